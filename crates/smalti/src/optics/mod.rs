//! The lens: from radiance in the scene to irradiance on the sensor.

mod image;

pub use image::OpticalImage;
