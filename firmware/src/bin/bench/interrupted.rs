//! Kernels under interrupts whose handler runs kernels, too.

use core::sync::atomic::{AtomicU32, Ordering};
use cortex_m_rt::exception;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::Real;
use picket_dsp::spectrum::Spectrum;
use picket_dsp::spectrum::engine::I32;
use picket_dsp::spectrum::peak::{Band, Peak, find, find_portably};
use picket_firmware::mps2::Timer;
use picket_firmware::mps2::count::Random;

/// The delay of an interrupt against the run before, in ticks: four instructions. The first interrupt comes before the kernels begin, the
/// last after they end.
const STEP: u32 = 9;
/// The number of runs of the kernels: nine thousand instructions are eighteen thousand ticks.
const RUNS: u32 = 2_200;

static INTERRUPTS: AtomicU32 = AtomicU32::new(0);
static UNEQUAL: AtomicU32 = AtomicU32::new(0);

/// Samples of a record and its spectrum by kernels and by their definition.
struct Record<const N: usize> {
    samples: [i16; N],
    kernel: Spectrum<Real, N, I32>,
    definition: Spectrum<Real, N, I32>,
    found: Option<Peak>,
}

impl<const N: usize> Record<N> {
    const CODES: Codes = Codes::signed::<12>();

    /// Random samples, transformed by the definition.
    fn new(seed: u32) -> Self {
        let (mut random, mut samples) = (Random(seed), [0; N]);
        samples.fill_with(|| (random.draw() >> 20) as i16 - 2048);
        let mut definition = Spectrum::new();
        definition.transform_portably(&samples, Self::CODES);
        let found = find_portably(&definition.view(), Band::real(N));
        Self { samples, kernel: Spectrum::new(), definition, found }
    }

    /// Transforms and searches by the kernels. Returns true if the results equal the definition's.
    fn run(&mut self) -> bool {
        self.kernel.transform(&self.samples, Self::CODES);
        let found = find(&self.kernel.view(), Band::real(N));
        self.kernel.points() == self.definition.points() && found == self.found
    }
}

/// Runs the kernels, each time with an interrupt at another place. Returns the number of interrupts, and the number of runs or interrupts
/// with a difference.
pub fn drive() -> (u32, u32) {
    let mut record = Record::<1024>::new(20_220_222);
    for run in 0..RUNS {
        Timer::ONE.start(run * STEP + 2);
        if !record.run() {
            UNEQUAL.fetch_add(1, Ordering::Relaxed);
        }
        Timer::ONE.stop();
    }
    Timer::ONE.run_free();
    (INTERRUPTS.load(Ordering::Relaxed), UNEQUAL.load(Ordering::Relaxed))
}

/// The timer's interrupt, once.
#[exception]
fn SysTick() {
    Timer::ONE.stop();
    INTERRUPTS.fetch_add(1, Ordering::Relaxed);
    if !Record::<256>::new(1).run() {
        UNEQUAL.fetch_add(1, Ordering::Relaxed);
    }
}
