//! What is printed, on either stream.

use crate::end;
use std::io::{ErrorKind, Write};
use std::sync::atomic::{AtomicU64, Ordering};

/// What a file says of itself, short enough for a message.
pub fn short(text: &str) -> String {
    excerpt(text, 60)
}

/// The first this many characters, and what would move a terminal's cursor as a sign: a message stays what it is, whatever it quotes.
fn excerpt(text: &str, most: usize) -> String {
    let shown = |character: char| if character.is_control() { '\u{fffd}' } else { character };
    let mut words: String = text.chars().take(most).map(shown).collect();
    if text.chars().nth(most).is_some() {
        words += "...";
    }
    words
}

/// An error as it is printed: its lines, none of them longer than anybody reads.
pub(super) fn printed(message: &str) -> String {
    const LINES: usize = 100;
    let lines: Vec<String> = message.lines().take(LINES).map(|line| excerpt(line, 2000)).collect();
    lines.join("\n")
}

/// The decimals that show two digits of one standard deviation.
pub fn decimals(sigma: f64) -> usize {
    // Casts saturate.
    (1.0 - sigma.log10().floor()).clamp(0.0, 9.0) as usize
}

/// A value and its standard deviation, with two digits of this.
pub fn figures(value: f64, sigma: f64) -> [String; 2] {
    let digits = decimals(sigma);
    [value, sigma].map(|number| format!("{number:.digits$}"))
}

/// A word as a shell takes it.
pub fn quoted(word: &str) -> String {
    let plain =
        !word.is_empty() && word.chars().all(|c| c.is_alphanumeric() || "-_./,+:".contains(c));
    if plain { word.into() } else { format!("'{}'", word.replace('\'', "'\\''")) }
}

/// Prints a line on stdout.
pub fn print_line(line: &str) {
    print(&format!("{line}\n"));
}

/// Prints on stdout. When the reader has gone (`| head`), the program ends quietly; when stdout takes no more (a full disk), it
/// ends with exit code 1 and says how much was written.
pub fn print(text: &str) {
    static LINES: AtomicU64 = AtomicU64::new(0);
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Ok(()) => {
            LINES.fetch_add(text.lines().count() as u64, Ordering::Relaxed);
        }
        Err(error) if error.kind() == ErrorKind::BrokenPipe => end::leave(0),
        Err(error) => {
            let lines = LINES.load(Ordering::Relaxed);
            let _ = writeln!(
                std::io::stderr(),
                "error: stdout: {error}; {lines} lines were written before"
            );
            end::leave(1)
        }
    }
}

/// A file's name on one line: what would break it is escaped.
pub fn name(file: &std::path::Path) -> String {
    let escaped = |letter: char| match letter.is_control() {
        true => letter.escape_debug().to_string(),
        false => letter.to_string(),
    };
    file.display().to_string().chars().map(escaped).collect()
}
