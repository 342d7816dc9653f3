//! The search for values that are not valid, among many that are.

use super::simd::{Kernel, dispatch};

/// Values that are tested without a branch, because nearly all are valid.
const TESTED_AT_ONCE: usize = 4096;

/// The place of the first value that is not valid.
pub(crate) fn first_invalid(values: &[f32], is_valid: impl Fn(f32) -> bool) -> Option<usize> {
    let any_invalid = |values| dispatch(AnyInvalid { values, is_valid: &is_valid });
    let piece = values.chunks(TESTED_AT_ONCE).position(any_invalid)?;
    let first = piece * TESTED_AT_ONCE;
    values[first..].iter().position(|v| !is_valid(*v)).map(|i| first + i)
}

/// Whether any of some values is not valid.
struct AnyInvalid<'a, F> {
    values: &'a [f32],
    is_valid: &'a F,
}

impl<F: Fn(f32) -> bool> Kernel for AnyInvalid<'_, F> {
    type Output = bool;

    #[inline(always)]
    fn run(self) -> bool {
        // Flags as wide as the values, so that a vector of values gives one of flags.
        self.values.iter().fold(0u32, |found, v| found | u32::from(!(self.is_valid)(*v))) != 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_invalid_value_is_found_wherever_it_is() {
        let mut values = vec![1.0; 2 * TESTED_AT_ONCE + 5];
        assert_eq!(first_invalid(&values, f32::is_finite), None);
        for at in [2 * TESTED_AT_ONCE + 4, TESTED_AT_ONCE, TESTED_AT_ONCE - 1, 7, 0] {
            values[at] = f32::NAN;
            assert_eq!(first_invalid(&values, f32::is_finite), Some(at));
        }
        assert_eq!(first_invalid(&[], f32::is_finite), None);
    }
}
