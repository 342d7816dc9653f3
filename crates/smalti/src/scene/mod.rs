//! What stands before the camera: spectral radiance with an absolute luminance, a distance and a field of view.

mod scene;

pub use self::scene::{Scene, SceneError};
