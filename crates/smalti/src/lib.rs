//! Smalti simulates a camera, from a radiometric spectral scene to a scored picture, in order to design
//! colour filter arrays and their image processing together.
//!
//! The modules follow the light, and each imports only from those before it:
//!
//! [`numeric`] → [`spectrum`] → [`color`] → [`scene`] → [`optics`] → [`sensor`] → [`isp`] → [`l3`] →
//! [`metrics`] → [`camera`] → [`design`] → [`experiment`]
//!
//! | stage | from | to | unit of the result |
//! |---|---|---|---|
//! | [`scene`] | reflectances, illuminant | [`scene::Scene`] | photons s⁻¹ m⁻² sr⁻¹ nm⁻¹ |
//! | [`optics`] | [`scene::Scene`] | [`optics::OpticalImage`] | photons s⁻¹ m⁻² nm⁻¹ |
//! | [`sensor`] | [`optics::OpticalImage`] | [`sensor::RawImage`] | digital numbers |
//! | [`isp`] | [`sensor::RawImage`] | [`color::Image`] | relative, in a stated colour space |
//! | [`l3`] | [`sensor::RawImage`] | [`color::Image`], by a learned pipeline | relative, CIE XYZ |
//! | [`metrics`] | images | numbers | as named |
//!
//! ```
//! use smalti::camera::{Camera, CameraDescription, EvaluationSettings, evaluate};
//! use smalti::spectrum::WavelengthGrid;
//!
//! let mut description = CameraDescription::default();
//! description.sensor.pixel.pitch_um = 1.4;
//! let camera = Camera::new(description, WavelengthGrid::VISIBLE)?;
//! // The closure may cache optical images between designs; this one computes them every time.
//! let (scores, _pictures) = evaluate(&camera, &EvaluationSettings::default(), &|_key, make| make())?;
//! assert!(scores.delta_e_2000.mean < 3.0 && scores.mtf50_cy_per_mm > 100.0);
//! # Ok::<(), smalti::camera::CameraError>(())
//! ```
//!
//! This crate is pure computation: it opens no file, prints nothing and keeps no global state. `smalti-io` reads and
//! writes files, and `smalti-cli` is the command. No function panics on any input; invalid input is an error that states
//! the reason.
//!
//! Out of scope: ray tracing of scenes or lenses, video, and raw formats of single camera makers.

pub mod camera;
pub mod color;
pub mod design;
pub mod experiment;
pub mod isp;
pub mod l3;
pub mod metrics;
pub mod names;
pub mod numeric;
pub mod optics;
pub mod rating;
pub mod scene;
pub mod sensor;
pub mod spectrum;
