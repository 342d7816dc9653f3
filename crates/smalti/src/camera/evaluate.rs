//! The scores of a camera on its targets: colour and noise on the ColorChecker, resolution on slanted edges of high and low contrast,
//! and aliasing on a zone plate; and the colorimetry of its sensor, for which nothing is rendered.
//!
//! Each target covers the same number of pixels on every camera, so that scores rest on equally many samples. Colour and
//! resolution are measured without noise, because they are properties of the design rather than of one capture. Noise is
//! measured on captures with all noise, one or several. Both use the actual exposure, because a learned pipeline processes dark and bright
//! signals differently. In little light, MTF50 therefore counts detail that noise hides, and must be read beside the noise.

use serde::Serialize;

use super::chart::{self, LUMINANCE};
use super::colorimetry::{ColorimetricObserver, SensorColorimetry};
use super::grey_noise::GreyNoise;
use super::target::{EDGE_REGION, EdgeMtf50, Target, edge_mtf50};
use super::{Camera, CameraError, GreyScores, PatchScores};
use crate::color::adaptation::bradford;
use crate::color::display::{D65_XYZ, Matrices};
use crate::color::matrix::product;
use crate::color::{Image, ImageError};
use crate::isp::{Isp, WhiteBalance};
use crate::metrics::MetricError;
use crate::metrics::aliasing::{Aliasing, aliasing};
use crate::metrics::dynamic_range::dynamic_range;
use crate::metrics::esfr::{EdgeSfr, EsfrOptions, Mtf50Reliability, edge_sfr};
use crate::numeric::Planes;
use crate::optics::OpticalImage;
use crate::scene::Setting;
use crate::sensor::{Exposure, NoiseMode, RawImage};
use crate::spectrum::{Illuminant, Observer, Spectrum, WavelengthGrid};

/// Luminance of the primaries of sRGB (IEC 61966-2-1).
const SRGB_LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// What errors call the targets.
const CHART: &str = "the ColorChecker";
const LOW_CONTRAST_EDGE: &str = "the slanted edge of low contrast";

/// From this share of saturated samples on, a target shows nothing but defects of pixels, percent.
const WHOLLY_SATURATED_PERCENT: f64 = 99.5;

/// Illumination of the targets and seeds of the noise.
#[derive(Debug, Clone, PartialEq)]
pub struct EvaluationSettings {
    /// Mean luminance of every target, cd/m².
    pub luminance_cd_m2: f64,
    /// The illuminant.
    pub illuminant: Illuminant,
    /// Seed of the noise, the first of several.
    pub seed: u64,
    /// Number of captures of the chart over which noise is averaged, at least 1, with consecutive seeds. A study and `smalti evaluate` take
    /// one, comparisons [`COMPARED_NOISE_CAPTURES`](super::COMPARED_NOISE_CAPTURES).
    pub noise_captures: u64,
    /// Exposure times of the targets; `None` for those of the camera's description.
    pub exposure: Option<ExposureTimes>,
}

impl EvaluationSettings {
    /// The setting of the targets on a wavelength grid.
    pub(crate) fn setting(&self, grid: WavelengthGrid) -> Setting {
        Setting {
            luminance_cd_m2: self.luminance_cd_m2,
            illuminant: self.illuminant.clone(),
            grid,
            ..Setting::default()
        }
    }
}

impl Default for EvaluationSettings {
    /// 75 cd/m² of D65, one capture.
    fn default() -> Self {
        let illuminant = Illuminant::D65;
        Self { luminance_cd_m2: 75.0, illuminant, seed: 1, noise_captures: 1, exposure: None }
    }
}

/// The colours of the patches of the chart in CIELAB, row by row from dark skin. White is the white patch of the reference, and the
/// white patch of each has Y = 100, so that exposure does not count.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PatchColors {
    /// As the camera renders them without noise.
    pub rendered_lab: Vec<[f64; 3]>,
    /// As the standard observer sees them.
    pub reference_lab: Vec<[f64; 3]>,
}

/// Exposure times of the targets.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ExposureTimes {
    /// The ColorChecker, s.
    pub macbeth_s: f64,
    /// The slanted edges of high and low contrast, s.
    pub edge_s: f64,
    /// The zone plate, s.
    pub zone_plate_s: f64,
}

/// The scores of a camera.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Evaluation {
    /// Mean luminance of the targets, cd/m².
    pub luminance_cd_m2: f64,
    /// ΔE*ab (CIE 1976) from the reference chart, white patch at Y = 100.
    pub delta_e_76: PatchScores,
    /// CIEDE2000 from the reference chart, white patch at Y = 100.
    pub delta_e_2000: PatchScores,
    /// The colours that these differences compare.
    pub patch_colors: PatchColors,
    /// Spatial frequency at which the edge response falls to one half (MTF50), cycles per mm on the sensor.
    pub mtf50_cy_per_mm: f64,
    /// MTF50 in cycles per pixel.
    pub mtf50_cy_per_px: f64,
    /// Whether this MTF50 can be trusted.
    pub mtf50_reliability: Mtf50Reliability,
    /// MTF50 of an edge with a luminance ratio of 4:1 (ISO 12233:2017), with the exposure time of the other edge, cycles per mm. It
    /// differs from `mtf50_cy_per_mm` where processing depends on contrast.
    pub mtf50_low_contrast_cy_per_mm: f64,
    /// The same in cycles per pixel.
    pub mtf50_low_contrast_cy_per_px: f64,
    /// Whether this MTF50 can be trusted.
    pub mtf50_low_contrast_reliability: Mtf50Reliability,
    /// `100 · std(Y) / mean(Y)` on the grey series, percent. Mean over the captures.
    pub luminance_noise_percent: PatchScores,
    /// Visual signal-to-noise ratio of the grey series: reciprocal noise in ΔE 1976, white patch at L* = 100, 60 pixels per
    /// degree. The summary is the median, because white may clip and black is mostly noise. Mean over the captures.
    pub visual_snr: GreyScores,
    /// Saturated raw samples of the chart, percent. Clipping falsifies colours.
    pub saturated_percent: f64,
    /// Aliased energy in the picture of the zone plate, percent of the energy of the picture, 0 to 100.
    pub aliasing_percent: f64,
    /// The chromatic part of the aliased energy, percent.
    pub color_aliasing_percent: f64,
    /// Ratio of saturation to the signal whose signal-to-noise ratio is 1 (EMVA 1288), dB.
    pub dynamic_range_db: f64,
    /// Vora value, sensitivity metamerism index and metamer mismatch under the illuminant.
    #[serde(flatten)]
    pub sensor: SensorColorimetry,
    /// Exposure times.
    pub exposure: ExposureTimes,
    /// Seed of the noise, the first of several.
    pub seed: u64,
    /// Number of captures over which noise was averaged.
    pub noise_captures: u64,
}

/// The pictures of the targets, in XYZ.
#[derive(Debug, Clone)]
pub struct EvaluationPictures {
    /// The chart, with all noise, in the first capture.
    pub macbeth: Image,
    /// The edge of high contrast, without noise.
    pub edge: Image,
    /// The zone plate, without noise.
    pub zone_plate: Image,
    /// The aliased part of the picture of the zone plate.
    pub aliasing: Planes,
}

impl EvaluationPictures {
    /// The edge response of the luminance plane, whose MTF50 is that of [`Evaluation`]; `None` when the picture shows
    /// no edge, or an edge of too little contrast.
    ///
    /// # Errors
    /// When the edge cannot be measured for another reason.
    pub fn edge_sfr(&self) -> Result<Option<EdgeSfr>, CameraError> {
        match edge_sfr(self.edge.planes(), LUMINANCE, EDGE_REGION, &EsfrOptions::default()) {
            Ok(sfr) => Ok(Some(sfr)),
            Err(MetricError::NoEdge(_) | MetricError::LowContrast { .. }) => Ok(None),
            Err(error) => Err(error.into()),
        }
    }
}

/// Returns the optical image for a key, from a cache or by calling the given function.
pub type OpticalImages<'a> = &'a (
        dyn Fn(&str, &dyn Fn() -> Result<OpticalImage, CameraError>) -> Result<OpticalImage, CameraError>
            + Sync
    );

/// Returns the processing for scenes under an illuminant (photons). Its pictures are X, Y, Z under that illuminant, not adapted.
pub type IspFor<'a> = &'a (dyn Fn(&Spectrum) -> Result<Box<dyn Isp + 'a>, CameraError> + Sync + 'a);

/// Scores a camera with its own processing. `images` may cache optical images; `&|_, make| make()` computes them every time.
///
/// # Errors
/// When a stage fails, or a metric cannot be computed.
pub fn evaluate(
    camera: &Camera,
    settings: &EvaluationSettings,
    images: OpticalImages<'_>,
) -> Result<(Evaluation, EvaluationPictures), CameraError> {
    evaluate_with(camera, settings, images, &|light| Ok(Box::new(camera.isp(light, WhiteBalance::None)?)))
}

/// Scores a camera with the given processing. Captures without noise bypass the analog-to-digital converter: their samples and
/// their black and white levels are volts.
///
/// # Errors
/// When a stage fails, or a metric cannot be computed.
pub fn evaluate_with(
    camera: &Camera,
    settings: &EvaluationSettings,
    images: OpticalImages<'_>,
    isp: IspFor<'_>,
) -> Result<(Evaluation, EvaluationPictures), CameraError> {
    let setting = settings.setting(camera.grid());
    let chart = Target::chart(camera, &setting)?;
    let edge = Target::edge(camera, &setting)?;
    let low_contrast = Target::low_contrast_edge(camera, &setting)?;
    let zone = Target::zone_plate(camera, &setting)?;
    let ((chart, edge), zone) = rayon::join(
        || {
            let time = |of: fn(ExposureTimes) -> f64| settings.exposure.map(of);
            rayon::join(
                || chart.capture(settings, time(|t| t.macbeth_s), images, isp),
                || {
                    let edge = edge.capture(settings, time(|t| t.edge_s), images, isp)?;
                    let low_contrast =
                        low_contrast.capture(settings, Some(edge.exposure.time_s), images, isp)?;
                    Ok::<_, CameraError>((edge, low_contrast))
                },
            )
        },
        || zone.capture(settings, settings.exposure.map(|t| t.zone_plate_s), images, isp),
    );
    let (chart, (edge, low_contrast), zone) = (chart?, edge?, zone?);
    let (noisy, reference) = rayon::join(
        || chart.camera.sensor.capture(&chart.image, &chart.exposure, NoiseMode::All, settings.seed),
        || zone.camera.reference(&zone.image),
    );
    let (noisy, reference) = (noisy?, reference?);
    let saturated_percent = noisy.saturated_percent();
    ensure_not_wholly_saturated(&noisy).map_err(|e| chart.explained(e, CHART))?;
    let noisy = chart.isp.render(&noisy)?;
    let light = setting.illuminant.photons(camera.grid())?;
    let colors = chart::colors(&chart.clean, &light).map_err(|e| chart.explained(e, CHART))?;
    let noise = chart.noise(&noisy, settings, &light).map_err(|e| chart.explained(e, CHART))?;
    let mtf50 = edge_mtf50(edge.clean.planes(), LUMINANCE, EDGE_REGION)
        .map_err(|e| edge.explained(e, "the slanted edge"))?;
    let low_contrast = low_contrast.mtf50_or_none()?;
    let aliasing = zone_plate_aliasing(&zone.clean, &reference, &setting)?;
    let evaluation = Evaluation {
        luminance_cd_m2: settings.luminance_cd_m2,
        delta_e_76: PatchScores::new(colors.delta_e_76.per_patch)?,
        delta_e_2000: PatchScores::new(colors.delta_e_2000.per_patch)?,
        patch_colors: PatchColors { rendered_lab: colors.measured_lab, reference_lab: colors.reference_lab },
        mtf50_cy_per_mm: mtf50.cy_per_mm(camera),
        mtf50_cy_per_px: mtf50.cy_per_px,
        mtf50_reliability: mtf50.reliability,
        mtf50_low_contrast_cy_per_mm: low_contrast.cy_per_mm(camera),
        mtf50_low_contrast_cy_per_px: low_contrast.cy_per_px,
        mtf50_low_contrast_reliability: low_contrast.reliability,
        luminance_noise_percent: noise.luminance_noise_percent,
        visual_snr: noise.visual_snr,
        saturated_percent,
        aliasing_percent: aliasing.total_percent,
        color_aliasing_percent: aliasing.color_percent,
        dynamic_range_db: pixel_dynamic_range_db(camera)?,
        sensor: ColorimetricObserver::new(&light)?.colorimetry(camera)?,
        exposure: ExposureTimes {
            macbeth_s: chart.exposure.time_s,
            edge_s: edge.exposure.time_s,
            zone_plate_s: zone.exposure.time_s,
        },
        seed: settings.seed,
        noise_captures: settings.noise_captures.max(1),
    };
    let pictures = EvaluationPictures {
        macbeth: noisy,
        edge: edge.clean,
        zone_plate: zone.clean,
        aliasing: aliasing.difference,
    };
    Ok((evaluation, pictures))
}

/// Checks that neither the chart nor the edge of low contrast saturates wholly, for which no processing is needed. The edge of high
/// contrast and the zone plate have black parts, which never do.
///
/// # Errors
/// [`CameraError::Exposure`] of the target that does; when a stage fails.
pub(crate) fn ensure_targets_show_something(
    camera: &Camera,
    settings: &EvaluationSettings,
    images: OpticalImages<'_>,
) -> Result<(), CameraError> {
    let setting = settings.setting(camera.grid());
    let time = |of: fn(ExposureTimes) -> f64| settings.exposure.map(of);
    for (target, time_s, name) in [
        (Target::chart(camera, &setting)?, time(|t| t.macbeth_s), CHART),
        (Target::low_contrast_edge(camera, &setting)?, time(|t| t.edge_s), LOW_CONTRAST_EDGE),
    ] {
        let image = images(&target.key, &|| target.image())?;
        let exposure = target.camera.exposure_or(time_s, &image)?;
        let raw = target.camera.sensor.capture_ideal(&image, &exposure)?;
        ensure_not_wholly_saturated(&raw).map_err(|e| target.camera.explained(e, name, &image, &exposure))?;
    }
    Ok(())
}

fn is_wholly_saturated(raw: &RawImage) -> bool {
    raw.saturated_percent() >= WHOLLY_SATURATED_PERCENT
}

fn ensure_not_wholly_saturated(raw: &RawImage) -> Result<(), CameraError> {
    if is_wholly_saturated(raw) {
        let reason = "all samples are saturated";
        return Err(MetricError::Undefined { quantity: "the picture", reason }.into());
    }
    Ok(())
}

/// A target imaged on the camera, and its picture without noise.
struct TargetCapture<'a, 'i> {
    camera: &'a Camera,
    image: OpticalImage,
    exposure: Exposure,
    isp: Box<dyn Isp + 'i>,
    clean: Image,
    /// Whether not all of it saturates.
    shows_something: bool,
}

impl TargetCapture<'_, '_> {
    /// The noise of the chart under an illuminant (photons), whose first picture is given.
    fn noise(
        &self,
        first: &Image,
        settings: &EvaluationSettings,
        light: &Spectrum,
    ) -> Result<GreyNoise, CameraError> {
        let mut captures = vec![first.clone()];
        for capture in 1..settings.noise_captures {
            let seed = settings.seed.wrapping_add(capture);
            let raw = self.camera.sensor.capture(&self.image, &self.exposure, NoiseMode::All, seed)?;
            captures.push(self.isp.render(&raw)?);
        }
        Ok(GreyNoise::mean(&GreyNoise::of_captures(&captures, light)?))
    }

    /// The MTF50 of the edge of low contrast; not a number when the picture shows none, as where it saturates: rounding may then look like an edge of any angle.
    fn mtf50_or_none(&self) -> Result<EdgeMtf50, CameraError> {
        let none = EdgeMtf50 { cy_per_px: f64::NAN, reliability: Mtf50Reliability::NoEdge };
        if !self.shows_something {
            return Ok(none);
        }
        match edge_mtf50(self.clean.planes(), LUMINANCE, EDGE_REGION) {
            Err(CameraError::Metric(MetricError::NoEdge(_) | MetricError::LowContrast { .. })) => Ok(none),
            found => found.map_err(|e| self.explained(e, LOW_CONTRAST_EDGE)),
        }
    }

    /// The error of a metric, or the fault of the exposure where it explains the error.
    fn explained(&self, error: CameraError, target: &'static str) -> CameraError {
        self.camera.explained(error, target, &self.image, &self.exposure)
    }
}

impl Target {
    fn capture<'i>(
        &self,
        settings: &EvaluationSettings,
        time_s: Option<f64>,
        images: OpticalImages<'_>,
        isp: IspFor<'i>,
    ) -> Result<TargetCapture<'_, 'i>, CameraError> {
        let camera = &self.camera;
        let make = || self.image();
        let image = images(&self.key, &make)?;
        let light = settings.illuminant.photons(camera.grid())?;
        let isp = isp(&light)?;
        let exposure = camera.exposure_or(time_s, &image)?;
        // Without converter, because quantisation errors are only negligible together with noise (dithering).
        let raw = camera.sensor.capture_ideal(&image, &exposure)?;
        let (shows_something, clean) = (!is_wholly_saturated(&raw), isp.render(&raw)?);
        Ok(TargetCapture { camera, image, exposure, isp, clean, shows_something })
    }
}

/// Aliasing in linear sRGB adapted to the illuminant, in which the zone plate is neutral.
pub(crate) fn zone_plate_aliasing(
    picture: &Image,
    reference: &Image,
    setting: &Setting,
) -> Result<Aliasing, CameraError> {
    let white = Observer::Cie1931.xyz_from_photons(&setting.illuminant.photons(setting.grid)?)?;
    // The scale of the picture depends on the exposure; the reference is scaled to the same mean luminance.
    let mean = |picture: &Image| picture.channels()[LUMINANCE].iter().map(|&v| f64::from(v)).sum::<f64>();
    let gain = mean(picture) / mean(reference);
    let (picture, reference) = (linear_srgb(picture, white, 1.0)?, linear_srgb(reference, white, gain)?);
    Ok(aliasing(&picture, &reference, &SRGB_LUMINANCE)?)
}

/// A picture in XYZ as linear sRGB, with its white adapted to D65, times a gain.
fn linear_srgb(picture: &Image, white: [f64; 3], gain: f64) -> Result<Planes, ImageError> {
    let adapted = bradford(D65_XYZ, white).ok_or(ImageError::White(white))?;
    let rgb_from_xyz = product(&Matrices::SRGB.rgb_from_xyz, &adapted);
    let [x, y, z] = picture.channels();
    let mut rgb = Planes::zeros(picture.rows(), picture.cols(), 3);
    for (out, row) in rgb.planes_mut().zip(&rgb_from_xyz) {
        let [a, b, c] = row.map(|v| (v * gain) as f32);
        let of = x.iter().zip(y).zip(z);
        out.iter_mut().zip(of).for_each(|(o, ((x, y), z))| *o = a * x + b * y + c * z);
    }
    Ok(rgb)
}

fn pixel_dynamic_range_db(camera: &Camera) -> Result<f64, CameraError> {
    let sensor = &camera.sensor;
    let exposure = Exposure { time_s: 0.0, ..camera.gain_and_offset() };
    let volts_per_e = sensor.volts_per_electron(&exposure) * exposure.analog_gain;
    let step_v = match (sensor.adc.bits, sensor.binning) {
        (0, _) => 0.0,
        (_, None) => sensor.pixel.voltage_swing_v / sensor.adc.levels(),
        // The quantisation of several readings averages out, as their read noise does.
        (_, Some(_)) => (12.0 * sensor.noise_variance(0.0, &exposure)?.quantization).sqrt(),
    };
    let read_e = sensor.read_noise_e(&exposure);
    Ok(dynamic_range(sensor.saturation_e(&exposure), read_e, step_v / volts_per_e)?.db)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::ColorSpace;

    #[test]
    fn only_a_picture_without_an_edge_has_no_edge_response() {
        let of = |side: usize, value: f32| {
            let planes = Planes::new(side, side, 3, vec![value; 3 * side * side]).unwrap();
            let image = Image::new(ColorSpace::Xyz, planes).unwrap();
            let (edge, zone_plate) = (image.clone(), image.clone());
            EvaluationPictures { macbeth: image, edge, zone_plate, aliasing: Planes::zeros(1, 1, 3) }
                .edge_sfr()
        };
        assert_eq!(of(120, 0.5), Ok(None));
        assert!(matches!(of(20, 0.5), Err(CameraError::Metric(MetricError::Region { .. }))));
        assert!(matches!(of(120, f32::NAN), Err(CameraError::Metric(MetricError::NotFinite { .. }))));
    }

    #[test]
    fn a_light_that_cannot_be_adapted_is_an_error() {
        let grey = Planes::new(2, 2, 3, vec![0.5; 12]).unwrap();
        let picture = Image::new(ColorSpace::Xyz, grey).unwrap();
        for white in [[0.0; 3], [0.1, -0.1, 20.0], [f64::INFINITY, 1.0, 1.0]] {
            assert_eq!(linear_srgb(&picture, white, 1.0).unwrap_err(), ImageError::White(white));
        }
        // X, Y, Z equal under the equal-energy light are neutral.
        let neutral = linear_srgb(&picture, [1.0; 3], 2.0).unwrap();
        assert!(neutral.data().iter().all(|v| (v - 1.0).abs() < 1e-3), "{:?}", neutral.data());
    }
}
