//! The bodies of the fuzz targets on the stable toolchain: the kept corpus, and damage to it.

#[path = "../../fuzz/src/lib.rs"]
mod targets;

use host_tests::sized;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::fs;
use std::panic::catch_unwind;
use std::path::Path;
use targets::TARGETS;

/// The inputs that are kept for a target. Each folder has some.
fn corpus(name: &str) -> Vec<(String, Vec<u8>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz/corpus").join(name);
    let entries = fs::read_dir(&folder).unwrap_or_else(|error| panic!("{name}: {error}"));
    let mut inputs: Vec<_> = entries
        .map(|entry| entry.unwrap().path())
        .map(|path| (path.display().to_string(), fs::read(&path).unwrap()))
        .collect();
    inputs.sort();
    assert!(!inputs.is_empty(), "{name} has no corpus");
    inputs
}

#[test]
fn every_kept_input_passes() {
    let mut bytes = 0;
    for (name, body) in TARGETS {
        for (path, input) in corpus(name) {
            bytes += input.len();
            assert!(catch_unwind(|| body(&input)).is_ok(), "{path}");
        }
        body(&[]);
    }
    assert!(bytes < 300_000, "the corpus has {bytes} bytes: merge it");
}

/// 2,000 damaged inputs for each target; a thousand times as many with `PICKET_LONG=1`.
#[test]
fn damage_to_the_corpus_passes() {
    println!("seed 231");
    let rounds = sized(2_000, 2_000_000);
    let mut rng = ChaCha8Rng::seed_from_u64(231);
    for (name, body) in TARGETS {
        let inputs = corpus(name);
        for round in 0..rounds {
            let (path, input) = &inputs[rng.random_range(0..inputs.len())];
            let mut input = input.clone();
            for _ in 0..rng.random_range(1..6) {
                damage(&mut input, &mut rng);
            }
            assert!(catch_unwind(|| body(&input)).is_ok(), "{path}, round {round}: {input:?}");
        }
    }
}

fn damage(input: &mut Vec<u8>, rng: &mut impl Rng) {
    let end = input.len();
    match rng.random_range(0..5) {
        _ if end == 0 => input.push(rng.random()),
        0 => input[rng.random_range(0..end)] ^= 1 << rng.random_range(0..8),
        1 => input[rng.random_range(0..end)] = rng.random(),
        2 => input.insert(rng.random_range(0..=end), rng.random()),
        3 => drop(input.remove(rng.random_range(0..end))),
        _ => input.truncate(rng.random_range(0..=end)),
    }
}
