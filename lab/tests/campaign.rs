//! The campaign of impairments as a user runs it.

use std::process::{Command, Output};

fn sweep(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_lab")).arg("sweep").args(arguments).output().unwrap()
}

#[test]
fn the_campaign_in_json() {
    let run = || {
        let output = sweep(&[
            "--impair",
            "none,chirp:0.3,quantise:20,second-tone:offset=0.5,level-db=-10,keying:4+dc:0.01",
            "--method",
            "least-squares-real,z-rife",
            "--snr-db",
            "10,30",
            "--trials",
            "60",
            "--json",
        ]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    let text = run();
    assert_eq!(text, run());
    let lines: Vec<serde_json::Value> =
        text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let (summary, cells) = lines.split_last().unwrap();
    // Rounding alone has no ratio, and is measured once.
    assert_eq!((summary["cells"].as_u64(), cells.len()), (Some(18), 18));
    for cell in cells {
        let count = |key: &str| cell[key].as_u64().unwrap();
        assert_eq!(count("right") + count("flagged") + count("overconfident"), 60, "{cell}");
        assert!(count("false_flag") <= count("flagged"), "{cell}");
        let verdicts = cell["verdicts"].as_object().unwrap();
        assert_eq!(verdicts.values().map(|v| v.as_u64().unwrap()).sum::<u64>(), 60, "{cell}");
        assert!(
            (cell["overconfident_share"].as_f64().unwrap() - count("overconfident") as f64 / 60.0)
                .abs()
                < 1e-9
        );
        for key in "impair method kind n snr_db arith trials outliers rmse_bins bound_bins ratio rms_z z2_good".split(' ') {
            assert!(cell.get(key).is_some(), "no {key} in {cell}");
        }
        assert_eq!(cell["arith"], "target");
    }
    let find = |impair: &str, method: &str, snr_db: f64| {
        let found = |c: &&serde_json::Value| {
            c["impair"] == impair && c["method"] == method && c["snr_db"] == snr_db
        };
        cells.iter().find(found).unwrap()
    };
    assert_eq!(find("chirp", "z-rife", 10.0)["rate_bins"], 0.3);
    let second = find("second-tone", "least-squares-real", 30.0);
    assert_eq!((&second["offset_bins"], &second["level_db"]), (&0.5.into(), &(-10.0).into()));
    let pair = find("keying+dc", "least-squares-real", 30.0);
    assert_eq!((&pair["keying_bits"], &pair["dc_fs"]), (&4.0.into(), &0.01.into()));
    // A pure tone is right, and sigma the error: 60 squares spread by a fifth.
    let none = find("none", "least-squares-real", 30.0);
    assert!(none["right"].as_u64() >= Some(59), "{none}");
    assert!((0.4..1.6).contains(&none["z2_good"].as_f64().unwrap()), "{none}");
    assert!((0.7..1.3).contains(&none["ratio"].as_f64().unwrap()), "{none}");
    // Its neighbour looks like a change: no answer says that all is well.
    assert!(second["ratio"].as_f64().unwrap() > 3.0, "{second}");
    assert!(second["z2_good"].is_null(), "{second}");
}

#[test]
fn campaigns_that_cannot_be() {
    let refused = |arguments: &[&str], says: &str| {
        let output = sweep(arguments);
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), message.lines().count()), (Some(2), 1), "{message}");
        assert!(
            message.starts_with("error: ") && message.contains(says),
            "{arguments:?}: {message}"
        );
        assert!(output.stdout.is_empty());
    };
    refused(&["--impair", "nothing"], "no impairment \"nothing\"");
    refused(&["--impair", "chirp:rate"], "rate");
    refused(&["--impair", "iq-dead"], "add --kind complex");
    refused(&["--impair", "swapped", "--kind", "complex"], "leave --kind complex out");
    refused(&["--impair", "hum+iq-dead"], "add --kind complex");
    refused(&["--impair", "hum+none"], "hum alone is the same");
    refused(&["--impair", "dc", "--bins", "4:600"], "choose from 0 to 512");
    refused(&["--impair", "dc", "--bins", "9:4"], "low end first");
    refused(&["--impair", "dc", "--bin", "9"], "--bin");
    refused(&["--bins", "4:9"], "--impair");
    refused(&["--impair", "dc", "--trials", "0"], "at least 1");
    refused(&["--impair", "dc", "--method", "ml"], "lab sweep --arith f64");
    refused(&["--impair", "dc", "--arith", "f32"], "add --arith target");
    let list = sweep(&["--impair", "list"]);
    let text = String::from_utf8(list.stdout).unwrap();
    assert!(
        list.status.success()
            && text.contains("phase-jump")
            && text.contains("size=0.05/0.1/0.3 rad")
            && text.contains("  speckle  ")
            && text.contains("chirp:0.3+hum")
    );
    assert!(text.lines().all(|line| line.len() <= 120), "{text}");
}
