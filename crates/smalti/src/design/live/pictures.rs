//! Captures of scenes by designs, rendered with their pipelines, and their references.

use std::collections::VecDeque;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::learner::LiveDesign;
use super::setup::LiveScene;
use super::target_light::metered;
use crate::camera::chart::LUMINANCE;
use crate::camera::score::ReferenceToScore;
use crate::camera::{Camera, CameraError, PictureScores, ScoreSettings};
use crate::color::{ColorSpace, Image};
use crate::design::latest::keep_latest;
use crate::design::pixel_light::PixelLight;
use crate::isp::Isp;
use crate::numeric::Planes;
use crate::sensor::{Exposure, NoiseMode, PixelSpectra, RawImage, SensorError, Window};
use crate::spectrum::{Illuminant, Observer, Spectrum};

/// Parts of the scene whose light is kept, and references: about 10 MB for 256 × 256 pixels.
const KEPT: usize = 3;

/// A part of a scene, in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LiveCrop {
    /// Its first row.
    pub row: usize,
    /// Its first column.
    pub col: usize,
    /// Number of rows.
    pub rows: usize,
    /// Number of columns.
    pub cols: usize,
}

impl LiveCrop {
    fn window(self) -> Window {
        let Self { row, col, rows, cols } = self;
        Window { row, col, rows, cols }
    }
}

/// A picture of a scene by a design.
#[derive(Debug, Clone)]
pub struct LivePicture {
    /// X, Y, Z under the illuminant of the scene, on the scale of the exposure.
    pub picture: Image,
    /// The factor from [`LivePictures::reference`] to the scale of the exposure.
    pub scale: f64,
    /// The part of the scene that it shows.
    pub crop: LiveCrop,
    /// The exposure time, s.
    pub time_s: f64,
    /// The share of the samples that saturate, percent.
    pub saturated_percent: f64,
}

/// A capture of a part of a scene, before it is rendered.
#[derive(Debug, Clone)]
struct Capture {
    raw: RawImage,
    exposure: Exposure,
    /// The part that was captured: whole tiles around the part that is wanted.
    window: Window,
}

/// What the light on a part of a scene depends on: that part, the transmittance of the lens and the luminance.
type LightKey = (Window, Vec<u64>, u64);

/// Takes pictures of one scene.
pub struct LivePictures {
    light: PixelLight,
    metered: Option<Vec<f64>>,
    /// The white of the illuminant: photons, and X, Y, Z with Y = 1.
    photons: Spectrum,
    white: [f64; 3],
    /// What the standard observer sees of the whole scene, X, Y, Z.
    seen: Image,
    gain: f64,
    kept: VecDeque<(LightKey, Arc<PixelSpectra>)>,
    references: VecDeque<(LiveCrop, Arc<ReferenceToScore>)>,
}

impl LivePictures {
    /// Prepares a scene under an illuminant, on the wavelengths and the pixels of a bare camera.
    ///
    /// # Errors
    /// When the parts of the light do not fit each other.
    pub fn new(scene: LiveScene, illuminant: &Illuminant, bare: &Camera) -> Result<Self, CameraError> {
        let light = scene.scene.light.light(bare.grid())?;
        let photons = illuminant.photons(bare.grid())?;
        let seen = seen(&light, bare)?;
        Ok(Self {
            light,
            metered: scene.scene.metered,
            white: Observer::Cie1931.white(&photons)?,
            photons,
            gain: seen.brightness_gain(),
            seen,
            kept: VecDeque::new(),
            references: VecDeque::new(),
        })
    }

    /// The whole scene.
    #[must_use]
    pub fn whole(&self) -> LiveCrop {
        LiveCrop { row: 0, col: 0, rows: self.seen.rows(), cols: self.seen.cols() }
    }

    /// Captures a part of the scene, or all of it, and renders it. A part has the same pixels as in the picture of the whole scene.
    ///
    /// # Errors
    /// When the part is not within the scene, no exposure is found, or a stage fails.
    pub fn picture(
        &mut self,
        design: &LiveDesign,
        crop: Option<LiveCrop>,
        noise: NoiseMode,
        seed: u64,
    ) -> Result<LivePicture, CameraError> {
        let crop = self.checked(crop)?;
        let Capture { raw, exposure, window } = self.capture(design, crop, noise, seed)?;
        let rendered = Isp::render(&design.pipeline.renderer(), &raw)?;
        // The reference is that of the scene at 1 cd/m².
        let camera = &design.camera;
        let y = &Observer::Cie1931.photon_weights(camera.grid())?[LUMINANCE];
        let scale = camera.exposure_scale(&exposure, &self.photons, y)? * design.luminance_cd_m2;
        let own = LiveCrop { row: crop.row - window.row, col: crop.col - window.col, ..crop };
        let saturated_percent = raw.saturated_percent();
        Ok(LivePicture {
            picture: part(&rendered, own)?,
            scale,
            crop,
            time_s: exposure.time_s,
            saturated_percent,
        })
    }

    /// The raw image of the whole scene of which [`LivePictures::picture`] makes the picture.
    ///
    /// # Errors
    /// When no exposure is found, or the capture fails.
    pub fn raw(&mut self, design: &LiveDesign, noise: NoiseMode, seed: u64) -> Result<RawImage, CameraError> {
        Ok(self.capture(design, self.whole(), noise, seed)?.raw)
    }

    /// Captures the samples that the picture of a part of the scene depends on.
    fn capture(
        &mut self,
        design: &LiveDesign,
        crop: LiveCrop,
        noise: NoiseMode,
        seed: u64,
    ) -> Result<Capture, CameraError> {
        let whole = self.whole();
        let LiveDesign { camera, pipeline, .. } = design;
        let camera = camera.with_size(whole.rows, whole.cols);
        let window = around(crop, whole, &camera, pipeline.reach());
        let (lens, luminance_cd_m2) = (&design.lens, design.luminance_cd_m2);
        let pixels = self.pixels(&camera, lens, luminance_cd_m2, window)?;
        let metered = metered(&camera, self.metered.as_deref(), lens, luminance_cd_m2)?;
        let exposure = match metered {
            Some(point) => camera.exposure_metered(&point)?,
            None if camera.stated_time_s().is_some() => camera.exposure_gathered(&pixels)?,
            // The rule meters all pixels.
            None => {
                camera.exposure_gathered(&*self.pixels(&camera, lens, luminance_cd_m2, whole.window())?)?
            }
        };
        let mut sensor = camera.sensor.clone();
        sensor.window = Some(window);
        let raw = sensor.capture(&*pixels, &exposure, noise, seed)?;
        Ok(Capture { raw, exposure, window })
    }

    /// The mean luminance of the scene beyond which a camera saturates more than a share of the samples of the whole scene (0 to below 1), cd/m². Light and mean
    /// dark signal count; noise does not. It is 0 where the samples saturate in any light, and infinite where they never do, as with an exposure that
    /// follows the light.
    ///
    /// # Errors
    /// When the camera has other pixels than the light, the share is invalid, or the exposure rule finds no light.
    pub fn saturating_luminance(&mut self, camera: &Camera, share: f64) -> Result<f64, CameraError> {
        let whole = self.whole();
        let camera = camera.with_size(whole.rows, whole.cols);
        let lens = camera.optics.transmittance_on(camera.grid())?;
        let pixels = self.pixels(&camera, &lens, 1.0, whole.window())?;
        let metered = metered(&camera, self.metered.as_deref(), &lens, 1.0)?;
        camera.saturating_factor(&pixels, metered.as_ref(), share)
    }

    /// What the standard observer sees of a part of the scene, X, Y, Z, without noise.
    ///
    /// # Errors
    /// When the part is not within the scene.
    pub fn reference(&self, crop: Option<LiveCrop>) -> Result<Image, CameraError> {
        part(&self.seen, self.checked(crop)?)
    }

    /// A picture as RGBA, row by row: in sRGB, adapted to the white of the scene. The brightness is that at which the reference of the
    /// whole scene fits the display, for all pictures of the scene.
    ///
    /// # Errors
    /// When the picture is not in X, Y, Z.
    pub fn rgba8(&self, picture: &LivePicture) -> Result<Vec<u8>, CameraError> {
        Ok(picture.picture.shown(Some(self.white), self.display_gain(picture))?.rgba8())
    }

    /// The gain with which [`LivePictures::rgba8`] shows a picture, as `smalti render --gain` takes it.
    #[must_use]
    pub fn display_gain(&self, picture: &LivePicture) -> f64 {
        self.gain / picture.scale
    }

    /// The reference as RGBA, like a picture.
    ///
    /// # Errors
    /// When the part is not within the scene.
    pub fn reference_rgba8(&self, crop: Option<LiveCrop>) -> Result<Vec<u8>, CameraError> {
        Ok(self.reference(crop)?.shown(Some(self.white), self.gain)?.rgba8())
    }

    /// The differences of a picture from the reference, as [`score_picture`](crate::camera::score_picture) has them.
    ///
    /// # Errors
    /// When the reference is dark, or the picture holds a value that is not finite.
    pub fn scores(&mut self, picture: &LivePicture) -> Result<PictureScores, CameraError> {
        self.kept_reference(picture.crop)?.score(&on_scale(picture))
    }

    /// CIEDE2000 at every pixel between a picture and another one of the same part, such as that of another design: one plane. Both are
    /// clipped at the white of the reference, as for [`scores`](Self::scores).
    ///
    /// # Errors
    /// When the reference is dark, the pictures differ in size, or one holds a value that is not finite.
    pub fn difference(&mut self, picture: &LivePicture, other: &LivePicture) -> Result<Planes, CameraError> {
        self.kept_reference(picture.crop)?.delta_e_2000_between(&on_scale(picture), &on_scale(other))
    }

    /// The reference of a part of the scene, which is kept.
    fn kept_reference(&mut self, crop: LiveCrop) -> Result<Arc<ReferenceToScore>, CameraError> {
        if let Some((_, found)) = self.references.iter().find(|(known, _)| *known == crop) {
            return Ok(found.clone());
        }
        let image = self.reference(Some(crop))?;
        let made = Arc::new(ReferenceToScore::new(&image, self.white, &ScoreSettings::default())?);
        keep_latest(&mut self.references, KEPT, (crop, made.clone()));
        Ok(made)
    }

    fn checked(&self, crop: Option<LiveCrop>) -> Result<LiveCrop, CameraError> {
        let whole = self.whole();
        let Some(crop) = crop else { return Ok(whole) };
        let inside = |first: usize, count: usize, all: usize| {
            count > 0 && first.checked_add(count).is_some_and(|end| end <= all)
        };
        if inside(crop.row, crop.rows, whole.rows) && inside(crop.col, crop.cols, whole.cols) {
            return Ok(crop);
        }
        let LiveCrop { row, col, rows, cols } = crop;
        let message = format!(
            "{rows} × {cols} pixels from row {row} and column {col}; expected a part of {} × {} pixels",
            whole.rows, whole.cols
        );
        Err(CameraError::Key { key: "crop".into(), message })
    }

    /// The light on a window of the sensor, behind a lens.
    fn pixels(
        &mut self,
        camera: &Camera,
        lens: &Spectrum,
        luminance_cd_m2: f64,
        window: Window,
    ) -> Result<Arc<PixelSpectra>, CameraError> {
        let passed = lens.values().iter().map(|v| v.to_bits()).collect();
        let key = (window, passed, luminance_cd_m2.to_bits());
        if let Some((_, found)) = self.kept.iter().find(|(k, _)| *k == key) {
            return Ok(found.clone());
        }
        let mut sensor = camera.sensor.clone();
        sensor.window = Some(window);
        let pixels = self.light.behind(&sensor, lens, luminance_cd_m2)?;
        let pixels = Arc::new(pixels);
        keep_latest(&mut self.kept, KEPT, (key, pixels.clone()));
        Ok(pixels)
    }
}

/// A picture on the scale of the reference.
fn on_scale(picture: &LivePicture) -> Image {
    picture.picture.clone().scaled(1.0 / picture.scale)
}

/// The window of whole tiles around a part of a scene with the samples that its picture depends on.
fn around(crop: LiveCrop, whole: LiveCrop, camera: &Camera, reach: usize) -> Window {
    let mosaic = camera.sensor.cfa.mosaic();
    let extent = |first: usize, count: usize, all: usize, tile: usize| {
        // Classes may be read from samples that are farther along the rows than along the columns: by a tile at most.
        let reach = reach + mosaic.rows().max(mosaic.cols());
        let start = first.saturating_sub(reach) / tile * tile;
        (start, (first + count + reach).min(all) - start)
    };
    let (row, rows) = extent(crop.row, crop.rows, whole.rows, mosaic.rows());
    let (col, cols) = extent(crop.col, crop.cols, whole.cols, mosaic.cols());
    Window { row, col, rows, cols }
}

fn part(image: &Image, crop: LiveCrop) -> Result<Image, CameraError> {
    let LiveCrop { row, col, rows, cols } = crop;
    if (rows, cols) == (image.rows(), image.cols()) {
        return Ok(image.clone());
    }
    let planes = image.planes().cropped(row, col, rows, cols).map_err(SensorError::from)?;
    Ok(Image::new(image.space(), planes)?)
}

/// X, Y, Z of the light on bare pixels as [`Camera::seen_by`] has them: the mean irradiance of each pixel, weighted.
fn seen(light: &PixelLight, bare: &Camera) -> Result<Image, CameraError> {
    let observer = Observer::Cie1931.photon_weights(bare.grid())?;
    let per_m2 = 1.0 / bare.sensor.pixel.photodetector_area_m2();
    let planes = light.planes();
    let mut seen = Planes::zeros(planes.rows(), planes.cols(), 3);
    for (out, weights) in seen.planes_mut().zip(&observer) {
        for (plane, spectrum) in planes.planes().zip(light.spectra()) {
            let weight = (spectrum.times(weights)?.integral() * per_m2) as f32;
            out.iter_mut().zip(plane).for_each(|(o, v)| *o += weight * v);
        }
        // Components are accurate to a share of the brightest pixel.
        out.iter_mut().for_each(|o| *o = o.max(0.0));
    }
    let image = Image::new(ColorSpace::Xyz, seen)?;
    if image.channels()[LUMINANCE].iter().all(|y| *y <= 0.0) {
        return Err(SensorError::NoLight.into());
    }
    Ok(image)
}
