//! The status of a call: 0, or the error in its arguments; then nothing was written.

use core::ffi::{CStr, c_char};
use picket_dsp::ConfigError;

/// Makes the codes with their sentences.
macro_rules! statuses {
    ($($(#[doc = $about:literal])* $name:ident = $code:literal: $message:expr;)*) => {
        /// What a call says. The numbers are those of `picket.h`, and never change.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[repr(i32)]
        pub enum Status {
            $($(#[doc = $about])* $name = $code,)*
        }

        /// The sentence of a code.
        const fn sentence(code: i32) -> &'static CStr {
            match code {
                $($code => c_string!($message),)*
                _ => c"no status has this number",
            }
        }
    };
}

statuses! {
    /// The call did its work.
    Ok = 0: "no error";
    /// A pointer is NULL.
    Null = 1: "a pointer is NULL";
    /// A pointer is not aligned for what it points to.
    Unaligned = 2: "a pointer is not aligned for its type";
    /// The memory holds nothing that was initialised, or something of another kind or length.
    Uninitialised = 3: "the memory was not initialised for this kind and length of record";
    /// Another number of samples than the function's name says.
    Samples = 4: "the number of samples is not the one in the function's name";
    /// Fewer than 256 codes, or the low one above the high one.
    Codes = 5: "the codes must be at least 256, the low one first";
    /// A field of options has an unknown number, or a reserved field is not 0.
    Option = 6: "an option has a number without a meaning, or a reserved field is not 0";
    /// Lines were asked for before any block.
    NoBlock = 7: "measure a block first";
    /// Fewer cells or numbers than the frame needs.
    Room = 8: "the room is smaller than the frame needs: picket_frame_cells returns how many";
    /// A calibration by a tone that may not be used.
    Unusable = 9: "the tone may not be used for a calibration";
    /// See [`ConfigError::Rate`].
    Rate = 16: ConfigError::Rate.message();
    /// See [`ConfigError::Band`].
    Band = 17: ConfigError::Band.message();
    /// See [`ConfigError::Scene`].
    Scene = 18: ConfigError::Scene.message();
    /// See [`ConfigError::Ramp`].
    Ramp = 19: ConfigError::Ramp.message();
    /// See [`ConfigError::Scale`].
    Scale = 20: ConfigError::Scale.message();
    /// See [`ConfigError::FalseAlarm`].
    FalseAlarm = 21: ConfigError::FalseAlarm.message();
    /// See [`ConfigError::Following`].
    Following = 22: ConfigError::Following.message();
    /// See [`ConfigError::Frame`].
    Frame = 24: ConfigError::Frame.message();
    /// See [`ConfigError::Length`].
    Length = 25: ConfigError::Length.message();
    /// Any other error of a configuration.
    Config = 23: "the configuration does not work for this kind and length of record";
}

impl From<ConfigError> for Status {
    fn from(error: ConfigError) -> Self {
        match error {
            ConfigError::Rate => Status::Rate,
            ConfigError::Band => Status::Band,
            ConfigError::Scene => Status::Scene,
            ConfigError::Ramp => Status::Ramp,
            ConfigError::Scale => Status::Scale,
            ConfigError::FalseAlarm => Status::FalseAlarm,
            ConfigError::Following => Status::Following,
            ConfigError::Frame => Status::Frame,
            ConfigError::Length => Status::Length,
            _ => Status::Config,
        }
    }
}

impl From<Result<(), Status>> for Status {
    fn from(done: Result<(), Status>) -> Self {
        done.err().unwrap_or(Status::Ok)
    }
}

/// What a status says, in one line of English. Never NULL; it lives as long as the program.
#[unsafe(no_mangle)]
pub extern "C" fn picket_status_message(status: i32) -> *const c_char {
    sentence(status).as_ptr()
}
