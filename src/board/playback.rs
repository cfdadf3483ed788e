//! A capture on the host, read by semihosting: what an emulated board has for a converter's input.

use super::halt::{Exit, exit};
use super::mps2::Uart;
use crate::acquire::capture::Header;
use crate::acquire::sample::Record;
use crate::config::Plan;
use crate::estimate::method::Method;
use crate::pipeline::Measurement;
use crate::report::record::{Health, Record as Telemetry};
use semihosting::fs::File;
use semihosting::io::Read;

/// The capture's name in the emulator's working directory.
const NAME: &core::ffi::CStr = c"capture.bin";

/// The capture, open behind its header.
pub struct Playback {
    /// What precedes the samples.
    pub header: Header,
    file: File,
}

impl Playback {
    /// Opens the capture; ends the emulation with a message where there is none.
    pub fn open() -> Self {
        Uart::ZERO.enable();
        Uart::ONE.enable();
        let mut bytes = [0; Header::BYTES];
        let Ok(mut file) = File::open(NAME) else {
            fail(Exit::Capture, "there is no capture");
        };
        if !fill(&mut file, &mut bytes) {
            fail(Exit::Capture, "the capture ends in its header");
        }
        match Header::from_bytes(&bytes) {
            Ok(header) => Self { header, file },
            Err(error) => fail(Exit::Capture, error.message()),
        }
    }

    /// Checks the configuration for records of kind `R` and `n` samples.
    pub fn plan<R: Record>(&self, n: usize) -> Plan {
        match self.header.config.validate::<R>(n) {
            Ok(plan) => plan,
            Err(error) => fail(Exit::Config, error.message()),
        }
    }

    /// Reads the next bytes of samples.
    pub fn read(&mut self, bytes: &mut [u8]) {
        if !fill(&mut self.file, bytes) {
            fail(Exit::Capture, "the capture ends before its last block");
        }
    }
}

/// Fills `bytes`; false at the end of the file.
fn fill(file: &mut File, mut bytes: &mut [u8]) -> bool {
    while !bytes.is_empty() {
        let Ok(count) = file.read(bytes) else {
            return false;
        };
        match core::mem::take(&mut bytes).split_at_mut_checked(count) {
            Some((_, rest)) if count > 0 => bytes = rest,
            _ => return false,
        }
    }
    true
}

/// Sends a measurement as a telemetry record.
pub fn send(measurement: Measurement, method: Method, health: Health) {
    Uart::ZERO.send(&Telemetry { measurement, method, health }.to_frame());
}

/// Ends the emulation with a line on the second serial port.
pub fn fail(code: Exit, message: &str) -> ! {
    Uart::ONE.send(message.as_bytes());
    Uart::ONE.send(b"\n");
    exit(code)
}
