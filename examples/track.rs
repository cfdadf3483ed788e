//! Tones followed from record to record in a 16-bit mono wav file: `cargo run --example track -- FILE`.

use picket_dsp::{Codes, Config, Following, Format, Framer, Real, Segment, Tracker};
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("say which wav file: 16 bits, one channel")?;
    let mut reader = hound::WavReader::open(path)?;
    let config = Config {
        following: Following { most: 2, ..Following::default() },
        ..Config::new(reader.spec().sample_rate.into(), Codes::signed::<16>())
    };
    let mut tracker = Tracker::<Real, 4096>::new(config.plan()?);
    let mut framer = Framer::<Real, 4096>::new(Format::signed::<16>());
    let samples = reader.samples::<i16>().collect::<Result<Vec<_>, _>>()?;
    framer.push(&samples, |stamp, samples| {
        tracker.block(stamp, samples);
        let seconds = stamp.clock as f64 / config.rate_hz;
        for track in tracker.tracks(Segment::Continuous) {
            println!("{seconds:8.3} s  track {}: {}", track.number, track.tone);
        }
    });
    Ok(())
}
