//! A view as the columns of a table: each number with a name that no other has.

use super::{View, is_reserved};
use crate::layout::{Form, Place};
use heapless::{String, Vec};

/// The most letters of a name, and the most numbers of a view.
const LETTERS: usize = 48;
const NUMBERS: usize = 64;

/// The last parts of names that are units: an element's number stands before them.
const UNITS: [&str; 5] = ["m", "mps", "hz", "rad", "ppm"];

/// What a table does not show: what is for programs in C, or belongs to a block.
const HIDDEN: [&str; 3] = ["count", "track", "clipped"];

/// A number of a view.
#[derive(Clone, Copy, Debug)]
pub struct Column<'a> {
    /// Its name: that of its field. One that is taken has the name of the structure's field before it, as `tone_verdict`, and so has one of
    /// several structures of a kind, as `clock_range_m`; one of a list's element has the element's number from 1 on, as `range_1_m`.
    pub name: &'a str,
    /// The list, the element's number from 0 on, and the field's own name.
    pub element: Option<(&'static str, usize, &'static str)>,
    /// The value; NaN in an element that is not there, which is one of zeros.
    pub value: f64,
}

/// Calls `put` with each column of a view, in order.
pub fn columns<V: View>(view: &V, put: &mut dyn FnMut(Column<'_>)) {
    let mut values = Vec::<f64, NUMBERS>::new();
    view.each("", &mut |_, value| {
        // A view of more numbers has no table: the test below counts them.
        let _ = values.push(value);
    });
    let mut walk = Walk { values: &values, names: Vec::new(), beside: false, absent: false, put };
    walk.form(&V::FORM, "", "", None);
}

struct Walk<'a> {
    values: &'a [f64],
    names: Vec<String<LETTERS>, NUMBERS>,
    /// Whether the structure is one of several of its kind in a structure.
    beside: bool,
    /// Whether the element is not there.
    absent: bool,
    put: &'a mut dyn FnMut(Column<'_>),
}

impl Walk<'_> {
    /// A form's numbers: the field's name, that of the field which holds it, and the element that they belong to.
    fn form(
        &mut self,
        form: &Form,
        holder: &'static str,
        name: &'static str,
        element: Option<(&'static str, usize)>,
    ) {
        match form {
            Form::Structure(structure) => {
                for place in structure.fields {
                    if !is_reserved(place.name) {
                        let before = self.beside;
                        self.beside |= is_repeated(&place.form, structure.fields);
                        self.form(&place.form, name, place.name, element);
                        self.beside = before;
                    }
                }
            }
            Form::Array(inner, count) => {
                let own = numbers(inner);
                for number in 0..*count {
                    let here = self.values.get(..own).unwrap_or_default();
                    self.absent = here.iter().all(|value| *value == 0.0);
                    self.form(inner, name, name, Some((name, number)));
                    self.absent = false;
                }
            }
            _ => self.number(holder, name, element),
        }
    }

    fn number(
        &mut self,
        holder: &'static str,
        name: &'static str,
        element: Option<(&'static str, usize)>,
    ) {
        let Some((&value, rest)) = self.values.split_first() else { return };
        self.values = rest;
        if HIDDEN.contains(&name) {
            return;
        }
        let mut of = String::new();
        // No name is longer than the room for it: the test below looks at all.
        let done = match element {
            Some((_, number)) => numbered(&mut of, name, number),
            None if self.beside || self.names.iter().any(|known| known == name) => {
                of.push_str(holder).and(of.push('_')).and(of.push_str(name))
            }
            None => of.push_str(name),
        };
        if done.is_err() {
            return;
        }
        let element = element.map(|(list, number)| (list, number, name));
        let value = if self.absent { f64::NAN } else { value };
        (self.put)(Column { name: &of, element, value });
        let _ = self.names.push(of);
    }
}

/// Whether a structure is one of several of its kind among these fields.
fn is_repeated(form: &Form, fields: &[Place]) -> bool {
    let name = |form: &Form| match form {
        Form::Structure(structure) => Some(structure.name),
        _ => None,
    };
    let own = name(form);
    own.is_some() && fields.iter().filter(|place| name(&place.form) == own).count() > 1
}

/// How many numbers a form has.
fn numbers(form: &Form) -> usize {
    match form {
        Form::Structure(structure) => {
            let shown = structure.fields.iter().filter(|place| !is_reserved(place.name));
            shown.map(|place| numbers(&place.form)).sum()
        }
        Form::Array(inner, count) => count * numbers(inner),
        _ => 1,
    }
}

/// A name with an element's number.
fn numbered(
    of: &mut String<LETTERS>,
    name: &str,
    number: usize,
) -> Result<(), heapless::CapacityError> {
    let unit = name.rsplit_once('_').filter(|(_, unit)| UNITS.contains(unit));
    let digit = char::from_digit(number as u32 + 1, 10).unwrap_or('_');
    of.push_str(unit.map_or(name, |it| it.0))?;
    of.push('_').and(of.push(digit))?;
    unit.map_or(Ok(()), |it| of.push('_').and(of.push_str(it.1)))
}

#[cfg(test)]
mod tests {
    use super::super::{Budget, FrameTarget, PhaseRange};
    use super::*;
    use std::string::String;
    use std::vec::Vec;

    fn names<V: View>() -> Vec<String> {
        let mut names = Vec::new();
        columns(&V::default(), &mut |column| names.push(column.name.into()));
        assert!(V::COUNT <= NUMBERS && names.len() + HIDDEN.len() >= V::COUNT);
        names
    }

    #[test]
    fn each_number_has_a_name_of_its_own() {
        for names in [names::<FrameTarget>(), names::<PhaseRange>(), names::<Budget>()] {
            let mut once = names.clone();
            once.sort();
            once.dedup();
            assert_eq!(once.len(), names.len(), "{names:?}");
        }
        let target = names::<FrameTarget>();
        for name in ["range_m", "range_1_m", "odds_4", "verdict", "tone_verdict", "covariance"] {
            assert!(target.iter().any(|known| known == name), "{name}: {target:?}");
        }
        let budget = names::<Budget>();
        assert_eq!(
            budget[..3],
            ["uncertainty_range_m", "uncertainty_velocity_mps", "noise_range_m"]
        );
    }
}
