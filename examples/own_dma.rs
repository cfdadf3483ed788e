//! A DMA controller that fills slots one after the other, as the front end wants it: here a thread of the desk stands for the
//! hardware. On a board the three methods of [`Dma`] touch its registers. `cargo run --example own_dma`.

use picket_dsp::acquire::frontend::{Dma, FrontEnd, Status, Timing};
use picket_dsp::{Codes, Config, ConfigError, Pipeline, Real};

const N: usize = 256;
/// The right to a record's memory.
type Slot = &'static mut [i16; N];

/// Fills the slot it holds with a tone.
struct Hardware {
    slot: Slot,
    sample: u32,
    done: u32,
}

impl Hardware {
    /// What the hardware does between two interrupts.
    fn fill(&mut self) {
        for place in self.slot.iter_mut() {
            *place = (1500.0 * (0.3 * f64::from(self.sample)).sin()).round() as i16;
            self.sample += 1;
        }
        self.done += 1;
    }
}

impl Dma for Hardware {
    type Slot = Slot;

    fn status(&mut self) -> Status {
        Status { completed: std::mem::take(&mut self.done), ..Status::default() }
    }

    fn exchange(&mut self, empty: Slot) -> Result<Slot, Slot> {
        Ok(std::mem::replace(&mut self.slot, empty))
    }

    fn restart(&mut self) -> u32 {
        1
    }
}

fn main() -> Result<(), ConfigError> {
    let [first, second] = [[0; N]; 2].map(|memory| Box::leak(Box::new(memory)));
    let mut front_end = FrontEnd::<Slot, 2>::new();
    let hardware = Hardware { slot: first, sample: 0, done: 0 };
    let (mut filler, mut blocks) =
        front_end.split(hardware, Timing::continuous(N as u32), [second]);
    let config = Config::new(1e6, Codes::signed::<12>());
    let mut pipeline = Pipeline::<Real, N>::new(config.plan()?);
    for _ in 0..5 {
        filler.dma().fill();
        // On a board: the interrupt at the end of a transfer.
        filler.interrupt();
        // On a board: the main loop.
        blocks.process(|stamp, counters, samples| {
            let tone = pipeline.block(stamp, samples).tone;
            println!("block {}: {tone}, {} lost", stamp.sequence, counters.lost());
            assert!((tone.hertz() - 0.3e6 / std::f64::consts::TAU).abs() < 1.0);
        });
    }
    Ok(())
}
