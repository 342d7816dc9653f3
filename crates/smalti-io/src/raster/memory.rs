//! Memory for cubes.

use std::mem::MaybeUninit;

use super::kind::Sample;

/// Below this a buffer comes from memory that is in use already.
#[cfg(target_os = "linux")]
const LARGE_BYTES: usize = 4 << 20;

/// Zeros to be filled.
pub(crate) fn zeros<S: Sample>(len: usize) -> Vec<S> {
    let zeros = vec![S::default(); len];
    advise(zeros.as_ptr().cast(), size_of_val(zeros.as_slice()));
    zeros
}

/// An empty vector with room for so many samples. Where they are filled by several threads, none need first fill it with zeros.
pub(super) fn room<S: Sample>(len: usize) -> Vec<S> {
    let room: Vec<S> = Vec::with_capacity(len);
    advise(room.as_ptr().cast(), len * size_of::<S>());
    room
}

/// Zeros where nothing was written yet.
pub(super) fn filled<S: Sample>(room: &mut [MaybeUninit<S>]) -> &mut [S] {
    room.fill(MaybeUninit::new(S::default()));
    // SAFETY: every element has just been written, and `MaybeUninit<S>` lies in memory as `S` does.
    unsafe { &mut *(std::ptr::from_mut(room) as *mut [S]) }
}

/// Asks that a large buffer be of large pages, as NumPy's are: fresh memory in pages of 4 KiB takes longer to get than a cube to
/// read.
fn advise(begin: *const u8, bytes: usize) {
    #[cfg(target_os = "linux")]
    if bytes >= LARGE_BYTES {
        const PAGE: usize = 1 << 12;
        let skipped = begin.align_offset(PAGE);
        let whole = bytes.saturating_sub(skipped) / PAGE * PAGE;
        // SAFETY: the range lies within a buffer of the caller, and the advice changes no content. Where the system does not take
        // it, all is as it was.
        unsafe {
            libc::madvise(begin.add(skipped).cast_mut().cast(), whole, libc::MADV_HUGEPAGE);
        }
    }
    #[cfg(not(target_os = "linux"))]
    let _ = (begin, bytes);
}
