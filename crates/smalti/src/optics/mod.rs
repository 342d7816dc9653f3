//! The lens: from radiance in the scene to irradiance on the sensor.
//!
//! [`Optics`] describes a lens; [`Optics::image`] forms the image. Irradiance follows the camera equation, E
//! = π τ L / (1 + 4 N² (1 + |m|)²), with an optional cos⁴ law. The blur is a multiplication with the optical
//! transfer function of each wavelength in the frequency domain. This function is the product of those of
//! lens, wavefront error and optical low-pass filter, and is the same over the whole field.
//!
//! Two numerical properties matter. First, the image has the samples of the scene. Finer detail is absent,
//! and where the sampling is coarser than the resolution of the lens, sharp edges overshoot (Gibbs); negative
//! values are set to zero. Second, the transforms are in single precision: values below 10⁻⁶ of the maximum
//! of their wavelength are not reliable.

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
