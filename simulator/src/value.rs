//! A number of a scene: fixed, drawn again for each run, or changing with time.

use crate::draw::Draw;
use core::fmt;
use serde::de::{Deserialize, Deserializer, Error, MapAccess, SeqAccess, Visitor, value};
use serde::{Deserialize as Derived, Serialize};

/// A number of a scene. In JSON `3.5`, `[2, 5]` for any number between two, `{"either": [-1, 1]}` for one of a list, or
/// `[[0, 20], [2, 20], [6, 0]]` for the times in seconds and the values at them: straight lines between, and constant before and after.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Value {
    /// Always the same.
    Fixed(f64),
    /// Any number between two, drawn for each run.
    Between([f64; 2]),
    /// One of these, drawn for each run.
    Either {
        /// The choice.
        either: Vec<f64>,
    },
    /// Times and the values at them; where the field says that it may change with time.
    Over(Vec<[f64; 2]>),
}

impl Default for Value {
    fn default() -> Self {
        Value::Fixed(0.0)
    }
}

/// A list in JSON: of numbers, or of pairs.
#[derive(Derived)]
#[serde(untagged)]
enum Part {
    Number(f64),
    Pair([f64; 2]),
}

/// The choice in JSON.
#[derive(Derived)]
#[serde(deny_unknown_fields)]
struct Choice {
    either: Vec<f64>,
}

impl<'de> Deserialize<'de> for Value {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        from.deserialize_any(Reader)
    }
}

struct Reader;

impl<'de> Visitor<'de> for Reader {
    type Value = Value;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a number, [low, high], {\"either\": [...]} or [[seconds, value], ...]")
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Value, E> {
        Ok(Value::Fixed(value))
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<Value, E> {
        Ok(Value::Fixed(value as f64))
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<Value, E> {
        Ok(Value::Fixed(value as f64))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Value, A::Error> {
        let (mut numbers, mut pairs) = (Vec::new(), Vec::new());
        let wrong = |_| A::Error::custom("give [low, high] or [[seconds, value], ...]");
        while let Some(part) = list.next_element().map_err(wrong)? {
            match part {
                Part::Number(number) => numbers.push(number),
                Part::Pair(pair) => pairs.push(pair),
            }
        }
        match (&numbers[..], pairs.is_empty()) {
            (&[low, high], true) => Ok(Value::Between([low, high])),
            ([], false) => Ok(Value::Over(pairs)),
            _ => Err(A::Error::custom("give [low, high] or [[seconds, value], ...]")),
        }
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Value, A::Error> {
        let Choice { either } = Derived::deserialize(value::MapAccessDeserializer::new(map))?;
        Ok(Value::Either { either })
    }
}

impl From<f64> for Value {
    fn from(value: f64) -> Self {
        Value::Fixed(value)
    }
}

/// Times and the values at them.
impl From<Vec<[f64; 2]>> for Value {
    fn from(course: Vec<[f64; 2]>) -> Self {
        Value::Over(course)
    }
}

impl From<core::ops::Range<f64>> for Value {
    fn from(range: core::ops::Range<f64>) -> Self {
        Value::Between([range.start, range.end])
    }
}

impl<const N: usize> From<[f64; N]> for Value {
    fn from(either: [f64; N]) -> Self {
        Value::Either { either: either.to_vec() }
    }
}

impl Value {
    /// Values that change at once at whole numbers of seconds, from 0 on.
    pub fn steps(values: impl IntoIterator<Item = f64>) -> Self {
        let step = |(index, value): (usize, f64)| {
            let from = index as f64;
            [[from, value], [from + (1.0 - 1e-9), value]]
        };
        Value::Over(values.into_iter().enumerate().flat_map(step).collect())
    }

    /// Both signs of a number.
    pub fn either_way(value: f64) -> Self {
        [-value, value].into()
    }

    /// The number of a run. What changes with time has the value of its start.
    pub(crate) fn draw(&self, draw: &mut Draw) -> f64 {
        match self {
            Value::Fixed(value) => *value,
            Value::Between([low, high]) => low + (high - low) * draw.share(),
            Value::Either { either } => {
                let place = (draw.share() * either.len() as f64) as usize;
                either.get(place).copied().unwrap_or(0.0)
            }
            Value::Over(points) => points.first().map_or(0.0, |point| point[1]),
        }
    }

    /// The number of a run; where it is not said, any number of turns.
    pub(crate) fn or_any(value: Option<&Self>, draw: &mut Draw) -> f64 {
        match value {
            Some(value) => value.draw(draw),
            None => draw.share(),
        }
    }

    /// The course of a run.
    pub(crate) fn course(&self, draw: &mut Draw) -> Course {
        Course::new(match self {
            Value::Over(points) => points.clone(),
            _ => vec![[0.0, self.draw(draw)]],
        })
    }

    /// The largest magnitude that it may have.
    pub(crate) fn most(&self) -> f64 {
        let most = |values: &[f64]| values.iter().map(|x| x.abs()).fold(0.0, f64::max);
        match self {
            Value::Fixed(value) => value.abs(),
            Value::Between(ends) => most(ends),
            Value::Either { either } => most(either),
            Value::Over(points) => points.iter().map(|point| point[1].abs()).fold(0.0, f64::max),
        }
    }

    /// Why it is no number of this kind.
    pub(crate) fn check(
        &self,
        name: &str,
        over_time: bool,
        range: (f64, f64),
    ) -> Result<(), String> {
        let fits = |x: &f64| x.is_finite() && (range.0..=range.1).contains(x);
        let good = match self {
            Value::Fixed(value) => fits(value),
            Value::Between(ends) => ends.iter().all(fits) && ends[0] <= ends[1],
            Value::Either { either } => !either.is_empty() && either.iter().all(fits),
            Value::Over(_) if !over_time => {
                return Err(format!("{name} does not change with time: give one number"));
            }
            Value::Over(points) => {
                let rising = points.windows(2).all(|pair| pair[0][0] < pair[1][0]);
                if !rising {
                    return Err(format!("{name}: the times do not rise"));
                }
                !points.is_empty()
                    && points.iter().all(|[time, value]| time.is_finite() && fits(value))
            }
        };
        let (low, high) = range;
        good.then_some(()).ok_or_else(|| match (low.is_finite(), high.is_finite()) {
            (true, true) => format!("{name}: give a number from {low} to {high}"),
            (true, false) => format!("{name}: give a number of {low} or more"),
            _ => format!("{name}: give a number"),
        })
    }
}

/// A number over time: straight lines between points.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Course {
    points: Vec<[f64; 2]>,
    /// The integral from the first point to each.
    sums: Vec<f64>,
}

impl Course {
    fn new(points: Vec<[f64; 2]>) -> Self {
        let mut sums = vec![0.0];
        for pair in points.windows(2) {
            let [[from, low], [to, high]] = [pair[0], pair[1]];
            let span = to - from;
            let sum = sums.last().copied().unwrap_or(0.0);
            sums.push(sum + span * (low + 0.5 * (high - low) * span / (to - from)));
        }
        Course { points, sums }
    }

    /// The points before and after a time.
    fn around(&self, time_s: f64) -> (usize, Option<[f64; 2]>, Option<[f64; 2]>) {
        let after = self.points.partition_point(|point| point[0] <= time_s);
        let before = after.checked_sub(1).and_then(|place| self.points.get(place));
        (after, before.copied(), self.points.get(after).copied())
    }

    /// The value at a time.
    pub fn at(&self, time_s: f64) -> f64 {
        match self.around(time_s) {
            (_, Some([from, low]), Some([to, high])) => {
                low + (high - low) * (time_s - from) / (to - from)
            }
            (_, Some([_, value]), None) | (_, None, Some([_, value])) => value,
            (_, None, None) => 0.0,
        }
    }

    /// The integral from 0 to a time.
    pub fn integral(&self, time_s: f64) -> f64 {
        if let [[_, value]] = self.points[..] {
            return value * time_s;
        }
        self.since_first(time_s) - self.since_first(0.0)
    }

    /// The integral from the first point to a time.
    fn since_first(&self, time_s: f64) -> f64 {
        match self.around(time_s) {
            (after, Some([from, low]), next) => {
                let (span, sum) = (time_s - from, self.sums.get(after - 1).copied().unwrap_or(0.0));
                let rise = next.map_or(0.0, |[to, high]| (high - low) * span / (to - from));
                sum + span * (low + 0.5 * rise)
            }
            (_, None, Some([first, value])) => value * (time_s - first),
            (_, None, None) => 0.0,
        }
    }

    /// The same course, raised by this.
    pub fn raised(mut self, by: f64) -> Self {
        self.points.iter_mut().for_each(|point| point[1] += by);
        Self::new(self.points)
    }

    /// Whether it does not change.
    pub fn is_steady(&self) -> bool {
        self.points.len() < 2
    }

    /// The largest magnitude.
    pub fn most(&self) -> f64 {
        self.points.iter().map(|point| point[1].abs()).fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The integral is the sum of the values over small steps.
    #[test]
    fn a_course_and_its_integral() {
        let course = Course::new(vec![[1.0, 20.0], [2.0, 20.0], [6.0, -4.0]]);
        assert_eq!([0.0, 1.5, 4.0, 9.0].map(|t| course.at(t)), [20.0, 20.0, 8.0, -4.0]);
        for time in [-2.0, 0.5, 1.7, 3.0, 8.0] {
            let steps = 10_000;
            let step = time / f64::from(steps);
            let sum: f64 = (0..steps).map(|i| step * course.at(step * (f64::from(i) + 0.5))).sum();
            assert!((course.integral(time) - sum).abs() < 1e-4, "{time}: {sum}");
        }
    }
}
