//! The way of a signal from the mixer to the codes, in a run.

use crate::draw::Draw;
use crate::noise::Coloured;
use crate::scene::{Converter, Place, Receiver, Scene};
use crate::value::{Course, Value};
use core::f64::consts::{PI, TAU};

/// A receiver and its converter, drawn for a run.
#[derive(Default)]
pub(crate) struct Path {
    iq: bool,
    rate_hz: f64,
    steps: usize,
    gain: f64,
    quadrature: (f64, f64),
    mixed: bool,
    late_s: f64,
    dead: Option<usize>,
    offset: [f64; 2],
    /// Standard deviation of the noise in each part, codes.
    pub noise: f64,
    pub coloured: Option<Coloured>,
    hum: Vec<Line>,
    drift: Option<(Course, [f64; 2])>,
    burst: Option<[f64; 3]>,
    /// Samples that stick out, by how much, in their order.
    impulses: Vec<(u64, [f64; 2])>,
    sections: Vec<Section>,
    limit: Option<f64>,
    converter: Converter,
    /// Its faults that are numbers: INL, the weights of the upper bits.
    inl: f64,
    weights: [f64; 3],
    lost: Option<(u64, f64)>,
    stale: Option<(u64, f64)>,
    repeated: Option<(u64, u64)>,
    draw: Option<Draw>,
    clock: Option<Draw>,
    /// Samples that were taken so far, and where the next one is expected, s.
    pub taken: u64,
    next_s: f64,
    /// What a repeated sample repeats.
    last: [f64; 2],
}

/// A sine from elsewhere.
struct Line {
    hz: f64,
    turns: f64,
    amplitude: f64,
    shares: [f64; 2],
}

/// Steps of the band in which the power of filtered noise is summed up.
const STEPS: i32 = 20_000;

/// A filter of first order, for both parts.
struct Section {
    high: bool,
    /// The tangent of its corner.
    corner: f64,
    state: Option<[[f64; 2]; 2]>,
}

impl Section {
    /// By the bilinear transform, which bends no frequency far below the rate. It begins as one that has seen its first input for long.
    fn pass(&mut self, x: [f64; 2]) -> [f64; 2] {
        let scale = 1.0 / (1.0 + self.corner);
        let back = (1.0 - self.corner) * scale;
        let [x1, y1] = *self.state.get_or_insert([x, if self.high { [0.0; 2] } else { x }]);
        let part = |i: usize| match self.high {
            true => scale * (x[i] - x1[i]) + back * y1[i],
            false => self.corner * scale * (x[i] + x1[i]) + back * y1[i],
        };
        let y = [part(0), part(1)];
        self.state = Some([x, y]);
        y
    }
}

impl Path {
    /// The path of a trial of a scene, with the first source so strong and at this frequency.
    pub fn new(scene: &Scene, trial: u64, amplitude: f64, nominal_hz: f64) -> Self {
        let draw = &mut Draw::part(scene.seed, trial, 2);
        let Receiver { iq, ref noise, .. } = scene.receiver;
        let of = &scene.receiver;
        let samples = libm::round(scene.seconds * scene.rate_hz) as usize;
        let steps = of.oversampling.max(1);
        let fine_hz = scene.rate_hz * steps as f64;
        let deviation = match (&noise.rms, &noise.snr_db) {
            (Some(rms), _) => rms.draw(draw),
            (_, Some(snr_db)) => {
                amplitude / libm::sqrt(2.0 * libm::exp10(snr_db.draw(draw) / 10.0))
            }
            _ => 0.0,
        };
        let quadrature = of.quadrature_rad.draw(draw);
        // A real waveform comes in in any direction of the plane of I and Q; of a real record with either sign.
        let shares = |turns: f64| {
            let (sin, cos) = libm::sincos(TAU * turns);
            if iq { [cos, sin] } else { [if cos < 0.0 { -1.0 } else { 1.0 }, 0.0] }
        };
        let mut hum = Vec::new();
        for line in &of.hum {
            let (hz, amplitude) = (line.frequency_hz.draw(draw), line.amplitude.draw(draw));
            let turns = Value::or_any(line.phase_turns.as_ref(), draw);
            let shares = shares(Value::or_any(line.direction_turns.as_ref(), draw));
            hum.push(Line { hz, turns, amplitude, shares });
            for &[order, level_db] in &line.harmonics {
                let level = amplitude * libm::exp10(level_db / 20.0);
                hum.push(Line { hz: order * hz, turns: draw.share(), amplitude: level, shares });
            }
        }
        let drift = of.drift.as_ref().map(|drift| (drift.course(draw), shares(draw.share())));
        let burst = of.noise_burst.as_ref();
        let burst = burst.map(|of| [&of.rms, &of.from_s, &of.for_s].map(|value| value.draw(draw)));
        let mut impulses = Vec::new();
        if let Some(of) = &of.impulses {
            for _ in 0..libm::round(of.count.draw(draw)) as u64 {
                let (at, codes) = (draw.below(samples) as u64, of.codes.draw(draw));
                impulses.push((at, [codes * draw.sign(), codes * draw.sign()]));
            }
        }
        let section = |&corner: &f64, high: bool| {
            let corner = libm::tan(PI * (corner / fine_hz).min(0.499));
            Section { high, corner, state: None }
        };
        let sections = of.high_pass_hz.iter().map(|hz| section(hz, true));
        let sections = sections.chain(of.low_pass_hz.iter().map(|hz| section(hz, false))).collect();
        let converter = scene.converter.clone();
        let (inl, step) = (converter.inl_codes.draw(draw), converter.step_codes.draw(draw));
        let weights = [0; 3].map(|_| step * draw.sign());
        let mut place = |place: &Option<Place>| {
            let of = place.as_ref()?;
            Some((libm::round(of.at.draw(draw)) as u64, libm::round(of.count.draw(draw))))
        };
        let (lost, repeated, stale) =
            (place(&converter.lost), place(&converter.repeated), place(&converter.stale));
        let mut noise_draw = Draw::part(scene.seed, trial, 0);
        let coloured = (!noise.shape.is_empty()).then(|| {
            let samples = samples * steps;
            Coloured::new(&noise.shape, iq, fine_hz, samples, nominal_hz, &mut noise_draw)
        });
        Path {
            iq,
            rate_hz: scene.rate_hz,
            steps,
            gain: 1.0 + of.gain_error.draw(draw),
            quadrature: libm::sincos(quadrature),
            mixed: noise.mixed,
            late_s: of.q_late_s.draw(draw),
            dead: of.dead,
            offset: [of.offset[0].draw(draw), of.offset[1].draw(draw)],
            noise: match &coloured {
                Some(coloured) if noise.at_tone => deviation / libm::sqrt(coloured.at(nominal_hz)),
                _ => deviation,
            },
            coloured,
            hum,
            drift,
            burst,
            impulses,
            sections,
            limit: of.limit,
            converter,
            inl,
            weights,
            lost,
            stale,
            repeated: repeated.map(|(at, count)| (at, count as u64)),
            draw: Some(noise_draw),
            clock: Some(Draw::part(scene.seed, trial, 3)),
            taken: 0,
            next_s: f64::NAN,
            last: [0.0; 2],
        }
    }

    /// The gain of its filters at a frequency.
    pub fn gain(&self, hz: f64) -> f64 {
        let tangent = libm::tan(PI * (hz / (self.rate_hz * self.steps as f64))).abs();
        let passed = |section: &Section| {
            let over = tangent / section.corner;
            (if section.high { over } else { 1.0 }) / libm::hypot(over, 1.0)
        };
        self.sections.iter().map(passed).product()
    }

    /// The noise's standard deviation behind its filters in each part, codes.
    pub fn passed_noise(&self) -> f64 {
        if self.sections.is_empty() || self.noise == 0.0 {
            return self.noise;
        }
        let half_hz = 0.5 * self.rate_hz * self.steps as f64;
        let dense = |hz: f64| self.coloured.as_ref().map_or(1.0, |coloured| coloured.at(hz));
        // Both sides of 0 Hz: the noise of I/Q records may differ there.
        let power = |step: i32| {
            let hz = half_hz * (f64::from(step) + 0.5) / f64::from(STEPS);
            let gain = self.gain(hz);
            gain * gain * 0.5 * (dense(hz) + dense(-hz))
        };
        self.noise * libm::sqrt((0..STEPS).map(power).sum::<f64>() / f64::from(STEPS))
    }

    /// Whether each sample is taken when it should be.
    fn is_punctual(&self) -> bool {
        let Converter { clock_ppm, skew_s, jitter_s, .. } = self.converter;
        let moved = self.lost.is_some() || self.stale.is_some();
        !moved && clock_ppm == 0.0 && skew_s == 0.0 && jitter_s <= 0.0
    }

    /// When a sample is taken that should be taken at a time, s; by its number in the run.
    fn instant_s(&mut self, time_s: f64, number: u64) -> f64 {
        let sample_s = 1.0 / self.rate_hz;
        let mut time_s = time_s * (1.0 - 1e-6 * self.converter.clock_ppm);
        if let Some((at, count)) = self.lost
            && number >= at
        {
            time_s += count * sample_s;
        }
        if let Some((at, count)) = self.stale
            && number >= at
        {
            time_s -= count * sample_s;
        }
        if self.converter.skew_s != 0.0 && number % 2 == 1 {
            time_s += self.converter.skew_s;
        }
        if self.converter.jitter_s > 0.0
            && let Some(clock) = &mut self.clock
        {
            time_s += self.converter.jitter_s * clock.normal();
        }
        time_s
    }

    /// What is beside the signal at a time: offsets, hum, drift.
    fn beside(&self, time_s: f64) -> [f64; 2] {
        let mut sum = self.offset;
        for line in &self.hum {
            let turns = line.hz * time_s + line.turns;
            let level = line.amplitude * libm::cos(TAU * (turns - libm::floor(turns)));
            sum = [sum[0] + line.shares[0] * level, sum[1] + line.shares[1] * level];
        }
        if let Some((course, shares)) = &self.drift {
            let level = course.at(time_s);
            sum = [sum[0] + shares[0] * level, sum[1] + shares[1] * level];
        }
        sum
    }

    /// The voltages of `n` samples from a time on, in codes; `signal` says what the mixer receives at a time.
    pub fn take(
        &mut self,
        from_s: f64,
        n: usize,
        signal: impl Fn(f64) -> [f64; 2],
    ) -> Vec<[f64; 2]> {
        let continues = (from_s - self.next_s).abs() * self.rate_hz < 1e-3;
        if !continues {
            self.sections.iter_mut().for_each(|section| section.state = None);
        }
        self.next_s = from_s + n as f64 / self.rate_hz;
        let ((sin, cos), gain) = (self.quadrature, self.gain);
        let fine_s = 1.0 / (self.rate_hz * self.steps as f64);
        let punctual = self.is_punctual();
        let mut volts = Vec::with_capacity(n);
        for index in 0..n {
            let number = self.taken;
            self.taken += 1;
            let mut instant_s = from_s + index as f64 / self.rate_hz;
            if !punctual {
                instant_s = self.instant_s(instant_s, number);
            }
            let mut volt = [0.0; 2];
            for step in 0..self.steps {
                let time_s = instant_s + step as f64 * fine_s;
                let mut x = signal(time_s);
                if self.iq {
                    let late = if self.late_s == 0.0 { x } else { signal(time_s - self.late_s) };
                    x[1] = gain * (late[1] * cos + late[0] * sin);
                } else {
                    x[1] = 0.0;
                }
                let beside = self.beside(time_s);
                let mut noise = self.noise_at(time_s);
                if self.mixed && self.iq {
                    noise[1] = gain * (noise[1] * cos + noise[0] * sin);
                }
                x = [x[0] + beside[0] + noise[0], x[1] + beside[1] + noise[1]];
                for section in &mut self.sections {
                    x = section.pass(x);
                }
                if step == 0 {
                    volt = x;
                }
            }
            for (_, codes) in self.impulses.iter().filter(|(at, _)| *at == number) {
                volt = [volt[0] + codes[0], volt[1] + codes[1]];
            }
            if let Some(limit) = self.limit {
                volt = volt.map(|part| part.clamp(-limit, limit));
            }
            match self.dead {
                Some(0) => volt[0] = 0.0,
                Some(_) => volt[1] = 0.0,
                None => {}
            }
            volts.push(if self.iq { volt } else { [volt[0], 0.0] });
        }
        volts
    }

    fn noise_at(&mut self, time_s: f64) -> [f64; 2] {
        let Some(draw) = &mut self.draw else { return [0.0; 2] };
        let mut noise = [0.0; 2];
        if self.noise > 0.0 {
            let unit = match &mut self.coloured {
                Some(coloured) => coloured.next(draw),
                None => [draw.normal(), if self.iq { draw.normal() } else { 0.0 }],
            };
            noise = unit.map(|part| self.noise * part);
        }
        if let Some([rms, from_s, for_s]) = self.burst
            && (from_s..from_s + for_s).contains(&time_s)
        {
            noise = [noise[0] + rms * draw.normal(), noise[1] + rms * draw.normal()];
        }
        noise
    }

    /// The codes of voltages, the first of which is sample number `first`; of a converter that rounds and ends at its rails, or of none such.
    pub fn convert(&mut self, volts: &[[f64; 2]], first: u64, rounds: bool) -> Vec<[f64; 2]> {
        let code = |[i, q]: &[f64; 2]| {
            [self.code(*i, rounds), if self.iq { self.code(*q, rounds) } else { 0.0 }]
        };
        let mut codes: Vec<[f64; 2]> = volts.iter().map(code).collect();
        if self.converter.swapped {
            codes.as_chunks_mut().0.iter_mut().for_each(|pair: &mut [_; 2]| pair.reverse());
        }
        if let Some((at, count)) = self.repeated {
            let before = codes.clone();
            for (index, code) in codes.iter_mut().enumerate() {
                let number = first + index as u64;
                if number >= at {
                    // What comes after is late, and what repeats is the one before.
                    let back = if number < at + count { number + 1 - at } else { count };
                    *code = (index as u64)
                        .checked_sub(back)
                        .and_then(|from| before.get(from as usize))
                        .copied()
                        .unwrap_or(self.last);
                }
            }
            self.last = before.last().copied().unwrap_or(self.last);
        }
        codes
    }

    /// The code of a voltage.
    fn code(&self, volt: f64, rounds: bool) -> f64 {
        let Converter { bits, unsigned, wraps, missing_codes, stuck_bit, wrong_sign, .. } =
            self.converter;
        let (half, zero) = match self.converter.rails {
            Some(rails) => {
                let [low, high] = rails.map(f64::from);
                (0.5 * (high + 1.0 - low), 0.5 * (high + 1.0 + low))
            }
            None => {
                // Widths are 16 bits at most.
                let half = f64::from(1u32.wrapping_shl(bits.wrapping_sub(1)));
                (half, if unsigned { half } else { 0.0 })
            }
        };
        let mut x = volt;
        if self.inl != 0.0 {
            let y = x / half;
            x += self.inl * (0.5 * (1.0 - y * y) + 1.3 * (y * y * y - y));
        }
        if self.weights[0] != 0.0 {
            let code = libm::floor((x / half + 1.0) * 4.0).clamp(0.0, 7.0) as usize;
            for (bit, weight) in self.weights.iter().enumerate() {
                if code >> (2 - bit) & 1 == 1 {
                    x += weight / libm::exp2(bit as f64);
                }
            }
        }
        // A middle between two codes leaves whole ones.
        let part = zero - libm::floor(zero);
        let mut code = if rounds { libm::round(x + part) - part } else { x };
        code = match (wraps, rounds) {
            (true, _) => modulo(code + half, 2.0 * half) - half,
            (false, true) => code.clamp(-half, half - 1.0),
            (false, false) => code,
        };
        if missing_codes > 0 {
            let (count, step) = (missing_codes as f64, half / 4.0);
            let over = modulo(code, step);
            if over < count && code > -half {
                code -= over + 1.0;
            }
        }
        if let Some(stuck) = stuck_bit {
            let weight = libm::exp2(f64::from(stuck.bit));
            let set = modulo(libm::floor((code + half) / weight), 2.0) >= 1.0;
            code += weight * (f64::from(u8::from(stuck.high)) - f64::from(u8::from(set)));
        }
        if wrong_sign {
            code += if code < 0.0 { half } else { -half };
        }
        code + zero
    }
}

/// What is left of a division whose quotient is whole, from 0 up.
fn modulo(x: f64, by: f64) -> f64 {
    x - by * libm::floor(x / by)
}

impl Receiver {
    pub(crate) fn check(&self, sources: bool) -> Result<(), String> {
        const ANY: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);
        const SOME: (f64, f64) = (0.0, f64::INFINITY);
        self.gain_error.check("gain_error", false, (-1.0, 100.0))?;
        self.quadrature_rad.check("quadrature_rad", false, ANY)?;
        self.q_late_s.check("q_late_s", false, ANY)?;
        self.offset.iter().try_for_each(|value| value.check("offset", false, ANY))?;
        match (&self.noise.rms, &self.noise.snr_db) {
            (Some(_), Some(_)) => return Err("noise: give rms or snr_db, not both".into()),
            (_, Some(_)) if !sources => {
                return Err("noise: snr_db is that of a source: give rms, or a source".into());
            }
            (Some(rms), _) => rms.check("noise: rms", false, SOME)?,
            (_, Some(snr_db)) => snr_db.check("noise: snr_db", false, (-300.0, 300.0))?,
            _ => {}
        }
        if let Some(crate::scene::Density::Points { points, .. }) = self
            .noise
            .shape
            .iter()
            .find(|density| matches!(density, crate::scene::Density::Points { .. }))
        {
            Value::Over(points.clone()).check("noise: points", true, (-300.0, 300.0))?;
        }
        for hum in &self.hum {
            hum.frequency_hz.check("hum: frequency_hz", false, SOME)?;
            hum.amplitude.check("hum: amplitude", false, SOME)?;
        }
        self.drift.as_ref().map_or(Ok(()), |drift| drift.check("drift", true, ANY))?;
        if self.high_pass_hz.iter().chain(&self.low_pass_hz).any(|&hz| hz.is_nan() || hz <= 0.0) {
            return Err("high_pass_hz, low_pass_hz: give numbers above 0".into());
        }
        match (self.dead, self.oversampling) {
            (Some(2..), _) => Err("dead: give 0 for I or 1 for Q".into()),
            (_, 0 | 1025..) => Err("oversampling: give 1 to 1024".into()),
            _ => Ok(()),
        }
    }
}

impl Converter {
    pub(crate) fn check(&self) -> Result<(), String> {
        let most = if self.unsigned { 15 } else { 16 };
        if !(2..=most).contains(&self.bits) {
            return Err(format!("bits: give 2 to {most}"));
        }
        if self.rails.is_some_and(|[low, high]| low >= high) {
            return Err("rails: give the lowest code, then the highest".into());
        }
        if self.stuck_bit.is_some_and(|stuck| stuck.bit >= self.bits) {
            return Err(format!("stuck_bit: the codes have bits 0 to {}", self.bits - 1));
        }
        for place in [&self.lost, &self.repeated, &self.stale].into_iter().flatten() {
            place.at.check("at", false, (0.0, f64::INFINITY))?;
            place.count.check("count", false, (0.0, f64::INFINITY))?;
        }
        (self.jitter_s >= 0.0 && self.skew_s.is_finite() && self.clock_ppm.is_finite())
            .then_some(())
            .ok_or_else(|| "jitter_s: give 0 or more".into())
    }
}
