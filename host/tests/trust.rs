//! docs/trust.md: a section for each verdict, and pictures that are made again here.

use picket_dsp::tone::Verdict;
use picket_host::report::verdicts::EXAMPLES;
use std::fs;
use std::path::Path;

const PAGE: &str = include_str!("../../docs/trust.md");

#[test]
fn every_verdict_has_its_section_and_picture() {
    for verdict in Verdict::ALL {
        let name = verdict.name();
        assert!(PAGE.contains(&format!("\n## {name}\n")), "no section {name}");
        // That the wrong codes were stated is in no spectrum, nor is which of several targets there is.
        let shown = EXAMPLES.iter().any(|example| example.verdict == name);
        let unseen = [Verdict::WrongCodes, Verdict::Ambiguous].contains(&verdict);
        assert!(shown || unseen, "no picture of {name}");
    }
    for example in &EXAMPLES {
        assert!(PAGE.contains(&format!("]({}.svg)", example.picture)), "{}", example.picture);
    }
}

/// The page's table says of every verdict what the library says it may be used for, from the best to the worst.
#[test]
fn the_table_says_what_a_verdict_may_be_used_for() {
    let rows = PAGE.lines().filter_map(|line| line.strip_prefix("| [")?.strip_suffix(" |"));
    let rows: Vec<(&str, &str)> = rows
        .map(|row| (row.split(']').next().unwrap_or(""), row.rsplit("| ").next().unwrap_or("")))
        .collect();
    assert_eq!(rows.len(), Verdict::ALL.len());
    for (verdict, (name, usable)) in Verdict::ALL.into_iter().zip(rows) {
        assert_eq!(name, verdict.name());
        let ours = verdict.usable().name();
        let rest = usable.strip_prefix(ours);
        let ends = |rest: &str| !rest.starts_with(char::is_alphanumeric);
        assert!(rest.is_some_and(ends), "{name}: \"{usable}\", not \"{ours}\"");
    }
}

/// `PICKET_WRITE_PICTURES=1 cargo test -p picket-host trust` writes them anew.
#[test]
fn pictures_are_those_of_the_page() {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs");
    for example in &EXAMPLES {
        let (answer, chart) = example.picture().unwrap();
        println!("{}: {answer:?}", example.picture);
        assert_eq!(answer.verdict.name(), example.verdict, "{answer:?}");
        if std::env::var_os("PICKET_WRITE_PICTURES").is_some() {
            fs::write(docs.join(format!("{}.svg", example.picture)), chart.svg().unwrap()).unwrap();
        }
        let file = docs.join(format!("{}.svg", example.picture));
        let drawn = fs::read_to_string(&file).unwrap_or_default();
        assert!(
            drawn == chart.svg().unwrap(),
            "{} is not what `cargo picket report` makes: copy target/report/{}.svg",
            file.display(),
            example.picture
        );
    }
}
