//! Blocks of columns for vector code.
//!
//! Loops over arrays of a block's width become loops over whole registers, and the overhead per block is
//! small. Single vectors process the columns that remain at the end of a row.

/// Lanes of a vector: one AVX-512 register of `f32`.
pub(super) const LANES: usize = 16;
/// Columns of a block, four vectors.
pub(super) const BLOCK: usize = 4 * LANES;

/// An operation on `W` columns from `at`, with `W` a compile-time constant.
pub(super) trait Columns {
    /// Must be `#[inline(always)]`, so that it is compiled for the instruction set of its caller.
    fn columns<const W: usize>(&mut self, at: usize);
}

/// Processes the columns up to `len`, which is a multiple of the number of lanes.
#[inline(always)]
pub(super) fn each(len: usize, work: &mut impl Columns) {
    let mut at = 0;
    while at + BLOCK <= len {
        work.columns::<BLOCK>(at);
        at += BLOCK;
    }
    while at < len {
        work.columns::<LANES>(at);
        at += LANES;
    }
}

/// The values of a line from `at`. Lines are padded so that enough values exist.
#[inline(always)]
pub(super) fn values<T, const W: usize>(line: &[T], at: usize) -> Option<&[T; W]> {
    line.get(at..).and_then(|l| l.first_chunk())
}

/// Like [`values`], but mutable.
#[inline(always)]
pub(super) fn values_mut<T, const W: usize>(line: &mut [T], at: usize) -> Option<&mut [T; W]> {
    line.get_mut(at..).and_then(|l| l.first_chunk_mut())
}

/// Adds the values of a line that begin at the `taps` columns from `at`.
#[inline(always)]
pub(super) fn add_taps<const W: usize>(total: &mut [f32; W], line: &[f32], at: usize, taps: usize) {
    for tap in 0..taps {
        let Some(values) = values::<f32, W>(line, at + tap) else { return };
        for i in 0..W {
            total[i] += values[i];
        }
    }
}

/// Period, in columns, of a tile and the blocks together: the least common multiple of the two widths. The
/// block width is a power of two.
pub(super) fn run_of(tile_cols: usize) -> usize {
    tile_cols << (BLOCK.trailing_zeros() - tile_cols.trailing_zeros().min(BLOCK.trailing_zeros()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// How often each column is visited.
    struct Visits(Vec<u32>);

    impl Columns for Visits {
        fn columns<const W: usize>(&mut self, at: usize) {
            self.0[at..at + W].iter_mut().for_each(|n| *n += 1);
        }
    }

    #[test]
    fn every_column_is_visited_once() {
        for len in (0..=3 * BLOCK).step_by(LANES) {
            let mut visits = Visits(vec![0; len]);
            each(len, &mut visits);
            assert!(visits.0.iter().all(|n| *n == 1), "{len}");
        }
    }

    #[test]
    fn a_run_is_the_shortest_of_whole_tiles_and_blocks() {
        for tile in 1..=130 {
            let shortest = (BLOCK..).step_by(BLOCK).find(|run| run % tile == 0);
            assert_eq!(Some(run_of(tile)), shortest, "{tile}");
        }
    }

    #[test]
    fn taps_are_summed_within_the_line() {
        let line: Vec<f32> = (0..40).map(|i| (i * i) as f32).collect();
        let mut total = [1.0; LANES];
        add_taps(&mut total, &line, 3, 5);
        for (i, sum) in total.iter().enumerate() {
            assert_eq!(*sum, 1.0 + line[3 + i..][..5].iter().sum::<f32>());
        }
        assert_eq!(values::<f32, LANES>(&line, 24).map(|v| v[15]), Some(39.0 * 39.0));
        assert!(values::<f32, LANES>(&line, 25).is_none() && values::<f32, LANES>(&line, 41).is_none());
        assert!(values_mut::<f32, LANES>(&mut [0.0; 15], 0).is_none());
    }
}
