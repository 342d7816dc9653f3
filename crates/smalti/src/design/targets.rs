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
use super::scenes::{StudyScene, View};
use super::scores::{AliasingScores, Asked, ColorScores, EdgeScores, Metric, Scores, Sight};
use super::shown::Shown;
use crate::camera::evaluate::zone_plate_aliasing;
use crate::camera::target::{EDGE_REGION, Target, edge_mtf50};
use crate::camera::{Camera, CameraError, EvaluationSettings, OpticalImages, chart};
use crate::color::Image;
use crate::isp::tile_filter::TileFilter;
use crate::isp::{Classic, ColorFit, Demosaic, Isp, IspError, WhiteBalance};
use crate::metrics::Rect;
use crate::metrics::luminance_noise::luminance_noise;
use crate::numeric::Planes;
use crate::scene::{Setting, macbeth};
use crate::sensor::{Cfa, ColorArchitecture, Exposure, Mosaic, NoiseMode, RawImage, Sensor};
use crate::spectrum::{Spectrum, WavelengthGrid};

/// Targets, ready to be seen through any filters.
#[derive(Debug, Clone)]
pub struct Targets {
    setting: Setting,
    pub(super) chart: Arc<Shown>,
    /// What metrics look at; the chart is there in any case, for exposure.
    sights: Vec<Sight>,
    edge: Option<Shown>,
    light: Spectrum,
    fit: ColorFit,
    /// X, Y, Z of the patches themselves.
    expected: Vec<[f64; 3]>,
    /// Photons s⁻¹ nm⁻¹, the most on any pixel of the chart at each wavelength.
    brightest: Vec<f64>,
    zone_plate: Option<ZonePlate>,
    scenes: Vec<View>,
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

impl ZonePlate {
    fn new(target: &Target, images: OpticalImages<'_>) -> Result<Self, CameraError> {
        let shown = Shown::target(target, images)?;
        Ok(Self { reference: shown.camera.reference(shown.image())?, shown })
    }
}

/// The scores of chart and edge.
struct Charts {
    colors: Asked<ColorScores>,
    noise: Asked<f64>,
    edge: Asked<EdgeScores>,
}

/// The edge, captured without noise.
struct EdgeCapture {
    raw: RawImage,
    /// Where it is measured.
    region: Rect,
    time_s: f64,
}

impl EdgeCapture {
    fn new(shown: &Shown, cfa: &Cfa, reach: usize) -> Result<Self, CameraError> {
        let (camera, exposure) = shown.through(cfa)?;
        let (first, end) = (EDGE_REGION.row, EDGE_REGION.row + EDGE_REGION.rows);
        let (sensor, row) = shown.band(&camera.sensor, first, end, reach);
        let raw = sensor.capture_ideal(&shown.pixels, &exposure)?;
        Ok(Self { raw, region: below(EDGE_REGION, row), time_s: exposure.time_s })
    }
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
    /// What metrics look at before a camera, whatever its filters; `scenes` are those that [`Metric::OF_SCENES`] are of. `images`
    /// may keep optical images, as for `evaluate`.
    ///
    /// # Errors
    /// When a stage refuses.
    pub fn new(
        camera: &Camera,
        settings: &EvaluationSettings,
        metrics: &[Metric],
        scenes: &[StudyScene],
        images: OpticalImages<'_>,
    ) -> Result<Self, CameraError> {
        let setting = settings.setting(camera.grid());
        let sights: Vec<Sight> = metrics.iter().map(|m| m.sight()).collect();
        let looks = |sight| sights.contains(&sight);
        let light = settings.illuminant.photons(camera.grid())?;
        let chart = Arc::new(Shown::target(&Target::chart(camera, &setting)?, images)?);
        let edge = || Shown::target(&Target::edge(camera, &setting)?, images);
        let zone_plate = || ZonePlate::new(&Target::zone_plate(camera, &setting)?, images);
        let view = |scene| View::new(camera, scene, &setting, images);
        let scenes = if looks(Sight::Scenes) { scenes } else { &[] };
        Ok(Self {
            brightest: chart.brightest(),
            chart,
            kept: Arc::default(),
            edge: looks(Sight::Edge).then(edge).transpose()?,
            zone_plate: looks(Sight::ZonePlate).then(zone_plate).transpose()?,
            scenes: scenes.iter().map(view).collect::<Result<_, _>>()?,
            fit: camera.color_fit(&light)?,
            expected: chart::expected(&light)?,
            sights,
            light,
            setting,
            seed: settings.seed,
        })
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
    /// When no exposure is found before the chart, or the processing cannot be made; what fails on a target stands in its
    /// scores.
    pub fn score(&self, cfa: &Cfa) -> Result<Scores, CameraError> {
        let (camera, exposure) = self.chart.through(cfa)?;
        let isp = camera.isp_fitted_to(&self.fit, WhiteBalance::None)?;
        let linear = match self.prepared(isp.demosaic, cfa.mosaic())? {
            Some(prepared) => self.score_linear(&camera, &exposure, &isp, &prepared)?,
            None => None,
        };
        match linear {
            Some(charts) => Ok(self.with_pictures(charts, cfa, &isp, exposure.time_s)),
            None => self.score_with(cfa, &isp, isp.demosaic.reach(cfa.mosaic())?),
        }
    }

    /// The scores with processing of one's own, which makes X, Y, Z as they are under the light of raw samples. A pixel of its
    /// picture depends on samples at most `reach` rows away.
    ///
    /// # Errors
    /// As [`Targets::score`].
    pub fn score_with(&self, cfa: &Cfa, isp: &dyn Isp, reach: usize) -> Result<Scores, CameraError> {
        let (camera, exposure) = self.chart.through(cfa)?;
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
        let edge = |shown: &Shown| {
            let edge = EdgeCapture::new(shown, cfa, reach)?;
            self.edge(&edge, isp.render(&edge.raw)?.planes(), chart::LUMINANCE)
        };
        let charts = self.charts(&colors, &noise, &edge);
        Ok(self.with_pictures(charts, cfa, isp, exposure.time_s))
    }

    /// Chart and edge, as far as metrics look at them.
    fn charts(
        &self,
        colors: &dyn Fn() -> Result<ColorScores, CameraError>,
        noise: &dyn Fn() -> Result<f64, CameraError>,
        edge: &dyn Fn(&Shown) -> Result<EdgeScores, CameraError>,
    ) -> Charts {
        Charts {
            colors: self.sights.contains(&Sight::Colors).then(colors),
            noise: self.sights.contains(&Sight::Greys).then(noise),
            edge: self.edge.as_ref().map(edge),
        }
    }

    /// The scores of chart and edge with those of zone plate and scenes, which take whole pictures.
    fn with_pictures(&self, charts: Charts, cfa: &Cfa, isp: &dyn Isp, macbeth_time_s: f64) -> Scores {
        Scores {
            colors: charts.colors,
            luminance_noise_percent: charts.noise,
            edge: charts.edge,
            zone_plate: self.zone_plate.as_ref().map(|zone| self.aliasing(zone, cfa, isp)),
            scenes: self.scenes.iter().map(|view| view.score(cfa, isp, self.seed)).collect(),
            macbeth_time_s,
        }
    }

    fn aliasing(&self, zone: &ZonePlate, cfa: &Cfa, isp: &dyn Isp) -> Result<AliasingScores, CameraError> {
        let (camera, exposure) = zone.shown.through(cfa)?;
        let picture = isp.render(&camera.sensor.capture_ideal(&zone.shown.pixels, &exposure)?)?;
        let found = zone_plate_aliasing(&picture, &zone.reference, &self.setting)?;
        Ok(AliasingScores {
            aliasing_percent: found.total_percent,
            color_aliasing_percent: found.color_percent,
        })
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
        let patches = chart::patches();
        // So far samples may lie from what is measured.
        let clear = patches.iter().chain([&EDGE_REGION]).map(|p| p.row.min(p.col)).min().unwrap_or(0);
        let near = demosaic.interpolation(mosaic)?.filter(|i| i.reach() <= clear);
        let made = near.map(|i| Arc::new(Prepared::new(i, mosaic, &self.chart.pixels, &patches)));
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
    ) -> Result<Option<Charts>, CameraError> {
        let (sensor, mosaic) = (&camera.sensor, camera.sensor.cfa.mosaic());
        let reach = prepared.interpolation.reach();
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
        if dark_clips || brightest > CLIPS || isp.white_balance != WhiteBalance::None {
            return Ok(None);
        }
        let matrix = &isp.color_matrix;
        let xyz = |channels: Vec<f64>| matrix.xyz(&channels).map(|v| v * gain * isp.gain);
        let colors = || self.colors(&prepared.channels(&response).map(xyz).collect::<Vec<_>>());

        let factors: Vec<f32> =
            matrix.xyz_from_camera().iter().map(|c| (c[chart::LUMINANCE] * isp.gain) as f32).collect();
        let luminance = TileFilter::new(&prepared.interpolation, mosaic, &factors);
        let plane = |raw: &RawImage| -> Result<Planes, CameraError> {
            let plane = luminance.apply(&raw.normalized(), raw.cols())?;
            Ok(Planes::new(raw.rows(), raw.cols(), 1, plane).map_err(IspError::from)?)
        };
        let noise = || {
            let (raw, greys) = self.greys_raw(sensor, exposure, reach)?;
            Ok(luminance_noise(&plane(&raw)?, 0, &greys)?.mean_percent)
        };
        let edge = |shown: &Shown| {
            let edge = EdgeCapture::new(shown, &sensor.cfa, reach)?;
            self.edge(&edge, &plane(&edge.raw)?, 0)
        };
        Ok(Some(self.charts(&colors, &noise, &edge)))
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

    /// The capture of the grey series with noise, and where its patches lie.
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
        let mtf50_cy_per_px = edge_mtf50(picture, luminance, edge.region)?;
        let mtf50_cy_per_mm = mtf50_cy_per_px / (self.chart.camera.sensor.pixel.pitch_m * 1e3);
        Ok(EdgeScores { mtf50_cy_per_mm, mtf50_cy_per_px, time_s: edge.time_s })
    }
}
