//! The scores of a camera on three targets: colour and noise on the ColorChecker, resolution on a slanted edge,
//! aliasing on a zone plate.
//!
//! Every target is as large on the sensor, in pixels, for every camera, so that scores rest on equally many samples.
//! Colour and resolution are measured without noise: they are properties of the design, not of one capture. Noise
//! is measured on one capture with all noise. Both are at the real exposure, so that processing which treats dark
//! and bright signals differently, as a learned pipeline does, is scored at what it does at this level.

use serde::Serialize;

use super::chart::{self, LUMINANCE};
use super::target::{EDGE_REGION, Target, edge_mtf50};
use super::{Camera, CameraError};
use crate::color::display::Primaries;
use crate::color::matrix::{IDENTITY, product};
use crate::color::{Adaptation, Image};
use crate::isp::{Isp, WhiteBalance};
use crate::metrics::aliasing::{Aliasing, aliasing};
use crate::metrics::dynamic_range::dynamic_range;
use crate::metrics::esfr::{EdgeSfr, EsfrOptions, edge_sfr};
use crate::numeric::Planes;
use crate::optics::OpticalImage;
use crate::scene::Setting;
use crate::sensor::{Exposure, NoiseMode, RawImage};
use crate::spectrum::{Illuminant, Observer, Spectrum, WavelengthGrid};

/// Luminance of the primaries of sRGB (IEC 61966-2-1).
const SRGB_LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// What the targets are lit by.
#[derive(Debug, Clone, PartialEq)]
pub struct EvaluationSettings {
    /// Mean luminance of every target, cd/m².
    pub luminance_cd_m2: f64,
    /// The light.
    pub illuminant: Illuminant,
    /// Seed of the noise.
    pub seed: u64,
}

impl EvaluationSettings {
    /// The setting of the targets, on a camera's wavelengths.
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
    /// 75 cd/m² of D65.
    fn default() -> Self {
        Self { luminance_cd_m2: 75.0, illuminant: Illuminant::D65, seed: 1 }
    }
}

/// A figure for each patch, and their mean.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PatchScores {
    /// Mean over the patches.
    pub mean: f64,
    /// One per patch, row by row from dark skin, or from white to black for the grey series.
    pub per_patch: Vec<f64>,
}

impl From<Vec<f64>> for PatchScores {
    fn from(per_patch: Vec<f64>) -> Self {
        Self { mean: per_patch.iter().sum::<f64>() / per_patch.len().max(1) as f64, per_patch }
    }
}

/// A figure for each grey patch, and the middle one.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GreyScores {
    /// Median over the patches.
    pub median: f64,
    /// From white to black.
    pub per_patch: Vec<f64>,
}

impl From<Vec<f64>> for GreyScores {
    fn from(per_patch: Vec<f64>) -> Self {
        let mut sorted = per_patch.clone();
        sorted.sort_by(f64::total_cmp);
        let middle = |i: usize| sorted.get(i / 2).copied().unwrap_or(f64::NAN);
        let median = f64::midpoint(middle(sorted.len().saturating_sub(1)), middle(sorted.len()));
        Self { median, per_patch }
    }
}

/// Exposure times found or stated for the targets.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ExposureTimes {
    /// The ColorChecker, s.
    pub macbeth_s: f64,
    /// The slanted edge, s.
    pub edge_s: f64,
    /// The zone plate, s.
    pub zone_plate_s: f64,
}

/// The scores of a camera.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Evaluation {
    /// Mean luminance of the targets, cd/m².
    pub luminance_cd_m2: f64,
    /// Colour difference of 1976 from the chart itself, white patch at Y = 100.
    pub delta_e_76: PatchScores,
    /// CIEDE2000 from the chart itself, white patch at Y = 100.
    pub delta_e_2000: PatchScores,
    /// Frequency at which the response to an edge falls to one half, cycles per mm on the sensor.
    pub mtf50_cy_per_mm: f64,
    /// The same in cycles per pixel.
    pub mtf50_cy_per_px: f64,
    /// `100 · std(Y) / mean(Y)` on the grey series, percent.
    pub luminance_noise_percent: PatchScores,
    /// Reciprocal of the noise of the grey series as it is seen, in units of ΔE 1976, white patch at L* = 100, at 60 pixels per
    /// degree. The median: white may be clipped, and black is little but noise.
    pub visual_snr: GreyScores,
    /// Share of the chart's raw samples that are saturated, percent: colours that clip are wrong colours.
    pub saturated_percent: f64,
    /// Energy in the picture of the zone plate that is not in the zone plate, percent.
    pub aliasing_percent: f64,
    /// The part of it that is colour.
    pub color_aliasing_percent: f64,
    /// From the smallest signal that stands out of the dark noise to saturation, dB (EMVA 1288).
    pub dynamic_range_db: f64,
    /// Exposure times.
    pub exposure: ExposureTimes,
    /// Seed of the noise.
    pub seed: u64,
}

/// The pictures of the targets, in XYZ.
#[derive(Debug, Clone)]
pub struct EvaluationPictures {
    /// The chart, with all noise.
    pub macbeth: Image,
    /// The edge, without noise.
    pub edge: Image,
    /// The zone plate, without noise.
    pub zone_plate: Image,
    /// What of the zone plate's picture is not in the zone plate.
    pub aliasing: Planes,
}

impl EvaluationPictures {
    /// The response to the edge in the plane of luminance, whose MTF50 is that of [`Evaluation`].
    ///
    /// # Errors
    /// When there is no edge in the picture.
    pub fn edge_sfr(&self) -> Result<EdgeSfr, CameraError> {
        Ok(edge_sfr(self.edge.planes(), LUMINANCE, EDGE_REGION, &EsfrOptions::default())?)
    }
}

/// Finds the optical image of a name, or makes it: where images are cached between runs.
pub type OpticalImages<'a> = &'a (
        dyn Fn(&str, &dyn Fn() -> Result<OpticalImage, CameraError>) -> Result<OpticalImage, CameraError>
            + Sync
    );

/// Finds the processing for scenes under a light (photons). Its pictures are XYZ as they are under that light, not adapted.
pub type IspFor<'a> = &'a (dyn Fn(&Spectrum) -> Result<Box<dyn Isp + 'a>, CameraError> + Sync + 'a);

/// Scores a camera with its own processing. `images` may keep optical images; `&|_, make| make()` makes them anew.
///
/// # Errors
/// When a stage refuses, or a metric cannot be computed.
pub fn evaluate(
    camera: &Camera,
    settings: &EvaluationSettings,
    images: OpticalImages<'_>,
) -> Result<(Evaluation, EvaluationPictures), CameraError> {
    evaluate_with(camera, settings, images, &|light| Ok(Box::new(camera.isp(light, WhiteBalance::None)?)))
}

/// Scores a camera with processing of one's own. Its captures without noise have no converter: their samples are volts, with
/// black and white level in volts.
///
/// # Errors
/// When a stage refuses, or a metric cannot be computed.
pub fn evaluate_with(
    camera: &Camera,
    settings: &EvaluationSettings,
    images: OpticalImages<'_>,
    isp: IspFor<'_>,
) -> Result<(Evaluation, EvaluationPictures), CameraError> {
    let setting = settings.setting(camera.grid());
    let chart = Target::chart(camera, &setting)?;
    let edge = Target::edge(camera, &setting)?;
    let zone = Target::zone_plate(camera, &setting)?;
    let ((chart, edge), zone) = rayon::join(
        || rayon::join(|| chart.shoot(settings, images, isp), || edge.shoot(settings, images, isp)),
        || zone.shoot(settings, images, isp),
    );
    let (chart, edge, zone) = (chart?, edge?, zone?);
    let (noisy, reference) = rayon::join(|| chart.noisy(settings.seed), || zone.reference());
    let (noisy, reference) = (noisy?, reference?);
    let saturated_percent = noisy.saturated_percent();
    let noisy = chart.isp.render(&noisy)?;
    let light = setting.illuminant.photons(camera.grid())?;
    let colors = chart::colors(&chart.clean, &light)?;
    let noise = chart::noise(&noisy, &light)?;
    let mtf50_cy_per_px = edge_mtf50(edge.clean.planes(), LUMINANCE, EDGE_REGION)?;
    let aliasing = zone_plate_aliasing(&zone.clean, &reference, &setting)?;
    let evaluation = Evaluation {
        luminance_cd_m2: settings.luminance_cd_m2,
        delta_e_76: colors.delta_e_76.per_patch.into(),
        delta_e_2000: colors.delta_e_2000.per_patch.into(),
        mtf50_cy_per_mm: mtf50_cy_per_px / (camera.sensor.pixel.pitch_m * 1e3),
        mtf50_cy_per_px,
        luminance_noise_percent: noise.luminance_noise_percent.into(),
        visual_snr: noise.visual_snr.into(),
        saturated_percent,
        aliasing_percent: aliasing.total_percent,
        color_aliasing_percent: aliasing.color_percent,
        dynamic_range_db: pixel_dynamic_range_db(camera)?,
        exposure: ExposureTimes {
            macbeth_s: chart.exposure.time_s,
            edge_s: edge.exposure.time_s,
            zone_plate_s: zone.exposure.time_s,
        },
        seed: settings.seed,
    };
    let pictures = EvaluationPictures {
        macbeth: noisy,
        edge: edge.clean,
        zone_plate: zone.clean,
        aliasing: aliasing.difference,
    };
    Ok((evaluation, pictures))
}

/// A target before the camera, and its picture without noise.
struct Shot<'a, 'i> {
    camera: &'a Camera,
    image: OpticalImage,
    exposure: Exposure,
    isp: Box<dyn Isp + 'i>,
    clean: Image,
}

impl Shot<'_, '_> {
    /// The capture with all noise.
    fn noisy(&self, seed: u64) -> Result<RawImage, CameraError> {
        Ok(self.camera.sensor.capture(&self.image, &self.exposure, NoiseMode::All, seed)?)
    }

    /// What the standard observer sees of it.
    fn reference(&self) -> Result<Image, CameraError> {
        self.camera.reference(&self.image)
    }
}

impl Target {
    fn shoot<'i>(
        &self,
        settings: &EvaluationSettings,
        images: OpticalImages<'_>,
        isp: IspFor<'i>,
    ) -> Result<Shot<'_, 'i>, CameraError> {
        let camera = &self.camera;
        let make = || self.image();
        let image = images(&self.key, &make)?;
        let light = settings.illuminant.photons(camera.grid())?;
        let isp = isp(&light)?;
        let exposure = camera.exposure(&image)?;
        // Without a converter: rounding without noise would be an error of its own, which noise takes away.
        let clean = isp.render(&camera.sensor.capture_ideal(&image, &exposure)?)?;
        Ok(Shot { camera, image, exposure, isp, clean })
    }
}

/// Compared in linear sRGB with the light made white, where the zone plate is neutral.
pub(crate) fn zone_plate_aliasing(
    picture: &Image,
    reference: &Image,
    setting: &Setting,
) -> Result<Aliasing, CameraError> {
    let white = Observer::Cie1931.xyz_from_photons(&setting.illuminant.photons(setting.grid)?)?;
    // The picture's scale is that of the exposure; the reference is brought to the same mean luminance.
    let mean = |picture: &Image| picture.planes().plane(LUMINANCE).iter().map(|&v| f64::from(v)).sum::<f64>();
    let gain = mean(picture) / mean(reference);
    let (picture, reference) = (linear_srgb(picture, white, 1.0), linear_srgb(reference, white, gain));
    Ok(aliasing(&picture, &reference, &SRGB_LUMINANCE)?)
}

/// A picture in XYZ with its white made that of sRGB, times a gain.
fn linear_srgb(picture: &Image, white: [f64; 3], gain: f64) -> Planes {
    let d65 = Primaries::SRGB.white_xyz().unwrap_or([1.0; 3]);
    let adapted = Adaptation::Bradford.matrix(d65, white).unwrap_or(IDENTITY);
    let rgb_from_xyz = product(&Primaries::SRGB.rgb_from_xyz().unwrap_or(IDENTITY), &adapted);
    let xyz = picture.planes();
    let mut rgb = Planes::zeros(xyz.rows(), xyz.cols(), 3);
    for (c, row) in rgb_from_xyz.iter().enumerate() {
        let [x, y, z] = row.map(|v| (v * gain) as f32);
        let of = xyz.plane(0).iter().zip(xyz.plane(1)).zip(xyz.plane(2));
        for (out, ((a, b), c)) in rgb.plane_mut(c).iter_mut().zip(of) {
            *out = x * a + y * b + z * c;
        }
    }
    rgb
}

fn pixel_dynamic_range_db(camera: &Camera) -> Result<f64, CameraError> {
    let (sensor, pixel) = (&camera.sensor, &camera.sensor.pixel);
    let exposure = Exposure { time_s: 0.0, ..camera.gain_and_offset() };
    let volts_per_e = pixel.conversion_gain_v_per_e * exposure.analog_gain;
    let zero_v = exposure.analog_offset_v * exposure.analog_gain;
    let step_v = if sensor.adc.bits == 0 { 0.0 } else { pixel.voltage_swing_v / sensor.adc.levels() };
    let saturation_e = (sensor.saturation_v(&exposure) - zero_v) / volts_per_e;
    let read_e = pixel.read_noise_v / pixel.conversion_gain_v_per_e;
    Ok(dynamic_range(saturation_e, read_e, step_v / volts_per_e)?.db)
}
