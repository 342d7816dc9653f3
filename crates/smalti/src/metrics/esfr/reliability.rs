//! Whether an MTF50 says what it seems to say.

use serde::Serialize;

use super::response::EdgeSfr;

/// The sampling limit of the pixel grid (Nyquist frequency), cycles per pixel. The pixels of a mosaic sample together, so that its limit for
/// detail without colour is that of the grid.
pub const NYQUIST_CY_PER_PX: f64 = 0.5;
/// Levels above and below one half between which the steepness of the fall is measured.
const AROUND_HALF: [f64; 2] = [0.55, 0.45];
/// The widest range of frequencies between these levels, in units of MTF50: twice that of a response that falls linearly to zero.
const WIDEST: f64 = 0.4;

/// Whether an MTF50 can be trusted as a resolution.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Mtf50Reliability {
    /// The response falls through one half once and steeply, below the sampling limit.
    Reliable,
    /// MTF50 lies beyond the sampling limit: detail that fine is aliased and not resolved.
    BeyondNyquist,
    /// The response stays near one half over a wide range of frequencies or rises above it again, as after sharpening or strong interpolation
    /// errors. A small change of the response moves MTF50 far.
    Plateau,
    /// The picture shows no straight edge, as after strong interpolation errors, so that MTF50 is not a number.
    NoEdge,
}

impl Mtf50Reliability {
    /// Its name in results.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Reliable => "reliable",
            Self::BeyondNyquist => "beyond-nyquist",
            Self::Plateau => "plateau",
            Self::NoEdge => "no-edge",
        }
    }
}

impl EdgeSfr {
    /// Whether MTF50 can be trusted, for a sampling limit such as [`NYQUIST_CY_PER_PX`]; `None` without an MTF50.
    ///
    /// It is [`Plateau`](Mtf50Reliability::Plateau) when the response takes more than 0.4 of MTF50 to fall from 55 % to
    /// 45 %, never falls to 45 %, or is above 55 % again at a frequency between MTF50 and the limit.
    #[must_use]
    pub fn mtf50_reliability(&self, nyquist_cy_per_px: f64) -> Option<Mtf50Reliability> {
        let mtf50 = self.mtf50_cy_per_px?;
        if mtf50 > nyquist_cy_per_px {
            return Some(Mtf50Reliability::BeyondNyquist);
        }
        let [above, below] = AROUND_HALF.map(|level| self.frequency_at(level));
        let steep = above.zip(below).is_some_and(|(above, below)| below - above <= WIDEST * mtf50);
        let after = |f: f64| f > mtf50 && f <= nyquist_cy_per_px;
        let mut later = self.frequency_cy_per_px.iter().zip(&self.sfr).filter(|(f, _)| after(**f));
        let rises = later.any(|(_, v)| *v > AROUND_HALF[0]);
        Some(if steep && !rises { Mtf50Reliability::Reliable } else { Mtf50Reliability::Plateau })
    }
}
