//! `cargo lab report --quick`: every file is there, whole, and every figure within its bar.

use picket_lab::report::page::escape;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

const PICTURES: [&str; 12] = [
    "over-snr",
    "impaired",
    "trust-good",
    "image-floors",
    "outliers",
    "lidar-figure-2",
    "lidar-figure-4",
    "wrong-direction",
    "doppler-figure-1",
    "doppler-figure-3-low",
    "doppler-figure-3-middle",
    "doppler-figure-3-high",
];

/// Figures that must be among those checked.
const FIGURES: [&str; 14] = [
    "RMSE of z-rife, real, Hz",
    "RMSE of rife, real, Hz",
    "RMSE of least-squares-real, real, Hz",
    "RMSE of least-squares, I/Q, Hz",
    "multiplications of Z-Rife beyond Rife's",
    "rows of Table 3 that eqs 1 and 2 get wrong",
    "share of targets inside 5 cm and 0.16 km/h, -5 dB, least-squares-real",
    "P(wrong direction), -10 dB, offset 0.05",
    "crossing at offset 0 as printed, dB",
    "turntable, FESA, -12 dB, mm/s",
    "outliers, N = 1024, 1e-3: at dB",
    "z-rife, real samples, 60 dB, bin 5",
    "target-fixed over f64, full scale, 60 dB",
    "fesa, RMSE / bound at 0 dB",
];

#[test]
fn the_quick_report() {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("report");
    let _ = fs::remove_dir_all(&folder);
    let output = Command::new(env!("CARGO_BIN_EXE_lab"))
        .args(["report", "--quick", "--json", "--out"])
        .arg(&folder)
        .output()
        .unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    let lines: Vec<serde_json::Value> =
        text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let (summary, checks) = lines.split_last().unwrap();
    println!("{summary}");
    for check in checks {
        assert_eq!(check["holds"], true, "{check}");
    }
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(checks.len() > 200 && summary["figures"] == checks.len());
    for figure in FIGURES {
        assert!(checks.iter().any(|check| check["figure"] == figure), "no \"{figure}\"");
    }
    let page = fs::read_to_string(folder.join("report.html")).unwrap();
    assert!(page.ends_with("</body></html>\n") && page.matches("<h2").count() == 16);
    // One file: nothing is fetched.
    assert!(!page.contains("<img") && !page.contains("<link") && !page.contains("<script"));
    assert!(!page.contains("NaN"));
    assert_eq!(page.matches("<svg").count(), page.matches("</svg>").count());
    for name in PICTURES {
        let svg = fs::read_to_string(folder.join(format!("{name}.svg"))).unwrap();
        assert!(svg.contains("<metadata>") && svg.trim_end().ends_with("</svg>"), "{name}");
        let png = fs::read(folder.join(format!("{name}.png"))).unwrap();
        assert!(png.starts_with(b"\x89PNG") && png.len() > 50_000, "{name}: {} bytes", png.len());
    }
    assert!(page.matches("<svg").count() >= PICTURES.len());
    text_is_large_enough(&page);
    figures_have_their_errors(&page);
}

/// In a browser: no text is too small, and nothing reaches over the edge.
#[test]
#[ignore = "needs Chromium: cargo test -p picket-lab --test all -- --ignored report"]
fn the_quick_report_in_a_browser() {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("report-seen");
    let _ = fs::remove_dir_all(&folder);
    let mut command = Command::new(env!("CARGO_BIN_EXE_lab"));
    assert!(command.args(["report", "--quick", "--out"]).arg(&folder).status().unwrap().success());
    let page = fs::read_to_string(folder.join("report.html")).unwrap();
    let browser = browser().expect("apt-get install chromium");
    [390, 1280].into_iter().for_each(|width| seen_in(&browser, &page, width, &folder));
}

/// The least size of a picture's text, in CSS pixels.
const LEAST: f64 = 11.0;

/// What follows `start` up to `end`, wherever that occurs.
fn between<'a>(text: &'a str, start: &str, end: &str) -> Vec<&'a str> {
    text.split(start).skip(1).map(|rest| rest.split(end).next().unwrap()).collect()
}

/// No picture is shown smaller than it is drawn, and drawn text is large enough.
fn text_is_large_enough(page: &str) {
    let style = between(page, "<style>", "</style>")[0];
    assert!(style.contains(".narrow { display: none; min-width: 344px;"));
    // The wide one only where the text is wider than it is drawn.
    assert!(style.contains("@media screen and (max-width: 66rem) { .narrow { display: block; } .wide { display: none; } }"));
    for (class, width) in [("narrow", 344), ("wide", 960)] {
        let pictures = between(page, &format!("<svg class=\"{class}\""), "</svg>");
        assert!(pictures.len() > PICTURES.len(), "{class}: {}", pictures.len());
        for picture in pictures {
            assert!(picture.contains(&format!("viewBox=\"0 0 {width} ")));
            let sizes = between(picture, "font-size=\"", "\"");
            let least = sizes.iter().map(|size| size.parse().unwrap()).fold(f64::MAX, f64::min);
            assert!((LEAST..20.0).contains(&least), "{class}: {least} px");
        }
    }
}

/// What was measured stands beside its statistical error: few trials make rough figures.
fn figures_have_their_errors(page: &str) {
    let mut figures = 0;
    for table in between(page, "<table><thead>", "</table>") {
        let head = between(table, "<th>", "</th>");
        for row in between(table, "<tr><td>", "</tr>") {
            let cells = between(row, "<td>", "</td>");
            for (name, cell) in head.iter().skip(1).zip(cells) {
                let measured =
                    ["RMSE / bound", "measured", "1 in 10", "inside the", "floor at", "rms "];
                let given =
                    cell.starts_with("at most") || cell.starts_with("below") || cell == "100";
                if measured.iter().any(|word| name.contains(word)) && !given {
                    assert!(cell.contains('±') || cell == "-", "{name}: {cell}");
                    figures += 1;
                }
            }
        }
    }
    println!("{figures} figures have their errors");
    assert!(figures > 150, "{figures}");
}

fn browser() -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    let names = ["chromium", "chromium-browser", "google-chrome"];
    std::env::split_paths(&path)
        .flat_map(|folder| names.map(|name| folder.join(name)))
        .find(|file| file.is_file())
}

/// Measures what a browser makes of the page on a screen of this width: the least text of a picture; what reaches over the edge
/// and does not scroll; pictures that scroll; cells of two lines; tables that scroll, and those without a mark that they do.
const MEASURE: &str = r#"
const of = document.querySelector('iframe').contentDocument, width = of.documentElement.clientWidth;
const shown = [...of.querySelectorAll('figure svg text')].filter(text => text.getBoundingClientRect().width > 0);
const sizes = shown.map(text => {
  const svg = text.ownerSVGElement;
  return parseFloat(getComputedStyle(text).fontSize) * svg.getBoundingClientRect().width / svg.viewBox.baseVal.width;
});
const boxes = [...of.querySelectorAll('body *')].filter(element => !element.closest('.picture, .table'));
const over = boxes.filter(element => element.getBoundingClientRect().right > width + 1);
const scrolls = [...of.querySelectorAll('.picture')].filter(box => box.scrollWidth > box.clientWidth + 1);
const small = [...of.querySelectorAll('td, th, p, li, figcaption')].filter(e => parseFloat(getComputedStyle(e).fontSize) < 12);
const lines = cell => cell.getBoundingClientRect().height / parseFloat(getComputedStyle(cell).lineHeight);
const broken = [...of.querySelectorAll('td')].filter(cell => lines(cell) > 2);
const wide = [...of.querySelectorAll('.table')].filter(box => box.scrollWidth > box.clientWidth + 1);
const shadow = box => getComputedStyle(box).backgroundAttachment.includes('scroll');
const told = of.querySelector('.hint').getBoundingClientRect().height > 0;
document.querySelector('pre').textContent = JSON.stringify({
  width, texts: sizes.length, least: Math.min(...sizes), over: over.length, page: of.documentElement.scrollWidth,
  scrolls: scrolls.length, small: small.length, broken: broken.length, tables: wide.length,
  unmarked: wide.filter(box => !(told && shadow(box))).length });
"#;

fn seen_in(browser: &Path, page: &str, width: u32, folder: &Path) {
    let file = folder.join(format!("seen-{width}.html"));
    let frame = format!(
        "<iframe style=\"width: {width}px; height: 844px; border: 0\" srcdoc=\"{}\"></iframe>",
        escape(page)
    );
    let script = format!("<script>onload = () => {{{MEASURE}}};</script>");
    fs::write(&file, format!("<!doctype html><meta charset=\"utf-8\"><pre></pre>{frame}{script}"))
        .unwrap();
    let profile = tempfile::tempdir().unwrap();
    let output = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"])
        .args(["--disable-background-networking", "--disable-component-update", "--disable-sync"])
        .arg(format!("--user-data-dir={}", profile.path().display()))
        .args(["--window-size=1400,1000", "--dump-dom"])
        .arg(format!("file://{}", file.canonicalize().unwrap().display()))
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&output.stdout);
    let measured = between(&text, "<pre>", "</pre>");
    let measured = measured.first().unwrap_or_else(|| {
        panic!("{}: {}", output.status, String::from_utf8_lossy(&output.stderr))
    });
    println!("{measured}");
    let seen: serde_json::Value = serde_json::from_str(measured).unwrap();
    assert!(seen["texts"].as_u64().unwrap() > 200, "{seen}");
    assert!(seen["least"].as_f64().unwrap() >= LEAST, "{seen}");
    for fault in ["over", "scrolls", "small", "broken", "unmarked"] {
        assert_eq!(seen[fault], 0, "{fault}: {seen}");
    }
    // Those that tell what is marked.
    assert!(seen["tables"].as_u64().unwrap() > 0, "{seen}");
    assert_eq!(seen["page"], seen["width"], "{seen}");
}

#[test]
fn a_folder_that_cannot_be() {
    let output = Command::new(env!("CARGO_BIN_EXE_lab"))
        .args(["report", "--quick", "--out", "/dev/null/report"])
        .output()
        .unwrap();
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), message.lines().count()), (Some(2), 1), "{message}");
}
