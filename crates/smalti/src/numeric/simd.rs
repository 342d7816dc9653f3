//! Selection of the instruction set at run time.
//!
//! A kernel is plain code over arrays of fixed length. It is compiled once per instruction set and becomes
//! vector code. Rust neither reorders nor contracts floating-point operations, so every instruction set gives
//! the same bits.

/// Code to compile for several instruction sets.
pub(crate) trait Kernel {
    /// Its result.
    type Output;
    /// The computation. It and everything that it calls must be `#[inline(always)]` to be compiled for the
    /// selected set.
    fn run(self) -> Self::Output;
}

/// Runs a kernel with the widest instruction set of this machine.
#[inline]
pub(crate) fn dispatch<K: Kernel>(kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    {
        if has_avx512() {
            // SAFETY: the required features were detected.
            return unsafe { avx512(kernel) };
        }
        if allowed(Set::Avx2) && is_x86_feature_detected!("avx2") {
            // SAFETY: as above.
            return unsafe { avx2(kernel) };
        }
    }
    kernel.run()
}

/// Whether the processor has AVX-512 with its instructions for 16-bit and short vectors.
#[cfg(target_arch = "x86_64")]
#[inline]
pub(crate) fn has_avx512() -> bool {
    use std::arch::is_x86_feature_detected as has;
    allowed(Set::Avx512) && has!("avx512f") && has!("avx512bw") && has!("avx512dq") && has!("avx512vl")
}

/// Whether the processor has AVX2 and multiplies and adds in one step.
#[cfg(target_arch = "x86_64")]
#[inline]
pub(crate) fn has_avx2_and_fma() -> bool {
    allowed(Set::Avx2) && is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma")
}

/// The choices of [`dispatch`], from the narrowest to the widest.
#[cfg(any(test, target_arch = "x86_64"))]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(not(test), allow(dead_code))]
pub(crate) enum Set {
    /// The baseline of the architecture.
    Plain,
    Avx2,
    Avx512,
}

/// Whether [`dispatch`] may select a set. Tests restrict the choice in order to run every path of the
/// machine.
#[cfg(all(target_arch = "x86_64", not(test)))]
#[inline]
fn allowed(_: Set) -> bool {
    true
}

#[cfg(test)]
static WIDEST: std::sync::atomic::AtomicU8 = std::sync::atomic::AtomicU8::new(Set::Avx512 as u8);

#[cfg(all(target_arch = "x86_64", test))]
fn allowed(set: Set) -> bool {
    set as u8 <= WIDEST.load(std::sync::atomic::Ordering::Relaxed)
}

/// Restricts [`dispatch`] on all threads to a set and narrower ones while `work` runs. All sets give the same
/// bits, so tests that run concurrently only become slower.
#[cfg(test)]
pub(crate) fn with_widest<T>(set: Set, work: impl FnOnce() -> T) -> T {
    use std::sync::atomic::Ordering;
    static ONE: std::sync::Mutex<()> = std::sync::Mutex::new(());
    let _one_at_a_time = ONE.lock();
    WIDEST.store(set as u8, Ordering::Relaxed);
    let result = work();
    WIDEST.store(Set::Avx512 as u8, Ordering::Relaxed);
    result
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::arithmetic::digest;
    use crate::numeric::normal::normal_pair;
    use crate::numeric::poisson::{LANES, LaneCounter, poisson_lanes};

    /// A block of Poisson and normal deviates, at means of every size.
    struct Draw(u32);

    impl Kernel for Draw {
        type Output = ([u64; LANES], [u32; LANES]);

        #[inline(always)]
        fn run(self) -> Self::Output {
            let counter = LaneCounter { key: [1, 2], first: 0, row: self.0, purpose: 3, attempt: 0 };
            let words = counter.block();
            let mut means = [0.0; LANES];
            let scale = 0.003 * f64::from(self.0 * self.0);
            for (i, m) in means.iter_mut().enumerate() {
                *m = scale * i as f64;
            }
            poisson_lanes(&counter, [&words[0], &words[1]], &mut means);
            let mut normals = [0; LANES];
            for (n, (a, b)) in normals.iter_mut().zip(words[2].iter().zip(&words[3])) {
                *n = normal_pair(*a, *b).0.to_bits();
            }
            (means.map(f64::to_bits), normals)
        }
    }

    #[test]
    fn every_instruction_set_gives_the_same_bits() {
        for row in 0..200 {
            let expected = Draw(row).run();
            assert!(dispatch(Draw(row)) == expected);
            #[cfg(target_arch = "x86_64")]
            if std::arch::is_x86_feature_detected!("avx2") {
                // SAFETY: the feature was detected above.
                assert!(unsafe { avx2(Draw(row)) } == expected);
            }
        }
        // Every machine gives the same bits: the digest was recorded when this test was written.
        let digest = digest((0..200).flat_map(|row| {
            let (counts, normals) = Draw(row).run();
            counts.into_iter().chain(normals.map(u64::from))
        }));
        assert_eq!(digest, 0x942f_d4c1_05c5_5016, "{digest:#x}");
    }
    #[cfg(target_arch = "x86_64")]
    #[test]
    fn tests_restrict_the_choice_of_the_machine() {
        use std::arch::is_x86_feature_detected as has;
        let all = [has!("avx512f"), has!("avx512bw"), has!("avx512dq"), has!("avx512vl")];
        assert_eq!(with_widest(Set::Avx512, has_avx512), all == [true; 4]);
        assert!(!with_widest(Set::Avx2, has_avx512) && !with_widest(Set::Plain, has_avx512));
    }
}
