//! The option bytes of a chip as it comes from the factory: only the image that is built for it writes them.

use crate::board::{Emulated, built, image};
use crate::self_test;
use picket_host::board::image as build;
use picket_wire::boot::{Boot, Clock};
use std::path::Path;
use std::sync::OnceLock;

/// FLASH_OPTCR, locked: as it comes, and with the brown-out level of 2.7 V.
const OPTCR: u32 = 0x4002_3C14;
const FACTORY: u32 = 0x0FFF_AAED;
const SET: u32 = 0x0FFF_AAE1;

/// A board with a chip as it comes, at its first power-up.
fn first(image: &Path) -> Emulated {
    let mut board = Emulated::plug_with(image);
    board.order(&format!("options {FACTORY:#x}"));
    board
}

fn measures(boot: &Boot) {
    assert!(boot.measuring && boot.clock == Clock::External, "{boot:?}");
}

#[test]
fn the_usual_image_leaves_the_option_bytes_alone() {
    let board = first(image());
    let (mut board, boot) = board.power();
    measures(&boot);
    board.run(50_000);
    assert_eq!(board.read(OPTCR), FACTORY);
    board.assert_rules();
}

#[test]
fn the_image_that_is_built_for_it_sets_the_level_once() {
    static IMAGE: OnceLock<std::path::PathBuf> = OnceLock::new();
    let image = built(&IMAGE, || build(false, true));
    let board = first(image);
    let (mut board, boot) = board.power();
    measures(&boot);
    assert_eq!(board.read(OPTCR), SET);
    board.assert_rules();
    // The chip keeps it, and the image finds it set.
    let (mut board, boot) = board.power();
    measures(&boot);
    board.run(50_000);
    assert_eq!((board.read(OPTCR), board.resets.len()), (SET, 0));
    board.assert_rules();
}

/// The self-test tells the word, and writes none.
#[test]
fn the_self_test_tells_a_level_that_is_not_set() {
    let mut board = first(image());
    board.order("oscillator 1");
    let (mut board, _) = board.power();
    let told = self_test::line(&mut board, "option word");
    let wanted = "- [x] option word 0fffaaed: a reset below 2.7 V is not set, picket flash --brown-out sets it";
    assert_eq!((told.as_str(), board.read(OPTCR)), (wanted, FACTORY));
}
