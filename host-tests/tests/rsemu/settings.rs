//! Settings that the tests measure by.

use picket_dsp::config::{Config, Scene};
use picket_dsp::solve::chirp::Shape;
use picket_dsp::solve::equations::Chirp;
use picket_firmware::nucleo_f446re::N;
use picket_firmware::nucleo_f446re::words::Words;
use picket_firmware::nucleo_f446re::words::clock::{Source, Speed, Tree};
use picket_wire::settings::{Drive, Settings};

pub fn tone(rate_hz: f64) -> Settings {
    let settings = Settings::default();
    Settings { config: Config { rate_hz, ..settings.config }, ..settings }
}

pub const DAC: Drive = Drive::Dac { low: 400, high: 3600 };

pub fn chirp(rate_hz: f64, shape: Shape, guard: u16, drive: Drive) -> Settings {
    let scene = Scene::Chirp(Chirp {
        shape,
        wavelength_m: 0.0125,
        bandwidth_hz: 200e6,
        duration_s: 0.0,
        ..Chirp::default()
    });
    let settings = tone(rate_hz);
    Settings { config: Config { scene, ..settings.config }, guard, drive, ..settings }
}

pub fn words(settings: &Settings) -> Words {
    let speed = Speed::from_mhz(settings.core_mhz).unwrap();
    Words::plan::<N>(settings, &Tree::new(speed, Source::HsePll)).unwrap().1
}
