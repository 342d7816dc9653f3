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
        if allowed(Set::Avx512) && has!("avx512f") && has!("avx512bw") && has!("avx512dq") && has!("avx512vl")
        {
            // SAFETY: the features that the function is compiled for were just found present.
            return unsafe { avx512(kernel) };
        }
        if allowed(Set::Avx2) && has!("avx2") {
            // SAFETY: as above.
            return unsafe { avx2(kernel) };
        }
    }
    kernel.run()
}

/// What [`dispatch`] chooses from, from the narrowest to the widest.
#[cfg(any(test, target_arch = "x86_64"))]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(not(test), allow(dead_code))]
pub(crate) enum Set {
    /// What any processor of the architecture runs.
    Plain,
    Avx2,
    Avx512,
}

/// Whether [`dispatch`] may choose a set: tests narrow the choice, so that every path runs that the machine has.
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

/// Keeps [`dispatch`], on all threads, to a set and narrower ones while `work` runs. All give the same bits, so that other tests
/// are slower meanwhile and no more.
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
    use crate::numeric::normal::normal_pair;
    use crate::numeric::poisson::{LANES, LaneCounter, poisson_lanes};

    /// A block of Poisson and normal numbers, at means of every size.
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
                // SAFETY: the feature was just found present.
                assert!(unsafe { avx2(Draw(row)) } == expected);
            }
        }
        // And so does every machine: a digest of what was drawn when this was written.
        let fold = |h: u64, v: u64| (h ^ v).wrapping_mul(0x0100_0000_01b3);
        let digest = (0..200).fold(0, |h, row| {
            let (counts, normals) = Draw(row).run();
            let h = counts.into_iter().fold(h, fold);
            normals.into_iter().fold(h, |h, v| fold(h, u64::from(v)))
        });
        assert_eq!(digest, 0xbafd_16e6_79b6_6427, "{digest:#x}");
    }
}
