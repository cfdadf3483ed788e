//! A capture on the host, read by semihosting. An emulated board plays it as its converter's input.

use super::Uart;
use super::halt::{Exit, exit};
use core::arch::asm;
use core::ffi::CStr;
use picket_dsp::acquire::sample::Record;
use picket_dsp::methods::registry::Method;
use picket_dsp::pipeline::Measurement;
use picket_dsp::plan::Plan;
use picket_wire::capture::Header;
use picket_wire::telemetry::{Health, Telemetry};

/// The capture's name in the emulator's working directory.
const NAME: &CStr = c"capture.bin";

/// The capture, open after its header.
pub struct Playback {
    /// The header.
    pub header: Header,
    file: File,
}

impl Playback {
    /// Opens the capture; without one, ends the emulation with a message.
    pub fn open() -> Self {
        Uart::ZERO.enable();
        Uart::ONE.enable();
        let mut bytes = [0; Header::BYTES];
        let Some(file) = File::open(NAME) else {
            fail(Exit::Capture, "there is no capture");
        };
        if !file.fill(&mut bytes) {
            fail(Exit::Capture, "the capture ends in its header");
        }
        match Header::from_bytes(&bytes) {
            Ok(header) => Self { header, file },
            Err(error) => fail(Exit::Capture, error.message()),
        }
    }

    /// Checks the configuration for records of kind `R` and `N` samples; if it fails, ends the
    /// emulation with a message.
    pub fn plan<R: Record, const N: usize>(&self) -> Plan<R, N> {
        match self.header.config.plan() {
            Ok(plan) => plan,
            Err(error) => fail(Exit::Config, error.message()),
        }
    }

    /// Reads the next bytes of samples.
    pub fn read(&mut self, bytes: &mut [u8]) {
        if !self.file.fill(bytes) {
            fail(Exit::Capture, "the capture ends before its last block");
        }
    }
}

/// A file for results in the emulator's working directory.
pub struct Results(File);

impl Results {
    /// The results' name in the emulator's working directory.
    const NAME: &CStr = c"results.bin";

    /// Opens the results to append to them.
    pub fn open() -> Self {
        match File::append(Self::NAME) {
            Some(file) => Self(file),
            None => fail(Exit::Capture, "the results cannot be written"),
        }
    }

    /// Writes a complex value.
    pub fn write(&mut self, [re, im]: [f32; 2]) {
        let ([a, b, c, d], [e, f, g, h]) = (re.to_le_bytes(), im.to_le_bytes());
        if !self.0.write(&[a, b, c, d, e, f, g, h]) {
            fail(Exit::Capture, "the results cannot be written");
        }
    }
}

/// A file on the host. The crate `semihosting` reads files, too, but checks their numbers by a panic.
struct File(u32);

impl File {
    /// SYS_OPEN, in mode "rb".
    fn open(name: &CStr) -> Option<Self> {
        let length = name.to_bytes().len() as u32;
        // SAFETY: the block has the arguments of SYS_OPEN: a name, a mode, the name's length.
        let number = unsafe { call(0x01, &[name.as_ptr() as u32, 1, length]) };
        (number != u32::MAX).then_some(Self(number))
    }

    /// SYS_OPEN, in mode "ab".
    fn append(name: &CStr) -> Option<Self> {
        let length = name.to_bytes().len() as u32;
        // SAFETY: as in `open`.
        let number = unsafe { call(0x01, &[name.as_ptr() as u32, 9, length]) };
        (number != u32::MAX).then_some(Self(number))
    }

    /// Writes `bytes`; false if the host takes fewer.
    fn write(&self, bytes: &[u8]) -> bool {
        // SAFETY: the block has the arguments of SYS_WRITE: a file's number, memory to read, its length.
        let missing = unsafe { call(0x05, &[self.0, bytes.as_ptr() as u32, bytes.len() as u32]) };
        missing == 0
    }

    /// Fills `bytes`; false at the end of the file.
    fn fill(&self, bytes: &mut [u8]) -> bool {
        let length = bytes.len() as u32;
        // SAFETY: the block has the arguments of SYS_READ: a file's number, memory to write to, its length.
        let missing = unsafe { call(0x06, &[self.0, bytes.as_mut_ptr() as u32, length]) };
        missing == 0
    }
}

/// Calls the emulator (ARM, Semihosting for AArch32 and AArch64).
///
/// # Safety
/// `block` must hold the arguments of `operation`, and its pointers must be valid for that operation.
unsafe fn call(operation: u32, block: &[u32; 3]) -> u32 {
    let mut result = operation;
    // SAFETY: the emulator stops here, does the operation that the caller guarantees to be valid, and answers in r0.
    unsafe { asm!("bkpt 0xab", inout("r0") result, in("r1") block, options(nostack)) };
    result
}

/// Sends the telemetry of a measurement.
pub fn send(measurement: Measurement, method: Method, health: Health) {
    Uart::ZERO.send(
        &Telemetry { measurement, method, health, basis: None, uncertainty: None }.to_frame(),
    );
}

/// Ends the emulation with a line on the second serial port.
pub fn fail(code: Exit, message: &str) -> ! {
    Uart::ONE.send(message.as_bytes());
    Uart::ONE.send(b"\n");
    exit(code)
}
