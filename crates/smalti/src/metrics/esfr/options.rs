//! Options of the measurement.

/// Orientation of the edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EdgeOrientation {
    /// Nearly along the columns, with the two sides left and right.
    Vertical,
    /// Nearly along the rows, with the two sides above and below.
    Horizontal,
}

/// The direction in which frequencies are measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FrequencyAxis {
    /// Perpendicular to the edge (ISO 12233:2017 and later).
    EdgeNormal,
    /// Along the lines of pixels, as in older software and ISETCam: lower by the cosine of the edge angle.
    PixelLines,
}

/// Position of the window that locates the edge on a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CentroidWindow {
    /// Centred on the edge.
    OnEdge,
    /// As in Burns's sfrmat 2–3 and ISETCam: offset by half a pixel and one line, with the first difference counted twice. The
    /// fitted slope changes by about 1e-4, which is negligible on a clean edge. On a demosaicked edge whose slope is near a ratio
    /// of small integers (7:3), samples move to other bins, and MTF50 of a colour channel changes by up to 2 %.
    Sfrmat,
}

/// Options of the measurement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EsfrOptions {
    /// The direction in which frequencies are measured.
    pub frequency_axis: FrequencyAxis,
    /// Position of the window that locates the edge.
    pub centroid_window: CentroidWindow,
    /// Whether the response of the discrete derivative, sinc(f / 2) with f in cycles per pixel, is divided out.
    pub derivative_correction: bool,
    /// Whether the profile is corrected to first order for samples that are unevenly distributed within their bins, as at slopes
    /// near a ratio of small integers. The correction is not in the standard. It reduces the error of the response fourfold at
    /// 1:7 and 3:7 and has no effect at other slopes.
    pub place_correction: bool,
    /// The least accepted Michelson contrast of the edge, above 0.
    pub minimum_contrast: f64,
}

impl Default for EsfrOptions {
    /// Perpendicular to the edge, window on the edge, both corrections, contrast at least 0.05.
    fn default() -> Self {
        Self {
            frequency_axis: FrequencyAxis::EdgeNormal,
            centroid_window: CentroidWindow::OnEdge,
            derivative_correction: true,
            place_correction: true,
            minimum_contrast: 0.05,
        }
    }
}

impl EsfrOptions {
    /// The options of `ISO12233` in ISETCam 2021, for comparison with published results: frequency along the lines, and no
    /// derivative correction. MTF50 is lower by the cosine of the angle and by the response of the derivative.
    #[must_use]
    pub fn isetcam() -> Self {
        Self {
            frequency_axis: FrequencyAxis::PixelLines,
            centroid_window: CentroidWindow::Sfrmat,
            derivative_correction: false,
            place_correction: false,
            ..Self::default()
        }
    }
}
