//! An nRF52840's converter at 20 kHz, two buffers in turn by PPI: the lamp of a development kit shines while there is a good tone on
//! P0.02.
#![no_std]
#![no_main]

use core::ptr::NonNull;
use embassy_executor::Spawner;
use embassy_nrf::gpio::{Level, Output, OutputDrive};
use embassy_nrf::ppi::{Event, Ppi};
use embassy_nrf::saadc::{CallbackResult, ChannelConfig, Config, InterruptHandler, Saadc};
use embassy_nrf::timer::{Frequency, Timer};
use embassy_nrf::{bind_interrupts, pac};
use panic_halt as _;
use picket_dsp::{Codes, Format, Framer, Pipeline, Plan, Real, Verdict};

bind_interrupts!(struct Irqs {
    SAADC => InterruptHandler;
});

const RATE_HZ: f64 = 1e6 / 50.0;

#[embassy_executor::main]
async fn main(_spawner: Spawner) {
    let mut p = embassy_nrf::init(Default::default());
    // The lamp shines when its pin is low.
    let mut lamp = Output::new(p.P0_13, Level::High, OutputDrive::Standard);
    let channel = ChannelConfig::single_ended(p.P0_02);
    let mut saadc = Saadc::new(p.SAADC, Irqs, Config::default(), [channel]);
    saadc.calibrate().await;
    // A counter of full buffers, which the HAL does not have.
    let counter = Timer::new_counter(p.TIMER2);
    let Some(end) = NonNull::new(pac::SAADC.events_end().as_ptr()) else { return };
    // SAFETY: it is a register of an event.
    let end = unsafe { Event::new_unchecked(end) };
    let mut count = Ppi::new_one_to_one(p.PPI_CH2, end, counter.task_count());
    count.enable();
    counter.start();
    let mut halves = [[[0i16; 1]; 512]; 2];
    let mut pipeline = Pipeline::<Real, 1024>::new(Plan::tone(RATE_HZ, Codes::unsigned::<12>()));
    // Around 0 V a word may lie below zero.
    let mut framer = Framer::<Real, 1024>::new(Format::signed::<13>());
    loop {
        counter.clear();
        let mut taken = 0;
        let (timer, start, sample) =
            (p.TIMER1.reborrow(), p.PPI_CH0.reborrow(), p.PPI_CH1.reborrow());
        let each = |half: &[[i16; 1]]| {
            taken += 1;
            if counter.cc(0).capture() != taken {
                return CallbackResult::Stop;
            }
            framer.push(half.as_flattened(), |stamp, samples| {
                let (_, tone) = pipeline.tone(stamp, samples);
                lamp.set_level((tone.verdict != Verdict::Good).into());
            });
            CallbackResult::Continue
        };
        saadc.run_task_sampler(timer, start, sample, Frequency::F1MHz, 50, &mut halves, each).await;
        // A buffer was filled twice, so the sampler starts anew. Nobody knows how many samples are missing.
        framer.lost(1);
    }
}
