//! The sweep's own figures: the ratios to the bound that the numerics state, the same digits on any
//! number of threads, and codes of a converter.

use indicatif::ProgressBar;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::{Iq, Real};
use picket_dsp::tone::fit::Reach;
use picket_host::arithmetic::Arithmetic;
use picket_host::estimator::parse;
use picket_host::simulate::{Kind, Width};
use picket_lab::exact::Numbers;
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

/// Each row within four standard errors and the rounding of the stated figure, itself good to 1 %.
#[test]
fn ratios_to_the_bound() {
    let table: &[(f64, &[(&str, f64)])] = &[
        (
            0.0,
            &[
                ("rife", 4.22),
                ("z-rife", 1.28),
                ("quinn2", 1.14),
                ("aboutanios-mulgrew", 1.00),
                ("fesa", 1.23),
                ("fitz", 1.01),
                ("ml", 1.00),
                ("least-squares", 1.01),
            ],
        ),
        (
            20.0,
            &[
                ("rife", 6.59),
                ("z-rife", 1.28),
                ("macleod", 1.15),
                ("autocorrelation", 1.07),
                ("fesa-corrected", 1.05),
                ("kay", 1.00),
                ("least-squares", 1.00),
            ],
        ),
    ];
    println!("seed {SEED}");
    for (snr_db, rows) in table {
        let names: Vec<_> = rows.iter().map(|row| row.0).collect();
        for (row, (name, truth)) in run::<Iq>(&sweep(&names.join(",")), *snr_db).iter().zip(*rows) {
            let (ratio, error) = (row.ratio.unwrap(), row.ratio_se.unwrap());
            println!("{snr_db} dB {name}: {ratio:.3} +- {error:.3}, stated {truth}");
            let allowed = 4.0 * error + 0.015 * truth;
            assert!((ratio - truth).abs() < allowed, "{name}: {ratio} for {truth}");
            assert!(row.outliers <= 4, "{name}: {} outliers", row.outliers);
        }
    }
}

/// Acceptance figure 1 in the firmware's arithmetic: 15 points across a bin, real, -10 dB, in Hz at 250 MS/s.
#[test]
fn points_across_a_bin_in_the_targets_arithmetic() {
    let mut sweep = sweep("z-rife,rife,least-squares-real");
    sweep.numbers = Numbers::Library(Arithmetic::Target);
    sweep.offsets = Offsets::Points(15);
    sweep.trials = 1000;
    sweep.width = Width::Codes(Codes::signed::<12>());
    let rows = run::<Real>(&sweep, -10.0);
    for (row, (low, high)) in
        rows.iter().zip([(17400.0, 18700.0), (41500.0, 45000.0), (0.0, 14150.0)])
    {
        let hertz = row.rmse_bins * 250e6 / 1024.0;
        println!("{}: {hertz:.0} Hz, {} outliers", row.method, row.outliers);
        assert!((low..=high).contains(&hertz), "{}: {hertz} Hz", row.method);
        assert_eq!(row.trials, 15_000);
        assert!(row.outliers <= 15);
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
