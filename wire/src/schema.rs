//! All layouts, for those who write them down: `lab schema` makes `docs/schema.json` of them, `lab docs` the tables of
//! `docs/protocol.md`.

use crate::boot::Boot;
use crate::burst::Burst;
use crate::chirp_frame::{ChirpFrame, Found};
use crate::follow::Follow;
use crate::frame::Kind;
use crate::fundamental::Fundamental;
use crate::layout::{Field, Form};
use crate::lines::Lines;
use crate::settings::Settings;
use crate::status::Status;
use crate::sum::Sum;
use crate::telemetry::Telemetry;

/// The records of a board: the kind of their frames, and their layout. Each begins with the byte [`VERSION`](crate::layout::VERSION).
pub const RECORDS: [(Kind, Form); 10] = [
    (Kind::Telemetry, Telemetry::FORM),
    (Kind::Boot, Boot::FORM),
    (Kind::Status, Status::FORM),
    (Kind::Follow, Follow::FORM),
    (Kind::Lines, Lines::FORM),
    (Kind::Fundamental, Fundamental::FORM),
    (Kind::Burst, Burst::FORM),
    (Kind::Sum, Sum::FORM),
    (Kind::ChirpFrame, ChirpFrame::FORM),
    (Kind::Found, Found::FORM),
];

/// Settings: they follow the version and the length of a block, a u32.
pub const SETTINGS: Form = Settings::FORM;
