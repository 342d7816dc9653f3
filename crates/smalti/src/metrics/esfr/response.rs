//! The response of one edge.

use super::options::EdgeOrientation;

/// The response measured on an edge.
#[derive(Debug, Clone, PartialEq)]
pub struct EdgeSfr {
    /// Frequencies from 0 to at least 1 cycle per pixel along the lines, even steps.
    pub frequency_cy_per_px: Vec<f64>,
    /// Response at these frequencies; 1 at frequency 0.
    pub sfr: Vec<f64>,
    /// The first frequency at which the response is one half, linear between samples; `None` when it stays above.
    pub mtf50_cy_per_px: Option<f64>,
    /// Area under the response from half a cycle per pixel upwards, percent of the total area: detail that aliases on the pixel
    /// grid.
    pub aliasing_percent: f64,
    /// Orientation of the edge.
    pub orientation: EdgeOrientation,
    /// Angle to the columns (vertical edge) or rows (horizontal edge), −45 to 45, positive where the position
    /// grows with row or column.
    pub edge_angle_deg: f64,
    /// Michelson contrast of the two plateaus, 0 to 1.
    pub contrast: f64,
    /// RMS distance of the centroids from the fitted straight line, along the lines of pixels.
    pub fit_residual_px: f64,
    /// The edge profile in steps of a quarter pixel along the lines, in the unit of the image.
    pub esf: Vec<f64>,
    /// Position of the edge in `esf`, in steps.
    pub edge_at: f64,
}

impl EdgeSfr {
    /// The response at a frequency, linear between samples; `None` outside the measured range.
    #[must_use]
    pub fn mtf(&self, cy_per_px: f64) -> Option<f64> {
        let step = *self.frequency_cy_per_px.get(1)?;
        let at = cy_per_px / step;
        if !(at >= 0.0 && at <= (self.sfr.len() - 1) as f64) {
            return None;
        }
        let (low, share) = (at as usize, at.fract());
        let here = *self.sfr.get(low)?;
        let next = self.sfr.get(low + 1).copied().unwrap_or(here);
        Some(here + share * (next - here))
    }

    /// The first frequency at which the response falls to `level`, in cycles per pixel.
    #[must_use]
    pub fn frequency_at(&self, level: f64) -> Option<f64> {
        first_crossing(&self.frequency_cy_per_px, &self.sfr, level)
    }

    /// MTF50 in cycles per millimetre on a sensor of this pixel pitch.
    #[must_use]
    pub fn mtf50_cy_per_mm(&self, pitch_m: f64) -> Option<f64> {
        self.mtf50_cy_per_px.map(|f| cy_per_mm(f, pitch_m))
    }

    /// The frequencies in cycles per millimetre on a sensor of this pixel pitch.
    #[must_use]
    pub fn frequency_cy_per_mm(&self, pitch_m: f64) -> Vec<f64> {
        self.frequency_cy_per_px.iter().map(|&f| cy_per_mm(f, pitch_m)).collect()
    }
}

/// Cycles per pixel as cycles per millimetre.
fn cy_per_mm(cy_per_px: f64, pitch_m: f64) -> f64 {
    cy_per_px / (pitch_m * 1e3)
}

/// The first position where `values` falls to `level`, interpolated linearly.
pub(super) fn first_crossing(places: &[f64], values: &[f64], level: f64) -> Option<f64> {
    places.windows(2).zip(values.windows(2)).find_map(|(p, v)| match (p, v) {
        (&[p0, p1], &[v0, v1]) if v0 > level && v1 <= level => {
            Some(p0 + (p1 - p0) * (v0 - level) / (v0 - v1))
        }
        _ => None,
    })
}
