//! Pointers of a C program, checked before anything is read or written.

use crate::status::Status;

/// Memory of the caller that holds a `T` once it is initialised, which its mark says.
#[repr(C, align(8))]
pub struct Slot<T> {
    mark: u64,
    value: T,
}

impl<T> Slot<T> {
    /// What another kind of value, other lengths and memory that was never initialised do not have: "picket" and a number of each type.
    const fn mark(number: u16) -> u64 {
        u64::from_le_bytes(*b"picket\0\0") | (number as u64) << 48
    }

    /// The memory, whatever it holds, if a value may be written there.
    pub fn place(memory: *mut Self) -> Result<*mut Self, Status> {
        aligned(memory).map(|()| memory)
    }

    /// Writes a value, and the mark of its type's number.
    ///
    /// # Safety
    /// The memory, which [`Slot::place`] gave, is the caller's, and as large as a slot.
    #[inline(always)]
    pub unsafe fn write(memory: *mut Self, number: u16, value: T) {
        // SAFETY: not NULL and aligned, as `place` has checked; as large as a slot, as the caller promises. What it holds before is
        // bytes, which need not be dropped.
        unsafe {
            (&raw mut (*memory).value).write(value);
            (&raw mut (*memory).mark).write(Self::mark(number));
        }
    }

    /// The value in initialised memory.
    ///
    /// # Safety
    /// If it is not NULL, the memory is as large as a slot, and nothing else uses it until the call returns.
    pub unsafe fn open<'a>(memory: *mut Self, number: u16) -> Result<&'a mut T, Status> {
        aligned(memory)?;
        // SAFETY: aligned and large enough. Volatile, because what was never written has any value, and the compiler must not reason
        // about it.
        let mark = unsafe { (&raw const (*memory).mark).read_volatile() };
        if mark != Self::mark(number) {
            return Err(Status::Uninitialised);
        }
        // SAFETY: the mark says that `write` wrote a value of this type there; the caller promises that nobody else uses it.
        Ok(unsafe { &mut (*memory).value })
    }
}

/// An error unless a value can be at this address.
fn aligned<T>(pointer: *const T) -> Result<(), Status> {
    if pointer.is_null() {
        Err(Status::Null)
    } else if !pointer.is_aligned() {
        Err(Status::Unaligned)
    } else {
        Ok(())
    }
}

/// What a pointer points to.
///
/// # Safety
/// If it is neither NULL nor unaligned, it points to a `T` that is not written until the call returns.
pub unsafe fn read<'a, T>(pointer: *const T) -> Result<&'a T, Status> {
    aligned(pointer)?;
    // SAFETY: checked, and promised by the caller.
    Ok(unsafe { &*pointer })
}

/// So many values that a pointer points to.
///
/// # Safety
/// As for [`read`], of all of them.
pub unsafe fn read_all<'a, T>(pointer: *const T, count: usize) -> Result<&'a [T], Status> {
    aligned(pointer)?;
    // SAFETY: checked, and promised by the caller.
    Ok(unsafe { core::slice::from_raw_parts(pointer, count) })
}

/// What a pointer points to, or `None` for NULL.
///
/// # Safety
/// As for [`read`].
pub unsafe fn read_if<'a, T>(pointer: *const T) -> Result<Option<&'a T>, Status> {
    if pointer.is_null() {
        return Ok(None);
    }
    // SAFETY: promised by the caller.
    unsafe { read(pointer) }.map(Some)
}

/// Where an answer goes.
pub struct Out<T>(*mut T);

impl<T> Out<T> {
    /// A place for an answer.
    pub fn at(pointer: *mut T) -> Result<Self, Status> {
        aligned(pointer).map(|()| Self(pointer))
    }

    /// Writes the answer.
    ///
    /// # Safety
    /// The memory is the caller's, and as large as a `T`.
    pub unsafe fn put(self, answer: T) {
        // SAFETY: `at` has checked NULL and alignment; the size is promised.
        unsafe { self.0.write(answer) };
    }

    /// All of so many places, which hold numbers.
    ///
    /// # Safety
    /// The memory is the caller's, holds numbers of any value, has room for so many `T`, and nothing else uses it while the slice lives.
    pub unsafe fn all<'a>(self, count: usize) -> &'a mut [T] {
        // SAFETY: `at` has checked NULL and alignment; the rest is promised.
        unsafe { core::slice::from_raw_parts_mut(self.0, count) }
    }

    /// Writes the answer of this number.
    ///
    /// # Safety
    /// The memory is the caller's, and has room for more `T` than the number.
    pub unsafe fn put_at(&mut self, number: usize, answer: T) {
        // SAFETY: promised by the caller.
        unsafe { self.0.add(number).write(answer) };
    }

    /// Writes as many answers as there is room for. Returns how many.
    ///
    /// # Safety
    /// The memory is the caller's, and has room for this many `T`.
    pub unsafe fn put_all(mut self, room: usize, answers: impl Iterator<Item = T>) -> usize {
        let mut count = 0;
        for answer in answers.take(room) {
            // SAFETY: the number is below the room that is promised.
            unsafe { self.put_at(count, answer) };
            count += 1;
        }
        count
    }
}
