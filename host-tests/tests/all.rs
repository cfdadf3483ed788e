//! Everything that needs more than one module, as one program: it is compiled and linked once, and slow tests run beside quick
//! ones. `cargo test -p host-tests golden::` runs a file's tests.

mod accumulate;
mod alternating;
mod budget;
mod cmsis;
mod cycles;
mod displacement;
mod documents;
mod emulated;
mod engine_error;
mod estimators;
mod f32;
mod false_alarms;
mod fft;
mod front_door;
mod frontend;
mod fuzz;
mod golden;
mod harmonic;
mod least_squares;
mod nucleo;
mod panic_free;
mod pipeline;
mod protocol;
mod recordings;
mod sigma_jumps;
mod solver;
mod sweep;
mod symmetries;
mod telemetry;
mod track;
mod vectors;
mod widths;
