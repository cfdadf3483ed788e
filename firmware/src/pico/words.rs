//! What the RP2040's registers hold that the settings decide, computed by pure functions.

use super::waveform::{Count, Waveform};
use super::{N, Pairs, SLOTS, USUAL_SLOTS};
use crate::instrument::plan::{Load, Plan};
use picket_dsp::config::{Config, ConfigError, Scene};
use picket_dsp::solve::equations::Chirp;
use picket_dsp::tone::arithmetic::Arithmetic;
use picket_dsp::tone::effort::Effort;
use picket_wire::boot::Causes;
use picket_wire::settings::{Drive, Settings};
use picket_wire::settings_error::{RateError, SettingsError};

/// The crystal of the board, Hz.
pub const CRYSTAL_HZ: u32 = 12_000_000;
/// The clock of the core and of the buses, MHz. The multiplier runs at 1440 MHz, divided by 5 and 2.
pub const CORE_MHZ: u16 = 144;
/// The converter's clock, Hz, from the second multiplier and the same crystal.
pub const ADC_HZ: u32 = 48_000_000;
/// Cycles of the converter's clock for a sample (DS 4.9.2).
pub const SAMPLE_CYCLES: u32 = 96;
/// Cycles of the core's clock in one of the converter's.
pub const CORE_CYCLES: u32 = CORE_MHZ as u32 * 1_000_000 / ADC_HZ;
/// The rate of the serial port, baud, equal to the other board's.
pub const BAUD: u32 = 921_600;

/// The channels that fill slots.
pub const CHAINED: [usize; 2] = [0, 1];
/// The channels that give the chained channels the address of their slots, and so start them (AL2_WRITE_ADDR_TRIG, DS 2.5.2.1). So a
/// chained channel always begins where its slot does: a channel that is started again before it has a new slot writes over its own slot,
/// and over nothing else.
pub const TURNED: [usize; 2] = [5, 6];
/// The channel that plays a chirp.
pub const PLAYED: usize = 3;
/// The channel that rewinds a chirp.
pub const REWOUND: usize = 4;
/// The channel that feeds the serial port.
pub const TRANSMIT: usize = 2;
/// The flags of the two chained channels.
pub const BOTH: u32 = 0b11;

/// The channels of the sync input, in the order in which each starts the next one, the last one the first. Each writes one word. A board
/// with a sync input plays no chirp of its own.
pub const LINKS: [usize; 7] = [3, 4, 7, 8, 9, 10, 11];
/// Words in the ring of the sixth of [`LINKS`].
pub const PLACES: usize = 16;

/// Cycles of the core from the converter's start to the gate's, and from the gate's end to the converter's.
const GATE_DELAY: u64 = 40;

/// The count at which slice 7 wraps in the middle of the last of `conversions`, `period` cycles of the converter's clock apart. `None` if
/// that is too long for the slice.
pub fn gate(conversions: u32, period: u32) -> Option<Count> {
    let halves = 2 * u64::from(conversions) - 1;
    let cycles =
        (halves * u64::from(period) * u64::from(CORE_CYCLES) / 2).checked_sub(GATE_DELAY)?;
    let divider = cycles.div_ceil(1 << 16);
    let top = cycles.checked_div(divider)?.checked_sub(1)?;
    (divider <= 255).then_some(Count { divider: (divider as u32) << 4, top: top as u32 })
}

/// Bits of the ring that feeds the serial port.
pub const OUT_BITS: u8 = 11;

/// ADC_CS (DS 4.9.6): EN 0, START_MANY 3. AINSEL 14:12 is input 0, GPIO 26, which is also the first of a round.
const SAMPLES: u32 = 1 | 1 << 3;
/// ADC_CS with RROBIN 20:16: inputs 0 and 1 in turn.
const PAIRS: u32 = SAMPLES | 0b11 << 16;

/// The watchdog's count for 4 s: it counts each microsecond twice (RP2040-E1).
pub const WATCHDOG_LOAD: u32 = 2 * 4_000_000;
/// PSM_WDSEL (DS 2.13.5): the watchdog resets everything but the two oscillators, bits 0 and 1.
pub const RESET_ALL: u32 = 0x1_FFFC;

/// Reset causes from WATCHDOG_REASON (DS 4.7.6: FORCE 1, TIMER 0), and if the watchdog did not reset the chip, from CHIP_RESET (DS 2.12.7:
/// HAD_PSM_RESTART 20, HAD_RUN 16, HAD_POR 8).
pub const fn causes(reason: u32, chip: u32) -> Causes {
    Causes(match reason & 3 {
        0 => (chip >> 8 & 1) as u8 | ((chip >> 16 & 1) as u8) << 1 | ((chip >> 20 & 1) as u8) << 4,
        reason => ((reason >> 1) as u8) << 2 | ((reason & 1) as u8) << 3,
    })
}

/// What an instrument's settings decide.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Words {
    /// Cycles of the converter's clock from a conversion to the next: 96 to 65536.
    pub period: u32,
    /// Samples from a block to the next: a block and its guard.
    pub length: u32,
    /// Whether a sample is an I/Q pair, of two conversions.
    pub iq: bool,
    /// Whether the converter's codes are corrected.
    pub corrects: bool,
    /// The chirp; `None` without a chirp of the board's own.
    pub waveform: Option<Waveform>,
    /// The opening time of the sync input's gate; `None` if the input is not used.
    pub gate: Option<Count>,
}

impl Words {
    /// Checks settings, and computes their words.
    ///
    /// # Errors
    /// The settings cannot work on this board.
    pub fn plan(settings: &Settings) -> Result<(Plan<N>, Self), SettingsError> {
        if !matches!(settings.core_mhz, 0 | CORE_MHZ) {
            return Err(SettingsError::Speed);
        }
        let slots = if settings.slots == 0 { USUAL_SLOTS } else { settings.slots };
        if !(4..=SLOTS as u16).contains(&slots) {
            return Err(SettingsError::Slots);
        }
        let iq = settings.iq;
        let each = conversions(iq);
        let rate_hz = settings.config.rate_hz * f64::from(each);
        let period = period(rate_hz).map_err(SettingsError::Rate)?;
        // Two real samples share a word, which a guard must not split. Pairs take a slot without a guard.
        if !settings.guard.is_multiple_of(2) || (iq && settings.guard > 0) {
            return Err(SettingsError::Guard);
        }
        if iq && !Pairs::fits(settings.config.method) {
            return Err(SettingsError::Config(ConfigError::Method));
        }
        // Floats would take longer than a block: this core has none, and the image no joint fit.
        let (arithmetic, effort) = (Arithmetic::Fixed, Effort::LOOK);
        let config = Config { arithmetic, effort, ..settings.config };
        let rounds = settings.effort.map(|_| effort);
        let settings = Settings { core_mhz: CORE_MHZ, slots, config, effort: rounds, ..*settings };
        let plan = Plan::new(&settings, rate_of(period * each))?;
        let length = plan.length;
        let adc = u64::from(period).saturating_mul((length * each).into());
        let cycles = adc.saturating_mul(CORE_CYCLES.into());
        let worst = (!iq).then_some([WORST_CYCLES; 4]);
        Load { block: cycles, usual: 0, worst, target: TARGET_CYCLES }.effort(&settings)?;
        let (mut waveform, mut opening) = (None, None);
        match (settings.drive, settings.config.scene) {
            (Drive::Off, _) => {}
            (Drive::Dac { low, high }, Scene::Chirp(Chirp { shape, .. })) => {
                let wave = Waveform::plan(shape, length, period * each, [low, high]);
                waveform = Some(wave.map_err(SettingsError::Waveform)?);
            }
            (Drive::External, Scene::Chirp(Chirp { shape, .. })) => {
                let conversions = length * each * shape.segments().len() as u32;
                let open = gate(conversions, period);
                opening = Some(open.ok_or(SettingsError::Rate(RateError::Slow))?);
            }
            _ => return Err(SettingsError::Drive),
        }
        let corrects = !settings.uncorrected;
        Ok((plan, Self { period, length, iq, corrects, waveform, gate: opening }))
    }

    /// The rate of samples or pairs, Hz.
    pub fn rate_hz(&self) -> f64 {
        rate_of(self.sample_cycles())
    }

    /// Cycles of the converter's clock from a sample or pair to the next.
    pub const fn sample_cycles(&self) -> u32 {
        self.period.saturating_mul(conversions(self.iq))
    }

    /// ADC_CS: the word that starts the converter.
    pub const fn start(&self) -> u32 {
        if self.iq { PAIRS } else { SAMPLES }
    }

    /// Conversions from a block to the next.
    pub const fn transfers(&self) -> u32 {
        self.length.saturating_mul(conversions(self.iq))
    }

    /// ADC_DIV (DS 4.9.6): INT 23:8 is a cycle less than the period. 0 samples back to back.
    pub const fn divider(self) -> u32 {
        if self.period <= SAMPLE_CYCLES { 0 } else { (self.period - 1) << 8 }
    }

    /// Cycles of the converter's clock in a block with its guard.
    pub const fn block_cycles(self) -> u32 {
        self.period.saturating_mul(self.transfers())
    }
}

/// The largest number of core cycles known for a real block: the ceiling of `host-tests/budget.json`. The image has no joint fit, so that the
/// effort makes no difference. The worst pairs have not been searched for.
pub const WORST_CYCLES: u64 = 585_000;

/// Core cycles for the range of a sawtooth's target. It is less than the range and the velocity of a trapezoid, which take 13,530
/// instructions by 1.4 cycles each.
const TARGET_CYCLES: u64 = 19_000;

/// The fastest rate at which a block lasts `cycles` of the core, Hz.
pub fn fastest(cycles: u64, iq: bool) -> f64 {
    let each = conversions(iq);
    let wanted = cycles.div_ceil(N as u64 * u64::from(CORE_CYCLES * each));
    let wanted = u32::try_from(wanted).unwrap_or(u32::MAX).max(SAMPLE_CYCLES);
    rate_of(wanted.saturating_mul(each))
}

/// Conversions in a sample.
const fn conversions(iq: bool) -> u32 {
    if iq { 2 } else { 1 }
}

/// The rate of `cycles` of the converter's clock, Hz.
fn rate_of(cycles: u32) -> f64 {
    f64::from(ADC_HZ) / f64::from(cycles)
}

/// The period nearest to a rate, in cycles of the converter's clock.
fn period(rate_hz: f64) -> Result<u32, RateError> {
    let cycles = f64::from(ADC_HZ) / rate_hz;
    // A rate a hair above the fastest counts as the fastest, as in any other rounding.
    if cycles < f64::from(SAMPLE_CYCLES) - 0.5 {
        return Err(RateError::Fast);
    }
    if cycles.is_nan() || cycles > 65_536.5 {
        return Err(RateError::Slow);
    }
    Ok(((cycles + 0.5) as u32).clamp(SAMPLE_CYCLES, 65_536))
}

#[cfg(test)]
mod tests {
    use super::*;
    use picket_dsp::methods::registry::Method;
    use picket_dsp::solve::chirp::Shape;
    use picket_wire::settings_error::WaveformError;

    #[test]
    fn the_fastest_rate_of_a_block() {
        assert_eq!((fastest(0, false), fastest(0, true)), (500e3, 250e3));
        // A block of 1024 real samples lasts 3072 of the core's cycles for each of the converter's.
        assert_eq!(fastest(192 * 3072, false), 250e3);
        assert_eq!(fastest(192 * 3072 + 1, false), 48e6 / 193.0);
    }

    /// A rate for the worst block is the fastest at which that block does not take longer than it lasts.
    #[test]
    fn a_rate_that_does_not_hold_for_the_worst_block_is_refused() {
        let worst = SettingsError::Rate(RateError::Worst);
        for effort in [Effort::LOOK, Effort::TWO] {
            let of = |rate_hz: f64| {
                let settings = at(rate_hz);
                Settings { effort: Some(effort), worst_case: true, ..settings }
            };
            let rate_hz = fastest(WORST_CYCLES, false);
            assert!(Words::plan(&of(rate_hz)).is_ok(), "{effort:?}");
            let faster = of(f64::from(ADC_HZ) / (f64::from(ADC_HZ) / rate_hz - 1.0));
            assert_eq!(Words::plan(&faster).map(|_| ()), Err(worst));
            assert!(Words::plan(&Settings { worst_case: false, ..faster }).is_ok());
            let pairs = Settings { iq: true, ..of(1e3) };
            let refused = Words::plan(&pairs).map(|_| ());
            assert_eq!(refused, Err(SettingsError::Rate(RateError::Unsearched)));
        }
    }

    fn at(rate_hz: f64) -> Settings {
        let settings = Settings::default();
        Settings { config: Config { rate_hz, ..settings.config }, ..settings }
    }

    #[test]
    fn rates_are_whole_periods_of_the_converter() {
        for (wanted, period, divider) in
            [(500e3, 96, 0), (501e3, 96, 0), (250e3, 192, 191 << 8), (100e3, 480, 479 << 8)]
        {
            let (plan, words) = Words::plan(&at(wanted)).unwrap();
            assert_eq!((words.period, words.divider()), (period, divider), "{wanted}");
            assert_eq!(plan.settings.config.rate_hz, 48e6 / f64::from(period));
            assert_eq!((plan.settings.core_mhz, plan.settings.slots), (144, 8));
            assert_eq!(plan.settings.config.arithmetic, Arithmetic::Fixed);
        }
        let refused = |settings| Words::plan(&settings).map(|_| ()).unwrap_err();
        assert_eq!(refused(at(505e3)), SettingsError::Rate(RateError::Fast));
        assert_eq!(refused(at(700.0)), SettingsError::Rate(RateError::Slow));
        assert_eq!(refused(at(f64::NAN)), SettingsError::Rate(RateError::Slow));
        let settings = at(500e3);
        assert_eq!(refused(Settings { core_mhz: 180, ..settings }), SettingsError::Speed);
        assert_eq!(refused(Settings { slots: 17, ..settings }), SettingsError::Slots);
        assert_eq!(refused(Settings { slots: 3, ..settings }), SettingsError::Slots);
        let dac = Drive::Dac { low: 0, high: 1 };
        assert_eq!(refused(Settings { drive: dac, ..settings }), SettingsError::Drive);
        let chirp = chirp(settings, dac);
        let shape = Shape::Trapezoid;
        for (guard, length) in [(0, 1024), (64, 1088)] {
            let (plan, words) = Words::plan(&Settings { guard, ..chirp }).unwrap();
            assert_eq!((plan.length, words.length), (length, length));
            assert_eq!(words.block_cycles(), 96 * length);
            assert_eq!(words.waveform, Waveform::plan(shape, length, 96, [0, 1]).ok());
        }
        assert_eq!(refused(Settings { guard: 3, ..chirp }), SettingsError::Guard);
        assert_eq!(refused(Settings { guard: 66, ..chirp }), SettingsError::Guard);
        let low = Drive::Dac { low: 2, high: 1 };
        let codes = SettingsError::Waveform(WaveformError::Codes);
        assert_eq!(refused(Settings { drive: low, ..chirp }), codes);
        let external = Settings { drive: Drive::External, ..chirp };
        let (_, words) = Words::plan(&external).unwrap();
        assert_eq!((words.gate, words.waveform), (gate(3 * 1024, 96), None));
        let rate_hz = 20e3;
        let slow = Settings { config: Config { rate_hz, ..external.config }, ..external };
        assert_eq!(refused(slow), SettingsError::Rate(RateError::Slow));
    }

    /// The converter stops within its last conversion, by a margin of 300 ns on each side.
    #[test]
    fn the_gate_ends_in_the_last_conversion() {
        for period in [96, 97, 480, 1000, 2999] {
            for conversions in [1024, 1088, 2 * 1024, 3 * 1088, 6 * 1024] {
                let Some(Count { divider, top }) = gate(conversions, period) else {
                    assert!(u64::from(conversions) * u64::from(period) > 5_500_000);
                    continue;
                };
                assert!(divider >> 4 <= 255 && top <= 0xFFFF);
                let cycles = (divider >> 4) * (top + 1);
                let [last, end] = [conversions - 1, conversions].map(|n| 3 * n * period);
                let margin = [cycles - last, end - cycles];
                assert!(margin.iter().all(|&cycles| cycles > 80), "{period} {margin:?}");
            }
        }
    }

    #[test]
    fn a_pair_is_two_conversions() {
        let pairs = |rate_hz| {
            let settings = at(rate_hz);
            let config = Config { band_hz: Some((2e3, 100e3)), ..settings.config };
            Settings { iq: true, config, ..settings }
        };
        for (wanted, period) in [(250e3, 96), (100e3, 240), (370.0, 64_865)] {
            let (wanted, band_hz) = (wanted, Some((wanted / 10.0, wanted / 2.5)));
            let settings = pairs(wanted);
            let config = Config { band_hz, ..settings.config };
            let (plan, words) = Words::plan(&Settings { config, ..settings }).unwrap();
            assert_eq!((words.period, words.length, words.transfers()), (period, 1024, 2048));
            assert_eq!(plan.settings.config.rate_hz, 24e6 / f64::from(period));
            assert_eq!(words.rate_hz(), plan.settings.config.rate_hz);
            assert_eq!((words.block_cycles(), plan.length), (2048 * period, 1024));
            assert_eq!(words.start(), 0x3_0009);
        }
        assert_eq!(Words::plan(&at(500e3)).unwrap().1.start(), 9);
        let refused = |settings| Words::plan(&settings).map(|_| ()).unwrap_err();
        let settings = pairs(250e3);
        assert_eq!(refused(pairs(252e3)), SettingsError::Rate(RateError::Fast));
        assert_eq!(refused(pairs(366.0)), SettingsError::Rate(RateError::Slow));
        let both = Config { band_hz: Some((-9e3, 9e3)), ..settings.config };
        // The channels' offsets are not searched.
        assert!(Words::plan(&Settings { config: both, ..settings }).is_ok());
        let method = Config { method: Method::Autocorrelation, ..settings.config };
        let error = SettingsError::Config(ConfigError::Method);
        assert_eq!(refused(Settings { config: method, ..settings }), error);
        let chirp = chirp(settings, Drive::Dac { low: 0, high: 4095 });
        assert_eq!(refused(Settings { guard: 2, ..chirp }), SettingsError::Guard);
        // The chirp has a level for each pair.
        let (_, words) = Words::plan(&chirp).unwrap();
        assert_eq!(words.waveform, Waveform::plan(Shape::Trapezoid, 1024, 192, [0, 4095]).ok());
    }

    fn chirp(settings: Settings, drive: Drive) -> Settings {
        let (shape, bandwidth_hz) = (Shape::Trapezoid, 200e6);
        let scene = Scene::Chirp(Chirp {
            shape,
            wavelength_m: 0.0125,
            bandwidth_hz,
            duration_s: 1.0,
            ..Chirp::default()
        });
        Settings { config: Config { scene, ..settings.config }, drive, ..settings }
    }
}
