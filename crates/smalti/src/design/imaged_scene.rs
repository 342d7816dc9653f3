//! A scene imaged on the pixels of a study's camera, before any colour filter.

use std::sync::Arc;

use crate::camera::target::Target;
use crate::camera::{Camera, CameraError, OpticalImages};
use crate::optics::OpticalImage;
use crate::sensor::{Cfa, Exposure, PixelSpectra, Sensor, Window};
use crate::spectrum::Spectrum;

/// The light of a scene on every pixel of a camera. It does not depend on the colour filter array.
#[derive(Debug, Clone)]
pub(super) struct ImagedScene {
    pub(super) camera: Camera,
    pub(super) pixels: PixelSpectra,
    meter: Meter,
}

/// What the exposure rule meters.
#[derive(Debug, Clone)]
enum Meter {
    /// The irradiance at one point.
    Point(Spectrum),
    /// The whole image; unused when the description states the exposure time.
    Image(Arc<OpticalImage>),
    /// All pixels, for light that was gathered without its optical image.
    Pixels,
}

impl ImagedScene {
    /// Images a target of [`evaluate`](crate::camera::evaluate).
    pub(super) fn of_target(target: &Target, images: OpticalImages<'_>) -> Result<Self, CameraError> {
        Self::new(target.camera.clone(), images(&target.key, &|| target.image())?)
    }

    /// Gathers an optical image on the pixels of a camera.
    pub(super) fn new(camera: Camera, image: OpticalImage) -> Result<Self, CameraError> {
        let pixels = PixelSpectra::new(&camera.sensor, &image)?;
        let meter = match camera.metered(&image)? {
            Some(point) => Meter::Point(point),
            None => Meter::Image(Arc::new(image)),
        };
        Ok(Self { camera, pixels, meter })
    }

    /// Light that was gathered before; `metered` is the result of [`Camera::metered`] for its optical image.
    pub(super) fn from_pixels(camera: Camera, pixels: PixelSpectra, metered: Option<Spectrum>) -> Self {
        Self { camera, pixels, meter: metered.map_or(Meter::Pixels, Meter::Point) }
    }

    /// The irradiance at the metered point; `None` when the exposure rule does not meter a point.
    pub(super) fn metered(&self) -> Option<&Spectrum> {
        if let Meter::Point(point) = &self.meter { Some(point) } else { None }
    }

    /// The maximum over the pixels at each wavelength, photons s⁻¹ nm⁻¹.
    pub(super) fn brightest(&self) -> Vec<f64> {
        brightest(&self.pixels)
    }

    /// The camera with a colour filter array, and its exposure for this scene.
    pub(super) fn with_cfa(&self, cfa: &Cfa) -> Result<(Camera, Exposure), CameraError> {
        let camera = self.camera.with_cfa(cfa.clone());
        let exposure = match &self.meter {
            Meter::Point(irradiance) => camera.exposure_metered(irradiance)?,
            Meter::Image(image) => camera.exposure(image)?,
            Meter::Pixels => camera.exposure_gathered(&self.pixels)?,
        };
        Ok((camera, exposure))
    }

    /// A sensor that reads the rows `first..end` and `reach` more rows on either side, and the first row that it reads, which
    /// begins a tile of the mosaic.
    pub(super) fn band(&self, sensor: &Sensor, first: usize, end: usize, reach: usize) -> (Sensor, usize) {
        let tile = sensor.cfa.mosaic().rows();
        let row = first.saturating_sub(reach) / tile * tile;
        let rows = (end + reach).min(sensor.rows) - row;
        let window = Window { row, col: 0, rows, cols: sensor.cols };
        (Sensor { window: Some(window), ..sensor.clone() }, row)
    }
}

/// The maximum over the pixels at each wavelength, photons s⁻¹ nm⁻¹.
pub(super) fn brightest(pixels: &PixelSpectra) -> Vec<f64> {
    let (window, grid) = (pixels.window(), pixels.grid());
    let maximum = |i: usize| {
        let rows = (window.row..window.row + window.rows).flat_map(|row| pixels.line(row, i));
        f64::from(rows.fold(0.0f32, |m, &v| m.max(v)))
    };
    (0..grid.len()).map(maximum).collect()
}
