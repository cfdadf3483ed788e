//! The one description of what crosses the line: a structure's fields, once, each with its form and its meaning. Writer, reader and
//! [schema](crate::schema) follow from it.
//!
//! ```text
//! record:    version: u8 | structure
//! structure: length of its fields: u8 | the fields, in order
//! choice:    number of the case: u8 | structure of the case's fields
//! list:      number of its elements: u8 | the elements
//! option:    u8, 0 absent or 1 | the value, if there is one
//! number:    little-endian, of the width of its type
//! ```
//!
//! A field that is added later stands at the end of its structure, with `= value`: the value that it has in bytes without it. A reader
//! passes over the fields that it does not know, by the structure's length. A writer leaves out added fields at the end that have this
//! value, so that what says nothing new is, byte for byte, what earlier programs write.

use fixed::types::{I0F32, I32F32};
use heapless::Vec;
use picket_dsp::tone::frequency::Frequency;

/// The form of a value, for the schema.
#[derive(Clone, Copy, Debug)]
pub enum Form {
    /// A number of this type, as Rust spells it; `bool` is a byte, 0 or 1.
    Number(&'static str),
    /// A byte or a wider number that stands for a name: the name of the list, and each number's name.
    Name(&'static str, fn(u8) -> Option<&'static str>),
    /// Fields in order.
    Structure(&'static Structure),
    /// One of several cases.
    Choice(&'static str, &'static [Case]),
    /// A list of at most this many values.
    List(&'static Form, usize),
    /// Exactly this many values, without a count.
    Array(&'static Form, usize),
    /// A value or none.
    Option(&'static Form),
}

/// A structure.
#[derive(Clone, Copy, Debug)]
pub struct Structure {
    /// The name of the type.
    pub name: &'static str,
    /// What it is.
    pub doc: &'static str,
    /// Its fields, in the order of the bytes.
    pub fields: &'static [Place],
}

/// A field of a structure.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// The name of the field.
    pub name: &'static str,
    /// The meaning and the unit.
    pub doc: &'static str,
    /// The form.
    pub form: Form,
    /// The value, as Rust spells it, in bytes of programs that do not have the field; empty for a field of the first version.
    pub absent: &'static str,
}

/// A case of a choice.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// The number.
    pub number: u8,
    /// The name.
    pub name: &'static str,
    /// The case's own fields.
    pub fields: &'static [Place],
    /// The structure that the case consists of, in place of fields.
    pub inner: Option<Form>,
}

/// A value with a place in a layout.
pub trait Field: Sized {
    /// The form.
    const FORM: Form;
    /// The most bytes that it takes.
    const MOST: usize;
    /// Appends the value.
    fn put(&self, writer: &mut Writer<'_>);
    /// The next value; `None` where the bytes end before, or have no meaning.
    fn take(reader: &mut Reader<'_>) -> Option<Self>;
}

/// Writes fields into a buffer.
#[derive(Debug)]
pub struct Writer<'a> {
    bytes: &'a mut [u8],
    used: usize,
}

impl<'a> Writer<'a> {
    /// A writer into this buffer. What does not fit is left out; each record's length is known to fit when it is compiled.
    pub fn new(bytes: &'a mut [u8]) -> Self {
        Self { bytes, used: 0 }
    }

    /// Appends these bytes.
    // Not inlined: a record has some thirty numbers.
    #[inline(never)]
    fn bytes(&mut self, bytes: &[u8]) {
        let rest = self.bytes.get_mut(self.used..);
        if let Some(place) = rest.and_then(|rest| rest.get_mut(..bytes.len())) {
            place.copy_from_slice(bytes);
            self.used += bytes.len();
        }
    }

    /// The number of bytes so far.
    pub fn used(&self) -> usize {
        self.used
    }

    /// Begins a structure.
    pub(crate) fn open(&mut self) -> usize {
        0u8.put(self);
        self.used
    }

    /// Ends the structure that began at `start`, at this number of bytes.
    pub(crate) fn close(&mut self, start: usize, end: usize) {
        self.used = end;
        if let Some(place) = start.checked_sub(1).and_then(|at| self.bytes.get_mut(at)) {
            *place = end.saturating_sub(start) as u8;
        }
    }

    /// The bytes written so far.
    pub fn written(self) -> &'a [u8] {
        let Self { bytes, used } = self;
        bytes.get(..used).unwrap_or(&[])
    }
}

/// Reads fields from a buffer.
#[derive(Debug)]
pub struct Reader<'a> {
    bytes: &'a [u8],
    /// Whether there was a field that is not known here.
    pub more: bool,
}

impl<'a> Reader<'a> {
    /// A reader of these bytes.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, more: false }
    }

    #[inline(never)]
    fn some(&mut self, count: usize) -> Option<&'a [u8]> {
        let (some, rest) = self.bytes.split_at_checked(count)?;
        self.bytes = rest;
        Some(some)
    }

    /// Whether nothing is left.
    pub(crate) fn is_empty(&self) -> bool {
        self.bytes.is_empty()
    }

    /// The fields of the next structure.
    pub(crate) fn open(&mut self) -> Option<Self> {
        let length = u8::take(self)?;
        self.some(length.into()).map(Self::new)
    }

    /// Ends a structure: what is left of it is not known here.
    pub(crate) fn close(&mut self, structure: &Self) {
        self.more |= structure.more || !structure.is_empty();
    }
}

macro_rules! numbers {
    ($($number:ident),*) => {
        $(impl Field for $number {
            const FORM: Form = Form::Number(stringify!($number));
            const MOST: usize = size_of::<Self>();

            fn put(&self, writer: &mut Writer<'_>) {
                writer.bytes(&self.to_le_bytes());
            }

            fn take(reader: &mut Reader<'_>) -> Option<Self> {
                let bytes = reader.some(size_of::<Self>())?;
                bytes.first_chunk().map(|&bytes| Self::from_le_bytes(bytes))
            }
        })*
    };
}

numbers!(u8, u16, u32, u64, i16, i32, i64, f32, f64);

/// Values that are written as a number of another type: what turns each into the other.
macro_rules! as_number {
    ($($type:ty as $number:ident, $to:expr, $of:expr;)*) => {
        $(impl $crate::layout::Field for $type {
            const FORM: $crate::layout::Form = $crate::layout::Form::Number(stringify!($number));
            const MOST: usize = size_of::<$number>();

            fn put(&self, writer: &mut $crate::layout::Writer<'_>) {
                let to: fn(&$type) -> $number = $to;
                to(self).put(writer);
            }

            fn take(reader: &mut $crate::layout::Reader<'_>) -> Option<Self> {
                let of: fn($number) -> Option<$type> = $of;
                $number::take(reader).and_then(of)
            }
        })*
    };
}

as_number! {
    Frequency as i32, |value| value.0.to_bits(), |bits| Some(Frequency(I0F32::from_bits(bits)));
    I32F32 as i64, |value| value.to_bits(), |bits| Some(I32F32::from_bits(bits));
}

/// Values that are written as a byte with a name: the name of the list, what turns each into the other, and a value's own name.
macro_rules! named {
    ($($type:ty: $list:literal, $to:expr, $of:expr, $name:expr;)*) => {
        $(impl $crate::layout::Field for $type {
            const FORM: $crate::layout::Form = $crate::layout::Form::Name($list, |number| {
                let of: fn(u8) -> Option<$type> = $of;
                let name: fn(&$type) -> &'static str = $name;
                of(number).as_ref().map(name)
            });
            const MOST: usize = 1;

            fn put(&self, writer: &mut $crate::layout::Writer<'_>) {
                let to: fn(&$type) -> u8 = $to;
                to(self).put(writer);
            }

            fn take(reader: &mut $crate::layout::Reader<'_>) -> Option<Self> {
                let of: fn(u8) -> Option<$type> = $of;
                u8::take(reader).and_then(of)
            }
        })*
    };
}

impl Field for bool {
    const FORM: Form = Form::Number("bool");
    const MOST: usize = 1;

    fn put(&self, writer: &mut Writer<'_>) {
        u8::from(*self).put(writer);
    }

    fn take(reader: &mut Reader<'_>) -> Option<Self> {
        match u8::take(reader)? {
            0 => Some(false),
            1 => Some(true),
            _ => None,
        }
    }
}

impl<T: Field> Field for Option<T> {
    const FORM: Form = Form::Option(&T::FORM);
    const MOST: usize = 1 + T::MOST;

    fn put(&self, writer: &mut Writer<'_>) {
        self.is_some().put(writer);
        if let Some(value) = self {
            value.put(writer);
        }
    }

    fn take(reader: &mut Reader<'_>) -> Option<Self> {
        if bool::take(reader)? { T::take(reader).map(Some) } else { Some(None) }
    }
}

/// Two values.
impl<T: Field> Field for (T, T) {
    const FORM: Form = Form::Array(&T::FORM, 2);
    const MOST: usize = 2 * T::MOST;

    fn put(&self, writer: &mut Writer<'_>) {
        self.0.put(writer);
        self.1.put(writer);
    }

    fn take(reader: &mut Reader<'_>) -> Option<Self> {
        Some((T::take(reader)?, T::take(reader)?))
    }
}

impl<T: Field + Copy + Default, const N: usize> Field for [T; N] {
    const FORM: Form = Form::Array(&T::FORM, N);
    const MOST: usize = N * T::MOST;

    fn put(&self, writer: &mut Writer<'_>) {
        self.iter().for_each(|value| value.put(writer));
    }

    fn take(reader: &mut Reader<'_>) -> Option<Self> {
        let mut values = [T::default(); N];
        for value in &mut values {
            *value = T::take(reader)?;
        }
        Some(values)
    }
}

impl<T: Field, const N: usize> Field for Vec<T, N> {
    const FORM: Form = Form::List(&T::FORM, N);
    const MOST: usize = 1 + N * T::MOST;

    fn put(&self, writer: &mut Writer<'_>) {
        (self.len() as u8).put(writer);
        self.iter().for_each(|value| value.put(writer));
    }

    fn take(reader: &mut Reader<'_>) -> Option<Self> {
        let mut values = Vec::new();
        for _ in 0..u8::take(reader)? {
            values.push(T::take(reader)?).ok()?;
        }
        Some(values)
    }
}

/// The largest of some numbers.
pub(crate) const fn largest(numbers: &[usize]) -> usize {
    let (mut most, mut rest) = (0, numbers);
    while let [first, others @ ..] = rest {
        (most, rest) = (if *first > most { *first } else { most }, others);
    }
    most
}

/// Describes structures: the fields of each in the order of their bytes.
macro_rules! layout {
    ($($(#[doc = $doc:literal])* $type:path {
        $($(#[doc = $meaning:literal])* $field:ident: $form:ty $(= $absent:expr)?),* $(,)?
    })*) => {
        $(impl $crate::layout::Field for $type {
            const FORM: $crate::layout::Form =
                $crate::layout::Form::Structure(&$crate::layout::Structure {
                    name: stringify!($type),
                    doc: concat!($($doc),*),
                    fields: &[$($crate::layout::Place {
                        name: stringify!($field),
                        doc: concat!($($meaning),*),
                        form: <$form as $crate::layout::Field>::FORM,
                        absent: concat!($(stringify!($absent))?),
                    }),*],
                });
            const MOST: usize = 1 $(+ <$form as $crate::layout::Field>::MOST)*;

            fn put(&self, writer: &mut $crate::layout::Writer<'_>) {
                let start = writer.open();
                let mut end = start;
                $(
                    $crate::layout::Field::put(&self.$field, writer);
                    if layout!(@said self.$field $(, $absent)?) {
                        end = writer.used();
                    }
                )*
                writer.close(start, end);
            }

            fn take(reader: &mut $crate::layout::Reader<'_>) -> Option<Self> {
                let mut fields = reader.open()?;
                let value = Self { $($field: layout!(@take fields, $form $(, $absent)?)),* };
                reader.close(&fields);
                Some(value)
            }
        })*
    };
    (@said $value:expr) => { true };
    (@said $value:expr, $absent:expr) => { $value != $absent };
    (@take $fields:ident, $form:ty) => { <$form as $crate::layout::Field>::take(&mut $fields)? };
    (@take $fields:ident, $form:ty, $absent:expr) => {
        match $fields.is_empty() {
            true => $absent,
            false => <$form as $crate::layout::Field>::take(&mut $fields)?,
        }
    };
}

/// Describes choices: the number of each case, and its fields or the structure that it consists of.
macro_rules! choice {
    ($($type:ident { $($number:literal $case:ident
        $({ $($(#[doc = $meaning:literal])* $field:ident: $form:ty),* $(,)? })? $(($one:ident: $inner:ty))?),* $(,)?
    })*) => {
        $(impl $crate::layout::Field for $type {
            const FORM: $crate::layout::Form =
                $crate::layout::Form::Choice(stringify!($type), &[$($crate::layout::Case {
                    number: $number,
                    name: stringify!($case),
                    fields: &[$($($crate::layout::Place {
                        name: stringify!($field),
                        doc: concat!($($meaning),*),
                        form: <$form as $crate::layout::Field>::FORM,
                        absent: "",
                    }),*)?],
                    inner: choice!(@inner $($inner)?),
                }),*]);
            const MOST: usize = 1 + $crate::layout::largest(&[$(
                $(1 $(+ <$form as $crate::layout::Field>::MOST)*)?
                $(<$inner as $crate::layout::Field>::MOST)?
            ),*]);

            fn put(&self, writer: &mut $crate::layout::Writer<'_>) {
                match self {
                    $(Self::$case { $($($field),*)? $(0: $one)? } => {
                        <u8 as $crate::layout::Field>::put(&$number, writer);
                        $(
                            let start = writer.open();
                            $($crate::layout::Field::put($field, writer);)*
                            let end = writer.used();
                            writer.close(start, end);
                        )?
                        $($crate::layout::Field::put($one, writer);)?
                    })*
                    // A case of a later library has no number here: every reader refuses this one.
                    #[allow(unreachable_patterns)]
                    _ => $crate::layout::Field::put(&[u8::MAX, 0], writer),
                }
            }

            fn take(reader: &mut $crate::layout::Reader<'_>) -> Option<Self> {
                match u8::take(reader)? {
                    $($number => {
                        $(
                            #[allow(unused_mut)]
                            let mut fields = reader.open()?;
                            let value = Self::$case {
                                $($field: $crate::layout::Field::take(&mut fields)?),*
                            };
                            reader.close(&fields);
                            Some(value)
                        )?
                        $(<$inner as $crate::layout::Field>::take(reader).map(Self::$case))?
                    })*
                    _ => None,
                }
            }
        })*
    };
    (@inner) => { None };
    (@inner $inner:ty) => { Some(<$inner as $crate::layout::Field>::FORM) };
}

/// Has a structure travel in frames of a kind, if `valid` holds of it.
macro_rules! record {
    ($type:ty, $kind:ident, $valid:expr) => {
        impl $type {
            /// The most bytes of the record.
            pub const BYTES: usize = 1 + <Self as $crate::layout::Field>::MOST;

            /// The record as bytes.
            pub fn to_bytes(&self) -> heapless::Vec<u8, { Self::BYTES }> {
                heapless::Vec::from_slice(self.written(&mut [0; Self::BYTES])).unwrap_or_default()
            }

            fn written<'a>(&self, bytes: &'a mut [u8]) -> &'a [u8] {
                const { assert!(Self::BYTES <= $crate::frame::PAYLOAD) };
                let mut writer = $crate::layout::Writer::new(bytes);
                $crate::layout::Field::put(&$crate::layout::VERSION, &mut writer);
                $crate::layout::Field::put(self, &mut writer);
                writer.written()
            }

            /// The record as a frame, ready to send.
            pub fn to_frame(&self) -> heapless::Vec<u8, { $crate::frame::WIRE }> {
                let kind = $crate::frame::Kind::$kind;
                $crate::frame::encode(kind, self.written(&mut [0; Self::BYTES])).unwrap_or_default()
            }

            /// The record in these bytes. Fields that are not known here are passed over.
            ///
            /// # Errors
            /// The bytes are of another version or cut off, or a field has a value without a meaning, or one that its verdict forbids.
            pub fn from_bytes(bytes: &[u8]) -> Result<Self, $crate::layout::RecordError> {
                use $crate::layout::{Field, Reader, RecordError, VERSION};
                let mut reader = Reader::new(bytes);
                match u8::take(&mut reader) {
                    Some(VERSION) => {}
                    Some(version) => return Err(RecordError::Version(version)),
                    None => return Err(RecordError::Field),
                }
                let valid: fn(&Self) -> bool = $valid;
                <Self as Field>::take(&mut reader).filter(valid).ok_or(RecordError::Field)
            }

            /// The record in a frame.
            ///
            /// # Errors
            /// The frame is of another kind, or the errors of [`Self::from_bytes`].
            pub fn from_frame(
                frame: &$crate::frame::Frame,
            ) -> Result<Self, $crate::layout::RecordError> {
                match frame.kind {
                    $crate::frame::Kind::$kind => Self::from_bytes(&frame.payload),
                    kind => Err($crate::layout::RecordError::Kind(kind)),
                }
            }
        }
    };
}

pub(crate) use {as_number, choice, layout, named, record};

/// The version of all records.
pub const VERSION: u8 = 1;

/// Why a frame does not hold the record that is wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum RecordError {
    /// The frame is of another kind.
    Kind(crate::frame::Kind),
    /// The record is of another version.
    Version(u8),
    /// The record is cut off, or a field has a value without a meaning, or one that its verdict forbids.
    Field,
}

impl core::fmt::Display for RecordError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            RecordError::Kind(kind) => write!(f, "the frame is of kind {}", *kind as u8),
            RecordError::Version(version) => {
                write!(
                    f,
                    "the record is of version {version}, this program knows {VERSION}: update picket, or flash the board again"
                )
            }
            RecordError::Field => {
                f.write_str("the record is cut off, or a field of it has no meaning")
            }
        }
    }
}

impl core::error::Error for RecordError {}

#[cfg(test)]
mod tests {
    use super::*;

    /// A structure as it was at first, and after a later program added a field.
    #[derive(Clone, Copy, Debug, PartialEq)]
    struct First {
        a: u16,
    }

    #[derive(Clone, Copy, Debug, PartialEq)]
    struct Second {
        a: u16,
        b: f32,
    }

    layout! {
        First { a: u16 }
        Second { a: u16, b: f32 = 1.0 }
    }

    fn bytes<T: Field>(value: T) -> std::vec::Vec<u8> {
        let mut bytes = [0; 32];
        let mut writer = Writer::new(&mut bytes);
        value.put(&mut writer);
        writer.written().to_vec()
    }

    fn read<T: Field>(bytes: &[u8]) -> (Option<T>, bool) {
        let mut reader = Reader::new(bytes);
        (T::take(&mut reader), reader.more)
    }

    #[test]
    fn programs_of_different_times_read_each_other() {
        let [old, same, new] =
            [bytes(First { a: 7 }), bytes(Second { a: 7, b: 1.0 }), bytes(Second { a: 7, b: 2.0 })];
        // What says nothing new is what the earlier program writes.
        assert_eq!(old, same);
        assert_eq!(old, [2, 7, 0]);
        assert_eq!(read(&old), (Some(Second { a: 7, b: 1.0 }), false));
        assert_eq!(read(&new), (Some(Second { a: 7, b: 2.0 }), false));
        // The earlier program passes over what it does not know, and knows that it does.
        assert_eq!(read(&new), (Some(First { a: 7 }), true));
        let list =
            Vec::<Second, 2>::from_slice(&[Second { a: 1, b: 0.5 }, Second { a: 2, b: 1.0 }]);
        let read: (Option<Vec<First, 2>>, bool) = read(&bytes(list.unwrap()));
        assert_eq!(read.0.unwrap()[..], [First { a: 1 }, First { a: 2 }]);
    }

    #[test]
    fn what_is_cut_off_is_none_and_what_does_not_fit_is_left_out() {
        let whole = bytes(Second { a: 7, b: 2.0 });
        for end in 0..whole.len() {
            assert_eq!(read::<Second>(&whole[..end]).0, None, "{end}");
        }
        // A structure that ends within a field.
        assert_eq!(read::<Second>(&[4, 7, 0, 1, 2]).0, None);
        let mut room = [0; 3];
        let mut writer = Writer::new(&mut room);
        (1u16, 2u16).put(&mut writer);
        assert_eq!(writer.written(), [1, 0]);
    }
}
