//! Lists of fixed room, without the panics of their own methods.

use heapless::Vec;

/// Removes the item at `index`, if there is one. The list's own `remove` panics otherwise.
pub(crate) fn remove<T, const ROOM: usize>(items: &mut Vec<T, ROOM>, index: usize) {
    let mut at = 0;
    items.retain(|_| {
        at += 1;
        at != index + 1
    });
}

/// Collects the first `ROOM` items. `collect` panics at one more.
pub(crate) fn first<T, const ROOM: usize>(items: impl Iterator<Item = T>) -> Vec<T, ROOM> {
    let mut vec = Vec::new();
    for item in items {
        if vec.push(item).is_err() {
            break;
        }
    }
    vec
}

/// Puts an item before the one at `index`, or at the end if there are fewer; a full list loses its last one. The list's own `insert` panics.
pub(crate) fn insert<T, const ROOM: usize>(items: &mut Vec<T, ROOM>, index: usize, item: T) {
    if items.is_full() && index < items.len() {
        let _ = items.pop();
    }
    if items.push(item).is_err() {
        return;
    }
    for at in (index.saturating_add(1)..items.len()).rev() {
        if let Some([before, here]) = items.get_mut(at - 1..=at) {
            core::mem::swap(before, here);
        }
    }
}
