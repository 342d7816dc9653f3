//! Spatial frequency response from a slanted edge (e-SFR), in the manner of ISO 12233 ([iso12233]) and
//! P. D. Burns (2000), "Slanted-edge MTF for digital camera and scanner analysis", IS&T PICS.
//!
//! An edge that is a little slanted is met by every line of pixels at another phase; all lines together sample
//! its profile much finer than the pixels do. On each line the edge is located by the centroid of the windowed
//! derivative; a straight line is fitted, and fitted again with windows centred on it. Every sample is
//! projected along that line into bins of a quarter pixel. The derivative of this profile, windowed, is the
//! line spread; the modulus of its Fourier transform, 1 at frequency 0, is the response.
//!
//! [iso12233]: https://www.iso.org/standard/71696.html

mod edge;
mod region;
mod spectrum;

pub use region::find_edge_region;

use super::patch::check_region;
use super::{MetricError, Rect};
use crate::numeric::Planes;
use crate::sensor::{RawImage, RawSamples, Sampling};

/// Which way the edge runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EdgeOrientation {
    /// Nearly along the columns: dark and bright lie left and right.
    Vertical,
    /// Nearly along the rows: dark and bright lie above and below.
    Horizontal,
}

/// The direction in which frequencies are counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FrequencyAxis {
    /// Across the edge, at right angles to it: the frequency the lens sees (ISO 12233:2017 and later).
    EdgeNormal,
    /// Along the lines of pixels, as older software and ISETCam count it: lower by the cosine of the edge's angle.
    PixelLines,
}

/// How the window that locates the edge on a line is laid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CentroidWindow {
    /// Centred on the edge.
    OnEdge,
    /// As in Burns's sfrmat 2–3 and ISETCam: half a pixel off and a line ahead, the first difference counted twice.
    /// The fitted slope changes by some 1e-4. That is nothing on a clean edge; on a demosaicked one whose slope
    /// is near a ratio of small numbers (7:3) it moves samples over the edges of bins, and MTF50 of a colour
    /// channel changes by up to 2 %.
    Sfrmat,
}

/// How an edge is measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EsfrOptions {
    /// The direction in which frequencies are counted.
    pub frequency_axis: FrequencyAxis,
    /// How the window that locates the edge is laid.
    pub centroid_window: CentroidWindow,
    /// Whether the response of the discrete derivative, sinc(f / 2) with f in cycles per pixel, is divided out.
    pub derivative_correction: bool,
    /// Whether the profile is corrected to first order for samples that do not lie evenly within their bins, as happens
    /// when the slope is near a ratio of small numbers. Beyond the standard; it changes nothing at other slopes, and
    /// at 1:7 or 3:7 it lowers the error of the response fourfold.
    pub place_correction: bool,
    /// The least accepted Michelson contrast of the edge, above 0.
    pub minimum_contrast: f64,
}

impl Default for EsfrOptions {
    /// Across the edge, window on the edge, derivative and places corrected; contrast at least 0.05.
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
    /// As ISETCam's `ISO12233` of 2021 has it: frequency along the lines, derivative not corrected. For comparison
    /// with published figures; its MTF50 is lower by the cosine of the angle and by the derivative's own loss.
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

/// The response measured on an edge.
#[derive(Debug, Clone, PartialEq)]
pub struct EdgeSfr {
    /// Frequencies from 0 to at least 1 cycle per pixel along the lines, even steps.
    pub frequency_cy_per_px: Vec<f64>,
    /// Response at these frequencies; 1 at frequency 0.
    pub sfr: Vec<f64>,
    /// The first frequency at which the response is one half, linear between samples; `None` when it stays above.
    pub mtf50_cy_per_px: Option<f64>,
    /// Area under the response from half a cycle per pixel upwards, in percent of the whole area up to the
    /// highest frequency: detail that the pixel grid can only show as something else.
    pub aliasing_percent: f64,
    /// Which way the edge runs.
    pub orientation: EdgeOrientation,
    /// Angle to the columns (vertical edge) or rows (horizontal edge), −45 to 45, positive where the position
    /// grows with row or column.
    pub edge_angle_deg: f64,
    /// Michelson contrast of the two plateaus, 0 to 1.
    pub contrast: f64,
    /// RMS distance, along the lines, of the located edge from the fitted straight line.
    pub fit_residual_px: f64,
    /// The edge profile in steps of a quarter pixel along the lines, in the unit of the image.
    pub esf: Vec<f64>,
    /// Place of the edge in `esf`, in its steps.
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
        spectrum::first_crossing(&self.frequency_cy_per_px, &self.sfr, level)
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

/// The responses of the planes of a picture and of its luminance.
#[derive(Debug, Clone, PartialEq)]
pub struct PictureSfr {
    /// One per plane.
    pub channels: Vec<EdgeSfr>,
    /// Of the weighted sum of the planes.
    pub luminance: EdgeSfr,
}

/// ISETCam's weights of red, green and blue in the luminance an edge is measured on (before 2022).
pub const ISETCAM_LUMINANCE_WEIGHTS: [f64; 3] = [0.3, 0.6, 0.1];

/// Measures one plane within a region; values must be linear in light.
///
/// # Errors
/// When the plane or region is not there, a value is not finite, or the region shows no usable edge
/// ([`MetricError::NoEdge`], [`MetricError::LowContrast`], [`MetricError::EdgeAngle`],
/// [`MetricError::EdgeSampling`]).
pub fn edge_sfr(
    planes: &Planes,
    plane: usize,
    rect: Rect,
    options: &EsfrOptions,
) -> Result<EdgeSfr, MetricError> {
    if plane >= planes.count() {
        return Err(MetricError::Plane { index: plane, count: planes.count() });
    }
    let (data, cols) = (planes.plane(plane), planes.cols());
    check_region(rect, planes.rows(), cols)?;
    measure(rect, options, |row, col| data.get(row * cols + col).map(|&v| f64::from(v)))
}

/// Measures every plane and the luminance `Σ weights[i] · plane[i]`.
///
/// # Errors
/// As [`edge_sfr`], and when the number of weights is not that of the planes or one is not finite.
pub fn picture_sfr(
    planes: &Planes,
    rect: Rect,
    luminance_weights: &[f64],
    options: &EsfrOptions,
) -> Result<PictureSfr, MetricError> {
    if luminance_weights.len() != planes.count() {
        let (expected, got) = (planes.count(), luminance_weights.len());
        return Err(MetricError::Count { what: "luminance weights", expected, got });
    }
    check_region(rect, planes.rows(), planes.cols())?;
    let luminance = measure(rect, options, |row, col| {
        let at = row * planes.cols() + col;
        planes.planes().zip(luminance_weights).map(|(p, w)| p.get(at).map(|&v| w * f64::from(v))).sum()
    })?;
    let channels = (0..planes.count()).map(|p| edge_sfr(planes, p, rect, options));
    Ok(PictureSfr { channels: channels.collect::<Result<_, _>>()?, luminance })
}

/// Measures one channel of a raw image before any demosaicking, on the samples of that channel alone at the places
/// where they are. Frequencies are in cycles per pixel of the whole sensor, so the aliasing limit of a Bayer
/// channel's own grid (0.25 cycles per pixel for red and blue) lies within the range.
///
/// # Errors
/// As [`edge_sfr`]. A sparse channel needs a longer edge: [`MetricError::EdgeSampling`] says when it is too short.
pub fn raw_channel_sfr(
    raw: &RawImage,
    channel: usize,
    rect: Rect,
    options: &EsfrOptions,
) -> Result<EdgeSfr, MetricError> {
    let count = raw.sampling().channels();
    if channel >= count {
        return Err(MetricError::Plane { index: channel, count });
    }
    check_region(rect, raw.rows(), raw.cols())?;
    let plane = match raw.sampling() {
        Sampling::Mosaic(_) => 0,
        Sampling::Full { .. } => channel,
    };
    let (first, black) = (plane * raw.rows() * raw.cols(), raw.black_level());
    measure(rect, options, |row, col| {
        match raw.sampling() {
            Sampling::Mosaic(m) if m.channel_at(row, col) != channel => return None,
            _ => {}
        }
        let at = first + row * raw.cols() + col;
        let value = match raw.samples() {
            RawSamples::Digital(v) => v.get(at).map(|&x| f64::from(x)),
            RawSamples::Analog(v) => v.get(at).map(|&x| f64::from(x)),
        };
        value.map(|v| v - black)
    })
}

/// Locates the edge among the samples that `value` yields and turns its profile into the response.
fn measure(
    rect: Rect,
    options: &EsfrOptions,
    value: impl Fn(usize, usize) -> Option<f64>,
) -> Result<EdgeSfr, MetricError> {
    if !(options.minimum_contrast > 0.0 && options.minimum_contrast < 1.0) {
        return Err(MetricError::Parameter {
            name: "minimum_contrast",
            value: options.minimum_contrast,
            expected: "above 0 and below 1",
        });
    }
    let (orientation, lines) = edge::gather(rect, value)?;
    let fit = edge::fit(&lines, options.centroid_window)?;
    spectrum::respond(&lines, &fit, orientation, options)
}
