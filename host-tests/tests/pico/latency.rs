//! From a block's last sample to the last byte of its record.

use crate::scene::{Hard, plug, set_plan, settings, stream};
use host_tests::figures::hold;
use host_tests::sized;
use picket_dsp::Config;
use picket_firmware::pico::N;
use picket_host::rates;

/// How far the time goes between two looks at the board, us: the error of a delay.
const STEP: u64 = 20;

/// The delays of this many blocks, us, from the least to the longest.
fn delays(rate_hz: f64, samples: &[i16], blocks: usize) -> Vec<f64> {
    let mut pico = plug();
    pico.power().unwrap();
    let settings = settings();
    let settings = picket_wire::settings::Settings {
        config: Config { rate_hz, ..settings.config },
        ..settings
    };
    set_plan(&mut pico, settings, |pico| {
        pico.keep(N).unwrap();
        pico.samples(samples).unwrap();
    });
    let mut sent = Vec::new();
    while sent.len() < blocks {
        pico.run(STEP).unwrap();
        let now = pico.now;
        for record in pico.telemetry() {
            assert_eq!(record.health.lost, 0);
            sent.push((record.measurement.stamp.sequence, now));
        }
    }
    let ended = pico.kept(N).unwrap();
    let delay = |(sequence, now): (u32, u64)| now as f64 - ended[sequence as usize].nanos / 1e3;
    let mut delays: Vec<f64> = sent.into_iter().map(delay).collect();
    delays.sort_unstable_by(f64::total_cmp);
    delays
}

#[test]
fn a_record_follows_its_block() {
    let blocks = sized(60, 5_000) as usize;
    let median_and_most = |rate_hz, samples: &[i16]| {
        let delays = delays(rate_hz, samples, blocks);
        [delays[blocks / 2], delays[blocks - 1]].map(|delay| delay / 1e3)
    };
    let usual = median_and_most(500e3, &stream(61, None, 25));
    let (_, slow) = rates::pico()[0].always_hz[0];
    let hard = median_and_most(slow, &stream(61, Some((1, Hard::Drifting)), 26));
    println!(
        "ms from the last sample to the record's last byte, median and most: usual {usual:?}, hard {hard:?}"
    );
    hold("pico, ms to a usual block's record", 0.01, &usual);
    hold("pico, ms to the longest block's record", 0.01, &hard);
}
