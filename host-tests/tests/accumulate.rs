//! Sums of blocks, by segments; their accuracy is in the table of claims.

use picket_dsp::config::Config;
use picket_dsp::{Accumulator, Codes, Pipeline, Real, Segment, Stamp, Verdict};

/// Each segment of a chirp has its sum, a gap does no harm, and silence is nothing.
#[test]
fn segments_silence_and_clearing() {
    let plan = Config::new(1.0, Codes::signed::<12>()).plan::<Real, 64>().unwrap();
    let mut pipeline = Pipeline::<Real, 64>::new(plan);
    let mut sum = Accumulator::<Real, 64>::new(3).for_segment(Segment::Down);
    let mut results = 0;
    for sequence in 0..12 {
        let segment = [Segment::Up, Segment::Down][sequence as usize % 2];
        let stamp = Stamp { sequence, segment, gap: sequence == 5, ..Stamp::default() };
        let measurement = pipeline.block(&stamp, &[7; 64]);
        results += i32::from(sum.add(&measurement, &pipeline).is_some_and(|seen| {
            assert_eq!((seen.tone.verdict, seen.blocks), (Verdict::NoSignal, 3));
            true
        }));
    }
    assert_eq!((results, sum.added()), (2, 0));
}
