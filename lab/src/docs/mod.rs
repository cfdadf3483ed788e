//! `lab docs`: the tables of the documents, written from measurements, or compared with them.
//!
//! A table stands between the lines `<!-- table: NAME -->` and `<!-- end -->` of a page. What stands there is the table's alone.

mod boards;
mod claims;
mod compare;
mod computed;
mod doors;
mod figures;
mod listings;
mod peers;
mod performance;
mod protocol;
pub mod recordings;
mod typed;

use crate::{cli, toolchain};
use clap::Args;
use std::fs;
use std::process::ExitCode;

/// Writes the tables of the documents from measurements, between their markers. With --check compares them, within 2 % or a unit of the last
/// digit; the exit code is 1 if one differs.
#[derive(Args, Debug)]
pub struct Options {
    /// Compares and writes nothing
    #[arg(long)]
    check: bool,
    /// Only tables that need no emulator and no image
    #[arg(long)]
    fast: bool,
    /// Lists the tables
    #[arg(long, conflicts_with_all = ["check", "fast"])]
    list: bool,
    /// Tables or pages, such as `recordings` or `docs/precision.md` [default: all]
    #[arg(value_name = "NAME")]
    names: Vec<String>,
}

/// A table of a page.
struct Table {
    /// Its name in the marker.
    name: &'static str,
    /// The page's path in the clone.
    page: &'static str,
    /// Whether it takes an emulator or an image.
    slow: bool,
    /// Its lines, as they are now.
    lines: fn(&Table) -> Result<Vec<String>, String>,
}

impl Table {
    const fn new(
        page: &'static str,
        name: &'static str,
        lines: fn(&Table) -> Result<Vec<String>, String>,
    ) -> Self {
        Self { name, page, slow: false, lines }
    }

    const fn slow(self) -> Self {
        Self { slow: true, ..self }
    }

    /// Where its lines are among those of the page: between its markers.
    fn place(&self, page: &[&str]) -> Result<std::ops::Range<usize>, String> {
        let Table { name, page: path, .. } = self;
        let marker = format!("<!-- table: {name} -->");
        if page.iter().filter(|line| **line == marker).count() != 1 {
            return Err(format!("{path}: the line {marker} must stand there once"));
        }
        let begin = 1 + page.iter().position(|line| *line == marker).unwrap_or(0);
        let rest = page.get(begin..).unwrap_or_default();
        let length = rest.iter().position(|line| line.starts_with("<!-- "));
        let end = length.filter(|&length| rest.get(length) == Some(&"<!-- end -->"));
        let length = end.ok_or_else(|| format!("{path}: no <!-- end --> after {marker}"))?;
        Ok(begin..begin + length)
    }
}

fn tables() -> impl Iterator<Item = &'static Table> {
    let pages: [&'static [Table]; 9] = [
        computed::TABLES,
        performance::TABLES,
        boards::TABLES,
        listings::TABLES,
        typed::TABLES,
        claims::TABLES,
        protocol::TABLES,
        doors::TABLES,
        peers::TABLES,
    ];
    pages.into_iter().flatten()
}

/// Writes or compares the tables.
///
/// # Errors
/// A name that is no table's and no page's; a page without a marker; what a measurement needs is missing.
pub fn run(options: &Options) -> Result<ExitCode, String> {
    let is_called = |table: &Table, name: &str| table.name == name || table.page == name;
    let unknown = |name: &&String| !tables().any(|table| is_called(table, name));
    if let Some(name) = options.names.iter().find(unknown) {
        return Err(format!("{name} is no table and no page with one: --list lists them"));
    }
    let chosen = tables().filter(|table| {
        let named = options.names.iter().any(|name| is_called(table, name));
        (named || options.names.is_empty()) && !(options.fast && table.slow)
    });
    let mut differs = 0;
    for table in chosen {
        let Table { name, page, slow, .. } = table;
        if options.list {
            cli::print_line(&format!("{page:22} {name}{}", if *slow { " (slow)" } else { "" }));
            continue;
        }
        let path = toolchain::workspace().join(page);
        let told = |error| format!("{page}, {name}: {error}");
        let text = fs::read_to_string(&path).map_err(|error| format!("{page}: {error}"))?;
        let lines: Vec<&str> = text.lines().collect();
        let place = table.place(&lines)?;
        let measured = (table.lines)(table).map_err(told)?;
        let stated = lines.get(place.clone()).unwrap_or_default();
        let differences = compare::differences(stated, &measured);
        for difference in &differences {
            cli::print_line(&format!("{page}, {name}: {difference}"));
        }
        differs += usize::from(!differences.is_empty());
        if !options.check && !differences.is_empty() {
            let (before, after) = (&lines[..place.start], &lines[place.end..]);
            let mut text = before.join("\n") + "\n" + &measured.join("\n") + "\n";
            text += &(after.join("\n") + "\n");
            fs::write(&path, text).map_err(|error| format!("{page}: {error}"))?;
        }
    }
    if options.check && differs > 0 {
        cli::print_line(&format!("{differs} tables differ: `lab docs` writes them"));
        return Ok(ExitCode::FAILURE);
    }
    Ok(ExitCode::SUCCESS)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each table has its place, each place its table, and no name stands for two tables of a page.
    #[test]
    fn every_marker_is_a_tables() {
        let pages = ["docs", "docs/recipes"].into_iter().flat_map(|folder| {
            let entries = fs::read_dir(toolchain::workspace().join(folder)).unwrap();
            entries.map(move |entry| format!("{folder}/{}", entry.unwrap().file_name().display()))
        });
        let mut markers = 0;
        let pages = pages.filter(|page| page.ends_with(".md"));
        for page in pages.chain(["README.md".to_owned()]) {
            let text = fs::read_to_string(toolchain::workspace().join(&page)).unwrap();
            let names = text.lines().filter_map(|line| line.strip_prefix("<!-- table: "));
            for name in names.map(|name| name.trim_end_matches(" -->")) {
                let known = tables().filter(|table| table.page == page && table.name == name);
                assert_eq!(known.count(), 1, "{page}: {name}");
                markers += 1;
            }
        }
        assert_eq!(markers, tables().count());
        for table in tables() {
            let text = fs::read_to_string(toolchain::workspace().join(table.page)).unwrap();
            table.place(&text.lines().collect::<Vec<_>>()).unwrap();
        }
    }

    #[test]
    fn a_table_has_its_place_between_its_markers() {
        let table = Table::new("page", "a", |_| Ok(Vec::new()));
        let page = ["x", "<!-- table: a -->", "1", "2", "<!-- end -->", "y"];
        assert_eq!(table.place(&page), Ok(2..4));
        assert!(table.place(&page[..4]).is_err() && table.place(&page[2..]).is_err());
        let within = ["<!-- table: a -->", "<!-- table: b -->", "<!-- end -->"];
        assert!(table.place(&within).is_err());
    }
}
