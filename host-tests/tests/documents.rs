//! The documents as a book: every chapter exists, every page is a chapter, and every link leads somewhere.

use picket_dsp::Verdict;
use picket_firmware::nucleo_f446re::words::Words;
use picket_firmware::nucleo_f446re::words::clock::{Source, Speed, Tree};
use picket_firmware::nucleo_f446re::{CELLS, N};
use picket_host::watch::settings;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Component, Path, PathBuf};

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
/// Where a page of the book finds what is outside of the book.
const REPOSITORY: &str = "https://github.com/picket-dsp/picket/blob/main/";

fn read(path: &str) -> String {
    fs::read_to_string(Path::new(ROOT).join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// The pages below `docs`, by their path from the root; `SUMMARY.md` is none.
fn pages() -> BTreeSet<String> {
    let folder = |name: &'static str| {
        let entries = fs::read_dir(Path::new(ROOT).join(name)).unwrap();
        entries.map(move |entry| {
            format!("{name}/{}", entry.unwrap().file_name().into_string().unwrap())
        })
    };
    let all = folder("docs").chain(folder("docs/recipes"));
    all.filter(|path| path.ends_with(".md") && path != "docs/SUMMARY.md").collect()
}

/// A page without its blocks and spans of code.
fn prose(text: &str) -> String {
    let outside = text.split("```").step_by(2).collect::<String>();
    outside.split('`').step_by(2).collect()
}

/// What the links and the pictures of a page lead to.
fn targets(text: &str) -> Vec<String> {
    let text = prose(text);
    let markdown = text.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    let html = text.split("src=\"").skip(1).filter_map(|rest| rest.split('"').next());
    markdown.chain(html).map(str::to_owned).collect()
}

/// A path without `.` and `..`.
fn plain(path: &Path) -> PathBuf {
    path.components().fold(PathBuf::new(), |mut plain, part| {
        match part {
            Component::ParentDir => {
                plain.pop();
            }
            Component::CurDir => {}
            part => plain.push(part),
        }
        plain
    })
}

/// The anchor of a heading, as GitHub and mdBook make it.
fn anchor(heading: &str) -> String {
    let kept = |c: &char| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_');
    heading
        .trim()
        .to_lowercase()
        .chars()
        .filter(kept)
        .map(|c| if c == ' ' { '-' } else { c })
        .collect()
}

fn anchors(text: &str) -> BTreeSet<String> {
    let outside = text.split("```").step_by(2).collect::<String>();
    let headings = outside.lines().filter(|line| line.starts_with('#'));
    headings.map(|line| anchor(line.trim_start_matches('#'))).collect()
}

#[test]
fn every_chapter_exists_and_every_page_is_a_chapter() {
    let chapters: Vec<String> =
        targets(&read("docs/SUMMARY.md")).iter().map(|target| format!("docs/{target}")).collect();
    let listed: BTreeSet<String> = chapters.iter().cloned().collect();
    assert_eq!(listed.len(), chapters.len(), "a chapter is listed twice");
    assert!(listed.len() > 15, "{listed:?}");
    assert_eq!(listed, pages(), "chapters of docs/SUMMARY.md, and pages below docs");
}

#[test]
fn every_link_leads_somewhere() {
    let (mut wrong, mut followed) = (Vec::new(), 0);
    let others = ["README.md", "CONTRIBUTING.md", "SECURITY.md", "CHANGELOG.md"];
    for page in pages().into_iter().chain(others.map(str::to_owned)) {
        let text = read(&page);
        for target in targets(&text) {
            let (file, fragment) = target.split_once('#').unwrap_or((&target, ""));
            let place = match file.strip_prefix(REPOSITORY) {
                Some(path) => PathBuf::from(path),
                None if file.starts_with("http") => continue,
                None if file.is_empty() => PathBuf::from(&page),
                None => plain(&Path::new(&page).parent().unwrap().join(file)),
            };
            followed += 1;
            let outside = page.starts_with("docs/") && !place.starts_with("docs");
            if outside && !file.starts_with(REPOSITORY) {
                wrong.push(format!(
                    "{page}: {target} is outside of the book: begin it with {REPOSITORY}"
                ));
            }
            if !Path::new(ROOT).join(&place).exists() {
                wrong.push(format!("{page}: {target} is not there"));
            } else if !fragment.is_empty()
                && !anchors(&read(place.to_str().unwrap())).contains(fragment)
            {
                wrong.push(format!("{page}: {target} has no such heading"));
            }
        }
    }
    assert!(followed > 100, "{followed}");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// The parts of a text between two marks, without the space around them.
fn list<'a>(text: &'a str, from: &str, to: &str, separator: &str) -> Vec<&'a str> {
    let (_, rest) = text.split_once(from).unwrap_or_else(|| panic!("no {from}"));
    let (list, _) = rest.split_once(to).unwrap_or_else(|| panic!("no {to}"));
    list.split(separator).map(str::trim).filter(|part| !part.is_empty()).collect()
}

/// The page has a sign for every verdict.
#[test]
fn every_verdict_has_a_sign() {
    let signs = read("web/page/words.js");
    let signs: Vec<&str> = list(&signs, "export const SIGNS = {", "};", "\n")
        .into_iter()
        .map(|line| line.split(':').next().unwrap().trim_matches('"'))
        .collect();
    assert_eq!(signs, Verdict::ALL.map(Verdict::name), "words.js");
}

/// The board takes the settings files of its page.
#[test]
fn the_boards_page_has_settings_that_the_board_takes() {
    let page = read("docs/board.md");
    let files: Vec<&str> =
        page.split("```json\n").skip(1).map(|rest| rest.split("```").next().unwrap()).collect();
    assert_eq!(files.len(), 3);
    let tree = Tree::new(Speed::from_mhz(180).unwrap(), Source::HsePll);
    for (number, file) in files.into_iter().enumerate() {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("settings-{number}.json"));
        fs::write(&path, file).unwrap();
        let (settings, n) = settings::read(&path).unwrap();
        assert_eq!(n, N);
        let (plan, _) =
            Words::plan::<N>(&settings, &tree).unwrap_or_else(|error| panic!("{error}"));
        assert!(plan.settings.iq == (number == 0), "{number}");
        let frames = plan.settings.frames(N).unwrap();
        assert_eq!(frames.is_some(), number == 2);
        assert!(frames.is_none_or(|frames| frames.cells() <= CELLS));
    }
}

/// A link that leads nowhere is seen.
#[test]
fn the_reader_of_links_reads_them() {
    let page = "# One `two`: three\n[a](b.md#c) ![d](e.svg) <img src=\"f.png\"> `[g](h.md)`\n```\n[i](j.md)\n# K\n```\n";
    assert_eq!(targets(page), ["b.md#c", "e.svg", "f.png"]);
    assert_eq!(anchors(page), BTreeSet::from(["one-two-three".to_owned()]));
    assert_eq!(plain(Path::new("docs/recipes/../web.md")), Path::new("docs/web.md"));
}
