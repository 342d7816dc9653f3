//! Weights of the expected figures.

use super::expected::ExpectedError;

/// The weights of the figures of one condition in a sum.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FigureWeights {
    /// Of the CPSNR, per dB.
    pub cpsnr_db: f64,
    /// Of the detail, per dB.
    pub detail_db: f64,
    /// Of the mean CIEDE2000, per unit.
    pub delta_e_2000: f64,
    /// Of the mean difference that the eye sees, per unit.
    pub scielab: f64,
}

impl FigureWeights {
    /// The weighted sum of expected figures. A figure without a weight does not count, even if it was not computed.
    #[must_use]
    pub fn of(&self, expected: &ExpectedError) -> f64 {
        let part = |weight: f64, figure: f64| if weight == 0.0 { 0.0 } else { weight * figure };
        part(self.cpsnr_db, expected.cpsnr_db)
            + part(self.detail_db, expected.detail_db)
            + part(self.delta_e_2000, expected.delta_e_2000)
            + part(self.scielab, expected.scielab)
    }

    /// All weights times a factor.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        let Self { cpsnr_db, detail_db, delta_e_2000, scielab } = self;
        Self {
            cpsnr_db: cpsnr_db * factor,
            detail_db: detail_db * factor,
            delta_e_2000: delta_e_2000 * factor,
            scielab: scielab * factor,
        }
    }

    /// The sums of two sets of weights.
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            cpsnr_db: self.cpsnr_db + other.cpsnr_db,
            detail_db: self.detail_db + other.detail_db,
            delta_e_2000: self.delta_e_2000 + other.delta_e_2000,
            scielab: self.scielab + other.scielab,
        }
    }
}
