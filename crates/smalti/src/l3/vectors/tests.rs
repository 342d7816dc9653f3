//! Lines in allocations without spare memory, so that Miri and the address sanitizer detect every access beyond their end.

use super::*;
use crate::numeric::simd::{Set, with_widest};

/// Miri lacks the permutations of AVX-512. The address sanitizer runs them.
const SETS: &[Set] = if cfg!(miri) { &[Set::Plain] } else { &[Set::Plain, Set::Avx512] };

/// Interleaves lines of every number and width on every instruction set. Lines are as long as a whole number of registers, or one element
/// shorter.
fn check<S: Copy + Default + PartialEq + std::fmt::Debug>(
    lanes: usize,
    interleave: fn(&[&[S]], usize, &mut Vec<S>),
    mut value: impl FnMut() -> S,
) {
    let mut out = Vec::new();
    for (count, columns) in
        (1..=11usize).flat_map(|n| [1usize, 15, 16, 31, 33, 48].map(|columns| (n, columns)))
    {
        let padded = columns.next_multiple_of(lanes);
        for len in [padded, padded - 1] {
            let lines: Vec<Box<[S]>> = (0..count).map(|_| (0..len).map(|_| value()).collect()).collect();
            let lines: Vec<&[S]> = lines.iter().map(|line| &**line).collect();
            let at = |i: usize| lines[i % count].get(i / count).copied().unwrap_or_default();
            let expected: Vec<S> = (0..columns * count).map(at).collect();
            for &set in SETS {
                with_widest(set, || interleave(&lines, columns, &mut out));
                let found = out.get(..expected.len());
                assert_eq!(found, Some(&*expected), "{count} lines of {len}, {columns} columns, {set:?}");
            }
        }
    }
}

#[test]
fn lines_of_any_number_and_length_are_interleaved() {
    let mut number = 0;
    let mut next = || {
        number += 1;
        number
    };
    check(16, interleave_f32, || next() as f32);
    check(32, interleave_i16, || next() as i16);
}

#[test]
fn registers_are_their_lanes() {
    let mut registers = [Register([1.0f32; 16]), Register([2.0; 16]), Register([3.0; 16])];
    Register::flat_mut(&mut registers)[31] = 4.0;
    assert_eq!(registers[1].0[15], 4.0);
    let expected: Vec<f32> = registers.iter().flat_map(|register| register.0).collect();
    assert_eq!(Register::flat(&registers), expected);
    assert!(Register::<f32, 16>::flat(&[]).is_empty());
}

/// Lines that end within longer memory: what follows an end is not read.
#[test]
fn lines_end_where_they_end() {
    fn check<S: Copy + Default + PartialEq + std::fmt::Debug>(
        interleave: fn(&[&[S]], usize, &mut Vec<S>),
        memory: &[Vec<S>],
    ) {
        let (columns, mut out) = (memory[0].len(), Vec::new());
        for count in 1..=memory.len() {
            for len in [0, 17, 31, 34, columns - 1, columns] {
                let lines: Vec<&[S]> = memory.iter().take(count).map(|line| &line[..len]).collect();
                let at = |i: usize| lines[i % count].get(i / count).copied().unwrap_or_default();
                let expected: Vec<S> = (0..columns * count).map(at).collect();
                for &set in SETS {
                    with_widest(set, || interleave(&lines, columns, &mut out));
                    assert_eq!(out, expected, "{count} lines of {len}, {set:?}");
                }
            }
        }
    }
    let numbers: Vec<Vec<i16>> = (0..11).map(|line| (0..96).map(|i| 1 + 100 * line + i).collect()).collect();
    check(interleave_i16, &numbers);
    let single = numbers.iter().map(|line| line.iter().map(|v| f32::from(*v)).collect());
    check(interleave_f32, &single.collect::<Vec<_>>());
}

/// Patches at every side, in lines that end with the last sample of the last patch, and room for exactly as many. Copying ends before a patch beyond
/// the lines.
#[cfg(target_arch = "x86_64")]
#[test]
fn patches_are_copied_row_by_row() {
    let Some(set) = Avx512::detect().filter(|_| SETS.contains(&Set::Avx512)) else { return };
    for side in [3usize, 5, 7, 9, 11] {
        for (step, starts) in [(side + 4, vec![0, 3, 4, 1]), (40, vec![7, 0, 29])] {
            let last = starts.iter().copied().max().unwrap();
            let len = last + (side - 1) * step + side;
            let lines: Box<[f32]> = (0..len).map(|i| (i % 97) as f32 - 20.5).collect();
            let stride = (1 + side * side).next_multiple_of(8);
            let mut out: Box<[f64]> = vec![f64::NAN; (starts.len() + 1) * stride].into();
            let with_one_beyond = starts.iter().copied().chain([last + 1]);
            set.copy_patches(side, (&lines, step), with_one_beyond, (&mut out, stride));
            for (start, z) in starts.iter().zip(out.chunks_exact(stride)) {
                let sample = |i: usize| f64::from(lines[start + i / side * step + i % side]);
                let patch: Vec<f64> = (0..side * side).map(sample).collect();
                assert!(z[0] == 1.0 && z[1..=side * side] == patch, "{side}, {step}, {start}");
                assert!(z[1 + side * side..].iter().all(|v| *v == 0.0), "{side}");
            }
            assert!(out[starts.len() * stride..].iter().all(|v| v.is_nan()), "{side}");
            let mut short: Box<[f64]> = vec![f64::NAN; stride - 8].into();
            set.copy_patches(side, (&lines, step), [0].into_iter(), (&mut short, stride));
            assert!(short.iter().all(|v| v.is_nan()), "{side}");
        }
    }
}
