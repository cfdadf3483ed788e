//! The inputs of the instrument's start: its settings, and the end of the last program.

use crate::crashes::Crashes;
use crate::port::Clocks;
use crate::storage::{self, Kept, Storage};
use crate::words::WORDS;
use picket_wire::boot::{Causes, LastEnd, Origin};
use picket_wire::settings::Settings;
use picket_wire::settings_error::SettingsError;

/// The inputs of the instrument's start.
#[derive(Clone, Copy, Debug, Default)]
pub struct Start {
    /// The settings to start with. A board whose clocks depend on them takes them from here.
    pub settings: Settings,
    /// The source of the settings.
    pub origin: Origin,
    /// Whether the board starts stopped, after crashes in a row.
    pub halted: bool,
    /// The causes of the chip's reset.
    pub causes: Causes,
    /// The end of the last program.
    pub last: LastEnd,
    /// Recent saves, as [`Instrument::saves`](crate::Instrument::saves) counted them at the last end.
    pub saves: u32,
    /// The CRC-32 of the program; 0 if unknown.
    pub program: u32,
    /// The clocks of the board, which the caller fills in.
    pub clocks: Clocks,
    /// Returns the largest stack so far, bytes; `None` if it is unknown.
    pub stack: Option<fn() -> u32>,
}

impl Start {
    /// Takes the settings that the last program left for this one, else the newest stored ones that can be read, else the default ones.
    /// Where something is stored that cannot be read, or the board crashed too often, the instrument starts stopped: measuring by other
    /// settings than the saved ones would be silently wrong.
    pub fn new<const N: usize>(
        left: Option<[u32; WORDS]>,
        storage: &impl Storage,
        crashes: Crashes,
    ) -> Self {
        let (settings, origin) = match left.and_then(|left| {
            of::<N>(Settings::from_bytes(left.map(u32::to_le_bytes).as_flattened()))
        }) {
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

/// The settings in these bytes of a page, if they are for blocks of `N` samples.
fn stored<const N: usize>(bytes: &[u8]) -> Option<Settings> {
    of::<N>(Settings::from_bytes(bytes))
}

/// Settings for blocks of `N` samples.
fn of<const N: usize>(read: Result<(Settings, usize), SettingsError>) -> Option<Settings> {
    let (settings, n) = read.ok()?;
    (n == N).then_some(settings)
}
