//! Spatial frequency response from a slanted edge (e-SFR), following ISO 12233 ([iso12233]) and
//! P. D. Burns (2000), "Slanted-edge MTF for digital camera and scanner analysis", IS&T PICS.
//!
//! A slightly slanted edge crosses each line of pixels at a different phase, so that all lines together sample its profile
//! more finely than the pixels. The centroid of the windowed derivative locates the edge on each line. A straight line is
//! fitted to the centroids, and fitted again with windows centred on it. Every sample is projected along this line into bins
//! of a quarter pixel. The windowed derivative of the profile is the line spread function, and the normalised modulus of its
//! Fourier transform is the response.
//!
//! Departures from ISO 12233:2017 and later, all stated in docs/validation.md: the whole picture is linear, so that no opto-electronic
//! conversion function is inverted; the samples of a bin are corrected for their place in it ([`EsfrOptions::place_correction`]); the edge
//! of an evaluation stands at 23.2° instead of 5°, where a bin holds samples of more phases; its contrast is 10⁶:1, beside
//! which an evaluation measures the edge of 4:1 that the standard asks for. [`Mtf50Reliability`] is not in the standard.
//!
//! [iso12233]: https://www.iso.org/standard/71696.html

mod edge;
mod options;
mod region;
mod reliability;
mod response;
mod spectrum;

pub use options::{CentroidWindow, EdgeOrientation, EsfrOptions, FrequencyAxis};
pub use region::find_edge_region;
pub use reliability::{Mtf50Reliability, NYQUIST_CY_PER_PX};
pub use response::EdgeSfr;

use super::patch::{check_plane, check_region};
use super::{MetricError, Rect};
use crate::numeric::Planes;
use crate::sensor::{RawImage, RawSamples, Sampling};

/// The responses of the planes of a picture and of its luminance.
#[derive(Debug, Clone, PartialEq)]
pub struct PictureSfr {
    /// One per plane.
    pub channels: Vec<EdgeSfr>,
    /// Of the weighted sum of the planes.
    pub luminance: EdgeSfr,
}

/// Weights of red, green and blue for the luminance of edges in ISETCam before 2022.
pub const ISETCAM_LUMINANCE_WEIGHTS: [f64; 3] = [0.3, 0.6, 0.1];

/// Measures one plane within a region; values must be linear in light.
///
/// # Errors
/// When the plane or region does not exist, a value is not finite, or the region shows no usable edge
/// ([`MetricError::NoEdge`], [`MetricError::LowContrast`], [`MetricError::EdgeAngle`],
/// [`MetricError::EdgeSampling`]).
pub fn edge_sfr(
    planes: &Planes,
    plane: usize,
    rect: Rect,
    options: &EsfrOptions,
) -> Result<EdgeSfr, MetricError> {
    check_plane(planes.count(), plane)?;
    let (data, cols) = (planes.plane(plane)?, planes.cols());
    check_region(rect, planes.rows(), cols)?;
    measure(rect, options, |row, col| data.get(row * cols + col).map(|&v| f64::from(v)))
}

/// Measures every plane and the luminance `Σ weights[i] · plane[i]`.
///
/// # Errors
/// As [`edge_sfr`], and when the number of weights is not that of the planes or a weight is not finite.
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

/// Measures one channel of a raw image without demosaicking, on its own samples. Frequencies are in cycles per pixel of the full
/// grid, so that the Nyquist limit of a Bayer channel (0.25 cycles per pixel for red and blue) lies within the range.
///
/// # Errors
/// As [`edge_sfr`]. A sparse channel needs a longer edge; [`MetricError::EdgeSampling`] reports an edge that is too short.
pub fn raw_channel_sfr(
    raw: &RawImage,
    channel: usize,
    rect: Rect,
    options: &EsfrOptions,
) -> Result<EdgeSfr, MetricError> {
    check_plane(raw.sampling().channels(), channel)?;
    check_region(rect, raw.rows(), raw.cols())?;
    let plane = if raw.sampling().planes() == 1 { 0 } else { channel };
    let (first, black) = (plane * raw.rows() * raw.cols(), raw.black_level());
    measure(rect, options, |row, col| {
        if let Sampling::Mosaic(m) = raw.sampling()
            && m.channel_at(row, col) != channel
        {
            return None;
        }
        let at = first + row * raw.cols() + col;
        let value = match raw.samples() {
            RawSamples::Digital(v) => v.get(at).map(|&x| f64::from(x)),
            RawSamples::Analog(v) => v.get(at).map(|&x| f64::from(x)),
        };
        value.map(|v| v - black)
    })
}

/// Locates the edge in the samples and computes the response.
fn measure(
    rect: Rect,
    options: &EsfrOptions,
    sample: impl Fn(usize, usize) -> Option<f64>,
) -> Result<EdgeSfr, MetricError> {
    let value = options.minimum_contrast;
    if !(value > 0.0 && value < 1.0) {
        let (name, expected) = ("minimum_contrast", "above 0 and below 1");
        return Err(MetricError::Parameter { name, value, expected });
    }
    let (orientation, lines) = edge::gather(rect, sample)?;
    let fit = edge::fit(&lines, options.centroid_window)?;
    spectrum::respond(&lines, &fit, orientation, options)
}
