//! More of a block than its answer: all its tones, each with its sigma and its phase, and every test behind its verdict. And what a
//! rate, a length and a level give, before there is any block.
//!
//! The page's own module measures one tone of a block. This one is loaded when somebody asks for more, and takes up what the
//! other has measured.

#[path = "../../../host/measure/src/explain/causes.rs"]
pub mod causes;
pub mod flow;
#[path = "../../src/record.rs"]
mod record;
#[path = "../../src/row.rs"]
pub mod row;
#[path = "../../../host/measure/src/explain/rows.rs"]
pub mod rows;
#[path = "../../../host/src/design/sheet.rs"]
pub mod sheet;

use flow::{FRINGE_M, Flow, Found, Sliders};
use picket_dsp::Validation;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::kind::{ForRecord, for_record};
use picket_dsp::acquire::sample::{Iq, Real, Record, Segment, Stamp};
use picket_dsp::carrier::Width;
use picket_dsp::methods::registry::Method;
use picket_dsp::pipeline::Pipeline;
use picket_dsp::plan::{self, Plan};
use picket_dsp::spectrum::Spectrum;
use picket_dsp::spectrum::neighbourhood::has_ring;
use picket_dsp::spectrum::peak::Band;
use picket_dsp::spectrum::view::View;
use picket_dsp::tone::arithmetic::Arithmetic;
use picket_dsp::tone::evidence::Evidence;
use picket_dsp::tone::fit::Reach;
use picket_dsp::tone::frequency::Frequency;
use picket_dsp::tone::lines::lines;
use picket_dsp::tone::options::Options;
use picket_dsp::tone::threshold::{FALSE_ALARM, Threshold};
use picket_dsp::tone::{Tone, Verdict, Verdicts};
use record::record;
use rows::{Notes, Row};
use sheet::{Design, Question};
use std::cell::RefCell;

/// What the page says of a block, as numbers: the samples' number, 1 for I/Q, the bits of a code (those from 0 as a negative number), the
/// rate in Hz, the band's first and last bin, the count of clipped samples, 1 behind a gap, then the block's tone: frequency and
/// sigma in cycles per sample, signal-to-noise ratio, amplitude, the verdict's number, the bits of what applies besides; then the
/// segment of the waveform.
pub type Terms = [f64; 15];

/// The tones of a block, at most `most`, the strongest first: a [`row`](row::row) each. None where they cannot work.
pub fn tones(terms: &Terms, samples: &[[i16; 2]], most: usize) -> Vec<f64> {
    tones_of(terms, samples, most).unwrap_or_default()
}

fn tones_of(terms: &Terms, samples: &[[i16; 2]], most: usize) -> Option<Vec<f64>> {
    let &[.., clipped, _, frequency, sigma, snr, amplitude, verdict, also, _] = terms;
    let tone = Tone {
        frequency: Frequency::from_bins(0, frequency, 1)?,
        sigma: sigma as f32,
        snr: snr as f32,
        amplitude: amplitude as f32,
        verdict: Verdict::from_u8(verdict as u8)?,
        also: Verdicts::from_bits(also as u8),
        ..Tone::default()
    };
    let (stamp, plan) = (stamp(terms)?, plan(terms)?);
    let rows = |view: &View| {
        let found = lines(view, &tone, plan.band, clipped as u32, &stamp, &plan.options, most);
        found.iter().flat_map(|tone| row::row(tone, plan.rate_hz)).collect()
    };
    let record = record(plan.iq, samples);
    for_record(plan.iq, plan.n as usize, Transformed { record, codes: plan.codes, rows: &rows })?
}

/// The rows of a record's spectrum.
struct Transformed<'a> {
    record: Vec<[i16; 2]>,
    codes: Codes,
    rows: &'a dyn Fn(&View) -> Vec<f64>,
}

impl ForRecord for Transformed<'_> {
    type Output = Option<Vec<f64>>;

    fn run<R: Record, const N: usize>(self) -> Self::Output {
        let mut spectrum = Box::new(Spectrum::<R, N>::new());
        spectrum.transform(R::samples(&self.record).try_into().ok()?, self.codes);
        Some((self.rows)(&spectrum.view()))
    }
}

/// The verdict on a block, and every test behind it.
pub fn explained(terms: &Terms, samples: &[[i16; 2]]) -> Option<(Verdict, Vec<Row>)> {
    let (stamp, plan, notes) = (stamp(terms)?, plan(terms)?, Notes::default());
    let (iq, n, record) = (plan.iq, plan.n as usize, record(plan.iq, samples));
    let (tone, evidence) = for_record(iq, n, Explained { stamp, plan, record, notes: &notes })??;
    let joint = notes.joint();
    let mut rows = rows::from_notes(&notes.taken().0);
    rows.extend(joint.iter().flat_map(causes::rows));
    rows.extend(rows::from_evidence(&evidence, n));
    Some((tone.verdict, rows))
}

/// The tests of a record.
struct Explained<'a> {
    stamp: Stamp,
    plan: plan::Terms,
    record: Vec<[i16; 2]>,
    notes: &'a Notes,
}

impl ForRecord for Explained<'_> {
    type Output = Option<(Tone, Evidence)>;

    fn run<R: Record, const N: usize>(self) -> Self::Output {
        let mut pipeline = Box::new(Pipeline::<R, N>::new(Plan::from_terms(self.plan).ok()?));
        let samples = R::samples(&self.record).try_into().ok()?;
        let (_, tone, evidence) = pipeline.explain(&self.stamp, samples, self.notes);
        Some((tone, evidence))
    }
}

/// The plan for blocks as `terms` tell of them. A whole configuration would bring its solvers along, and their size.
fn plan(terms: &Terms) -> Option<plan::Terms> {
    let &[n, iq, bits, rate_hz, low, high, ..] = terms;
    let (n, iq) = (n as u32, iq != 0.0);
    let codes = Codes::from_bits(bits > 0.0, bits.abs() as u32)?;
    let band = Band::new(low as i32, high as i32);
    let method = Method::default();
    let threshold = Threshold::new(band.width(), FALSE_ALARM);
    let options = Options {
        method: if iq { method.from_kind::<Iq>() } else { method.from_kind::<Real>() },
        reach: Reach::default(),
        arithmetic: Arithmetic::default(),
        threshold: if has_ring(n as usize, iq) { threshold.with_another() } else { threshold },
        effort: picket_dsp::Effort::default(),
        width: Width::NONE,
    };
    let idle = *Plan::<Real, { flow::N }>::IDLE;
    Some(plan::Terms { n, iq, rate_hz, codes, band, options, ..idle })
}

fn stamp(terms: &Terms) -> Option<Stamp> {
    let &[.., gap, _, _, _, _, _, _, segment] = terms;
    let segment = Segment::from_u8(segment as u8)?;
    Some(Stamp { segment, gap: gap != 0.0, ..Stamp::default() })
}

/// What goes in and what comes out.
#[derive(Default)]
struct Exchange {
    terms: Terms,
    samples: Vec<[i16; 2]>,
    numbers: Vec<f64>,
    text: Vec<u8>,
    flow: Option<Flow>,
}

thread_local! {
    static EXCHANGE: RefCell<Exchange> = RefCell::default();
}

/// Room for the [`Terms`]: its address.
#[unsafe(no_mangle)]
pub extern "C" fn tones_terms() -> *mut f64 {
    EXCHANGE.with_borrow_mut(|exchange| exchange.terms.as_mut_ptr())
}

/// Reserves room for this many samples of two codes each; returns its address.
#[unsafe(no_mangle)]
pub extern "C" fn tones_samples(count: usize) -> *mut i16 {
    EXCHANGE.with_borrow_mut(|exchange| {
        exchange.samples.clear();
        exchange.samples.resize(count, [0; 2]);
        exchange.samples.as_mut_ptr().cast()
    })
}

/// Finds at most this many tones in those samples; returns how many numbers it leaves.
#[unsafe(no_mangle)]
pub extern "C" fn tones_find(most: usize) -> usize {
    EXCHANGE.with_borrow_mut(|exchange| {
        exchange.numbers = tones(&exchange.terms, &exchange.samples, most);
        exchange.numbers.len()
    })
}

/// Explains the verdict on those samples: the text has the verdict, and a line for each test with its name, what is compared, the fit, the unit,
/// the outcome and what followed; its value and its limit are numbers. Gives how many numbers it leaves: none where it cannot work.
#[unsafe(no_mangle)]
pub extern "C" fn tones_explain() -> usize {
    EXCHANGE.with_borrow_mut(|exchange| {
        let explained = explained(&exchange.terms, &exchange.samples);
        let (verdict, rows) = explained.unwrap_or_default();
        let number = |x: Option<f64>| x.unwrap_or(f64::NAN);
        exchange.numbers = rows.iter().flat_map(|row| [row.value, row.limit]).map(number).collect();
        exchange.text = verdict.name().into();
        for row in &rows {
            let fit = row.fit.unwrap_or_default();
            let cells = [row.test, row.about, fit, row.unit, row.outcome(), &row.followed];
            exchange.text.push(b'\n');
            exchange.text.extend(cells.join("\t").bytes());
        }
        exchange.numbers.len()
    })
}

/// Answers the question that the first eleven of the terms are: wavelength in m, rate in Hz, N, signal-to-noise ratio in dB, 1 for I/Q, bandwidth in Hz
/// and duration in s of a ramp, the fastest and the farthest target in m/s and m, the wanted sigmas in m/s and m; 0 where something is left open.
/// The text has the chosen row's index, the settings, the table's head, its rows, and sentences on all of them: lines, cells apart by tabs. Of
/// each row these are numbers: N, the block's duration in s, bin and sigma in m/s, and both in m, NaN without a ramp. Gives the number of rows;
/// where it is 0 the text says why.
#[unsafe(no_mangle)]
pub extern "C" fn tones_design() -> usize {
    EXCHANGE.with_borrow_mut(|exchange| {
        let design = match Design::of(question(&exchange.terms)) {
            Ok(design) => design,
            Err(trouble) => {
                exchange.text = trouble.to_string().into_bytes();
                return 0;
            }
        };
        let number = |x: Option<f64>| x.unwrap_or(f64::NAN);
        let numbers = design.rows.iter().flat_map(|row| {
            let range = [row.resolution_m, row.sigma_m].map(number);
            [row.n as f64, row.block_s, row.resolution_mps, row.sigma_mps, range[0], range[1]]
        });
        exchange.numbers = numbers.collect();
        let chosen = design.chosen.map(|index| index.to_string()).unwrap_or_default();
        let mut lines =
            vec![chosen, design.settings().unwrap_or_default(), design.head().join("\t")];
        lines.extend(design.rows.iter().map(|row| row.cells().join("\t")));
        lines.extend(design.sentences());
        exchange.text = lines.join("\n").into_bytes();
        design.rows.len()
    })
}

/// What is asked, see [`tones_design`].
pub fn question(terms: &Terms) -> Question {
    let &[wavelength_m, rate, n, snr_db, iq, bandwidth, chirp, velocity, range, mps, m, ..] = terms;
    let given = |x: f64| (x > 0.0).then_some(x);
    Question {
        wavelength_m,
        rate_hz: given(rate),
        n: given(n).map(|n| n as usize),
        snr_db,
        iq: iq != 0.0,
        chirp: given(bandwidth).zip(given(chirp)),
        velocity_mps: given(velocity),
        range_m: given(range),
        sigma_mps: given(mps),
        sigma_m: given(m),
        ..Question::default()
    }
}

/// The terms of a flow's processor: samples of 12 bits, signed, and the whole band except for its edges.
const FLOW: Terms = {
    let (n, last) = (flow::N as f64, flow::N as f64 / 2.0 - 1.0);
    [n, 0.0, 12.0, flow::RATE_HZ, 1.0, last, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
};

fn flow_plan() -> Option<Plan<Real, { flow::N }>> {
    Plan::from_terms(plan(&FLOW)?).ok()
}

/// Begins a flow of particles, see [`flow`].
#[unsafe(no_mangle)]
pub extern "C" fn tones_flow_begin(seed: u32) {
    EXCHANGE.with_borrow_mut(|exchange| {
        exchange.flow = flow_plan().map(|plan| Flow::new(plan, seed.into()))
    });
}

/// Lets it flow for this many samples, by the first five of the terms: the mean speed in m/s, its turbulence as a share, particles per second,
/// signal-to-noise ratio in dB and level in dB of full scale. The text has the samples around the last burst as floats of 32 bits. Of each burst these are
/// numbers: arrival in s, frequency in Hz, its sigma, signal-to-noise ratio in dB, amplitude in codes, transit time in s, verdict, speed in m/s, its sigma,
/// the truth, and the validation's number. Gives the number of bursts.
#[unsafe(no_mangle)]
pub extern "C" fn tones_flow(samples: usize) -> usize {
    EXCHANGE.with_borrow_mut(|exchange| {
        let &[mean_mps, turbulence, particles_hz, snr_db, level_db, ..] = &exchange.terms;
        let sliders = Sliders { mean_mps, turbulence, particles_hz, snr_db, level_db };
        let Some(flow) = &mut exchange.flow else { return 0 };
        let found = flow.advance(&sliders, samples.min(1 << 15));
        let around = found.last().map(|found| flow.around(&found.burst)).unwrap_or_default();
        exchange.text = around.into_iter().flat_map(f32::to_le_bytes).collect();
        let numbers = found.iter().flat_map(|Found { burst, truth_mps }| {
            let (tone, speed) = (&burst.tone, FRINGE_M);
            let (hertz, sigma) = (tone.hertz(), tone.sigma_hertz());
            [
                burst.arrival / flow::RATE_HZ,
                hertz,
                sigma,
                tone.snr_db().into(),
                tone.amplitude.into(),
                8f64.sqrt() * f64::from(burst.deviation) / flow::RATE_HZ,
                f64::from(tone.verdict as u8),
                hertz * speed,
                sigma * speed,
                *truth_mps,
                f64::from(burst.validation as u8),
            ]
        });
        exchange.numbers = numbers.collect();
        found.len()
    })
}

/// Leaves the names of validations as text, a line each, in the order of their numbers.
#[unsafe(no_mangle)]
pub extern "C" fn tones_validations() {
    EXCHANGE.with_borrow_mut(|exchange| {
        let mut all = Validation::ALL;
        all.sort_by_key(|validation| *validation as u8);
        exchange.text = all.map(Validation::name).join("\n").into_bytes();
    });
}

/// The text that it left: its address.
#[unsafe(no_mangle)]
pub extern "C" fn tones_text() -> *const u8 {
    EXCHANGE.with_borrow(|exchange| exchange.text.as_ptr())
}

/// How many bytes that has.
#[unsafe(no_mangle)]
pub extern "C" fn tones_text_length() -> usize {
    EXCHANGE.with_borrow(|exchange| exchange.text.len())
}

/// Those numbers: their address.
#[unsafe(no_mangle)]
pub extern "C" fn tones_numbers() -> *const f64 {
    EXCHANGE.with_borrow(|exchange| exchange.numbers.as_ptr())
}
