//! The shape of a file of columns, seen from its first lines: what separates columns, where the numbers begin, which column
//! is the time and how fast it runs. Oscilloscopes' files (Tektronix, Rigol, Siglent, Keysight) begin with lines of their own.

use super::times;
use super::unit::{self, Named};

/// What stands between columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Between {
    Byte(char),
    Space,
}

/// A file's shape.
#[derive(Clone, Debug)]
pub(super) struct Shape {
    pub between: Between,
    /// Commas within numbers are decimal.
    pub decimal_comma: bool,
    /// The line, from 0, on which numbers begin.
    pub start: usize,
    /// Columns with numbers, from 0.
    pub columns: Vec<usize>,
    /// Fields of the first line of numbers.
    pub width: usize,
    /// The column of the time, and what is known of it.
    pub time: Option<(usize, Named)>,
    /// The line over the numbers.
    pub names: Vec<String>,
    /// The samples per second that a line above the numbers states.
    pub rate_hz: Option<f64>,
}

/// Why the shape is not clear.
#[derive(Debug, PartialEq)]
pub(super) enum Unclear {
    /// No line has a number.
    Empty,
    /// This line is one number with a decimal comma, or two columns.
    Comma(String),
}

impl Between {
    /// The fields of a line, without the blanks and quotes around them.
    pub fn fields(self, line: &str) -> Vec<&str> {
        let plain = |field: &'_ str| -> bool { !field.is_empty() };
        match self {
            Between::Byte(byte) => {
                line.split(byte).map(|field| field.trim().trim_matches('"').trim()).collect()
            }
            Between::Space => line.split_whitespace().filter(|field| plain(field)).collect(),
        }
    }
}

/// Lines that are not read.
pub(super) fn skipped(line: &str) -> bool {
    let line = line.trim();
    line.is_empty() || line.starts_with(['#', '%'])
}

/// A field as a number: decimal or hexadecimal, behind a name as in A0:512, or a time of the day or since 1970.
pub(super) fn number(field: &str, decimal_comma: bool) -> Option<f64> {
    let plain = |field: &str| match decimal_comma && field.contains(',') {
        true => field.replacen(',', ".", 1).parse().ok(),
        false => field.parse().ok(),
    };
    plain(field).or_else(|| {
        if let Some(digits) = field.strip_prefix("0x").or_else(|| field.strip_prefix("0X")) {
            return u64::from_str_radix(digits, 16).ok().map(|x| x as f64);
        }
        if field.starts_with(|c: char| c.is_ascii_digit()) && field.contains(':') {
            return moment(field);
        }
        let (name, value) = field.split_once([':', '='])?;
        let (name, value) = (name.trim(), value.trim());
        let labels = name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '[');
        (labels && name.len() <= 24).then(|| plain(value))?
    })
}

/// Seconds of a time of the day, 12:34:56.789, or of a date and a time, 2026-11-28T12:34:56.789.
fn moment(field: &str) -> Option<f64> {
    let (date, time) = match field.split_once(['T', ' ']) {
        Some((date, time)) => (Some(date), time.trim_end_matches('Z')),
        None => (None, field),
    };
    let mut parts = time.splitn(3, ':');
    let two = |part: Option<&str>| part?.parse::<u32>().ok().filter(|&x| x < 60);
    let (hours, minutes) = (two(parts.next())?, two(parts.next())?);
    let seconds: f64 = parts.next()?.replace(',', ".").parse().ok()?;
    let day = match date {
        None => 0,
        Some(date) => {
            let mut parts = date.splitn(3, ['-', '/']).map(|part| part.parse::<i64>().ok());
            let (year, month, day) = (parts.next()??, parts.next()??, parts.next()??);
            days(year, month, day)?
        }
    };
    Some(86_400.0 * day as f64 + 3600.0 * f64::from(hours) + 60.0 * f64::from(minutes) + seconds)
}

/// Days since 1970 in the Gregorian calendar (Hinnant, "chrono-compatible low-level date algorithms").
fn days(year: i64, month: i64, day: i64) -> Option<i64> {
    if !((1900..3000).contains(&year) && (1..=12).contains(&month) && (1..=31).contains(&day)) {
        return None;
    }
    let year = if month <= 2 { year - 1 } else { year };
    let (era, of_era) = (year.div_euclid(400), year.rem_euclid(400));
    let of_year = (153 * (month + if month > 2 { -3 } else { 9 }) + 2) / 5 + day - 1;
    Some(era * 146_097 + of_era * 365 + of_era / 4 - of_era / 100 + of_year - 719_468)
}

/// The shape of a file that begins with these lines.
pub(super) fn shape(lines: &[&str], decimal_comma: bool, chosen: bool) -> Result<Shape, Unclear> {
    let told: Vec<(usize, &str)> =
        (0..).zip(lines.iter().copied()).filter(|(_, line)| !skipped(line)).collect();
    let sample = |byte| told.iter().rev().take(20).any(|(_, line)| line.contains(byte));
    let (between, decimal_comma) = match () {
        () if sample(';') => (Between::Byte(';'), true),
        () if sample('\t') => (Between::Byte('\t'), true),
        () if decimal_comma => (Between::Space, true),
        () if sample(',') => (Between::Byte(','), false),
        () => (Between::Space, false),
    };
    let rows: Vec<(usize, Vec<usize>, Vec<&str>)> = told
        .iter()
        .map(|&(line, text)| {
            let fields = between.fields(text);
            let numeric = |at: &usize| number(fields[*at], decimal_comma).is_some();
            (line, (0..fields.len()).filter(numeric).collect(), fields)
        })
        .collect();
    let mut counts: Vec<(&Vec<usize>, usize)> = Vec::new();
    for (_, columns, _) in rows.iter().filter(|(_, columns, _)| !columns.is_empty()) {
        match counts.iter_mut().find(|(known, _)| *known == columns) {
            Some((_, count)) => *count += 1,
            None => counts.push((columns, 1)),
        }
    }
    // The most frequent; of equals the first.
    let most = counts.iter().map(|(_, count)| *count).max().unwrap_or(0);
    let columns = counts.iter().find(|(_, count)| *count == most).map(|(columns, _)| *columns);
    let columns = columns.ok_or(Unclear::Empty)?.clone();
    let holds = |row: &(usize, Vec<usize>, Vec<&str>)| columns.iter().all(|c| row.1.contains(c));
    let start = (0..rows.len())
        .find(|&at| holds(&rows[at]) && rows.get(at + 1).is_none_or(holds))
        .or_else(|| rows.iter().position(holds))
        .unwrap_or(0);
    let data: Vec<&Vec<&str>> =
        rows[start..].iter().filter(|row| holds(row)).map(|(.., fields)| fields).collect();
    let names: Vec<String> = start
        .checked_sub(1)
        .map_or(vec![], |above| rows[above].2.iter().map(|&name| name.to_owned()).collect());
    if between == Between::Byte(',') && !chosen && names.len() != 2 && either(&data) {
        return Err(Unclear::Comma(data[0].join(",")));
    }
    let head: Vec<&[&str]> = rows[..start].iter().map(|(.., fields)| fields.as_slice()).collect();
    let all: Vec<&Vec<&str>> = rows[start..].iter().map(|(.., fields)| fields).collect();
    let width = rows[start].2.len();
    let rate_hz = lines[..rows[start].0].iter().find_map(|line| stated_rate(line));
    let time = time(&columns, &all, &head, decimal_comma).map(|column| {
        let names = head.iter().rev().take(3).filter_map(|fields| fields.get(column));
        let names = names.filter(|name| number(name, decimal_comma).is_none());
        let names = names.map(|&name| name.to_owned()).collect();
        let number = (column + 1).to_string();
        (column, Named { column: number, names, step: stated(&head), rate_hz })
    });
    Ok(Shape { between, decimal_comma, start: rows[start].0, columns, width, time, names, rate_hz })
}

/// True where every line is digits, a comma and digits: as good one number as two.
fn either(data: &[&Vec<&str>]) -> bool {
    let digits = |field: &str| !field.is_empty() && field.bytes().all(|byte| byte.is_ascii_digit());
    data.len() > 2
        && data.iter().all(|fields| {
            let [first, second] = fields[..] else { return false };
            digits(first.trim_start_matches(['-', '+'])) && digits(second)
        })
        // Numbers of one kind have one number of digits behind the comma, and a small one before it.
        && data.iter().all(|fields| fields[1].len() == data[0][1].len())
}

/// The samples per second that a line states: "Sample Rate: 44100 Hz", as Audacity writes it, or "# fs = 48 kHz".
fn stated_rate(line: &str) -> Option<f64> {
    let line = line.to_ascii_lowercase();
    let names = [
        "sample rate",
        "sampling rate",
        "sampling frequency",
        "sample frequency",
        "samplerate",
        "sample_rate",
        "fs",
    ];
    let (name, at) = names.iter().find_map(|name| Some((name, line.find(name)?)))?;
    // A word of its own.
    let before = line[..at].chars().next_back();
    let rest = line[at + name.len()..].trim_start_matches([':', '=', ' ', '\t', ',', ';', '"']);
    if before.is_some_and(char::is_alphanumeric)
        || line[at + name.len()..].starts_with(char::is_alphanumeric)
    {
        return None;
    }
    let end =
        rest.find(|c: char| !(c.is_ascii_digit() || "+-.e".contains(c))).unwrap_or(rest.len());
    let number: f64 = rest[..end].parse().ok()?;
    let unit = rest[end..].trim_start();
    let factor = match () {
        () if unit.starts_with('k') => 1e3,
        () if unit.starts_with("mhz") || unit.starts_with("ms/s") || unit.starts_with("msa") => 1e6,
        () if unit.starts_with("ghz") || unit.starts_with("gs") => 1e9,
        () => 1.0,
    };
    let rate = number * factor;
    (rate > 0.0 && rate.is_finite()).then_some(rate)
}

/// True for what a program writes that has no number: nothing, or a word for it.
pub(super) fn says_nothing(field: &str) -> bool {
    let words = [
        "",
        "-",
        "--",
        "---",
        "na",
        "n/a",
        "null",
        "none",
        "nan",
        "inf",
        "-inf",
        "+inf",
        "\u{221e}",
        "-\u{221e}",
        "overflow",
        "#n/a",
        "(null)",
        "-nan",
        "-nan(ind)",
        "1.#qnan",
        "1.#inf",
        "-1.#ind",
    ];
    let field = field.trim_start_matches('[').trim_end_matches(']').to_ascii_lowercase();
    words.contains(&field.as_str())
}

/// Rows from which on a column that rises in each is the time, however unevenly.
const RISES: usize = 64;

/// The column of the time: by its name, else a first column that rises evenly, or long enough, or such a last one.
fn time(
    columns: &[usize],
    data: &[&Vec<&str>],
    head: &[&[&str]],
    decimal_comma: bool,
) -> Option<usize> {
    let (&[first, _, ..], &[.., last]) = (columns, columns) else { return None };
    let names = |column: usize| -> Vec<String> {
        let names = head.iter().rev().take(3).filter_map(|fields| fields.get(column));
        names.map(|&name| name.to_owned()).collect()
    };
    // A line without a number takes its time, too.
    let times = |column: usize| -> Vec<f64> {
        let time =
            |fields: &&Vec<&str>| fields.get(column).and_then(|it| number(it, decimal_comma));
        data.iter().map(|fields| time(fields).unwrap_or(f64::NAN)).collect()
    };
    let named = |column: &usize| Named { names: names(*column), ..Named::default() };
    let said = columns.iter().find(|column| named(column).timely());
    let rises = |column: usize| {
        let times: Vec<f64> = times(column).into_iter().filter(|time| time.is_finite()).collect();
        times::is_even(&times)
            || times.len() >= RISES
                && times.windows(2).all(|pair| pair[1] >= pair[0])
                && times.first() < times.last()
                && times.windows(2).filter(|pair| pair[1] > pair[0]).count() * 64 > times.len()
    };
    let told = said.copied().filter(|&column| {
        // A letter may be anything's name.
        names(column).iter().any(|name| name.trim().len() > 2) || rises(column)
    });
    let unnamed = |column: &usize| {
        names(*column).iter().all(|name| !unit::has_letters(name)) || *column == first
    };
    told.or_else(|| [first, last].into_iter().find(|column| unnamed(column) && rises(*column)))
}

/// The seconds from sample to sample that a header states, beside their name or below it.
fn stated(head: &[&[&str]]) -> Option<f64> {
    let names =
        ["sample interval", "increment", "xincr", "tinc", "time increment", "sampling period"];
    head.iter().enumerate().find_map(|(row, fields)| {
        let at = fields.iter().position(|field| {
            let field = field.to_ascii_lowercase();
            names.iter().any(|name| field.starts_with(name))
        })?;
        let beside =
            fields.get(at + 1).and_then(|field| number(field.split(':').next_back()?, false));
        let below = || head.get(row + 1)?.get(at).and_then(|field| number(field, false));
        beside.or_else(below).filter(|seconds| *seconds > 0.0)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The column of the time, and its rate.
    fn timed(shape: &Shape, time: impl Fn(f64) -> f64) -> (usize, Option<f64>) {
        let (column, named) = shape.time.as_ref().unwrap();
        let times: Vec<f64> = (0..40).map(|n| time(f64::from(n))).collect();
        let timing = times::timing(&times, named, None).unwrap();
        (*column, timing.clock.map(|clock| clock.rate_hz))
    }

    /// A file that begins with `head` and goes on with these lines.
    fn of(head: &str, line: impl Fn(f64) -> String) -> Result<Shape, Unclear> {
        let lines: Vec<String> =
            head.lines().map(str::to_owned).chain((0..40).map(|n| line(f64::from(n)))).collect();
        shape(&lines.iter().map(String::as_str).collect::<Vec<_>>(), false, false)
    }

    #[test]
    fn oscilloscopes() {
        let volts = |n: f64| 0.01 * (0.7 * n).sin();
        let tektronix = "Record Length,2.500000e+03,,-5.0e-04,0.0100,\nSample Interval,4.000000e-07,,-4.996e-04,0.0120,\n";
        let shape =
            of(tektronix, |n| format!(",,,{:.4e},{:.4},", -4.992e-4 + 4e-7 * n, volts(n))).unwrap();
        assert_eq!(shape.columns, [3, 4]);
        let (column, rate) = timed(&shape, |n| -4.992e-4 + 4e-7 * n);
        assert!(column == 3 && (rate.unwrap() - 2.5e6).abs() < 1e-3, "{rate:?}");
        let newer = "Model,DPO4034B\nHorizontal Scale,4e-06\nHorizontal Delay,0\nSample Interval,4e-10\nRecord Length,100000\n\nLabel,,\nTIME,CH1,CH2\n";
        let shape =
            of(newer, |n| format!("{:.5e},{:.3},{:.3}", 4e-10 * n, volts(n), volts(n))).unwrap();
        assert_eq!(timed(&shape, |n| 4e-10 * n), (0, Some(2.5e9)));
        assert_eq!(shape.columns, [0, 1, 2]);
        assert_eq!(shape.start, 8);
        let rigol = "X,CH1,Start,Increment,\nSequence,Volt,-3.000000e-03,5.000000e-06,\n";
        let shape = of(rigol, |n| format!("{n},{:.3},,", volts(n))).unwrap();
        assert_eq!((shape.start, timed(&shape, |n| n)), (2, (0, Some(2e5))));
        let siglent = "Record Length,Analog:10000\nSample Interval,Analog:2.00E-08\nVertical Units,CH1:V\nSource,CH1\nSecond,Volt\n";
        let shape = of(siglent, |n| format!("{:.10},{:.5}", 2e-8 * n, volts(n))).unwrap();
        assert_eq!((shape.start, timed(&shape, |n| 2e-8 * n)), (5, (0, Some(5e7))));
        let keysight = "x-axis,1\nsecond,Volt\n";
        let shape =
            of(keysight, |n| format!("{:+.8E},{:+.5E}", 1e-6 * n - 1e-3, volts(n))).unwrap();
        assert_eq!(timed(&shape, |n| 1e-6 * n - 1e-3), (0, Some(1e6)));
        let pico = "Time,Channel A\n(ms),(mV)\n\n";
        let shape = of(pico, |n| format!("{:.5},{:.5}", 0.01 * n, volts(n))).unwrap();
        assert_eq!(timed(&shape, |n| 0.01 * n), (0, Some(1e5)));
    }

    #[test]
    fn commas() {
        let german = of("Zeit;Spannung\n", |n| {
            format!("{:.4};{:.4}", 0.001 * n, 1.5 * n % 7.0).replace('.', ",")
        })
        .unwrap();
        assert!(german.decimal_comma);
        assert_eq!(timed(&german, |n| 0.001 * n), (0, Some(1e3)));
        let either = of("", |n| format!("{},{:03}", n % 5.0, 7.0 * n % 1000.0));
        assert_eq!(either.unwrap_err(), Unclear::Comma("0,000".into()));
        let iq = of("", |n| format!("{},{}", n % 5.0, 3.0 - n % 7.0)).unwrap();
        assert_eq!((iq.columns, iq.time), (vec![0, 1], None));
        assert_eq!(of("one\ntwo\n", |_| "three".into()).unwrap_err(), Unclear::Empty);
    }
}
