//! A serial port over USB (CDC-ACM), beside UART0: both send equal frames and take equal commands.
//!
//! A packet to the host that is corrupted in the last fifth of a frame of the bus may hang the controller until it is reset (RP2040-E15).
//! So packets are given to it in the first four fifths alone, and the start of each frame interrupts.
//!
//! Frames wait in a ring while a program has the port open. The board never waits for the line: a frame without room is dropped whole and
//! counted. With no program there the ring is empty, and nothing is lost.

use super::line;
use super::registers::{enable, usb};
use super::start::{ticks, within};
use core::cell::RefCell;
use cortex_m::interrupt::{Mutex, free};
use rp2040_hal::clocks::UsbClock;
use rp2040_hal::pac;
use rp2040_hal::usb::UsbBus;
use static_cell::StaticCell;
use usb_device::bus::UsbBusAllocator;
use usb_device::prelude::{
    StringDescriptors, UsbDevice, UsbDeviceBuilder, UsbDeviceState, UsbVidPid,
};
use usbd_serial::{CdcAcmClass, USB_CLASS_CDC};

/// The numbers that V-USB shares among serial ports, which differ by their names.
const NUMBERS: UsbVidPid = UsbVidPid(0x16C0, 0x27DD);
/// The largest packet of the endpoints, bytes.
const PACKET: usize = 64;
/// Room for bytes to the host: 40 records.
const OUT: usize = 4096;

static PORT: Mutex<RefCell<Option<Port>>> = Mutex::new(RefCell::new(None));

/// The device, its one class, and the bytes that wait.
struct Port {
    device: UsbDevice<'static, UsbBus>,
    class: CdcAcmClass<'static, UsbBus>,
    open: bool,
    ring: [u8; OUT],
    /// Bytes written to the ring, and bytes sent from it; modulo 2^32.
    written: u32,
    sent: u32,
    /// When the frame began, microseconds of the timer.
    began: u32,
}

/// The part of a frame in which packets are given to the controller, and a time after which no frames come, microseconds.
const SAFE: u32 = 750;
const NO_FRAMES: u32 = 1_500;

impl Port {
    /// Follows the events on the bus.
    fn follow(&mut self) {
        if usb().ints().read().dev_sof().bit() {
            // Reading the frame's number clears its interrupt.
            let _ = usb().sof_rd().read().count().bits();
            self.began = ticks();
        }
        let _ = self.device.poll(&mut [&mut self.class]);
        let open = self.device.state() == UsbDeviceState::Configured && self.class.dtr();
        if open != self.open {
            // Unsent bytes are of no use to another reader. A zero ends the frame that was cut.
            (self.open, self.sent) = (open, self.written);
            self.put(if open { &[0] } else { &[] });
        }
        let mut packet = [0; PACKET];
        if let Ok(length) = self.class.read_packet(&mut packet) {
            line::hear(packet.iter().copied().take(length));
        }
        self.pass();
    }

    /// Whether a frame was taken, or no program is there to miss it.
    fn send(&mut self, frame: &[u8]) -> bool {
        if !self.open {
            return true;
        }
        let waiting = self.written.wrapping_sub(self.sent) as usize;
        let taken = OUT.saturating_sub(waiting) >= frame.len();
        if taken {
            self.put(frame);
            self.pass();
        }
        taken
    }

    fn put(&mut self, bytes: &[u8]) {
        line::put_in(&mut self.ring, self.written, bytes);
        self.written = self.written.wrapping_add(bytes.len() as u32);
    }

    /// Gives the endpoint its next packet, if it is free.
    fn pass(&mut self) {
        if (SAFE..NO_FRAMES).contains(&ticks().wrapping_sub(self.began)) {
            return;
        }
        let waiting = self.written.wrapping_sub(self.sent) as usize;
        let rest = self.ring.get(self.sent as usize % OUT..).unwrap_or_default();
        // A packet that is not full ends a transfer, so that the host passes it on at once.
        let length = waiting.min(rest.len()).min(PACKET - 1);
        if let Some(packet) = rest.get(..length).filter(|packet| !packet.is_empty())
            && self.class.write_packet(packet).is_ok()
        {
            self.sent = self.sent.wrapping_add(length as u32);
        }
    }
}

/// Sets up the port; `None` at the second call.
pub fn start(
    bus: (pac::USBCTRL_REGS, pac::USBCTRL_DPRAM, UsbClock),
    resets: &mut pac::RESETS,
) -> Option<()> {
    static BUS: StaticCell<UsbBusAllocator<UsbBus>> = StaticCell::new();
    let (registers, memory, clock) = bus;
    // The board has no wire to sense the host's voltage with.
    let bus = UsbBus::new(registers, memory, clock, true, resets);
    let bus = &*BUS.try_init_with(|| UsbBusAllocator::new(bus))?;
    let class = CdcAcmClass::new(bus, PACKET as u16);
    let names = StringDescriptors::default().manufacturer("Picket").product("Picket on a Pico");
    let device = UsbDeviceBuilder::new(bus, NUMBERS)
        .strings(&[names])
        .ok()?
        .max_packet_size_0(PACKET as u8)
        .ok()?
        .device_class(USB_CLASS_CDC)
        .build();
    let port = Port { device, class, open: false, ring: [0; OUT], written: 0, sent: 0, began: 0 };
    free(|token| *PORT.borrow(token).borrow_mut() = Some(port));
    usb().inte().modify(|_, w| w.dev_sof().set_bit());
    enable(pac::Interrupt::USBCTRL_IRQ);
    Some(())
}

fn with<T>(work: impl FnOnce(&mut Port) -> T) -> Option<T> {
    free(|token| PORT.borrow(token).try_borrow_mut().ok()?.as_mut().map(work))
}

/// Sends a frame whole and returns true, or drops it and returns false.
pub fn send(frame: &[u8]) -> bool {
    with(|port| port.send(frame)).unwrap_or(true)
}

/// Whether a program has the port open.
pub fn open() -> bool {
    with(|port| port.open).unwrap_or(false)
}

/// Waits, within bounded time, until the host has what was sent, or is gone. Called before a reset.
pub fn flush() {
    let waits = || with(|port| port.open && port.written != port.sent).unwrap_or(false);
    if open() {
        let _ = within(100, || !waits());
        // The last packets lie in the controller until the host asks for them, a frame of the bus for each.
        let _ = within(3, || false);
    }
}

/// Handles the interrupt of the bus.
pub extern "C" fn event() {
    with(Port::follow);
}
