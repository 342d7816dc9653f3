//! What the pipelines of all designs are learned from: the light of the training scene on the pixels, its reference, and uniform surfaces.

use std::sync::Arc;

use super::imaged_scene::ImagedScene;
use super::learning_settings::LearningSettings;
use crate::camera::chart::LUMINANCE;
use crate::camera::{Camera, CameraError};
use crate::l3::{Axes, L3Error, Levels};
use crate::numeric::Planes;
use crate::sensor::{Cfa, Exposure, PixelSpectra};
use crate::spectrum::{Observer, Spectrum};

/// Range of the cuts between levels, as fractions of the response to white. Outside it, noise and kernels change little.
const LEVEL_RANGE: [f64; 2] = [0.03, 0.6];
/// Least response of a channel to white, relative to the brightest channel. Levels need a response above 0.
const MIN_WHITE: f64 = 1e-3;
/// Relative illuminance of the uniform surfaces.
const SHADES: [f64; 3] = [1.0, 0.6, 0.3];
/// Number of patches that a uniform surface counts for at each position. Of 16, 64, 128 and 256, it is the smallest with which
/// five sets of Gaussian filters all have a smaller ΔE 1976 and ΔE 2000 on the surfaces than the fitted colour matrix. Larger
/// numbers cost some resolution and cause false colour on black-and-white patterns.
pub(super) const SURFACE_PATCHES: u32 = 128;

/// The training scene on the pixels of a camera, with its reference.
#[derive(Debug)]
pub(super) struct TrainingLight {
    pub(super) pixels: PixelSpectra,
    /// X, Y, Z of the reference at every pixel.
    pub(super) seen: Planes,
    /// Y of the reference for white.
    pub(super) white_y: f64,
    /// Radiance of white, photons.
    pub(super) light: Spectrum,
}

/// A uniform surface: its radiance, and X, Y, Z with Y = 1 for fully lit white.
pub(super) type Surface = (Spectrum, [f64; 3]);

/// The training data of one camera. Nothing in it depends on the filters.
#[derive(Debug, Clone)]
pub(super) struct TrainingData {
    pub(super) settings: LearningSettings,
    /// The chart, on which the exposure is found.
    pub(super) chart: Arc<ImagedScene>,
    pub(super) camera: Camera,
    pub(super) pixels: Arc<PixelSpectra>,
    /// X, Y, Z of the reference at every pixel.
    pub(super) seen: Arc<Planes>,
    /// Uniform surfaces: those that the camera's colour matrix is fitted to, so that learned and fitted colours use the same data.
    pub(super) surfaces: Arc<Vec<Surface>>,
    /// Y of the reference for white.
    pub(super) white_y: f64,
    pub(super) light: Spectrum,
    /// Seed of the noise.
    pub(super) seed: u64,
}

/// The rule for the cuts between levels.
pub(super) struct LevelCuts {
    /// Number of levels.
    pub(super) levels: usize,
    /// Range of the cuts, relative to the mean response to white. It reaches down by a factor of ten at least.
    pub(super) range: [f64; 2],
    /// Largest cut, relative to saturation.
    pub(super) highest: f64,
}

/// A design at its exposure for the chart.
pub(super) struct ExposedDesign {
    pub(super) camera: Camera,
    pub(super) exposure: Exposure,
    /// The factor from X, Y, Z of the reference to targets.
    pub(super) scale: f64,
    /// Electrons per photon that enters the lens, for each channel.
    responsivities: Vec<Spectrum>,
    /// Response of the brightest channel to white.
    brightest: f64,
    /// Y of white on the scale of the targets, and the response of the brightest channel to white on that of the samples.
    pub(super) full: f64,
    /// Response of each channel to white, on the scale of the samples.
    pub(super) white: Vec<f64>,
    pub(super) axes: Axes,
}

impl ExposedDesign {
    /// The normalised samples of a surface, one for each channel.
    pub(super) fn samples(&self, radiance: &Spectrum) -> Vec<f64> {
        responses(&self.responsivities, radiance).iter().map(|r| r / self.brightest * self.full).collect()
    }
}

/// Uniform surfaces in full light and in shade, as seen in the light of white.
fn seen_surfaces(reflectances: &[Spectrum], white: &Spectrum) -> Result<Vec<Surface>, CameraError> {
    let luminance_cd_m2 = Observer::Cie1931.xyz_from_photons(white)?[LUMINANCE];
    let lit = reflectances.iter().map(|s| Ok(s.times(white)?)).collect::<Result<Vec<_>, CameraError>>()?;
    let seen = |s: Spectrum| {
        let xyz = Observer::Cie1931.xyz_from_photons(&s)?.map(|v| v / luminance_cd_m2);
        Ok((s, xyz))
    };
    SHADES.iter().flat_map(|&light| lit.iter().map(move |s| seen(s.scaled(light)?))).collect()
}

fn responses(responsivities: &[Spectrum], light: &Spectrum) -> Vec<f64> {
    let of = |r: &Spectrum| r.values().iter().zip(light.values()).map(|(r, l)| r * l).sum();
    responsivities.iter().map(of).collect()
}

impl TrainingData {
    /// Light on a camera with as many pixels.
    pub(super) fn new(
        camera: Camera,
        settings: &LearningSettings,
        chart: Arc<ImagedScene>,
        light: TrainingLight,
        seed: u64,
    ) -> Result<Self, CameraError> {
        settings.validate()?;
        let TrainingLight { pixels, seen, white_y, light } = light;
        let surfaces = seen_surfaces(&camera.surfaces()?, &light)?;
        let (settings, surfaces) = (settings.clone(), Arc::new(surfaces));
        let (pixels, seen) = (Arc::new(pixels), Arc::new(seen));
        Ok(Self { settings, chart, camera, pixels, seen, surfaces, white_y, light, seed })
    }

    /// Uniform surfaces of other reflectances, as `surfaces` has them.
    pub(super) fn surfaces_of(&self, reflectances: &[Spectrum]) -> Result<Vec<Surface>, CameraError> {
        seen_surfaces(reflectances, &self.light)
    }

    /// The exposure of a design for the chart, and the classes of its samples.
    pub(super) fn exposed(&self, cfa: &Cfa) -> Result<ExposedDesign, CameraError> {
        let levels = self.settings.levels;
        self.exposed_in(cfa, &LevelCuts { levels, range: LEVEL_RANGE, highest: f64::INFINITY })
    }

    /// The same with other levels.
    pub(super) fn exposed_in(&self, cfa: &Cfa, cuts: &LevelCuts) -> Result<ExposedDesign, CameraError> {
        let (_, exposure) = self.chart.with_cfa(cfa)?;
        let camera = self.camera.with_cfa(cfa.clone());
        let y = &Observer::Cie1931.photon_weights(camera.grid())?[LUMINANCE];
        let scale = camera.exposure_scale(&exposure, &self.light, y)?;
        let responsivities = camera.responsivities()?;
        let white = responses(&responsivities, &self.light);
        let brightest = white.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        // At this exposure, the response of the brightest channel to white equals Y of white.
        let full = scale * self.white_y;
        let white: Vec<f64> = white.iter().map(|w| (w / brightest).max(MIN_WHITE) * full).collect();
        let noise = camera.sensor.signal_noise(&exposure)?;
        let axes = Axes::new(cfa.mosaic().clone(), self.settings.side, cuts.levels(cfa, &white)?, noise)?
            .with_levels_by_position(&white)?
            .with_textures(self.settings.textures);
        Ok(ExposedDesign { camera, exposure, scale, responsivities, brightest, full, white, axes })
    }
}

impl LevelCuts {
    /// Cuts in equal ratios of the mean response over the tile, from the responses of the channels to white.
    fn levels(&self, cfa: &Cfa, white: &[f64]) -> Result<Levels, L3Error> {
        let cells = cfa.mosaic().cells();
        let sum: f64 = cells.iter().filter_map(|&c| white.get(usize::from(c))).sum();
        let mean = sum / cells.len().max(1) as f64;
        let [least, most] = self.range;
        let most = most.min(self.highest / mean);
        let least = least.min(0.1 * most);
        let cuts = self.levels.saturating_sub(1);
        let cut = |i: usize| (mean * least * libm::pow(most / least, (i as f64 + 0.5) / cuts as f64)) as f32;
        Levels::new((0..cuts).map(cut).collect())
    }
}
