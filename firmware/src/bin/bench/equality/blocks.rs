//! Random blocks of samples, of any codes.

use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::Record;
use picket_firmware::mps2::count::Random;

/// Draws blocks.
pub struct Blocks(Random);

/// The contents of a block.
#[derive(Clone, Copy)]
enum Kind {
    /// Noise of any level about the middle or any code, periodic in some of the blocks: then bins are equally strong.
    Noise { low: i32, span: u32, period: usize },
    /// Two codes, by chance.
    Two([i32; 2]),
    /// Two codes, each `half` times after the other.
    Square { codes: [i32; 2], half: u32 },
    /// One code, and another in one of `among` samples: 0 is none.
    Impulses { codes: [i32; 2], among: u32 },
    /// A tone of any strength, clipped where it is too strong, in noise of `noise` codes.
    Tone { centre: f32, amplitude: f32, turn: [f32; 2], noise: u32 },
}

impl Blocks {
    /// The blocks of a seed.
    pub fn new(seed: u32) -> Self {
        Self(Random(seed.wrapping_mul(0x9E37_79B9) | 1))
    }

    fn below(&mut self, limit: u32) -> u32 {
        (self.0.draw() >> 4).checked_rem(limit).unwrap_or(0)
    }

    /// Codes of a usual width, of another width, or from any code to any other.
    pub fn codes(&mut self) -> Codes {
        let (signed, bits) = (self.below(2) == 0, 8 + self.below(9));
        let (low, high) = (self.0.draw() as i16, (self.0.draw() >> 16) as i16);
        match self.below(6) {
            0 => Some(Codes::signed::<12>()),
            1 => Some(Codes::unsigned::<12>()),
            2..5 => Codes::from_bits(signed, bits),
            _ => Codes::between(low.min(high), low.max(high)),
        }
        .unwrap_or(const { Codes::signed::<16>() })
    }

    /// Two codes: the rails, or any.
    fn two(&mut self, low: i32, span: u32) -> [i32; 2] {
        let mut any = || low.wrapping_add(self.below(span.wrapping_add(1)) as i32);
        let codes = [any(), any()];
        if self.below(2) == 0 { [low, low.wrapping_add(span as i32)] } else { codes }
    }

    /// A point of the unit circle: `[(1 - t^2) / (1 + t^2), 2 t / (1 + t^2)]` for some t.
    fn turn(&mut self) -> [f32; 2] {
        let t = self.0.draw() as i32 as f32 * (1.0 / 2_147_483_648.0);
        let sign = if self.below(2) == 0 { 1.0 } else { -1.0 };
        let share = sign / (1.0 + t * t);
        [(1.0 - t * t) * share, 2.0 * t * share]
    }

    fn kind(&mut self, codes: Codes, samples: usize) -> Kind {
        let (low, high) = codes.rails();
        let (low, span) = (i32::from(low), (i32::from(high) - i32::from(low)) as u32);
        let weaker = self.below(codes.bits());
        match self.below(8) {
            kind @ 0..3 => {
                let within = span >> weaker;
                // Weak blocks about the middle are shifted up, blocks elsewhere are not.
                let rest = span - within;
                let below = if self.below(2) == 0 { rest / 2 } else { self.below(rest + 1) };
                let low = low.wrapping_add(below as i32);
                let period = if kind == 0 { 1 << self.below(8) } else { samples };
                Kind::Noise { low, span: within, period }
            }
            3 => Kind::Two(self.two(low, span)),
            4 => Kind::Square { codes: self.two(low, span), half: 1 << self.below(8) },
            5 => {
                let among = [0, 0, 4, 300, 3000].get(self.below(5) as usize).copied();
                Kind::Impulses { codes: self.two(low, span), among: among.unwrap_or(0) }
            }
            _ => {
                let amplitude = 0.6 * span as f32 / (1u32 << weaker) as f32;
                let noise = (span >> self.below(codes.bits())) & 0u32.wrapping_sub(self.below(2));
                Kind::Tone {
                    centre: f32::from(codes.middle()),
                    amplitude,
                    turn: self.turn(),
                    noise,
                }
            }
        }
    }

    /// Draws a block of these codes.
    pub fn fill<R: Record>(&mut self, codes: Codes, samples: &mut [R::Sample]) {
        let (low, high) = codes.rails();
        let kind = self.kind(codes, samples.len());
        let either = |first: bool, [a, b]: [i32; 2]| if first { a } else { b };
        let mut z = self.turn();
        for index in 0..samples.len() {
            if let Kind::Noise { period, .. } = kind
                && let Some(&repeated) = index.checked_sub(period).and_then(|at| samples.get(at))
            {
                if let Some(sample) = samples.get_mut(index) {
                    *sample = repeated;
                }
                continue;
            }
            let parts = z.map(|part| {
                let code = match kind {
                    Kind::Noise { low, span, .. } => low.wrapping_add(self.below(span + 1) as i32),
                    Kind::Two(codes) => either(self.below(2) == 0, codes),
                    Kind::Square { codes, half } => either(index as u32 & half == 0, codes),
                    Kind::Impulses { codes, among } => {
                        either(among == 0 || self.below(among) > 0, codes)
                    }
                    Kind::Tone { centre, amplitude, noise, .. } => {
                        let noise = self.below(noise + 1) as f32 - 0.5 * noise as f32;
                        (centre + amplitude * part + noise) as i32
                    }
                };
                code.max(low.into()).min(high.into()) as i16
            });
            if let Some(sample) = samples.get_mut(index) {
                *sample = R::from_parts(parts);
            }
            if let Kind::Tone { turn: [cos, sin], .. } = kind {
                z = [z[0] * cos - z[1] * sin, z[0] * sin + z[1] * cos];
            }
        }
    }
}
