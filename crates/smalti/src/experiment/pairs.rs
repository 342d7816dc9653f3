//! Training pairs of a raw image and its target picture, with alignment.

use super::ExperimentError;
use super::error::StageContext;
use crate::camera::{Camera, CameraError};
use crate::color::{ColorSpace, Image};
use crate::l3::{GOOD_CORRELATION, GOOD_RESIDUAL_PX, Learner, Pair, Registration, ensure_mosaic_of};
use crate::numeric::Planes;
use crate::sensor::RawImage;

/// A raw image and its target picture.
#[derive(Debug, Clone)]
pub struct RawAndPicture {
    /// The raw image. The order of its channels may differ from that of the camera.
    pub raw: RawImage,
    /// Rows and columns of the default crop, if the raw file states it.
    pub default_crop: Option<(usize, usize)>,
    /// The picture.
    pub picture: Image,
}

/// The alignment of a picture with its raw image.
#[derive(Debug, Clone)]
pub struct PairAlignment {
    /// The registration; `None` when the pair was not to be aligned.
    pub registration: Option<Registration>,
    /// Rows that were used for training.
    pub rows: usize,
    /// Columns that were used for training.
    pub cols: usize,
}

impl PairAlignment {
    /// What is doubtful about the alignment, in words.
    pub(super) fn doubts(&self) -> Vec<String> {
        let Some(found) = &self.registration else { return Vec::new() };
        let mut doubts = Vec::new();
        if found.correlation < GOOD_CORRELATION {
            let correlation = found.correlation;
            doubts.push(format!(
                "their correlation is only {correlation:.2}; check that both are of the same shot"
            ));
        }
        if found.largest_residual_px() > GOOD_RESIDUAL_PX {
            let px = found.largest_residual_px();
            doubts.push(format!(
                "quadrants are off by up to {px:.2} pixels; is the picture's distortion corrected?"
            ));
        }
        doubts
    }
}

/// Adds a pair to what is learned. With `align`, the picture may be a crop of the raw image, shifted by fractions of a pixel or
/// scaled. Otherwise picture and raw image must match pixel by pixel. `name` is that of the pair in messages.
///
/// # Errors
/// When the picture cannot be aligned, or the pair does not match the others.
pub(super) fn add_pair(
    learner: &mut dyn Learner,
    camera: &Camera,
    name: &str,
    pair: RawAndPicture,
    align: bool,
) -> Result<PairAlignment, ExperimentError> {
    let about = || name.to_owned();
    let names: Vec<String> = camera.sensor.cfa.channels().iter().map(|c| c.name.clone()).collect();
    let picture = pair.picture.converted(ColorSpace::Xyz).in_context(about)?;
    let target = picture.planes();
    let raw = pair.raw.with_channels(&names);
    ensure_mosaic_of(&camera.sensor.cfa, &raw).map_err(CameraError::from).in_context(about)?;
    if !align {
        learner.add(&Pair { raw: &raw, seen: None, target }).map_err(CameraError::from).in_context(about)?;
        return Ok(PairAlignment { registration: None, rows: raw.rows(), cols: raw.cols() });
    }
    let refused = |source| ExperimentError::Registration { pair: about(), source };
    let luminance = Planes::new(target.rows(), target.cols(), 1, picture.channels()[1].to_vec())
        .map_err(crate::l3::L3Error::from)?;
    let scales = scales(&raw, pair.default_crop, target);
    let found = Registration::best(&raw, &luminance, &scales).map_err(refused)?;
    let aligned = found.apply(&raw, target).map_err(refused)?;
    learner.add(&aligned.pair()).map_err(CameraError::from).in_context(about)?;
    let (rows, cols) = (aligned.raw.rows(), aligned.raw.cols());
    Ok(PairAlignment { registration: Some(found), rows, cols })
}

/// Y of a picture per mean of the normalised samples of its raw image, over all of both. `None` where either is dark.
///
/// # Errors
/// When the picture cannot be converted to X, Y, Z.
pub(super) fn brightness(name: &str, pair: RawAndPicture) -> Result<Option<f64>, ExperimentError> {
    let mean =
        |values: &[f32]| values.iter().map(|&v| f64::from(v)).sum::<f64>() / values.len().max(1) as f64;
    let picture = pair.picture.converted(ColorSpace::Xyz).in_context(|| name.to_owned())?;
    let (y, x) = (mean(picture.channels()[1]), mean(&pair.raw.normalized()));
    Ok((y > 0.0 && x > 0.0 && (y / x).is_finite()).then_some(y / x))
}

/// Candidate scales, pixels of the raw image per pixel of the picture: 1, and the ratios of the default crop and of the raw image
/// to the picture.
fn scales(raw: &RawImage, default_crop: Option<(usize, usize)>, picture: &Planes) -> Vec<f64> {
    let mut scales = vec![1.0];
    for (rows, cols) in default_crop.into_iter().chain([(raw.rows(), raw.cols())]) {
        let down = rows as f64 / picture.rows().max(1) as f64;
        let across = cols as f64 / picture.cols().max(1) as f64;
        let scale = if rows > cols { down } else { across };
        let is_new = scales.iter().all(|s| (s / scale - 1.0).abs() > 1e-4);
        if (down / across - 1.0).abs() < 0.01 && is_new && (0.25..=8.0).contains(&scale) {
            scales.push(scale);
        }
    }
    scales
}
