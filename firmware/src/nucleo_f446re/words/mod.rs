//! What the NUCLEO's registers hold that its settings decide, computed by pure functions: the clock's frequencies, periods, waveforms and
//! loads. The modules one level up write them, by the names that ST's description of the registers has, in the crate `stm32f4`.
//!
//! Sections named RM are in ST's reference manual RM0390 (STM32F446xx), DS in the data sheet DS10693.

pub mod clock;
pub mod gauge;
pub mod guard;
pub mod passage;
pub mod pulses;
pub mod sampling;
pub mod serial;
pub mod waveform;

use super::{SLOTS, USUAL_SLOTS};
use crate::instrument::adf4159::{self, Ramps};
use crate::instrument::plan::{Load, Plan};
use clock::{Speed, Tree};
use picket_dsp::config::{Config, Scene};
use picket_dsp::solve::equations::Chirp;
use picket_dsp::tone::arithmetic::Arithmetic;
use picket_wire::settings::{Drive, Mode, Settings};
use picket_wire::settings_error::{RateError, SettingsError};
use sampling::{BLOCK_CYCLES, Sampling, WORST_CYCLES};
use waveform::{Waveform, gate_ticks};

/// What an instrument's settings decide.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Words {
    /// The sample clock and the converters.
    pub sampling: Sampling,
    /// The waveform of the DAC; `None` if the DAC does not play.
    pub waveform: Option<Waveform>,
    /// The words for the synthesiser; `None` without it.
    pub synthesiser: Option<adf4159::Words>,
    /// Ticks of the timers from a block to the next; `None` where an external source sets the pace.
    pub block_ticks: Option<u64>,
}

/// Core cycles in which a fundamental is sought among eight lines, also of a slow square, as in [`ADD_CYCLES`].
pub const HARMONICS_CYCLES: u64 = 2_300_000;

/// The most core cycles for the further tones of a block and its fundamental, by 1.4 cycles an instruction, modelled and not measured: a
/// search, and the cost of each tone.
const fn lines_cycles(settings: &Settings) -> u64 {
    let tones = match settings.further() {
        0 => 0,
        further => 84_000 + 45_000 * further as u64,
    };
    tones + if settings.order() > 0 { HARMONICS_CYCLES } else { 0 }
}

/// Core cycles for the sum of a real and of an I/Q block, by 1.4 cycles an instruction: host-tests compare the counted instructions with
/// them (`nucleo::signals`).
pub const ADD_CYCLES: [u64; 2] = [90_000, 180_000];
/// Core cycles for the line of a sum, real and I/Q, as in [`ADD_CYCLES`].
pub const SUM_CYCLES: [u64; 2] = [800_000, 1_450_000];
/// Core cycles for the range of a sawtooth's target. It is less than the range and the velocity of a trapezoid, which take 1,862
/// instructions by 1.64 cycles each.
const TARGET_CYCLES: u64 = 3_100;
/// Core cycles in which a burst is sought in a block, real and I/Q.
pub const SEEK_CYCLES: [u64; 2] = [40_000, 60_000];
/// Core cycles in which a burst is measured, real and I/Q.
pub const BURST_CYCLES: [u64; 2] = [1_300_000, 1_800_000];

/// Core cycles in which a chirp of a frame is transformed and its bins are kept, real and I/Q, as in [`ADD_CYCLES`], and 27,000 for the waits of
/// the flash.
pub const CHIRP_CYCLES: [u64; 2] = [84_000, 128_000];

/// The fewest core cycles that a block may last, whatever its samples are. While a sum's last block or a burst takes longer, the blocks
/// wait in slots that the stream does not fill.
fn least_cycles(settings: &Settings, slots: u16) -> u64 {
    let of = |[real, iq]: [u64; 2]| if settings.iq { iq } else { real };
    let wait = u64::from(slots.saturating_sub(2).max(1));
    match settings.mode {
        Mode::Blocks => of(BLOCK_CYCLES) + lines_cycles(settings),
        Mode::Accumulate { blocks, .. } => {
            let wait = wait.min(blocks.max(1).into());
            of(BLOCK_CYCLES) + of(ADD_CYCLES) + of(SUM_CYCLES).div_ceil(wait)
        }
        Mode::Frames { .. } => of(CHIRP_CYCLES),
        // On average at most one burst in this number of blocks.
        Mode::Bursts(_) => of(SEEK_CYCLES) + of(BURST_CYCLES).div_ceil(wait),
    }
}

impl Words {
    /// Checks settings for blocks of `N` samples with this clock, and computes their words.
    ///
    /// # Errors
    /// The settings cannot work on this board.
    #[inline(never)] // once in an image, not in each place that plans
    pub fn plan<const N: usize>(
        settings: &Settings,
        tree: &Tree,
    ) -> Result<(Plan<N>, Self), SettingsError> {
        let speed = Speed::from_mhz(settings.core_mhz).ok_or(SettingsError::Speed)?;
        let rate_hz = settings.calibration.nominal_hz(settings.config.rate_hz);
        let sampling = Sampling::plan(tree, rate_hz, settings.iq);
        let sampling = sampling.map_err(SettingsError::Rate)?;
        let slots = if settings.slots == 0 { USUAL_SLOTS } else { settings.slots };
        if !(USUAL_SLOTS..=SLOTS as u16).contains(&slots) {
            return Err(SettingsError::Slots);
        }
        let samples = N as u32 + u32::from(settings.guard);
        let ticks = u64::from(samples) * u64::from(sampling.period.ticks());
        let cycles = ticks.saturating_mul((tree.core_hz / tree.timer_hz.max(1)).into());
        let usual = least_cycles(settings, slots);
        let [real, iq] = WORST_CYCLES;
        let worst = Some(if settings.iq { iq } else { real });
        let load = Load { block: cycles, usual, worst, target: TARGET_CYCLES };
        // The slow clock is a way out of a failure: no rate is refused.
        let worst_case = settings.worst_case && tree.pll.is_some();
        let effort = load.effort(&Settings { worst_case, ..*settings })?;
        // The image has the arithmetic of its core alone.
        let config = Config { arithmetic: Arithmetic::Float, effort, ..settings.config };
        let settings = Settings { core_mhz: speed.mhz(), slots, config, ..*settings };
        let plan = Plan::new(&settings, sampling.rate_hz)?;
        // A tracker rarely searches a whole block.
        let searches = settings.config.following.most == 0 && tree.pll.is_some();
        if searches && settings.start && cycles < usual {
            return Err(SettingsError::Rate(RateError::Load));
        }
        let block_ticks = (settings.drive != Drive::External).then_some(ticks);
        let mut words = Words { sampling, waveform: None, synthesiser: None, block_ticks };
        if let Scene::Chirp(Chirp { shape, bandwidth_hz, duration_s, .. }) =
            plan.settings.config.scene
        {
            match settings.drive {
                Drive::Off => {}
                Drive::Dac { low, high } => {
                    let wave = Waveform::plan(shape, plan.length, sampling.rate_hz, [low, high]);
                    words.waveform = Some(wave.map_err(SettingsError::Waveform)?);
                }
                Drive::Adf4159 { reference_hz, start_hz, divider } => {
                    let divider = f64::from(divider.max(1));
                    let ramps = Ramps {
                        reference_hz,
                        start_hz: start_hz / divider,
                        bandwidth_hz: bandwidth_hz / divider,
                        duration_s,
                        shape,
                        triggered: true,
                    };
                    words.synthesiser = Some(ramps.words().map_err(SettingsError::Ramps)?);
                }
                Drive::External if sampling.continuous => return Err(SettingsError::Sync),
                // The gate counts a whole chirp.
                Drive::External
                    if gate_ticks(ticks.saturating_mul(plan.settings.segments().into()))
                        .is_none() =>
                {
                    return Err(SettingsError::Sync);
                }
                Drive::External => {}
            }
        }
        Ok((plan, words))
    }
}

#[cfg(test)]
mod tests {
    use super::clock::Source;
    use super::*;
    use picket_dsp::acquire::codes::Codes;
    use picket_dsp::config::{ConfigError, Following};
    use picket_dsp::solve::chirp::Shape;
    use picket_dsp::{Effort, Method};
    use picket_wire::settings::Calibration;
    use picket_wire::settings_error::{RampError, WaveformError};

    const TREE: Tree = Tree::new(Speed::Mhz180, Source::HsePll);

    fn plan(settings: &Settings) -> Result<(Plan<1024>, Words), SettingsError> {
        Words::plan(settings, &TREE)
    }

    fn chirp(shape: Shape, drive: Drive) -> Settings {
        let scene = Scene::Chirp(Chirp {
            shape,
            wavelength_m: 0.0125,
            bandwidth_hz: 200e6,
            duration_s: 1.0,
            ..Chirp::default()
        });
        let config = Config { rate_hz: 500e3, scene, ..Settings::default().config };
        Settings { config, guard: 64, drive, ..Settings::default() }
    }

    const DAC: Drive = Drive::Dac { low: 0, high: 4095 };
    const HEAD: Drive = Drive::Adf4159 { reference_hz: 80e6, start_hz: 24e9, divider: 2 };

    #[test]
    fn block_and_segment_are_one() {
        let (instrument, words) = plan(&chirp(Shape::Trapezoid, DAC)).unwrap();
        assert_eq!((instrument.length, instrument.timing.period), (1088, 1088));
        assert_eq!(instrument.timing.segments.len(), 3);
        let wave = words.waveform.unwrap();
        assert_eq!(u32::from(wave.hold) * u32::from(wave.steps), 1088);
        let Scene::Chirp(Chirp { duration_s, .. }) = instrument.settings.config.scene else {
            panic!("the scene is a chirp");
        };
        let samples = duration_s * instrument.settings.config.rate_hz;
        assert!((samples - 1088.0).abs() < 1e-9, "{samples}");
        assert_eq!(instrument.settings.config.codes, Codes::unsigned::<12>());
        let (_, head) = plan(&chirp(Shape::Triangle, HEAD)).unwrap();
        assert!(head.synthesiser.is_some() && head.waveform.is_none());
    }

    #[test]
    fn without_guard_a_ramp_is_a_record() {
        for (rate_hz, ppm) in [(1.5e6, 0.0), (333_333.0, 17.0), (48e3, -999.0), (7e4, 3.3)] {
            let mut settings = chirp(Shape::Trapezoid, DAC);
            settings.guard = 0;
            settings.config.rate_hz = rate_hz;
            settings.calibration.clock_ppm = ppm;
            plan(&settings).unwrap();
        }
    }

    /// Each time settings were set again, a correction of the clock once moved the rate a little further.
    #[test]
    fn settings_that_were_answered_stay_when_they_are_set_again() {
        for rate_hz in [500e3, 48e3, 100.0, 3.3, 1.0] {
            for clock_ppm in [0.0, 12.5, -999.0, 1e3] {
                let mut settings = Settings::default();
                settings.calibration.clock_ppm = clock_ppm;
                settings.config.rate_hz = settings.calibration.true_hz(rate_hz);
                let (first, _) = plan(&settings).unwrap();
                let (second, _) = plan(&first.settings).unwrap();
                assert_eq!(second, first, "{rate_hz} {clock_ppm}");
            }
        }
    }

    #[test]
    fn what_the_core_cannot_measure_is_refused() {
        let following = Following { most: 1, ..Following::default() };
        for (rate_hz, iq, most, fits) in [
            (1.5e6, false, 0, true),
            // 25 and 24 cycles of 36 MHz a sample.
            (1.44e6, false, 0, true),
            (1.51e6, false, 0, false),
            (1.6e6, false, 0, false),
            (2.4e6, false, 0, false),
            (2.4e6, false, 1, true),
            (1.5e6, true, 0, false),
            // 25 and 26 cycles of 22.5 MHz.
            (0.9e6, true, 0, false),
            (0.865e6, true, 0, true),
        ] {
            let core_mhz = if iq || rate_hz == 1.5e6 { 180 } else { 144 };
            let tree = Tree::new(Speed::from_mhz(core_mhz).unwrap(), Source::HsePll);
            let band_hz = iq.then_some((1e4, 4e5));
            let following = Following { most, ..following };
            let tone = Settings::default();
            let config = Config { rate_hz, band_hz, following, ..tone.config };
            let settings = Settings { core_mhz, iq, config, ..tone };
            let planned = Words::plan::<1024>(&settings, &tree).map(|_| ());
            let refused = Err(SettingsError::Rate(RateError::Load));
            assert_eq!(planned, if fits { Ok(()) } else { refused }, "{rate_hz} {iq} {most}");
        }
    }

    /// A rate for the worst block is the fastest at which that block does not take longer than it lasts.
    #[test]
    fn a_rate_that_does_not_hold_for_the_worst_block_is_refused() {
        let tree = Tree::new(Speed::Mhz180, Source::HsePll);
        let of = |rate_hz: f64, iq, effort| {
            let config = Config { rate_hz, ..Settings::default().config };
            let effort = Some(effort);
            Settings { iq, config, worst_case: true, effort, ..Settings::default() }
        };
        let refused = |settings: &Settings| plan(settings).map(|_| ()).unwrap_err();
        for (iq, worst) in [false, true].into_iter().zip(WORST_CYCLES) {
            for (&effort, cycles) in Effort::ALL.iter().zip(worst) {
                let holds = of(sampling::fastest(&tree, 1024, cycles), iq, effort);
                assert!(plan(&holds).is_ok(), "{iq} {effort:?}");
                // The next that the timer makes: one cycle of the converter less, or the one at which conversions follow each other.
                let apart = (f64::from(tree.adc_hz) / holds.config.rate_hz).round();
                let nearer = if apart > 18.0 { apart - 1.0 } else { 15.0 };
                let faster = of(f64::from(tree.adc_hz) / nearer, iq, effort);
                assert_eq!(refused(&faster), SettingsError::Rate(RateError::Worst));
                assert!(plan(&Settings { worst_case: false, ..faster }).is_ok());
            }
        }
        let settings = of(1e3, false, Effort::TWO);
        let with = |config: Config| Settings { config, ..settings };
        let following = Following { most: 1, ..Following::default() };
        let sums = Mode::Accumulate { blocks: 9, drift_bins: 0.0 };
        for unknown in [
            with(Config { following, ..settings.config }),
            with(Config { method: Method::ZRife, ..settings.config }),
            Settings { mode: sums, ..settings },
            Settings { worst_case: true, ..chirp(Shape::Triangle, Drive::External) },
        ] {
            assert_eq!(
                refused(&unknown),
                SettingsError::Rate(RateError::Unsearched),
                "{unknown:?}"
            );
        }
    }

    /// Unless settings say how many rounds, the board takes the most whose worst block lasts no longer than a block.
    #[test]
    fn the_board_takes_the_rounds_that_its_rate_allows() {
        let tree = Tree::new(Speed::Mhz180, Source::HsePll);
        let slow = Tree::new(Speed::Mhz180, Source::Hsi);
        let taken = |settings: &Settings, tree: &Tree| {
            let (plan, _) = Words::plan::<1024>(settings, tree).unwrap();
            assert_eq!(plan.settings.effort, settings.effort);
            plan.plan.options.effort.rounds()
        };
        let at = |rate_hz: f64| {
            let config = Config { rate_hz, ..Settings::default().config };
            Settings { config, ..Settings::default() }
        };
        for (iq, worst) in [false, true].into_iter().zip(WORST_CYCLES) {
            for (&effort, cycles) in Effort::ALL.iter().zip(worst) {
                let holds = Settings { iq, ..at(sampling::fastest(&tree, 1024, cycles)) };
                assert_eq!(taken(&holds, &tree), effort.rounds(), "{iq}");
                let faster = Settings { iq, ..at(1.05 * holds.config.rate_hz) };
                let fewer = effort.rounds().saturating_sub(1);
                assert_eq!(taken(&faster, &tree), fewer, "{iq}");
                let told = Settings { effort: Some(effort), ..faster };
                assert_eq!(taken(&told, &tree), effort.rounds(), "{iq}");
            }
        }
        assert_eq!(taken(&at(1e3), &tree), 3);
        assert_eq!(taken(&at(50e3), &slow), 0);
        // Each tone may take as many rounds.
        let several = Settings { most: 4, ..at(80e3) };
        assert!(taken(&several, &tree) < taken(&at(80e3), &tree));
        assert_eq!(taken(&Settings { most: 4, ..at(10e3) }, &tree), 3);
    }

    /// A longer chirp once ran without its gate. 3 segments of 1024 samples in 2^32 ticks of 90 MHz are 64.4 samples a second.
    #[test]
    fn a_chirp_of_a_source_is_no_longer_than_its_gate_counts() {
        for (rate_hz, fits) in [(500e3, true), (65.0, true), (64.0, false), (1.0, false)] {
            let mut settings = chirp(Shape::Trapezoid, Drive::External);
            (settings.guard, settings.config.rate_hz) = (0, rate_hz);
            match plan(&settings) {
                Ok((planned, words)) => {
                    let segments = u64::from(planned.settings.segments());
                    let ticks = 1024 * segments * u64::from(words.sampling.period.ticks());
                    assert!(fits && gate_ticks(ticks).is_some(), "{rate_hz}");
                }
                Err(error) => assert!(!fits && error == SettingsError::Sync, "{rate_hz}: {error}"),
            }
        }
    }

    #[test]
    fn every_contradiction_is_told_and_has_words() {
        use SettingsError as E;
        let tone = Settings::default();
        let with = |config: Config| Settings { config, ..tone };
        let calibrated = |calibration| Settings { calibration, ..tone };
        let ideal = Calibration::default();
        let prime = Settings { guard: 63, ..chirp(Shape::Trapezoid, DAC) };
        let mut quick = chirp(Shape::Trapezoid, Drive::External);
        quick.config.rate_hz = 1.5e6;
        for (settings, error) in [
            (Settings { guard: 1, ..tone }, E::Guard),
            (Settings { guard: 65, ..chirp(Shape::Triangle, DAC) }, E::Guard),
            (Settings { drive: DAC, ..tone }, E::Drive),
            (chirp(Shape::Triangle, Drive::Off), E::Drive),
            (with(Config { rate_hz: 2e6, ..tone.config }), E::Rate(RateError::Fast)),
            (with(Config { rate_hz: f64::NAN, ..tone.config }), E::Rate(RateError::Slow)),
            (with(Config { false_alarm: 0.0, ..tone.config }), E::Config(ConfigError::FalseAlarm)),
            (
                with(Config { band_hz: Some((3.0, 2.0)), ..tone.config }),
                E::Config(ConfigError::Band),
            ),
            (prime, E::Waveform(WaveformError::Steps)),
            (
                chirp(Shape::Triangle, Drive::Dac { low: 9, high: 9 }),
                E::Waveform(WaveformError::Codes),
            ),
            (
                chirp(
                    Shape::Triangle,
                    Drive::Adf4159 { reference_hz: 1.0, start_hz: 24e9, divider: 2 },
                ),
                E::Ramps(RampError::Reference),
            ),
            (quick, E::Sync),
            (Settings { core_mhz: 160, ..tone }, E::Speed),
            (Settings { slots: 3, ..tone }, E::Slots),
            (Settings { slots: SLOTS as u16 + 1, ..tone }, E::Slots),
            (calibrated(Calibration { clock_ppm: f32::NAN, ..ideal }), E::Calibration),
            (calibrated(Calibration { range_slope: 0.1, ..ideal }), E::Calibration),
            (calibrated(Calibration { range_offset_m: f32::INFINITY, ..ideal }), E::Calibration),
        ] {
            assert_eq!(plan(&settings).map(|_| ()), Err(error), "{settings:?}");
            let code = error.code();
            assert_ne!(SettingsError::message_of(code), SettingsError::message_of([0, 0]));
        }
    }
}
