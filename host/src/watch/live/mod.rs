//! `--live`: what a device measures as a picture on the terminal, by ratatui, on 80 columns and 24 lines or more.

mod screen;

use super::clock::HostClock;
use super::orders::Pending;
use super::port::{Piece, Source};
use super::scale::Scale;
use super::{Kept, Options, WatchError, io};
use crate::device::{Listener, Said};
use crate::end;
use picket_dsp::pipeline::Outcome;
use picket_dsp::tone::{Usable, Verdict};
use picket_wire::follow::Follow;
use picket_wire::status::Status;
use picket_wire::telemetry::Telemetry;
use ratatui::DefaultTerminal;
use ratatui::crossterm::event::{self, Event, KeyCode, KeyModifiers};
use std::collections::VecDeque;
use std::path::Path;
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// Points of the history.
const KEPT: usize = 2000;
/// Time from picture to picture.
const FRAME: Duration = Duration::from_millis(100);

/// Quantities over time: the first that a device gives is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Quantity {
    Range,
    Velocity,
    Frequency,
}

impl Quantity {
    const ALL: [Self; 3] = [Quantity::Range, Quantity::Velocity, Quantity::Frequency];
}

/// A value and its sigma.
type Value = (f64, f64);

/// The newest range, m, and velocity, m/s.
#[derive(Clone, Copy)]
struct Target {
    range: Option<Value>,
    velocity: Option<Value>,
    verdict: Verdict,
    /// What a negative range says.
    caution: Option<&'static str>,
}

/// What is shown.
#[derive(Default)]
struct Live {
    listener: Listener,
    scale: Scale,
    title: String,
    newest: Option<Telemetry>,
    /// The sample rate of the newest, if it is known.
    rate_hz: Option<f64>,
    target: Option<Target>,
    status: Option<Status>,
    follow: Option<Follow>,
    /// Seconds, a value and its sigma, of each quantity.
    history: [VecDeque<(f64, f64, f64)>; 3],
    quantity: Option<Quantity>,
    paused: bool,
    ended: bool,
    heard: bool,
    bytes: u64,
    /// The board's clock against this machine's; of a port, whose bytes come as the board sends them.
    clock: HostClock,
    begun: Option<Instant>,
}

/// Draws until the user ends it.
pub(super) fn run(options: &Options) -> Result<ExitCode, WatchError> {
    let mut source = Source::open(options.port.as_deref(), options.replay.as_deref())?;
    let kept = |path: &Path| Kept::create(path, options.output);
    let mut record = options.record.as_deref().map(kept).transpose()?;
    let mut live = Live {
        scale: Scale::given(options.rate),
        title: title(options.port.as_deref(), options.replay.as_deref()),
        ..Live::default()
    };
    end::look();
    let mut orders = options.orders.prepare()?;
    let mut terminal = ratatui::try_init().map_err(io("the terminal"))?;
    let ended = live.until_the_end(&mut terminal, &mut source, &mut orders, &mut record);
    ratatui::restore();
    ended.map(|()| ExitCode::SUCCESS)
}

fn title(port: Option<&str>, replay: Option<&Path>) -> String {
    match (port, replay) {
        (_, Some(path)) => path.display().to_string(),
        (Some("-") | None, None) => "standard input".into(),
        (Some(port), None) => port.into(),
    }
}

impl Live {
    fn until_the_end(
        &mut self,
        terminal: &mut DefaultTerminal,
        source: &mut Source,
        orders: &mut Pending,
        record: &mut Option<Kept>,
    ) -> Result<(), WatchError> {
        let mut drawn: Option<Instant> = None;
        while end::asked().is_none() {
            if !self.ended && !self.paused {
                self.hear(source, orders, record)?;
            }
            if drawn.is_none_or(|drawn| drawn.elapsed() >= FRAME) {
                drawn = Some(Instant::now());
                terminal.draw(|frame| self.draw(frame)).map_err(io("the terminal"))?;
            }
            // A source that waits has waited already.
            let wait = if self.ended || self.paused { FRAME } else { Duration::ZERO };
            if event::poll(wait).map_err(io("the terminal"))?
                && let Event::Key(key) = event::read().map_err(io("the terminal"))?
            {
                let control = key.modifiers.contains(KeyModifiers::CONTROL);
                match key.code {
                    KeyCode::Char('c') if control => break,
                    KeyCode::Char('q') | KeyCode::Esc => break,
                    KeyCode::Char(' ' | 'p') => self.paused = !self.paused,
                    KeyCode::Char('v') => self.turn(),
                    _ => {}
                }
            }
        }
        Ok(())
    }

    fn hear(
        &mut self,
        source: &mut Source,
        orders: &mut Pending,
        record: &mut Option<Kept>,
    ) -> Result<(), WatchError> {
        match source.piece()? {
            Piece::End => self.ended = true,
            Piece::Opened => {
                self.scale.forget();
                self.clock.restart();
                orders.ask(source)?;
                orders.renew(source);
            }
            Piece::Bytes(bytes) => {
                if let Some(file) = record {
                    file.write(&bytes)?;
                }
                self.bytes += bytes.len() as u64;
                let arrival = self.begun.get_or_insert_with(Instant::now).elapsed();
                for byte in bytes {
                    if let Some(said) = self.listener.push(byte) {
                        self.heard = true;
                        orders.hear(&said, source)?;
                        if source.listens() {
                            self.compare(&said, arrival);
                        }
                        if self.take(said) {
                            orders.renew(source);
                        }
                    }
                }
            }
        }
        orders.again(source, self.heard, self.bytes)
    }

    /// Compares the board's clock with this machine's.
    fn compare(&mut self, said: &Said, arrival: Duration) {
        let (scale, listener) = (&self.scale, &self.listener);
        // What it tells stands on the screen as long as it holds.
        let _ = self.clock.hear(said, |sequence| scale.rate_of(sequence, listener), arrival);
    }

    /// Takes what is said. True if the settings have become unknown.
    fn take(&mut self, said: Said) -> bool {
        let unknown = self.scale.hear(&said, &self.listener);
        match said {
            Said::Telemetry(record) => self.measured(record),
            Said::Burst(burst) => self.measured(burst.record()),
            Said::Status(status) => self.status = Some(status),
            Said::Follow(follow) => self.follow = Some(follow),
            Said::Boot(boot) => {
                self.title = boot.board.as_str().to_owned();
                (self.newest, self.target, self.status, self.follow) = (None, None, None, None);
                self.begin(None);
            }
            // The picture has room for one tone.
            Said::Lines(_)
            | Said::Fundamental(_)
            | Said::Sum(_)
            | Said::ChirpFrame(_)
            | Said::Found(_) => {}
            Said::Answer(..) | Said::Raw(_) => {}
        }
        unknown
    }

    /// The histories begin again, at this rate: their times have another zero, or another unit.
    fn begin(&mut self, rate_hz: Option<f64>) {
        self.rate_hz = rate_hz;
        self.history.iter_mut().for_each(VecDeque::clear);
    }

    fn measured(&mut self, record: Telemetry) {
        let tone = &record.measurement.tone;
        let rate_hz = self.scale.rate_of(record.measurement.stamp.sequence, &self.listener);
        if rate_hz != self.rate_hz {
            self.begin(rate_hz);
        }
        // Without a rate all is counted in samples.
        let rate = rate_hz.unwrap_or(1.0);
        let time = record.measurement.stamp.clock as f64 / rate;
        let usable = |verdict: Verdict| verdict.usable() < Usable::No;
        let mut points = Vec::new();
        match &record.measurement.result {
            Outcome::None => {}
            Outcome::Velocity(v) => {
                let velocity = (v.velocity.to_num(), v.sigma.into());
                let (range, verdict, caution) = (None, v.verdict, None);
                let shown = Some(velocity);
                self.target = Some(Target { range, velocity: shown, verdict, caution });
                points.push((Quantity::Velocity, velocity, usable(v.verdict)));
            }
            Outcome::Target(t) => {
                let range = (t.range.to_num(), t.sigma_range.into());
                let velocity = t.velocity.map(|v| (v.to_num(), t.sigma_velocity.into()));
                let (verdict, caution) = (t.verdict, t.caution());
                self.target = Some(Target { range: Some(range), velocity, verdict, caution });
                points.push((Quantity::Range, range, usable(t.verdict)));
                let velocity = velocity.map(|v| (Quantity::Velocity, v, usable(t.verdict)));
                points.extend(velocity);
            }
        }
        if record.measurement.stamp.segment == picket_dsp::Segment::Continuous {
            let frequency = (tone.frequency.hertz(rate), f64::from(tone.sigma) * rate);
            points.push((Quantity::Frequency, frequency, usable(tone.verdict)));
        }
        self.newest = Some(record);
        if let Some(&(first, ..)) = points.first() {
            self.quantity = self.quantity.or(Some(first));
        }
        for (quantity, (value, sigma), _) in points.into_iter().filter(|point| point.2) {
            let history = &mut self.history[quantity as usize];
            history.push_back((time, value, sigma));
            if history.len() > KEPT {
                history.pop_front();
            }
        }
    }

    /// Draws the next quantity of which there are values.
    fn turn(&mut self) {
        let Some(current) = self.quantity else { return };
        let order = (1..=3).map(|step| Quantity::ALL[(current as usize + step) % 3]);
        let filled = |&quantity: &Quantity| !self.history[quantity as usize].is_empty();
        self.quantity = order.into_iter().find(filled).or(self.quantity);
    }
}

#[cfg(test)]
#[path = "../../../tests/scenes.rs"]
mod scenes;

#[cfg(test)]
mod tests {
    use super::*;
    use picket_dsp::pipeline::Measurement;
    use ratatui::Terminal;
    use ratatui::backend::TestBackend;

    fn heard(bytes: &[u8]) -> Live {
        let mut live = Live { bytes: bytes.len() as u64, ..Live::default() };
        for &byte in bytes {
            if let Some(said) = live.listener.push(byte) {
                live.take(said);
            }
        }
        live
    }

    fn drawn(live: &Live, width: u16, height: u16) -> String {
        let mut terminal = Terminal::new(TestBackend::new(width, height)).unwrap();
        terminal.draw(|frame| live.draw(frame)).unwrap();
        terminal.backend().to_string()
    }

    /// The newest record's own rate is shown, and the settings are asked for where they may be others.
    #[test]
    fn a_records_own_rate_is_drawn() {
        for scene in scenes::SCENES {
            let [before, after] = scene.bytes();
            let mut live = heard(&before);
            if scene == scenes::Scene::Reopened {
                live.scale.forget();
            }
            let mut asks = 0;
            for byte in after {
                let said = live.listener.push(byte);
                asks += usize::from(said.is_some_and(|said| live.take(said)));
            }
            let screen = drawn(&live, 100, 30);
            assert!(screen.contains("10000.000 ± 0.100 Hz"), "{scene:?}\n{screen}");
            assert!(screen.contains("at 100 kHz") && !screen.contains("250 kHz"), "{screen}");
            let times: Vec<f64> = live.history[Quantity::Frequency as usize]
                .iter()
                .map(|point| (point.0 * 100e3).round())
                .collect();
            assert_eq!(times, [1024.0, 2048.0, 3072.0], "{scene:?}");
            let unknown = matches!(scene, scenes::Scene::Restart | scenes::Scene::Elsewhere);
            assert_eq!(asks, usize::from(unknown), "{scene:?}");
        }
    }

    #[test]
    fn a_session_on_small_and_large_terminals() {
        let mut live = heard(include_bytes!("../../../../docs/session.bin"));
        for (width, height) in [(80, 24), (200, 60)] {
            let screen = drawn(&live, width, height);
            for words in [
                "nucleo-f446re, live",
                "1024 I/Q samples at 250 kHz",
                "range  88.31275 ± 0.00065 m",
                "velocity  13.9994 ± 0.0011 m/s",
                "√ good",
                "records 30   missing 0   bad frames 0   lost 0   faults 0   load 31.0 %",
                "q quits",
            ] {
                assert!(screen.contains(words), "{words}\n{screen}");
            }
            // The curve, in dots.
            assert!(screen.chars().any(|c| ('\u{2801}'..='\u{28ff}').contains(&c)), "{screen}");
        }
        // It has no frequencies: those of a chirp's ramps are not one quantity.
        for quantity in [Quantity::Velocity, Quantity::Range] {
            live.turn();
            assert_eq!(live.quantity, Some(quantity));
            assert!(drawn(&live, 80, 24).contains(quantity.name()));
        }
        for quantity in [None, Some(Quantity::Range)] {
            let mut nothing = Live { quantity, ..Live::default() };
            nothing.turn();
            assert_eq!(nothing.quantity, quantity);
        }
    }

    /// The clock's error stands beside the rate, and a wrong rate where every number is.
    #[test]
    fn the_clocks_error_is_drawn() {
        for (ratio, words) in [
            (1.0 + 20e-6, &["samples at 250 kHz +", " ppm"][..]),
            (0.8, &["at 250 kHz, WRONG: 80.00 % of it", "wrong-rate: every number"]),
        ] {
            let mut live = heard(include_bytes!("../../../../docs/session.bin"));
            let newest = live.newest.unwrap();
            let mut stamp = newest.measurement.stamp;
            let block_s = 1024.0 / newest.measurement.tone.rate_hz;
            let mut listener = Listener::default();
            for &byte in include_bytes!("../../../../docs/session.bin") {
                let said = listener.push(byte);
                if let Some(said) = said.filter(|said| matches!(said, Said::Answer(..))) {
                    live.compare(&said, Duration::ZERO);
                }
            }
            for block in 0..5000u32 {
                (stamp.sequence, stamp.clock) = (block, 1024 * u64::from(block));
                let measurement = Measurement { stamp, ..newest.measurement };
                let jitter = 1e-6 * f64::from((block * 7919) % 100);
                let at = f64::from(block) * block_s / ratio + jitter;
                for byte in (Telemetry { measurement, ..newest }).to_frame() {
                    let Some(said) = live.listener.push(byte) else { continue };
                    live.compare(&said, Duration::from_secs_f64(at));
                }
            }
            let screen = drawn(&live, 80, 24);
            let error = live.clock.error().unwrap();
            let off = f64::from(error.ppm) - 1e6 * (ratio - 1.0);
            assert!(off.abs() < 5.0 * f64::from(error.sigma_ppm).max(0.1), "{error:?}");
            assert!(words.iter().all(|words| screen.contains(words)), "{words:?}\n{screen}");
        }
    }

    #[test]
    fn smaller_terminals_and_strangers_do_no_harm() {
        let live = heard(include_bytes!("../../../../docs/session.bin"));
        for (width, height) in [(1, 1), (20, 5), (79, 10)] {
            drawn(&live, width, height);
        }
        let screen = drawn(&heard(b"AT+CGMI OK"), 80, 24);
        assert!(screen.contains("10 bytes came, and no frame"), "{screen}");
        assert!(drawn(&Live::default(), 80, 24).contains("It says nothing yet"));
    }
}
