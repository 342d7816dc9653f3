//! The targets of [`evaluate`](crate::camera::evaluate), imaged once so that many colour filter arrays can be scored fast.
//!
//! The light on every pixel is gathered once ([`PixelSpectra`](crate::sensor::PixelSpectra)). Each design then needs only the
//! computations that depend on its filters: the integral over wavelength, the noise of the grey patches, the processing and
//! the metrics. Only the rows that a metric measures are rendered, extended by the reach of the processing. Scores equal
//! those of `evaluate` up to rounding.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

use super::imaged_scene::ImagedScene;
use super::patch_light::PatchLight;
use super::scenes::{SceneTarget, StudyScene};
use super::scores::{AliasingScores, ColorScores, EdgeScores, Metric, MetricResult, MetricTarget, Scores};
use crate::camera::evaluate::zone_plate_aliasing;
use crate::camera::target::{EDGE_REGION, Target, edge_mtf50};
use crate::camera::{Camera, CameraError, ColorimetricObserver, EvaluationSettings, OpticalImages, chart};
use crate::color::Image;
use crate::isp::tile_filter::TileFilter;
use crate::isp::{Classic, ColorFit, Demosaic, Isp, IspError, WhiteBalance};
use crate::metrics::Rect;
use crate::metrics::luminance_noise::luminance_noise;
use crate::numeric::Planes;
use crate::scene::{Setting, macbeth};
use crate::sensor::{Cfa, ColorArchitecture, Exposure, Mosaic, NoiseMode, RawImage, Sensor};
use crate::spectrum::{Spectrum, WavelengthGrid};

/// The targets imaged on the pixels of a camera, ready for any colour filter array.
#[derive(Debug, Clone)]
pub struct Targets {
    /// Illuminant, luminance and distance of the targets.
    pub(super) setting: Setting,
    pub(super) chart: Arc<ImagedScene>,
    /// The targets that the metrics need. The chart is always imaged, because the exposure is found on it.
    measured: Vec<MetricTarget>,
    edge: Option<ImagedScene>,
    fit: ColorFit,
    /// `None` when no metric is one of the spectral sensitivities alone.
    observer: Option<ColorimetricObserver>,
    /// X, Y, Z of the reference patches.
    expected: Vec<[f64; 3]>,
    /// Maximum over the pixels of the chart at each wavelength, photons s⁻¹ nm⁻¹.
    brightest: Vec<f64>,
    zone_plate: Option<ZonePlate>,
    scenes: Vec<SceneTarget>,
    /// Seed of the noise.
    pub(super) seed: u64,
    cache: Arc<Mutex<PatchLightCache>>,
}

/// The light of the patches for the latest mosaics; `None` for a mosaic that needs the general path.
type PatchLightCache = VecDeque<(Mosaic, Option<Arc<PatchLight>>)>;

/// Capacity of the cache. A study of filters has one mosaic for each number of colours.
const CACHED_MOSAICS: usize = 8;
/// Fraction of saturation above which the chart may clip.
const CLIPPING: f64 = 0.9999;

/// The zone plate imaged on the camera, with the reference seen by the standard observer.
#[derive(Debug, Clone)]
struct ZonePlate {
    imaged: ImagedScene,
    reference: Image,
}

impl ZonePlate {
    fn new(target: &Target, images: OpticalImages<'_>) -> Result<Self, CameraError> {
        let image = images(&target.key, &|| target.image())?;
        let reference = target.camera.reference(&image)?;
        Ok(Self { reference, imaged: ImagedScene::new(target.camera.clone(), image)? })
    }
}

/// The scores on the chart and the edge.
struct Charts {
    colors: MetricResult<ColorScores>,
    noise: MetricResult<f64>,
    edge: MetricResult<EdgeScores>,
    /// Exposure time of the ColorChecker, s.
    time_s: f64,
    /// The share of its samples that saturate without noise, percent.
    saturated_percent: f64,
}

/// A capture of the edge without noise.
struct EdgeCapture {
    raw: RawImage,
    /// The region that is measured.
    region: Rect,
    time_s: f64,
    saturated_percent: f64,
}

impl EdgeCapture {
    fn new(imaged: &ImagedScene, cfa: &Cfa, reach: usize) -> Result<Self, CameraError> {
        let (camera, exposure) = imaged.with_cfa(cfa)?;
        let (first, end) = (EDGE_REGION.row, EDGE_REGION.row + EDGE_REGION.rows);
        let (sensor, row) = imaged.band(&camera.sensor, first, end, reach);
        let raw = sensor.capture_ideal(&imaged.pixels, &exposure)?;
        let saturated_percent = raw.saturated_percent();
        Ok(Self { raw, region: relative_to(EDGE_REGION, row), time_s: exposure.time_s, saturated_percent })
    }
}

/// A rectangle of a target, relative to an image that begins at row `row` of the target.
fn relative_to(rect: Rect, row: usize) -> Rect {
    Rect { row: rect.row - row, ..rect }
}

/// Photoelectrons per photon times the wavelength step, for each channel.
pub(super) fn response(sensor: &Sensor, grid: WavelengthGrid) -> Result<Vec<Vec<f64>>, CameraError> {
    let on_grid = sensor.spectral_responsivity_on(grid)?;
    Ok(on_grid.iter().map(|r| r.values().iter().map(|v| v * grid.step_nm()).collect()).collect())
}

/// Whether every sample is the light of one pixel through one filter.
pub(super) fn has_independent_samples(sensor: &Sensor) -> bool {
    let is_alone = sensor.crosstalk.is_none() && sensor.binning.is_none();
    is_alone && sensor.architecture == ColorArchitecture::Mosaic
}

/// Normalised samples per photoelectron per second.
pub(super) fn samples_per_rate(sensor: &Sensor, exposure: &Exposure) -> Result<f64, CameraError> {
    let levels = sensor.raw_levels(exposure)?;
    let volts_per_rate = exposure.time_s * sensor.volts_per_electron(exposure) * exposure.analog_gain;
    Ok(volts_per_rate / (levels.white_v - levels.black_v))
}

impl Targets {
    /// Images the targets that the metrics need on the pixels of a camera. [`Metric::OF_SCENES`] are measured on `scenes`;
    /// `images` may cache optical images, as in `evaluate`.
    ///
    /// # Errors
    /// When a stage fails.
    pub fn new(
        camera: &Camera,
        settings: &EvaluationSettings,
        metrics: &[Metric],
        scenes: &[StudyScene],
        images: OpticalImages<'_>,
    ) -> Result<Self, CameraError> {
        let setting = settings.setting(camera.grid());
        let measured: Vec<MetricTarget> = metrics.iter().map(|m| m.target()).collect();
        let needs = |target| measured.contains(&target);
        let light = settings.illuminant.photons(camera.grid())?;
        let chart = Arc::new(ImagedScene::of_target(&Target::chart(camera, &setting)?, images)?);
        let edge = || ImagedScene::of_target(&Target::edge(camera, &setting)?, images);
        let zone_plate = || ZonePlate::new(&Target::zone_plate(camera, &setting)?, images);
        let scene_target = |scene| SceneTarget::new(camera, scene, &setting, images);
        let scenes = if needs(MetricTarget::Scenes) { scenes } else { &[] };
        Ok(Self {
            brightest: chart.brightest(),
            chart,
            cache: Arc::default(),
            edge: needs(MetricTarget::Edge).then(edge).transpose()?,
            zone_plate: needs(MetricTarget::ZonePlate).then(zone_plate).transpose()?,
            scenes: scenes.iter().map(scene_target).collect::<Result<_, _>>()?,
            fit: camera.color_fit(&light)?,
            observer: needs(MetricTarget::Sensitivities)
                .then(|| ColorimetricObserver::new(&light))
                .transpose()?,
            expected: chart::expected(&light)?,
            measured,
            setting,
            seed: settings.seed,
        })
    }

    /// The irradiance at the metered point of the chart; `None` when the exposure rule does not meter a point.
    #[must_use]
    pub fn metered(&self) -> Option<&Spectrum> {
        self.chart.metered()
    }

    /// The scores of a colour filter array with the camera's own processing.
    ///
    /// # Errors
    /// When no exposure is found for the chart or the processing cannot be built. The scores hold the error of a target that
    /// cannot be measured.
    pub fn score(&self, cfa: &Cfa) -> Result<Scores, CameraError> {
        let (camera, exposure) = self.chart.with_cfa(cfa)?;
        let isp = camera.isp_fitted_to(&self.fit, WhiteBalance::None)?;
        let linear = match self.patch_light(isp.demosaic, cfa.mosaic())? {
            Some(patch_light) => self.score_linear(&camera, &exposure, &isp, &patch_light)?,
            None => None,
        };
        match linear {
            Some(charts) => Ok(self.with_pictures(charts, &camera, &isp)),
            None => self.score_with(cfa, &isp, isp.demosaic.reach(cfa.mosaic())?),
        }
    }

    /// The scores of a colour filter array with the given processing. Its pictures are X, Y, Z under the illuminant of the
    /// scene, not adapted, and each pixel depends on samples at most `reach` rows away.
    ///
    /// # Errors
    /// As [`Targets::score`].
    pub fn score_with(&self, cfa: &Cfa, isp: &dyn Isp, reach: usize) -> Result<Scores, CameraError> {
        let (camera, exposure) = self.chart.with_cfa(cfa)?;
        let patches = chart::patches();
        let colors = || {
            let mut measured = Vec::with_capacity(patches.len());
            for row in patches.chunks(macbeth::COLS) {
                let (raw, row) = self.chart_raw(&camera.sensor, &exposure, row, reach, None)?;
                measured.extend(chart::means(&isp.render(&raw)?, &row)?);
            }
            self.colors(&measured)
        };
        let noise = || {
            let (raw, greys) = self.greys_raw(&camera.sensor, &exposure, reach)?;
            Ok(luminance_noise(isp.render(&raw)?.planes(), chart::LUMINANCE, &greys)?.mean_percent)
        };
        let edge = |imaged: &ImagedScene| {
            let edge = EdgeCapture::new(imaged, cfa, reach)?;
            self.edge(&edge, isp.render(&edge.raw)?.planes(), chart::LUMINANCE)
        };
        let exposed = (exposure.time_s, self.saturated_percent(&camera.sensor, &exposure)?);
        let charts = self.charts(exposed, &colors, &noise, &edge);
        Ok(self.with_pictures(charts, &camera, isp))
    }

    /// Measures the chart and the edge where the metrics need them.
    fn charts(
        &self,
        (time_s, saturated_percent): (f64, f64),
        colors: &dyn Fn() -> Result<ColorScores, CameraError>,
        noise: &dyn Fn() -> Result<f64, CameraError>,
        edge: &dyn Fn(&ImagedScene) -> Result<EdgeScores, CameraError>,
    ) -> Charts {
        Charts {
            colors: self.measured.contains(&MetricTarget::ColorPatches).then(colors),
            noise: self.measured.contains(&MetricTarget::GreyPatches).then(noise),
            edge: self.edge.as_ref().map(edge),
            time_s,
            saturated_percent,
        }
    }

    /// Adds the scores of the sensor, and those on the zone plate and the scenes, which need whole pictures.
    fn with_pictures(&self, charts: Charts, camera: &Camera, isp: &dyn Isp) -> Scores {
        let cfa = &camera.sensor.cfa;
        Scores {
            sensor: self.observer.as_ref().map(|observer| observer.colorimetry(camera)),
            colors: charts.colors,
            luminance_noise_percent: charts.noise,
            edge: charts.edge,
            zone_plate: self.zone_plate.as_ref().map(|zone| self.aliasing(zone, cfa, isp)),
            scenes: self.scenes.iter().map(|scene| scene.score(cfa, isp, self.seed)).collect(),
            macbeth_time_s: charts.time_s,
            macbeth_saturated_percent: charts.saturated_percent,
        }
    }

    fn aliasing(&self, zone: &ZonePlate, cfa: &Cfa, isp: &dyn Isp) -> Result<AliasingScores, CameraError> {
        let (camera, exposure) = zone.imaged.with_cfa(cfa)?;
        let picture = isp.render(&camera.sensor.capture_ideal(&zone.imaged.pixels, &exposure)?)?;
        let found = zone_plate_aliasing(&picture, &zone.reference, &self.setting)?;
        Ok(AliasingScores {
            aliasing_percent: found.total_percent,
            color_aliasing_percent: found.color_percent,
        })
    }

    /// The light of the patches for a mosaic, from the cache or computed; `None` when the mosaic needs the general path.
    fn patch_light(
        &self,
        demosaic: Demosaic,
        mosaic: &Mosaic,
    ) -> Result<Option<Arc<PatchLight>>, CameraError> {
        if !has_independent_samples(&self.chart.camera.sensor) {
            return Ok(None);
        }
        let cache = || self.cache.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, found)) = cache().iter().find(|(m, _)| m == mosaic) {
            return Ok(found.clone());
        }
        let patches = chart::patches();
        // Distance from the measured regions to the border: the reach must not exceed it.
        let clear = patches.iter().chain([&EDGE_REGION]).map(|p| p.row.min(p.col)).min().unwrap_or(0);
        let near = demosaic.interpolation(mosaic)?.filter(|i| i.reach() <= clear);
        let made = near.map(|i| Arc::new(PatchLight::new(i, mosaic, &self.chart.pixels, &patches)));
        let mut cache = cache();
        if cache.len() >= CACHED_MOSAICS {
            cache.pop_front();
        }
        cache.push_back((mosaic.clone(), made.clone()));
        Ok(made)
    }

    /// [`Targets::score_with`] for processing that is linear in the samples: colours from the light of the patches, and only the
    /// luminance plane for edge and noise. `None` when the chart may clip or the picture is white-balanced.
    fn score_linear(
        &self,
        camera: &Camera,
        exposure: &Exposure,
        isp: &Classic,
        patch_light: &PatchLight,
    ) -> Result<Option<Charts>, CameraError> {
        let (sensor, mosaic) = (&camera.sensor, camera.sensor.cfa.mosaic());
        let reach = patch_light.interpolation.reach();
        let response = response(sensor, self.chart.pixels.grid())?;
        let levels = sensor.raw_levels(exposure)?;
        // An offset below the range of the converter clips the dark signal.
        let dark_clips =
            (levels.black_v - exposure.zero_v()).abs() > 1e-9 * (levels.white_v - levels.black_v);
        let gain = samples_per_rate(sensor, exposure)?;
        let brightest = self.brightest_rate(&response) * gain;
        if dark_clips || brightest > CLIPPING || isp.white_balance != WhiteBalance::None {
            return Ok(None);
        }
        let matrix = &isp.color_matrix;
        let xyz = |channels: Vec<f64>| matrix.xyz(&channels).map(|v| v * gain * isp.gain);
        let colors = || self.colors(&patch_light.channels(&response).map(xyz).collect::<Vec<_>>());

        let factors: Vec<f32> =
            matrix.xyz_from_camera().iter().map(|c| (c[chart::LUMINANCE] * isp.gain) as f32).collect();
        let luminance = TileFilter::new(&patch_light.interpolation, mosaic, &factors);
        let plane = |raw: &RawImage| -> Result<Planes, CameraError> {
            let plane = luminance.apply(&raw.normalized(), raw.cols())?;
            Ok(Planes::new(raw.rows(), raw.cols(), 1, plane).map_err(IspError::from)?)
        };
        let noise = || {
            let (raw, greys) = self.greys_raw(sensor, exposure, reach)?;
            Ok(luminance_noise(&plane(&raw)?, 0, &greys)?.mean_percent)
        };
        let edge = |imaged: &ImagedScene| {
            let edge = EdgeCapture::new(imaged, &sensor.cfa, reach)?;
            self.edge(&edge, &plane(&edge.raw)?, 0)
        };
        // Nothing of the chart clips.
        Ok(Some(self.charts((exposure.time_s, 0.0), &colors, &noise, &edge)))
    }

    /// A bound of the photoelectrons per second of every sample of the chart.
    fn brightest_rate(&self, response: &[Vec<f64>]) -> f64 {
        let bound =
            |response: &Vec<f64>| response.iter().zip(&self.brightest).map(|(r, b)| r * b).sum::<f64>();
        response.iter().map(bound).fold(0.0, f64::max)
    }

    /// The share of the samples of the chart that saturate without noise, percent. The chart is captured only where it may clip.
    fn saturated_percent(&self, sensor: &Sensor, exposure: &Exposure) -> Result<f64, CameraError> {
        let pixels = &self.chart.pixels;
        if has_independent_samples(sensor) {
            let rate = self.brightest_rate(&response(sensor, pixels.grid())?);
            if rate * samples_per_rate(sensor, exposure)? <= CLIPPING {
                return Ok(0.0);
            }
        }
        Ok(sensor.capture_ideal(pixels, exposure)?.saturated_percent())
    }

    /// The capture of a row of patches, without noise or with the noise of a seed, and the patches in it.
    fn chart_raw(
        &self,
        sensor: &Sensor,
        exposure: &Exposure,
        patches: &[Rect],
        reach: usize,
        seed: Option<u64>,
    ) -> Result<(RawImage, Vec<Rect>), CameraError> {
        let first = patches.iter().map(|p| p.row).min().unwrap_or(0);
        let end = patches.iter().map(|p| p.row + p.rows).max().unwrap_or(0);
        let (sensor, row) = self.chart.band(sensor, first, end, reach);
        let raw = match seed {
            None => sensor.capture_ideal(&self.chart.pixels, exposure)?,
            Some(seed) => sensor.capture(&self.chart.pixels, exposure, NoiseMode::All, seed)?,
        };
        Ok((raw, patches.iter().map(|&p| relative_to(p, row)).collect()))
    }

    /// The capture of the grey series with noise, and its patches.
    fn greys_raw(
        &self,
        sensor: &Sensor,
        exposure: &Exposure,
        reach: usize,
    ) -> Result<(RawImage, Vec<Rect>), CameraError> {
        self.chart_raw(sensor, exposure, &chart::patches()[chart::GREYS], reach, Some(self.seed))
    }

    fn colors(&self, measured: &[[f64; 3]]) -> Result<ColorScores, CameraError> {
        let found = chart::accuracy(measured, &self.expected)?;
        Ok(ColorScores { delta_e_76: found.delta_e_76.mean, delta_e_2000: found.delta_e_2000.mean })
    }

    fn edge(
        &self,
        edge: &EdgeCapture,
        picture: &Planes,
        luminance: usize,
    ) -> Result<EdgeScores, CameraError> {
        let mtf50 = edge_mtf50(picture, luminance, edge.region)?;
        Ok(EdgeScores {
            mtf50_cy_per_mm: mtf50.cy_per_mm(&self.chart.camera),
            mtf50_cy_per_px: mtf50.cy_per_px,
            mtf50_reliability: mtf50.reliability,
            time_s: edge.time_s,
            saturated_percent: edge.saturated_percent,
        })
    }
}
