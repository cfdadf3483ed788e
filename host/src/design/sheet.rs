//! What a rate, a length and a level give, as numbers and as words: for the command and for the page.

use picket_dsp::Shape;
use picket_dsp::config::SPEED_OF_LIGHT;
use picket_dsp::tone::sigma::bound_bins;
use std::fmt;

/// Lengths of the library.
pub const LENGTHS: [usize; 7] = [64, 128, 256, 512, 1024, 2048, 4096];
/// A tone has to lie so far below half the rate that filters let it pass, as a share of the rate.
const USED: f64 = 0.4;
/// Samples before a block that a board drops, at most, and their step: the DAC's stairs fit them.
const GUARD: [f64; 2] = [64.0, 32.0];
/// Bins from 0 Hz within which a tone cannot be distinguished from an offset.
const EDGE_BINS: f64 = 1.5;
/// Samples of a block on the boards, whose images measure blocks of this length alone.
const ON_BOARDS: usize = 1024;
/// The clocks of the cores whose load the sheet states.
const CORES_HZ: [f64; 2] = [180e6, 125e6];

/// The question. All numbers are above 0, except the signal-to-noise ratio.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Question {
    /// The wavelength of the radar or laser, m.
    pub wavelength_m: f64,
    /// Samples per second; `None` for as many as the target needs.
    pub rate_hz: Option<f64>,
    /// Samples in a block; `None` for all lengths.
    pub n: Option<usize>,
    /// Signal-to-noise ratio per sample, dB.
    pub snr_db: f64,
    /// I/Q samples.
    pub iq: bool,
    /// Bandwidth and duration of a ramp, Hz and s.
    pub chirp: Option<(f64, f64)>,
    /// The ramps that the settings ask for.
    pub shape: Shape,
    /// The fastest target, m/s.
    pub velocity_mps: Option<f64>,
    /// The farthest target of a chirp, m.
    pub range_m: Option<f64>,
    /// The wanted sigma of the velocity, m/s.
    pub sigma_mps: Option<f64>,
    /// The wanted sigma of the range, m.
    pub sigma_m: Option<f64>,
}

/// Why there is no answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Trouble {
    /// The rate is neither given nor implied.
    NoRate,
    /// The rate is too low for the target: its beat, Hz, and the rate that it needs.
    Slow {
        /// The beat.
        beat_hz: f64,
        /// The rate that it needs.
        needed_hz: f64,
    },
    /// No block is as short as the ramp.
    ShortRamp,
    /// No block reaches the wanted sigma: the longest one, the signal-to-noise ratio, dB, and the velocity's sigma, m/s.
    TooNoisy(usize, f64, f64),
}

impl fmt::Display for Trouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Trouble::NoRate => {
                f.write_str("the rate is not known: give it, or how fast or far the target is")
            }
            Trouble::Slow { beat_hz, needed_hz } => write!(
                f,
                "this target's beat is {beat_hz:.0} Hz, which needs {needed_hz:.0} samples per second"
            ),
            Trouble::ShortRamp => f.write_str(
                "the ramp is shorter than the block: raise the rate, or lengthen the ramp",
            ),
            Trouble::TooNoisy(n, snr_db, sigma_mps) => write!(
                f,
                "no block of {n} samples or less reaches this: the bound at {snr_db} dB is {} m/s; lower the rate, or raise the level",
                digits(*sigma_mps)
            ),
        }
    }
}

/// The figures of a length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Samples in a block.
    pub n: usize,
    /// Duration of a block.
    pub block_s: f64,
    /// Blocks per second.
    pub updates_hz: f64,
    /// One bin, the least distance of two tones.
    pub bin_hz: f64,
    /// The bound on sigma of the frequency.
    pub sigma_hz: f64,
    /// The bin as a velocity.
    pub resolution_mps: f64,
    /// The bound on sigma of the velocity.
    pub sigma_mps: f64,
    /// The slowest velocity that can be distinguished from an offset.
    pub slowest_mps: f64,
    /// The fastest velocity.
    pub fastest_mps: f64,
    /// The bin as a range, of a chirp.
    pub resolution_m: Option<f64>,
    /// The bound on sigma of the range.
    pub sigma_m: Option<f64>,
    /// The farthest range.
    pub farthest_m: Option<f64>,
    /// The load of a Cortex-M4F at 180 MHz, by the median of its modelled cycles, where it is measured.
    pub load_m4f: Option<f64>,
    /// The load of a Cortex-M0+ at 125 MHz.
    pub load_m0: Option<f64>,
}

impl Row {
    /// Its numbers behind the length, by the keys of the JSON lines.
    pub fn fields(&self) -> [(&'static str, Option<f64>); 13] {
        [
            ("block_s", Some(self.block_s)),
            ("updates_hz", Some(self.updates_hz)),
            ("bin_hz", Some(self.bin_hz)),
            ("sigma_hz", Some(self.sigma_hz)),
            ("resolution_mps", Some(self.resolution_mps)),
            ("sigma_mps", Some(self.sigma_mps)),
            ("slowest_mps", Some(self.slowest_mps)),
            ("fastest_mps", Some(self.fastest_mps)),
            ("resolution_m", self.resolution_m),
            ("sigma_m", self.sigma_m),
            ("farthest_m", self.farthest_m),
            ("load_m4f", self.load_m4f),
            ("load_m0", self.load_m0),
        ]
    }

    /// Its cells in a table, under [`Design::head`].
    pub fn cells(&self) -> Vec<String> {
        let load = |load: Option<f64>| match load {
            Some(load) if load > 1.0 => "too slow".to_owned(),
            Some(load) => format!("{:.1} %", 100.0 * load),
            None => "not measured".into(),
        };
        let numbers = [1e3 * self.block_s, self.updates_hz, self.bin_hz, self.resolution_mps];
        let range = [self.resolution_m, self.sigma_m].into_iter().flatten();
        let all = numbers.into_iter().chain([self.sigma_mps, self.slowest_mps]).chain(range);
        let mut cells = vec![self.n.to_string()];
        cells.extend(all.map(digits));
        cells.extend([load(self.load_m4f), load(self.load_m0)]);
        cells
    }
}

/// A board's ramp.
struct Ramp {
    /// Samples before the block.
    guard: u16,
    /// What it sweeps until the block's end.
    bandwidth_hz: f64,
}

/// An answer.
#[derive(Clone, Debug, PartialEq)]
pub struct Design {
    question: Question,
    rate_hz: f64,
    /// A row for each length, the shortest first.
    pub rows: Vec<Row>,
    /// The row that reaches the wanted sigma, if there is one.
    pub chosen: Option<usize>,
}

impl Design {
    /// The answer to a question.
    ///
    /// # Errors
    /// Where there is none.
    pub fn of(question: Question) -> Result<Self, Trouble> {
        let Question { wavelength_m, chirp, sigma_mps, sigma_m, n, .. } = question;
        let shift = question.velocity_mps.map_or(0.0, |v| 2.0 * v / wavelength_m);
        let beat = chirp.zip(question.range_m);
        let beat = beat.map_or(0.0, |((b, t), r)| 2.0 * r * b / t / SPEED_OF_LIGHT);
        let beat_hz = shift + beat;
        let needed = (beat_hz > 0.0).then_some(beat_hz / USED);
        let rate_hz = question.rate_hz.or(needed).ok_or(Trouble::NoRate)?;
        if let Some(needed_hz) = needed.filter(|_| beat_hz > rate_hz / 2.0) {
            return Err(Trouble::Slow { beat_hz, needed_hz });
        }
        let mut design = Self { question, rate_hz, rows: Vec::new(), chosen: None };
        let lengths = LENGTHS.into_iter().filter(|length| n.is_none_or(|n| n == *length));
        design.rows = lengths.filter(|&n| design.fits(n)).map(|n| design.row(n)).collect();
        let longest = *design.rows.last().ok_or(Trouble::ShortRamp)?;
        if sigma_mps.is_some() || sigma_m.is_some() || n.is_some() {
            let reaches = |row: &Row| {
                let velocity = sigma_mps.is_none_or(|wanted| row.sigma_mps <= wanted);
                let range = |wanted| row.sigma_m.is_some_and(|sigma| sigma <= wanted);
                velocity && sigma_m.is_none_or(range)
            };
            design.chosen = design.rows.iter().position(reaches);
            if design.chosen.is_none() {
                return Err(Trouble::TooNoisy(longest.n, question.snr_db, longest.sigma_mps));
            }
        }
        Ok(design)
    }

    /// Whether a ramp is as long as a block.
    fn fits(&self, n: usize) -> bool {
        let duration_s = self.question.chirp.map(|(_, duration_s)| duration_s);
        duration_s.is_none_or(|duration_s| n as f64 / self.rate_hz <= duration_s * (1.0 + 1e-9))
    }

    fn row(&self, n: usize) -> Row {
        let Question { wavelength_m, iq, snr_db, .. } = self.question;
        let bin_hz = self.rate_hz / n as f64;
        let snr = 10f64.powf(snr_db / 10.0) as f32;
        let bound = bound_bins(iq, n, snr);
        let sigma_hz = f64::from(bound) * bin_hz;
        let (speed, half, metres) = (wavelength_m / 2.0, self.rate_hz / 2.0, self.metres());
        let load = |cycles: Option<u32>, core_hz: f64| {
            let cycles = cycles.filter(|_| !iq)?;
            Some(f64::from(cycles) / (n as f64 / self.rate_hz * core_hz))
        };
        Row {
            n,
            block_s: n as f64 / self.rate_hz,
            updates_hz: bin_hz,
            bin_hz,
            sigma_hz,
            resolution_mps: bin_hz * speed,
            sigma_mps: sigma_hz * speed,
            slowest_mps: EDGE_BINS * bin_hz * speed,
            fastest_mps: half * speed,
            resolution_m: metres.map(|m| m * bin_hz),
            sigma_m: metres.map(|m| m * sigma_hz),
            farthest_m: metres.map(|m| m * half),
            load_m4f: load(cycles_m4f(n), CORES_HZ[0]),
            load_m0: load(cycles_m0(n), CORES_HZ[1]),
        }
    }

    /// Metres of range for a hertz of a chirp's beat.
    fn metres(&self) -> Option<f64> {
        self.question
            .chirp
            .map(|(bandwidth, duration)| SPEED_OF_LIGHT * duration / (2.0 * bandwidth))
    }

    /// Samples per second.
    pub const fn rate_hz(&self) -> f64 {
        self.rate_hz
    }

    /// What holds for all lengths, a line each.
    pub fn sentences(&self) -> Vec<String> {
        let Question { wavelength_m, iq, snr_db, .. } = self.question;
        let kind = if iq { "I/Q" } else { "real" };
        let sign = if iq { "either way" } else { "without its sign" };
        let rate_hz = self.rate_hz;
        let mut sentences = vec![
            format!(
                "{kind} samples at {} Hz, wavelength {} m, {snr_db:.1} dB per sample",
                digits(rate_hz),
                digits(wavelength_m),
            ),
            format!(
                "1 m/s is {} Hz; velocities up to {} m/s, {sign}",
                digits(2.0 / wavelength_m),
                digits(rate_hz / 4.0 * wavelength_m),
            ),
        ];
        sentences.extend(self.metres().map(|metres| {
            format!(
                "1 m is {} Hz; ranges up to {} m. A single ramp shows 1 m/s as {} m: a trapezoid or an I/Q triangle separates them, a sawtooth from chirp to chirp",
                digits(1.0 / metres),
                digits(metres * rate_hz / 2.0),
                digits(2.0 / wavelength_m * metres),
            )
        }));
        sentences.extend(self.ramp().map(|ramp| {
            let why = match (self.question.shape, iq) {
                (Shape::Trapezoid, _) => "a trapezoid, whose flat part shows the velocity alone, in three times the ramp",
                (Shape::Triangle, true) => "a triangle: the sum of its two beats is the range, their difference the velocity",
                (Shape::Triangle, false) => "a triangle, which on real samples fits two targets: limit range or velocity",
                (Shape::Sawtooth, _) => "a sawtooth, whose range is that of a target at rest: limit the velocity",
            };
            let drive = "made by the board's DAC; for another source put \"external\" or \"adf4159\" into `drive`";
            format!(
                "the settings ask for {why}; of the ramp {} Hz in {} guard samples and the block, {drive}",
                digits(ramp.bandwidth_hz),
                ramp.guard
            )
        }));
        sentences.extend(self.for_boards());
        sentences
    }

    /// The ramp that a board makes: it lasts a block and its guard, and rises as fast as the one that was asked for.
    fn ramp(&self) -> Option<Ramp> {
        let (bandwidth_hz, duration_s) = self.question.chirp?;
        let n = self.on_boards()? as f64;
        let whole = duration_s * self.rate_hz;
        let [most, step] = GUARD;
        let guard = ((whole - n + 1e-6) / step).floor() * step;
        let guard = guard.clamp(0.0, most);
        let swept_hz = bandwidth_hz * (n + guard) / whole;
        Some(Ramp { guard: guard as u16, bandwidth_hz: swept_hz.min(bandwidth_hz) })
    }

    /// The length for a board: the asked one, else that of the boards' images if it reaches the wanted sigma, as any length does from the
    /// shortest on that reaches it.
    fn on_boards(&self) -> Option<usize> {
        let chosen = self.rows.get(self.chosen?)?.n;
        let there = self.rows.iter().any(|row| row.n == ON_BOARDS) && chosen <= ON_BOARDS;
        Some(if there { ON_BOARDS } else { chosen })
    }

    /// What the settings' length is, where it was not asked for.
    fn for_boards(&self) -> Option<String> {
        let (chosen, n) = (self.rows.get(self.chosen?)?.n, self.on_boards()?);
        let asked = self.question.n.is_some();
        let row = self.rows.iter().find(|row| row.n == n).filter(|_| !asked)?;
        match n {
            ON_BOARDS if chosen == n => None,
            ON_BOARDS => Some(format!(
                "{chosen} samples reach it; the settings are for blocks of {n}, as the boards' images measure them: sigma {} m/s",
                digits(row.sigma_mps)
            )),
            _ => Some(format!(
                "the boards' images measure blocks of {ON_BOARDS} samples: {n} need an image of their own"
            )),
        }
    }

    /// The headings of the cells of a row.
    pub fn head(&self) -> Vec<&'static str> {
        let mut head =
            vec!["N", "block ms", "updates/s", "bin Hz", "bin m/s", "sigma m/s", "slowest m/s"];
        if self.question.chirp.is_some() {
            head.extend(["bin m", "sigma m"]);
        }
        head.extend(["load M4F 180 MHz", "load M0+ 125 MHz"]);
        head
    }

    /// The settings for a board, as `picket watch --set-settings` takes them: JSON.
    pub fn settings(&self) -> Option<String> {
        let (Question { wavelength_m, iq, shape, .. }, rate_hz) = (self.question, self.rate_hz);
        let n = self.on_boards()?;
        let board = format!(r#""iq":{iq},"n":{n},"rate_hz":{rate_hz:?}"#);
        let Some(Ramp { guard, bandwidth_hz }) = self.ramp() else {
            return Some(format!(
                r#"{{{board},"scene":{{"doppler":{{"angle_rad":0.0,"wavelength_m":{wavelength_m:?}}}}}}}"#
            ));
        };
        let shape = match shape {
            Shape::Trapezoid => "trapezoid",
            Shape::Triangle => "triangle",
            Shape::Sawtooth => "sawtooth",
        };
        Some(format!(
            r#"{{"drive":{{"dac":{{"high":3845,"low":250}}}},"guard":{guard},{board},"scene":{{"chirp":{{"bandwidth_hz":{bandwidth_hz:?},"shape":"{shape}","wavelength_m":{wavelength_m:?}}}}}}}"#
        ))
    }
}

/// Four digits.
pub fn digits(value: f64) -> String {
    let before = value.abs().max(1e-12).log10().floor();
    match before {
        -4.0..5.0 => format!("{value:.*}", (3.0 - before).clamp(0.0, 8.0) as usize),
        _ => format!("{value:.3e}"),
    }
}

/// The cycles that the tests hold each stage to.
const BUDGET: &[u8] = include_bytes!("../../../host-tests/budget.json");

/// The cycles of a measurement on a Cortex-M4F, for the lengths for which they are measured.
const fn cycles_m4f(n: usize) -> Option<u32> {
    const OF: [u32; 3] = [
        cycles(&["picket-i32", "cycles", "256", "measurement"]),
        cycles(&["picket-i32", "cycles", "1024", "measurement"]),
        cycles(&["picket-i32", "cycles", "4096", "measurement"]),
    ];
    match n {
        256 => Some(OF[0]),
        1024 => Some(OF[1]),
        4096 => Some(OF[2]),
        _ => None,
    }
}

/// Cycles of a measurement on a Cortex-M0.
const fn cycles_m0(n: usize) -> Option<u32> {
    const OF: u32 = cycles(&["portable_cycles", "M0", "measurement"]);
    if n == 1024 { Some(OF) } else { None }
}

/// The number behind these keys of the budget, each sought behind the one before. The compiler reads it, so that the page needs no
/// JSON; a test holds it to what a reader of JSON finds.
const fn cycles(keys: &[&str]) -> u32 {
    let (mut at, mut index) = (0, 0);
    while index < keys.len() {
        let key = keys[index].as_bytes();
        while !quoted(key, at) {
            at += 1;
        }
        at += key.len() + 2;
        index += 1;
    }
    while !BUDGET[at].is_ascii_digit() {
        at += 1;
    }
    let mut number = 0;
    while BUDGET[at].is_ascii_digit() {
        number = 10 * number + (BUDGET[at] - b'0') as u32;
        at += 1;
    }
    number
}

/// Whether this key stands in quotes at a place.
const fn quoted(key: &[u8], at: usize) -> bool {
    let mut index = 0;
    while index < key.len() {
        if BUDGET[at + 1 + index] != key[index] {
            return false;
        }
        index += 1;
    }
    BUDGET[at] == b'"' && BUDGET[at + 1 + key.len()] == b'"'
}
