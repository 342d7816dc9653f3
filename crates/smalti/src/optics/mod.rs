//! The lens: from radiance in the scene to irradiance on the sensor.
//!
//! [`Optics`] describes a lens by values; [`Optics::image`] forms the image. Irradiance follows the camera
//! equation, E = π τ L / (1 + 4 N² (1 + |m|)²), with an optional cos⁴ fall-off; blur is a multiplication with
//! the optical transfer function of each wavelength in the frequency domain, where lens, wavefront error and
//! optical low-pass filter combine by their product. The blur is the same over the whole field.
//!
//! Two things to know of the arithmetic. The image has the samples of the scene: detail finer than that is not
//! invented, and where the samples are coarser than the lens resolves, sharp edges overshoot (Gibbs); what
//! would be negative is set to zero. And the transforms are of single precision: a value below 10⁻⁶ of the
//! brightest of its wavelength is not to be relied on.

pub mod builtin;
mod diffraction;
mod error;
mod focus;
mod form;
mod geometry;
mod image;
mod lens;
mod olpf;
mod otf;
mod padding;
mod psf;
mod pupil;
mod zernike;

pub use error::OpticsError;
pub use focus::{ChromaticFocus, Defocus};
pub use geometry::Geometry;
pub use image::{OPTICAL_IMAGE_REVISION, OpticalImage};
pub use lens::{Falloff, Optics, OpticsModel, Transmittance};
pub use olpf::BirefringentLowPass;
pub use otf::Otf;
pub use padding::{Boundary, Padding};
pub use psf::PsfStack;
pub use zernike::{Wavefront, WavefrontUnit, ZernikeIndex, ZernikeMode};
