//! A measurement as a line, for people and for programs.

use super::Style;
use crate::analyze::names;
use crate::device::Listener;
use picket_dsp::Candidate;
use picket_dsp::Effort;
use picket_dsp::acquire::burst::Counters;
use picket_dsp::acquire::sample::Segment;
use picket_dsp::fixed::types::I32F32;
use picket_dsp::pipeline::Outcome;
use picket_dsp::solve::uncertainty::Total;
use picket_dsp::tone::phasor::ToneWithPhase;
use picket_dsp::tone::{Tone, Verdict};
use picket_wire::boot::{Boot, Clock};
use picket_wire::burst::Burst;
use picket_wire::follow::Follow;
use picket_wire::lines as wire;
use picket_wire::status::Status;
use picket_wire::sum::Sum;
use picket_wire::telemetry::{Basis, Telemetry};
use picket_wire::view;
use serde::Serialize;
use std::collections::BTreeMap;

/// The reason of an answer whose rate is not the stated one, by this machine's clock.
pub(super) const WRONG_RATE: &str = "wrong-rate";

/// What is read of a tone.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Reading {
    pub(super) frequency_cycles_per_sample: f64,
    sigma_cycles_per_sample: f32,
    pub(super) frequency_hz: Option<f64>,
    pub(super) sigma_hz: Option<f64>,
    pub(super) snr_db: f64,
    pub(super) amplitude_codes: f32,
    /// What every program shows of a tone as it is.
    #[serde(flatten)]
    further: BTreeMap<&'static str, f64>,
}

/// A number as a cell of a table, which is empty where there is none.
fn cell(value: Option<f64>) -> String {
    value.map(|v| v.to_string()).unwrap_or_default()
}

impl Reading {
    /// Converts a tone of a block, to hertz if the sample rate is known.
    pub(super) fn of(tone: &Tone, rate_hz: Option<f64>) -> Self {
        let cycles = tone.frequency.0.to_num::<f64>();
        let hertz = |cycles: f64| rate_hz.map(|rate| cycles * rate);
        let mut further = BTreeMap::new();
        view::Tone::from_tone(tone, 0).further(&mut |name, value| {
            further.insert(name, value);
        });
        Self {
            further,
            frequency_cycles_per_sample: cycles,
            sigma_cycles_per_sample: tone.sigma,
            frequency_hz: hertz(cycles),
            sigma_hz: hertz(tone.sigma.into()),
            snr_db: 10.0 * f64::from(tone.snr).log10(),
            amplitude_codes: tone.amplitude,
        }
    }

    /// Comma-separated values of the lines below a block's row, empty where only a block has one. `more` are
    /// the last three columns.
    pub(super) fn csv_below(
        &self,
        sequence: u32,
        segment: &str,
        verdict: &str,
        more: &str,
    ) -> String {
        let Self { frequency_hz, sigma_hz, snr_db, amplitude_codes, .. } = *self;
        let (frequency, sigma) = (cell(frequency_hz), cell(sigma_hz));
        format!(
            "{sequence},,{segment},,{frequency},{sigma},{snr_db},{amplitude_codes},,{verdict},,,,,,,,,,{more}"
        )
    }

    /// A row of the table below a block's row.
    pub(super) fn table_below(&self, name: &str, more: &str) -> String {
        let (frequency, sigma) = self.cells();
        let name = format!("{name:>9}");
        format!("{name:18} {frequency:>16} {sigma:>13} {:7.1}  {more}", self.snr_db)
    }

    /// Frequency and sigma in hertz, or in cycles per sample where no rate is known: the heading says which.
    fn cells(&self) -> (String, String) {
        match (self.frequency_hz, self.sigma_hz) {
            (Some(hertz), Some(sigma)) => (format!("{hertz:.4}"), format!("{sigma:.4}")),
            _ => (
                format!("{:.9}", self.frequency_cycles_per_sample),
                format!("{:.2e}", self.sigma_cycles_per_sample),
            ),
        }
    }
}

/// A record's fields, units in their names.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    sequence: u32,
    rate_hz: Option<f64>,
    time_s: Option<f64>,
    segment: &'static str,
    gap: bool,
    #[serde(flatten)]
    reading: Reading,
    clipped: u32,
    verdict: &'static str,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    also: Vec<&'static str>,
    method: &'static str,
    range_m: Option<f64>,
    sigma_range_m: Option<f32>,
    velocity_mps: Option<f64>,
    sigma_velocity_mps: Option<f32>,
    /// The whole error.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    uncertainty: Option<Whole>,
    outcome_verdict: Option<&'static str>,
    ambiguity: Option<&'static str>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    candidates: Vec<Likely>,
    /// What a negative range says.
    caution: Option<&'static str>,
    lost: u32,
    faults: u32,
    missing: u64,
    bad_frames: u64,
    /// By what it was measured.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    basis: Option<Told>,
    /// Of a burst.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    transit: Option<Transit>,
}

/// A target that fits as others do, and its probability.
#[derive(Clone, Copy, Debug, Serialize)]
struct Likely {
    range_m: f64,
    velocity_mps: f64,
    odds: f32,
}

impl From<&Candidate> for Likely {
    fn from(candidate: &Candidate) -> Self {
        let Candidate { range, velocity, odds } = *candidate;
        Self { range_m: range.to_num(), velocity_mps: velocity.to_num(), odds }
    }
}

/// One standard deviation of each number by all that the settings say is not known, if they say it.
#[derive(Clone, Copy, Debug, Serialize)]
struct Whole {
    uncertainty_hz: Option<f64>,
    uncertainty_range_m: Option<f32>,
    uncertainty_velocity_mps: Option<f32>,
}

impl Whole {
    /// What a row of the table ends with.
    fn text(&self) -> String {
        let hertz = self.uncertainty_hz.filter(|_| self.uncertainty_velocity_mps.is_none());
        let parts = [
            (self.uncertainty_range_m.map(f64::from), "m"),
            (self.uncertainty_velocity_mps.map(f64::from), "m/s"),
            (hertz, "Hz"),
        ];
        let parts = parts.into_iter().filter_map(|(value, unit)| Some((value?, unit)));
        let parts = parts.map(|(value, unit)| format!("{value:.2e} {unit}"));
        format!("  ± {} in all", parts.collect::<Vec<_>>().join(", "))
    }

    fn of(record: &Telemetry, rate_hz: Option<f64>) -> Option<Self> {
        let Total { frequency, range, velocity } = record.uncertainty?;
        let [ranged, moving] = match record.measurement.result {
            Outcome::None => [false; 2],
            Outcome::Velocity(_) => [false, true],
            Outcome::Target(target) => [true, target.velocity.is_some()],
        };
        Some(Self {
            uncertainty_hz: rate_hz.map(|rate| f64::from(frequency) * rate),
            uncertainty_range_m: ranged.then_some(range),
            uncertainty_velocity_mps: moving.then_some(velocity),
        })
    }
}

/// Settings' checksum, clock and effort, if a board reports them.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Told {
    settings: String,
    clock: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    effort: Option<&'static str>,
}

impl Told {
    pub(super) fn of(basis: Basis) -> Self {
        let Basis { settings, clock, effort } = basis;
        let effort = Effort::from_rounds(effort).map(Effort::name);
        Self { settings: format!("{settings:08x}"), clock: clock.name(), effort }
    }
}

/// What only a burst has.
#[derive(Clone, Debug, Serialize)]
struct Transit {
    validation: &'static str,
    arrival_samples: f64,
    transit_s: Option<f64>,
    bursts: u32,
    bursts_lost: u32,
    bursts_long: u32,
    dead_share: f64,
}

/// The header of comma-separated values.
pub const CSV: &str = "sequence,time_s,segment,gap,frequency_hz,sigma_hz,snr_db,amplitude_codes,clipped,verdict,range_m,sigma_range_m,velocity_mps,sigma_velocity_mps,outcome_verdict,lost,faults,missing,bad_frames,line,phase_rad,sigma_phase_rad";

/// The header of the table, of blocks whose sample rate is known or of others.
pub const fn table_heading(knows_rate: bool) -> &'static str {
    match knows_rate {
        true => {
            "    block  segment     frequency Hz      sigma Hz  SNR dB     range m  velocity m/s  verdict      lost  faults"
        }
        false => {
            "    block  segment    cycles/sample         sigma  SNR dB     range m  velocity m/s  verdict      lost  faults"
        }
    }
}

pub(super) const fn segment(segment: Segment) -> &'static str {
    match segment {
        Segment::Continuous => "-",
        Segment::Up => "up",
        Segment::Flat => "flat",
        Segment::Down => "down",
    }
}

impl Row {
    /// The row of a record at this sample rate, if it is known.
    pub fn from_record(record: &Telemetry, rate_hz: Option<f64>, listener: &Listener) -> Self {
        let measurement = &record.measurement;
        let (stamp, tone) = (&measurement.stamp, &measurement.tone);
        let mut row = Row {
            sequence: stamp.sequence,
            rate_hz,
            time_s: rate_hz.map(|rate| stamp.clock as f64 / rate),
            segment: segment(stamp.segment),
            gap: stamp.gap,
            reading: Reading::of(tone, rate_hz),
            clipped: measurement.clipped,
            verdict: tone.verdict.name(),
            also: names(tone.also),
            method: record.method.name(),
            range_m: None,
            sigma_range_m: None,
            velocity_mps: None,
            sigma_velocity_mps: None,
            uncertainty: Whole::of(record, rate_hz),
            outcome_verdict: None,
            ambiguity: None,
            candidates: Vec::new(),
            caution: None,
            lost: record.health.lost,
            faults: record.health.faults,
            missing: listener.missing,
            bad_frames: listener.bad,
            basis: record.basis.map(Told::of),
            transit: None,
        };
        match &measurement.result {
            Outcome::None => {}
            Outcome::Velocity(v) => {
                row.velocity_mps = Some(v.velocity.to_num());
                row.sigma_velocity_mps = Some(v.sigma);
                row.outcome_verdict = Some(v.verdict.name());
            }
            Outcome::Target(t) => {
                row.range_m = Some(t.range.to_num());
                row.sigma_range_m = Some(t.sigma_range);
                row.velocity_mps = t.velocity.map(I32F32::to_num);
                row.sigma_velocity_mps = Some(t.sigma_velocity);
                row.outcome_verdict = Some(t.verdict.name());
                row.caution = t.caution();
                row.ambiguity = Some(t.ambiguity.name());
                row.candidates = t.ambiguity.candidates().iter().map(Likely::from).collect();
            }
        }
        if tone.verdict == Verdict::NoSignal {
            (row.reading.frequency_hz, row.reading.sigma_hz) = (None, None);
        }
        row
    }

    /// The row of a burst at this sample rate, if it is known.
    pub fn from_burst(burst: &Burst, rate_hz: Option<f64>, listener: &Listener) -> Self {
        let picket_dsp::Burst { arrival, validation, .. } = burst.burst;
        let Counters { samples, bursts, lost, long, dead } = burst.counters;
        let transit = Transit {
            validation: validation.name(),
            arrival_samples: arrival,
            transit_s: rate_hz.map(|rate| burst.burst.transit() / rate),
            bursts,
            bursts_lost: lost,
            bursts_long: long,
            dead_share: dead as f64 / samples.max(1) as f64,
        };
        let row = Self::from_record(&burst.record(), rate_hz, listener);
        let time_s = rate_hz.map(|rate| arrival / rate);
        Self { segment: "burst", time_s, transit: Some(transit), ..row }
    }

    /// Says of an answer that the rate is wrong by which its numbers were computed.
    pub fn at_wrong_rate(mut self, wrong: bool) -> Self {
        self.also.extend(wrong.then_some(WRONG_RATE));
        self
    }

    /// The block's number.
    pub fn sequence(&self) -> u32 {
        self.sequence
    }

    /// Whether its frequency is in hertz.
    pub fn knows_rate(&self) -> bool {
        self.rate_hz.is_some()
    }

    /// One JSON object. NaN is null.
    pub fn json(&self) -> String {
        serde_json::to_string(self).unwrap_or_default()
    }

    /// Comma-separated values, empty where there is none.
    pub fn csv(&self) -> String {
        let single = |value: Option<f32>| cell(value.map(f64::from));
        [
            self.sequence.to_string(),
            cell(self.time_s),
            self.segment.into(),
            self.gap.to_string(),
            cell(self.reading.frequency_hz),
            cell(self.reading.sigma_hz),
            self.reading.snr_db.to_string(),
            self.reading.amplitude_codes.to_string(),
            self.clipped.to_string(),
            self.verdict.into(),
            cell(self.range_m),
            single(self.sigma_range_m),
            cell(self.velocity_mps),
            single(self.sigma_velocity_mps),
            self.outcome_verdict.unwrap_or_default().into(),
            self.lost.to_string(),
            self.faults.to_string(),
            self.missing.to_string(),
            self.bad_frames.to_string(),
            // The columns of a line; a burst's validation stands in the first.
            self.transit.as_ref().map_or(String::new(), |transit| transit.validation.into()),
            String::new(),
            String::new(),
        ]
        .join(",")
    }

    /// A row of the table.
    pub fn table(&self) -> String {
        let number = |value: Option<f64>, digits: usize| match value {
            Some(value) => format!("{value:.digits$}"),
            None => "-".into(),
        };
        let others: String = self
            .candidates
            .iter()
            .skip(1)
            .map(|Likely { range_m, velocity_mps, odds }| {
                format!("  or {range_m:.4} m, {velocity_mps:.4} m/s ({:.0} %)", 100.0 * odds)
            })
            .collect();
        let caution = match (&self.transit, self.caution) {
            (Some(Transit { validation, transit_s: Some(time), .. }), _) => {
                format!("  {validation}, {:.1} us", 1e6 * time)
            }
            (Some(Transit { validation, .. }), _) => format!("  {validation}"),
            (None, caution) => caution.map_or(String::new(), |words| format!("  {words}")),
        };
        let whole = self.uncertainty.map_or(String::new(), |whole| whole.text());
        let rate = if self.also.contains(&WRONG_RATE) { "  at a wrong rate" } else { "" };
        let (frequency, sigma) = match self.reading.frequency_hz.is_none() && self.knows_rate() {
            true => ("-".into(), "-".into()),
            false => self.reading.cells(),
        };
        format!(
            "{:9}  {:7} {frequency:>16} {sigma:>13} {:7.1} {:>11} {:>13}  {:11} {:5} {:7}{rate}{caution}{whole}{others}",
            self.sequence,
            self.segment,
            self.reading.snr_db,
            number(self.range_m, 4),
            number(self.velocity_mps, 4),
            self.outcome_verdict.unwrap_or(self.verdict),
            self.lost,
            self.faults,
        )
    }

    /// Teleplot's lines.
    pub fn teleplot(&self) -> Vec<String> {
        let values = [
            ("frequency_hz", self.reading.frequency_hz),
            ("sigma_hz", self.reading.sigma_hz),
            ("snr_db", Some(self.reading.snr_db)),
            ("range_m", self.range_m),
            ("velocity_mps", self.velocity_mps),
            ("transit_s", self.transit.as_ref().and_then(|transit| transit.transit_s)),
            ("lost", Some(self.lost.into())),
            ("missing", Some(self.missing as f64)),
        ];
        let finite = values.into_iter().filter_map(|(name, value)| Some((name, value?)));
        finite
            .filter(|(_, value)| value.is_finite())
            .map(|(name, value)| format!(">{name}:{value}"))
            .collect()
    }
}

/// The tones of a block, units in the fields' names.
#[derive(Debug)]
pub struct Lines(Vec<Line>);

/// One of them.
#[derive(Debug, Serialize)]
struct Line {
    /// Its place, the strongest first: 1 and on.
    line: usize,
    sequence: u32,
    segment: &'static str,
    #[serde(flatten)]
    reading: Reading,
    phase_rad: f32,
    sigma_phase_rad: f32,
    verdict: &'static str,
}

impl Lines {
    /// Converts the tones that a device reports, to hertz if the sample rate is known.
    pub fn from_tones(lines: &wire::Lines, rate_hz: Option<f64>) -> Self {
        let line = |(index, phasor): (usize, &ToneWithPhase)| {
            let ToneWithPhase { tone, phase, sigma_phase } = phasor;
            Line {
                line: index + 1,
                sequence: lines.sequence,
                segment: segment(lines.segment),
                reading: Reading::of(tone, rate_hz),
                phase_rad: *phase,
                sigma_phase_rad: *sigma_phase,
                verdict: tone.verdict.name(),
            }
        };
        Lines(lines.tones.iter().enumerate().map(line).collect())
    }

    /// Their lines in this style.
    pub(super) fn written(&self, style: Style) -> Vec<String> {
        match style {
            Style::Jsonl => self.json(),
            Style::Teleplot => self.teleplot(),
            Style::Csv => self.csv(),
            Style::Table => self.table(),
        }
    }

    /// A JSON object for each.
    pub fn json(&self) -> Vec<String> {
        self.0.iter().map(|line| serde_json::to_string(line).unwrap_or_default()).collect()
    }

    /// Comma-separated values of each, empty where only a block has one.
    fn csv(&self) -> Vec<String> {
        let csv = |line: &Line| {
            let more = format!("{},{},{}", line.line, line.phase_rad, line.sigma_phase_rad);
            line.reading.csv_below(line.sequence, line.segment, line.verdict, &more)
        };
        self.0.iter().map(csv).collect()
    }

    /// A row of the table for each, if there are more than one.
    fn table(&self) -> Vec<String> {
        let table = |line: &Line| {
            let more = format!(
                "phase {:8.4} ± {:.4} rad  {}",
                line.phase_rad, line.sigma_phase_rad, line.verdict
            );
            line.reading.table_below(&format!("line {}", line.line), &more)
        };
        if self.0.len() > 1 { self.0.iter().map(table).collect() } else { Vec::new() }
    }

    /// Teleplot's lines.
    pub fn teleplot(&self) -> Vec<String> {
        let each = self.0.iter().flat_map(|line| {
            let number = line.line;
            let hertz = line.reading.frequency_hz.map(|hertz| format!(">line_{number}_hz:{hertz}"));
            hertz.into_iter().chain([format!(">line_{number}_phase_rad:{}", line.phase_rad)])
        });
        each.collect()
    }
}

/// A line on a device that has started.
pub fn boot(boot: &Boot) -> String {
    let settings = match boot.unfit {
        true => "settings that do not work here, so it is stopped",
        false => boot.origin.message(),
    };
    let last = match boot.last.kind {
        0 => String::new(),
        1 => {
            let [lr, cfsr] = boot.last.more;
            format!(", after a fault at {:#010x} (lr {lr:#010x}, CFSR {cfsr:#x})", boot.last.pc)
        }
        2 => format!(", after an unexpected interrupt {}", boot.last.more[0]),
        3 => ", after its external clock failed".into(),
        4 => format!(", after a panic in line {} of a crate for USB", boot.last.more[0]),
        5 => format!(", after a stack overflow at {:#010x}", boot.last.more[0]),
        other => format!(", after an end of kind {other}"),
    };
    let covered = match boot.clock {
        Clock::External => "",
        _ => "; sigma covers that clock",
    };
    format!(
        "started by {}{last}: program {:08x}, {} MHz from {}, blocks of {}, {settings}, {}{covered}",
        boot.causes.message(),
        boot.program,
        f64::from(boot.core_hz) / 1e6,
        boot.clock.message(),
        boot.n,
        match (boot.halted, boot.measuring) {
            (true, _) =>
                "stopped after three crashes within a minute each: picket watch PORT --start starts it",
            (_, true) => "measuring",
            _ => "stopped",
        },
    )
}

/// What a device follows as JSON, at this sample rate if it is known: a line for each track, and one for each target.
pub fn follow(follow: &Follow, rate_hz: Option<f64>) -> Vec<String> {
    let hertz = |cycles: f64| rate_hz.map(|rate| cycles * rate);
    let tracks = follow.tracks.iter().map(|track| {
        serde_json::json!({
            "track": track.number, "sequence": follow.sequence, "segment": segment(follow.segment),
            "locked": follow.locked, "state": track.state.name(), "misses": track.misses,
            "frequency_cycles_per_sample": track.frequency.cycles(),
            "sigma_cycles_per_sample": track.sigma, "rate_cycles_per_sample_per_block": track.rate,
            "frequency_hz": hertz(track.frequency.cycles()), "sigma_hz": hertz(track.sigma.into()),
            "verdict": track.verdict.name(),
        })
    });
    let targets = follow.targets.iter().map(|(number, target)| {
        serde_json::json!({
            "target": number, "sequence": follow.sequence,
            "range_m": target.range.to_num::<f64>(), "sigma_range_m": target.sigma_range,
            "velocity_mps": target.velocity.map(|velocity| velocity.to_num::<f64>()),
            "sigma_velocity_mps": target.sigma_velocity, "verdict": target.verdict.name(),
            "ambiguity": target.ambiguity.name(),
            "caution": target.caution(),
        })
    });
    tracks.chain(targets).map(|line| line.to_string()).collect()
}

/// What a record adds up, below its row.
pub(super) fn sum(sum: &Sum, style: Style) -> Vec<String> {
    let &Sum { sequence, blocks, ln_chance } = sum;
    let log10_chance = ln_chance / std::f32::consts::LN_10;
    match style {
        Style::Jsonl => {
            let line = serde_json::json!({
                "sum": true, "sequence": sequence, "blocks": blocks, "log10_chance": log10_chance,
            });
            vec![line.to_string()]
        }
        Style::Table => {
            let told = format!("noise alone shows such a line once in 10^{:.1}", -log10_chance);
            vec![format!("{:>9}  of {blocks} blocks: {told}", "sum")]
        }
        // Their columns are those of a tone.
        Style::Csv | Style::Teleplot => Vec::new(),
    }
}

/// A device's status as JSON.
pub fn status(status: &Status) -> String {
    let c = &status.counters;
    serde_json::json!({
        "status": true, "blocks": c.blocks, "overruns": c.overruns, "missed": c.missed, "late": c.late,
        "broken": c.broken, "spurious": c.spurious, "dma_errors": c.dma_errors, "adc_overruns": c.adc_overruns,
        "dropped": status.dropped, "refused": status.refused, "load_permille": status.load,
        "stack_bytes": status.stack, "longest_ticks": status.longest, "peak_permille": status.peak,
    })
    .to_string()
}
