//! `picket watch` and the NUCLEO's real image, which runs on rsemu's model of the chip, with a pseudo terminal between them.

#[path = "../../host-tests/tests/rsemu/board.rs"]
#[allow(dead_code)]
mod board;
#[path = "../../host-tests/tests/rsemu/source.rs"]
mod source;

use board::Emulated;
use picket_wire::settings::Settings;
use serialport::{SerialPort, TTYPort};
use std::fs;
use std::io::{Read, Write};
use std::path::PathBuf;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

/// Runs `picket watch` on a board until it ends: the board's time passes at most as fast as the host's.
fn watch(board: &mut Emulated, port: &mut TTYPort, name: &str, arguments: &[&str]) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_picket"))
        .args(["watch", name])
        .args(arguments)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let begun = Instant::now();
    while running(&mut child) {
        assert!(begun.elapsed() < Duration::from_secs(60), "{arguments:?}: it does not end");
        let mut bytes = [0; 512];
        if let Ok(count @ 1..) = port.read(&mut bytes) {
            board.hear(&bytes[..count]);
        }
        let sent = board.sent.len();
        board.run(2_000);
        let said = board.sent[sent..].to_vec();
        // Nobody reads any more when it ends.
        let _ = port.write_all(&said);
        board.sent.clear();
    }
    child.wait_with_output().unwrap()
}

fn running(child: &mut Child) -> bool {
    child.try_wait().unwrap().is_none()
}

/// What is printed can be sent back, settings are kept over the restart that they cause, and orders are repeated until the
/// board, deaf meanwhile, has answered.
#[test]
fn settings_go_round() {
    let rounds = if std::env::var_os("PICKET_LONG").is_some() { 50 } else { 1 };
    for start in [true, false] {
        let settings = Settings { start, ..Settings::default() };
        let Some((mut board, _)) = Emulated::start(&settings) else { return };
        let (mut ours, theirs) = TTYPort::pair().unwrap();
        ours.set_timeout(Duration::from_millis(1)).unwrap();
        let name = theirs.name().unwrap();
        let file = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("round-{start}.json"));
        let mut rate = 500e3;
        for round in 0..rounds {
            let got = watch(&mut board, &mut ours, &name, &["--get-settings"]);
            let (out, err) =
                (String::from_utf8(got.stdout).unwrap(), String::from_utf8(got.stderr).unwrap());
            assert!(got.status.success(), "{err}");
            let mut json: serde_json::Value =
                serde_json::from_str(&out).unwrap_or_else(|error| panic!("{error}: {out}"));
            assert!((json["rate_hz"].as_f64().unwrap() - rate).abs() < 1.0, "round {round}: {out}");
            rate = [250e3, 500e3][round % 2];
            json["rate_hz"] = rate.into();
            fs::write(&file, json.to_string()).unwrap();
            let path = file.to_str().unwrap();
            let set = watch(&mut board, &mut ours, &name, &["--set-settings", path, "--save"]);
            let told = String::from_utf8(set.stderr).unwrap();
            assert!(set.status.success() && told.contains("--save: done"), "round {round}: {told}");
            let kept = board.sectors().settings().unwrap();
            assert!((kept.config.rate_hz - rate).abs() < 1.0 && kept.start == start, "{kept:?}");
        }
        assert!(board.resets.iter().all(|(_, cause)| cause == "software"), "{:?}", board.resets);
    }
}
