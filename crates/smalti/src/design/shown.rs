//! A target in front of the camera of a study, whatever its filters.

use std::sync::Arc;

use crate::camera::target::Target;
use crate::camera::{Camera, CameraError, OpticalImages};
use crate::optics::OpticalImage;
use crate::sensor::{Cfa, Exposure, PixelSpectra, Sensor, Window};
use crate::spectrum::Spectrum;

/// A target in front of the camera.
#[derive(Debug, Clone)]
pub(super) struct Shown {
    pub(super) camera: Camera,
    pub(super) pixels: PixelSpectra,
    /// What the exposure rule looks at; `None` where the time is stated or the rule looks at the whole image.
    metered: Option<Spectrum>,
    image: Arc<OpticalImage>,
}

impl Shown {
    /// A target of [`evaluate`](crate::camera::evaluate).
    pub(super) fn target(target: &Target, images: OpticalImages<'_>) -> Result<Self, CameraError> {
        Self::new(target.camera.clone(), images(&target.key, &|| target.image())?)
    }

    /// What a lens throws on the sensor of a camera.
    pub(super) fn new(camera: Camera, image: OpticalImage) -> Result<Self, CameraError> {
        let pixels = PixelSpectra::new(&camera.sensor, &image)?;
        let metered = camera.metered(&image)?;
        Ok(Self { camera, pixels, metered, image: Arc::new(image) })
    }

    /// The image on the sensor.
    pub(super) fn image(&self) -> &OpticalImage {
        &self.image
    }

    /// The most light on any pixel at each wavelength.
    pub(super) fn brightest(&self) -> Vec<f64> {
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
    pub(super) fn band(&self, sensor: &Sensor, first: usize, end: usize, reach: usize) -> (Sensor, usize) {
        let tile = sensor.cfa.mosaic().rows();
        let row = first.saturating_sub(reach) / tile * tile;
        let rows = (end + reach).min(sensor.rows) - row;
        let window = Window { row, col: 0, rows, cols: sensor.cols };
        (Sensor { window: Some(window), ..sensor.clone() }, row)
    }
}
