//! The instrument's lives on random bytes, seeded: `cargo run --release --example steps SECONDS [SEED]` says how many steps there were.
//! Without counters of what was reached it is several times as fast as `fuzz/run`.

use std::time::{Duration, Instant};

fn main() {
    let mut numbers = std::env::args().skip(1).map(|it| it.parse::<u64>().expect("a number"));
    let seconds = Duration::from_secs(numbers.next().unwrap_or(10));
    let seed = numbers.next().unwrap_or(1);
    println!("seed {seed}");
    // xorshift64*
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    let mut random = || {
        state ^= state >> 12;
        state ^= state << 25;
        state ^= state >> 27;
        state.wrapping_mul(0x2545_F491_4F6C_DD1D)
    };
    let (begin, mut lives, mut steps) = (Instant::now(), 0u64, 0u64);
    while begin.elapsed() < seconds {
        let length = 1 + random() % 256;
        let bytes: Vec<u8> = (0..length).flat_map(|_| random().to_le_bytes()).collect();
        let done = std::panic::catch_unwind(|| picket_fuzz::instrument::steps(&bytes));
        let Ok(done) = done else {
            println!("after {steps} steps: {bytes:?}");
            std::process::exit(1);
        };
        (lives, steps) = (lives + 1, steps + done);
    }
    let rate = steps as f64 / begin.elapsed().as_secs_f64();
    println!("{steps} steps in {lives} inputs, {rate:.0} a second");
}
