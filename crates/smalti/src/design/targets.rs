//! The targets of [`evaluate`](crate::camera::evaluate) before one lens and one geometry of pixels, kept so that many colour
//! filter arrays are scored on them fast.
//!
//! The light on every pixel is gathered once ([`PixelSpectra`]). A design then costs what depends on its filters: an
//! integral over wavelength, the noise of the grey patches, its processing, the metrics. Only the rows are made
//! that a metric looks at, with the reach of the processing around them. Scores are those of `evaluate`, but for
//! rounding.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

use super::prepared::Prepared;
use crate::camera::evaluate::zone_plate_aliasing;
use crate::camera::target::{EDGE_REGION, Target, edge_mtf50};
use crate::camera::{Camera, CameraError, EvaluationSettings, OpticalImages, chart};
use crate::color::Image;
use crate::isp::tile_filter::TileFilter;
use crate::isp::{Classic, ColorFit, Demosaic, Isp, IspError, WhiteBalance};
use crate::metrics::Rect;
use crate::metrics::color_accuracy::ColorAccuracy;
use crate::metrics::luminance_noise::{LuminanceNoise, luminance_noise};
use crate::numeric::Planes;
use crate::optics::OpticalImage;
use crate::scene::{Setting, macbeth};
use crate::sensor::{
    Cfa, ColorArchitecture, Exposure, Mosaic, NoiseMode, PixelSpectra, RawImage, Sensor, Window,
};
use crate::spectrum::{Spectrum, WavelengthGrid};

/// The scores of a design.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scores {
    /// Colour difference of 1976 from the chart itself, mean over the patches.
    pub delta_e_76: f64,
    /// CIEDE2000 from the chart itself, mean over the patches.
    pub delta_e_2000: f64,
    /// Frequency at which the response to an edge falls to one half, cycles per mm on the sensor.
    pub mtf50_cy_per_mm: f64,
    /// The same in cycles per pixel.
    pub mtf50_cy_per_px: f64,
    /// `100 · std(Y) / mean(Y)`, mean over the grey series, percent.
    pub luminance_noise_percent: f64,
    /// Exposure time of the chart, s.
    pub macbeth_time_s: f64,
    /// Exposure time of the edge, s.
    pub edge_time_s: f64,
}

/// What of a zone plate's picture is not in the zone plate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AliasingScores {
    /// Energy in the picture of the zone plate that is not in the zone plate, percent.
    pub aliasing_percent: f64,
    /// The part of it that is colour.
    pub color_aliasing_percent: f64,
}

/// Targets, ready to be seen through any filters.
#[derive(Debug, Clone)]
pub struct Targets {
    setting: Setting,
    pub(super) chart: Arc<Shown>,
    edge: Shown,
    light: Spectrum,
    fit: ColorFit,
    /// X, Y, Z of the patches themselves.
    expected: Vec<[f64; 3]>,
    /// Photons s⁻¹ nm⁻¹, the most on any pixel of the chart at each wavelength.
    brightest: Vec<f64>,
    zone_plate: Option<ZonePlate>,
    seed: u64,
    kept: Arc<Mutex<Kept>>,
}

/// Mosaics with what scoring them needs; none where it cannot be done by filters.
type Kept = VecDeque<(Mosaic, Option<Arc<Prepared>>)>;

/// Mosaics of which is kept what scoring needs: those of a study of filters, one for each number of colours.
const KEPT_MOSAICS: usize = 8;
/// Share of saturation from which a chart may clip.
const CLIPS: f64 = 0.9999;

/// The zone plate in front of the camera, and as the standard observer sees it.
#[derive(Debug, Clone)]
struct ZonePlate {
    shown: Shown,
    reference: Image,
}

/// A target in front of the camera.
#[derive(Debug, Clone)]
pub(super) struct Shown {
    pub(super) camera: Camera,
    pixels: PixelSpectra,
    /// What the exposure rule looks at; `None` where the time is stated or the rule looks at the whole image.
    metered: Option<Spectrum>,
    image: Arc<OpticalImage>,
}

impl Shown {
    fn new(target: &Target, images: OpticalImages<'_>) -> Result<Self, CameraError> {
        let camera = target.camera.clone();
        let image = Arc::new(images(&target.key, &|| target.image())?);
        let pixels = PixelSpectra::new(&camera.sensor, &image)?;
        let metered = camera.metered(&image)?;
        Ok(Self { camera, pixels, metered, image })
    }

    /// The most light on any pixel at each wavelength.
    fn brightest(&self) -> Vec<f64> {
        let (window, grid) = (self.pixels.window(), self.pixels.grid());
        let most = |i: usize| {
            let rows = (window.row..window.row + window.rows).flat_map(|row| self.pixels.line(row, i));
            f64::from(rows.fold(0.0f32, |m, &v| m.max(v)))
        };
        (0..grid.len()).map(most).collect()
    }

    /// The camera of the target with another colour filter array, and the exposure that it finds.
    pub(super) fn through(&self, cfa: &Cfa) -> Result<(Camera, Exposure), CameraError> {
        let camera = self.camera.with_cfa(cfa.clone());
        let exposure = match &self.metered {
            Some(spectrum) => camera.exposure_metered(spectrum)?,
            None => camera.exposure(&self.image)?,
        };
        Ok((camera, exposure))
    }

    /// A sensor that reads the rows `first..end` with `reach` more on either side, beginning with a tile of the mosaic; and
    /// the first row.
    fn band(&self, sensor: &Sensor, first: usize, end: usize, reach: usize) -> (Sensor, usize) {
        let tile = sensor.cfa.mosaic().rows();
        let row = first.saturating_sub(reach) / tile * tile;
        let rows = (end + reach).min(sensor.rows) - row;
        let window = Window { row, col: 0, rows, cols: sensor.cols };
        (Sensor { window: Some(window), ..sensor.clone() }, row)
    }
}

/// The edge, captured.
struct EdgeCapture {
    raw: RawImage,
    /// Where it is measured.
    region: Rect,
    time_s: f64,
}

/// A rectangle of a target in an image whose first row is row `row` of the target.
fn below(rect: Rect, row: usize) -> Rect {
    Rect { row: rect.row - row, ..rect }
}

/// Photoelectrons per photon and nm, per channel.
fn response(sensor: &Sensor, grid: WavelengthGrid) -> Result<Vec<Vec<f64>>, CameraError> {
    let on_grid = sensor.spectral_responsivity_on(grid)?;
    Ok(on_grid.iter().map(|r| r.values().iter().map(|v| v * grid.step_nm()).collect()).collect())
}

impl Targets {
    /// The targets before a camera, whatever its filters. `images` may keep optical images, as for `evaluate`.
    ///
    /// # Errors
    /// When a stage refuses.
    pub fn new(
        camera: &Camera,
        settings: &EvaluationSettings,
        images: OpticalImages<'_>,
    ) -> Result<Self, CameraError> {
        let setting = settings.setting(camera.grid());
        let light = settings.illuminant.photons(camera.grid())?;
        let chart = Arc::new(Shown::new(&Target::chart(camera, &setting)?, images)?);
        Ok(Self {
            brightest: chart.brightest(),
            chart,
            zone_plate: None,
            kept: Arc::default(),
            edge: Shown::new(&Target::edge(camera, &setting)?, images)?,
            fit: camera.color_fit(&light)?,
            expected: chart::expected(&light)?,
            light,
            setting,
            seed: settings.seed,
        })
    }

    /// With the zone plate, which costs some milliseconds a design.
    ///
    /// # Errors
    /// When a stage refuses.
    pub fn with_zone_plate(self, images: OpticalImages<'_>) -> Result<Self, CameraError> {
        let shown = Shown::new(&Target::zone_plate(&self.chart.camera, &self.setting)?, images)?;
        let reference = shown.camera.reference(&shown.image)?;
        Ok(Self { zone_plate: Some(ZonePlate { shown, reference }), ..self })
    }

    /// The light, photons.
    #[must_use]
    pub fn light(&self) -> &Spectrum {
        &self.light
    }

    /// What the targets are lit by and how far they are.
    pub(super) fn setting(&self) -> &Setting {
        &self.setting
    }

    /// Seed of the noise.
    pub(super) fn seed(&self) -> u64 {
        self.seed
    }

    /// The scores of a colour filter array with the camera's own processing.
    ///
    /// # Errors
    /// When a stage refuses, or a metric cannot be computed.
    pub fn score(&self, cfa: &Cfa) -> Result<Scores, CameraError> {
        let (camera, exposure) = self.chart.through(cfa)?;
        let isp = camera.isp_fitted_to(&self.fit, WhiteBalance::None)?;
        let linear = match self.prepared(isp.demosaic, cfa.mosaic())? {
            Some(prepared) => self.score_linear(&camera, &exposure, &isp, &prepared)?,
            None => None,
        };
        match linear {
            Some(scores) => Ok(scores),
            None => self.score_with(cfa, &isp, isp.demosaic.reach(cfa.mosaic())?),
        }
    }

    /// Aliasing of a colour filter array with the camera's own processing; `None` without a zone plate.
    ///
    /// # Errors
    /// When a stage refuses.
    pub fn aliasing(&self, cfa: &Cfa) -> Result<Option<AliasingScores>, CameraError> {
        if self.zone_plate.is_none() {
            return Ok(None);
        }
        let camera = self.chart.camera.with_cfa(cfa.clone());
        self.aliasing_with(cfa, &camera.isp_fitted_to(&self.fit, WhiteBalance::None)?)
    }

    /// Aliasing with processing of one's own, as for [`Targets::score_with`].
    ///
    /// # Errors
    /// When a stage refuses.
    pub fn aliasing_with(&self, cfa: &Cfa, isp: &dyn Isp) -> Result<Option<AliasingScores>, CameraError> {
        let Some(zone) = &self.zone_plate else { return Ok(None) };
        let (camera, exposure) = zone.shown.through(cfa)?;
        let picture = isp.render(&camera.sensor.capture_ideal(&zone.shown.pixels, &exposure)?)?;
        let found = zone_plate_aliasing(&picture, &zone.reference, &self.setting)?;
        Ok(Some(AliasingScores {
            aliasing_percent: found.total_percent,
            color_aliasing_percent: found.color_percent,
        }))
    }

    /// What scoring a mosaic needs, kept from the last designs; `None` where it cannot be done by filters.
    fn prepared(&self, demosaic: Demosaic, mosaic: &Mosaic) -> Result<Option<Arc<Prepared>>, CameraError> {
        let sensor = &self.chart.camera.sensor;
        if sensor.crosstalk.is_some() || sensor.architecture != ColorArchitecture::Mosaic {
            return Ok(None);
        }
        let kept = || self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, found)) = kept().iter().find(|(m, _)| m == mosaic) {
            return Ok(found.clone());
        }
        let made = Prepared::new(demosaic, mosaic, &self.chart.pixels, &chart::patches())?.map(Arc::new);
        let mut kept = kept();
        if kept.len() >= KEPT_MOSAICS {
            kept.pop_front();
        }
        kept.push_back((mosaic.clone(), made.clone()));
        Ok(made)
    }

    /// As [`Targets::score_with`], by what processing is that is linear in the samples: colours from the light on the patches,
    /// one plane of luminance for edge and noise. `None` where the chart may clip, or the tile is so large that patches lie too
    /// near the border.
    fn score_linear(
        &self,
        camera: &Camera,
        exposure: &Exposure,
        isp: &Classic,
        prepared: &Prepared,
    ) -> Result<Option<Scores>, CameraError> {
        let (sensor, mosaic) = (&camera.sensor, camera.sensor.cfa.mosaic());
        let patches = chart::patches();
        let reach = prepared.interpolation.reach();
        let clear = patches.iter().chain([&EDGE_REGION]).map(|p| p.row.min(p.col)).min().unwrap_or(0);
        let response = response(sensor, self.chart.pixels.grid())?;
        let levels = sensor.raw_levels(exposure)?;
        let range_v = levels.white_v - levels.black_v;
        // A converter that cannot show no light, because the offset is below its range, clips the dark.
        let dark_v = exposure.analog_offset_v * exposure.analog_gain;
        let dark_clips = (levels.black_v - dark_v).abs() > 1e-9 * range_v;
        // Normalised samples per photoelectron per second.
        let gain = exposure.time_s * sensor.pixel.conversion_gain_v_per_e * exposure.analog_gain / range_v;
        let most =
            |response: &Vec<f64>| response.iter().zip(&self.brightest).map(|(r, b)| r * b).sum::<f64>();
        let brightest = response.iter().map(most).fold(0.0, f64::max) * gain;
        if dark_clips || brightest > CLIPS || reach > clear || isp.white_balance != WhiteBalance::None {
            return Ok(None);
        }
        let matrix = &isp.color_matrix;
        let xyz = |channels: Vec<f64>| matrix.xyz(&channels).map(|v| v * gain * isp.gain);
        let measured: Vec<[f64; 3]> = prepared.channels(&response).map(xyz).collect();
        let colors = chart::accuracy(&measured, &self.expected)?;

        let factors: Vec<f32> =
            matrix.xyz_from_camera().iter().map(|c| (c[chart::LUMINANCE] * isp.gain) as f32).collect();
        let luminance = TileFilter::new(&prepared.interpolation, mosaic, &factors);
        let plane = |raw: &RawImage| -> Result<Planes, CameraError> {
            let plane = luminance.apply(&raw.normalized(), raw.cols())?;
            Ok(Planes::new(raw.rows(), raw.cols(), 1, plane).map_err(IspError::from)?)
        };
        let (raw, greys) =
            self.chart_raw(sensor, exposure, &patches[chart::GREYS], reach, Some(self.seed))?;
        let noise = luminance_noise(&plane(&raw)?, 0, &greys)?;
        let edge = self.edge_raw(&sensor.cfa, reach)?;
        let mtf50_cy_per_px = edge_mtf50(&plane(&edge.raw)?, 0, edge.region)?;
        Ok(Some(self.scores(&colors, &noise, mtf50_cy_per_px, [exposure.time_s, edge.time_s])))
    }

    /// The scores with processing of one's own, which makes X, Y, Z as they are under the light of raw samples. A pixel of its
    /// picture depends on samples at most `reach` rows away.
    ///
    /// # Errors
    /// When a stage refuses, or a metric cannot be computed.
    pub fn score_with(&self, cfa: &Cfa, isp: &dyn Isp, reach: usize) -> Result<Scores, CameraError> {
        let (camera, exposure) = self.chart.through(cfa)?;
        let patches = chart::patches();
        let mut measured = Vec::with_capacity(patches.len());
        for row in patches.chunks(macbeth::COLS) {
            let (raw, row) = self.chart_raw(&camera.sensor, &exposure, row, reach, None)?;
            measured.extend(chart::means(&isp.render(&raw)?, &row)?);
        }
        let colors = chart::accuracy(&measured, &self.expected)?;
        let (raw, greys) =
            self.chart_raw(&camera.sensor, &exposure, &patches[chart::GREYS], reach, Some(self.seed))?;
        let noise = luminance_noise(isp.render(&raw)?.planes(), chart::LUMINANCE, &greys)?;
        let edge = self.edge_raw(cfa, reach)?;
        let picture = isp.render(&edge.raw)?;
        let mtf50_cy_per_px = edge_mtf50(picture.planes(), chart::LUMINANCE, edge.region)?;
        Ok(self.scores(&colors, &noise, mtf50_cy_per_px, [exposure.time_s, edge.time_s]))
    }

    /// The capture of a row of patches, without noise or with that of a seed, and where the patches lie in it.
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
        Ok((raw, patches.iter().map(|&p| below(p, row)).collect()))
    }

    /// The capture of the edge without noise.
    fn edge_raw(&self, cfa: &Cfa, reach: usize) -> Result<EdgeCapture, CameraError> {
        let (camera, exposure) = self.edge.through(cfa)?;
        let (first, end) = (EDGE_REGION.row, EDGE_REGION.row + EDGE_REGION.rows);
        let (sensor, row) = self.edge.band(&camera.sensor, first, end, reach);
        let raw = sensor.capture_ideal(&self.edge.pixels, &exposure)?;
        Ok(EdgeCapture { raw, region: below(EDGE_REGION, row), time_s: exposure.time_s })
    }

    fn scores(
        &self,
        colors: &ColorAccuracy,
        noise: &LuminanceNoise,
        mtf50_cy_per_px: f64,
        [macbeth_time_s, edge_time_s]: [f64; 2],
    ) -> Scores {
        Scores {
            delta_e_76: colors.delta_e_76.mean,
            delta_e_2000: colors.delta_e_2000.mean,
            mtf50_cy_per_mm: mtf50_cy_per_px / (self.chart.camera.sensor.pixel.pitch_m * 1e3),
            mtf50_cy_per_px,
            luminance_noise_percent: noise.mean_percent,
            macbeth_time_s,
            edge_time_s,
        }
    }
}
