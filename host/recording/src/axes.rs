//! What the sides of an array count: frames, chirps, receivers, samples; and the records of one receiver out of it.

use super::source::Source;
use super::{Options, RecordingError, Sample};
use std::fmt;
use std::path::Path;
use std::str::FromStr;

/// What a side of an array counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// Frames of chirps.
    Frame,
    /// Chirps, or other records of their own.
    Chirp,
    /// Receivers.
    Receiver,
    /// Samples of a record.
    Sample,
    /// The two parts of I/Q samples.
    Iq,
}

/// The sides of an array, in its order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Axes {
    axes: [Axis; Axes::MOST],
    count: usize,
}

/// From this length of the shorter side on, two sides are records and their samples, not channels.
const RECORDS: u64 = 9;
/// The most receivers, where no name states what a side counts.
const RECEIVERS: u64 = 16;

impl Axis {
    const ALL: [(Axis, &'static str); 5] = [
        (Axis::Frame, "frame"),
        (Axis::Chirp, "chirp"),
        (Axis::Receiver, "rx"),
        (Axis::Sample, "sample"),
        (Axis::Iq, "iq"),
    ];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|it| it.0 == self).map_or("", |it| it.1)
    }
}

impl Axes {
    const MOST: usize = 6;

    fn of(axes: &[Axis]) -> Option<Self> {
        let mut all = [Axis::Sample; Self::MOST];
        all.get_mut(..axes.len())?.copy_from_slice(axes);
        Some(Self { axes: all, count: axes.len() })
    }

    /// What each side counts.
    pub fn each(&self) -> &[Axis] {
        &self.axes[..self.count]
    }

    /// The same sides with chirps and samples exchanged, as in the transposed array.
    pub fn exchanged(&self) -> Self {
        let mut other = *self;
        for axis in &mut other.axes[..self.count] {
            *axis = match *axis {
                Axis::Chirp => Axis::Sample,
                Axis::Sample => Axis::Chirp,
                axis => axis,
            };
        }
        other
    }

    /// What these sides may count: the one that runs fastest the samples.
    fn proposed(sides: &[u64], rows_first: bool, complex: bool) -> Option<Self> {
        let mut sides: Vec<u64> = sides.to_vec();
        if !rows_first {
            sides.reverse();
        }
        let pairs = !complex && sides.len() > 2 && sides.last() == Some(&2);
        sides.truncate(sides.len() - usize::from(pairs));
        let single = sides.iter().take_while(|side| **side == 1).count();
        let left = &sides[single.min(sides.len().saturating_sub(1))..];
        let mut axes = vec![Axis::Frame; sides.len() - left.len()];
        axes.extend(match *left {
            [_] => vec![Axis::Sample],
            [_, _] => vec![Axis::Chirp, Axis::Sample],
            [_, rx, _] if rx <= RECEIVERS => vec![Axis::Chirp, Axis::Receiver, Axis::Sample],
            [_, _, _] => vec![Axis::Frame, Axis::Chirp, Axis::Sample],
            [_, _, rx, _] if rx <= RECEIVERS => {
                vec![Axis::Frame, Axis::Chirp, Axis::Receiver, Axis::Sample]
            }
            _ => return None,
        });
        axes.extend(pairs.then_some(Axis::Iq));
        if !rows_first {
            axes.reverse();
        }
        Self::of(&axes)
    }
}

impl fmt::Display for Axes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<&str> = self.each().iter().map(|axis| axis.name()).collect();
        f.write_str(&names.join(","))
    }
}

impl FromStr for Axes {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let axis = |name: &str| Axis::ALL.iter().find(|it| it.1 == name.trim()).map(|it| it.0);
        let axes: Option<Vec<Axis>> = text.split(',').map(axis).collect();
        let wrong = || "name each side: frame, chirp, rx, sample, iq, as in frame,chirp,rx,sample";
        let axes = axes.filter(|axes| axes.len() <= Self::MOST).ok_or_else(wrong)?;
        let samples = axes.iter().filter(|axis| **axis == Axis::Sample).count();
        let pairs = axes.iter().filter(|axis| **axis == Axis::Iq).count();
        if samples != 1 || pairs > 1 {
            return Err("one side counts the samples, and at most one I and Q".into());
        }
        Self::of(&axes).ok_or_else(|| wrong().into())
    }
}

/// The records of an array, and how they are taken out of it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Cube {
    pub axes: Axes,
    /// Samples of a record.
    pub samples: u64,
    /// Records of all receivers.
    records: u64,
    pub complex: bool,
    chirps: Option<u64>,
    /// Sides and steps between their neighbours, in numbers, of the records in their order: the receivers last.
    order: Vec<(u64, u64)>,
    receivers: u64,
    picked: u64,
    step: u64,
    part: u64,
    /// What was assumed.
    pub note: String,
}

impl Cube {
    /// The records of an array of these sides; `None` where it is no more than channels. A complex number counts as two.
    pub fn of(
        path: &Path,
        sides: &[u64],
        rows_first: bool,
        complex: bool,
        options: &Options,
    ) -> Result<Option<Self>, RecordingError> {
        let wrong = |what: String| RecordingError::Columns(path.into(), what);
        let shape = sides.iter().map(u64::to_string).collect::<Vec<_>>().join(", ");
        let channels = match *sides {
            [a, b] => a.min(b) < RECORDS,
            _ => sides.len() < 2,
        };
        let axes = match options.axes {
            Some(axes) if axes.count != sides.len() => {
                return Err(wrong(format!("its shape is ({shape}): --axes has {} names for it", axes.count)));
            }
            Some(axes) => axes,
            None if channels => return Ok(None),
            None => Axes::proposed(sides, rows_first, complex).ok_or_else(|| {
                wrong(format!("its shape is ({shape}): say what each side counts, as --axes frame,chirp,rx,sample"))
            })?,
        };
        let parts = if complex { 2u64 } else { 1 };
        let mut steps = vec![parts; sides.len()];
        let mut all = parts;
        for place in 0..sides.len() {
            let at = if rows_first { sides.len() - 1 - place } else { place };
            steps[at] = all;
            all = all
                .checked_mul(sides[at])
                .ok_or_else(|| wrong(format!("its shape is ({shape})")))?;
        }
        if all == 0 {
            return Err(RecordingError::Empty(path.into()));
        }
        let of = |wanted: Axis| {
            let each = axes.each().iter().zip(sides.iter().zip(&steps));
            each.filter(move |it| *it.0 == wanted).map(|(_, (side, step))| (*side, *step))
        };
        let (samples, step) =
            of(Axis::Sample).next().ok_or_else(|| wrong("no side counts samples".into()))?;
        let receivers: u64 = of(Axis::Receiver).map(|it| it.0).product();
        let picked = match options.channel {
            None => 1,
            Some((channel, None)) if (1..=receivers).contains(&(channel as u64)) => channel as u64,
            Some((_, Some(_))) => return Err(wrong("--channel takes one receiver".into())),
            Some((channel, None)) => {
                return Err(RecordingError::Channel(path.into(), channel, receivers as usize));
            }
        };
        let pairs = of(Axis::Iq).next();
        if pairs.is_some_and(|pairs| pairs.0 != 2) {
            return Err(wrong(format!("its shape is ({shape}): the side of I and Q has 2")));
        }
        let order: Vec<(u64, u64)> =
            of(Axis::Frame).chain(of(Axis::Chirp)).chain(of(Axis::Receiver)).collect();
        let mut note = format!(
            "the shape ({shape}) is taken as {axes}: a record is {samples} samples in time (--axes says otherwise)"
        );
        if options.axes.is_some() {
            note = format!("the shape ({shape}) is {axes}");
        }
        if receivers > 1 && options.channel.is_none() {
            note += &format!("; receiver 1 of {receivers} is read, --channel chooses");
        }
        Ok(Some(Self {
            axes,
            samples,
            records: order.iter().map(|it| it.0).product::<u64>() / receivers,
            complex: complex || pairs.is_some(),
            chirps: of(Axis::Chirp).map(|it| it.0).reduce(|all, side| all.saturating_mul(side)),
            order,
            receivers,
            picked: picked - 1,
            step,
            part: pairs.map_or(1, |pairs| pairs.1),
            note,
        }))
    }

    /// Samples of all records.
    pub fn length(&self) -> u64 {
        self.records.saturating_mul(self.samples)
    }

    /// Records of a frame, where a side counts chirps.
    pub fn frame(&self) -> Option<u64> {
        self.chirps
    }

    /// How the records lie behind each other in the file: in all of the others' places only other receivers'.
    pub fn is_in_order(&self) -> bool {
        let width = if self.complex { 2 } else { 1 };
        let mut expected = width;
        let samples = [(self.samples, self.step)];
        let inner_first = self.order.iter().chain(&samples).rev();
        self.part == 1
            && inner_first.filter(|it| it.0 > 1).all(|&(side, step)| {
                let fits = step == expected;
                expected *= side;
                fits
            })
    }

    /// The samples of the records out of all numbers of the array.
    pub fn samples(&self, numbers: &[f64]) -> Vec<Sample> {
        let number = |at: u64| numbers.get(at as usize).copied().unwrap_or(f64::NAN);
        let mut samples = Vec::new();
        for record in 0..self.records {
            let mut rest = record * self.receivers + self.picked;
            let mut start = 0;
            for &(side, step) in self.order.iter().rev() {
                start += rest % side * step;
                rest /= side;
            }
            for sample in 0..self.samples {
                let at = start + sample * self.step;
                samples.push(Sample::of(number(at), self.complex.then(|| number(at + self.part))));
            }
        }
        samples
    }

    /// The records of the receiver out of those of all of them, where these are in order.
    pub fn chosen(&self, all: Box<dyn Source>) -> Box<dyn Source> {
        match self.receivers {
            1 => all,
            of => Box::new(Chosen { all, record: self.samples, of, picked: self.picked, at: 0 }),
        }
    }
}

/// One record of several in turn.
struct Chosen {
    all: Box<dyn Source>,
    record: u64,
    of: u64,
    picked: u64,
    at: u64,
}

impl Source for Chosen {
    fn read(&mut self, into: &mut Vec<Sample>, count: usize) -> Result<(), RecordingError> {
        let wanted = into.len() + count;
        let mut some = Vec::new();
        while into.len() < wanted {
            some.clear();
            // What is left of this record.
            let left = (self.record - self.at % self.record).min(4096);
            let own = self.at / self.record % self.of == self.picked;
            let ask = if own { left.min((wanted - into.len()) as u64) } else { left };
            self.all.read(&mut some, ask as usize)?;
            self.at += some.len() as u64;
            if own {
                into.extend_from_slice(&some);
            }
            if (some.len() as u64) < ask {
                break;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(sides: &[u64], rows_first: bool, complex: bool, axes: Option<&str>, rx: usize) -> Cube {
        let options = Options {
            axes: axes.map(|axes| axes.parse().unwrap()),
            channel: (rx > 0).then_some((rx, None)),
            ..Options::default()
        };
        Cube::of(Path::new("x"), sides, rows_first, complex, &options).unwrap().unwrap()
    }

    #[test]
    fn sides_are_proposed() {
        for (sides, rows_first, complex, axes) in [
            (&[64, 256][..], true, true, "chirp,sample"),
            (&[256, 64], false, true, "sample,chirp"),
            (&[64, 4, 256], true, true, "chirp,rx,sample"),
            (&[10, 64, 256], true, true, "frame,chirp,sample"),
            (&[10, 64, 4, 256], true, true, "frame,chirp,rx,sample"),
            (&[10, 64, 4, 256, 2], true, false, "frame,chirp,rx,sample,iq"),
            (&[1, 1, 64, 256], true, false, "frame,frame,chirp,sample"),
        ] {
            assert_eq!(of(sides, rows_first, complex, None, 0).axes.to_string(), axes, "{sides:?}");
        }
        assert!("frame,chirp".parse::<Axes>().is_err() && "x".parse::<Axes>().is_err());
    }

    #[test]
    fn records_come_in_order() {
        // Two frames of three chirps at two receivers of four samples.
        let numbers: Vec<f64> = (0..48).map(f64::from).collect();
        let cube = of(&[2, 3, 2, 4], true, false, None, 2);
        let values: Vec<f64> = cube.samples(&numbers).iter().map(|it| it.value.re).collect();
        assert_eq!((values.len(), &values[..5]), (24, &[4.0, 5.0, 6.0, 7.0, 12.0][..]));
        assert!(cube.is_in_order());
        let all = super::super::source::Held {
            samples: numbers.iter().map(|x| Sample::of(*x, None)).collect::<Vec<_>>().into_iter(),
        };
        let (mut chosen, mut streamed) = (cube.chosen(Box::new(all)), Vec::new());
        while {
            let before = streamed.len();
            chosen.read(&mut streamed, 5).unwrap();
            streamed.len() > before
        } {}
        assert_eq!(streamed.iter().map(|it| it.value.re).collect::<Vec<_>>(), values);
        // The same array, told to be samples first.
        let turned = of(&[4, 6], true, false, Some("sample,chirp"), 0);
        let values: Vec<f64> = turned.samples(&numbers).iter().map(|it| it.value.re).collect();
        assert!(values[..4] == [0.0, 6.0, 12.0, 18.0] && !turned.is_in_order());
        let pairs = of(&[3, 4, 2], true, false, Some("chirp,sample,iq"), 0);
        assert!(pairs.complex && pairs.is_in_order());
        assert_eq!(pairs.samples(&numbers)[1], Sample::of(2.0, Some(3.0)));
    }
}
