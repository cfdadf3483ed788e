//! `cargo picket report --quick`: every file is there, whole, and every figure within its bar.

use std::fs;
use std::path::PathBuf;
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
    let output = Command::new(env!("CARGO_BIN_EXE_picket"))
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
    assert!(page.ends_with("</body></html>\n") && page.matches("<h2").count() == 15);
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
}

#[test]
fn a_folder_that_cannot_be() {
    let output = Command::new(env!("CARGO_BIN_EXE_picket"))
        .args(["report", "--quick", "--out", "/dev/null/report"])
        .output()
        .unwrap();
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), message.lines().count()), (Some(2), 1), "{message}");
}
