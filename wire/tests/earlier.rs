//! Settings as programs before version 3 sent and saved them: the bytes were written by such a program.

use picket_dsp::acquire::codes::Codes;
use picket_dsp::carrier::Carrier;
use picket_dsp::config::{Config, Scene};
use picket_dsp::solve::chirp::{Mixing, Shape};
use picket_dsp::solve::equations::Chirp;
use picket_wire::command::{Answer, Command, Refusal, Request};
use picket_wire::frame::{Frame, Kind};
use picket_wire::settings::{Calibration, Drive, Settings};
use picket_wire::settings_error::SettingsError;

const TONE: [&str; 4] = [
    "0100000100000000010000000000000000000000000000000000000000000000",
    "00000000000000000000803f00130000100000000000ff0f0004000000000000",
    "80841e4100000000000000000000000000000000000000000000000000000000",
    "0000000000000000000000008dedb5a0f7c6b03ecdcc4c3d0000000000000040",
];

const DOPPLER: [&str; 4] = [
    "0100000100000000010000000000000000000000000000000000000000000000",
    "00000000000000000000803f03130100100000000000ff0f0004000000000000",
    "80841e410000000000409f4000000000004cfd409a9999999999893f33333333",
    "3333d33f00000000000000008dedb5a0f7c6b03ecdcc4c3d0000000000000040",
];

const CHIRP: [&str; 4] = [
    "0102020100004000030000000000000000000000d0129341000000c00b5a1642",
    "000048c19a99993ec520803f03130201100000000000ff0f0004000000000000",
    "80841e410000000000409f4000000000004cfd409a9999999999893f00000000",
    "84d7a741664cc11a67d3613f8dedb5a0f7c6b03ecdcc4c3d0000000000000040",
];

fn bytes(lines: [&str; 4]) -> Vec<u8> {
    let text = lines.concat();
    let byte = |at| u8::from_str_radix(&text[at..at + 2], 16).unwrap();
    (0..text.len()).step_by(2).map(byte).collect()
}

/// The settings of the three, as they are read now.
fn settings() -> [Settings; 3] {
    let config = Config {
        rate_hz: 500e3,
        band_hz: Some((2e3, 120e3)),
        ..Config::new(500e3, Codes::unsigned::<12>())
    };
    let chirp = Chirp {
        shape: Shape::Triangle,
        wavelength_m: 0.0125,
        bandwidth_hz: 200e6,
        duration_s: 0.002176,
        guard_s: 64.0 / 500e3,
        mixing: Mixing::TxConjRx,
        sweep_curvature: 0.0,
    };
    let doppler = Scene::Doppler { wavelength_m: 0.0125, angle_rad: 0.3, mixing: Mixing::RxConjTx };
    [
        Settings::default(),
        Settings { iq: true, config: Config { scene: doppler, ..config }, ..Settings::default() },
        Settings {
            iq: true,
            config: Config { scene: Scene::Chirp(chirp), ..config },
            guard: 64,
            drive: Drive::Adf4159 { reference_hz: 80e6, start_hz: 24e9, divider: 2 },
            report_every: 3,
            calibration: Calibration { clock_ppm: -12.5, range_offset_m: 0.3, range_slope: 1.001 },
            ..Settings::default()
        },
    ]
}

/// Earlier programs read what this one sends, as long as it means no more than they know.
#[test]
fn settings_are_the_bytes_of_earlier_programs() {
    for (settings, lines) in settings().into_iter().zip([TONE, DOPPLER, CHIRP]) {
        let earlier = bytes(lines);
        assert_eq!(Settings::from_bytes(&earlier), Ok((settings, 1024)));
        assert_eq!(settings.to_bytes(1024)[..], earlier[..]);
        // As the words that flash keeps: the further ones are 0.
        let padded = [&earlier[..], &[0; Settings::BYTES - Settings::SHORT]].concat();
        assert_eq!(Settings::from_bytes(&padded), Ok((settings, 1024)));
    }
}

/// A carrier of its own width goes with any scene, and with a curved sweep.
#[test]
fn a_width_is_of_another_version() {
    let [tone, doppler, mut chirp] = settings();
    if let Scene::Chirp(chirp) = &mut chirp.config.scene {
        chirp.sweep_curvature = 0.01;
    }
    for mut settings in [tone, doppler, chirp] {
        settings.config.carrier = Carrier { linewidth_hz: 120.5, envelope_hz: 0.1 };
        let bytes = settings.to_bytes(1024);
        assert_eq!((bytes[0], bytes.len()), (4, Settings::WIDE));
        assert_eq!(Settings::from_bytes(&bytes), Ok((settings, 1024)));
        assert!(Settings::from_bytes(&bytes[..Settings::LONG]).is_err());
    }
}

/// What an earlier program would take for something else is of another version.
#[test]
fn the_other_mixing_and_a_curved_sweep_are_of_another_version() {
    let [tone, mut doppler, mut chirp] = settings();
    let mut curved = chirp;
    if let Scene::Doppler { mixing, .. } = &mut doppler.config.scene {
        *mixing = Mixing::TxConjRx;
    }
    if let Scene::Chirp(chirp) = &mut chirp.config.scene {
        chirp.mixing = Mixing::RxConjTx;
    }
    if let Scene::Chirp(curved) = &mut curved.config.scene {
        curved.sweep_curvature = -0.02;
    }
    for settings in [doppler, chirp, curved] {
        let bytes = settings.to_bytes(1024);
        assert_eq!((bytes[0], bytes.len()), (3, Settings::LONG));
        assert_eq!(Settings::from_bytes(&bytes), Ok((settings, 1024)));
        let short = Settings::from_bytes(&bytes[..Settings::SHORT]);
        assert!(matches!(short, Err(SettingsError::Encoding(_))));
        let command = Command::SetSettings(settings, 1024);
        let payload = [&[7, 5][..], &bytes].concat().as_slice().try_into().unwrap();
        let request = Request::from_frame(&Frame { kind: Kind::Command, payload });
        assert_eq!(request, Ok(Request { tag: 7, command }));
    }
    for length in [0, 127, 129, 135, 137, 143] {
        let body = [&tone.to_bytes(1024)[..], &[0; 16]].concat();
        let payload = [&[7, 5], &body[..length]].concat().as_slice().try_into().unwrap();
        let request = Request::from_frame(&Frame { kind: Kind::Command, payload });
        assert_eq!(request, Err((Answer { tag: 7, command: 5 }, Refusal::Unknown)), "{length}");
    }
}
