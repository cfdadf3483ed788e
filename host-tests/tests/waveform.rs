//! From the transmitter's waveform to the target: the whole way through records of the simulator.

use crate::signal::{CODES, mean, trials};
use picket::config::{Config, Scene};
use picket::{Chirp, Iq, Mixing, Outcome, Pipeline, Shape, Stamp, Target, Verdict};
use picket_host::scenario::{self, Row};
use picket_simulator::Sensor;

const N: usize = 1024;
const RATE_HZ: f64 = 1e6;

/// 24 GHz with 200 MHz: a ramp of two records, of which the second one is measured.
fn late_records(shape: Shape, mixing: Mixing) -> Chirp {
    let duration_s = 2.0 * N as f64 / RATE_HZ;
    Chirp { shape, duration_s, guard_s: duration_s / 2.0, mixing, ..Chirp::default() }
}

fn config(chirp: Chirp) -> Config {
    Config { scene: Scene::Chirp(chirp), ..Config::new(RATE_HZ, CODES) }
}

/// Targets of so many chirps of `sent`, which are measured as chirps of `set`.
fn measured(row: Row, snr_db: f64, [sent, set]: [Chirp; 2], count: u64) -> Vec<Target> {
    let sensor: Sensor = scenario::sensor::<Iq>(&config(sent), N, 0.0);
    trials(37, count, |rng| {
        let mut pipeline = Pipeline::<Iq, N>::new(config(set).plan().unwrap());
        let mut result = Outcome::None;
        for (number, &segment) in sent.shape.segments().iter().enumerate() {
            let record = row.codes::<Iq>(&sensor, number, (1000.0, snr_db), rng);
            let stamp = Stamp { sequence: number as u32, segment, ..Stamp::default() };
            result = pipeline.block(stamp, record.as_array().unwrap()).result;
        }
        let Outcome::Target(target) = result else { panic!("no target") };
        target
    })
}

/// Errors of the range, m, and their root mean square in sigmas.
fn range_errors(row: Row, targets: &[Target]) -> (Vec<f64>, f64) {
    let error = |target: &Target| target.range.to_num::<f64>() - row.range_m;
    let square = |target: &Target| (error(target) / f64::from(target.sigma_range)).powi(2);
    (targets.iter().map(error).collect(), mean(targets.iter().map(square)).sqrt())
}

/// A sweep whose middle is off by a ten-thousandth of its bandwidth, with records in the upper half of the ramp: there the slope is
/// less by two ten-thousandths, and so is the range of whoever does not know. With the constant set nothing is left.
#[test]
fn a_sweeps_curvature_scales_the_range_and_its_constant_mends_it() {
    const CURVATURE: f64 = 1e-4;
    for mixing in Mixing::ALL {
        let straight = late_records(Shape::Trapezoid, mixing);
        let bent = Chirp { sweep_curvature: CURVATURE, ..straight };
        for (range_m, velocity_mps) in [(30.0, 25.0), (60.0, -25.0), (120.0, 40.0)] {
            let row = Row { range_m, velocity_mps };
            let known = measured(row, 20.0, [bent, bent], 300);
            let unknown = measured(row, 20.0, [bent, straight], 300);
            let good = known.iter().filter(|target| target.verdict == Verdict::Good).count();
            let (_, sigmas) = range_errors(row, &known);
            let (errors, without) = range_errors(row, &unknown);
            let share = mean(errors.into_iter()) / range_m;
            println!(
                "{range_m} m, {velocity_mps} m/s, {mixing:?}: {good} of 300 good, {sigmas:.3} sigmas with the constant; \
                 without it {without:.2} sigmas, {:.4} % of the range",
                100.0 * share
            );
            assert!(good >= 297 && (0.85..1.15).contains(&sigmas), "{sigmas}");
            assert!((share / (-2.0 * CURVATURE) - 1.0).abs() < 0.1, "{share}");
        }
    }
}

/// The receiver's orientation through the whole way: right within its sigma, and never good where the other one is set.
#[test]
fn a_receivers_mixing_is_heeded_and_a_wrong_one_is_seen() {
    for shape in [Shape::Triangle, Shape::Trapezoid] {
        for mixing in Mixing::ALL {
            let row = Row { range_m: 30.0, velocity_mps: 3.0 };
            let sent = Chirp { duration_s: 1.1e-3, guard_s: 50e-6, ..late_records(shape, mixing) };
            let other = Mixing::ALL.into_iter().find(|other| *other != mixing).unwrap();
            let right = measured(row, 20.0, [sent; 2], 100);
            let wrong = measured(row, 20.0, [sent, Chirp { mixing: other, ..sent }], 100);
            let (_, sigmas) = range_errors(row, &right);
            println!("{shape:?}, {mixing:?}: {sigmas:.3} sigmas, first {:?}", right[0]);
            assert!((0.8..1.2).contains(&sigmas), "{sigmas}");
            assert!(wrong.iter().all(|target| target.verdict > Verdict::Good));
        }
    }
}
