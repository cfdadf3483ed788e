//! Frames of chirps, each target to the bit as this machine has it, from the transmitter's phase; and what the board refuses.

use super::several::longest_block;
use super::*;
use picket_dsp::frame::{Cells, Frame, FramePlan};
use picket_firmware::nucleo_f446re::CELLS;
use picket_firmware::nucleo_f446re::words::CHIRP_CYCLES;
use picket_host::scenario::{echo, sensor};
use picket_simulator::{Run, Scene as World};
use picket_wire::chirp_frame::{ChirpFrame, Found};
use picket_wire::settings::Mode;
use picket_wire::settings_error::{FramesError, SettingsError};

const CHIRPS: u16 = 64;

/// 24 GHz and 200 MHz, at a rate that the emulated clock has; 120 bins reach 95 m, and aliases are 2.55 m/s apart.
fn radar(iq: bool) -> Settings {
    let scene = Scene::Chirp(Chirp {
        shape: Shape::Sawtooth,
        wavelength_m: 0.0125,
        bandwidth_hz: 200e6,
        duration_s: 1.0,
        ..Chirp::default()
    });
    let config = Config {
        scene,
        rate_hz: 4e6 / 9.0,
        band_hz: Some((450.0, 51_900.0)),
        velocity_mps: Some((-1.25, 1.25)),
        ..Settings::default().config
    };
    let drive = Drive::Dac { low: 400, high: 3600 };
    let mode = Mode::Frames { chirps: CHIRPS, period_s: None };
    Settings { iq, config, guard: 64, drive, mode, ..Settings::default() }
}

/// Two targets before the radar, the weaker one below the noise of a sample.
fn world<R: Record>(plan: &Plan<N>, chirps: usize) -> World {
    let Settings { config, .. } = plan.settings;
    let Scene::Chirp(chirp) = config.scene else { panic!("a chirp") };
    let mut world = World { seed: SEED, ..sensor::<R>(&config, N, chirp.duration_s, chirps + 1) };
    let targets = [echo(300.0, 31.5, 0.9), echo(80.0, 52.3, -0.4)];
    world.sources = targets.into_iter().map(scene::Source::Target).collect();
    world.receiver.noise.rms = Some(150.0.into());
    world
}

/// A frame as this machine has it.
struct Gathered<R: Record> {
    here: Here<R>,
    plan: FramePlan,
    cells: Vec<[i16; 2]>,
}

impl<R: Record> Gathered<R> {
    fn new(settings: &Settings) -> Self {
        let here = Here::<R>::new(settings);
        let plan = here.plan.settings.frames(N).unwrap().unwrap();
        // The whole of the board's memory.
        assert_eq!((plan.cells(), plan.bins()), (CELLS, 120));
        Self { here, plan, cells: vec![[0; 2]; CELLS] }
    }

    /// What the board says of the frame that begins with this chirp.
    fn said(
        &mut self,
        records: &[[R::Sample; N]],
        (number, first, gap): (u32, u32, bool),
        [passed, lost]: [u32; 2],
    ) -> Vec<Said> {
        let stamp = self.here.stamp(first.into(), gap);
        let mut frame = Frame::new(self.plan, Cells::Narrow(&mut self.cells)).unwrap();
        let mut complete = false;
        for chirp in first..first + u32::from(CHIRPS) {
            assert!(!complete);
            let clipped = self.here.pipeline.look(&records[chirp as usize]);
            complete = frame.push(&self.here.pipeline.spectrum().view(), clipped);
        }
        let found = frame.targets();
        let Settings { config, .. } = self.here.plan.settings;
        let Scene::Chirp(chirp) = config.scene else { panic!("a chirp") };
        let told = ChirpFrame {
            number,
            stamp,
            chirps: CHIRPS,
            passed,
            clipped: frame.clipped(),
            targets: found.len() as u8,
            search_s: 0.0,
            rate_hz: config.rate_hz,
            period_s: chirp.duration_s,
            health: Health { lost, faults: u32::from(lost > 0) },
            basis: Some(self.here.plan.basis(tree().source.clock())),
        };
        let targets = found.iter().zip(0..);
        let targets =
            targets.map(|(&found, place)| Said::Found(Found { frame: number, place, found }));
        [Said::ChirpFrame(told)].into_iter().chain(targets).collect()
    }
}

/// Whether the targets are those that are there, in the middle of the frame.
fn right(run: &Run, world: &World, first: usize, said: &[Said]) {
    let [_, targets @ ..] = said else { panic!("a frame") };
    assert_eq!(targets.len(), 2, "{targets:?}");
    let starts = [first, first + usize::from(CHIRPS) - 1].map(|chirp| world.start_s(chirp, N));
    for (source, said) in targets.iter().enumerate() {
        let Said::Found(Found { found, .. }) = said else { panic!("a target") };
        let target = &found.target;
        let truth = run.truth(source, f64::midpoint(starts[0], starts[1]), N);
        let off = [
            (target.range.to_num::<f64>() - truth.range_m.unwrap()) / f64::from(target.sigma_range),
            (target.velocity.unwrap().to_num::<f64>() - truth.velocity_mps.unwrap())
                / f64::from(target.sigma_velocity),
        ];
        println!("{off:?} sigma, {target:?}");
        assert!(off.iter().all(|off| off.abs() < 5.0) && target.verdict == Verdict::Good);
    }
}

/// Takes the time of the search, which this machine does not know, out of a message.
fn untimed(said: &mut Said) -> f32 {
    match said {
        Said::ChirpFrame(frame) => std::mem::take(&mut frame.search_s),
        _ => 0.0,
    }
}

/// What is told of frames in a turn of the board's loop.
fn told_of(board: &mut Board) -> Vec<Said> {
    let mut said = board.turn().unwrap();
    said.retain(|said| matches!(said, Said::ChirpFrame(_) | Said::Found(_) | Said::Telemetry(_)));
    said
}

/// The messages until the targets of a frame are all there, without the time of the search, and that time in ticks.
fn heard(board: &mut Board) -> (Vec<Said>, f64) {
    let mut told = Vec::new();
    board
        .expect(|said| {
            if matches!(said, Said::ChirpFrame(_) | Said::Found(_)) {
                told.push(said);
            }
            match told.first() {
                Some(Said::ChirpFrame(frame)) => {
                    (told.len() > usize::from(frame.targets)).then_some(())
                }
                _ => None,
            }
        })
        .unwrap_or_else(|error| panic!("{error}"));
    let seconds: f32 = told.iter_mut().map(untimed).sum();
    (told, f64::from(seconds) * 16e6)
}

fn gathered<R: Record>() {
    println!("seed {SEED}");
    let settings = radar(R::IQ);
    let mut board = Board::start_counted(played()).unwrap();
    boot(&mut board);
    let answer = board.request(Command::SetSettings(settings, N)).unwrap();
    let answer = answer.unwrap_or_else(|refusal| panic!("{refusal}"));
    assert_eq!(Settings::from_bytes(&answer).unwrap().0.mode, settings.mode);
    assert!(boot(&mut board).measuring);
    board.recorded = Some(Vec::new());
    let mut here = Gathered::<R>::new(&settings);
    let world = world::<R>(&here.here.plan, 8 * usize::from(CHIRPS));
    let mut run = world.run(SEED).unwrap();
    let records: Vec<_> =
        (0..8 * usize::from(CHIRPS)).map(|chirp| samples::<R, N>(&mut run, chirp)).collect();
    let mut next = 0;
    let send = |board: &mut Board, next: &mut u32| {
        let parts = records[*next as usize].iter().map(|&sample| R::parts(sample));
        let parts = parts.flat_map(|parts| parts.into_iter().take(if R::IQ { 2 } else { 1 }));
        assert!(board.block(&bytes(&parts.collect::<Vec<i16>>())).unwrap());
        *next += 1;
    };
    for chirp in 1..=CHIRPS {
        send(&mut board, &mut next);
        // Nothing is asked during the search.
        assert!(chirp == CHIRPS || told_of(&mut board).is_empty());
    }
    let expected = here.said(&records, (0, 0, false), [0; 2]);
    right(&run, &world, 0, &expected);
    let (told, search) = heard(&mut board);
    assert_eq!(told, expected);
    let longest = longest_block(&mut board);
    board.recorded = Some(Vec::new());
    // A frame that a lost block interrupts begins again, and says so.
    let interrupted = 20;
    for _ in 0..interrupted {
        send(&mut board, &mut next);
        assert!(told_of(&mut board).is_empty());
    }
    board.adc_overrun().unwrap();
    let lost = status(&mut board).counters.lost();
    assert!(lost > 0);
    next += lost;
    let first = next;
    for _ in 0..CHIRPS {
        send(&mut board, &mut next);
        assert!(told_of(&mut board).is_empty());
    }
    let expected = here.said(&records, (1, first, true), [interrupted + lost, lost]);
    right(&run, &world, first as usize, &expected);
    assert_eq!(heard(&mut board).0, expected);
    // Chirps that pass while targets are sought are in no frame: how many, the pace of the emulator decides.
    let third = next;
    let mut told = Vec::new();
    while next < third + u32::from(CHIRPS) || told.is_empty() {
        send(&mut board, &mut next);
        told.extend(told_of(&mut board));
    }
    let end = third + u32::from(CHIRPS);
    told.iter_mut().map(untimed).for_each(drop);
    let Some(Said::ChirpFrame(ChirpFrame { health, .. })) = told.first() else { panic!("a frame") };
    // A slow machine keeps blocks waiting during a search, so that some are lost.
    let lost = [lost, health.lost];
    assert!(lost[1] >= lost[0]);
    assert_eq!(told, here.said(&records, (2, third, false), [0, lost[1]]));
    // How many of them passed before the search ended, the board says.
    let ended = next;
    let mut told = Vec::new();
    while told.is_empty() {
        send(&mut board, &mut next);
        told.extend(told_of(&mut board));
    }
    told.iter_mut().map(untimed).for_each(drop);
    let Some(Said::ChirpFrame(fourth)) = told.first() else { panic!("a frame") };
    let ChirpFrame { stamp: Stamp { sequence: first, gap, .. }, health, .. } = *fourth;
    assert!(health.lost >= lost[1]);
    println!("{} chirps passed", fourth.passed);
    assert!(end < first && first <= ended, "{end} {first} {ended}");
    assert_eq!(told, here.said(&records, (3, first, gap), [first - end, health.lost]));
    fits(&mut board, if R::IQ { "with frames of I/Q chirps" } else { "with frames" });
    let kind = if R::IQ { "I/Q" } else { "real" };
    println!("{kind}: {longest} instructions a chirp");
    assert!(1.4 * f64::from(longest) + 27e3 < CHIRP_CYCLES[usize::from(R::IQ)] as f64);
    hold(
        &format!(
            "board, instructions of a chirp in a frame and of the search for two targets, {kind}"
        ),
        1.0,
        &[longest.into(), search],
    );
}

#[test]
fn frames_on_the_board_are_those_of_this_machine() {
    gathered::<Real>();
    gathered::<Iq>();
}

/// Settings with which no frame can be gathered.
#[test]
fn what_is_no_frame_is_refused() {
    let usual = radar(false);
    let (mut board, _) = start();
    let with = |config: Config| Settings { config, ..usual };
    let frames = |chirps, period_s| Settings { mode: Mode::Frames { chirps, period_s }, ..usual };
    let shaped = |shape| {
        let Scene::Chirp(chirp) = usual.config.scene else { panic!("a chirp") };
        with(Config { scene: Scene::Chirp(Chirp { shape, ..chirp }), ..usual.config })
    };
    let following = Following { most: 1, ..Following::default() };
    let error = |error| SettingsError::Frames(error);
    let frame = SettingsError::Config(picket_dsp::ConfigError::Frame);
    for (settings, refusal) in [
        (shaped(Shape::Triangle), error(FramesError::Scene)),
        (with(Config { following, ..usual.config }), error(FramesError::Scene)),
        (Settings { most: 2, ..usual }, error(FramesError::Scene)),
        (frames(64, Some(3e-3)), error(FramesError::Period)),
        (Settings { drive: Drive::External, ..usual }, error(FramesError::Period)),
        (Settings { drive: Drive::External, ..frames(64, Some(1e-3)) }, frame),
        (frames(128, None), error(FramesError::Cells)),
        (with(Config { band_hz: None, ..usual.config }), error(FramesError::Cells)),
        (frames(7, None), frame),
        (frames(512, None), frame),
    ] {
        let told = board.request(Command::SetSettings(settings, N)).unwrap().unwrap_err();
        assert_eq!(told, Refusal::Settings(refusal.code()), "{settings:?}");
    }
    // The cells of the error's words are those of the board.
    assert!(error(FramesError::Cells).to_string().contains(&format!("{CELLS} cells")));
    // The bins of the ranges that a target may have, and sixteen beside them on each side.
    let near = Config { band_hz: None, range_m: Some((20.0, 60.0)), ..usual.config };
    let (plan, _) = planned(&with(near));
    let plan = plan.settings.frames(N).unwrap().unwrap();
    let ends = [plan.first(), plan.first() + plan.bins() as i32 - 1];
    let [low, high] = ends.map(|bin| plan.cell(bin as f32, 0.0)[0]);
    assert!(
        (20.0 - low - 16.0 * 0.8).abs() < 1.0 && (high - 60.0 - 16.0 * 0.8).abs() < 1.0,
        "{low} {high}"
    );
    let external = Settings { drive: Drive::External, ..frames(64, Some(3e-3)) };
    board.request(Command::SetSettings(external, N)).unwrap().unwrap();
}
