//! The implementation of [`Board`](crate::board::Board).

use super::correct::correct;
use super::line::Serial;
use super::storage::{self, Flash};
use super::words::{BAUD, CORE_MHZ, Words};
use super::{N, SLOT, converter, line, start, widths};
use crate::board::{Board, Clocks, Port};
use crate::instrument::plan::Plan;
use crate::slot::Slot;
use crate::{fence, self_test};
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::frontend::{Blocks, Counters};
use picket_dsp::pipeline::Measurement;
use picket_wire::boot::{Causes, Clock};
use picket_wire::settings::Settings;
use picket_wire::settings_error::SettingsError;
use rp2040_hal::adc::{Adc, AdcPin};
use rp2040_hal::dma::DMAExt;
use rp2040_hal::fugit::RateExtU32;
use rp2040_hal::gpio::{FunctionPwm, FunctionUart, PinState, Pins, PullUp};
use rp2040_hal::pwm::Slices;
use rp2040_hal::uart::{DataBits, StopBits, UartConfig, UartPeripheral};
use rp2040_hal::{Clock as _, Sio, Timer, pac};

/// The Raspberry Pi Pico.
pub struct Pico {
    serial: Serial,
    /// Whether the converter's codes are corrected.
    corrects: bool,
    /// Whether the samples are pairs.
    iq: bool,
    /// Samples of a guard, which is even, and 0 for pairs.
    guard: usize,
}

impl Port<N, SLOT> for Pico {
    const NAME: &'static str = "pico";
    const CODES: Codes = Codes::unsigned::<12>();
    type Words = Words;
    type Storage = Flash;
    type Slots = Blocks<'static, Slot<SLOT>>;

    fn plan(&self, settings: &Settings) -> Result<(Plan<N>, Words), SettingsError> {
        Words::plan(settings)
    }

    fn correct(&self, slot: &mut Slot<SLOT>) {
        if !self.corrects {
            return;
        }
        // Two real samples share a word, and so do both samples of a pair.
        let block = slot.memory().get_mut(self.guard / 2..).unwrap_or_default();
        let halves = block.as_chunks_mut::<{ N / 2 }>().0;
        halves.iter_mut().take(if self.iq { 2 } else { 1 }).for_each(correct);
    }

    fn widen(&self, measurement: &mut Measurement) {
        widths::widen(measurement, self.corrects, self.iq);
    }

    fn counters(&self) -> Counters {
        converter::counters()
    }

    fn ticks(&self) -> u32 {
        start::ticks()
    }

    fn has_room(&self, bytes: usize) -> bool {
        self.serial.has_room(bytes)
    }

    fn send(&mut self, frame: &[u8]) -> bool {
        let sent = self.serial.send(frame);
        #[cfg(feature = "usb")]
        let sent = super::usb::send(frame) && sent;
        sent
    }

    fn pause(&mut self) {
        converter::pause();
    }

    fn resume(&mut self) {
        converter::resume();
    }

    fn gate_opened(&mut self) -> bool {
        converter::gate_opened()
    }

    fn stalled(&mut self) -> bool {
        self.serial.stalled()
    }

    fn feed(&mut self) {
        start::feed();
    }

    fn self_test(&mut self) -> bool {
        self_test::mark(line::usb_open());
        true
    }
}

impl Board<N, SLOT> for Pico {
    fn causes() -> Causes {
        start::causes()
    }

    fn start(_: &Settings) -> Option<Self> {
        fence::raise();
        let mut chip = pac::Peripherals::take()?;
        let resets = &mut chip.RESETS;
        start::voltage(&mut chip.VREG_AND_CHIP_RESET);
        let sources = (chip.XOSC, chip.PLL_SYS, chip.PLL_USB);
        let clocks = start::clocks(sources, chip.CLOCKS, resets)?;
        Timer::new(chip.TIMER, resets, &clocks);
        start::alarm();
        let sio = Sio::new(chip.SIO);
        let pins = Pins::new(chip.IO_BANK0, chip.PADS_BANK0, sio.gpio_bank0, resets);
        // The supply's regulator switches at one rate under any load, and ripples less (Pico data sheet, 4.4).
        pins.gpio23.into_push_pull_output_in_state(PinState::High);
        // The receiver rests high where nothing is connected.
        let serial = (
            pins.gpio0.into_function::<FunctionUart>(),
            pins.gpio1.reconfigure::<FunctionUart, PullUp>(),
        );
        let config = UartConfig::new(BAUD.Hz(), DataBits::Eight, None, StopBits::One);
        UartPeripheral::new(chip.UART0, serial, resets)
            .enable(config, clocks.peripheral_clock.freq())
            .ok()?;
        // The chirp's sync pulse, and the chirp.
        pins.gpio12.into_function::<FunctionPwm>();
        pins.gpio14.into_function::<FunctionPwm>();
        Slices::new(chip.PWM, resets);
        // The pads without their digital inputs and their pulls.
        AdcPin::new(pins.gpio26.into_floating_input()).ok()?;
        AdcPin::new(pins.gpio27.into_floating_input()).ok()?;
        Adc::new(chip.ADC, resets);
        chip.DMA.split(resets);
        #[cfg(feature = "usb")]
        super::usb::start((chip.USBCTRL_REGS, chip.USBCTRL_DPRAM, clocks.usb_clock), resets)?;
        Some(Self { serial: Serial::start()?, corrects: false, iq: false, guard: 0 })
    }

    fn clocks(&self) -> Clocks {
        let core_hz = 1_000_000 * u32::from(CORE_MHZ);
        Clocks { source: Clock::External, core_hz, ticks_hz: 1_000_000 }
    }

    fn sample(&mut self, plan: &Plan<N>, words: &Words) -> Option<Blocks<'static, Slot<SLOT>>> {
        self.corrects = words.corrects;
        self.iq = words.iq;
        self.guard = plan.settings.guard.into();
        converter::start(plan, words)
    }

    fn receive(&mut self) -> Option<u8> {
        self.serial.receive()
    }

    fn flush(&mut self) {
        self.serial.flush();
    }

    fn sleep(&mut self, blocks: Option<&Blocks<'static, Slot<SLOT>>>) {
        converter::sleep(blocks);
    }

    fn program() -> u32 {
        storage::program()
    }
}
