//! Tests of Picket that need more than one module; see `tests/`.

use std::path::{Path, PathBuf};

/// A file of the reference material, which lies beside the repository or where `PICKET_SHARED` says. Where it
/// is absent a test can only say that it was skipped: `None`, and that line is printed.
pub fn shared(name: &str) -> Option<PathBuf> {
    let beside = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared");
    let folder = std::env::var("PICKET_SHARED").unwrap_or(beside.into());
    let path = Path::new(&folder).join(name);
    if !path.exists() {
        println!("skipped: no ../shared/{name}");
        return None;
    }
    Some(path)
}
