//! The speed that the documents state is the budget, which `budget.rs` holds against what is counted.

use host_tests::figures::Document;
use picket_firmware::pico::words::WORST_CYCLES;
use serde_json::Value;

fn budgets() -> Value {
    serde_json::from_str(include_str!("../budget.json")).unwrap()
}

#[test]
fn the_documents_state_the_budget() {
    let (page, budgets) = (Document::performance(), budgets());
    let figure = |path: &str| budgets.pointer(path).and_then(Value::as_f64).expect(path);
    let i32 =
        |n: &str, stage: &str| figure(&format!("/engines/picket-i32/instructions/{n}/{stage}"));
    let q15 =
        |n: &str, stage: &str| figure(&format!("/engines/picket-q15/instructions/{n}/{stage}"));
    let cycles = |engine: &str, n: &str, stage: &str| {
        figure(&format!("/engines/{engine}/cycles/{n}/{stage}"))
    };
    page.assert_states(
        "| **Picket: FFT, peak and noise floor**, cycles | # | # | # |",
        &["256", "1024", "4096"].map(|n| cycles("picket-i32", n, "fft_peak")),
    );
    page.assert_states(
        "| **Picket: all of it, to frequency, sigma and verdict**, cycles | # | # | # |",
        &["256", "1024", "4096"].map(|n| cycles("picket-i32", n, "measurement")),
    );
    page.assert_states(
        "| **Picket: FFT, peak and noise floor** | # | # | # |",
        &["256", "1024", "4096"].map(|n| i32(n, "fft_peak")),
    );
    page.assert_states(
        "| **Picket: all of it, to frequency, sigma and verdict** | # | # | # |",
        &["256", "1024", "4096"].map(|n| i32(n, "measurement")),
    );
    for (row, effort) in [("at most, cycles", "one"), ("at most at effort `look`, cycles", "look")]
    {
        let most = |n| figure(&format!("/ceilings/M4F/real/{n}/{effort}/1"));
        page.assert_states(
            &format!("| all of it, {row} | # | # | # |"),
            &["256", "1024", "4096"].map(most),
        );
    }
    Document::readme().assert_states(
        "a block of 1,024 real samples takes # modelled cycles, from the samples to",
        &[cycles("picket-i32", "1024", "measurement")],
    );
    for (row, place) in [
        ("M4F, N = 64", "M4F/real/64"),
        ("M4F, 256", "M4F/real/256"),
        ("M4F, 1024", "M4F/real/1024"),
        ("M4F, 1024, I/Q", "M4F/iq/1024"),
        ("M4F, 4096", "M4F/real/4096"),
        ("M3, 1024", "M3/real/1024"),
        ("M0 and M0+, 1024", "M0/real/1024"),
    ] {
        let ceilings = ["look/0", "look/1", "one/0", "one/1"];
        page.assert_states(
            &format!("| {row} | # / # | # / # |"),
            &ceilings.map(|which| figure(&format!("/ceilings/{place}/{which}"))),
        );
    }
    let [look, one] = ["look", "one"].map(|effort| {
        [0, 1].map(|which| figure(&format!("/ceilings/M0/real/1024/{effort}/{which}")))
    });
    let pico = Document::pico();
    pico.assert_states("more than # instructions at `look` and # at `one`", &[look[0], one[0]]);
    pico.assert_states("# and # modelled cycles", &[look[1], one[1]]);
    assert_eq!(WORST_CYCLES.map(|cycles| cycles as f64), [look[1], one[1]]);
    page.assert_states(
        "| M55, 1024 | # | # |",
        &["look", "one"].map(|effort| figure(&format!("/ceilings/M55/real/1024/{effort}/0"))),
    );
    page.assert_states(
        "| 16-bit engine: FFT, peak and noise floor | # | # | # |",
        &["256", "1024", "4096"].map(|n| cycles("picket-q15", n, "fft_peak")),
    );
    page.assert_states(
        "| 16-bit engine: all of it | | # |",
        &[cycles("picket-q15", "1024", "measurement")],
    );
    page.assert_states(
        "a trapezoid's three tones take # instructions on the M4F and # on M0 and M0+",
        &[i32("1024", "chirp"), figure("/portable/M0/chirp")],
    );
    for (row, core) in [("M3", "M3"), ("M0+", "M0")] {
        for (what, stage) in
            [("FFT, peak and noise floor", "fft_peak"), ("all of it", "measurement")]
        {
            page.assert_states(
                &format!("| {row}: {what} | | # |"),
                &[figure(&format!("/portable_cycles/{core}/{stage}"))],
            );
        }
    }
    page.assert_states(
        "| **16-bit engine: FFT, peak and noise floor** | # | # | # |",
        &["256", "1024", "4096"].map(|n| q15(n, "fft_peak")),
    );
    page.assert_states("| **16-bit engine: all of it** | | # |", &[q15("1024", "measurement")]);
    let f32 =
        |n: &str, stage: &str| figure(&format!("/engines/picket-f32/instructions/{n}/{stage}"));
    page.assert_states(
        "| **Float engine (microfft): FFT, peak and noise floor** | # | # | # |",
        &["256", "1024", "4096"].map(|n| f32(n, "fft_peak")),
    );
    page.assert_states(
        "| **Float engine: all of it** | # | # | # |",
        &["256", "1024", "4096"].map(|n| f32(n, "measurement")),
    );
    let each = |kind: &str| {
        (figure(&format!("/band/400/{kind}")) - figure(&format!("/band/100/{kind}"))) / 300.0
    };
    page.assert_states(
        "a further bin costs at most # instructions, or # of an I/Q record; of a whole real spectrum a bin costs #.",
        &[each("0"), each("1"), i32("1024", "peak") / 511.0],
    );
    page.assert_states(
        "# bytes of RAM at N = 1024 with two records and the result, where the default needs #",
        &["picket-q15", "picket-i32"]
            .map(|engine| figure(&format!("/engines/{engine}/ram_bytes/1024"))),
    );
    page.assert_states(
        "| M3, median | | # | # | # |",
        &["fft_peak", "estimator", "measurement"]
            .map(|stage| figure(&format!("/portable/M3/{stage}"))),
    );
    page.assert_states(
        "| M0 and M0+, median | # | # | # | # |",
        &["fft", "fft_peak", "estimator", "measurement"]
            .map(|stage| figure(&format!("/portable/M0/{stage}"))),
    );
    page.assert_states(
        "| **With Helium: FFT, peak and noise floor** | # | # | # |",
        &["256", "1024", "4096"].map(|n| figure(&format!("/helium/{n}/fft_peak/0"))),
    );
    page.assert_states(
        "| with Helium, worst | # | # | # |",
        &["256", "1024", "4096"].map(|n| figure(&format!("/helium/{n}/fft_peak/1"))),
    );
    page.assert_states(
        "| **With Helium: all of it, to frequency, sigma and verdict** | | # |",
        &[figure("/helium/1024/measurement/0")],
    );
    page.assert_states(
        "| **With Helium and the 16-bit engine: FFT, peak and noise floor** | # | # | # |",
        &["256", "1024", "4096"].map(|n| figure(&format!("/helium_q15/{n}/q15_fft_peak/0"))),
    );
    page.assert_states(
        "| with Helium and that engine, worst | # | # | # |",
        &["256", "1024", "4096"].map(|n| figure(&format!("/helium_q15/{n}/q15_fft_peak/1"))),
    );
    page.assert_states(
        "| **All of it, with Helium and that engine** | | # |",
        &[figure("/helium_q15/1024/measurement/0")],
    );
    page.assert_states(
        "take between # cycles, if every two neighbours overlap, and #, if none do",
        &[1.1, 2.1].map(|cycles| cycles * figure("/helium/1024/fft_peak/0")),
    );
    page.assert_states(
        "By the 16-bit engine it is # to # cycles",
        &[1.1, 2.1].map(|cycles| cycles * figure("/helium_q15/1024/q15_fft_peak/0")),
    );
    Document::precision().assert_states(
        "takes # instructions a block of 1024, and # with the search for clipped samples and the filter, where a whole measurement takes #",
        &["lock", "locked", "whole"].map(|stage| figure(&format!("/locked/{stage}"))),
    );
    page.assert_states(
        "calls `Pipeline::tone`: # KB of program memory",
        &[figure("/single_images/M4F/0") / 1000.0],
    );
    page.assert_states(
        "by `FrequencyOnly`, it takes # KB",
        &[figure("/single_images/M4F/1") / 1000.0],
    );
}
