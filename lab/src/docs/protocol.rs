//! The tables of the protocol: the layouts in `wire/`.

use super::Table;
use crate::schema::tables;

const PAGE: &str = "docs/protocol.md";

pub(super) const TABLES: &[Table] = &[
    Table::new(PAGE, "answers", |_| Ok(tables::answers())),
    Table::new(PAGE, "settings", |_| Ok(tables::settings())),
    Table::new(PAGE, "names", |_| Ok(tables::names())),
];
