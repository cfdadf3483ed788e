//! The page: everything in one file, for paper and for a dark screen.

use super::lab::{Check, Lab, Section, Table, digits};
pub use crate::plot::picture::escape;

const HEAD: &str = r#"<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>Picket: the papers' figures, computed anew</title>
<style>
:root { color-scheme: light dark; --ink: #202020; --ground: #ffffff; --line: #c8c8c8; --faint: #606060; --bad: #b00020; --more: #80808080; }
@media screen and (prefers-color-scheme: dark) {
  :root { --ink: #e4e4e4; --ground: #15181c; --line: #444a52; --faint: #a0a6ad; --bad: #ff8080; }
}
body { color: var(--ink); background: var(--ground); font: 16px/1.5 "DejaVu Sans", Verdana, sans-serif; max-width: 66rem;
  margin: 2rem auto; padding: 0 1rem; }
figure { margin: 1rem 0; break-inside: avoid; }
figcaption { font-size: 0.9rem; } figcaption span { display: inline-block; margin-right: 0.9rem; }
svg { color: var(--ink); display: block; width: 100%; height: auto; }
svg.key { display: inline; width: auto; height: 0.75rem; }
/* Each picture is there twice: the narrow one never shrinks below its own size, where its text would fall under 11 px. */
.narrow { display: none; min-width: 344px; max-width: 30rem; }
@media screen and (max-width: 66rem) { .narrow { display: block; } .wide { display: none; } }
h1 { font-size: 1.6rem; } h2 { font-size: 1.2rem; margin-top: 3rem; break-after: avoid; }
/* What scrolls sideways has a shadow at the side where there is more. */
.picture, .table { overflow-x: auto; margin: 0.5rem 0 1rem; background: linear-gradient(to right, var(--ground) 40%, transparent) left,
  linear-gradient(to left, var(--ground) 40%, transparent) right, linear-gradient(to right, var(--more), transparent) left,
  linear-gradient(to left, var(--more), transparent) right; background-size: 3rem 100%, 3rem 100%, 1.2rem 100%, 1.2rem 100%;
  background-repeat: no-repeat; background-attachment: local, local, scroll, scroll; }
table { border-collapse: collapse; font-size: 0.8rem; font-variant-numeric: tabular-nums; }
th, td { padding: 0.25rem 0.7rem; text-align: right; white-space: nowrap; border-bottom: 1px solid var(--line); }
/* What a row is of stays in sight. */
th:first-child, td:first-child { text-align: left; position: sticky; left: 0; background: var(--ground); }
th { vertical-align: bottom; white-space: normal; min-width: 4.5rem; }
tr { break-inside: avoid; }
details, .faint { color: var(--faint); font-size: 0.9rem; }
.bad { color: var(--bad); font-weight: bold; }
nav li { margin: 0.1rem 0; }
@media print { body { margin: 0; max-width: none; font-size: 11pt; } nav { display: none; } }
</style></head><body>
"#;

/// The page of these sections.
pub fn page(sections: &[Section], lab: &Lab) -> Result<String, String> {
    let checks: Vec<&Check> = sections.iter().flat_map(|section| &section.checks).collect();
    let held = checks.iter().filter(|check| check.holds).count();
    let mut page = HEAD.to_owned();
    page += "<h1>The papers' figures, computed anew</h1>\n";
    page += "<p>Ye et al. 2022 (<a href=\"https://doi.org/10.3788/IRLA20220222\">doi:10.3788/IRLA20220222</a>), the lidar \
             paper, and Yang et al. 2011 (<a href=\"https://doi.org/10.3724/SP.J.1146.2010.01373\">\
             doi:10.3724/SP.J.1146.2010.01373</a>), the Doppler paper, beside what Picket measures. Every number was \
             computed by this run. ± is one standard error.</p>\n";
    page += &format!(
        "<p class=\"faint\">lab report{} --seed {}, Picket {}: {held} of {} figures within their bars.</p>\n",
        if lab.quick { " --quick" } else { "" },
        lab.seed,
        env!("CARGO_PKG_VERSION"),
        checks.len()
    );
    page += "<p class=\"hint faint\">A table that is wider than the page scrolls sideways; a shadow says where there is more.</p>\n";
    page += "<nav><ol>\n";
    for (number, section) in (1..).zip(sections) {
        page += &format!("<li><a href=\"#part{number}\">{}</a></li>\n", escape(section.title));
    }
    page += "</ol></nav>\n";
    for (number, section) in (1..).zip(sections) {
        page += &format!("<h2 id=\"part{number}\">{number}. {}</h2>\n", escape(section.title));
        for paragraph in &section.text {
            page += &format!("<p>{}</p>\n", with_code(paragraph));
        }
        for chart in &section.charts {
            page += &chart.figure()?;
        }
        if let Some(outcomes) = &section.outcomes {
            page += &outcomes.figure()?;
        }
        section.tables.iter().for_each(|table| page += &html(table));
        page += &checked(&section.checks);
    }
    page += "</body></html>\n";
    Ok(page)
}

/// Text whose parts between backticks are to be typed.
fn with_code(text: &str) -> String {
    let parts = text.split('`').enumerate();
    let part = |(index, part): (usize, &str)| match index % 2 {
        0 => escape(part),
        _ => format!("<code>{}</code>", escape(part)),
    };
    parts.map(part).collect()
}

fn html(table: &Table) -> String {
    let cells = |row: &[String], tag: &str| {
        let cells = row.iter().map(|cell| format!("<{tag}>{}</{tag}>", escape(cell)));
        format!("<tr>{}</tr>\n", cells.collect::<String>())
    };
    let rows: String = table.rows.iter().map(|row| cells(row, "td")).collect();
    format!(
        "<div class=\"table\" tabindex=\"0\"><table><thead>{}</thead><tbody>\n{rows}</tbody></table></div>\n",
        cells(&table.head, "th")
    )
}

/// The bars: what failed is in the open, the rest on demand.
fn checked(checks: &[Check]) -> String {
    if checks.is_empty() {
        return String::new();
    }
    let line = |check: &&Check| {
        let class = if check.holds { "" } else { " class=\"bad\"" };
        let bar = format!("{} to {}", digits(check.low), digits(check.high));
        format!(
            "<tr{class}><td>{}</td><td>{}</td><td>{}</td><td>{bar}</td></tr>\n",
            escape(&check.figure),
            digits(check.measured),
            digits(check.error)
        )
    };
    let list = |wanted: bool| -> String {
        let rows: String =
            checks.iter().filter(|check| check.holds == wanted).map(|c| line(&c)).collect();
        let head = "<tr><th>figure</th><th>measured</th><th>standard error</th><th>bar</th></tr>";
        if rows.is_empty() {
            rows
        } else {
            format!("<div class=\"table\" tabindex=\"0\"><table>{head}{rows}</table></div>\n")
        }
    };
    let held = checks.iter().filter(|check| check.holds).count();
    format!(
        "{}<details><summary>{held} of {} figures within their bars (and four standard errors)</summary>{}</details>\n",
        list(false),
        checks.len(),
        list(true)
    )
}
