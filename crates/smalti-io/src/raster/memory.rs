//! Memory for cubes.

use super::kind::Sample;

/// Below this a buffer comes from memory that is in use already.
#[cfg(target_os = "linux")]
const LARGE_BYTES: usize = 4 << 20;

/// Zeros to be filled. Large buffers are of large pages, as NumPy's are: fresh memory in pages of 4 KiB takes longer to
/// get than a cube to read.
pub(crate) fn zeros<S: Sample>(len: usize) -> Vec<S> {
    let zeros = vec![S::default(); len];
    #[cfg(target_os = "linux")]
    if size_of_val(zeros.as_slice()) >= LARGE_BYTES {
        const PAGE: usize = 1 << 12;
        let begin = zeros.as_ptr().cast::<u8>();
        let skipped = begin.align_offset(PAGE);
        let whole = size_of_val(zeros.as_slice()).saturating_sub(skipped) / PAGE * PAGE;
        // SAFETY: the range lies within the buffer, which is owned here, and the advice changes no content. Where the system
        // does not take it, all is as it was.
        unsafe {
            libc::madvise(begin.add(skipped).cast_mut().cast(), whole, libc::MADV_HUGEPAGE);
        }
    }
    zeros
}
