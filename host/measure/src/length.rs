//! The lengths and the kinds of a record, which are types of the library: a number becomes one here, for code that has borrows that the
//! library's `ForRecord` would have to name.

/// The lengths of a record.
pub const LENGTHS: [usize; 7] = [64, 128, 256, 512, 1024, 2048, 4096];

/// # Errors
/// `n` is no length of a record: one line that names the nearest.
pub fn check(n: usize) -> Result<(), String> {
    let below = LENGTHS.into_iter().rfind(|&length| length < n);
    let above = LENGTHS.into_iter().find(|&length| length > n);
    let nearest = match (below, above) {
        _ if LENGTHS.contains(&n) => return Ok(()),
        (Some(below), Some(above)) => format!("{below} or {above}"),
        (below, above) => below.or(above).unwrap_or_default().to_string(),
    };
    Err(format!("N = {n}: blocks have 64, 128, ... 4096 samples, so choose {nearest}"))
}

/// Runs `$body` with `$kind` standing for the kind of record that a flag names.
#[macro_export]
macro_rules! with_kind {
    ($iq:expr, $kind:ident => $body:expr) => {
        if $iq {
            type $kind = picket_dsp::acquire::sample::Iq;
            $body
        } else {
            type $kind = picket_dsp::acquire::sample::Real;
            $body
        }
    };
}

/// Runs `$body` with `$kind` standing for the kind of record that a flag names, and the constant `$length` for a number of samples that
/// was [checked](check).
#[macro_export]
macro_rules! with_record {
    ($iq:expr, $n:expr, $kind:ident, $length:ident => $body:expr) => {
        $crate::with_kind!($iq, $kind => $crate::with_record!(@ $n, $length, $body, 64, 128, 256, 512, 1024, 2048; 4096))
    };
    (@ $n:expr, $length:ident, $body:expr, $($each:literal),*; $last:literal) => {
        match $n {
            $($each => {
                const $length: usize = $each;
                $body
            })*
            _ => {
                const $length: usize = $last;
                $body
            }
        }
    };
}

#[cfg(test)]
mod tests {
    use super::*;
    use picket_dsp::acquire::sample::Record;

    #[test]
    fn an_error_names_the_nearest_lengths() {
        let nearest =
            |n| check(n).err().and_then(|error| Some(error.split_once("choose ")?.1.to_owned()));
        for n in LENGTHS {
            assert_eq!(nearest(n), None);
            assert_eq!(with_record!(false, n, R, N => [R::IQ as usize, N]), [0, n]);
            assert_eq!(with_record!(true, n, R, N => [R::IQ as usize, N]), [1, n]);
        }
        for (n, expected) in [(0, "64"), (65, "64 or 128"), (1000, "512 or 1024"), (5000, "4096")] {
            assert_eq!(nearest(n).as_deref(), Some(expected));
        }
    }
}
