//! The speed of what reflects a 24 GHz beam, from a 16-bit mono wav file of the mixer's output:
//! `cargo run --example doppler -- FILE`.

use picket_dsp::config::SPEED_OF_LIGHT;
use picket_dsp::{Codes, Config, Format, Framer, Mixing, Outcome, Pipeline, Real, Scene, Usable};
use std::error::Error;

const CARRIER_HZ: f64 = 24e9;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("say which wav file: 16 bits, one channel")?;
    let mut reader = hound::WavReader::open(path)?;
    let config = Config {
        // Below 300 Hz a radar sees its own supply, above 3 kHz no vehicle.
        band_hz: Some((300.0, 3000.0)),
        scene: Scene::Doppler {
            wavelength_m: SPEED_OF_LIGHT / CARRIER_HZ,
            angle_rad: 0.0,
            mixing: Mixing::RxConjTx,
        },
        ..Config::new(reader.spec().sample_rate.into(), Codes::signed::<16>())
    };
    let mut pipeline = Pipeline::<Real, 4096>::new(config.plan()?);
    let mut framer = Framer::<Real, 4096>::new(Format::signed::<16>()).with_hop(1024);
    let samples = reader.samples::<i16>().collect::<Result<Vec<_>, _>>()?;
    framer.push(&samples, |stamp, samples| {
        let measurement = pipeline.block(stamp, samples);
        if let Outcome::Velocity(speed) = measurement.result
            && speed.verdict.usable() <= Usable::WithinSigma
        {
            let seconds = stamp.clock as f64 / config.rate_hz;
            let (metres, sigma) = (speed.velocity.to_num::<f64>(), speed.sigma);
            println!("{seconds:8.3} s  {metres:8.3} ± {sigma:.3} m/s  {}", speed.verdict);
        }
    });
    Ok(())
}
