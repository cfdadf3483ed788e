//! A line of the list as text, without the formatting of `core`, which can panic.

use heapless::Vec;

/// A line on its way to the host.
pub struct Line(Vec<u8, 256>);

impl Line {
    /// A line that begins with this text.
    pub fn new(text: &str) -> Self {
        Line(Vec::new()).text(text)
    }

    /// Appends a text; a part that does not fit is left out.
    #[inline(never)] // once, for all lines
    pub fn text(mut self, text: &str) -> Self {
        text.bytes().for_each(|byte| self.push(byte));
        self
    }

    /// Appends a number.
    pub fn number(self, number: u32) -> Self {
        self.digits(number.into(), 1)
    }

    /// Appends a number with this many decimals; a dash if it is NaN or too large.
    #[inline(never)] // once, for all lines
    pub fn decimal(mut self, number: f64, decimals: u32) -> Self {
        let scale = 10_u64.saturating_pow(decimals);
        let scaled = libm::round(libm::fabs(number) * scale as f64);
        if scaled.is_nan() || scaled >= 1e18 {
            return self.text("-");
        }
        if number < 0.0 && scaled > 0.0 {
            self.push(b'-');
        }
        let scaled = scaled as u64;
        let (whole, part) =
            (scaled.checked_div(scale).unwrap_or(0), scaled.checked_rem(scale).unwrap_or(0));
        let line = self.digits(whole, 1);
        if decimals == 0 { line } else { line.text(".").digits(part, decimals) }
    }

    /// Appends a word in hexadecimal.
    #[inline(never)] // once, for all lines
    pub fn hex(mut self, word: u32) -> Self {
        for place in (0..8).rev() {
            let digit = (word >> (4 * place) & 15) as u8;
            self.push(if digit < 10 { b'0' + digit } else { b'a' + (digit - 10) });
        }
        self
    }

    /// Appends at least this many decimal digits.
    #[inline(never)] // once, for all lines
    fn digits(mut self, number: u64, least: u32) -> Self {
        for place in (0..20).rev() {
            let power = 10_u64.saturating_pow(place);
            if number >= power || place < least {
                let digit = number.checked_div(power).unwrap_or(0) % 10;
                self.push(b'0' + digit as u8);
            }
        }
        self
    }

    fn push(&mut self, byte: u8) {
        // A line that is too long is cut.
        let _ = self.0.push(byte);
    }

    /// The bytes of the line.
    pub fn bytes(&self) -> &[u8] {
        &self.0
    }
}
