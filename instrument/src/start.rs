//! What is known before the instrument starts: its settings, and how the last program ended.

use crate::crashes::Crashes;
use crate::storage::{self, Kept, Storage};
use crate::words::WORDS;
use picket_wire::boot::{Causes, LastEnd, Origin};
use picket_wire::settings::Settings;
use picket_wire::stored;

/// What is known before the instrument starts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Start {
    /// The settings to start with. A board that needs them for its clocks takes them from here.
    pub settings: Settings,
    /// Where they come from.
    pub origin: Origin,
    /// Whether the board starts stopped, after crashes in a row.
    pub halted: bool,
    /// Why the chip was reset.
    pub causes: Causes,
    /// How the last program ended.
    pub last: LastEnd,
    /// Saves of late, as [`Instrument::saves`](crate::Instrument::saves) said at the last end.
    pub saves: u32,
    /// The CRC-32 of the program; 0 if unknown.
    pub program: u32,
}

impl Start {
    /// The settings that the last program left for this one, else the newest stored ones that can be read, else the default ones. Where
    /// something is stored that cannot be read, or the board crashed too often, the instrument starts stopped: to measure by
    /// other settings than the saved ones would be silently wrong.
    pub fn new<const N: usize>(
        left: Option<[u32; WORDS]>,
        storage: &impl Storage,
        crashes: Crashes,
    ) -> Self {
        let (settings, origin) =
            match left.and_then(|left| stored::<N>(left.map(u32::to_le_bytes).as_flattened())) {
                Some(left) => (Some(left), Origin::Host),
                None => match storage::latest(storage, stored::<N>) {
                    Kept::Found(kept) => (Some(kept), Origin::Flash),
                    Kept::Nothing => (None, Origin::Default),
                    Kept::Unreadable => (None, Origin::Unreadable),
                },
            };
        let mut settings = settings.unwrap_or_default();
        settings.start &= origin != Origin::Unreadable && !crashes.halts();
        Self { settings, origin, halted: crashes.halts(), ..Self::default() }
    }
}

/// The settings in these bytes, if they are for blocks of `N` samples.
// Compiled once for what the last program left and for the flash.
#[inline(never)]
fn stored<const N: usize>(bytes: &[u8]) -> Option<Settings> {
    let (settings, n) = stored::decode(bytes).ok()?;
    (n == N).then_some(settings)
}
