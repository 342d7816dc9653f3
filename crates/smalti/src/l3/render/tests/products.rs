//! The products alone, on allocations without spare memory, so that Miri and the address sanitizer detect every access beyond their end.

use super::super::super::vectors::PIXELS;
use super::super::fixed::Entry;
use super::super::simd::Rendering;
use super::super::table::{Run, Table, registers_of};
use super::*;

/// Distinct kernels of a table.
const KERNELS: usize = 5;

/// Products with the kernels of a table, on every instruction set, for patches of every side, one to four outputs, and numbers of pixels below, at and
/// above those of a vector. `entry` is what a run states for the first register of a kernel.
fn check<S: Rendering>(mut value: impl FnMut() -> S, entry: impl Fn(usize) -> u32) {
    for side in [3, 5, 7, 9, 11] {
        for (outputs, count) in [(1, 1usize), (2, 15), (3, 16), (4, 37)] {
            let mut values = |n: usize| -> Vec<S> { (0..n).map(|_| value()).collect() };
            let weights = values(KERNELS * outputs * side * side);
            let offsets = values(KERNELS * outputs * S::CONSTANTS.len());
            let offset = |i: usize| offsets[i * S::CONSTANTS.len()..][..S::CONSTANTS.len()].to_vec();
            let (table, places) = Table::new(&weights, offset, side, outputs, 1.0);
            assert_eq!(table.registers.len(), KERNELS * outputs * registers_of::<S>(side));
            let padded = count.next_multiple_of(PIXELS);
            let patches = values((padded + side - 1) * side).into_boxed_slice();
            let kernels: Box<[u32]> =
                (0..padded).map(|x| entry(places[(3 * x + 4) % KERNELS] as usize)).collect();
            // From the third pixel of the planes to their end.
            let run = Run { table: &table, patches: &patches, kernels: &kernels, at: 2, count };
            let products = |set: Set| {
                let mut planes = vec![vec![-1.0f32; 2 + count].into_boxed_slice(); outputs];
                let mut views: Vec<&mut [f32]> = planes.iter_mut().map(|p| &mut **p).collect();
                with_widest(set, || S::products(&run, &mut views));
                planes
            };
            let expected = products(Set::Plain);
            assert!(expected.iter().all(|p| p[..2] == [-1.0; 2] && p[2..].iter().all(|v| *v != -1.0)));
            for set in [Set::Avx2, Set::Avx512] {
                assert_eq!(
                    products(set),
                    expected,
                    "patch {side}, {outputs} outputs, {count} pixels, {set:?}"
                );
            }
        }
    }
}

#[test]
fn products_read_and_write_within_their_memory() {
    let mut random = Stream::new(7, 8, 9);
    check(|| random.uniform() as f32 - 0.5, |place| place as u32);
    // No sum of 123 such products overflows.
    check(|| (random.next_u32() as i16) >> 4, |place| Entry::new(place as u32, 3).unwrap().0);
}

/// Vectors read no patches that are one element short; the element exists in memory.
#[cfg(target_arch = "x86_64")]
#[test]
fn vectors_refuse_patches_that_are_too_short() {
    use super::super::super::vectors::Avx512;
    use super::super::x86::{products_f32, products_i16};

    const SIDE: usize = 5;
    let count = 2 * PIXELS;
    let kernels = vec![0; count];
    let size = (count + SIDE - 1) * SIDE;
    with_widest(Set::Avx512, || {
        let Some(set) = Avx512::detect() else { return };
        for missing in [0, 1] {
            let mut planes = [vec![-1.0f32; count], vec![-1.0f32; count]];
            let [float, fixed] = &mut planes;
            let (table, _) = Table::new(&[1.0f32; SIDE * SIDE], |_| vec![0.0], SIDE, 1, 1.0);
            let mut patches = vec![1.0f32; size];
            patches.truncate(size - missing);
            let run = Run { table: &table, patches: &patches, kernels: &kernels, at: 0, count };
            products_f32(set, &run, &mut [&mut float[..]]);
            let (table, _) = Table::new(&[1i16; SIDE * SIDE], |_| vec![0, 0], SIDE, 1, 1.0);
            let mut patches = vec![1i16; size];
            patches.truncate(size - missing);
            let run = Run { table: &table, patches: &patches, kernels: &kernels, at: 0, count };
            products_i16(set, &run, &mut [&mut fixed[..]]);
            let expected = if missing == 0 { (SIDE * SIDE) as f32 } else { -1.0 };
            assert!(planes.iter().flatten().all(|v| *v == expected), "{missing} missing");
        }
    });
}
