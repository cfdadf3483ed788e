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

/// Sense, what is compared, its unit, and the result of a value above the limit and of another. A power counts in multiples of the
/// noise's.
const fn of(statistic: Statistic) -> (Sense, &'static str, &'static str, [&'static str; 2]) {
    use Sense::{Alarm, Must, Path};
    const TOLD: [&str; 2] = ["above this noise", "it may be noise: weak"];
    const EITHER: [&str; 2] = ["above this noise", "not by this test"];
    const LOOK: [&str; 2] = ["needs a closer look", "no more than noise leaves"];
    const REST: [&str; 2] = ["more than noise leaves: not a steady tone", "as noise leaves"];
    const PART: [&str; 2] = ["-"; 2];
    const ONE: [&str; 2] =
        ["changes of one tone do not explain it", "changes of one tone explain it"];
    match statistic {
        Statistic::Floor => (Must, "line over the mean of the band's other bins", "dB", TOLD),
        Statistic::FarAbove => (
            Path,
            "line over the loudest noise near it",
            "dB",
            ["far above: no other test is needed", "not far above: more tests of detection"],
        ),
        Statistic::Hump => (
            Path,
            "noise near the line over the ring's",
            "",
            [
                "the ring does not show this noise: the residual decides",
                "the ring shows this noise",
            ],
        ),
        Statistic::MiddleResidual => {
            (Must, "line over the median of three residuals", "dB", EITHER)
        }
        Statistic::LeastResidual => (Must, "line over the smallest of three residuals", "dB", TOLD),
        Statistic::MeanResidual => (Must, "line over the mean residual", "dB", TOLD),
        Statistic::WideRing => (Must, "line over the noise of a wide ring", "dB", TOLD),
        Statistic::Ring => (Must, "line over the noise of the louder side", "dB", TOLD),
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
            "noise of the louder side over the quieter one's",
            "dB",
            ["an edge in the noise: the residual gives the noise", "noise alike on both sides"],
        ),
        Statistic::Changes => {
            (Path, "power along changes of the tone, first look", "x noise", LOOK)
        }
        Statistic::Within2 => (Path, "residual up to 2 bins off, first look", "x noise", LOOK),
        Statistic::Within4 => (Path, "residual up to 4 bins off, first look", "x noise", LOOK),
        Statistic::WithinAll => (Path, "residual of all bins, first look", "x noise", LOOK),
        Statistic::Level => (Path, "part of moves: a changing level", "x noise", PART),
        Statistic::Bend => (Path, "part of moves: a phase that bends", "x noise", PART),
        Statistic::Twist => (Path, "part of moves: a phase of order 3", "x noise", PART),
        Statistic::Moves => (
            Alarm,
            "power along changes of the tone",
            "x noise",
            ["it changes within the block: not a steady tone", "no change beyond chance"],
        ),
        Statistic::Near2 => (Alarm, "residual up to 2 bins off", "x noise", REST),
        Statistic::Near4 => (Alarm, "residual up to 4 bins off", "x noise", REST),
        Statistic::All => (Alarm, "residual of all bins", "x noise", REST),
        Statistic::Unexplained8 => {
            (Alarm, "residual without changes, up to 8 bins off", "x noise", ONE)
        }
        Statistic::Unexplained => (Alarm, "residual without changes, all bins", "x noise", ONE),
        Statistic::Share => (
            Alarm,
            "power that changes do not explain, over what they explain",
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
            ["the power of the samples must be compared", "the tone has nearly all the power"],
        ),
        Statistic::TwoTones => (
            Alarm,
            "power of the samples over the largest of two tones between the rails",
            "",
            ["more than any tones: front-end", "as tones between the rails may have"],
        ),
        Statistic::ThreeTones => (
            Path,
            "power of the samples over the largest of three tones between the rails",
            "",
            [
                "too much for three tones: the lines are counted",
                "as tones between the rails may have",
            ],
        ),
        Statistic::Lines => (
            Alarm,
            "lines with a fiftieth of the tone's power or more",
            "",
            ["three or more: front-end", "as two tones may have"],
        ),
        Statistic::Exchanged => (
            Path,
            "line that exchanged samples would make, over the noise",
            "sigma",
            ["must be compared with the line of an exchange", "no such line"],
        ),
        Statistic::ExchangedRest => (
            Must,
            "residual of that line after an exchange of samples",
            "",
            ["it is another line", "nothing: front-end"],
        ),
        // None of these, see above.
        _ => (Path, "", "", PART),
    }
}
