//! The settings, as Python passes them.

use picket_dsp::{Chirp, Codes, Mixing, Scene, Shape};

/// A scene: its kind, wavelength, angle, bandwidth, duration, guard, curvature, shape, mixing, bounds of range and velocity.
pub type SceneTerms<'a> =
    (&'a str, f64, f64, f64, f64, f64, f64, &'a str, &'a str, [Option<(f64, f64)>; 2]);

/// The library's scene of these terms.
pub fn scene(terms: &SceneTerms) -> Result<Scene, String> {
    let &(
        kind,
        wavelength_m,
        angle_rad,
        bandwidth_hz,
        duration_s,
        guard_s,
        curvature,
        shape,
        name,
        _,
    ) = terms;
    let mixing = mixing(name)?;
    Ok(match kind {
        "doppler" => Scene::Doppler { wavelength_m, angle_rad, mixing },
        "chirp" => Scene::Chirp(Chirp {
            shape: match shape {
                "trapezoid" => Shape::Trapezoid,
                "triangle" => Shape::Triangle,
                "sawtooth" => Shape::Sawtooth,
                _ => {
                    return Err(format!("shape is trapezoid, triangle or sawtooth, not {shape}"));
                }
            },
            wavelength_m,
            bandwidth_hz,
            duration_s,
            guard_s,
            mixing,
            sweep_curvature: curvature,
        }),
        _ => Scene::Tone,
    })
}

/// The mixing of this name.
pub fn mixing(name: &str) -> Result<Mixing, String> {
    Mixing::from_name(name).ok_or_else(|| format!("mixing is tx-conj-rx or rx-conj-tx, not {name}"))
}

/// The codes from a lowest to a highest.
pub fn codes(low: i16, high: i16) -> Result<Codes, String> {
    Codes::between(low, high)
        .ok_or_else(|| "codes: at least 256 of them, the low one first".to_owned())
}

/// Why a length is refused, with the nearest.
pub fn length(n: usize) -> String {
    let nearest = match n.max(1).ilog2() {
        ..=5 => "64".to_owned(),
        12.. => "4096".to_owned(),
        power => format!("{} or {}", 1 << power, 2 << power),
    };
    format!("n = {n}: blocks have 64, 128, ... 4096 samples, so choose {nearest}")
}
