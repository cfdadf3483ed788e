//! The methods in noise: the papers' figures in Hz, each method's RMSE over the Cramer-Rao bound, and the sweep that measures them: the same
//! digits on any number of threads, codes of a converter.

use indicatif::ProgressBar;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::{Iq, Real};
use picket_dsp::methods::registry::Method;
use picket_dsp::tone::fit::Reach;
use picket_host::arithmetic::Arithmetic;
use picket_host::estimator::parse;
use picket_host::reference::Reference;
use picket_host::simulate::{Kind, Width};
use picket_lab::exact::Numbers;
use picket_lab::report::limits::{LEVELS_DB, STATED};
use picket_lab::sweep::{Offsets, Row, Sweep};

const SEED: u64 = 20260;

fn sweep(methods: &str) -> Sweep {
    Sweep {
        estimators: parse(methods, Reach::Sixteen).unwrap(),
        numbers: Numbers::F64,
        n: 1024,
        bin: 64.0,
        offsets: Offsets::Uniform,
        trials: 4000,
        width: Width::Float,
        amplitude: None,
        dc: 0.0,
        seed: SEED,
    }
}

fn run<R: Kind>(sweep: &Sweep, snr_db: f64) -> Vec<Row> {
    sweep.run::<R>(snr_db, &ProgressBar::hidden()).unwrap()
}

/// What an independent implementation has, within four standard errors, the 1 % to which that is good, and its last digit; and at 20 dB what the
/// registry says.
#[test]
fn every_method_over_the_bound() {
    println!("seed {SEED}");
    let methods = || Method::ALL.iter().filter(|method| method.fits::<Iq>());
    let names: Vec<&str> = methods()
        .map(|method| method.name())
        .chain(Reference::ALL.iter().map(|reference| reference.about().name))
        .collect();
    let mut wrong = Vec::new();
    for (level, snr_db) in LEVELS_DB.into_iter().enumerate() {
        for (row, name) in run::<Iq>(&sweep(&names.join(",")), snr_db).iter().zip(&names) {
            let (ratio, error) = row.over_bound();
            println!("{snr_db} dB {name}: {ratio:.3} +- {error:.3}");
            let method = methods().find(|method| snr_db == 20.0 && method.name() == *name);
            let registered = method.map(|method| f64::from(method.efficiency()));
            let stated = STATED.iter().find(|row| row.0 == *name).map(|row| row.1[level]);
            // The windowed ones are in no other table.
            let stated = stated.filter(|&figure| figure > 0.0);
            let Some(expected) = stated.or(registered) else { continue };
            assert!(registered.is_none_or(|of| (of / expected - 1.0).abs() < 0.011), "{name}");
            let digit = if expected < 2.0 { 0.005 } else { 0.015 * expected };
            let allowed = 0.01 * expected + 4.0 * error + digit;
            if (ratio - expected).abs() > allowed || row.outliers > 4 {
                wrong.push(format!("{name} at {snr_db} dB: {ratio:.3}, not {expected} +- {allowed:.3}; {} outliers", row.outliers));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Ye et al. 2022, Table 2: 15 points across one bin at 15.625 MHz of 250 MS/s, -10 dB. The bars are acceptance figures 1 and 2 in Hz; paper:
/// Z-Rife 18371, Rife 37258 (of fifteen single shots).
#[test]
fn table_2_of_the_lidar_paper() {
    let codes = Width::Codes(Codes::signed::<12>());
    for (numbers, width) in
        [(Numbers::F64, Width::Float), (Numbers::Library(Arithmetic::Target), codes)]
    {
        let sweep = |names: &str| Sweep {
            numbers,
            width,
            offsets: Offsets::Points(15),
            trials: 1000,
            ..sweep(names)
        };
        let real = run::<Real>(&sweep("z-rife,rife,least-squares-real"), -10.0);
        let iq = run::<Iq>(&sweep("z-rife,rife"), -10.0);
        let bars =
            [17400.0..18700.0, 41500.0..45000.0, 0.0..14150.0, 12250.0..12850.0, 30500.0..33000.0];
        for (row, bar) in real.iter().chain(&iq).zip(bars) {
            let hertz = row.rmse_bins * 250e6 / 1024.0;
            println!(
                "{} {} {}: {hertz:.0} Hz, {} outliers",
                row.arith, row.kind, row.method, row.outliers
            );
            assert!(bar.contains(&hertz), "{} {}: {hertz} Hz", row.kind, row.method);
            assert!(row.trials == 15_000 && row.outliers <= 15, "{row:?}");
        }
    }
}

/// Yang et al. 2011: FESA as printed and put right, at 0 and 20 dB (acceptance figure 5).
#[test]
fn fesa_and_its_correction() {
    let sweep = Sweep { trials: 10_000, ..sweep("fesa,fesa-corrected") };
    for snr_db in [-10.0, -5.0, 0.0, 5.0, 10.0, 20.0, 40.0, 60.0] {
        let rows = run::<Iq>(&sweep, snr_db);
        let [printed, corrected] = [0, 1].map(|i: usize| rows[i].over_bound().0);
        println!("{snr_db} dB: fesa {printed:.3}, fesa-corrected {corrected:.3}");
        assert!(rows.iter().all(|row| row.outliers <= 10) && corrected <= 1.02 * printed);
        if snr_db == 0.0 {
            assert!((printed - 1.24).abs() <= 0.03 && corrected <= 0.95 * printed);
        }
        if snr_db == 20.0 {
            assert!((printed - 1.056).abs() <= 0.02);
        }
    }
}

#[test]
fn threads_do_not_matter() {
    let mut sweep = sweep("z-rife,least-squares");
    sweep.trials = 1001;
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| run::<Iq>(&sweep, 5.0))
            .into_iter()
            .map(|row| (row.rmse_bins.to_bits(), row.bias_bins.to_bits(), row.outliers))
            .collect::<Vec<_>>()
    };
    assert_eq!(on(1), on(3));
}

/// Without noise what is left of least squares is rounding, in float and in codes.
#[test]
fn without_noise() {
    let mut sweep = sweep("least-squares-real");
    sweep.trials = 50;
    let float = run::<Real>(&sweep, f64::INFINITY);
    assert!(float[0].rmse_bins < 1e-9, "{float:?}");
    assert_eq!((float[0].ratio, float[0].snr_db), (None, None));
    sweep.width = Width::Codes(Codes::signed::<12>());
    let codes = run::<Real>(&sweep, f64::INFINITY);
    assert!((1e-7..1e-5).contains(&codes[0].rmse_bins), "{codes:?}");
}

/// At -30 dB the peak is noise: nearly every trial is an outlier and counted as one.
#[test]
fn outliers_are_counted() {
    let rows = run::<Iq>(&Sweep { trials: 500, ..sweep("z-rife") }, -30.0);
    assert!(rows[0].outliers > 400 && rows[0].trials == 500, "{rows:?}");
}
