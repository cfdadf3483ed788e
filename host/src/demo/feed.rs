//! Records of scenes, and the images of the emulated board that measure them.

use super::options::Options;
use super::{DemoError, said};
use crate::device::{Listener, Said};
use crate::emulator::{Capture, Machine};
use crate::progress::{self, ProgressBar};
use crate::scenario::record;
use crate::simulate::Kind;
use crate::toolchain::{Firmware, Need, Profile, have, io_error};
use picket_dsp::acquire::sample::{Record, Stamp};
use picket_dsp::config::Config;
use picket_simulator::Scene;
use picket_wire::capture::Header;
use std::fs;
use std::time::Duration;

/// Samples in a block.
pub(super) const N: usize = 1024;

/// All records of a scene, each with its stamp.
pub(super) fn records<R: Record>(
    scene: &Scene,
    config: &Config,
) -> Result<impl Iterator<Item = (Stamp, [R::Sample; N])> + use<R>, DemoError>
where
    R::Sample: Copy,
{
    let mut run = scene.run(0).map_err(said)?;
    let segments = config.scene.segments();
    Ok((0..scene.records(N)).filter_map(move |index| {
        let segment = segments.get(index % segments.len().max(1)).copied().unwrap_or_default();
        let stamp = Stamp { sequence: index as u32, segment, ..Stamp::default() };
        Some((stamp, *record::<R>(&mut run, index, N).as_array()?))
    }))
}

/// The board that has DMA.
const BOARD: Machine = Machine::An505;

/// No run takes longer.
const LIMIT: Duration = Duration::from_secs(3600);

/// Plays blocks of `n` samples to an image of the emulated board; `take` receives all messages of the image. Returns what was lost on the way.
pub(super) fn play<R: Kind>(
    bin: &'static str,
    (config, n): (Config, usize),
    blocks: impl ExactSizeIterator<Item = Result<Vec<R::Sample>, DemoError>>,
    options: &Options,
    mut take: impl FnMut(&ProgressBar, Said),
) -> Result<Listener, DemoError> {
    let count = u32::try_from(blocks.len()).map_err(|_| said("too many blocks"))?;
    let header = Header::from_config::<R>(config, n as u32, count);
    let mut capture = Capture::create(&header).map_err(said)?;
    for block in blocks {
        capture.push::<R>(&block?).map_err(said)?;
    }
    have(&[Need::Core(BOARD.target()), Need::Emulator]).map_err(said)?;
    let features: &[&str] = if options.log.is_some() { &["mps2", "log"] } else { &["mps2"] };
    let image = Firmware { bin, target: BOARD.target(), features, profile: Profile::Release };
    let image = image.build().map_err(said)?;
    let bar = progress::bar(count.into(), "blocks");
    let mut listener = Listener::default();
    let outcome = capture.run(BOARD, &image, LIMIT, |piece| {
        for said in listener.read(piece) {
            bar.inc(matches!(said, Said::Telemetry(_)).into());
            take(&bar, said);
        }
    });
    let outcome = outcome.map_err(said)?;
    bar.finish_and_clear();
    if let Some(file) = &options.log {
        fs::write(file, &outcome.log).map_err(io_error(file.display())).map_err(said)?;
        eprintln!("the log: defmt-print -e {} <{}", image.display(), file.display());
    }
    Ok(listener)
}
