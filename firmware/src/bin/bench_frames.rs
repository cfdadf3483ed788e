//! Counts the instructions of a frame of chirps and of a range by phase, whose linking proves them free of panics. The frame is of 32 chirps
//! of 256 I/Q samples, with two targets in noise.
#![no_std]
#![no_main]

use core::hint::black_box;
use cortex_m_rt::entry;
use fixed::types::I32F32;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::rate_check::RateCheck;
use picket_dsp::acquire::sample::{Iq, Segment};
use picket_dsp::config::Config;
use picket_dsp::frame::{Cells, Frame, FrameConfig};
use picket_dsp::pipeline::Pipeline;
use picket_dsp::solve::chirp::Target;
use picket_dsp::solve::equations::Chirp;
use picket_dsp::solve::phase_range::{Calibration, PhaseRanging};
use picket_dsp::solve::uncertainty::Uncertainty;
use picket_dsp::solve::waveform::Shape;
use picket_dsp::tone::frequency::Frequency;
use picket_dsp::tone::phasor::ToneWithPhase;
use picket_dsp::tone::{Tone, Verdict};
use picket_firmware::mps2::count::{Random, count};
use picket_firmware::mps2::halt::{Exit, exit};
use picket_firmware::mps2::{Timer, Uart, handlers};
use static_cell::ConstStaticCell;

picket_firmware::vectors!(handlers(&[]));

/// Samples of a chirp, chirps, and the bins that are kept.
const N: usize = 256;
const CHIRPS: usize = 32;
const BINS: usize = 127;

/// The range of the target that has a phase, m.
const RANGE: I32F32 = I32F32::lit("20.4");

static CELLS: ConstStaticCell<[[i16; 2]; CHIRPS * BINS]> =
    ConstStaticCell::new([[0; 2]; CHIRPS * BINS]);

#[entry]
fn main() -> ! {
    Uart::ONE.enable();
    Timer::ONE.run_free();
    let rate_hz = black_box(2.56e6);
    let (duration_s, guard_s) = (102e-6, 2e-6);
    let chirp = Chirp {
        shape: Shape::Sawtooth,
        bandwidth_hz: 300e6,
        duration_s,
        guard_s,
        ..Chirp::default()
    };
    let config = FrameConfig {
        velocity_mps: Some((-20.0, 20.0)),
        ..FrameConfig::new(chirp, rate_hz, N, true, CHIRPS, 120e-6)
    };
    let settings = Config::new(rate_hz, Codes::signed::<12>());
    let (Ok(frames), Ok(plan)) = (config.plan(), settings.plan::<Iq, N>()) else {
        exit(Exit::Config)
    };
    let cells = CELLS.try_take().and_then(|cells| Frame::new(frames, Cells::Narrow(cells)));
    let Some(mut frame) = cells else { exit(Exit::Config) };
    let mut pipeline = Pipeline::<Iq, N>::new(plan);
    let ranging = PhaseRanging::new(&chirp, rate_hz, N, true, Calibration::default());
    let Ok(ranging) = ranging else { exit(Exit::Config) };
    let mut random = Random(1);
    for chirp in 0..CHIRPS as i32 {
        // Two tones by rotation, in noise of eight bits.
        let tone = |bin: i32, row: i32, n: i32| {
            let turns = ((bin * n) as u32 % N as u32) as f32 / N as f32
                + ((row * chirp) as u32 % CHIRPS as u32) as f32 / CHIRPS as f32;
            <f32 as picket_dsp::math::scalar::Scalar>::unit(turns)
        };
        let samples: [[i16; 2]; N] = core::array::from_fn(|n| {
            let noise = random.draw();
            let sum = tone(40, 5, n as i32) * 300.0 + tone(60, -3, n as i32) * 100.0;
            [(noise >> 24) as i16 + sum.re as i16, (noise >> 16 & 0xFF) as i16 + sum.im as i16]
        });
        count("block", || pipeline.record(black_box(&samples)));
        count("chirp", || {
            let clipped = pipeline.look(black_box(&samples));
            frame.push(&pipeline.spectrum().view(), clipped)
        });
    }
    let found = count("targets", || frame.targets());
    black_box(&found);
    // A beat of 20 dB at 20 m, as the fit gives it.
    let verdict = Verdict::Good;
    let frequency = Frequency::from_bins(40, 0.03f32, N).unwrap_or_default();
    let tone = Tone { frequency, sigma: 1.2e-5, snr: 100.0, verdict, rate_hz, ..Tone::default() };
    let phasor = black_box(ToneWithPhase { tone, phase: 1.0, sigma_phase: 4.4e-3 });
    let target = black_box(Target {
        range: RANGE,
        velocity: Some(I32F32::ZERO),
        sigma_range: 1.5e-3,
        sigma_velocity: 0.1,
        verdict,
        ..Target::default()
    });
    let answer = count("phase range", || ranging.at_rest(Segment::Up, &phasor));
    count("phase ranges", || ranging.moving(&phasor, &phasor, &target));
    let known = black_box(Uncertainty {
        clock_ppm: 20.0,
        carrier_ppm: 1.0,
        slope_ppm: 100.0,
        angle_rad: 0.01,
        range_offset_m: 1e-3,
        phase_rad: 0.1,
    });
    count("budget", || known.of_target(&target, 0.1).total());
    black_box(known.of_phase_range(&answer, 0.0125).total());
    black_box(ranging.of_target(Segment::Up, &phasor, &target).candidates().count());
    black_box(ranging.calibrate(&phasor, black_box(1.0), 1e-3));
    if let Some(mut check) = RateCheck::new(black_box(1e6), black_box(1e6)) {
        check.push(black_box(0), black_box(0));
        count("clock push", || check.push(black_box(9), black_box(9)));
        // A window each, until all are filled.
        for block in 1..64u64 {
            check.push(black_box(20_000 * block), black_box(20_000 * block + block % 7));
        }
        count("clock error", || check.error());
    }
    exit(Exit::Done)
}
