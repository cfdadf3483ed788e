//! The library by the names at its root, as a stranger uses it: the wrong codes, slices of the wrong length, what people read.

use picket_claims::scenes::{Kind, deviation, line, tones};
use picket_dsp::{Codes, Config, Method, Pipeline, Real, Tone, Verdict};

const RATE_HZ: f64 = 48e3;

/// A tone of this share of the range between the rails, 40 dB above its noise, as a converter with these codes delivers it.
fn samples(codes: Codes, share: f64, hertz: f64) -> [i16; 1024] {
    let (low, high) = codes.rails();
    let amplitude = 0.5 * share * (f64::from(high) - f64::from(low));
    let tone = line(hertz / RATE_HZ * 1024.0, amplitude);
    let mut scene = tones(Kind::Real, 1024, [tone], deviation(amplitude, 40.0));
    scene.converter.rails = Some([low, high]);
    picket_claims::samples::<Real, 1024>(&mut scene.run(0).unwrap(), 0)
}

#[test]
fn codes_that_the_converter_cannot_make_have_their_own_verdict() {
    let said = |stated: Codes, true_codes: Codes| -> Tone {
        let samples = samples(true_codes, 0.5, 1234.57);
        let plan = Config::new(RATE_HZ, stated).plan().unwrap();
        Pipeline::<Real, 1024>::new(plan).record(&samples).unwrap().tone
    };
    let pairs = [
        (Codes::signed::<12>(), Codes::signed::<16>()),
        (Codes::signed::<12>(), Codes::unsigned::<12>()),
        (Codes::unsigned::<12>(), Codes::signed::<12>()),
        (Codes::unsigned::<12>(), Codes::unsigned::<14>()),
    ];
    for (stated, truth) in pairs {
        let tone = said(stated, truth);
        assert_eq!(tone.verdict, Verdict::WrongCodes, "{stated:?} for {truth:?}: {tone}");
    }
    // The right ones, at half scale: the frequency that a wrong reading missed by far.
    let tone = said(Codes::signed::<16>(), Codes::signed::<16>());
    assert_eq!(tone.verdict, Verdict::Good);
    assert!((tone.hertz() - 1234.57).abs() < 0.1, "{tone}");
}

#[test]
fn a_slice_of_another_length_is_refused_in_words() {
    let plan = Config::new(RATE_HZ, Codes::signed::<12>()).plan().unwrap();
    let mut pipeline = Pipeline::<Real, 1024>::new(plan);
    for length in [0, 1023, 1025] {
        let error = pipeline.record(&vec![0; length]).unwrap_err();
        assert_eq!((error.samples, error.wanted), (length, 1024));
        assert!(error.to_string().contains("1024"));
    }
}

#[test]
fn what_people_read() {
    let codes = Codes::signed::<12>();
    let samples = samples(codes, 0.9, 1000.2);
    let plan = Config::new(RATE_HZ, codes).plan().unwrap();
    let tone = Pipeline::<Real, 1024>::new(plan).record(&samples).unwrap().tone;
    let said = tone.to_string();
    // Hertz with two digits of sigma, and the verdict.
    let (hertz, rest) = said.split_once(" Hz ± ").unwrap();
    assert!((hertz.parse::<f64>().unwrap() - 1000.2).abs() < 0.1, "{said}");
    let (sigma, rest) = rest.split_once(" Hz, SNR ").unwrap();
    let digits = |x: &str| x.split_once('.').map_or(0, |(_, digits)| digits.len());
    assert_eq!(digits(hertz), digits(sigma));
    assert!((sigma.parse::<f64>().unwrap() / tone.sigma_hertz() - 1.0).abs() < 0.06);
    assert!(rest.ends_with(" dB, good"), "{said}");
    assert!(tone.frequency.to_string().starts_with("0.02083"), "{}", tone.frequency);
    // A tone that means nothing is told without a panic.
    assert!(Tone::default().to_string().ends_with("no-signal"));
    assert_eq!("z-rife".parse(), Ok(Method::ZRife));
    assert_eq!("zrife".parse::<Method>().unwrap_err().to_string().lines().count(), 1);
}
