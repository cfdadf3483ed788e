//! What differs between the lines that a page has and those that were measured.

/// Another release of the compiler may order instructions otherwise: so far a figure may be off.
const MARGIN: f64 = 0.02;

/// A line's words, and its numbers with the unit of their last digit.
#[derive(Debug, PartialEq)]
struct Line {
    /// With a sign for each number, and one space in the place of many.
    words: String,
    numbers: Vec<(f64, f64)>,
}

impl Line {
    fn new(text: &str) -> Self {
        let spaced: Vec<&str> = text.split_whitespace().collect();
        let spaced = spaced.join(" ");
        let (mut words, mut numbers, mut rest) = (String::new(), Vec::new(), spaced.as_str());
        let mut in_word = false;
        while let Some(first) = rest.chars().next() {
            let length =
                rest.find(|c: char| !matches!(c, '0'..='9' | ',' | '.')).unwrap_or(rest.len());
            let digits = rest[..length].trim_end_matches([',', '.']);
            let figure = digits.replace(',', "");
            // A digit in a name, as of `i32`, belongs to it.
            match figure.parse::<f64>() {
                Ok(number) if !in_word => {
                    let decimals = figure.split_once('.').map_or(0, |(_, decimals)| decimals.len());
                    numbers.push((number, 10f64.powi(-(decimals as i32))));
                    words.push('#');
                    rest = &rest[digits.len()..];
                }
                _ => {
                    words.push(first);
                    in_word = first.is_alphanumeric() || first == '_';
                    rest = &rest[first.len_utf8()..];
                }
            }
        }
        Self { words, numbers }
    }

    fn is_near(&self, measured: &Line) -> bool {
        let near = |(stated, measured): (&(f64, f64), &(f64, f64))| {
            let unit = stated.1.max(measured.1);
            (stated.0 - measured.0).abs() <= (MARGIN * measured.0.abs()).max(1.001 * unit)
        };
        self.words == measured.words && self.numbers.iter().zip(&measured.numbers).all(near)
    }
}

/// Each line that differs by its words, or by a number that is off by more than 2 % and more than a unit of its last digit.
pub(super) fn differences(stated: &[&str], measured: &[String]) -> Vec<String> {
    let longest = stated.len().max(measured.len());
    let each = (0..longest).filter_map(|at| {
        let (stated, measured) = (stated.get(at), measured.get(at));
        match (stated, measured) {
            (Some(stated), Some(measured)) => {
                let near = Line::new(stated).is_near(&Line::new(measured));
                (!near).then(|| format!("\n- {stated}\n+ {measured}"))
            }
            (Some(stated), None) => Some(format!("\n- {stated}")),
            (None, measured) => measured.map(|measured| format!("\n+ {measured}")),
        }
    });
    each.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn same(stated: &str, measured: &str) -> bool {
        differences(&[stated], &[measured.to_owned()]).is_empty()
    }

    #[test]
    fn numbers_may_be_off_by_their_last_digit_and_words_by_nothing() {
        assert!(same("| a  | 1,000 |", "| a | 1,019 |") && !same("| a | 1,000 |", "| a | 1,021 |"));
        assert!(same("0.04 %", "0.05 %") && !same("0.04 %", "0.06 %"));
        assert!(same("rms 1, good", "rms 1, good") && !same("rms 1, good", "rms 1, weak"));
        assert!(!same("-5.0", "5.0") && !same("i32 4", "i64 4") && !same("a", ""));
        assert_eq!(differences(&[], &["a".into()]).len(), 1);
        assert_eq!(differences(&["a"], &[]).len(), 1);
        assert_eq!(Line::new("1,234.50 Hz, N4").numbers, [(1234.5, 0.01)]);
    }
}
