//! Everything that needs more than one module, as one program: it is compiled and linked once, and slow tests run beside quick
//! ones. `cargo test -p host-tests golden::` runs a file's tests.

mod budget;
mod cycles;
mod displacement;
mod emulated;
mod estimators;
mod f32;
mod fft;
mod field;
mod figures;
mod front_door;
mod frontend;
mod fuzz;
mod golden;
mod harmonic;
mod least_squares;
mod lines;
mod locked;
mod monte_carlo;
mod nucleo;
mod panic_free;
mod pipeline;
mod protocol;
mod q15;
mod recordings;
mod registers;
mod signal;
mod solver;
mod sweep;
mod telemetry;
mod track;
mod trust;
mod two_tones;
mod vectors;
mod widths;
