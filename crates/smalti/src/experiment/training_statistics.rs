//! Statistics that training begins with: empty ones for scenes or for pairs, or saved ones.

use super::ExperimentError;
use super::error::{StageContext, ensure_memory};
use crate::camera::{Camera, TrainingSettings};
use crate::color::SRGB_WHITE;
use crate::l3::{self, Axes, Pipeline, RefinementStatistics, SecondStage, Statistics};
use crate::sensor::ColorArchitecture;
use crate::spectrum::Spectrum;

/// Checks that a camera has a mosaic. `label` is its name in the error.
///
/// # Errors
/// [`ExperimentError::NotMosaic`].
pub(super) fn ensure_mosaic(camera: &Camera, label: &str) -> Result<(), ExperimentError> {
    let architecture = match camera.sensor.architecture {
        ColorArchitecture::Mosaic => return Ok(()),
        ColorArchitecture::Prism => "prism",
        ColorArchitecture::FieldSequential => "field-sequential",
    };
    Err(ExperimentError::NotMosaic { camera: label.to_owned(), architecture })
}

/// Empty statistics of a camera, with levels cut for white under an illuminant (photons).
///
/// # Errors
/// When the camera has no mosaic, a setting is invalid, or memory does not suffice.
pub(super) fn fresh_statistics(
    camera: &Camera,
    settings: &TrainingSettings,
    light: &Spectrum,
    memory_bytes: Option<u64>,
) -> Result<Statistics, ExperimentError> {
    ensure_mosaic(camera, &camera.description().name)?;
    let statistics = camera.training_statistics(settings, light).in_context(|| "learning".into())?;
    ensure_memory(statistics.axes(), statistics.outputs().len(), memory_bytes)?;
    Ok(statistics)
}

/// What Y = 1 in the pictures of a pipeline stands for.
#[derive(Debug, Clone, Copy)]
pub(super) enum WhiteIn<'a> {
    /// A white diffuser under an illuminant (photons) that just saturates the brightest channel.
    Light(&'a Spectrum),
    /// This mean of the normalised samples.
    Samples(f64),
}

/// Empty statistics of the second stage of a pipeline.
///
/// # Errors
/// When the outputs of the pipeline are not X, Y, Z, or no exposure is found.
pub(super) fn second_stage<'a>(
    camera: &Camera,
    white: WhiteIn<'_>,
    pipeline: &'a Pipeline,
) -> Result<SecondStage<'a>, ExperimentError> {
    pipeline.ensure_picture().map_err(|_| ExperimentError::NotRefined(pipeline.outputs().join(", ")))?;
    let axes = match white {
        WhiteIn::Light(light) => camera.refinement_axes(light),
        WhiteIn::Samples(mean) => camera.refinement_axes_at(mean),
    };
    let axes = axes.in_context(|| "learning".into())?;
    Ok(SecondStage { pipeline, statistics: RefinementStatistics::new(axes) })
}

/// Empty statistics for pairs of raw files and pictures: the raw images are noisy, and the pictures have the white of sRGB.
/// Classes and targets are those of `fresh`.
///
/// # Errors
/// When the targets are invalid.
pub(super) fn pair_statistics(fresh: &Statistics) -> Result<Statistics, ExperimentError> {
    let statistics = Statistics::new(fresh.axes().clone(), fresh.outputs().to_vec(), true)?;
    Ok(statistics.with_white(Some(SRGB_WHITE)))
}

/// Merges saved statistics, each given with its name. They must match the camera and the settings of `fresh`, under any
/// illuminant. With `add_more`, `fresh` is merged as well and must match completely.
///
/// # Errors
/// [`ExperimentError::Statistics`] when statistics do not match; [`ExperimentError::NoScene`] without statistics.
pub(super) fn continue_statistics(
    saved: &[(String, Statistics)],
    fresh: &Statistics,
    add_more: bool,
) -> Result<Statistics, ExperimentError> {
    let ((name, first), others) = saved.split_first().ok_or(ExperimentError::NoScene)?;
    let mut statistics = first.clone();
    let refused = |reason: String| ExperimentError::Statistics { name: name.clone(), reason };
    let (its, own) = (statistics.axes(), fresh.axes());
    if its.mosaic() != own.mosaic() {
        return Err(refused("statistics of another mosaic than that of the camera".into()));
    }
    if its.side() != own.side() {
        let (its, own) = (its.side(), own.side());
        return Err(refused(format!("statistics of patches of {its} × {its}; {own} × {own} was asked for")));
    }
    if its.level_count() != own.level_count() {
        let (its, own) = (its.level_count(), own.level_count());
        return Err(refused(format!("statistics of {its} levels; {own} were asked for")));
    }
    if its.textures() != own.textures() {
        let names = |a: &Axes| a.textures().names().join(", ");
        let (its, own) = (names(its), names(own));
        return Err(refused(format!("statistics of the textures {its}; {own} were asked for")));
    }
    if its.noise() != own.noise() {
        return Err(refused("statistics of a camera with other noise (or of another exposure)".into()));
    }
    if statistics.outputs() != fresh.outputs() {
        let (its, own) = (statistics.outputs().join(", "), fresh.outputs().join(", "));
        return Err(refused(format!("statistics with targets {its}; {own} were asked for")));
    }
    let refused_merge =
        |what: String, e: l3::L3Error| ExperimentError::Statistics { name: what, reason: e.to_string() };
    if add_more {
        if statistics.noisy() != fresh.noisy() {
            return Err(refused(
                "statistics from raw files include noise and statistics from scenes do not; they cannot be combined".into(),
            ));
        }
        let what = || format!("{name}, gathered in another light or with other settings");
        statistics.merge(fresh).map_err(|e| refused_merge(what(), e))?;
    }
    for (file, other) in others {
        statistics.merge(other).map_err(|e| refused_merge(format!("{name} and {file}"), e))?;
    }
    Ok(statistics)
}
