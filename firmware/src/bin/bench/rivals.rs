//! Third-party transforms. They may panic, so this image is not part of the proof that no panic is reachable.

use core::hint::black_box;
use fixed_dsp::transform::{RfftI16, RfftI32};
use picket_dsp::acquire::sample::Record;
use picket_firmware::mps2::count::count;
use picket_firmware::mps2::playback::Results;

/// The shift that takes 12-bit codes to the full scale of a 16-bit transform.
const UP: u32 = 4;

pub fn count_all<R: Record, const N: usize>(samples: &[R::Sample; N], results: &mut Results) {
    if R::IQ {
        return;
    }
    let codes: [i16; N] =
        core::array::from_fn(|index| samples.get(index).map_or(0, |&sample| R::parts(sample)[0]));
    floats(&codes, results);
    if N <= 1024 {
        let mut input = black_box(codes.map(|code| code << UP));
        let mut output = [fixed_fft_complex(); N];
        count("fixed-fft", || {
            let _ = fixed_fft::fft_radix2_real_q15(&mut input, &mut output, true);
        });
        for x in output.iter().take(N / 2) {
            results.write([x.re as f32, x.im as f32]);
        }
    }
    let mut input = black_box(codes.map(|code| code << UP));
    let mut output = [[0i16; 2]; N];
    let transform = RfftI16::new(N, false, true);
    count("fixed-dsp-q15", || transform.run(&mut input, output.as_flattened_mut()));
    for [re, im] in output.into_iter().take(N / 2) {
        results.write([re.into(), im.into()]);
    }
    let mut input = black_box(codes.map(|code| i32::from(code) << (UP + 16)));
    let mut output = [[0i32; 2]; N];
    let transform = RfftI32::new(N, false, true);
    count("fixed-dsp-q31", || transform.run(&mut input, output.as_flattened_mut()));
    for [re, im] in output.into_iter().take(N / 2) {
        results.write([re as f32, im as f32]);
    }
}

/// The crate exports no name for the zero of its number type, and uses an older `num-complex`.
fn fixed_fft_complex() -> num_complex_old::Complex<i16> {
    num_complex_old::Complex::new(0, 0)
}

fn floats<const N: usize>(codes: &[i16; N], results: &mut Results) {
    let mut input = black_box(codes.map(f32::from));
    macro_rules! transform {
        ($function:ident) => {{
            let Ok(input) = <&mut [f32; _]>::try_from(input.as_mut_slice()) else { return };
            let output = count("microfft", || microfft::real::$function(input));
            for (k, x) in output.iter().enumerate() {
                // DC and Nyquist share the first bin.
                results.write([x.re, if k == 0 { 0.0 } else { x.im }]);
            }
        }};
    }
    match N {
        64 => transform!(rfft_64),
        128 => transform!(rfft_128),
        256 => transform!(rfft_256),
        512 => transform!(rfft_512),
        1024 => transform!(rfft_1024),
        2048 => transform!(rfft_2048),
        _ => transform!(rfft_4096),
    }
}
