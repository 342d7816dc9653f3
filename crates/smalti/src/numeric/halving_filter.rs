//! Filters in the frequency domain whose result has half of the resolution: each sample is the mean of two by
//! two samples of the filtered plane.
//!
//! With N samples in a line, the mean of a sample and the next one multiplies bin k of the spectrum by
//! (1 + exp(2πik / N)) / 2. Taking every second mean folds the spectrum: bin k of the result is half of the sum
//! of the bins k and k + N / 2. The inverse transform is a quarter as large as that of the whole plane.

use rayon::prelude::*;

use super::fft::{Complex32, FftError, RealFft2, TASKS, Workspace};
use super::plane_filter::PlaneFilter;
use super::simd::{Kernel, dispatch};

/// A planned filter for planes of one size with even sides.
#[derive(Debug, Clone)]
pub(crate) struct HalvingFilter {
    fine: RealFft2,
    coarse: RealFft2,
    /// Factors of the bins of a column, and of those of a row.
    down: Vec<Complex32>,
    across: Vec<Complex32>,
}

/// Memory for one filter at a time.
pub(crate) struct HalvingWorkspace {
    fine: Workspace,
    coarse: Workspace,
}

impl HalvingFilter {
    /// Plans filters of `rows` × `cols` planes.
    ///
    /// # Errors
    /// When a side is zero or odd, or the spectrum would not fit the address space.
    pub(crate) fn new(rows: usize, cols: usize) -> Result<Self, FftError> {
        if !rows.is_multiple_of(2) || !cols.is_multiple_of(2) {
            return Err(FftError::Odd { rows, cols });
        }
        let factors = |len: usize| {
            let factor = |k: usize| {
                let (sin, cos) = (std::f64::consts::TAU * k as f64 / len as f64).sin_cos();
                Complex32::new(((1.0 + cos) / 4.0) as f32, (sin / 4.0) as f32)
            };
            (0..len).map(factor).collect()
        };
        let (fine, coarse) = (RealFft2::new(rows, cols)?, RealFft2::new(rows / 2, cols / 2)?);
        Ok(Self { fine, coarse, down: factors(rows), across: factors(cols) })
    }
}

impl PlaneFilter for HalvingFilter {
    type Workspace = HalvingWorkspace;

    fn workspace(&self) -> HalvingWorkspace {
        HalvingWorkspace { fine: self.fine.workspace(), coarse: self.coarse.workspace() }
    }

    /// The plane is that of `fill`, `passing` and `transfer`; the result has half of its rows and columns.
    fn filter(
        &self,
        work: &mut HalvingWorkspace,
        fill: impl Fn(usize, &mut [f32]) + Sync,
        passing: usize,
        transfer: impl Fn(usize, &mut [Complex32]) + Sync,
        (out, out_cols): (&mut [f32], usize),
        finish: impl Fn(f32) -> f32 + Sync,
    ) -> Result<(), FftError> {
        let Self { fine, coarse, down, across } = self;
        fine.check_workspace(&work.fine)?;
        coarse.check_workspace(&work.coarse)?;
        coarse.check_window(out.len(), out_cols)?;
        fine.filtered_columns(&mut work.fine, fill, passing, transfer, |column, _| {
            dispatch(FoldDown { column, factors: down });
        });
        let (rows, cols) = (coarse.rows(), coarse.cols());
        let by_col = &work.fine.by_col;
        let folded = |kx: usize| &by_col[kx * fine.rows()..][..rows];
        let per_task = coarse.half_cols().div_ceil(TASKS);
        let columns = work.coarse.by_col.par_chunks_mut(per_task * rows).zip(&mut work.coarse.tasks);
        columns.enumerate().for_each(|(task, (columns, scratch))| {
            for (i, column) in columns.chunks_exact_mut(rows).enumerate() {
                let kx = task * per_task + i;
                let factors = [across[kx], across[cols + kx]];
                dispatch(FoldAcross { column, low: folded(kx), opposite: folded(cols - kx), factors });
                coarse.col_inverse.process_with_scratch(column, &mut scratch.fft);
            }
        });
        coarse.inverse_rows(&mut work.coarse, out, out_cols, finish);
        Ok(())
    }
}

/// a · b + c · d.
#[inline(always)]
fn sum_of_products([a, b]: [Complex32; 2], [c, d]: [Complex32; 2]) -> Complex32 {
    let product = |a: Complex32, b: Complex32| [a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re];
    let ([re, im], [more_re, more_im]) = (product(a, b), product(c, d));
    Complex32::new(re + more_re, im + more_im)
}

/// Multiplies a column of the spectrum by factors and folds it into its first half.
struct FoldDown<'a> {
    column: &'a mut [Complex32],
    factors: &'a [Complex32],
}

impl Kernel for FoldDown<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let half = self.column.len() / 2;
        let (low, high) = self.column.split_at_mut(half);
        let (of_low, of_high) = self.factors.split_at(half);
        let factors = of_low.iter().zip(of_high);
        for ((low, high), (of_low, of_high)) in low.iter_mut().zip(high).zip(factors) {
            *low = sum_of_products([*low, *of_low], [*high, *of_high]);
        }
    }
}

/// Folds two columns into one: the spectrum at a horizontal bin, and in place of the bin `cols` beyond it the opposite bin, which has the
/// conjugate values at the opposite vertical bins because the plane is real.
struct FoldAcross<'a> {
    column: &'a mut [Complex32],
    low: &'a [Complex32],
    opposite: &'a [Complex32],
    factors: [Complex32; 2],
}

impl Kernel for FoldAcross<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { column, low, opposite, factors } = self;
        let folded = |low: Complex32, opposite: Complex32| {
            sum_of_products([low, factors[0]], [Complex32::new(opposite.re, -opposite.im), factors[1]])
        };
        // Bin 0 is its own opposite.
        let opposites = opposite.iter().skip(1).rev();
        for ((to, low), opposite) in column.iter_mut().zip(low).skip(1).zip(opposites) {
            *to = folded(*low, *opposite);
        }
        if let (Some(to), Some(low), Some(own)) = (column.first_mut(), low.first(), opposite.first()) {
            *to = folded(*low, *own);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::fft::tests::plane;
    use super::*;

    /// A transfer function with a phase, Hermitian along the columns of the half spectrum that are their own
    /// opposites.
    fn blur(rows: usize, cols: usize) -> impl Fn(usize, &mut [Complex32]) + Sync {
        move |kx, column| {
            for (ky, v) in column.iter_mut().enumerate() {
                let signed = if 2 * ky > rows { ky as f32 - rows as f32 } else { ky as f32 };
                let (x, y) = (kx as f32 / cols as f32, signed / rows as f32);
                let turn = if 2 * ky == rows || 2 * kx == cols { 0.0 } else { x + 2.0 * y };
                *v *= Complex32::from_polar((-3.0 * (x * x + y * y)).exp(), turn);
            }
        }
    }

    /// The result has the means of the samples that the filter of the whole plane has, with all bins and with some.
    #[test]
    fn means_are_those_of_the_filtered_plane() {
        for (rows, cols) in [(2, 2), (2, 12), (10, 6), (16, 24), (90, 70), (288, 40)] {
            let x = plane(rows, cols);
            let fill = |r: usize, row: &mut [f32]| row.copy_from_slice(&x[r * cols..][..cols]);
            let (whole, halved) =
                (RealFft2::new(rows, cols).unwrap(), HalvingFilter::new(rows, cols).unwrap());
            let (mut work, mut halved_work) = (whole.workspace(), halved.workspace());
            for passing in [usize::MAX, 3 * cols / 8 + 1, cols / 4 + 1, 1, 0] {
                let mut fine = vec![0.0; rows * cols];
                let transfer = blur(rows, cols);
                whole.filter(&mut work, fill, passing, &transfer, (&mut fine, cols), |v| v).unwrap();
                let (out_rows, out_cols) = (rows.div_ceil(4), (cols / 2).div_ceil(3));
                let mut coarse = vec![7.0; out_rows * out_cols];
                let out = (&mut coarse[..], out_cols);
                halved.filter(&mut halved_work, fill, passing, &transfer, out, |v| 2.0 * v).unwrap();
                for (i, v) in coarse.iter().enumerate() {
                    let first = 2 * (i / out_cols) * cols + 2 * (i % out_cols);
                    let four = [first, first + 1, first + cols, first + cols + 1].map(|at| fine[at]);
                    let expected = 2.0 * four.iter().sum::<f32>() / 4.0;
                    assert!((v - expected).abs() < 4e-6, "{rows} × {cols}, {passing}, {i}: {v} {expected}");
                }
            }
        }
    }

    #[test]
    fn threads_do_not_change_a_bit() {
        let (rows, cols) = (150, 132);
        let (x, halved) = (plane(rows, cols), HalvingFilter::new(rows, cols).unwrap());
        let with = |n| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
            let mut out = vec![0.0; rows * cols / 4];
            let fill = |r: usize, row: &mut [f32]| row.copy_from_slice(&x[r * cols..][..cols]);
            pool.install(|| {
                let (work, to) = (&mut halved.workspace(), (&mut out[..], cols / 2));
                halved.filter(work, fill, 50, blur(rows, cols), to, |v| v).unwrap();
            });
            out
        };
        assert_eq!(with(1), with(3));
    }

    #[test]
    fn wrong_sizes_are_refused() {
        for (rows, cols) in [(3, 4), (4, 3)] {
            assert_eq!(HalvingFilter::new(rows, cols).unwrap_err(), FftError::Odd { rows, cols });
        }
        assert!(HalvingFilter::new(0, 2).is_err());
        let halved = HalvingFilter::new(4, 6).unwrap();
        let run = |work: &mut HalvingWorkspace, out: &mut [f32], cols| {
            halved.filter(work, |_, _| (), 3, |_, _| (), (out, cols), |v| v)
        };
        let mut work = halved.workspace();
        for (len, cols) in [(6, 4), (5, 3), (9, 3), (0, 3), (6, 0)] {
            assert!(run(&mut work, &mut vec![0.0; len], cols).is_err(), "{len}, {cols}");
        }
        assert!(run(&mut work, &mut [0.0; 6], 3).is_ok());
        let mut other = HalvingFilter::new(4, 4).unwrap().workspace();
        assert!(run(&mut other, &mut [0.0; 6], 3).is_err());
    }
}
