//! How large the library is inside: counts that may fall and not rise, so that a new rule takes the place of old ones. `cargo test -p
//! picket-host --test all -- --nocapture house` prints them.

use crate::sources::{ROOT, files};
use std::fs;
use std::path::{Path, PathBuf};

/// A file of `src/`: its path in it, and its code without tests and comments.
struct Source {
    path: String,
    code: String,
}

/// A file's text without its tests.
fn text(path: &Path) -> String {
    let text = fs::read_to_string(path).unwrap();
    text.split("#[cfg(test)]\nmod tests").next().unwrap_or_default().to_owned()
}

fn sources() -> Vec<Source> {
    let source = |path: PathBuf| {
        let text = text(&path);
        let lines = text.lines().filter(|line| {
            let line = line.trim();
            !line.is_empty() && !line.starts_with("//")
        });
        let code = lines.map(|line| format!("{line}\n")).collect();
        let path = path.strip_prefix(Path::new(ROOT).join("src")).unwrap();
        Source { path: path.to_string_lossy().into_owned(), code }
    };
    files("src").into_iter().map(source).collect()
}

/// How many constants a text defines: `const`, and a name in capitals.
fn constants(code: &str) -> usize {
    let starts = code.match_indices("const ").map(|(at, word)| &code[at + word.len()..]);
    let capital = |rest: &&str| {
        let name = rest.split(':').next().unwrap_or_default();
        // `const N: usize` of a generic item is none.
        name.len() > 1
            && name.chars().all(|c| c.is_ascii_uppercase() || c.is_ascii_digit() || c == '_')
    };
    starts.filter(capital).count()
}

#[test]
fn the_house_does_not_grow() {
    let sources = sources();
    let of = |folder: &str, count: &dyn Fn(&str) -> usize| -> usize {
        let within = sources.iter().filter(|source| source.path.starts_with(folder));
        within.map(|source| count(&source.code)).sum()
    };
    let words = |word: &'static str| move |code: &str| code.matches(word).count();
    let lines = |code: &str| code.lines().count();
    let has = |words: &'static [&'static str]| {
        move |code: &str| usize::from(words.iter().any(|word| code.contains(word)))
    };
    let counts = [
        ("lines of code in src/", of("", &lines), 23_610),
        ("lines of code in src/tone", of("tone/", &lines), 7_720),
        ("lines of code in src/model", of("model/", &lines), 1_850),
        ("constants in src/tone", of("tone/", &constants), 217),
        ("constants in src/model", of("model/", &constants), 58),
        (
            "items of src/tone that are generic over the length",
            of("tone/", &words("const N: usize")),
            49,
        ),
        ("attributes by feature in src/tone", of("tone/", &words("feature = ")), 17),
        ("attributes for the page's module in src/", of("", &words("target_arch = \"wasm32\"")), 5),
        (
            "files of src/ that tell cores apart",
            of("", &has(&["cfg(dsp", "cfg(mve", "cfg(thumb1", "cfg(any(dsp", "cfg(not(any(dsp"])),
            10,
        ),
        (
            "files of src/ that make a verdict of an Evidence",
            of("", &has(&["-> [(bool, Verdict)"])),
            1,
        ),
    ];
    for (what, count, most) in counts {
        println!("{count:6} {what}, at most {most}");
    }
    for (what, count, most) in counts {
        assert!(count <= most, "{what}: {count}, more than {most}");
    }
}

/// Every constant of the estimator has a word on what it is: a comment above it, or above the constants that it stands among.
#[test]
fn every_constant_has_a_word() {
    let mut bare = Vec::new();
    for path in ["src/tone", "src/model"].into_iter().flat_map(files) {
        let text = text(&path);
        // Whether what stands before, attributes left out, is a comment, or a constant that has one.
        let mut said = false;
        for (number, line) in text.lines().enumerate() {
            let line = line.trim();
            if constants(line) > 0 {
                if !said {
                    bare.push(format!("{}:{}: {line}", path.display(), number + 1));
                }
            } else if !line.starts_with("#[") {
                said = line.starts_with("//");
            }
        }
    }
    assert!(bare.is_empty(), "say what these are:\n{}", bare.join("\n"));
}
