//! The tones of a 16-bit mono wav file, a record at a time: `cargo run --example tone -- FILE`.

use picket_dsp::{Codes, Config, Format, Framer, Pipeline, Real};
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("say which wav file: 16 bits, one channel")?;
    let mut reader = hound::WavReader::open(path)?;
    let config = Config::new(reader.spec().sample_rate.into(), Codes::signed::<16>());
    let mut pipeline = Pipeline::<Real, 4096>::new(config.plan()?);
    let mut framer = Framer::<Real, 4096>::new(Format::signed::<16>());
    let samples = reader.samples::<i16>().collect::<Result<Vec<_>, _>>()?;
    framer.push(&samples, |stamp, samples| {
        let seconds = stamp.clock as f64 / config.rate_hz;
        println!("{seconds:8.3} s  {}", pipeline.block(stamp, samples).tone);
    });
    Ok(())
}
