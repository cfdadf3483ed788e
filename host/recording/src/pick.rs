//! Which channels of a recording are its samples: one, or two as I and Q.

use super::{Options, RecordingError};
use std::path::Path;

/// The channel that is the sample, from 0, and the one that is its quadrature part.
pub(super) type Picked = (usize, Option<usize>);

/// Of this many channels those that are asked for. Without a choice there has to be one, or two where they are I and Q.
pub(super) fn real(
    path: &Path,
    channels: usize,
    options: &Options,
) -> Result<Picked, RecordingError> {
    if let Some((first, second)) = options.channel {
        let place = |channel: usize| {
            let wrong = || RecordingError::Channel(path.into(), channel, channels);
            channel.checked_sub(1).filter(|&place| place < channels).ok_or_else(wrong)
        };
        return Ok((place(first)?, second.map(place).transpose()?));
    }
    match (channels, options.iq) {
        (1, false) => Ok((0, None)),
        (2, true) => Ok((0, Some(1))),
        _ => Err(RecordingError::Channels(path.into(), channels, options.iq)),
    }
}

/// Of this many channels of complex numbers the one that is asked for, as places among their parts. A single one's parts can be picked
/// as two channels: 2,1 exchanges I and Q, and 1 alone is I.
pub(super) fn complex(
    path: &Path,
    channels: usize,
    options: &Options,
) -> Result<Picked, RecordingError> {
    match (options.channel, channels) {
        (None, 1) => Ok((0, Some(1))),
        (Some(_), 1) => real(path, 2, options),
        (Some((channel, None)), _) if (1..=channels).contains(&channel) => {
            Ok((2 * (channel - 1), Some(2 * channel - 1)))
        }
        (Some((_, Some(_))), _) => Err(RecordingError::AlreadyPairs(path.into(), channels)),
        (Some((channel, None)), _) => Err(RecordingError::Channel(path.into(), channel, channels)),
        (None, _) => Err(RecordingError::ComplexChannels(path.into(), channels)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_or_a_pair() {
        let path = Path::new("x");
        let with = |iq, channel| Options { iq, channel, ..Options::default() };
        let of = |channels, iq, channel| real(path, channels, &with(iq, channel)).ok();
        assert_eq!(of(1, false, None), Some((0, None)));
        assert_eq!(of(2, true, None), Some((0, Some(1))));
        assert_eq!(of(5, false, Some((4, Some(2)))), Some((3, Some(1))));
        assert!(of(2, false, None).is_none() && of(1, true, None).is_none());
        assert!(of(2, false, Some((3, None))).is_none());
        let of = |channels, channel| complex(path, channels, &with(false, channel)).ok();
        assert_eq!(of(1, None), Some((0, Some(1))));
        assert_eq!(of(1, Some((2, Some(1)))), Some((1, Some(0))));
        assert_eq!(of(3, Some((2, None))), Some((2, Some(3))));
        assert!(of(3, None).is_none() && of(3, Some((4, None))).is_none());
        assert!(of(2, Some((1, Some(2)))).is_none());
    }
}
