//! Every test in words: what it compares, and what follows from it.

use super::Row;
use picket_dsp::tone::observer::{Statistic, Test};

/// What becomes of a value above its limit.
#[derive(Clone, Copy, PartialEq)]
enum Sense {
    /// The line must exceed the limit: a test of detection.
    Must,
    /// A value above the limit speaks against one steady tone.
    Alarm,
    /// It only decides which test comes next, or what a sum is made of.
    Path,
}

/// A test as a row of the table.
pub fn row(test: &Test, fit: Option<&'static str>) -> Row {
    let (sense, about, unit, [above, below]) = of(test.statistic);
    let exceeds = test.fires();
    let fired = match sense {
        Sense::Must => !exceeds,
        Sense::Alarm => exceeds,
        Sense::Path => false,
    };
    let number = |x: f32| {
        let x = if unit == "dB" { 10.0 * f64::from(x).log10() } else { x.into() };
        x.is_finite().then_some(x)
    };
    Row {
        test: test.statistic.name(),
        about,
        fit,
        value: number(test.value),
        limit: number(test.limit),
        unit,
        fired,
        decides: sense != Sense::Path,
        followed: if exceeds { above } else { below }.to_owned(),
    }
}

/// Every statistic has its words: where one has none, the compiler names it.
const _: () = {
    let mut rest = Statistic::ALL;
    while let [statistic, others @ ..] = rest {
        assert!(!of(*statistic).1.is_empty(), "{}", statistic.name());
        rest = others;
    }
};

/// Sense, what is compared, its unit, and what follows from a value above the limit and from another.
const fn of(statistic: Statistic) -> (Sense, &'static str, &'static str, [&'static str; 2]) {
    use Sense::{Alarm, Must, Path};
    const TOLD: [&str; 2] = ["told from this noise", "it may be noise: weak"];
    const EITHER: [&str; 2] = ["told from this noise", "not by this test"];
    const LOOK: [&str; 2] = ["looked at more closely", "no more than noise leaves"];
    const REST: [&str; 2] = ["more than noise leaves: no steady tone", "as noise leaves"];
    const PART: [&str; 2] = ["-"; 2];
    const ONE: [&str; 2] =
        ["changes of one tone do not explain it", "changes of one tone explain it"];
    match statistic {
        Statistic::Floor => (Must, "line over the mean of the band's other bins", "dB", TOLD),
        Statistic::FarAbove => (
            Path,
            "line over the loudest noise near it",
            "dB",
            ["detected by far: no other test is needed", "not by far: more tests of detection"],
        ),
        Statistic::Hump => (
            Path,
            "noise near the line over the ring's",
            "",
            [
                "the ring does not tell this noise: the residual decides",
                "the ring tells this noise",
            ],
        ),
        Statistic::MiddleResidual => {
            (Must, "line over the middle one of three residuals", "dB", EITHER)
        }
        Statistic::LeastResidual => (Must, "line over the least of three residuals", "dB", TOLD),
        Statistic::MeanResidual => (Must, "line over the mean residual", "dB", TOLD),
        Statistic::WideRing => (Must, "line over the noise of a wide ring", "dB", TOLD),
        Statistic::Ring => (Must, "line over the louder side's noise", "dB", TOLD),
        Statistic::LouderHalf => (
            Path,
            "residual of the louder half of the bins over the floor",
            "",
            ["louder on one side: the line must exceed it", "as loud as the floor"],
        ),
        Statistic::OverLouderHalf => {
            (Must, "line over the louder half of the residual", "dB", TOLD)
        }
        Statistic::NoiseEdge => (
            Path,
            "louder side's noise over the quieter side's",
            "dB",
            ["an edge of the noise: taken from the residual", "noise alike on both sides"],
        ),
        Statistic::Changes => (Path, "power along changes of the tone, first look", "", LOOK),
        Statistic::Within2 => (Path, "residual up to 2 bins off, first look", "", LOOK),
        Statistic::Within4 => (Path, "residual up to 4 bins off, first look", "", LOOK),
        Statistic::WithinAll => (Path, "residual of all bins, first look", "", LOOK),
        Statistic::Level => (Path, "of moves: a changing level", "", PART),
        Statistic::Bend => (Path, "of moves: a phase that bends", "", PART),
        Statistic::Twist => (Path, "of moves: a phase of order 3", "", PART),
        Statistic::Moves => (
            Alarm,
            "power along changes of the tone",
            "",
            ["it changes within the block: no steady tone", "no change beyond chance"],
        ),
        Statistic::Near2 => (Alarm, "residual up to 2 bins off", "", REST),
        Statistic::Near4 => (Alarm, "residual up to 4 bins off", "", REST),
        Statistic::All => (Alarm, "residual of all bins", "", REST),
        Statistic::Unexplained8 => (Alarm, "residual less changes, up to 8 bins off", "", ONE),
        Statistic::Unexplained => (Alarm, "residual less changes, of all bins", "", ONE),
        Statistic::Share => (
            Alarm,
            "what changes do not explain over what they do",
            "",
            ["too much for one tone: unresolved", "changes explain most: moving"],
        ),
        Statistic::ClippedResidual => (
            Alarm,
            "residual over the noise, of clipped samples",
            "",
            ["more than the harmonics of clipping: unresolved", "as noise and clipping leave"],
        ),
        Statistic::ImageShare => (
            Alarm,
            "line at minus the frequency over the tone",
            "dB",
            ["stronger than a front end should make", "weaker than a front end may make"],
        ),
        Statistic::ImageNoise => (
            Alarm,
            "line at minus the frequency over the noise",
            "dB",
            ["and no noise: image", "it may be noise"],
        ),
        Statistic::OtherLines => (
            Path,
            "power of the band's other bins over the tone's",
            "dB",
            ["looked at the power of the samples", "the tone is nearly all there is"],
        ),
        Statistic::TwoTones => (
            Alarm,
            "power of the samples over the most of two tones between the rails",
            "",
            ["no tones have so much: front-end", "as tones between the rails may have"],
        ),
        Statistic::ThreeTones => (
            Path,
            "power of the samples over the most of three tones between the rails",
            "",
            ["too much for three tones: counted the lines", "as tones between the rails may have"],
        ),
        Statistic::Lines => (
            Alarm,
            "lines with a fiftieth of the tone's power or more",
            "",
            ["three or more with so much power: front-end", "two tones may have so much"],
        ),
        Statistic::Exchanged => (
            Path,
            "line where exchanged samples put one, over the noise",
            "sigma",
            ["compared with what an exchange makes", "no such line"],
        ),
        Statistic::ExchangedRest => (
            Must,
            "what an exchange of samples leaves of that line",
            "",
            ["it is another line", "nothing: front-end"],
        ),
        // None of these, see above.
        _ => (Path, "", "", PART),
    }
}
