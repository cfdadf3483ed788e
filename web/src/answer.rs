//! An answer as a row of numbers, which the page shows, stores and writes. Absent values are NaN.

use picket_dsp::acquire::sample::Stamp;
use picket_dsp::pipeline::{Measurement, Outcome};
use picket_wire::view::Tone;

macro_rules! answer {
    ($($(#[$doc:meta])* $name:ident),* $(,)?) => {
        /// A row.
        #[derive(Clone, Copy, Debug)]
        pub struct Answer {
            $($(#[$doc])* pub $name: f64,)*
            /// What every program shows of a tone as it is.
            pub further: [f64; Tone::FURTHER],
        }

        impl Answer {
            /// The names of the numbers, in their order.
            pub fn names() -> Vec<&'static str> {
                let mut names = vec![$(stringify!($name)),*];
                Tone::default().further(&mut |name, _| names.push(name));
                names
            }

            /// Nothing known.
            pub const NONE: Answer = Answer { $($name: f64::NAN,)* further: [f64::NAN; Tone::FURTHER] };

            /// Appends the numbers.
            pub fn put(&self, into: &mut Vec<f64>) {
                into.extend([$(self.$name),*]);
                into.extend(self.further);
            }
        }
    };
}

answer! {
    /// The block's number.
    block,
    /// Samples before the block.
    clock,
    /// The time of its middle; a board's at its first sample.
    time_s,
    /// 0 none, 1 up, 2 flat, 3 down.
    segment,
    /// 1 where samples were lost just before it.
    gap,
    /// Cycles per block, 0..N for I/Q.
    bins,
    /// The frequency.
    frequency_hz,
    /// One standard deviation of it.
    sigma_hz,
    /// The same in bins.
    sigma_bins,
    /// Signal-to-noise ratio per sample.
    snr_db,
    /// The amplitude in codes.
    amplitude_codes,
    /// Samples that touch a rail.
    clipped,
    /// The verdict's number.
    verdict,
    /// What applies besides, a bit each, see [`picket_dsp::Verdicts::bits`].
    also,
    /// The range.
    range_m,
    /// One standard deviation of it.
    sigma_range_m,
    /// The velocity.
    velocity_mps,
    /// One standard deviation of it.
    sigma_velocity_mps,
    /// The verdict of range and velocity.
    outcome_verdict,
    /// 0 none, 1 several targets fit, 2 coupled; decided by 3 a bound, 4 the last chirp, 5 the levels.
    ambiguity,
    /// What a simulated tone's frequency is.
    truth_hz,
    /// What a simulated target's range is.
    truth_m,
    /// What a simulated target's velocity is.
    truth_mps,
    /// Blocks lost by the board.
    lost,
    /// Faults of its converters' chain.
    faults,
    /// The frequency's whole error, where a board's settings tell what is not known of the sensor.
    uncertainty_hz,
    /// The range's.
    uncertainty_range_m,
    /// The velocity's.
    uncertainty_velocity_mps,
    /// The displacement since a start, where it is followed.
    displacement_m,
    /// One standard deviation of it.
    sigma_displacement_m,
    /// The start's number.
    displacement_start,
    /// The displacement's verdict.
    displacement_verdict,
}

impl Answer {
    /// The answer of a block of `n` samples.
    pub fn of(measurement: &Measurement, n: usize, iq: bool, rate_hz: f64) -> Self {
        let Measurement { stamp, clipped, tone, result } = measurement;
        let &Stamp { sequence, clock, segment, gap } = stamp;
        // As `picket analyze` has it, to the bit: hertz from bins, and those of I/Q from 0 to N.
        let bins = tone.frequency.bins(n);
        let bins = if iq { bins.rem_euclid(n as f64) } else { bins };
        let signed = if iq && bins >= n as f64 / 2.0 { bins - n as f64 } else { bins };
        let hertz = |bins: f64| bins * rate_hz / n as f64;
        let sigma_bins = f64::from(tone.sigma) * n as f64;
        let mut row = Answer {
            block: sequence.into(),
            clock: clock as f64,
            time_s: (clock as f64 + n as f64 / 2.0) / rate_hz,
            segment: f64::from(segment as u8),
            gap: gap.into(),
            bins,
            frequency_hz: hertz(signed),
            sigma_hz: hertz(sigma_bins),
            sigma_bins,
            snr_db: tone.snr_db().into(),
            amplitude_codes: tone.amplitude.into(),
            clipped: (*clipped).into(),
            verdict: f64::from(tone.verdict as u8),
            also: f64::from(tone.also.bits()),
            ..Answer::NONE
        };
        let mut places = row.further.iter_mut();
        Tone::from_tone(tone, *clipped).further(&mut |_, value| {
            places.next().into_iter().for_each(|place| *place = value);
        });
        match result {
            Outcome::None => {}
            Outcome::Velocity(v) => {
                row.velocity_mps = v.velocity.to_num();
                row.sigma_velocity_mps = v.sigma.into();
                row.outcome_verdict = f64::from(v.verdict as u8);
            }
            Outcome::Target(t) => {
                (row.range_m, row.sigma_range_m) = (t.range.to_num(), t.sigma_range.into());
                row.velocity_mps = t.velocity.map_or(f64::NAN, |velocity| velocity.to_num());
                row.sigma_velocity_mps = t.sigma_velocity.into();
                row.outcome_verdict = f64::from(t.verdict as u8);
                row.ambiguity = f64::from(t.ambiguity.number());
            }
        }
        row
    }
}
