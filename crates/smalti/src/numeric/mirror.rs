//! Reflection of indices beyond the ends of a row.

/// The index in `0..len` that reflection about the border assigns to `at`. The outermost sample is repeated
/// (… 1 0 | 0 1 … n−1 | n−1 n−2 …). Returns 0 for an empty row.
pub(crate) fn about_border(at: isize, len: usize) -> usize {
    if len == 0 {
        return 0;
    }
    let folded = at.rem_euclid(2 * len as isize) as usize;
    folded.min(2 * len - 1 - folded)
}

/// The index in `0..len` that reflection about the outermost sample assigns to `at`. That sample is not
/// repeated (… 2 1 | 0 1 … n−1 | n−2 …), so a mosaic of period 2 keeps its phase. Returns 0 for a row of at
/// most one sample.
pub(crate) fn about_outermost(at: isize, len: usize) -> usize {
    if len < 2 {
        return 0;
    }
    let period = 2 * (len - 1);
    let folded = at.rem_euclid(period as isize) as usize;
    folded.min(period - folded)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_mirrors_go_on_for_ever() {
        let places = |f: fn(isize, usize) -> usize| (-7..8).map(|i| f(i, 3)).collect::<Vec<_>>();
        assert_eq!(places(about_border), [0, 0, 1, 2, 2, 1, 0, 0, 1, 2, 2, 1, 0, 0, 1]);
        assert_eq!(places(about_outermost), [1, 2, 1, 0, 1, 2, 1, 0, 1, 2, 1, 0, 1, 2, 1]);
        assert_eq!([about_border(5, 0), about_border(-5, 1), about_outermost(9, 1)], [0; 3]);
    }
}
