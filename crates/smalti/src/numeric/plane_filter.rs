//! What filters in the frequency domain have in common.

use super::fft::{Complex32, FftError, RealFft2, Workspace};

/// A planned filter for planes of one size.
pub(crate) trait PlaneFilter: Sync {
    /// Memory for one filter at a time.
    type Workspace;

    /// Allocates the memory. Each plane that is processed concurrently needs its own.
    fn workspace(&self) -> Self::Workspace;

    /// As [`RealFft2::filter`].
    ///
    /// # Errors
    /// When `work` was made for another size, or `out` is not a window of the result.
    fn filter(
        &self,
        work: &mut Self::Workspace,
        fill: impl Fn(usize, &mut [f32]) + Sync,
        passing: usize,
        transfer: impl Fn(usize, &mut [Complex32]) + Sync,
        out: (&mut [f32], usize),
        finish: impl Fn(f32) -> f32 + Sync,
    ) -> Result<(), FftError>;
}

impl PlaneFilter for RealFft2 {
    type Workspace = Workspace;

    fn workspace(&self) -> Workspace {
        self.workspace()
    }

    fn filter(
        &self,
        work: &mut Workspace,
        fill: impl Fn(usize, &mut [f32]) + Sync,
        passing: usize,
        transfer: impl Fn(usize, &mut [Complex32]) + Sync,
        out: (&mut [f32], usize),
        finish: impl Fn(f32) -> f32 + Sync,
    ) -> Result<(), FftError> {
        self.filter(work, fill, passing, transfer, out, finish)
    }
}
