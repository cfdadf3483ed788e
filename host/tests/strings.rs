//! Strings and reeds, whose fundamental is weaker than its partials, and the partials are stretched: the proposed command returns the
//! fundamental, and no good answer is another note.

use crate::cli::seed;
use crate::unknown::{picket, wav};
use picket_simulator::{Draw, Scene};
use serde_json::json;
use std::path::Path;

const STRINGS: usize = 32;
const RATE_HZ: f64 = 44_100.0;

/// A string's scene: its fundamental is the first source.
pub fn scene(first_hz: f64, weaker_db: f64, stretch: f64, decay_s: f64, draw: &mut Draw) -> Scene {
    let partial = |k: u32, draw: &mut Draw| {
        let order = f64::from(k);
        let ratio = order * ((1.0 + stretch * order * order) / (1.0 + stretch)).sqrt();
        // Falling from the second on, by some decibels here and there.
        let db = match k {
            1 => -weaker_db,
            _ => -3.0 * (order - 2.0) + draw.between(-4.0, 0.0),
        };
        let amplitude = 0.2 * 10f64.powf(db / 20.0);
        json!({"tone": {"frequency_hz": first_hz * ratio, "amplitude": amplitude, "phase_turns": [0, 1],
            "changes": [{"decay": {"time_s": decay_s}}]}})
    };
    let highest = (0.45 * RATE_HZ / first_hz).min(10.0) as u32;
    let sources: Vec<_> = (1..=highest).map(|k| partial(k, draw)).collect();
    let scene = json!({"seed": draw.bits(), "rate_hz": RATE_HZ, "seconds": 2.5, "sources": sources,
        "receiver": {"noise": {"rms": 3e-4}}});
    serde_json::from_value(scene).unwrap()
}

/// The frequencies of all answers to what a look proposes, and of the good ones.
fn answers(folder: &Path, name: &str) -> Option<[Vec<f64>; 2]> {
    let look = picket(folder, &["analyze".into(), name.into()]);
    let proposed = look.lines().find_map(|line| line.strip_prefix("try       picket "))?;
    let words = proposed.split(' ').map(str::to_owned).chain(["--json".into()]);
    let lines = picket(folder, &words.collect::<Vec<_>>());
    println!("{proposed}");
    let (mut all, mut good) = (Vec::new(), Vec::new());
    for line in lines.lines() {
        let line: serde_json::Value = serde_json::from_str(line).unwrap();
        if let Some(hz) = line["frequency_hz"].as_f64() {
            all.push(hz);
            good.extend((line["verdict"] == "good").then_some(hz));
        }
    }
    all.sort_by(f64::total_cmp);
    Some([all, good])
}

#[test]
fn the_fundamental_is_proposed() {
    let mut draw = Draw::new(seed(82), 0);
    let folder = crate::survey::folder("strings");
    let (mut right, mut octaves) = (0, 0);
    for index in 0..STRINGS {
        let first_hz = 82.4 * (draw.between(0.0, 3.0)).exp2();
        let (weaker_db, decay_s) = (draw.between(0.0, 20.0), draw.between(0.5, 3.0));
        let stretch = if index % 4 == 0 { 0.0 } else { 10f64.powf(draw.between(-6.0, -4.0)) };
        let scene = scene(first_hz, weaker_db, stretch, decay_s, &mut draw);
        let samples = scene.run(0).unwrap().voltages(0.0, (RATE_HZ * scene.seconds) as usize);
        let name = format!("{index}.wav");
        wav(&folder.join(&name), RATE_HZ, (1, 16), samples.iter().map(|x| x[0]));
        let Some([all, good]) = answers(&folder, &name) else {
            println!(
                "{index}: nothing proposed for {first_hz:.2} Hz, {weaker_db:.1} dB, B {stretch:.1e}, {decay_s:.2} s"
            );
            continue;
        };
        let cents = |hz: f64| 1200.0 * (hz / first_hz).log2();
        let median = all.get(all.len() / 2).map_or(f64::NAN, |hz| cents(*hz));
        right += usize::from(median.abs() < 2.0);
        let other = good.iter().filter(|hz| cents(**hz).abs() > 50.0).count();
        octaves += usize::from(other > 0);
        println!(
            "{index}: {median:.2} cents, {} good of {}, {other} of another note; {first_hz:.2} Hz, {weaker_db:.1} dB, B {stretch:.1e}, {decay_s:.2} s",
            good.len(),
            all.len()
        );
    }
    println!(
        "{right} of {STRINGS} fundamentals within 2 cents, {octaves} with a good answer of another note"
    );
    assert!(right >= 30 && octaves == 0, "{right} of {STRINGS} right, {octaves} of another note");
}
