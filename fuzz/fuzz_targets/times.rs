#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| picket_fuzz::times(bytes));
