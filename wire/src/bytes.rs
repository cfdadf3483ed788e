//! Fields in sequence, little-endian. Everything on the wire goes through this writer and this
//! reader.

/// Writes fields into a buffer.
#[derive(Debug)]
pub(crate) struct Writer<'a> {
    bytes: &'a mut [u8],
    used: usize,
}

impl<'a> Writer<'a> {
    pub fn new(bytes: &'a mut [u8]) -> Self {
        Self { bytes, used: 0 }
    }

    /// Appends a field. A field without room is dropped; a test of each layout shows that its
    /// fields fit.
    pub fn put<const L: usize>(&mut self, field: [u8; L]) {
        let place = self.bytes.get_mut(self.used..).and_then(<[u8]>::first_chunk_mut);
        if let Some(place) = place {
            *place = field;
            self.used += L;
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
pub(crate) struct Reader<'a>(pub &'a [u8]);

impl Reader<'_> {
    /// The next `L` bytes; `None` if fewer are left.
    pub fn take<const L: usize>(&mut self) -> Option<[u8; L]> {
        let (&field, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(field)
    }
}

macro_rules! numbers {
    ($($name:ident: $t:ty),*) => {
        impl Writer<'_> {
            $(pub fn $name(&mut self, number: $t) {
                self.put(number.to_le_bytes());
            })*
        }
        impl Reader<'_> {
            $(pub fn $name(&mut self) -> Option<$t> {
                Some(<$t>::from_le_bytes(self.take()?))
            })*
        }
    };
}

numbers!(i16: i16, u16: u16, u32: u32, u64: u64, i32: i32, i64: i64, f32: f32, f64: f64);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_come_back_and_what_does_not_fit_is_left_out() {
        let mut memory = [0; 11];
        let mut writer = Writer::new(&mut memory);
        writer.u16(0x1234);
        writer.put([7]);
        writer.f64(-2.5);
        writer.u32(9);
        let mut reader = Reader(writer.written());
        assert_eq!(
            (reader.u16(), reader.take(), reader.f64()),
            (Some(0x1234), Some([7]), Some(-2.5))
        );
        assert_eq!(reader.take::<1>(), None);
    }
}
