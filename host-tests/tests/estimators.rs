//! Every method of the registry on exact tones, on nothing, and on the wrong kind of record.

use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::{Data, Iq, Real, Record};
use picket_dsp::math::scalar::Scalar;
use picket_dsp::methods::registry::{Method, Needs, Unfit};
use picket_dsp::methods::samples::Samples;
use picket_dsp::spectrum::Spectrum;
use picket_dsp::spectrum::bins::{Bins, Rectangular};
use picket_host::reference::Reference;
use picket_transform::{Transform, num_complex::Complex};

/// A method's largest error on an exact complex tone at N = 256, offsets up to 0.49, in bins: what its
/// formula leaves out. In f32 there are 6e-7 more: its sines are short series, right to the last digit or two.
fn bias(method: Method) -> f64 {
    match method {
        Method::Candan | Method::Autocorrelation | Method::ImprovedAutocorrelation => 1e-13,
        // Two iterations are not the limit.
        Method::AboutaniosMulgrew => 1.3e-10,
        Method::Haqse => 1.1e-8,
        // Large N is assumed: terms of order 1/N^4.
        Method::Grandke | Method::CandanHann => 8e-10,
        // Large N is assumed: terms of order 1/N^2.
        Method::Rife | Method::ZRife | Method::APRife => 2.6e-6,
        Method::IRife | Method::DualThresholdRife => 2.1e-6,
        Method::Quinn1 | Method::Quinn2 | Method::Jacobsen | Method::Macleod => 2.1e-5,
        Method::Fesa | Method::FesaCorrected => 2.1e-5,
        // The lines of a rectangular window are no parabola.
        Method::Parabolic => 0.17,
        // The start is exact, so no step is too few.
        Method::LeastSquares => 1e-13,
        // On real records, with their image: see the tests of least squares.
        Method::LeastSquaresReal => unreachable!("takes no complex tone"),
        other => panic!("state the bias of {other}"),
    }
}

/// One record of floats with its bins and powers.
struct Tone<T> {
    samples: Vec<Complex<T>>,
    spectrum: Vec<Complex<T>>,
}

impl<T: Scalar> Tone<T> {
    fn new(n: usize, bins: f64, amplitude: f64, phase: f64) -> Self {
        let turns = |k: usize| (bins * k as f64 / n as f64 + phase).fract();
        let exact: Vec<_> = (0..n).map(|k| f64::unit(turns(k)) * amplitude).collect();
        let mut spectrum = exact.clone();
        f64::forward(n).process(&mut spectrum);
        let narrow = |x: &Complex<f64>| Complex::new(T::new(x.re), T::new(x.im));
        Self {
            samples: exact.iter().map(narrow).collect(),
            spectrum: spectrum.iter().map(narrow).collect(),
        }
    }

    fn offset(&self, method: Method, peak: i32) -> T {
        let bins =
            Bins::<T, Iq, Rectangular>::gather(self.samples.len(), peak, |k| self.spectrum[k]);
        let power = |k: i32| self.spectrum[k as usize].norm_sqr();
        method.offset(&bins, self.samples.as_slice(), power).unwrap()
    }
}

fn worst<T: Scalar>(method: Method) -> f64 {
    let mut worst = 0.0f64;
    for peak in [0, 1, 37, 128, 255] {
        for step in -49..=49 {
            let offset = f64::from(step) / 100.0;
            let tone =
                Tone::<T>::new(256, f64::from(peak) + offset, 1000.0, 0.123 * f64::from(step));
            worst = worst.max((tone.offset(method, peak).wide() - offset).abs());
        }
    }
    worst
}

#[test]
fn an_exact_tone_is_found_up_to_the_methods_bias() {
    for &method in Method::ALL.iter().filter(|method| method.fits::<Iq>()) {
        let (double, single) = (worst::<f64>(method), worst::<f32>(method));
        println!("{method:26} {double:8.1e} {single:8.1e}");
        assert!(double < bias(method), "{method}: {double:e} bin");
        assert!(single < bias(method) + 6e-7, "{method}: {single:e} bin in f32");
    }
}

#[test]
fn silence_and_rails_give_a_finite_offset() {
    fn try_all<R: Record>(samples: &[R::Sample; 64], codes: Codes) {
        let mut spectrum = Spectrum::<R, 64>::new();
        spectrum.transform(samples, codes);
        for &method in Method::ALL.iter().filter(|method| method.fits::<R>()) {
            for peak in [0, 1, 5, 31, 32, 63] {
                let offset =
                    method.offset_target(&spectrum.view(), Data::of::<R>(samples), peak).unwrap();
                assert!(offset.abs() <= 2, "{method} at {peak}: {offset}");
            }
        }
    }
    for code in [0, 1, -2048, 2047] {
        try_all::<Real>(&[code; 64], Codes::signed::<12>());
        try_all::<Iq>(&[[code; 2]; 64], Codes::signed::<12>());
    }
    let square = std::array::from_fn(|n| if n % 5 < 2 { i16::MIN } else { i16::MAX });
    try_all::<Real>(&square, Codes::signed::<16>());
    try_all::<Iq>(&square.map(|x| [x, !x]), Codes::signed::<16>());
}

/// In floats too: no method answers with something that is not a number.
#[test]
fn silence_is_offset_zero() {
    let silent = Tone::<f64>::new(64, 5.0, 0.0, 0.0);
    for &method in Method::ALL.iter().filter(|method| method.fits::<Iq>()) {
        let offset = silent.offset(method, 5);
        assert!(offset.is_finite() && offset.abs() <= 0.5, "{method}: {offset}");
    }
}

#[test]
fn real_records_are_refused_where_they_are_wrong() {
    let samples: Vec<f64> = vec![1.0; 64];
    let bins = Bins::<f64, Real, Rectangular>::gather(64, 5, |_| Complex::new(1.0, 0.0));
    let offset = |method: Method, samples: &[f64]| method.offset(&bins, samples, |_| 1.0);
    for &method in Method::ALL {
        assert_eq!(offset(method, &samples) == Err(Unfit), !method.fits::<Real>(), "{method}");
        let unfit = method.about().family == "autocorrelation";
        assert!(!unfit || !method.fits::<Real>(), "{method}");
    }
    assert!(Method::ALL.iter().filter(|m| !m.fits::<Real>()).count() >= 4);
}

#[test]
fn the_registry_is_consistent() {
    let mut names: Vec<_> = Method::ALL.iter().map(|m| m.name()).collect();
    names.extend(Reference::ALL.iter().map(|r| r.about().name));
    for name in &names {
        assert_eq!(names.iter().filter(|other| other == &name).count(), 1, "{name}");
    }
    for &method in Method::ALL {
        assert_eq!(Method::from_u8(method.id()), Some(method));
        assert_eq!(Method::from_name(method.name()), Some(method));
        let about = method.about();
        assert_eq!((about.name, about.records), (method.name(), method.records()));
        assert!(about.efficiency >= 1.0 && !about.doc.is_empty());
        assert!(about.needs != Needs::Powers || !method.fits::<Real>());
    }
    assert_eq!(Method::from_u8(255), None);
    assert_eq!(Method::from_name("no such method"), None);
}

/// `Samples` beyond their end are none, not a panic.
#[test]
fn samples_end() {
    let samples: &[f32] = &[1.0, 2.0];
    assert_eq!(Samples::<f32, Real>::from(samples, 1).count(), 1);
    assert_eq!(Samples::<f32, Real>::from(samples, 3).count(), 0);
}

/// RMSE in bins on exact real tones about a bin of N = 1024, over offsets and phases: the floor that the mirror
/// image sets.
fn image_floor(method: Method, peak: i32) -> f64 {
    let (n, mut squares, mut count) = (1024usize, 0.0, 0.0);
    let fft = f64::forward(n);
    for step in -24..=24 {
        let offset = f64::from(step) / 49.0;
        for phase in 0..16 {
            let start = f64::from(phase) / 16.0;
            let turns = |k: usize| (f64::from(peak) + offset) * k as f64 / n as f64 + start;
            let samples: Vec<f64> = (0..n).map(|k| f64::unit(turns(k).fract()).re).collect();
            let mut spectrum: Vec<_> = samples.iter().map(|&x| Complex::new(x, 0.0)).collect();
            fft.process(&mut spectrum);
            let bins = Bins::<f64, Real, Rectangular>::gather(n, peak, |k| spectrum[k]);
            let power = |k: i32| spectrum[k as usize].norm_sqr();
            let error = method.offset(&bins, samples.as_slice(), power).unwrap() - offset;
            squares += error * error;
            count += 1.0;
        }
    }
    (squares / count).sqrt()
}

/// The reference's floors at bins 5 and 256, which it gives to two digits and for a grid of offsets of its own:
/// within a tenth. The methods under Hann's window and least squares are made for this: below a limit.
#[test]
fn real_tones_stop_at_the_image_floor() {
    let floors = |method| [5, 256].map(|peak| image_floor(method, peak));
    for (method, expected) in [
        (Method::ZRife, [1.4e-2, 4e-4]),
        (Method::Quinn2, [1.2e-2, 3.5e-4]),
        (Method::Haqse, [1.6e-2, 4.7e-4]),
        (Method::Candan, [1.9e-3, 1.7e-6]),
    ] {
        let found = floors(method);
        println!("{method:20} {:.2e} {:.2e}", found[0], found[1]);
        let close = |(found, expected): (f64, f64)| (found / expected - 1.0).abs() < 0.1;
        assert!(found.into_iter().zip(expected).all(close), "{method}: not {expected:?}");
    }
    for (method, limits) in [
        (Method::Grandke, [4e-4, 3e-11]),
        (Method::CandanHann, [1e-4, 3e-11]),
        (Method::LeastSquaresReal, [1e-12, 1e-12]),
    ] {
        let found = floors(method);
        println!("{method:20} {:.2e} {:.2e}", found[0], found[1]);
        assert!(found[0] < limits[0] && found[1] < limits[1], "{method}: not below {limits:?}");
    }
}
