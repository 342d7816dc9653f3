//! A camera and a scene on their way to a capture.

use super::light_notes;
use crate::camera::{Camera, CameraError, Photograph};
use crate::color::Image;
use crate::scene::Scene;

/// The field of view of a scene in a capture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FieldOfView {
    /// That of the scene.
    Stated,
    /// That with which the scene fits on the sensor.
    Fitted,
    /// That with which it fits, and covers at most as many pixels as it has samples: a file holds no finer detail.
    FittedFile,
}

/// A camera and a scene that fit each other.
#[derive(Debug, Clone)]
pub struct PreparedCapture {
    /// The camera on the wavelengths of the scene.
    pub camera: Camera,
    /// The scene with its field of view.
    pub scene: Scene,
    /// What is to be told of the light that the camera sees.
    pub notes: Vec<String>,
}

impl PreparedCapture {
    /// Prepares a capture, as `smalti simulate` and the studio make it. Unless the whole sensor is read out (`is_full_frame`), its window is that which the scene
    /// covers.
    ///
    /// # Errors
    /// When a curve of the camera does not cover the wavelengths of the scene, or the scene is not beyond the focal length.
    pub fn new(
        camera: &Camera,
        scene: Scene,
        field_of_view: FieldOfView,
        is_full_frame: bool,
    ) -> Result<Self, CameraError> {
        let mut camera = camera.on_grid(scene.radiance().grid())?;
        let notes = light_notes(&camera, scene.illuminant())?;
        let scene = match field_of_view {
            FieldOfView::Stated => scene,
            FieldOfView::Fitted => camera.fitted(scene, false)?,
            FieldOfView::FittedFile => camera.fitted(scene, true)?,
        };
        if !is_full_frame {
            camera.sensor.window = Some(camera.window_on(&scene)?);
        }
        Ok(Self { camera, scene, notes })
    }
}

/// The picture of a photograph for a display, in the output space of its camera, and the factor that made it as bright as the display shows.
///
/// # Errors
/// When the picture cannot be converted.
pub fn displayed(camera: &Camera, photograph: &Photograph) -> Result<(Image, f64), CameraError> {
    let gain = photograph.picture.brightness_gain();
    let picture = photograph.picture.clone().scaled(gain).converted(camera.output_space())?;
    Ok((picture, gain))
}
