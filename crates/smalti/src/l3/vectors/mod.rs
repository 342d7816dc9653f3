//! What the inner loops of both stages share: aligned registers, inputs laid out for them, and the order in which lanes are summed.

mod portable;
#[cfg(test)]
mod tests;
#[cfg(target_arch = "x86_64")]
mod x86;

pub(super) use portable::{PIXELS, Register, tree};
#[cfg(target_arch = "x86_64")]
pub(super) use x86::{Avx512, for_side, quarters_f32, quarters_i32, store, whole_f32, whole_i32};

/// `out[x * lines + i] = lines[i][x]` for at least `columns` columns. Lines extend a register beyond the last column.
pub(super) fn interleave_f32(lines: &[&[f32]], columns: usize, out: &mut Vec<f32>) {
    #[cfg(target_arch = "x86_64")]
    if let Some(set) = Avx512::detect() {
        return set.interleave_f32(lines, columns, out);
    }
    portable::interleave(lines, columns, out);
}

/// As [`interleave_f32`].
pub(super) fn interleave_i16(lines: &[&[i16]], columns: usize, out: &mut Vec<i16>) {
    #[cfg(target_arch = "x86_64")]
    if let Some(set) = Avx512::detect() {
        return set.interleave_i16(lines, columns, out);
    }
    portable::interleave(lines, columns, out);
}
