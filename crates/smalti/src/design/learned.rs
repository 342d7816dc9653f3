//! A pipeline of its own for every colour filter array: L³, learned from light that is gathered once.
//!
//! One scene of many small pictures is thrown on the sensor; the light on every pixel, and what the standard observer sees there,
//! do not depend on the filters and are kept ([`Lessons`]). A design then costs a capture of the kept light with and
//! without noise, one pass of statistics and their solution. The exposure is the one that the design finds before the ColorChecker of
//! [`Targets`](super::Targets), so that noise and levels are those that it is scored at.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::lessons;
use super::shown::Shown;
use super::targets::Targets;
use crate::camera::{Camera, CameraError, OpticalImages};
use crate::l3::{Axes, L3Error, Levels, Pair, Pipeline, Solver, Statistics, Textures, Training};
use crate::numeric::Planes;
use crate::scene::{self, Setting, macbeth};
use crate::sensor::{Cfa, NoiseMode, PixelSpectra};
use crate::spectrum::{Observer, Spectrum};

/// Where the lowest and the highest level end, as shares of the response to white: below and above, the noise and what
/// transforms make of it change little.
const LEVEL_RANGE: [f64; 2] = [0.03, 0.6];
/// The response of a channel that does not see the light, relative to the brightest: levels need one.
const LEAST_WHITE: f64 = 1e-3;
/// How many patches an even surface counts for at each position. Of 16, 64, 128 and 256, tried on five sets of Gaussian filters, the
/// first that has less ΔE on the surfaces than a matrix fitted to them in every set, by ΔE 1976 and 2000. More costs a
/// little resolution, and colour on black-and-white patterns.
const SURFACE_PATCHES: u32 = 128;
/// Y in pictures.
const LUMINANCE: usize = 1;

/// How the pipelines of designs are learned.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct LessonSettings {
    /// Side of the patch, pixels: 3, 5, 7, 9 or 11.
    pub side: usize,
    /// Number of response levels, 1 to 256. Nothing that is scored lies far from the exposure that is trained for, so few do.
    pub levels: usize,
    /// What is told apart by structure.
    pub textures: Textures,
    /// What kernels minimise.
    pub solver: Solver,
    /// Side of the square of pixels that is learned from, 16 to 1024: a design takes time in proportion to its square.
    pub size_px: usize,
}

impl Default for LessonSettings {
    fn default() -> Self {
        Self { side: 7, levels: 4, textures: Textures::Oriented, solver: Solver::Wiener, size_px: 320 }
    }
}

impl LessonSettings {
    /// Checks every field.
    ///
    /// # Errors
    /// [`L3Error::Parameter`] with the first field that is out of its range.
    pub fn validate(&self) -> Result<(), L3Error> {
        let range = |name, value: usize, fits: bool, expected| {
            if fits { Ok(()) } else { Err(L3Error::Parameter { name, value: value as f64, expected }) }
        };
        range("side", self.side, [3, 5, 7, 9, 11].contains(&self.side), "3, 5, 7, 9 or 11 pixels")?;
        range("levels", self.levels, (1..=256).contains(&self.levels), "1 to 256")?;
        range("size_px", self.size_px, (16..=1024).contains(&self.size_px), "16 to 1024 pixels")
    }
}

/// What training needs of a lens, pixels and light, whatever the filters: kept like [`Targets`](super::Targets).
#[derive(Debug, Clone)]
pub struct Lessons {
    settings: LessonSettings,
    /// Finds the exposure.
    chart: Arc<Shown>,
    camera: Camera,
    pixels: Arc<PixelSpectra>,
    /// X, Y, Z that the observer sees, per pixel.
    seen: Arc<Planes>,
    /// Even surfaces: radiance, and X, Y, Z as he sees them, where white in full light is Y = 1.
    surfaces: Arc<Vec<(Spectrum, [f64; 3])>>,
    /// Y that he sees of white.
    white_y: f64,
    light: Spectrum,
    seed: u64,
}

impl Lessons {
    /// The lessons before the camera of targets, whatever its filters. `images` may keep optical images, as for
    /// [`evaluate`](crate::camera::evaluate); luminance, light and seed of the noise are those of the targets.
    ///
    /// # Errors
    /// When a setting is out of its range or a stage refuses.
    pub fn new(
        targets: &Targets,
        settings: &LessonSettings,
        images: OpticalImages<'_>,
    ) -> Result<Self, CameraError> {
        settings.validate()?;
        let size = settings.size_px;
        let setting = targets.setting().clone();
        let light = macbeth::chart(1, &setting)?.illuminant().clone();
        let camera = targets.chart.camera.with_size(size, size);
        let horizontal_fov_deg = camera.field_of_view_deg(size, setting.distance_m)?;
        let wide = Setting { horizontal_fov_deg, ..setting.clone() };
        let key = format!("lessons {size} {wide:?} {:?}", camera.optics);
        let image =
            images(&key, &|| Ok(camera.optics.image(&lessons::scene(&camera, size, &light, &wide)?)?))?;
        let luminance_cd_m2 = Observer::Cie1931.xyz_from_photons(&light)?[LUMINANCE];
        let white = scene::uniform(8, 8, &Setting { luminance_cd_m2, ..setting })?;
        let small = camera.with_size(1, 1);
        let white = small.seen_by_observer(&small.optics.image(&white)?)?;
        let xyz = |s: Spectrum| {
            let seen = Observer::Cie1931.xyz_from_photons(&s)?.map(|v| v / luminance_cd_m2);
            Ok::<_, CameraError>((s, seen))
        };
        let surfaces = lessons::surfaces(&camera, &light)?.into_iter().map(xyz).collect::<Result<_, _>>()?;
        Ok(Self {
            surfaces: Arc::new(surfaces),
            settings: settings.clone(),
            pixels: Arc::new(PixelSpectra::new(&camera.sensor, &image)?),
            seen: Arc::new(camera.seen_by_observer(&image)?),
            white_y: white.plane(LUMINANCE).iter().map(|&y| f64::from(y)).sum(),
            chart: targets.chart.clone(),
            camera,
            light,
            seed: targets.seed(),
        })
    }

    /// The pipeline of a colour filter array, and how many rows away samples lie at most that a pixel of its pictures depends on.
    ///
    /// # Errors
    /// When the filters pass no light, the mosaic has more channels than L³ tells apart, or a stage refuses.
    pub fn pipeline(&self, cfa: &Cfa) -> Result<(Pipeline, usize), CameraError> {
        let (_, exposure) = self.chart.through(cfa)?;
        let camera = self.camera.with_cfa(cfa.clone());
        let y = &Observer::Cie1931.photon_weights(camera.grid())?[LUMINANCE];
        let scale = camera.exposure_scale(&exposure, &self.light, y)?;
        let responsivities = camera.responsivities()?;
        let responses = |light: &Spectrum| -> Vec<f64> {
            let of = |r: &Spectrum| r.values().iter().zip(light.values()).map(|(r, l)| r * l).sum();
            responsivities.iter().map(of).collect()
        };
        let white = responses(&self.light);
        let brightest = white.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        // As exposed, the brightest channel's response to white is what Y of white is.
        let full = scale * self.white_y;
        let white: Vec<f64> = white.iter().map(|w| (w / brightest).max(LEAST_WHITE) * full).collect();
        let noise = camera.sensor.signal_noise(&exposure)?;
        let axes = Axes::new(cfa.mosaic().clone(), self.settings.side, self.levels(cfa, &white)?, noise)?
            .with_levels_by_position(&white)?
            .with_textures(self.settings.textures);
        let mut statistics = Statistics::new(axes, ["X", "Y", "Z"].map(String::from).to_vec(), false)?;
        let raw = camera.sensor.capture_ideal(&*self.pixels, &exposure)?;
        let seen = camera.sensor.capture(&*self.pixels, &exposure, NoiseMode::All, self.seed)?;
        let mut target = Planes::clone(&self.seen);
        target.data_mut().iter_mut().for_each(|v| *v *= scale as f32);
        statistics.add(&Pair { raw: &raw, seen: Some(&seen), target: &target })?;
        for (radiance, xyz) in &*self.surfaces {
            let samples: Vec<f64> = responses(radiance).iter().map(|r| r / brightest * full).collect();
            statistics.add_even(&samples, &xyz.map(|v| v * full), SURFACE_PATCHES)?;
        }
        let training = Training { solver: self.settings.solver, ..Training::default() };
        let pipeline = training.solve(&statistics, String::new())?;
        let reach = pipeline.reach();
        Ok((pipeline, reach))
    }

    /// Cuts in equal ratios, as mean responses over the tile.
    fn levels(&self, cfa: &Cfa, white: &[f64]) -> Result<Levels, L3Error> {
        let cells = cfa.mosaic().cells();
        let sum: f64 = cells.iter().filter_map(|&c| white.get(usize::from(c))).sum();
        let mean = sum / cells.len().max(1) as f64;
        let [least, most] = LEVEL_RANGE;
        let cuts = self.settings.levels.saturating_sub(1);
        let cut = |i: usize| (mean * least * libm::pow(most / least, (i as f64 + 0.5) / cuts as f64)) as f32;
        Levels::new((0..cuts).map(cut).collect())
    }
}
