//! Wrong invocations of `lab`: each ends in one line, with exit code 2.

use crate::program::{lines, refused};

const SWEEP: &str = "sweep";

/// Wrong values of an option, by command.
const VALUES: &[(&str, &str, &[&str])] = &[
    ("sweep", "--method", &["x", "", "fesa", "least-squares"]),
    ("sweep", "--kind", &["x", ""]),
    ("sweep", "--n", &["0", "x", "2", "99999999", "-4"]),
    ("sweep", "--snr-db", &["x", "nan", "-inf", ""]),
    ("sweep", "--delta-points", &["0", "x", "999999"]),
    ("sweep", "--delta", &["x", "2", "nan"]),
    ("sweep", "--trials", &["0", "2e12", "2000000000000", "x", "10000000"]),
    ("sweep", "--bits", &["13", "x"]),
    ("sweep", "--amplitude", &["0", "-1", "nan", "x"]),
    ("sweep", "--dc", &["nan", "x", "inf"]),
    ("sweep", "--bin", &["600", "nan", "x", "1e9"]),
    ("sweep", "--seed", &["-1", "x"]),
    ("bench", "--core", &["x", "M9", ""]),
    ("bench", "--engine", &["x", "i64"]),
    ("bench", "--n", &["100", "0", "x"]),
    ("bench", "--k", &["5", "x"]),
    ("report", "--out", &["/dev/null/x"]),
    ("report", "--seed", &["x", "-1"]),
];

#[test]
fn wrong_values() {
    for &(command, option, values) in VALUES {
        refused(command, &[option], option);
        for value in values {
            refused(command, &[option, value], "");
        }
    }
    for whole in [
        "firmware",
        "soak x",
        "firmware x",
        "sweep x",
        "bench x",
        "report x",
        "report --quick --json x",
    ] {
        let words: Vec<&str> = whole.split(' ').collect();
        refused(words[0], &words[1..], "");
    }
}

#[test]
fn options_that_do_not_fit() {
    refused(SWEEP, &["--method", "least-squares"], "least-squares works on I/Q records only");
    refused(SWEEP, &["--snr-db", "loud"], "loud");
    refused(SWEEP, &["--n", "1000", "--arith", "target"], "choose 512 or 1024");
    refused(SWEEP, &["--trials", "0"], "at least 1");
    refused(SWEEP, &["--bits", "13"], "13");
    refused(SWEEP, &["--bin", "600"], "--bin 600");
}

#[test]
fn sweeps_in_json() {
    let flags = ["--method", "z-rife,rife", "--snr-db", "0,20", "--trials", "20", "--json"];
    let rows = lines(SWEEP, &flags);
    assert_eq!(rows.len(), 5);
    for key in "method kind n snr_db arith trials outliers rmse_bins rmse_se_bins mean_abs_bins bias_bins bound_bins ratio".split(' ') {
        assert!(!rows[0][key].is_null(), "{key}");
    }
    assert_eq!(rows[4]["summary"], true);
}
