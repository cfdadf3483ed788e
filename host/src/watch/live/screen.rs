//! What stands on the terminal: the answer, its verdict, its course, the counters.

use super::{Live, Quantity, Target, Value};
use crate::cli::decimals;
use crate::device::Listener;
use crate::watch::error::unknown;
use picket_dsp::tone::{Usable, Verdict};
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style};
use ratatui::symbols::Marker;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Axis, Block, Chart, Dataset, GraphType, Paragraph, Wrap};

impl Quantity {
    pub(super) const fn name(self) -> &'static str {
        match self {
            Quantity::Range => "range, m",
            Quantity::Velocity => "velocity, m/s",
            Quantity::Frequency => "frequency",
        }
    }
}

impl Live {
    /// Draws all of it.
    pub(super) fn draw(&self, frame: &mut Frame) {
        let rows = Layout::vertical([
            Constraint::Length(1),
            Constraint::Length(8),
            Constraint::Min(8),
            Constraint::Length(3),
            Constraint::Length(1),
        ]);
        let [head, answer, chart, counters, keys] = rows.areas(frame.area());
        frame.render_widget(self.head(), head);
        self.answer(frame, answer);
        self.chart(frame, chart);
        self.counters(frame, counters);
        let quiet = Style::new().add_modifier(Modifier::DIM);
        let words = " q quits   space pauses   v draws another quantity";
        frame.render_widget(Paragraph::new(words).style(quiet), keys);
    }

    fn head(&self) -> Paragraph<'_> {
        let state = match (self.paused, self.ended, self.newest.is_some()) {
            (true, ..) => "paused",
            (_, true, _) => "at its end",
            (_, _, true) => "live",
            _ => "waiting for the device",
        };
        let bold = Style::new().add_modifier(Modifier::BOLD);
        let mut words = vec![
            Span::styled(" Picket ", bold.add_modifier(Modifier::REVERSED)),
            Span::raw(format!(" {}, {state}", self.title)),
        ];
        let known = self.scale.known();
        if let Some(known) = known {
            let kind = if known.iq { "I/Q" } else { "real" };
            words.push(Span::raw(format!("   {} {kind} samples", known.n)));
        }
        if let Some(rate) = self.rate_hz.or(known.map(|known| known.rate_hz)) {
            let before = if known.is_some() { " " } else { "   " };
            words.push(Span::raw(format!("{before}at {} kHz", rate / 1e3)));
            words.extend(self.clock_error());
        }
        Paragraph::new(Line::from(words))
    }

    /// By how much the sample clock is fast, by this machine's clock.
    fn clock_error(&self) -> Option<Span<'static>> {
        let error = self.clock.error()?;
        if self.clock.is_wrong() {
            let raised = Style::new().fg(Color::Red).add_modifier(Modifier::BOLD);
            let share = 100.0 + 1e-4 * error.ppm;
            return Some(Span::styled(format!(", WRONG: {share:.2} % of it"), raised));
        }
        let digits = decimals(f64::from(error.sigma_ppm).max(0.01));
        let [ppm, sigma] = [error.ppm, error.sigma_ppm];
        Some(Span::raw(format!(" {ppm:+.digits$} ± {sigma:.digits$} ppm")))
    }

    fn answer(&self, frame: &mut Frame, area: Rect) {
        let halves = Layout::horizontal([Constraint::Length(42), Constraint::Min(20)]);
        let [figures, verdict] = halves.areas(area);
        let Some(record) = &self.newest else {
            let words = match (self.bytes, self.listener.version) {
                (_, Some(version)) => unknown(version),
                (0, None) => {
                    "It says nothing yet: has it power and its image (picket flash)?".to_owned()
                }
                (bytes, None) => {
                    format!("{bytes} bytes came, and no frame: is it the board's port?")
                }
            };
            let words = Paragraph::new(words).wrap(Wrap { trim: true });
            return frame.render_widget(words.block(Block::bordered()), area);
        };
        let tone = &record.measurement.tone;
        let (rate, unit) = self.rate_hz.map_or((1.0, "cycles/sample"), |rate| (rate, "Hz"));
        let mut lines = Vec::new();
        if let Some(Target { range, velocity, .. }) = self.target {
            lines.extend(range.map(|range| figure("range", range, "m")));
            lines.extend(velocity.map(|velocity| figure("velocity", velocity, "m/s")));
        }
        let frequency = (tone.frequency.hertz(rate), f64::from(tone.sigma) * rate);
        lines.push(figure("frequency", frequency, unit));
        lines.push(Line::from(format!(" {:>9}  {:.1} dB", "SNR", tone.snr_db())));
        lines.push(Line::from(format!(" {:>9}  {:.0} codes", "amplitude", tone.amplitude)));
        if let Some(follow) = &self.follow {
            let lock = if follow.locked { ", locked" } else { "" };
            lines.push(Line::from(format!(" {:>9}  {}{lock}", "tracks", follow.tracks.len())));
        }
        frame.render_widget(
            Paragraph::new(lines).block(Block::bordered().title(" answer ")),
            figures,
        );
        let said = self.target.map_or(tone.verdict, |target| target.verdict);
        let style = colour(said).add_modifier(Modifier::BOLD);
        let mut words = vec![
            Line::from(Span::styled(format!("{} {}", sign(said), said.name()), style)),
            Line::from(""),
            Line::from(said.reason()),
        ];
        let caution = self.target.and_then(|target| target.caution);
        words.extend(caution.map(Line::from));
        let rate = self.clock.is_wrong().then_some("wrong-rate: every number is off by as much");
        words.extend(rate.map(Line::from));
        let words = Paragraph::new(words).wrap(Wrap { trim: true });
        frame.render_widget(words.block(Block::bordered().title(" verdict ")), verdict);
    }

    fn chart(&self, frame: &mut Frame, area: Rect) {
        let name = self.quantity.map_or("answers", Quantity::name);
        let block = Block::bordered().title(format!(" {name}, with ± sigma "));
        let Some(history) = self.quantity.map(|quantity| &self.history[quantity as usize]) else {
            return frame.render_widget(block, area);
        };
        let (Some(first), Some(last)) = (history.front(), history.back()) else {
            return frame.render_widget(block, area);
        };
        let points = |side: f64| -> Vec<(f64, f64)> {
            history.iter().map(|&(time, value, sigma)| (time, value + side * sigma)).collect()
        };
        let [low, value, high] = [-1.0, 0.0, 1.0].map(points);
        let bottom = low.iter().map(|p| p.1).fold(f64::INFINITY, f64::min);
        let top = high.iter().map(|p| p.1).fold(f64::NEG_INFINITY, f64::max);
        let spread = (top - bottom).max(1e-9);
        let (bottom, top) = (bottom - 0.1 * spread, top + 0.1 * spread);
        let digits = (1.0 - (top - bottom).log10().floor()).clamp(0.0, 9.0) as usize;
        let label = |value: f64, digits: usize| Line::from(format!("{value:.digits$}"));
        let seconds = (last.0 - first.0).max(1e-9);
        let unit = if self.rate_hz.is_some() { "s" } else { "samples" };
        let places = (2.0 - seconds.log10().floor()).clamp(0.0, 6.0) as usize;
        let set = |data, colour, kind| {
            Dataset::default()
                .data(data)
                .marker(Marker::Braille)
                .graph_type(kind)
                .style(Style::new().fg(colour))
        };
        let band = GraphType::Scatter;
        let sets = vec![
            set(&low, Color::DarkGray, band),
            set(&high, Color::DarkGray, band),
            set(&value, Color::Cyan, GraphType::Line),
        ];
        let x = Axis::default().bounds([first.0, first.0 + seconds]).labels([
            label(first.0, places),
            Line::from(format!("{:.places$} {unit}", first.0 + seconds)),
        ]);
        let middle = (bottom + top) / 2.0;
        let labels = [bottom, middle, top].map(|value| label(value, digits));
        let y = Axis::default().bounds([bottom, top]).labels(labels);
        frame.render_widget(Chart::new(sets).x_axis(x).y_axis(y).block(block), area);
    }

    fn counters(&self, frame: &mut Frame, area: Rect) {
        let Listener { records, missing, bad, .. } = self.listener;
        let health = self.newest.map(|record| record.health).unwrap_or_default();
        let raised = Style::new().fg(Color::Red).add_modifier(Modifier::BOLD);
        let mut words = vec![Span::raw(format!(" records {records}"))];
        for (name, count) in [
            ("missing", missing),
            ("bad frames", bad),
            ("lost", health.lost.into()),
            ("faults", health.faults.into()),
        ] {
            let style = if count > 0 { raised } else { Style::new() };
            words.push(Span::styled(format!("   {name} {count}"), style));
        }
        if let Some(status) = &self.status {
            // Records that a full line has thinned are missing, and no block of them is lost.
            if status.dropped > 0 {
                words.push(Span::styled(format!("   no room {}", status.dropped), raised));
            }
            words.push(Span::raw(format!("   load {:.1} %", f64::from(status.load) / 10.0)));
        }
        let words = Paragraph::new(Line::from(words));
        frame.render_widget(words.block(Block::bordered().title(" counters ")), area);
    }
}

/// A value with as many digits as its sigma permits.
fn figure(name: &str, (value, sigma): Value, unit: &str) -> Line<'static> {
    let digits = if sigma > 0.0 { decimals(sigma) } else { 3 };
    let bold = Style::new().add_modifier(Modifier::BOLD);
    Line::from(vec![
        Span::raw(format!(" {name:>9}  ")),
        Span::styled(format!("{value:.digits$}"), bold),
        Span::raw(format!(" ± {sigma:.digits$} {unit}")),
    ])
}

/// Told apart without colour, too.
const fn sign(verdict: Verdict) -> &'static str {
    match verdict.usable() {
        Usable::Yes => "√",
        Usable::WithinSigma | Usable::WithoutSign | Usable::Rough => "!",
        Usable::No => "x",
    }
}

fn colour(verdict: Verdict) -> Style {
    Style::new().fg(match verdict.usable() {
        Usable::Yes => Color::Green,
        Usable::WithinSigma | Usable::WithoutSign | Usable::Rough => Color::Yellow,
        Usable::No => Color::Red,
    })
}
