//! How `serde` stores what a user sets, and what a block answers with: what the derives of these types do not say.
//!
//! A structure is stored by its fields' names, a choice by its name in tables and commands: `"near-edge"`, `"least-squares-real"`. A
//! reach is its number of bins. Frequencies, ranges and velocities are numbers and come back to the bit: a frequency always, the others
//! below 2^21 m or m/s; beyond, to a part in 2^53. A standard deviation that is not finite is none, in JSON `null`, and is read as
//! infinite; another such number is read as NaN.
//!
//! What a user sets is read strictly: a field that is not known, a name that this program does not have, codes that no converter has
//! are errors. A field that is missing has its default, except for the rate and the codes of a [`Config`] and for the wavelength and the
//! angle of a Doppler shift, which have none. Whether all of them together can work is the question of [`Config::plan`].

use crate::acquire::sample::Segment;
use crate::solve::candidates::CANDIDATES;
use crate::tone::threshold::FALSE_ALARM;
use crate::{
    Arithmetic, Candidate, Candidates, Codes, Decision, Effort, Following, Frequency, Method,
    Mixing, Reach, Shape, Validation, Verdict, Verdicts,
};
use core::fmt;
use fixed::types::{I0F32, I32F32};
use serde::de::{Error, SeqAccess, Unexpected, Visitor};
use serde::ser::SerializeSeq as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// The default of [`Config::new`].
pub(crate) const fn none_followed() -> Following {
    Following::NONE
}

/// The default of [`Config::new`].
pub(crate) const fn usual_false_alarm() -> f64 {
    FALSE_ALARM
}

/// The mixing by which a positive shift approaches, see [`Scene::Doppler`].
pub(crate) const fn usual_mixing() -> Mixing {
    Mixing::RxConjTx
}

/// Choices by their names.
macro_rules! names {
    ($($name:ident: $all:expr, $of:expr;)*) => {$(
        impl Serialize for $name {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                let name: fn($name) -> &'static str = $of;
                serializer.serialize_str(name(*self))
            }
        }

        impl<'de> Deserialize<'de> for $name {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                struct Named;

                impl Visitor<'_> for Named {
                    type Value = $name;

                    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                        let name: fn($name) -> &'static str = $of;
                        let mut before = "one of ";
                        for &one in $all.iter() {
                            write!(f, "{before}{}", name(one))?;
                            before = ", ";
                        }
                        Ok(())
                    }

                    fn visit_str<E: Error>(self, text: &str) -> Result<$name, E> {
                        let name: fn($name) -> &'static str = $of;
                        let found = $all.iter().copied().find(|&one| name(one) == text);
                        found.ok_or_else(|| E::invalid_value(Unexpected::Str(text), &self))
                    }
                }

                deserializer.deserialize_str(Named)
            }
        }
    )*};
}

names! {
    Verdict: Verdict::ALL, Verdict::name;
    Validation: Validation::ALL, Validation::name;
    Method: Method::ALL, Method::name;
    Effort: Effort::ALL, Effort::name;
    Decision: Decision::ALL, Decision::name;
    Mixing: Mixing::ALL, Mixing::name;
    Arithmetic: [Arithmetic::Float, Arithmetic::Fixed], |arithmetic| match arithmetic {
        Arithmetic::Float => "float",
        Arithmetic::Fixed => "fixed",
    };
    Shape: [Shape::Trapezoid, Shape::Triangle, Shape::Sawtooth], |shape| match shape {
        Shape::Trapezoid => "trapezoid",
        Shape::Triangle => "triangle",
        Shape::Sawtooth => "sawtooth",
    };
    Segment: [Segment::Continuous, Segment::Up, Segment::Flat, Segment::Down], |segment| match segment {
        Segment::Continuous => "continuous",
        Segment::Up => "up",
        Segment::Flat => "flat",
        Segment::Down => "down",
    };
}

impl Serialize for Reach {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_u8(self.bins() as u8)
    }
}

impl<'de> Deserialize<'de> for Reach {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        match u8::deserialize(deserializer)? {
            4 => Ok(Reach::Four),
            8 => Ok(Reach::Eight),
            16 => Ok(Reach::Sixteen),
            other => {
                Err(D::Error::invalid_value(Unexpected::Unsigned(other.into()), &"4, 8 or 16"))
            }
        }
    }
}

/// The rails.
#[derive(Serialize, Deserialize)]
#[serde(rename = "Codes", deny_unknown_fields)]
struct Rails {
    low: i16,
    high: i16,
}

impl Serialize for Codes {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let (low, high) = self.rails();
        Rails { low, high }.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Codes {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let Rails { low, high } = Rails::deserialize(deserializer)?;
        Codes::between(low, high)
            .ok_or_else(|| D::Error::custom("a converter has 256 codes or more"))
    }
}

/// In cycles per sample.
impl Serialize for Frequency {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_f64(self.cycles())
    }
}

impl<'de> Deserialize<'de> for Frequency {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let cycles = f64::deserialize(deserializer)?;
        I0F32::checked_from_num(cycles).map(Frequency).ok_or_else(|| {
            let expected = &"at least -0.5 and less than 0.5 cycles per sample";
            D::Error::invalid_value(Unexpected::Float(cycles), expected)
        })
    }
}

impl Serialize for Verdicts {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        // The number comes first in formats without an end of a sequence.
        let mut names = serializer.serialize_seq(Some(self.iter().count()))?;
        self.iter().try_for_each(|verdict| names.serialize_element(&verdict))?;
        names.end()
    }
}

impl<'de> Deserialize<'de> for Verdicts {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Several;

        impl<'de> Visitor<'de> for Several {
            type Value = Verdicts;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("verdicts that can apply beside another")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut names: A) -> Result<Verdicts, A::Error> {
                let mut verdicts = Verdicts::NONE;
                while let Some(verdict) = names.next_element::<Verdict>()? {
                    verdicts = verdicts.with(verdict);
                    if !verdicts.has(verdict) {
                        let name = Unexpected::Str(verdict.name());
                        return Err(A::Error::invalid_value(name, &self));
                    }
                }
                Ok(verdicts)
            }
        }

        deserializer.deserialize_seq(Several)
    }
}

impl Serialize for Candidates {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.iter())
    }
}

impl<'de> Deserialize<'de> for Candidates {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Several;

        impl<'de> Visitor<'de> for Several {
            type Value = Candidates;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("at most four candidates")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut all: A) -> Result<Candidates, A::Error> {
                let mut candidates = heapless::Vec::<Candidate, CANDIDATES>::new();
                while let Some(candidate) = all.next_element()? {
                    let full = |_| A::Error::invalid_length(CANDIDATES + 1, &self);
                    candidates.push(candidate).map_err(full)?;
                }
                Ok(Candidates::new(candidates))
            }
        }

        deserializer.deserialize_seq(Several)
    }
}

/// A velocity that may not be known.
pub(crate) mod quantity_or_none {
    use super::*;

    pub fn serialize<S: Serializer>(
        value: &Option<I32F32>,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        value.map(I32F32::to_num::<f64>).serialize(serializer)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Option<I32F32>, D::Error> {
        #[derive(Deserialize)]
        struct Quantity(#[serde(with = "quantity")] I32F32);

        Ok(Option::<Quantity>::deserialize(from)?.map(|Quantity(value)| value))
    }
}

/// A range or a velocity.
pub(crate) mod quantity {
    use super::*;

    pub fn serialize<S: Serializer>(value: &I32F32, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_f64(value.to_num())
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<I32F32, D::Error> {
        let value = f64::deserialize(deserializer)?;
        I32F32::checked_from_num(value).ok_or_else(|| {
            let expected = &"at least -2^31 and less than 2^31";
            D::Error::invalid_value(Unexpected::Float(value), expected)
        })
    }
}

/// A number that may not be finite, and how it is read then.
macro_rules! or {
    ($name:ident, $otherwise:expr) => {
        pub(crate) mod $name {
            use super::*;

            pub fn serialize<S: Serializer>(value: &f32, serializer: S) -> Result<S::Ok, S::Error> {
                Some(*value).filter(|value| value.is_finite()).serialize(serializer)
            }

            pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<f32, D::Error> {
                Ok(Option::<f32>::deserialize(from)?.unwrap_or($otherwise))
            }
        }
    };
}

or!(sigma, f32::INFINITY);
or!(number, f32::NAN);
