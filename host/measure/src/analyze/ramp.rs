//! A radar's ramps on the command line.

use super::input::Input;
use super::radar::Radar;
use crate::{band, cli};
use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use picket_dsp::Shape;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::config::Config;
use picket_dsp::solve::chirp::Mixing;

/// The carrier, and the ramps of an FMCW radar.
#[derive(Args, Clone, Copy, Debug)]
pub struct Chirps {
    /// Carrier of a Doppler radar or laser, as in 24G or 193.4e12; adds speeds
    #[arg(long, value_name = "HZ", value_parser = carrier_hz, allow_negative_numbers = true)]
    pub carrier_hz: Option<f64>,
    /// The sign of an approaching target's shift in I/Q samples: rx-conj-tx if it is positive, tx-conj-rx if it is negative or if I and
    /// Q are exchanged [default: rx-conj-tx, with --chirp-s tx-conj-rx]
    #[arg(long, value_name = "MIXING", value_parser = mixing(), requires = "carrier_hz")]
    pub mixing: Option<Mixing>,
    /// Duration of a ramp of an FMCW radar, s; adds ranges, with --carrier-hz and --bandwidth-hz. --skip leads to the start of a ramp, --find-ramps or --trigger find it
    #[arg(long, value_name = "S", value_parser = cli::positive, requires_all = ["bandwidth_hz", "carrier_hz"], conflicts_with = "hop")]
    pub chirp_s: Option<f64>,
    /// Bandwidth of a ramp, as in 4G
    #[arg(long, value_name = "HZ", value_parser = cli::positive_hertz, requires = "chirp_s")]
    pub bandwidth_hz: Option<f64>,
    /// Shape of the ramps: sawtooth, triangle or trapezoid
    #[arg(long, value_name = "SHAPE", value_parser = shape(), default_value = SHAPES[0].0, requires = "chirp_s")]
    pub shape: Shape,
    /// Limits of the targets' velocities, m/s; without them a sawtooth's range is ambiguous
    #[arg(long, value_name = "LO:HI", value_parser = band::parse, allow_hyphen_values = true, requires = "chirp_s")]
    pub velocity_mps: Option<(f64, f64)>,
}

impl Chirps {
    /// The radar, if its ramps are told.
    pub fn radar(&self, input: &Input) -> Option<Radar> {
        let &Self { chirp_s, bandwidth_hz, carrier_hz, shape, velocity_mps, .. } = self;
        let usual = Config::new(1.0, Codes::signed::<12>()).false_alarm;
        Some(Radar {
            shape,
            carrier_hz: carrier_hz?,
            bandwidth_hz: bandwidth_hz?,
            chirp_s: chirp_s?,
            mixing: self.mixing(),
            velocity_mps,
            effort: input.effort,
            false_alarm: Some(input.false_alarm).filter(|asked| *asked != usual),
        })
    }

    /// The signal that the receiver conjugates: as usual for the scene if nothing is told.
    pub fn mixing(&self) -> Mixing {
        let usual = if self.chirp_s.is_some() { Mixing::TxConjRx } else { Mixing::RxConjTx };
        self.mixing.unwrap_or(usual)
    }
}

/// Shapes of ramps.
const SHAPES: [(&str, Shape); 3] =
    [("sawtooth", Shape::Sawtooth), ("triangle", Shape::Triangle), ("trapezoid", Shape::Trapezoid)];

/// The names of the shapes.
pub fn shape() -> impl TypedValueParser<Value = Shape> {
    let names = PossibleValuesParser::new(SHAPES.map(|it| it.0));
    names.map(|name| SHAPES.iter().find(|it| it.0 == name).map_or(Shape::Sawtooth, |it| it.1))
}

/// A carrier of a radar or a laser: from 100 MHz to the ultraviolet. A number that looks like gigahertz is reported.
fn carrier_hz(text: &str) -> Result<f64, String> {
    let hz = cli::positive_hertz(text)?;
    match (1e8..3e15).contains(&hz) {
        true => Ok(hz),
        false => {
            Err(format!("{hz} Hz is no carrier of a radar or a laser: 24 GHz are 24G or 24e9"))
        }
    }
}

/// The names of the two ways to mix.
pub fn mixing() -> impl TypedValueParser<Value = Mixing> {
    let names = PossibleValuesParser::new(Mixing::ALL.map(Mixing::name));
    names.map(|name| Mixing::from_name(&name).unwrap_or_default())
}
