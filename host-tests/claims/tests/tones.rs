//! One tone: its sigma, its bound, whether it is found, and what noise passes for.

use picket_claims::scenes::{Kind, amplitude, anywhere, beside, deviation, line, tone, tones};
use picket_claims::{Asked, Case, Event, Truths, hold};
use picket_dsp::{Codes, Config, Iq as IqRecord, Method, Reach, Real as RealRecord, Record};
use picket_simulator::Value;
use picket_simulator::scene::{Change, Tone};

use Kind::{Iq, Real};

/// SNR, sigma and its coverage, of tones that are well above the threshold.
fn trusted(case: Case) -> Case {
    case.square(0.9, 1.12)
        .asks(Asked::Share { of: Event::Within(1.96), least: 0.94, most: 0.958 })
        .asks(Asked::Snr { most_db: 0.15 })
}

/// 2 dB above the threshold, dB.
fn above_threshold(kind: Kind, n: usize) -> f64 {
    let real = -2.6 - 9.67 * (n as f64 / 256.0).log10();
    if kind == Iq { real - 3.0 } else { real }
}

#[test]
fn sigma_and_snr_are_right() {
    let mut rows = Vec::new();
    for kind in Kind::ALL {
        for n in [256, 1024, 4096] {
            for snr_db in [above_threshold(kind, n), 10.0, 30.0, 60.0] {
                let label = format!("sigma is right: {} {n}, {snr_db:.1} dB", kind.name());
                // The ring beside a tone of 256 samples is as good as 34 real numbers.
                let spread = if n < 1024 || snr_db < 10.0 { 0.5 } else { 0.68 };
                let case = trusted(Case::new(label, tone(kind, n, snr_db), n).trials(3000));
                rows.push(case.at_least(spread, Event::SnrWithin(1.0)));
                let label = format!("sigma is right: floats, {} {n}, {snr_db:.1} dB", kind.name());
                let case = Case::new(label, tone(kind, n, snr_db), n).in_floats();
                rows.push(trusted(case.trials(if n == 4096 { 600 } else { 1500 })));
            }
        }
    }
    for (rms, snr_db) in [(0.3, 60.0), (0.3, 30.0), (0.3, 10.0)] {
        let amplitude = rms * (2.0 * 10f64.powf(snr_db / 10.0)).sqrt();
        let scene = tones(Real, 1024, [line(anywhere(Real, 1024), amplitude)], rms);
        let label = format!("sigma is right: noise of {rms} codes, {snr_db} dB");
        rows.push(trusted(Case::new(label.clone(), scene.clone(), 1024).trials(3000)));
        rows.push(trusted(Case::new(label + ", floats", scene, 1024).in_floats().trials(1500)));
    }
    for (kind, n) in [(Real, 256), (Real, 1024), (Real, 4096), (Iq, 256), (Iq, 1024)] {
        for amplitude in [2044.0, 20.47] {
            let scene = tones(kind, n, [line(anywhere(kind, n), amplitude)], 0.5);
            let label = format!("floats find {amplitude} codes in .5: {} {n}", kind.name());
            let case = Case::new(label, scene, n).in_floats().square(0.88, 1.15);
            rows.push(case.at_least(0.99, Event::Good).asks(Asked::Rms { most: 0.004 }));
        }
    }
    hold(rows);
}

/// At 60 dB and where noise decides whether a tone is found: a third, three quarters or nine tenths of them.
#[test]
fn a_tone_that_noise_lifts_over_the_threshold_has_its_sigma() {
    let mut rows = Vec::new();
    for snr_db in [-8.0, -6.0, -4.9] {
        for (kind, n, less, trials) in [
            (Real, 256, 0.0, 4000),
            (Iq, 256, 3.0, 4000),
            (Real, 1024, 6.2, 3000),
            (Iq, 1024, 9.2, 3000),
            (Real, 4096, 12.2, 1000),
            (Iq, 4096, 15.2, 1000),
        ] {
            let snr_db = snr_db - less;
            let label = format!("sigma of the just found: {} {n}, {snr_db} dB", kind.name());
            let case = Case::new(label, tone(kind, n, snr_db), n).trials(trials);
            rows.push(case.square(0.88, 1.12).at_most(0.0005, Event::Wrong(6.0)));
        }
    }
    hold(rows);
}

/// From 2 dB above the SNR where one record in 10^4 is an outlier, to 60 dB: rounding to codes counts as noise.
#[test]
fn least_squares_reaches_the_bound() {
    let mut rows = Vec::new();
    for kind in Kind::ALL {
        for (n, trials) in [(256, 2000), (1024, 2000), (4096, 1000)] {
            for (reach, most) in [(Reach::Sixteen, 1.035), (Reach::Eight, 1.05)] {
                for snr_db in [above_threshold(kind, n), 20.0, 60.0] {
                    let label =
                        format!("the bound: {} {n}, {reach:?}, {snr_db:.1} dB", kind.name());
                    let case = Case::new(label, tone(kind, n, snr_db), n).reach(reach);
                    let case = case.trials(trials).asks(Asked::OverBound { quantity: 0, most });
                    rows.push(case.square(0.88, 1.15).at_most(1e-3, Event::Elsewhere));
                }
            }
        }
    }
    // Ye et al. 2022, Table 2: 250 MS/s, 15.625 MHz, 1024 samples, -10 dB; hertz.
    for (kind, reach, hertz) in [
        (Real, Reach::Eight, 14_300.0),
        (Real, Reach::Sixteen, 14_150.0),
        (Iq, Reach::Sixteen, 9850.0),
    ] {
        let amplitude = amplitude(-10.0);
        let scene = tones(kind, 1024, [line(63.5..64.5, amplitude)], deviation(amplitude, -10.0));
        let label = format!("table 2 of the lidar paper: {}, {reach:?}", kind.name());
        let case = Case::new(label, scene, 1024).reach(reach).trials(20_000);
        let most = hertz / (250e6 / 1024.0);
        rows.push(case.asks(Asked::Rms { most }).at_most(1e-3, Event::Elsewhere));
    }
    hold(rows);
}

/// Lines outside the searched band, 10 dB stronger than the tone, are lines, not noise.
#[test]
fn lines_outside_the_band_are_not_noise() {
    let mut rows = Vec::new();
    for (kind, n) in [(Real, 1024), (Real, 4096), (Iq, 1024)] {
        for count in [1, 2] {
            let size = n as f64;
            let strong = || line(0.3 * size..0.48 * size, 10f64.sqrt() * 150.0);
            let all = std::iter::once(line(0.04 * size..0.11 * size, 150.0));
            let scene =
                tones(kind, n, all.chain((0..count).map(|_| strong())), deviation(150.0, 0.0));
            let case = Case::new(format!("beside the band {count}: {} {n}", kind.name()), scene, n);
            let case = case.told(|config| config.band_hz = Some((size / 32.0, size / 8.0)));
            let case = case.trials(2000).square(0.88, 1.15).asks(Asked::Snr { most_db: 0.15 });
            rows.push(case.at_most(0.0005, Event::Off(10.0)));
        }
    }
    hold(rows);
}

/// The default thresholds, as docs/proofs.md has them under Detection. By the power of its bin and the floor alone a tone would be found as
/// often at -4.6, -10.7 and -16.5 dB.
#[test]
fn tones_are_found_and_noise_is_not() {
    let mut rows = Vec::new();
    for (n, snr_db) in [(256, -4.9), (1024, -11.2), (4096, -17.2)] {
        let case = Case::new(format!("found: real {n}, {snr_db} dB"), tone(Real, n, snr_db), n);
        rows.push(case.trials(3000).asks(Asked::Share {
            of: Event::Found,
            least: 0.88,
            most: 0.92,
        }));
    }
    for (kind, n, asked, trials) in [
        (Real, 64, 1e-2, 200_000),
        (Real, 256, 1e-2, 200_000),
        (Real, 256, 1e-3, 400_000),
        (Real, 1024, 1e-2, 50_000),
        (Real, 4096, 1e-2, 12_500),
        (Iq, 64, 1e-2, 200_000),
        (Iq, 256, 1e-2, 200_000),
    ] {
        let label = format!("noise alone: {} {n}, {asked} asked", kind.name());
        let case = Case::new(label, tones(kind, n, [], 30.0), n);
        let case = case.told(|config| config.false_alarm = asked).trials(trials);
        let least = if n == 4096 { 0.8 } else { 0.93 } * asked;
        rows.push(case.asks(Asked::Share { of: Event::Found, least, most: 1.07 * asked }));
    }
    hold(rows);
}

/// Of records that clip at one rail or both, by 1.5 to 40 % of the samples, at least 99 % are within 3 sigma, also where harmonics fall onto
/// the tone; elsewhere sigma is no more than the error asks for, too.
#[test]
fn clipping_is_flagged_and_explained() {
    let mut rows = Vec::new();
    for (kind, n, trials) in [
        (Real, 256, 600),
        (Real, 1024, 600),
        (Real, 4096, 200),
        (Iq, 256, 600),
        (Iq, 1024, 600),
        (Iq, 4096, 200),
    ] {
        for snr_db in [30.0, 60.0] {
            for rails in [1.0, 2.0] {
                for share in [0.015, 0.05, 0.1, 0.2, 0.4] {
                    // A sample of two parts has two chances.
                    let of_part = if kind == Iq { share / 2.0 } else { share };
                    let edge = (std::f64::consts::PI * of_part / rails).cos();
                    let (amplitude, offset) = if rails == 1.0 {
                        (1900.0, 2047.0 - 1900.0 * edge)
                    } else {
                        (2047.0 / edge, 0.0)
                    };
                    // A harmonic is within 7 bins of a simple fraction of the rate.
                    let simple =
                        [1.0 / 3.0, 1.0 / 4.0, 1.0 / 5.0, 2.0 / 5.0].map(|share| share * n as f64);
                    let worst = simple.map(|middle| Some(Value::from(middle - 1.5..middle + 1.5)));
                    for (at, place) in [None].into_iter().chain(worst).enumerate() {
                        let usual = place.is_none();
                        let bins = place.unwrap_or_else(|| anywhere(kind, n));
                        let mut scene =
                            tones(kind, n, [line(bins, amplitude)], deviation(amplitude, snr_db));
                        scene.receiver.offset = [offset.into(), offset.into()];
                        let label = format!(
                            "clipped: {} {n}, {snr_db} dB, {share} at {rails} rails, place {at}",
                            kind.name()
                        );
                        let case = Case::new(label, scene, n).trials(if usual {
                            trials
                        } else {
                            trials / 6
                        });
                        let case = case.whatever_the_verdict().at_least(0.99, Event::Within(3.0));
                        // A harmonic among the fit's own bins is taken for a second tone, and counts as noise besides.
                        let case = case.square(if usual { 0.5625 } else { 0.0 }, 1.3225);
                        // The amplitude of a strongly clipped tone is too small, and with it the signal.
                        let told = usual && share <= 0.1;
                        rows.push(if told { case.asks(Asked::Snr { most_db: 0.5 }) } else { case });
                    }
                }
            }
        }
    }
    hold(rows);
}

/// I/Q tones beside the channels' offsets: none is told near 0 Hz, the others are right.
#[test]
fn tones_beside_an_offset_are_right_or_refused() {
    let mut rows = Vec::new();
    for n in [256, 1024] {
        for offset in [0.0, 40.0, 900.0] {
            for snr_db in [15.0, 30.0, 45.0] {
                for (near, ends) in [(true, (0.3, 1.2)), (false, (1.7, 12.0))] {
                    for sign in [1.0, -1.0] {
                        let ends = if sign < 0.0 { -ends.1..-ends.0 } else { ends.0..ends.1 };
                        let mut scene = tones(Iq, n, [line(ends, 300.0)], deviation(300.0, snr_db));
                        scene.receiver.offset = [0; 2].map(|_| Value::from(-offset..offset));
                        let label = format!(
                            "offset {offset}: I/Q {n}, {snr_db} dB, near 0 Hz {near}, sign {sign}"
                        );
                        let case = Case::new(label, scene, n).trials(150);
                        rows.push(if near {
                            case.at_most(0.0005, Event::Usable)
                        } else {
                            let case = case.at_least(0.97, Event::Usable).square(0.85, 1.17);
                            case.at_most(0.0005, Event::Off(5.0))
                        });
                    }
                }
            }
        }
    }
    for (amplitude, snr_db) in [(3.0, 15.0), (30.0, 20.0), (900.0, 40.0)] {
        for away in [0.0, 20.0] {
            for n in [256, 1024] {
                let half = n as f64 / 2.0;
                let bins = line(2.0..half, amplitude);
                let mut scene = tones(Iq, n, [bins], deviation(amplitude, snr_db));
                scene.converter.unsigned = true;
                scene.receiver.offset = [away.into(), away.into()];
                let label =
                    format!("codes from 0, {away} off: I/Q {n}, {amplitude} codes, {snr_db} dB");
                let case = Case::new(label, scene, n).trials(500);
                assert_eq!(case.config.codes, Codes::unsigned::<12>());
                let held =
                    |case: Case| case.at_least(0.99, Event::Good).at_most(0.0002, Event::Off(6.0));
                let mut floats = case.clone().in_floats();
                floats.label += ", floats";
                rows.extend([held(case), held(floats)]);
            }
        }
    }
    hold(rows);
}

/// Tones of 16 bits and 60 to 98 dB: sigma has the engine's own error.
#[test]
fn sigma_has_the_engines_error() {
    let mut rows = Vec::new();
    for kind in Kind::ALL {
        for n in [256, 512, 1024, 2048, 4096] {
            for snr_db in [60.0, 70.0, 80.0, 90.0, 98.0] {
                let end = if kind == Iq { n } else { n / 2 } as f64;
                let amplitude = 0.84 * 32_767.0;
                let noise = deviation(amplitude, snr_db);
                // The codes' rounding is a part of the noise.
                let added = (noise * noise - 1.0 / 12.0).max(1e-6).sqrt();
                let mut scene = tones(kind, n, [line(8.0..end - 8.0, amplitude)], added);
                scene.converter.bits = 16;
                let label = format!("the engine's error: {} {n}, {snr_db} dB", kind.name());
                let held = |case: Case| {
                    let case = case.trials(250).square(0.72, 1.32).at_least(0.998, Event::Good);
                    case.at_most(0.0005, Event::Off(5.0))
                };
                rows.push(held(Case::new(label.clone(), scene.clone(), n)));
                rows.push(held(Case::new(label + ", floats", scene, n).in_floats()));
            }
        }
    }
    hold(rows);
}

/// Codes of 8 to 16 bits, signed and not, and those of a converter that adds conversions up: right between the rails, and not good where
/// the converter is overdriven.
#[test]
fn codes_of_every_width_are_right_or_refused() {
    let signed = (8..=16).map(|bits| Codes::from_bits(true, bits));
    let unsigned = (8..=15).map(|bits| Codes::from_bits(false, bits));
    let sums = [Codes::between(0, 4095 * 7), Codes::between(-3000, 12_000)];
    let mut rows = Vec::new();
    for codes in signed.chain(unsigned).chain(sums).flatten() {
        let (low, high) = codes.rails();
        let case = |kind: Kind, n: usize, share: f64| {
            let amplitude = 0.5 * share * (f64::from(high) - f64::from(low));
            // The offset of I/Q codes lies in bin 0, and the fit of a tone below bin 17 would read it.
            let tone = line(n as f64 / 16.0..0.4 * n as f64, amplitude);
            let mut scene = tones(kind, n, [tone], deviation(amplitude, 40.0));
            scene.converter.rails = Some([low, high]);
            let label = format!("codes {low} to {high}: {} {n}, {share}", kind.name());
            Case::new(label, scene, n).trials(40)
        };
        let right =
            |case: Case| case.at_least(1.0, Event::Good).never(Event::Off(5.0)).square(0.9, 1.12);
        rows.push(right(case(Real, 1024, 0.9)));
        rows.push(right(case(Iq, 512, 0.9)));
        let mut floats = case(Real, 1024, 0.9).in_floats();
        floats.label += ", floats";
        rows.push(right(floats));
        rows.push(case(Real, 1024, 1.3).trials(100).never(Event::Good));
    }
    hold(rows);
}

/// A line up to two bins beyond an end of the band that is searched is not good.
#[test]
fn a_line_beyond_an_end_of_the_band_is_not_good() {
    let mut rows = Vec::new();
    for (low, high) in [(8.0, 20.0), (50.0, 51.0), (120.0, 159.0), (199.0, 230.0)] {
        for (end, out) in [(low, -1.0), (high, 1.0)] {
            let place = |from: f64, to: f64| {
                let [a, b] = [from, to].map(|beyond| end + out * beyond);
                let amplitude = amplitude(30.0);
                tones(Real, 512, [line(a.min(b)..a.max(b), amplitude)], deviation(amplitude, 30.0))
            };
            let told = |what: &str, scene| {
                let case = Case::new(format!("{what} {end} of {low} to {high}"), scene, 512);
                case.told(|config| config.band_hz = Some((low, high))).trials(500)
            };
            let inside = told("half a bin beyond the band's end", place(0.0, 0.45));
            rows.push(inside.at_least(0.9, Event::Good).never(Event::Off(5.0)));
            rows.push(told("beyond the band's end", place(0.6, 2.0)).never(Event::Good));
        }
    }
    hold(rows);
}

/// No method's answers are usable and wrong more often than those of least squares, but for chance: five of a thousand. A band of a steady
/// tone, of none, of one with sidebands, of two.
#[test]
fn good_means_one_thing_whatever_the_method() {
    fn methods<R: Record>() -> Vec<Method> {
        let config = |method| Config { method, ..Config::new(512.0, Codes::signed::<12>()) };
        let fits = |method: &Method| config(*method).plan::<R, 512>().is_ok();
        let own = Method::LeastSquaresReal.from_kind::<R>();
        [own].into_iter().chain(Method::ALL.iter().copied().filter(fits)).collect()
    }
    let place = || Value::from(70.0..170.0);
    let swing = Change::Am { depth: 0.5.into(), rate_hz: (0.5..1.5).into() };
    let outside = [25.0, 33.3, 41.7, 48.2, 191.6, 202.5, 213.4, 228.1];
    let all = [
        ("steady", vec![line(place(), 450.0)]),
        ("beside the band", vec![line(outside, 450.0)]),
        ("with sidebands", vec![Tone { changes: vec![swing], ..line(place(), 300.0) }]),
        ("two tones", vec![line(place(), 300.0), beside(1.5..6.5, -6.0)]),
    ];
    for (kind, methods) in [(Real, methods::<RealRecord>()), (Iq, methods::<IqRecord>())] {
        assert!(methods.len() > 5, "{methods:?}");
        for (name, lines) in &all {
            let mut scene = tones(kind, 512, lines.iter().cloned(), 0.0);
            (scene.receiver.noise.rms, scene.receiver.noise.snr_db) =
                (None, Some((0.0..50.0).into()));
            // Nothing in the band is right.
            let wrong = if *name == "beside the band" { Event::Usable } else { Event::Wrong(5.0) };
            let row = |method: &Method| {
                let label =
                    format!("{name}, whatever the method: {}|{}", kind.name(), method.name());
                let case = Case::new(label, scene.clone(), 512).against(Truths::Carrier);
                let case = case.told(|config| {
                    (config.band_hz, config.method) = (Some((60.0, 180.0)), *method);
                });
                case.asks(Asked::Share { of: wrong, least: 0.0, most: 1.0 })
            };
            let seen = hold(methods.iter().map(row).collect()).concat();
            let least = seen.first().copied().unwrap_or(0.0);
            assert!(least <= 0.015, "{name}: {least}");
            assert!(seen.iter().all(|&share| share <= least + 0.005), "{name}: {seen:?}");
        }
    }
}
