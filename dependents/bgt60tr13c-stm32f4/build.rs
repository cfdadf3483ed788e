//! Hands the linker script over; the memory map is the HAL's.

fn main() {
    println!("cargo:rustc-link-arg-bins=-Tlink.x");
}
