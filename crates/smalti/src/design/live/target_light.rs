//! The light of a target on bare pixels, and behind the lens of a design.

use crate::camera::description::AutoExposureName;
use crate::camera::{Camera, CameraError};
use crate::design::imaged_scene::ImagedScene;
use crate::design::pixel_light::PixelLight;
use crate::design::preview::PreviewScene;
use crate::spectrum::{Spectrum, WavelengthGrid};

/// The light of a target on bare pixels.
#[derive(Debug)]
pub(super) struct TargetLight {
    pub(super) light: PixelLight,
    metered: Option<Vec<f64>>,
}

impl TargetLight {
    /// # Errors
    /// When the parts of the light do not fit each other.
    pub(super) fn new(scene: &PreviewScene, grid: WavelengthGrid) -> Result<Self, CameraError> {
        Ok(Self { light: scene.light.light(grid)?, metered: scene.metered.clone() })
    }

    /// The target at a mean luminance, behind a lens, on a camera.
    pub(super) fn imaged(
        &self,
        camera: &Camera,
        lens: &Spectrum,
        luminance_cd_m2: f64,
    ) -> Result<ImagedScene, CameraError> {
        let planes = self.light.planes();
        let camera = camera.with_size(planes.rows(), planes.cols());
        let pixels = self.light.behind(&camera.sensor, lens, luminance_cd_m2)?;
        let metered = metered(&camera, self.metered.as_deref(), lens, luminance_cd_m2)?;
        Ok(ImagedScene::from_pixels(camera, pixels, metered))
    }
}

/// The irradiance at the point that a camera meters, behind its lens; `None` if it meters no point. `bare` is that behind a clear lens.
pub(super) fn metered(
    camera: &Camera,
    bare: Option<&[f64]>,
    lens: &Spectrum,
    luminance_cd_m2: f64,
) -> Result<Option<Spectrum>, CameraError> {
    let is_point = camera.stated_time_s().is_none()
        && camera.description().exposure.auto != Some(AutoExposureName::Mean);
    match bare.filter(|_| is_point) {
        None => Ok(None),
        Some(bare) => {
            let values = bare.iter().zip(lens.values()).map(|(v, t)| v * t * luminance_cd_m2).collect();
            Ok(Some(Spectrum::new(camera.grid(), values)?))
        }
    }
}
