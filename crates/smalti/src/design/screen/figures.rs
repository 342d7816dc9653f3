//! The figures that a screen computes.

/// The figures to compute.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Figures {
    /// The CPSNR alone, whose computation takes no time beside that of the error covariances.
    Cpsnr,
    /// The colour difference as well: 24 differences for each colour of each class, position and condition.
    Color,
    /// The difference that the eye sees as well, which takes about three times as long again.
    All,
}
