//! docs/trust.md: a section and a picture for each verdict.

use picket_dsp::tone::Verdict;
use picket_lab::report::verdicts::EXAMPLES;

const PAGE: &str = include_str!("../../docs/trust.md");

#[test]
fn every_verdict_has_its_section_and_picture() {
    for verdict in Verdict::ALL {
        let name = verdict.name();
        assert!(PAGE.contains(&format!("\n## {name}\n")), "no section {name}");
        // That the wrong codes were stated is in no spectrum, nor is a prediction, or which of several targets there is.
        let shown = EXAMPLES.iter().any(|example| example.verdict == name);
        let unseen =
            matches!(verdict, Verdict::WrongCodes | Verdict::Coasting | Verdict::Ambiguous);
        assert!(shown || unseen, "no picture of {name}");
    }
    for example in &EXAMPLES {
        assert!(PAGE.contains(&format!("]({}.svg)", example.picture)), "{}", example.picture);
    }
}

/// The record of each picture has the verdict that it shows.
#[test]
fn every_example_has_its_verdict() {
    for example in &EXAMPLES {
        let (answer, _) = example.picture().unwrap();
        println!("{}: {answer:?}", example.picture);
        assert_eq!(answer.verdict.name(), example.verdict, "{answer:?}");
    }
}
