//! Counts the instructions of a block that is measured where its tone is expected, and of a whole search of this block. The image sends its
//! measurements and tracks, for comparison with other machines. It also compares the kernels with their definition, on random blocks of
//! every length and kind. The header's period has another meaning here: the number of these blocks.
#![no_std]
#![no_main]

use core::hint::black_box;
use cortex_m_rt::entry;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::{Data, Iq, Real, Record, Segment, Stamp, Statistics};
use picket_dsp::pipeline::Pipeline;
use picket_dsp::plan::Plan;
use picket_dsp::spectrum::fft::twiddle::MAX_LENGTH;
use picket_dsp::spectrum::layout::Layout;
use picket_dsp::spectrum::zoom::Oscillator;
use picket_dsp::tone::Tone;
use picket_dsp::tone::lock::Lock;
use picket_dsp::tone::zoomed::{self, Place};
use picket_dsp::tracker::Tracker;
use picket_firmware::mps2::count::{Random, count, measured};
use picket_firmware::mps2::halt::{Exit, exit};
use picket_firmware::mps2::playback::{Playback, fail, send};
use picket_firmware::mps2::{Timer, Uart, figure, handlers};
use picket_wire::capture::decode;
use picket_wire::follow::Follow;
use picket_wire::telemetry::Health;

picket_firmware::vectors!(handlers(&[]));

/// Samples in a block.
const N: usize = 1024;

#[entry]
fn main() -> ! {
    let mut playback = Playback::open();
    let header = playback.header;
    if header.iq || header.n as usize != N {
        fail(Exit::Config, "this image takes real records of 1024 samples");
    }
    Timer::ONE.run_free();
    let plan = playback.plan::<Real, N>();
    let mut pipeline = Pipeline::<Real, N>::new(plan);
    let mut tracker = Tracker::<Real, N>::new(plan);
    let (mut bytes, mut samples) = ([0; 2 * N], [0; N]);
    for sequence in 0..header.blocks {
        playback.read(&mut bytes);
        decode::<Real>(&bytes, &mut samples);
        let (samples, stamp) = (black_box(&samples), header.timing().stamp(sequence.into(), false));
        let tone = count("whole", || pipeline.block(&stamp, samples)).tone;
        count("clipped", || Statistics::clipped(Data::of::<Real>(samples), plan.codes));
        stages(&tone, samples);
        follow(&mut tracker, &plan, stamp, samples);
    }
    let mut equality = Equality { random: Random(20_220_222), compared: 0, unequal: 0 };
    for _ in 0..header.period_us {
        equality.kind::<Real>();
        equality.kind::<Iq>();
    }
    figure(Uart::ONE, "compared", equality.compared.into());
    figure(Uart::ONE, "unequal", equality.unequal.into());
    exit(Exit::Done)
}

/// Kernels compared with their definition.
struct Equality {
    random: Random,
    compared: u32,
    unequal: u32,
}

impl Equality {
    fn kind<R: Record>(&mut self) {
        self.compare::<R, 64>();
        self.compare::<R, 128>();
        self.compare::<R, 256>();
        self.compare::<R, 512>();
        self.compare::<R, 1024>();
        self.compare::<R, 2048>();
        self.compare::<R, 4096>();
    }

    /// Compares a random block about a random centre. One block in four has only samples at the
    /// rails, and one in four is a full-scale tone. A second block starts a sample later in memory,
    /// where the kernels may not load whole words.
    #[inline(never)]
    fn compare<R: Record, const N: usize>(&mut self) {
        let oscillator =
            Oscillator::new(self.random.draw() as i32 % N as i32, Layout::of::<R, N>());
        let mut buffer = [R::Sample::default(); MAX_LENGTH + 2];
        let (shape, weaker) = (self.random.draw() % 4, self.random.draw() % 16);
        let step = self.random.draw();
        for (sample, index) in buffer.iter_mut().zip(0u32..) {
            let mut part = |turned: u32| match shape {
                0 => [i16::MIN, i16::MAX][usize::from(self.random.draw() & 1 == 0)],
                // The first line of a triangle is a tone, and its rails are the codes' rails.
                1 => {
                    let turn = (step.wrapping_mul(index).wrapping_add(turned) >> 15) as i32;
                    ((turn - 65_536).abs() - 32_768).min(32_767) as i16
                }
                _ => (self.random.draw() as i16) >> weaker,
            };
            *sample = R::from_parts([part(0), part(1 << 30)]);
        }
        for start in 0..2 {
            let Some(samples) = buffer.get(start..).and_then(|samples| samples.first_chunk::<N>())
            else {
                return;
            };
            let kernel = oscillator.zoom::<R, N>(samples);
            self.compared = self.compared.wrapping_add(1);
            let clipped = Statistics::clipped(Data::of::<R>(samples), Codes::signed::<16>());
            let same = clipped
                == Statistics::from_samples(Data::of::<R>(samples), Codes::signed::<16>()).clipped;
            if !same || kernel != oscillator.zoom_portably::<R, N>(samples) {
                self.unequal = self.unequal.wrapping_add(1);
            }
        }
    }
}

/// The stages of a measurement where the tone is expected, for a tone just found.
fn stages(tone: &Tone, samples: &[i16; N]) {
    let expected = tone.frequency.cycles() as f32;
    let bins = expected * N as f32;
    let Some(centre) = zoomed::centre(bins, Layout::of::<Real, N>()) else { return };
    let (oscillator, place) = (
        Oscillator::new(centre, Layout::of::<Real, N>()),
        Place::new(centre, Layout::of::<Real, N>()),
    );
    let zoom = count("zoom", || oscillator.zoom::<Real, N>(samples));
    count("fit", || place.fit(&zoom, bins - centre as f32));
    if let Some(mut lock) = Lock::on(tone, Layout::of::<Real, N>()) {
        let layout = Layout::of::<Real, N>();
        count("lock", || {
            let zoom = lock.aim(expected, layout)?.zoom::<Real, N>(samples);
            lock.measure(&zoom, expected, 0, layout)
        });
    }
}

fn follow(tracker: &mut Tracker<Real, N>, plan: &Plan<Real, N>, stamp: Stamp, samples: &[i16; N]) {
    let (ticks, measurement) = measured(|| tracker.block(&stamp, samples));
    let way = if tracker.is_locked(Segment::Continuous) { "locked" } else { "searched" };
    figure(Uart::ONE, way, ticks.into());
    send(measurement, plan.options.method, Health::default());
    Uart::ZERO.send(&Follow::from_tracker(tracker, &stamp).to_frame());
}
