//! One place that picks the instruction set at run time.
//!
//! A kernel is plain code over arrays of fixed length. Compiled once per instruction set it becomes vector code,
//! and since nothing in it is reordered or contracted (Rust does neither), every set gives the same bits.

/// Work to be compiled for several instruction sets.
pub(crate) trait Kernel {
    /// Its result.
    type Output;
    /// The work. Must be `#[inline(always)]`, and so must all that it calls, to be compiled for the set chosen.
    fn run(self) -> Self::Output;
}

/// Runs a kernel with the widest instruction set of this machine.
#[inline]
pub(crate) fn dispatch<K: Kernel>(kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::is_x86_feature_detected as has;
        if has!("avx512f") && has!("avx512bw") && has!("avx512dq") && has!("avx512vl") {
            // SAFETY: the features that the function is compiled for were just found present.
            return unsafe { avx512(kernel) };
        }
        if has!("avx2") {
            // SAFETY: as above.
            return unsafe { avx2(kernel) };
        }
    }
    kernel.run()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl")]
fn avx512<K: Kernel>(kernel: K) -> K::Output {
    kernel.run()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn avx2<K: Kernel>(kernel: K) -> K::Output {
    kernel.run()
}
