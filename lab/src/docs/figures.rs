//! Figures that tests hold: `host-tests/budget.json`, what may be spent on emulated cores, within 1 %, and `host-tests/figures.json`, what
//! boards, programs and campaigns were measured to take, within 2 %.

use crate::toolchain::workspace;
use serde_json::Value;

pub(super) fn read(name: &str) -> Result<Value, String> {
    let path = workspace().join("host-tests").join(name);
    let text = std::fs::read_to_string(&path).map_err(|error| format!("{name}: {error}"))?;
    serde_json::from_str(&text).map_err(|error| format!("{name}: {error}"))
}

/// `budget.json`.
pub(super) struct Budget(Value);

impl Budget {
    pub(super) fn read() -> Result<Self, String> {
        read("budget.json").map(Self)
    }

    /// The number at a path, as `/locked/zoom`.
    pub(super) fn at(&self, path: &str) -> Result<f64, String> {
        let figure = self.0.pointer(path).and_then(Value::as_f64);
        figure.ok_or_else(|| format!("budget.json has no {path}"))
    }
}

/// The figures of this name in `figures.json`.
pub(super) fn measured<const COUNT: usize>(name: &str) -> Result<[f64; COUNT], String> {
    let all = read("figures.json")?;
    let figures = all[name].as_array();
    let figures: Vec<f64> = figures.into_iter().flatten().filter_map(Value::as_f64).collect();
    let wrong = |_| format!("figures.json has not {COUNT} figures of the name {name}");
    figures.try_into().map_err(wrong)
}

/// A number with commas between its thousands.
pub(super) fn whole(figure: f64) -> String {
    let digits = format!("{:.0}", figure.abs());
    let mut text = if figure < -0.5 { "-".to_owned() } else { String::new() };
    for (at, digit) in digits.chars().enumerate() {
        if at > 0 && (digits.len() - at).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// A count of instructions, cycles or the like: to tens, from 10,000 on to hundreds.
pub(super) fn rounded(figure: f64) -> String {
    let unit = if figure < 10_000.0 { 10.0 } else { 100.0 };
    whole((figure / unit).round() * unit)
}

/// A table's row.
pub(super) fn row(cells: impl IntoIterator<Item = String>) -> String {
    let cells: Vec<String> = cells.into_iter().collect();
    // An empty cell has one space.
    format!("| {} |", cells.join(" | ")).replace("|  |", "| |").replace("|  |", "| |")
}

/// A table's head, and the line below it.
pub(super) fn head(cells: &str) -> Vec<String> {
    let count = cells.matches('|').count() - 1;
    vec![cells.to_owned(), format!("|{}", "---|".repeat(count))]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_commas() {
        assert_eq!(
            ["0", "-5", "999", "1,000", "12,345,678"].map(str::to_owned),
            [0.0, -5.0, 999.0, 1e3, 12_345_678.0].map(whole)
        );
        assert_eq!([6404.0, 33_507.0].map(rounded), ["6,400", "33,500"]);
        assert_eq!(row(["a".into(), String::new(), String::new()]), "| a | | |");
    }
}
