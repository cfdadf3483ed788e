//! Verdicts in words, and the library's version.

use core::ffi::{CStr, c_char};
use picket_dsp::{Usable, Validation, Verdict, Verdicts};

/// A constant string of Rust as one of C, without a copy at run time.
macro_rules! c_string {
    ($text:expr) => {{
        const TEXT: &str = $text;
        const BYTES: [u8; TEXT.len() + 1] = $crate::words::terminated(TEXT);
        const STRING: &core::ffi::CStr = match core::ffi::CStr::from_bytes_with_nul(&BYTES) {
            Ok(string) => string,
            Err(_) => c"",
        };
        STRING
    }};
}

/// The bytes of a text and a zero.
pub const fn terminated<const LENGTH: usize>(text: &str) -> [u8; LENGTH] {
    let mut bytes = [0; LENGTH];
    let (mut rest, mut index) = (text.as_bytes(), 0);
    while let [first, tail @ ..] = rest {
        bytes[index] = *first;
        (rest, index) = (tail, index + 1);
    }
    bytes
}

/// What a verdict has in words.
struct Words {
    name: &'static CStr,
    reason: &'static CStr,
}

/// The words of these verdicts. A verdict that is missing here does not compile.
macro_rules! words {
    ($($verdict:ident),*) => {
        const fn words(verdict: Verdict) -> Words {
            match verdict {
                $(Verdict::$verdict => Words {
                    name: c_string!(Verdict::$verdict.name()),
                    reason: c_string!(Verdict::$verdict.reason()),
                },)*
                _ => Words { name: c"unknown", reason: c"This verdict is newer than the archive." },
            }
        }
        const _: () =
            assert!([$(Verdict::$verdict),*].len() == Verdict::ALL.len(), "a verdict has no words");
    };
}

words!(
    Good, Moving, NearEdge, Clipped, Unresolved, Image, Gap, Weak, Ambiguous, FrontEnd, NoSignal,
    WrongCodes, Coasting
);

/// The words of a number from a tone.
fn of(verdict: u8) -> Words {
    match Verdict::from_u8(verdict) {
        Some(verdict) => words(verdict),
        None => Words { name: c"unknown", reason: c"No verdict has this number." },
    }
}

/// The name of a verdict, as tables and JSON show it: "good", "near-edge". Never NULL.
#[unsafe(no_mangle)]
pub extern "C" fn picket_verdict_name(verdict: u8) -> *const c_char {
    of(verdict).name.as_ptr()
}

/// What a verdict means, in a sentence. Never NULL.
#[unsafe(no_mangle)]
pub extern "C" fn picket_verdict_reason(verdict: u8) -> *const c_char {
    of(verdict).reason.as_ptr()
}

/// What a number of this verdict may be used for: a `PICKET_USABLE_`. For nothing where the number is no verdict's.
#[unsafe(no_mangle)]
pub extern "C" fn picket_verdict_usable(verdict: u8) -> u8 {
    Verdict::from_u8(verdict).map_or(Usable::No, Verdict::usable) as u8
}

/// 1 if a verdict is among a tone's `also`, else 0.
#[unsafe(no_mangle)]
pub extern "C" fn picket_verdict_is_among(verdict: u8, also: u8) -> u8 {
    Verdict::from_u8(verdict).is_some_and(|verdict| Verdicts::from_bits(also).has(verdict)) as u8
}

/// What is known against a burst: "valid", "two-particles". Never NULL.
#[unsafe(no_mangle)]
pub extern "C" fn picket_validation_name(validation: u8) -> *const c_char {
    const NAMES: [&CStr; Validation::ALL.len()] = [
        c_string!(Validation::Valid.name()),
        c_string!(Validation::TwoParticles.name()),
        c_string!(Validation::FewCycles.name()),
        c_string!(Validation::Short.name()),
        c_string!(Validation::Long.name()),
        c_string!(Validation::Weak.name()),
        c_string!(Validation::Clipped.name()),
    ];
    NAMES.get(usize::from(validation)).unwrap_or(&c"unknown").as_ptr()
}

/// The version of the archive, "0.1.0". Never NULL.
#[unsafe(no_mangle)]
pub extern "C" fn picket_version() -> *const c_char {
    c_string!(env!("CARGO_PKG_VERSION")).as_ptr()
}
