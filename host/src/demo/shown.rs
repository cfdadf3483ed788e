//! One way to show the results of a scene: a table and figures for people, lines for programs, pictures, and an exit code.

use super::options::Options;
use super::{DemoError, said};
use crate::plot::chart::{Axis, Chart, Series, Style};
use comfy_table::{Cell, CellAlignment, Color, LineStyle, Table, TableStyle};
use picket_dsp::{Target, Usable, Verdict};
use serde::{Serialize, Serializer};
use serde_json::Value;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// What a scene has given.
#[derive(Clone, Debug)]
pub struct Shown {
    /// What it is of.
    pub heading: String,
    /// The rows, for people.
    pub table: String,
    /// What stands below them.
    pub text: String,
    /// For programs: a JSON object for each row, and one for all of them.
    pub lines: Vec<String>,
    /// A picture, or that of ranges and that of velocities.
    pub charts: Vec<Chart>,
    /// Whether all is as it should be.
    pub right: bool,
}

impl Shown {
    /// Draws it, prints it, and says whether it is right.
    pub(super) fn show(&self, options: &Options) -> Result<ExitCode, DemoError> {
        self.draw(options)?;
        if options.json {
            self.lines.iter().for_each(|line| outln!("{line}"));
        } else {
            out!("{}\n\n{}\n\n{}", self.heading, self.table, self.text);
        }
        Ok(code(self.right))
    }

    /// Draws it, where that is asked for.
    pub(super) fn draw(&self, options: &Options) -> Result<(), DemoError> {
        let Some(file) = &options.plot else { return Ok(()) };
        for (chart, file) in self.charts.iter().zip([file.clone(), beside(file)]) {
            chart.save(&file, options.output).map_err(said)?;
        }
        Ok(())
    }
}

/// Success, or failure.
pub(super) fn code(right: bool) -> ExitCode {
    if right { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// The file of velocities beside that of ranges.
pub(super) fn beside(file: &Path) -> PathBuf {
    let stem = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let suffix = file.extension().unwrap_or_default().to_string_lossy().into_owned();
    file.with_file_name(format!("{stem}-velocity.{suffix}"))
}

/// A JSON line for each row, and one for all of them.
pub(super) fn lines(rows: &[impl Serialize], all: &Keys) -> Result<Vec<String>, DemoError> {
    let lines = rows.iter().map(serde_json::to_string);
    lines.chain([serde_json::to_string(all)]).collect::<Result<_, _>>().map_err(said)
}

/// Keys and values of a JSON object, in their order.
#[derive(Clone, Debug)]
pub(super) struct Keys(pub Vec<(&'static str, Value)>);

impl Serialize for Keys {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_map(self.0.iter().map(|(key, value)| (key, value)))
    }
}

/// A JSON object of variables, and of what is stated after a name.
macro_rules! keys {
    (@ $key:ident) => { $key };
    (@ $key:ident : $value:expr) => { $value };
    ($($key:ident $(: $value:expr)?),* $(,)?) => {
        $crate::demo::shown::Keys(vec![
            $((stringify!($key), serde_json::json!(keys!(@ $key $(: $value)?)))),*
        ])
    };
}
pub(super) use keys;

/// A table of what rows have as JSON; on a terminal those that are outside are red. Columns are parted by ` | `, and each is
/// `HEAD: [FACTOR] PATH [DIGITS] [± PATH]`: digits are `.3`, or with a sign `+.3`. What a row lacks is a dash.
pub(super) fn table<'r, R: Serialize + 'r>(
    rows: impl IntoIterator<Item = &'r R>,
    columns: &str,
    outside: impl Fn(&R) -> bool,
) -> String {
    let columns: Vec<(&str, &str)> =
        columns.split(" | ").filter_map(|column| column.split_once(": ")).collect();
    let mut table = Table::new();
    let rule = LineStyle::none().fill('─').junction('─');
    table.load_style(TableStyle::new().header_separator(rule));
    let right = |text: &str| Cell::new(text).set_alignment(CellAlignment::Right);
    table.set_header(columns.iter().map(|(head, _)| right(head)));
    let colours = std::io::stdout().is_terminal();
    for row in rows {
        let red = |cell: Cell| if colours && outside(row) { cell.fg(Color::Red) } else { cell };
        let row = serde_json::json!(row);
        table.add_row(columns.iter().map(|(_, of)| red(right(&cell(&row, of)))));
    }
    table.trim_fmt()
}

/// What a column says of a row.
fn cell(row: &Value, of: &str) -> String {
    let (of, sigma) = of.split_once(" ± ").map_or((of, None), |(of, sigma)| (of, Some(sigma)));
    let mut words = of.split(' ').peekable();
    let factor = words.peek().and_then(|word| word.parse::<f64>().ok());
    words.next_if(|_| factor.is_some());
    let at = |path: &str| row.pointer(&format!("/{path}"));
    let number = |value: &Value, digits: &str| {
        let value = factor.unwrap_or(1.0) * value.as_f64()?;
        let places: usize = digits.trim_start_matches('+').strip_prefix('.')?.parse().ok()?;
        Some(match digits.starts_with('+') {
            true => format!("{value:+.places$}"),
            false => format!("{value:.places$}"),
        })
    };
    let digits = [words.next().unwrap_or_default(), words.next().unwrap_or(".0")];
    let text = match at(digits[0]) {
        Some(Value::String(text)) => Some(text.clone()),
        value => value.and_then(|value| number(value, digits[1])),
    };
    let sigma =
        sigma.and_then(at).and_then(|sigma| number(sigma, digits[1].trim_start_matches('+')));
    match (text, sigma) {
        (Some(text), Some(sigma)) => format!("{text} ± {sigma}"),
        (text, _) => text.unwrap_or_else(|| "-".into()),
    }
}

/// The root of the mean square.
pub(super) fn rms(values: impl IntoIterator<Item = f64>) -> f64 {
    let (mut squares, mut count) = (0.0, 0.0);
    for value in values {
        squares += value * value;
        count += 1.0;
    }
    (squares / f64::max(count, 1.0)).sqrt()
}

/// A measured target. The keys are those of the JSON lines.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Answer {
    /// Metres; 0 of a velocimeter.
    pub range_m: f64,
    /// Metres per second, positive when approaching.
    pub velocity_mps: f64,
    /// One standard deviation.
    pub sigma_range_m: f64,
    /// One standard deviation.
    pub sigma_velocity_mps: f64,
    /// Whether it may be used.
    #[serde(serialize_with = "named")]
    pub verdict: Verdict,
}

impl From<&Target> for Answer {
    fn from(target: &Target) -> Self {
        Answer {
            range_m: target.range.to_num(),
            velocity_mps: target.velocity.map_or(f64::NAN, |velocity| velocity.to_num()),
            sigma_range_m: target.sigma_range.into(),
            sigma_velocity_mps: target.sigma_velocity.into(),
            verdict: target.verdict,
        }
    }
}

impl Answer {
    pub(super) fn is_good(&self) -> bool {
        self.verdict == Verdict::Good
    }

    /// Range and velocity.
    pub(super) const fn place(&self) -> [f64; 2] {
        [self.range_m, self.velocity_mps]
    }

    /// The standard deviations of both.
    pub(super) const fn sigmas(&self) -> [f64; 2] {
        [self.sigma_range_m, self.sigma_velocity_mps]
    }

    /// How far range and velocity are from these.
    pub(super) fn off(&self, place: [f64; 2]) -> [f64; 2] {
        [self.range_m - place[0], self.velocity_mps - place[1]]
    }

    /// Whether its distance from this place is less than these metres and metres per second.
    pub(super) fn is_near(&self, place: [f64; 2], near: [f64; 2]) -> bool {
        let [range, velocity] = self.off(place);
        range.abs() < near[0] && velocity.abs() < near[1]
    }
}

/// A measured speed beside the true one, m/s. The keys are those of the JSON lines.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct Speed {
    pub truth_mps: f64,
    pub velocity_mps: f64,
    pub sigma_mps: f64,
    #[serde(serialize_with = "named")]
    pub verdict: Verdict,
}

impl Speed {
    pub(super) fn error(&self) -> f64 {
        self.velocity_mps - self.truth_mps
    }

    pub(super) fn sigmas(&self) -> f64 {
        self.error() / self.sigma_mps
    }

    pub(super) fn is_within(&self) -> bool {
        self.sigmas().abs() <= 5.0
    }
}

/// Whether an answer may be used within its sigma.
pub(super) fn is_usable(verdict: Verdict) -> bool {
    verdict.usable() <= Usable::WithinSigma
}

/// A verdict by its name.
pub(super) fn named<S: Serializer>(verdict: &Verdict, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_str(verdict.name())
}

/// What is drawn over time of ranges and velocities: in the legend, how, in which colour, and where what is when.
pub(super) type Points = (&'static str, Style, usize, Vec<(f64, [f64; 2])>);

/// Two pictures over time: of ranges, and of velocities.
pub(super) fn over_time(
    names: [&'static str; 2],
    title: &str,
    end_s: f64,
    axes: [Axis; 2],
    points: &[Points],
) -> Vec<Chart> {
    let parts = names.into_iter().zip(["range", "velocity"]).zip(axes).enumerate();
    let chart = |(what, ((name, of), y)): (usize, _)| Chart {
        name,
        title: format!("{title}: {of}"),
        x: Axis::linear("time, s", 0.0, end_s),
        y,
        series: points
            .iter()
            .map(|(label, style, colour, points)| {
                let points = points.iter().map(|(time_s, place)| (*time_s, place[what]));
                Series::new(*label, *style, *colour, points)
            })
            .collect(),
    };
    parts.map(chart).collect()
}
