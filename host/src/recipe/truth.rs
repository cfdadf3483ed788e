//! What is true of a scene, beside its recording.

use picket_simulator::scene::{Shape, Source};
use picket_simulator::{Passed, Run, Scene};

/// Stretches of a scene that takes samples all the time.
const STRETCHES: usize = 100;

/// What is true of a source at a time. Levels are those behind the receiver's filters.
struct Row {
    /// The sample of the file, where the truth is that of a stretch.
    sample: Option<f64>,
    time_s: f64,
    /// As the receiver shows it: of real records without a sign.
    frequency_hz: f64,
    amplitude: f64,
    range_m: Option<f64>,
    velocity_mps: Option<f64>,
}

/// A source and its rows.
struct Known {
    kind: &'static str,
    /// Particles have no course: a row each.
    particles: bool,
    rows: Vec<Row>,
}

/// What is true of a scene.
pub struct Told {
    sources: Vec<Known>,
    noise: f64,
}

/// Where the truth of a scene is asked: the first sample in the scene's time and in the file, and the count of samples.
fn stretches(scene: &Scene) -> Vec<(f64, f64, usize)> {
    let waveform = scene.waveform.as_ref().filter(|of| of.shape != Shape::Continuous);
    let Some(waveform) = waveform else {
        let total = (scene.seconds * scene.rate_hz).round() as usize;
        let n = (total / STRETCHES).max(2).min(total);
        let starts = (0..total / n).map(|index| (index * n) as f64);
        return starts.map(|at| (at / scene.rate_hz, at, n)).collect();
    };
    // Records of the segments; without a guard the segments except for their ends, where echoes are still those of the segment before.
    let (mut gated, mut n) = (scene.clone(), waveform.samples);
    let all = waveform.guard_s.is_none();
    if let Some(of) = gated.waveform.as_mut().filter(|_| all) {
        let shortest = match of.shape {
            Shape::Sequence => {
                of.segments.iter().map(|segment| segment.seconds).fold(f64::INFINITY, f64::min)
            }
            _ => of.ramp_s,
        };
        n = (0.9 * shortest * scene.rate_hz).max(1.0) as usize;
        (of.guard_s, of.samples) = (Some(0.05 * shortest), n);
    }
    let record = |index: usize| {
        let start_s = gated.start_s(index, n);
        (start_s, if all { start_s * scene.rate_hz } else { (index * n) as f64 }, n)
    };
    (0..gated.records(n)).map(record).collect()
}

impl Told {
    /// What is true of the first trial of a scene.
    ///
    /// # Errors
    /// The scene cannot be, or a target of a stated range reaches the sensor.
    pub fn new(scene: &Scene) -> Result<Self, String> {
        let run = scene.run(0)?;
        let stretches = stretches(scene);
        let known = |(number, source): (usize, &Source)| {
            let (kind, falls) = match source {
                Source::Tone(_) => ("tone", false),
                Source::Target(of) => ("target", of.amplitude_at_m.is_some()),
                Source::Blades(_) => ("blades", false),
                Source::Walker(of) => ("walker", of.amplitude_at_m.is_some()),
                Source::Particles(of) => {
                    let hertz = |mps: f64| mps / of.fringe_m + of.shift_hz;
                    let inside = |of: &&Passed| (0.0..scene.seconds).contains(&of.middle_s);
                    let passed = run.particles(number).iter().filter(inside);
                    let rows = passed.map(|of| particle(scene, &run, of, hertz(of.velocity_mps)));
                    return Ok(Known { kind: "particles", particles: true, rows: rows.collect() });
                }
            };
            let row = |&(start_s, sample, n): &(f64, f64, usize)| {
                let truth = run.truth(number, start_s, n);
                if falls && truth.range_m.is_some_and(|range_m| range_m <= 0.0) {
                    let time_s = truth.time_s;
                    return Err(format!(
                        "sources[{number}]: it reaches the sensor before {time_s:.3} s: give more range, less velocity or less time"
                    ));
                }
                Ok(Row {
                    sample: Some(sample + 0.5 * (n - 1) as f64),
                    time_s: truth.time_s,
                    frequency_hz: shown(scene, truth.frequency_hz),
                    amplitude: truth.amplitude * run.gain(truth.frequency_hz),
                    range_m: truth.range_m,
                    velocity_mps: truth.velocity_mps,
                })
            };
            let rows = stretches.iter().map(row).collect::<Result<_, _>>()?;
            Ok(Known { kind, particles: false, rows })
        };
        let sources = scene.sources.iter().enumerate().map(known).collect::<Result<_, String>>()?;
        Ok(Told { sources, noise: run.passed_noise() })
    }

    /// A line for each source: from its start to its end; of particles from the least to the most.
    pub fn lines(&self) -> Vec<String> {
        self.sources.iter().map(|known| self.line(known)).collect()
    }

    fn line(&self, known: &Known) -> String {
        let (Some(first), Some(last)) = (known.rows.first(), known.rows.last()) else {
            return format!("{}: none", known.kind);
        };
        let span = |of: &dyn Fn(&Row) -> Option<f64>| {
            if !known.particles {
                return of(first).zip(of(last));
            }
            let all = || known.rows.iter().filter_map(of);
            known.rows.first().and_then(of)?;
            Some((all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max)))
        };
        let mut line = match known.particles {
            true => format!("{} particles", known.rows.len()),
            false => known.kind.to_owned(),
        };
        let mut add = |before: &str, ends: Option<(f64, f64)>, decimals: usize, unit: &str| {
            let Some((from, to)) = ends else { return };
            // Zero has no sign.
            let [from, to] = [from, to].map(|end| format!("{:.decimals$}", end + 0.0));
            let both = if from == to { from } else { format!("{from} to {to}") };
            line += &format!("{before}{both} {unit}");
        };
        add(": ", span(&|row| Some(row.frequency_hz)), 1, "Hz");
        add(", ", span(&|row| row.range_m), 3, "m");
        add(", ", span(&|row| row.velocity_mps), 4, "m/s");
        let amplitude = span(&|row| Some(row.amplitude));
        add(", amplitude ", amplitude, 0, "codes");
        add(", noise ", Some((self.noise, self.noise)), 1, "codes");
        let decibels =
            |amplitude: f64| 20.0 * (amplitude / (2f64.sqrt() * self.noise)).max(1e-15).log10();
        if self.noise > 0.0 {
            add(", ", amplitude.map(|(from, to)| (decibels(from), decibels(to))), 1, "dB");
        }
        line
    }

    /// A row for each stretch or particle of each source.
    pub fn csv(&self) -> String {
        let head = "source,kind,sample,time_s,frequency_hz,amplitude,range_m,velocity_mps\n";
        let mut text = String::from(head);
        for (number, known) in self.sources.iter().enumerate() {
            for row in &known.rows {
                let cell = |x: Option<f64>, decimals: usize| {
                    x.map(|x| format!("{:.decimals$}", x + 0.0)).unwrap_or_default()
                };
                let cells = [
                    cell(row.sample, 1),
                    cell(Some(row.time_s), 9),
                    cell(Some(row.frequency_hz), 4),
                    cell(Some(row.amplitude), 3),
                    cell(row.range_m, 6),
                    cell(row.velocity_mps, 9),
                ];
                text += &format!("{number},{},{}\n", known.kind, cells.join(","));
            }
        }
        text
    }
}

/// A particle in the middle of the beams.
fn particle(scene: &Scene, run: &Run, of: &Passed, frequency_hz: f64) -> Row {
    let gated = scene.waveform.as_ref().is_some_and(|waveform| waveform.guard_s.is_some());
    Row {
        sample: (!gated).then_some(of.middle_s * scene.rate_hz),
        time_s: of.middle_s,
        frequency_hz: shown(scene, frequency_hz),
        amplitude: of.amplitude * run.gain(frequency_hz),
        range_m: None,
        velocity_mps: Some(of.velocity_mps),
    }
}

/// A frequency as the receiver shows it.
const fn shown(scene: &Scene, frequency_hz: f64) -> f64 {
    if scene.receiver.iq { frequency_hz } else { frequency_hz.abs() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(json: &str) -> Told {
        Told::new(&Scene::from_json(json).unwrap()).unwrap()
    }

    #[test]
    fn a_line_is_from_start_to_end() {
        let told = told(
            r#"{"rate_hz": 1000, "seconds": 10, "receiver": {"noise": {"rms": 1}},
                "sources": [{"tone": {"frequency_hz": -100, "amplitude": 20}},
                            {"tone": {"frequency_hz": [[0, 50], [10, 150]], "level_db": -20}}]}"#,
        );
        assert_eq!(
            told.lines(),
            [
                "tone: 100.0 Hz, amplitude 20 codes, noise 1.0 codes, 23.0 dB",
                "tone: 50.5 to 149.5 Hz, amplitude 2 codes, noise 1.0 codes, 3.0 dB",
            ]
        );
        let csv = told.csv();
        assert_eq!(csv.lines().count(), 1 + 2 * STRETCHES);
        assert!(csv.contains("\n0,tone,49.5,0.049500000,100.0000,20.000,,\n"), "{csv}");
    }

    /// A ramp each, although samples are taken all the time; and records, whose samples are counted in the file.
    #[test]
    fn ramps_and_records_have_a_row_each() {
        let json = |more: &str| {
            let waveform = r#""shape": "triangle", "bandwidth_hz": 1e8, "ramp_s": 1e-3"#;
            format!(
                r#"{{"rate_hz": 1e6, "seconds": 0.01, "waveform": {{{waveform}{more}}}, "receiver": {{"iq": true}},
                    "sources": [{{"target": {{"range_m": 30, "amplitude": 100}}}}]}}"#
            )
        };
        let [ramps, records] = ["", r#", "guard_s": 1e-4, "samples": 512"#].map(|more| {
            let csv = told(&json(more)).csv();
            csv.lines().skip(1).map(str::to_owned).collect::<Vec<_>>()
        });
        let cell = |line: &str, index: usize| line.split(',').nth(index).unwrap().parse::<f64>();
        assert_eq!((ramps.len(), records.len()), (10, 10));
        assert_eq!((cell(&ramps[1], 2), cell(&records[1], 2)), (Ok(1499.5), Ok(767.5)));
        let beat_hz = 1e8 / 1e-3 * 60.0 / 299_792_458.0;
        for rows in [ramps, records] {
            for (index, row) in rows.iter().enumerate() {
                let wanted = if index % 2 == 0 { beat_hz } else { -beat_hz };
                assert!((cell(row, 4).unwrap() - wanted).abs() < 10.0, "{row}");
            }
        }
    }
}
