//! The unit of a column of times: by its name, else by which rates are plausible.

/// What is known of a column beside its numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Named {
    /// Its number, from 1, or its name in a file of arrays.
    pub column: String,
    /// Its names, one over the other, the nearest to the numbers first.
    pub names: Vec<String>,
    /// The seconds from row to row that the header states.
    pub step: Option<f64>,
    /// The samples per second that the file states.
    pub rate_hz: Option<f64>,
}

/// What a column means.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Meaning {
    /// Times, with the seconds in one of their units.
    Seconds { of_one: f64, note: String },
    /// The header's step holds.
    Step { seconds: f64, note: String },
    /// Only the user knows.
    Unknown { note: String },
}

/// Units by the words for them.
const UNITS: [(f64, &str, &[&str]); 7] = [
    (1e-3, "milliseconds", &["ms", "msec", "msecs", "millis", "millisecond", "milliseconds"]),
    (
        1e-6,
        "microseconds",
        &["us", "µs", "μs", "usec", "usecs", "micros", "microsecond", "microseconds"],
    ),
    (1e-9, "nanoseconds", &["ns", "nsec", "nanos", "nanosecond", "nanoseconds"]),
    (1e-12, "picoseconds", &["ps"]),
    (1.0, "seconds", &["s", "sec", "secs", "second", "seconds", "sekunden"]),
    (60.0, "minutes", &["min", "minute", "minutes"]),
    (3600.0, "hours", &["h", "hour", "hours"]),
];
/// Words for a time without a unit.
const TIMES: [&str; 9] =
    ["time", "zeit", "temps", "timestamp", "t", "x-axis", "epoch", "datetime", "clock"];
/// Common rates of loggers, Hz.
const PLAUSIBLE: std::ops::RangeInclusive<f64> = 5.0..=250e3;

/// The words of a name.
fn words(name: &str) -> Vec<String> {
    let name = name.to_lowercase();
    name.split(|c: char| !(c.is_alphanumeric() || c == '-'))
        .filter(|word| !word.is_empty())
        .map(str::to_owned)
        .collect()
}

/// The unit in a name, with its seconds: its last word, or a time's that is one word with it, as timeMs.
fn unit(name: &str) -> Option<(f64, &'static str)> {
    let words = words(name);
    let of =
        |word: &str| UNITS.iter().find(|unit| unit.2.contains(&word)).map(|unit| (unit.0, unit.1));
    let joined = |word: &String| {
        let rest = TIMES.iter().find_map(|time| word.strip_prefix(time).filter(|_| time.len() > 1));
        rest.and_then(of)
    };
    words.iter().rev().find_map(|word| of(word)).or_else(|| words.iter().find_map(joined))
}

/// Whether a name alone says that a column is the time: a word for it, or a unit of time as all there is.
fn timely(name: &str) -> bool {
    let words = words(name);
    let begins = |word: &String| {
        TIMES.iter().any(|time| word == time || time.len() > 3 && word.starts_with(time))
    };
    words.iter().any(begins) || words.len() == 1 && unit(name).is_some()
}

/// Whether a field of a header says anything.
pub(super) fn has_letters(name: &str) -> bool {
    name.chars().any(char::is_alphabetic)
}

impl Named {
    /// Whether its name says that it is the time.
    pub fn timely(&self) -> bool {
        self.names.iter().any(|name| timely(name))
    }

    fn unit(&self) -> Option<(f64, &'static str)> {
        let found = self.names.iter().find_map(|name| unit(name));
        // A unit beside no word for a time is a time's if it is all of a name.
        found.filter(|_| self.timely())
    }

    /// How it is called in a sentence.
    fn called(&self) -> String {
        match self.names.iter().rfind(|name| !name.is_empty()) {
            Some(name) => format!("column {} ({name})", self.column),
            None => format!("column {}", self.column),
        }
    }
}

/// The meaning of a column whose numbers rise by `step`, from `first` on, in multiples of `quantum`.
pub(super) fn meaning(
    named: &Named,
    step: f64,
    first: f64,
    quantum: f64,
    numbered: bool,
) -> Meaning {
    let called = named.called();
    let seconds = |of_one: f64, note: String| Meaning::Seconds { of_one, note };
    if let Some(stated) = named.step {
        let near = |unit: f64| ((stated - step * unit) / stated).abs() < 0.01;
        let own = named.unit().map_or(1.0, |unit| unit.0);
        if near(own) || near(1.0) || numbered && named.unit().is_none() {
            return Meaning::Step { seconds: stated, note: String::new() };
        }
    }
    if let Some((of_one, unit)) = named.unit() {
        return seconds(of_one, format!("{called} is the time in {unit}, by its name"));
    }
    if let Some(rate) = named.rate_hz {
        return Meaning::Step { seconds: 1.0 / rate, note: String::new() };
    }
    // No rows are numbered from the milliseconds since 1970 on.
    if numbered && !named.timely() && !(1e12..4.1e12).contains(&first) {
        return Meaning::Unknown { note: format!("{called} numbers the rows") };
    }
    // Since 1970: between 2001 and 2100.
    for (of_one, unit) in
        [(1.0, "seconds"), (1e-3, "milliseconds"), (1e-6, "microseconds"), (1e-9, "nanoseconds")]
    {
        if (1e9..4.1e9).contains(&(first * of_one)) && first >= 1e9 {
            // A counter of microseconds has such numbers, too.
            let other = 1.0 / step;
            if of_one < 1.0 || other < 1e6 && (step < 0.5 || quantum < 1.0) {
                return seconds(of_one, format!("{called} is taken as {unit} since 1970"));
            }
        }
    }
    let rates =
        [(1.0, "seconds"), (1e-3, "milliseconds"), (1e-6, "microseconds"), (1e-9, "nanoseconds")];
    let fitting = |unit: &&(f64, &str)| PLAUSIBLE.contains(&(1.0 / (step * unit.0)));
    if quantum < 1.0 && 1.0 / step >= *PLAUSIBLE.start() {
        return seconds(1.0, format!("{called} is taken as seconds"));
    }
    let possible: Vec<&(f64, &str)> = rates.iter().filter(fitting).collect();
    match possible[..] {
        [&(of_one, unit)] => seconds(of_one, format!("{called} is taken as {unit}")),
        _ => {
            let some = if possible.is_empty() { rates.iter().take(3).collect() } else { possible };
            let each: Vec<String> = some
                .iter()
                .map(|(of_one, unit)| {
                    let rate: f64 = format!("{:.5e}", 1.0 / (step * of_one)).parse().unwrap_or(0.0);
                    format!("--rate {rate} for {unit}")
                })
                .collect();
            Meaning::Unknown {
                note: format!("{called} is a time without a unit: add {}", each.join(", ")),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_rates_tell_units() {
        let of = |names: &[&str], step: f64, first: f64, quantum: f64| {
            let names = names.iter().map(|name| (*name).to_owned()).collect();
            let named = Named { column: "1".into(), names, ..Named::default() };
            match meaning(&named, step, first, quantum, step == 1.0) {
                Meaning::Seconds { of_one, note } => (of_one, note.contains("taken")),
                _ => (0.0, false),
            }
        };
        for (name, seconds) in [
            ("Time(ms)", 1e-3),
            ("time_ms", 1e-3),
            ("millis", 1e-3),
            ("micros", 1e-6),
            ("microseconds", 1e-6),
            ("Time (usec)", 1e-6),
            ("Time [µs]", 1e-6),
            ("timestamp_us", 1e-6),
            ("Time (s)", 1.0),
            ("seconds", 1.0),
        ] {
            assert_eq!(of(&[name], 20.0, 0.0, 1.0), (seconds, false), "{name}");
        }
        assert_eq!(of(&["(ms)", "Time"], 0.01, 0.0, 0.01), (1e-3, false));
        assert_eq!(of(&["time"], 0.001, 0.0, 0.001), (1.0, true));
        assert_eq!(of(&["timestamp"], 1000.3, 37_012.0, 4.0), (1e-6, true));
        assert_eq!(of(&["timestamp"], 1.0004, 123_456.0, 1.0), (1e-3, true));
        assert_eq!(of(&["timestamp"], 1.0, 1.7e12, 1.0), (1e-3, true));
        assert_eq!(of(&["ts"], 1.0, 1.7e12, 1.0), (1e-3, true));
        assert_eq!(of(&["n"], 1.0, 0.0, 1.0), (0.0, false));
        assert_eq!(of(&["time"], 0.01, 1.7e9, 0.01), (1.0, true));
        // Ten milliseconds, or ten microseconds.
        assert_eq!(of(&["time"], 10.0, 0.0, 10.0), (0.0, false));
        assert_eq!(of(&[], 1.0, 0.0, 1.0), (0.0, false));
    }
}
