//! Commands and answers over a bad line: what arrives is what was sent, and nothing else is followed.

use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::frontend::Counters;
use picket_dsp::config::{Config, Scene};
use picket_dsp::solve::chirp::{Mixing, Shape};
use picket_dsp::solve::equations::Chirp;
use picket_firmware::nucleo_f446re::words::guard::causes;
use picket_wire::boot::{Boot, Causes, Clock, LastEnd, Name, Origin};
use picket_wire::command::{Answer, Command, Refusal, Request};
use picket_wire::frame::{self, Frame, Kind, Reader};
use picket_wire::settings::{Calibration, Drive, Settings};
use picket_wire::settings_error::SettingsError;
use picket_wire::status::{Raw, Status};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn settings(rng: &mut impl RngExt) -> Settings {
    let (guard, rate_hz) = (rng.random::<u16>(), rng.random::<f64>());
    let mixing = Mixing::ALL[rng.random_range(0..2)];
    let scene = match rng.random_range(0..3) {
        0 => Scene::Tone,
        1 => Scene::Doppler { wavelength_m: rng.random(), angle_rad: rng.random(), mixing },
        _ => Scene::Chirp(Chirp {
            shape: Shape::Triangle,
            wavelength_m: rng.random(),
            bandwidth_hz: rng.random(),
            duration_s: rng.random(),
            // It follows from the guard's samples.
            guard_s: f64::from(guard) / rate_hz,
            mixing,
            sweep_curvature: if rng.random() { rng.random() } else { 0.0 },
        }),
    };
    let config = Config {
        rate_hz,
        codes: Codes::unsigned::<12>(),
        scene,
        ..Config::new(1.0, Codes::signed::<12>())
    };
    let drive = match rng.random_range(0..4) {
        0 => Drive::Off,
        1 => Drive::Dac { low: rng.random(), high: rng.random() },
        2 => Drive::Adf4159 {
            reference_hz: rng.random(),
            start_hz: rng.random(),
            divider: rng.random(),
        },
        _ => Drive::External,
    };
    let calibration = Calibration { clock_ppm: rng.random(), ..Calibration::default() };
    let (report_every, slots) = (rng.random(), rng.random());
    Settings {
        config,
        iq: rng.random(),
        guard,
        drive,
        report_every,
        slots,
        calibration,
        ..Settings::default()
    }
}

fn request(rng: &mut impl RngExt) -> Request {
    let command = match rng.random_range(0..11) {
        0 => Command::Identify,
        1 => Command::Start,
        2 => Command::Stop,
        3 => Command::GetSettings,
        4 => Command::SetSettings(settings(rng), 1 << rng.random_range(6..13)),
        5 => Command::Save,
        6 => Command::Capture(rng.random()),
        7 => Command::Reset,
        8 => Command::Status,
        9 => Command::SelfTest,
        _ => Command::Reboot,
    };
    Request { tag: rng.random(), command }
}

fn frames(bytes: &[u8]) -> Vec<Frame> {
    let mut reader = Reader::default();
    bytes.iter().filter_map(|&byte| reader.push(byte)?.ok()).collect()
}

fn only(bytes: &[u8]) -> Frame {
    let frames = frames(bytes);
    let [frame] = &frames[..] else { panic!("{} frames", frames.len()) };
    frame.clone()
}

#[test]
fn requests_come_back_as_they_were() {
    println!("seed 21");
    let mut rng = ChaCha8Rng::seed_from_u64(21);
    for _ in 0..10_000 {
        let sent = request(&mut rng);
        assert_eq!(Request::from_frame(&only(&sent.to_frame())), Ok(sent));
    }
}

#[test]
fn answers_come_back_as_they_were() {
    let answer = Answer { tag: 7, command: 5 };
    let body = [9; 150];
    assert_eq!(Answer::from_frame(&only(&answer.reply(&body))), Some((answer, Ok(&body[..]))));
    let refusals = [
        Refusal::Damaged,
        Refusal::Unknown,
        Refusal::Settings(SettingsError::Drive.code()),
        Refusal::Flash,
        Refusal::Stopped,
    ];
    for refusal in refusals {
        let frame = only(&answer.refusal(refusal));
        assert_eq!(Answer::from_frame(&frame), Some((answer, Err(refusal))));
        assert!(!refusal.to_string().contains('\n'));
    }
    assert!(answer.reply(&[0; 300]).is_empty(), "what is too long is not cut");
}

#[test]
fn boot_status_and_samples_come_back_as_they_were() {
    println!("seed 22");
    let mut rng = ChaCha8Rng::seed_from_u64(22);
    for _ in 0..1000 {
        let boot = Boot {
            board: Name::new("a board"),
            clock: Clock::from_u8(rng.random_range(0..3)).unwrap(),
            causes: Causes(rng.random()),
            measuring: rng.random(),
            origin: [Origin::Host, Origin::Flash, Origin::Default, Origin::Unreadable]
                [rng.random_range(0..4)],
            unfit: rng.random(),
            halted: rng.random(),
            program: rng.random(),
            settings: rng.random(),
            n: rng.random(),
            core_hz: rng.random(),
            last: LastEnd { kind: rng.random(), pc: rng.random(), more: rng.random() },
        };
        assert_eq!(Boot::from_frame(&only(&boot.to_frame())), Ok(boot));
        let [blocks, overruns, missed, late, broken, spurious, dma_errors, adc_overruns] =
            rng.random();
        let counters =
            Counters { blocks, overruns, missed, late, broken, spurious, dma_errors, adc_overruns };
        let [dropped, refused, load, stack, longest, peak] = rng.random();
        let status = Status { counters, dropped, refused, load, stack, longest, peak };
        assert_eq!(Status::from_frame(&only(&status.to_frame())), Ok(status));
        let mut bytes = vec![0; rng.random_range(0..=Raw::PIECE)];
        rng.fill_bytes(&mut bytes);
        let bytes = heapless::Vec::from_slice(&bytes).unwrap();
        let raw = Raw { sequence: rng.random(), offset: rng.random(), bytes };
        assert_eq!(Raw::from_frame(&only(&raw.to_frame())), Some(raw));
    }
}

#[test]
fn a_hundred_thousand_damaged_commands_and_none_followed() {
    println!("seed 23");
    let mut rng = ChaCha8Rng::seed_from_u64(23);
    let mut followed = 0;
    for _ in 0..100_000 {
        let sent = request(&mut rng);
        let mut bytes = sent.to_frame().to_vec();
        let last = bytes.len() - 1;
        match rng.random_range(0..4) {
            0 => (0..rng.random_range(1..8)).for_each(|_| {
                bytes[rng.random_range(0..=last)] ^= 1 << rng.random_range(0..8);
            }),
            1 => {
                let from = rng.random_range(0..last);
                rng.fill_bytes(&mut bytes[from..last]);
            }
            2 => drop(bytes.remove(rng.random_range(0..last))),
            _ => bytes.insert(rng.random_range(0..last), rng.random()),
        }
        bytes.push(0);
        for frame in frames(&bytes) {
            // Damage may undo itself: then the command is the one that was sent.
            followed += u32::from(Request::from_frame(&frame).is_ok_and(|got| got != sent));
        }
    }
    assert_eq!(followed, 0);
}

#[test]
fn what_is_no_command_is_refused_and_the_tag_comes_back() {
    let told =
        |kind, payload: &[u8]| Request::from_frame(&only(&frame::encode(kind, payload).unwrap()));
    let answer = |tag, command| Answer { tag, command };
    assert_eq!(told(Kind::Command, &[3]), Err((answer(0, 0), Refusal::Unknown)));
    for payload in [&[3, 0][..], &[3, 99], &[3, 1, 0], &[3, 7, 1]] {
        let unknown = Err((answer(3, payload[1]), Refusal::Unknown));
        assert_eq!(told(Kind::Command, payload), unknown, "{payload:?}");
    }
    assert_eq!(told(Kind::Reply, &[3, 1]), Err((answer(3, 1), Refusal::Unknown)));
    let mut damaged = vec![3, 5];
    damaged.extend(Settings::default().to_bytes(1024));
    // The version, the length of a block, whether two converters sample: values without a meaning.
    for place in [2, 3, 2 + 8] {
        let mut damaged = damaged.clone();
        damaged[place] ^= 0x80;
        let Err((head, Refusal::Settings([1, _]))) = told(Kind::Command, &damaged) else {
            panic!("settings without a meaning must be refused");
        };
        assert_eq!(head, answer(3, 5));
    }
}

/// The boot record's fingerprint of the settings.
#[test]
fn different_settings_have_different_checksums() {
    println!("seed 23");
    let mut rng = ChaCha8Rng::seed_from_u64(23);
    let crc = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);
    let all: std::collections::HashSet<u32> =
        (0..1000).map(|_| crc.checksum(&settings(&mut rng).to_bytes(1024))).collect();
    assert!(all.len() >= 999, "{} of 1000", all.len());
}

// RM 6.3.21.
#[test]
fn reset_causes() {
    for (csr, message) in [
        (0x0E00_0000, "power"),
        (0x0400_0000, "reset button"),
        (0x1400_0000, "software"),
        (0x2400_0000, "watchdog"),
        (0x2C00_0000, "watchdog"),
        (0x4400_0000, "other"),
        (0, "unknown"),
    ] {
        assert_eq!(causes(csr).message(), message, "{csr:#x}");
    }
}
