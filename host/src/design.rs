//! `picket design`: what a rate, a length and a level give, and which of them a wanted sigma or span needs.

use crate::cli;
use crate::with_kind;
use clap::Args;
use comfy_table::{CellAlignment, ContentArrangement, LineStyle, Table, TableStyle};
use picket::config::SPEED_OF_LIGHT;
use picket::tone::sigma::bound_bins;
use serde::Serialize;
use serde_json::{Value, json};
use std::process::ExitCode;
use std::sync::LazyLock;

/// Lengths of the library.
const LENGTHS: [usize; 7] = [64, 128, 256, 512, 1024, 2048, 4096];
/// A tone has to lie so far below half the rate that filters let it pass, as a share of the rate.
const USED: f64 = 0.4;
/// Bins from 0 Hz in which an offset is not told from a tone.
const EDGE_BINS: f64 = 1.5;

/// Tells what a sample rate, a block length and a signal-to-noise ratio give: resolution, span, sigma, updates and load. With a wanted
/// sigma or speed it tells the settings.
#[derive(Args, Debug)]
pub struct Options {
    /// Carrier of the radar or laser, as 24.125G
    #[arg(long, value_name = "HZ", value_parser = cli::positive_hertz, required_unless_present = "wavelength_m", conflicts_with = "wavelength_m")]
    carrier_hz: Option<f64>,
    /// Its wavelength instead, as 1550e-9
    #[arg(long, value_name = "M", value_parser = cli::positive)]
    wavelength_m: Option<f64>,
    /// Samples per second [default: what --velocity-mps or --range-m need]
    #[arg(long, value_name = "HZ", value_parser = cli::positive_hertz)]
    rate: Option<f64>,
    /// Samples in a block [default: all lengths]
    #[arg(long, value_parser = length)]
    n: Option<usize>,
    /// Signal-to-noise ratio per sample, dB
    #[arg(long, value_name = "DB", default_value_t = 20.0, allow_negative_numbers = true, value_parser = cli::number)]
    snr_db: f64,
    /// I/Q samples
    #[arg(long)]
    iq: bool,
    /// Bandwidth of a chirp: ranges
    #[arg(long, value_name = "HZ", value_parser = cli::positive_hertz, requires = "chirp_s")]
    bandwidth_hz: Option<f64>,
    /// Duration of its ramp
    #[arg(long, value_name = "S", value_parser = cli::positive, requires = "bandwidth_hz")]
    chirp_s: Option<f64>,
    /// The fastest target
    #[arg(long, value_name = "M/S", value_parser = cli::positive)]
    velocity_mps: Option<f64>,
    /// The farthest target of a chirp
    #[arg(long, value_name = "M", value_parser = cli::positive, requires = "bandwidth_hz")]
    range_m: Option<f64>,
    /// Wanted sigma of the velocity: the shortest block that reaches it
    #[arg(long, value_name = "M/S", value_parser = cli::positive)]
    sigma_mps: Option<f64>,
    /// Wanted sigma of the range
    #[arg(long, value_name = "M", value_parser = cli::positive, requires = "bandwidth_hz")]
    sigma_m: Option<f64>,
    /// One JSON object a length, and one with the settings
    #[arg(long)]
    json: bool,
}

fn length(text: &str) -> Result<usize, String> {
    let known = text.parse().ok().filter(|n| LENGTHS.contains(n));
    known.ok_or_else(|| "choose 64, 128, ... 4096".into())
}

/// What a length gives. The keys are those of the JSON lines.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Samples in a block.
    pub n: usize,
    /// Duration of a block.
    pub block_s: f64,
    /// Blocks per second.
    pub updates_hz: f64,
    /// One bin, which is how far two tones have to be apart.
    pub bin_hz: f64,
    /// The bound on sigma of the frequency.
    pub sigma_hz: f64,
    /// The bin as a velocity, and sigma.
    pub resolution_mps: f64,
    /// The bound on sigma of the velocity.
    pub sigma_mps: f64,
    /// The slowest velocity that is told from an offset.
    pub slowest_mps: f64,
    /// The fastest velocity.
    pub fastest_mps: f64,
    /// The bin as a range, of a chirp.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub resolution_m: Option<f64>,
    /// The bound on sigma of the range.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sigma_m: Option<f64>,
    /// The farthest range.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub farthest_m: Option<f64>,
    /// The load of a Cortex-M4F at 180 MHz, by the median of its modelled cycles, where it is measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub load_m4f: Option<f64>,
    /// The load of a Cortex-M0+ at 125 MHz.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub load_m0: Option<f64>,
}

/// The cycles that the tests hold each stage to.
static BUDGET: LazyLock<Value> = LazyLock::new(|| {
    serde_json::from_str(include_str!("../../host-tests/budget.json")).unwrap_or_default()
});

/// What is designed.
struct Design {
    wavelength_m: f64,
    rate_hz: f64,
    iq: bool,
    snr: f64,
    /// Bandwidth and duration of a ramp.
    chirp: Option<(f64, f64)>,
}

impl Design {
    fn of(options: &Options) -> Result<Self, String> {
        let carrier = options.carrier_hz.map(|hz| SPEED_OF_LIGHT / hz);
        let wavelength_m = carrier.or(options.wavelength_m).ok_or("give --carrier-hz")?;
        let chirp = options.bandwidth_hz.zip(options.chirp_s);
        let shift = options.velocity_mps.map_or(0.0, |v| 2.0 * v / wavelength_m);
        let beat = chirp.zip(options.range_m);
        let beat = beat.map_or(0.0, |((b, t), r)| 2.0 * r * b / t / SPEED_OF_LIGHT);
        let needed = (shift + beat > 0.0).then(|| (shift + beat) / USED);
        let rate_hz = options.rate.or(needed).ok_or(
            "give --rate, or --velocity-mps of the fastest target, or --range-m of the farthest",
        )?;
        if let Some(needed) = needed.filter(|needed| *needed * USED > rate_hz / 2.0) {
            return Err(format!(
                "--rate {rate_hz}: this target's beat is {:.0} Hz, which needs {needed:.0} samples per second",
                needed * USED
            ));
        }
        let snr = 10f64.powf(options.snr_db / 10.0);
        Ok(Self { wavelength_m, rate_hz, iq: options.iq, snr, chirp })
    }

    /// Whether a ramp is as long as a block.
    fn fits(&self, n: usize) -> bool {
        self.chirp
            .is_none_or(|(_, duration_s)| n as f64 / self.rate_hz <= duration_s * (1.0 + 1e-9))
    }

    fn row(&self, n: usize) -> Row {
        let &Self { wavelength_m, rate_hz, iq, snr, chirp } = self;
        let bin_hz = rate_hz / n as f64;
        let bound = with_kind!(iq, R => bound_bins::<R>(n, snr as f32));
        let sigma_hz = f64::from(bound) * bin_hz;
        let (speed, half) = (wavelength_m / 2.0, rate_hz / 2.0);
        let metres = chirp.map(|(b, t)| SPEED_OF_LIGHT * t / (2.0 * b));
        let cycles = |pointer: &str| BUDGET.pointer(pointer).and_then(Value::as_f64);
        let load = |cycles: f64, core_hz: f64| cycles / (n as f64 / rate_hz * core_hz);
        let m4f = cycles(&format!("/engines/picket-i32/cycles/{n}/measurement"));
        let m0 = cycles("/portable_cycles/M0/measurement").filter(|_| n == 1024);
        Row {
            n,
            block_s: n as f64 / rate_hz,
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
            load_m4f: m4f.filter(|_| !iq).map(|cycles| load(cycles, 180e6)),
            load_m0: m0.filter(|_| !iq).map(|cycles| load(cycles, 125e6)),
        }
    }

    /// The settings of a length, as `picket watch --set-settings` takes them.
    fn settings(&self, n: usize) -> Value {
        let &Self { wavelength_m, rate_hz, iq, chirp, .. } = self;
        let scene = match chirp {
            None => json!({"doppler": {"wavelength_m": wavelength_m, "angle_rad": 0.0}}),
            Some((bandwidth_hz, _)) => json!({
                "chirp": {"shape": "trapezoid", "wavelength_m": wavelength_m, "bandwidth_hz": bandwidth_hz}
            }),
        };
        json!({"n": n, "rate_hz": rate_hz, "iq": iq, "scene": scene})
    }
}

/// Four digits.
fn digits(value: f64) -> String {
    let before = value.abs().max(1e-12).log10().floor();
    match before {
        -4.0..5.0 => format!("{value:.*}", (3.0 - before).clamp(0.0, 8.0) as usize),
        _ => format!("{value:.3e}"),
    }
}

/// Prints the design.
pub fn run(options: &Options) -> Result<ExitCode, String> {
    let design = Design::of(options)?;
    let rows: Vec<Row> = LENGTHS
        .into_iter()
        .filter(|n| options.n.is_none_or(|wanted| wanted == *n))
        .filter(|n| design.fits(*n))
        .map(|n| design.row(n))
        .collect();
    if rows.is_empty() {
        return Err(
            "the ramp is shorter than the block: raise --rate, or lengthen --chirp-s".into()
        );
    }
    let reaches = |row: &&Row| {
        let velocity = options.sigma_mps.is_none_or(|wanted| row.sigma_mps <= wanted);
        let range = options.sigma_m.is_none_or(|wanted| row.sigma_m.is_some_and(|m| m <= wanted));
        velocity && range
    };
    let wanted = options.sigma_mps.is_some() || options.sigma_m.is_some() || options.n.is_some();
    let chosen = rows.iter().find(reaches).filter(|_| wanted);
    if wanted && chosen.is_none() {
        let best = rows.last().map_or(f64::NAN, |row| row.sigma_mps);
        return Err(format!(
            "no block of {} samples or less reaches this: the bound at {} dB is {} m/s; lower the rate, or raise the level",
            rows.last().map_or(0, |row| row.n),
            options.snr_db,
            digits(best)
        ));
    }
    if options.json {
        for row in &rows {
            cli::print_line(&serde_json::to_string(row).unwrap_or_default());
        }
    } else {
        cli::print(&text(&design, &rows));
    }
    if let Some(row) = chosen {
        let settings = design.settings(row.n);
        match options.json {
            true => cli::print_line(&json!({"summary": true, "settings": settings}).to_string()),
            false => cli::print_line(&format!("settings  {settings}")),
        }
    }
    Ok(ExitCode::SUCCESS)
}

fn text(design: &Design, rows: &[Row]) -> String {
    let Design { wavelength_m, rate_hz, iq, chirp, snr } = design;
    let kind = if *iq { "I/Q" } else { "real" };
    let sign = if *iq { "either way" } else { "without its sign" };
    let mut text = format!(
        "{kind} samples at {} Hz, wavelength {} m, {:.1} dB per sample\n1 m/s is {} Hz; velocities up to {} m/s, {sign}",
        digits(*rate_hz),
        digits(*wavelength_m),
        10.0 * snr.log10(),
        digits(2.0 / wavelength_m),
        digits(rate_hz / 4.0 * wavelength_m),
    );
    if let Some((bandwidth, duration)) = chirp {
        let metres = SPEED_OF_LIGHT * duration / (2.0 * bandwidth);
        text += &format!(
            "\n1 m is {} Hz; ranges up to {} m. A ramp alone takes 1 m/s for {} m: a trapezoid or I/Q triangle tells them apart",
            digits(1.0 / metres),
            digits(metres * rate_hz / 2.0),
            digits(2.0 / wavelength_m * metres),
        );
    }
    let mut table = Table::new();
    let rule = LineStyle::none().fill('─').junction('─');
    table.load_style(TableStyle::new().header_separator(rule));
    table.set_content_arrangement(ContentArrangement::Disabled);
    let mut head = vec!["N", "block ms", "updates/s", "bin Hz", "bin m/s", "sigma m/s", "from m/s"];
    if chirp.is_some() {
        head.extend(["bin m", "sigma m"]);
    }
    head.extend(["M4F 180 MHz", "M0+ 125 MHz"]);
    let columns = head.len();
    table.set_header(head);
    let load = |load: Option<f64>| match load {
        Some(load) if load > 1.0 => "too slow".to_owned(),
        Some(load) => format!("{:.1} %", 100.0 * load),
        None => "-".into(),
    };
    for row in rows {
        let mut cells = vec![row.n.to_string()];
        let numbers = [1e3 * row.block_s, row.updates_hz, row.bin_hz, row.resolution_mps];
        cells.extend(numbers.map(digits));
        cells.extend([row.sigma_mps, row.slowest_mps].map(digits));
        cells.extend([row.resolution_m, row.sigma_m].into_iter().flatten().map(digits));
        cells.extend([load(row.load_m4f), load(row.load_m0)]);
        table.add_row(cells);
    }
    for column in 0..columns {
        if let Some(column) = table.column_mut(column) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    format!("{text}\n\n{table}\n")
}
