//! Cycles of every stage, modelled from the program as it was executed.

use super::cycles::Clock;
use super::trace::{Section, Trace};
use super::{Core, How, SEED, config, corpus, median};
use crate::emulator::{Capture, RunError};
use picket_dsp::acquire::sample::{Real, Record};
use picket_wire::capture::Header;
use std::collections::HashMap;
use std::path::Path;
use std::time::Duration;

/// Every so manieth record of the corpus is followed: of each kind some.
const STRIDE: usize = 4;
/// Instructions that the compiler may put between the clock's readings and the marks.
const BESIDE: f64 = 32.0;
pub(super) const LIMIT: Duration = Duration::from_secs(900);

/// What an image executed.
#[derive(Clone, Debug)]
pub struct Model {
    /// Whether each record has a sample at a rail.
    clipped: Vec<bool>,
    stages: Stages,
}

/// What was executed of each stage, record by record.
pub(super) type Stages = HashMap<String, Vec<Section>>;

impl Model {
    /// Follows the image through a part of the records that [`super::count`] takes; `None` for a core whose timing is not published.
    ///
    /// # Errors
    /// The emulator failed, or its log holds other instructions than its clock counted.
    pub fn of(core: &Core, image: &Path, n: usize, how: How) -> Result<Option<Self>, RunError> {
        let records: Vec<_> = corpus::corpus(n, SEED).into_iter().step_by(STRIDE).collect();
        let samples: Vec<_> = records.iter().map(|record| record.samples.as_slice()).collect();
        let clipped = records.iter().map(|record| record.clipped).collect();
        let stages = stages::<Real>(core, image, n, how, &samples)?;
        Ok(stages.map(|stages| Self { clipped, stages }))
    }

    /// The cycles of a stage: the median over the records that are not clipped.
    pub fn median(&self, stage: &str) -> Option<u64> {
        let sections = self.stages.get(stage).map_or(&[][..], Vec::as_slice);
        let whole = sections.iter().zip(&self.clipped).filter(|(_, clipped)| !**clipped);
        median(whole.map(|(section, _)| section.cycles))
    }
}

/// The cycles of one record's measurement; `None` for a core whose timing is not published.
///
/// # Errors
/// The errors of [`Model::of`].
pub fn measurement<R: Record>(
    core: &Core,
    image: &Path,
    n: usize,
    how: How,
    samples: &[R::Sample],
) -> Result<Option<u64>, RunError> {
    let stages = stages::<R>(core, image, n, how, &[samples])?;
    Ok(stages.and_then(|stages| Some(stages.get("measurement")?.first()?.cycles)))
}

/// What the image executes of each stage, record by record; `None` for a core whose timing is not published.
pub(super) fn stages<R: Record>(
    core: &Core,
    image: &Path,
    n: usize,
    how: How,
    records: &[&[R::Sample]],
) -> Result<Option<Stages>, RunError> {
    let Some(clock) = Clock::of(core) else { return Ok(None) };
    let header = Header::from_config::<R>(config(core, how), n as u32, records.len() as u32);
    let mut capture = Capture::create(&Header { period_us: 0, ..header })?;
    for record in records {
        capture.push::<R>(record)?;
    }
    let mut trace = Trace::new(clock);
    let outcome = capture.trace(core.machine, image, LIMIT, |line| trace.line(line))?;
    let mut stages = Stages::new();
    let figures = outcome.messages.lines().filter_map(|line| line.split_once('='));
    // Before each stage, the image reads its clock around nothing.
    for ((name, ticks), [nothing, stage]) in figures.zip(trace.sections.as_chunks().0) {
        let section = Section {
            instructions: stage.instructions.saturating_sub(nothing.instructions),
            cycles: stage.cycles.saturating_sub(nothing.cycles),
        };
        let counted = ticks.parse().unwrap_or(0.0) * core.machine.instructions_per_tick();
        if (section.instructions as f64 - counted).abs() > BESIDE {
            let (found, of) = (section.instructions, counted);
            return Err(RunError::Emulator(format!(
                "its log has {found} instructions of {name}, its clock {of}"
            )));
        }
        stages.entry(name.into()).or_default().push(section);
    }
    Ok(Some(stages))
}
