//! A stack that outgrows its room ends at the fence, in a fault that is told.

use super::{boot, played};
use object::{Object, ObjectSection, ObjectSymbol};
use picket_host::board::Board;
use std::fs;
use std::path::Path;
use std::time::Duration;

/// `push {r0-r7, lr}`, and back to it.
const ENDLESS: [u8; 4] = [0xFF, 0xB5, 0xFD, 0xE7];

/// The image with a function in which the stack grows for ever, in place of the one that sends the status; and the stack's end.
fn overflowing(image: &Path) -> (Vec<u8>, u64) {
    let mut bytes = fs::read(image).unwrap();
    let file = object::File::parse(&*bytes).unwrap();
    let address = |name: &dyn Fn(&str) -> bool| {
        let mut symbols = file.symbols().filter(|symbol| symbol.name().is_ok_and(name));
        let symbol = symbols.next().unwrap();
        assert!(symbols.next().is_none());
        symbol.address()
    };
    let end = address(&|name| name == "_stack_end");
    // Its lowest bit says that it is Thumb code.
    let status = address(&|name| name.contains("send_status")) & !1;
    let text = file.section_by_name(".text").unwrap();
    let (offset, _) = text.file_range().unwrap();
    let at = (offset + status - text.address()) as usize;
    bytes[at..at + 4].copy_from_slice(&ENDLESS);
    (bytes, end)
}

#[test]
fn a_stack_overflow_ends_at_the_fence_and_is_told() {
    let (bytes, end) = overflowing(played());
    let image = Path::new(env!("CARGO_TARGET_TMPDIR")).join("overflowing.elf");
    fs::write(&image, bytes).unwrap();
    let mut board = Board::start(&image).unwrap();
    let first = boot(&mut board);
    assert_eq!(first.last.kind, 0);
    // A status comes each second, of a loop that something wakes: the emulated chip's timer does not.
    let second = (0..120).find_map(|_| {
        board.send(&[0]).unwrap();
        let mut said = std::iter::from_fn(|| board.hear(Duration::from_millis(500)).unwrap());
        said.find_map(|said| match said {
            picket_host::device::Said::Boot(boot) => Some(boot),
            _ => None,
        })
    });
    let second = second.unwrap();
    assert_eq!(second.last.kind, 5, "{second:?}");
    // The stack reached into the 256 bytes of the fence, by a push or by what the core stacks for the fault: no further.
    let [place, _] = second.last.more;
    println!("stack end {end:#x}, stopped at {place:#x}");
    assert!((end - 256 - 104..end).contains(&u64::from(place)), "{place:#x} {end:#x}");
    assert_eq!(end % 256, 0);
}
