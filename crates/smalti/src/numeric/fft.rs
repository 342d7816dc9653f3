//! Two-dimensional Fourier transforms of real image planes.
//!
//! Rows are transformed with `realfft` and columns with `rustfft`. Between the two, the half spectrum is
//! transposed in tiles one cache line wide, so that both passes access contiguous memory. The spectrum stays
//! transposed: value `(ky, kx)` is stored at `kx * rows + ky`, with `kx` in `0..cols / 2 + 1` and `ky` in
//! `0..rows`.
//!
//! The forward transform is not normalised; the inverse divides by `rows * cols`, so that it recovers the
//! plane. One thread computes each row and column in a fixed order: results have the same bits for any number
//! of threads.

use std::sync::Arc;

use rayon::prelude::*;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use rustfft::{Fft, FftPlanner};
use thiserror::Error;

use super::transpose::{TILE, transpose};
pub use rustfft::num_complex::Complex32;

/// Number of tasks that one pass is split into; also the maximum number of threads that work on one plane.
pub(super) const TASKS: usize = 16;

/// Errors of a transform.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum FftError {
    /// The plane is empty or too large to address.
    #[error("cannot transform a plane of {rows} × {cols}: expected at least 1 × 1 and an addressable size")]
    Size {
        /// Rows.
        rows: usize,
        /// Columns.
        cols: usize,
    },
    /// Only planes with even sides can be halved.
    #[error("cannot halve a plane of {rows} × {cols}: expected even numbers of rows and columns")]
    Odd {
        /// Rows.
        rows: usize,
        /// Columns.
        cols: usize,
    },
    /// A buffer has the wrong length.
    #[error("{what}: expected {expected} values, got {got}")]
    Length {
        /// Which buffer.
        what: &'static str,
        /// Values it should have.
        expected: usize,
        /// Values it has.
        got: usize,
    },
}

/// The smallest even length of at least `n` whose prime factors are 2, 3 and 5, for which the transform is
/// fast.
#[must_use]
pub fn fast_len(n: usize) -> usize {
    let smooth = |n: usize| {
        let mut m = n;
        for p in [2, 3, 5] {
            while m.is_multiple_of(p) {
                m /= p;
            }
        }
        m == 1
    };
    // Lengths beyond addressable memory are not searched.
    if n > usize::MAX / 4 {
        return n;
    }
    let mut even = n.max(2).next_multiple_of(2);
    while !smooth(even) {
        even += 2;
    }
    even
}

/// Frequency of bin `k` of a transform of `len` samples, cycles per sample, in −0.5 to 0.5. The Nyquist bin
/// counts as positive.
#[must_use]
pub fn bin_frequency(k: usize, len: usize) -> f64 {
    if k <= len / 2 { k as f64 / len as f64 } else { -((len - k.min(len)) as f64 / len as f64) }
}

/// A planned transform for planes of one size. Plan it once; use it for many planes from any thread.
#[derive(Clone)]
pub struct RealFft2 {
    rows: usize,
    cols: usize,
    row_forward: Arc<dyn RealToComplex<f32>>,
    row_inverse: Arc<dyn ComplexToReal<f32>>,
    col_forward: Arc<dyn Fft<f32>>,
    pub(super) col_inverse: Arc<dyn Fft<f32>>,
}

/// Memory for one transform at a time, about three times the size of the plane. See [`RealFft2::workspace`].
pub struct Workspace {
    /// Half spectrum of the rows, row-major.
    by_row: Vec<Complex32>,
    /// Half spectrum of the plane, transposed.
    pub(super) by_col: Vec<Complex32>,
    pub(super) tasks: Vec<TaskScratch>,
}

pub(super) struct TaskScratch {
    real: Vec<f32>,
    tile: Vec<Complex32>,
    pub(super) fft: Vec<Complex32>,
}

impl std::fmt::Debug for RealFft2 {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("RealFft2").field("rows", &self.rows).field("cols", &self.cols).finish_non_exhaustive()
    }
}

impl RealFft2 {
    /// Plans transforms of `rows` × `cols` planes. Any size works; sizes from [`fast_len`] are fast.
    ///
    /// # Errors
    /// When a side is zero, or the spectrum would not fit the address space.
    pub fn new(rows: usize, cols: usize) -> Result<Self, FftError> {
        // Two half spectra of 8-byte values, with a margin.
        let bytes = rows.checked_mul(cols).and_then(|n| n.checked_mul(32));
        if rows == 0 || cols == 0 || bytes.is_none_or(|b| b > isize::MAX as usize) {
            return Err(FftError::Size { rows, cols });
        }
        let mut real = RealFftPlanner::new();
        let mut complex = FftPlanner::new();
        Ok(Self {
            rows,
            cols,
            row_forward: real.plan_fft_forward(cols),
            row_inverse: real.plan_fft_inverse(cols),
            col_forward: complex.plan_fft_forward(rows),
            col_inverse: complex.plan_fft_inverse(rows),
        })
    }

    /// Rows of the plane.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Columns of the plane.
    #[must_use]
    pub fn cols(&self) -> usize {
        self.cols
    }

    /// Columns of the half spectrum, `cols / 2 + 1`.
    #[must_use]
    pub fn half_cols(&self) -> usize {
        self.cols / 2 + 1
    }

    /// Allocates the memory for a transform. Each plane that is processed concurrently needs its own.
    #[must_use]
    pub fn workspace(&self) -> Workspace {
        let zero = Complex32::default();
        let half = self.half_cols();
        let fft = [
            self.row_forward.get_scratch_len(),
            self.row_inverse.get_scratch_len(),
            self.col_forward.get_inplace_scratch_len(),
            self.col_inverse.get_inplace_scratch_len(),
        ];
        let fft = fft.into_iter().max().unwrap_or(0);
        let task = || TaskScratch {
            real: vec![0.0; self.cols],
            tile: vec![zero; TILE * half],
            fft: vec![zero; fft],
        };
        Workspace {
            by_row: vec![zero; half * self.rows],
            by_col: vec![zero; half * self.rows],
            tasks: (0..TASKS).map(|_| task()).collect(),
        }
    }

    /// The spectrum of a row-major plane.
    ///
    /// # Errors
    /// When `plane` does not have `rows * cols` values.
    pub fn forward(&self, plane: &[f32]) -> Result<Vec<Complex32>, FftError> {
        check("the plane", self.rows * self.cols, plane.len())?;
        let mut work = self.workspace();
        self.forward_rows(&mut work, |r, row| row.copy_from_slice(&plane[r * self.cols..][..self.cols]));
        self.columns(&mut work, |_, col, scratch| self.col_forward.process_with_scratch(col, scratch));
        Ok(work.by_col)
    }

    /// The plane of a spectrum: the inverse of [`RealFft2::forward`].
    ///
    /// # Errors
    /// When `spectrum` does not have `rows * (cols / 2 + 1)` values.
    pub fn inverse(&self, spectrum: &[Complex32]) -> Result<Vec<f32>, FftError> {
        check("the spectrum", self.rows * self.half_cols(), spectrum.len())?;
        let mut work = self.workspace();
        work.by_col.copy_from_slice(spectrum);
        work.by_col.par_chunks_mut(self.rows * TILE).for_each(|columns| self.col_inverse.process(columns));
        let mut plane = vec![0.0; self.rows * self.cols];
        self.inverse_rows(&mut work, &mut plane, self.cols, |v| v);
        Ok(plane)
    }

    /// Filters a plane in the frequency domain without allocating memory beyond `work`.
    ///
    /// `fill(r, row)` writes input row `r` (all `cols` values). `transfer(kx, column)` modifies the spectrum
    /// at horizontal bin `kx` in place, one value per vertical bin. `finish` converts the upper left
    /// `out.len() / out_cols` rows × `out_cols` columns of the result into `out`. Horizontal bins from
    /// `passing` on are taken to be zero and are skipped.
    ///
    /// # Errors
    /// When `work` was made for another size, or `out` is not a window of the plane.
    pub fn filter(
        &self,
        work: &mut Workspace,
        fill: impl Fn(usize, &mut [f32]) + Sync,
        passing: usize,
        transfer: impl Fn(usize, &mut [Complex32]) + Sync,
        (out, out_cols): (&mut [f32], usize),
        finish: impl Fn(f32) -> f32 + Sync,
    ) -> Result<(), FftError> {
        self.check_workspace(work)?;
        self.check_window(out.len(), out_cols)?;
        self.filtered_columns(work, fill, passing, transfer, |col, scratch| {
            self.col_inverse.process_with_scratch(col, scratch);
        });
        self.inverse_rows(work, out, out_cols, finish);
        Ok(())
    }

    /// An error unless a workspace was made for this size.
    pub(super) fn check_workspace(&self, work: &Workspace) -> Result<(), FftError> {
        check("the workspace", self.rows * self.half_cols(), work.by_col.len())?;
        let tile = work.tasks.first().map_or(0, |t| t.tile.len());
        check("columns of the workspace", self.half_cols() * TILE, tile)
    }

    /// An error unless `len` values in rows of `cols` are a window of the plane.
    pub(super) fn check_window(&self, len: usize, cols: usize) -> Result<(), FftError> {
        let window = cols.saturating_mul(self.rows);
        let fits = (1..=self.cols).contains(&cols) && (1..=window).contains(&len);
        if fits && len.is_multiple_of(cols) {
            return Ok(());
        }
        Err(FftError::Length { what: "the output window", expected: window, got: len })
    }

    /// The spectrum of the filled rows, as [`RealFft2::filter`] modifies it, in `by_col`. `work_on(column, scratch)` follows `transfer` on
    /// each column. Those from `passing` on are zero.
    pub(super) fn filtered_columns(
        &self,
        work: &mut Workspace,
        fill: impl Fn(usize, &mut [f32]) + Sync,
        passing: usize,
        transfer: impl Fn(usize, &mut [Complex32]) + Sync,
        work_on: impl Fn(&mut [Complex32], &mut [Complex32]) + Sync,
    ) {
        self.forward_rows(work, fill);
        self.columns(work, |kx, col, scratch| {
            if kx >= passing {
                col.fill(Complex32::default());
                return;
            }
            self.col_forward.process_with_scratch(col, scratch);
            transfer(kx, col);
            work_on(col, scratch);
        });
    }

    /// Row transforms into `by_row`.
    fn forward_rows(&self, work: &mut Workspace, fill: impl Fn(usize, &mut [f32]) + Sync) {
        let half = self.half_cols();
        let per_task = self.rows.div_ceil(TASKS);
        work.by_row.par_chunks_mut(per_task * half).zip(&mut work.tasks).enumerate().for_each(
            |(task, (rows, scratch))| {
                for (i, row) in rows.chunks_exact_mut(half).enumerate() {
                    fill(task * per_task + i, &mut scratch.real);
                    // This fails only on wrong lengths, and the lengths are fixed by the plan.
                    let done =
                        self.row_forward.process_with_scratch(&mut scratch.real, row, &mut scratch.fft);
                    debug_assert!(done.is_ok());
                }
            },
        );
    }

    /// Transposes `by_row` into `by_col` and runs `work_on(kx, column, scratch)` on every column.
    fn columns(
        &self,
        work: &mut Workspace,
        work_on: impl Fn(usize, &mut [Complex32], &mut [Complex32]) + Sync,
    ) {
        let (rows, half) = (self.rows, self.half_cols());
        // Each task takes whole tiles, so that no two tasks share a cache line.
        let per_task = half.div_ceil(TASKS).next_multiple_of(TILE);
        let by_row = &work.by_row;
        work.by_col.par_chunks_mut(per_task * rows).zip(&mut work.tasks).enumerate().for_each(
            |(task, (cols, scratch))| {
                for (t, tile) in cols.chunks_mut(TILE * rows).enumerate() {
                    let kx = task * per_task + t * TILE;
                    transpose(&by_row[kx..], half, tile, rows, tile.len() / rows);
                    for (i, col) in tile.chunks_exact_mut(rows).enumerate() {
                        work_on(kx + i, col, &mut scratch.fft);
                    }
                }
            },
        );
    }

    /// Row transforms of `by_col` into the upper left window of the plane, `out_cols` wide.
    pub(super) fn inverse_rows(
        &self,
        work: &mut Workspace,
        out: &mut [f32],
        out_cols: usize,
        finish: impl Fn(f32) -> f32 + Sync,
    ) {
        let (rows, half) = (self.rows, self.half_cols());
        let scale = 1.0 / (rows as f32 * self.cols as f32);
        let out_rows = out.len() / out_cols;
        let per_task = out_rows.div_ceil(TASKS).next_multiple_of(TILE);
        let by_col = &work.by_col;
        out.par_chunks_mut(per_task * out_cols).zip(&mut work.tasks).enumerate().for_each(
            |(task, (out, scratch))| {
                for (t, out) in out.chunks_mut(TILE * out_cols).enumerate() {
                    let r = task * per_task + t * TILE;
                    let count = out.len() / out_cols;
                    let tile = &mut scratch.tile[..count * half];
                    transpose(&by_col[r..], rows, tile, half, count);
                    for (row, out) in tile.chunks_exact_mut(half).zip(out.chunks_exact_mut(out_cols)) {
                        // The row of a real plane is real at this bin; the imaginary part is rounding error.
                        row[0].im = 0.0;
                        if self.cols.is_multiple_of(2) {
                            row[half - 1].im = 0.0;
                        }
                        let done =
                            self.row_inverse.process_with_scratch(row, &mut scratch.real, &mut scratch.fft);
                        debug_assert!(done.is_ok());
                        for (o, &v) in out.iter_mut().zip(&scratch.real) {
                            *o = finish(v * scale);
                        }
                    }
                }
            },
        );
    }
}

fn check(what: &'static str, expected: usize, got: usize) -> Result<(), FftError> {
    if expected == got { Ok(()) } else { Err(FftError::Length { what, expected, got }) }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub(in super::super) fn plane(rows: usize, cols: usize) -> Vec<f32> {
        (0..rows * cols).map(|i| ((i * 7919 + i * i % 31) % 101) as f32 / 101.0 - 0.3).collect()
    }

    fn close(a: &[f32], b: &[f32], tolerance: f32) {
        assert_eq!(a.len(), b.len());
        for (x, y) in a.iter().zip(b) {
            assert!((x - y).abs() <= tolerance, "{x} {y}");
        }
    }

    /// Sizes with odd, prime and single sides, and with more rows than tasks.
    const SIZES: [(usize, usize); 8] =
        [(1, 1), (1, 8), (9, 1), (2, 2), (7, 13), (16, 24), (33, 20), (150, 131)];

    #[test]
    fn matches_the_sum_that_defines_it() {
        for (rows, cols) in [(7, 13), (8, 6), (1, 5), (11, 20)] {
            let x = plane(rows, cols);
            let got = RealFft2::new(rows, cols).unwrap().forward(&x).unwrap();
            for kx in 0..cols / 2 + 1 {
                for ky in 0..rows {
                    let mut sum = (0.0f64, 0.0f64);
                    for r in 0..rows {
                        for c in 0..cols {
                            let turn = (kx * c) as f64 / cols as f64 + (ky * r) as f64 / rows as f64;
                            let (s, co) = (-std::f64::consts::TAU * turn).sin_cos();
                            let v = f64::from(x[r * cols + c]);
                            sum = (sum.0 + v * co, sum.1 + v * s);
                        }
                    }
                    let g = got[kx * rows + ky];
                    assert!((f64::from(g.re) - sum.0).abs() < 1e-4 && (f64::from(g.im) - sum.1).abs() < 1e-4);
                }
            }
        }
    }

    #[test]
    fn inverse_undoes_forward() {
        for (rows, cols) in SIZES {
            let x = plane(rows, cols);
            let fft = RealFft2::new(rows, cols).unwrap();
            close(&fft.inverse(&fft.forward(&x).unwrap()).unwrap(), &x, 2e-6);
        }
    }

    #[test]
    fn a_filter_of_one_is_the_identity_on_any_window() {
        for (rows, cols) in SIZES {
            let x = plane(rows, cols);
            let fft = RealFft2::new(rows, cols).unwrap();
            let mut work = fft.workspace();
            let (out_rows, out_cols) = (rows.div_ceil(2), cols.div_ceil(3));
            let mut out = vec![0.0; out_rows * out_cols];
            let fill = |r: usize, row: &mut [f32]| row.copy_from_slice(&x[r * cols..][..cols]);
            for _ in 0..2 {
                fft.filter(&mut work, fill, usize::MAX, |_, _| (), (&mut out, out_cols), |v| v).unwrap();
            }
            let want: Vec<f32> =
                x.chunks(cols).take(out_rows).flat_map(|row| row[..out_cols].iter().copied()).collect();
            close(&out, &want, 2e-6);
        }
    }

    #[test]
    fn no_passing_bins_leave_nothing() {
        let fft = RealFft2::new(6, 10).unwrap();
        let mut out = vec![1.0; 60];
        let mut work = fft.workspace();
        fft.filter(&mut work, |_, row| row.fill(1.0), 0, |_, _| (), (&mut out, 10), |v| v).unwrap();
        assert!(out.iter().all(|&v| v == 0.0));
    }

    #[test]
    fn threads_do_not_change_a_bit() {
        let x = plane(150, 131);
        let fft = RealFft2::new(150, 131).unwrap();
        let with = |n| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
            pool.install(|| fft.inverse(&fft.forward(&x).unwrap()).unwrap())
        };
        assert_eq!(with(1), with(3));
    }

    #[test]
    fn wrong_sizes_are_refused() {
        assert!(RealFft2::new(0, 4).is_err());
        assert!(RealFft2::new(usize::MAX, 4).is_err());
        let fft = RealFft2::new(4, 4).unwrap();
        assert!(fft.forward(&[0.0; 15]).is_err());
        assert!(fft.inverse(&[Complex32::default(); 13]).is_err());
        let mut other = RealFft2::new(4, 6).unwrap().workspace();
        let mut out = [0.0; 16];
        let run = |work: &mut Workspace, out: &mut [f32], cols| {
            fft.filter(work, |_, _| (), 3, |_, _| (), (out, cols), |v| v)
        };
        assert!(run(&mut other, &mut out, 4).is_err());
        let mut work = fft.workspace();
        for cols in [0, 5, 3] {
            assert!(run(&mut work, &mut out, cols).is_err());
        }
        assert!(run(&mut work, &mut [], 4).is_err());
        assert!(run(&mut work, &mut out, 4).is_ok());
    }

    #[test]
    fn fast_lengths() {
        for (n, want) in [(0, 2), (1, 2), (7, 8), (641, 648), (1281, 1296), (1280, 1280)] {
            assert_eq!(fast_len(n), want);
        }
    }

    #[test]
    fn bins_have_signed_frequencies() {
        let f: Vec<f64> = (0..4).map(|k| bin_frequency(k, 4)).collect();
        assert_eq!(f, [0.0, 0.25, 0.5, -0.25]);
        assert_eq!(bin_frequency(2, 5), 0.4);
        assert_eq!(bin_frequency(3, 5), -0.4);
    }
    #[test]
    fn fast_lengths_are_the_shortest_of_their_factors() {
        let mut all = Vec::new();
        for a in 1..12 {
            for b in 0..7 {
                all.extend((0..5).map(|c| 2usize.pow(a) * 3usize.pow(b) * 5usize.pow(c)));
            }
        }
        for n in 0..2000 {
            assert_eq!(Some(fast_len(n)), all.iter().copied().filter(|len| *len >= n).min());
        }
        // No plane is as long as that.
        assert_eq!(fast_len(usize::MAX), usize::MAX);
        assert_eq!(fast_len(usize::MAX - 2), usize::MAX - 2);
    }
}
