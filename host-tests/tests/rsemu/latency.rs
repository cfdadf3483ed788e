//! From a block's last sample to the last byte of its record.

use crate::settings::tone;
use crate::streams::{fed, moving, table};
use host_tests::figures::hold;
use host_tests::sized;
use picket_firmware::nucleo_f446re::N;

/// How far the time goes between two looks at the board, us: the error of a delay.
const STEP: u64 = 10;

/// The delays of this many blocks at 500 kS/s, us, from the least to the longest.
fn delays(codes: &[u16], blocks: usize) -> Vec<u64> {
    let mut board = fed(&tone(500e3), codes);
    board.order("power");
    let (mut left, mut ended, mut delays) = (0, Vec::new(), Vec::new());
    while delays.len() < blocks {
        board.run(STEP);
        // DMA2's stream 0, S0NDTR (RM0390, 9.5.6): the samples that are left of a block.
        let before = std::mem::replace(&mut left, board.read(0x4002_6414));
        if before != 0 && left > before {
            ended.push(board.now);
        }
        for record in board.telemetry() {
            let stamp = record.measurement.stamp;
            assert_eq!(record.health.lost, 0);
            assert!(u64::from(left) <= N as u64, "no block of {N}: {left}");
            delays.push(board.now - ended[stamp.sequence as usize]);
        }
        assert!(board.now < 5_000_000 + 4_096 * blocks as u64, "no records");
    }
    delays.sort_unstable();
    delays
}

#[test]
fn a_record_follows_its_block() {
    let blocks = sized(60, 5_000) as usize;
    let median_and_most = |codes: &[u16]| {
        let delays = delays(codes, blocks);
        [delays[blocks / 2], delays[blocks - 1]].map(|delay| delay as f64 / 1e3)
    };
    let steady = median_and_most(&table(900.0));
    let hard = median_and_most(&moving(61));
    println!(
        "ms from the last sample to the record's last byte, median and most: steady {steady:?}, hard {hard:?}"
    );
    hold("board, ms to a steady tone's record", 0.01, &steady);
    hold("board, ms to the longest block's record", 0.01, &hard);
}
