//! The samples of a block as a transform takes them. Both modules of the page have them as pairs of codes.

/// The record of these samples as `Record::pairs` gives it: of real ones the first code of each.
pub fn record(iq: bool, samples: &[[i16; 2]]) -> Vec<[i16; 2]> {
    match iq {
        true => samples.to_vec(),
        false => samples.as_chunks().0.iter().map(|&[[a, _], [b, _]]| [a, b]).collect(),
    }
}
