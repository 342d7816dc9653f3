//! The pictures of a rating experiment: every condition on every scene, cropped alike, with the metrics of the very pictures that
//! observers see.

use super::comparison::{ComparisonSettings, imaged};
use super::contender::Contender;
use super::error::StageContext;
use super::progress::ensure_running;
use super::{ExperimentError, ExposurePlan, Resources};
use crate::camera::compare::IntegratedScene;
use crate::camera::{
    COMPARED_NOISE_CAPTURES, CameraError, Evaluation, EvaluationSettings, Setup, score_picture,
};
use crate::color::Image;
use crate::metrics::MetricError;
use crate::numeric::{Planes, Rect};

/// The side of the blocks of a trap, pixels.
const TRAP_BLOCK: usize = 12;

/// A condition of a rating experiment: a contender in an amount of light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RatedCondition {
    /// The number of the contender.
    pub contender: usize,
    /// The number of the luminance in the settings, which determines the exposure time.
    pub light: usize,
    /// Light beyond this luminance, stops, at the same exposure time.
    pub stops: f64,
}

/// A picture as observers see it.
#[derive(Debug, Clone)]
pub struct RatedPicture {
    /// The picture in sRGB.
    pub image: Image,
    /// The factor from the scale of the picture to that of the display: the reciprocal of the luminance of white.
    pub gain: f64,
    /// Exposure time, s.
    pub exposure_time_s: f64,
    /// The metrics of a comparison, by their names in the catalogue: first those of this picture, then those of the targets, which are the
    /// same for all scenes. A metric that is not defined is left out.
    pub metrics: Vec<(&'static str, f64)>,
}

/// The pictures of a scene.
#[derive(Debug, Clone)]
pub struct RatedScene {
    /// The name of the scene.
    pub name: String,
    /// The reference in sRGB: the scene as the standard observer sees it through the lens of the first contender.
    pub reference: Image,
    /// The reference in coarse blocks, which is plainly worse than any picture.
    pub trap: Image,
    /// A picture for each condition.
    pub pictures: Vec<RatedPicture>,
}

/// Renders the conditions on the scenes of the settings, for their first seed, and crops all pictures to at most `side` × `side` pixels
/// in the middle. Each condition on each scene is a step of progress, as are its targets.
///
/// # Errors
/// When there is no condition, a contender lacks its pipeline, a stage fails, or the work is stopped.
pub fn rated_scenes(
    contenders: &[Contender<'_>],
    conditions: &[RatedCondition],
    side: usize,
    settings: &ComparisonSettings,
    resources: Resources<'_>,
) -> Result<Vec<RatedScene>, ExperimentError> {
    let used = |c: &RatedCondition| {
        contenders.get(c.contender).filter(|_| c.light < settings.luminances_cd_m2.len())
    };
    let Some(first) =
        conditions.first().and_then(used).filter(|_| conditions.iter().all(|c| used(c).is_some()))
    else {
        return Err(ExperimentError::NothingToCompare);
    };
    let steps = conditions.len() * (settings.scenes.len() + 1);
    resources.progress.expect(steps as u64);
    let setups = imaged(first, settings, &[], resources)?;
    let cameras: Vec<_> = contenders.iter().map(|c| (c.label, c.camera)).collect();
    let pictures = settings.pictures(&setups);
    let exposure = ExposurePlan::new(settings.exposure, &cameras, pictures, resources)?;
    let targets = |condition: &RatedCondition| {
        let contender = &contenders[condition.contender];
        resources.progress.begin(&format!("{}, targets", contender.name()));
        let targets = EvaluationSettings {
            luminance_cd_m2: settings.luminances_cd_m2[condition.light] * libm::exp2(condition.stops),
            illuminant: settings.illuminant.clone(),
            seed: settings.seed,
            noise_captures: COMPARED_NOISE_CAPTURES,
            exposure: exposure.targets(condition.light),
        };
        let (evaluation, _) = contender.evaluate(&targets, resources)?;
        resources.progress.done();
        Ok(evaluation)
    };
    let targets = conditions.iter().map(targets).collect::<Result<Vec<_>, ExperimentError>>()?;
    let with_targets: Vec<_> = conditions.iter().zip(&targets).collect();
    let on_scene = |(number, setup): (usize, &Setup)| {
        rated_scene(contenders, &with_targets, (number, setup), side, (settings, &exposure), resources)
    };
    setups.iter().enumerate().map(on_scene).collect()
}

fn rated_scene(
    contenders: &[Contender<'_>],
    conditions: &[(&RatedCondition, &Evaluation)],
    (number, shared): (usize, &Setup),
    side: usize,
    (settings, exposure): (&ComparisonSettings, &ExposurePlan),
    resources: Resources<'_>,
) -> Result<RatedScene, ExperimentError> {
    let progress = resources.progress;
    let scene = &settings.scenes[number];
    let (mut reference, mut pictures) = (None, Vec::with_capacity(conditions.len()));
    // The scene on the camera of one contender at a time.
    let mut integrated: Option<(usize, IntegratedScene)> = None;
    for (condition, targets) in conditions {
        ensure_running(progress)?;
        let contender = &contenders[condition.contender];
        let luminance_cd_m2 = settings.luminances_cd_m2[condition.light];
        let at = luminance_cd_m2 * libm::exp2(condition.stops);
        progress.begin(&format!("{} at {at:.3} cd/m², {}", contender.name(), scene.name()));
        let mut render = || -> Result<_, CameraError> {
            if integrated.as_ref().is_none_or(|(of, _)| *of != condition.contender) {
                let setup = scene.before_sharing(contender.camera, &settings.illuminant, Some(shared))?;
                integrated = Some((condition.contender, IntegratedScene::new(setup)?));
            }
            let Some((_, integrated)) = &integrated else { return Ok(None) };
            let exposure = integrated.exposure(luminance_cd_m2, exposure.scene_s(number, condition.light))?;
            let isp = contender.isp(&integrated.light(at)?, progress)?;
            let seeds = settings.seed..settings.seed.saturating_add(1);
            Ok(Some(integrated.compare_seeds((at, &exposure), &*isp, seeds, &settings.score)?.first))
        };
        let context = || format!("{} at {at} cd/m², {}", contender.name(), scene.name());
        let Some(scored) = render().in_context(context)? else { continue };
        let picture = || -> Result<_, CameraError> {
            let [picture, own] = [&scored.picture, &scored.reference].map(|image| middle(image, side));
            let (picture, own) = (picture?, own?);
            // White, and with it the metrics, are those of what is shown.
            let scores = score_picture(&picture, &own, scored.white, &settings.score)?;
            let gain = 1.0 / scores.white_y;
            let image = picture.shown(Some(scored.white), gain)?;
            let of_picture = [
                ("cpsnr_db", scores.cpsnr_db),
                ("pixel_delta_e_2000_mean", scores.pixel_delta_e_2000_mean),
                ("scielab_mean", scores.scielab_mean),
            ];
            let of_targets = [
                ("mtf50_cy_per_px", targets.mtf50_cy_per_px),
                ("mtf50_low_contrast_cy_per_px", targets.mtf50_low_contrast_cy_per_px),
                ("visual_snr", targets.visual_snr.median),
                ("luminance_noise_percent", targets.luminance_noise_percent.mean),
            ];
            let metrics = of_picture.into_iter().chain(of_targets).filter(|(_, value)| value.is_finite());
            let rated = RatedPicture {
                image,
                gain,
                exposure_time_s: scored.exposure_time_s,
                metrics: metrics.collect(),
            };
            Ok((rated, own.shown(Some(scored.white), gain)?))
        };
        let (picture, own) = picture().in_context(context)?;
        reference.get_or_insert(own);
        pictures.push(picture);
        progress.done();
    }
    let reference = reference.ok_or(ExperimentError::NothingToCompare)?;
    let trap = coarse(&reference).in_context(|| scene.name().to_owned())?;
    Ok(RatedScene { name: scene.name().to_owned(), reference, trap, pictures })
}

/// The middle of an image, at most `side` × `side` pixels.
fn middle(image: &Image, side: usize) -> Result<Image, CameraError> {
    let [rows, cols] = [image.rows(), image.cols()].map(|n| n.min(side.max(1)));
    let (top, left) = ((image.rows() - rows) / 2, (image.cols() - cols) / 2);
    mapped(image, Rect { row: top, col: left, rows, cols }, |plane, cols_of, row, col| {
        plane[row * cols_of + col]
    })
}

/// The means of blocks.
fn coarse(image: &Image) -> Result<Image, CameraError> {
    let (all_rows, all_cols) = (image.rows(), image.cols());
    mapped(image, Rect::whole(all_rows, all_cols), |plane, cols_of, row, col| {
        let from = |n: usize| n / TRAP_BLOCK * TRAP_BLOCK;
        let rows = from(row)..(from(row) + TRAP_BLOCK).min(all_rows);
        let cols = from(col)..(from(col) + TRAP_BLOCK).min(all_cols);
        let count = (rows.len() * cols.len()) as f32;
        rows.map(|r| plane[r * cols_of..][cols.clone()].iter().sum::<f32>()).sum::<f32>() / count
    })
}

/// A region of an image with new values, which depend on the plane, its number of columns and the place.
fn mapped(
    image: &Image,
    region: Rect,
    value: impl Fn(&[f32], usize, usize, usize) -> f32,
) -> Result<Image, CameraError> {
    let (rows, cols) = (region.rows, region.cols);
    let places = || (0..rows).flat_map(move |r| (0..cols).map(move |c| (region.row + r, region.col + c)));
    let planes = image.channels().into_iter();
    let data =
        planes.flat_map(|plane| places().map(|(r, c)| value(plane, image.cols(), r, c)).collect::<Vec<_>>());
    let planes = Planes::new(rows, cols, 3, data.collect()).map_err(MetricError::from)?;
    Ok(Image::new(image.space(), planes)?)
}
