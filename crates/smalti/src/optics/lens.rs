//! What a lens is, by its values.

use serde::{Deserialize, Serialize};

use super::diffraction::{in_focus, out_of_focus};
use super::error::OpticsError;
use super::focus::{ChromaticFocus, Defocus, rim_error_m};
use super::geometry::Geometry;
use super::olpf::BirefringentLowPass;
use super::otf::{LensTransfer, Otf};
use super::padding::Padding;
use super::psf::PsfStack;
use super::pupil::Pupil;
use super::zernike::Wavefront;
use crate::numeric::Planes;
use crate::numeric::fft::{Complex32, RealFft2, bin_frequency};
use crate::numeric::require;
use crate::spectrum::{Extrapolation, Spectrum, WavelengthGrid};

/// Largest wavefront slope for which the defocus integral is evaluated, waves per pupil radius.
const STEEPEST_DEFOCUS: f64 = 200.0;

/// A lens and the filters before the sensor.
///
/// All fields are open; they are checked where they are used. [`Optics::new`] fills them for a perfect lens.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Optics {
    /// Focal length, m.
    pub focal_length_m: f64,
    /// Focal length over diameter of the entrance pupil.
    pub f_number: f64,
    /// How the lens blurs.
    pub model: OpticsModel,
    /// How light falls off from the axis.
    pub falloff: Falloff,
    /// Share of the light that the lens passes, 0–1.
    pub transmittance: Transmittance,
    /// Filter against infrared, 0–1; must cover the wavelengths of the scene.
    pub ir_cut: Option<Spectrum>,
    /// Optical low-pass filter.
    pub olpf: Option<BirefringentLowPass>,
    /// What lies beyond the border of the scene.
    pub padding: Padding,
}

/// How a lens blurs. The blur is the same over the whole field.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub enum OpticsModel {
    /// No blur, and no focusing: the image plane stays at the focal length, the magnification term of the camera
    /// equation is absent, and no scene is too near. For tests. Without a low-pass filter the optical image has
    /// exactly the samples of the scene and no padding.
    Pinhole,
    /// A perfect lens with a circular pupil, maybe out of focus.
    Diffraction {
        /// Focus for all wavelengths.
        defocus: Defocus,
        /// Focus by wavelength.
        chromatic: ChromaticFocus,
    },
    /// A lens with a wavefront error.
    Zernike {
        /// The error.
        wavefront: Wavefront,
        /// Focus for all wavelengths, added to the error.
        defocus: Defocus,
        /// Focus by wavelength, added to the error.
        chromatic: ChromaticFocus,
    },
    /// Point spread functions from elsewhere.
    Psf(PsfStack),
}

/// How light falls off from the axis. With cos⁴: a thin lens without vignetting, before a flat sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Falloff {
    /// None.
    None,
    /// Fourth power of the cosine of the field angle.
    #[default]
    Cos4,
}

/// Share of the light that the lens passes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum Transmittance {
    /// The same at all wavelengths, 0–1.
    Constant(f64),
    /// By wavelength, 0–1; must cover the wavelengths of the scene.
    Spectral(Spectrum),
}

impl Optics {
    /// A perfect lens: diffraction-limited, lossless, in focus, cos⁴ fall-off, dark surroundings.
    #[must_use]
    pub fn new(focal_length_m: f64, f_number: f64) -> Self {
        let model = OpticsModel::Diffraction { defocus: Defocus::None, chromatic: ChromaticFocus::None };
        Self {
            focal_length_m,
            f_number,
            model,
            falloff: Falloff::Cos4,
            transmittance: Transmittance::Constant(1.0),
            ir_cut: None,
            olpf: None,
            padding: Padding::default(),
        }
    }

    /// Where a scene at `distance_m` (may be infinite) is imaged.
    ///
    /// # Errors
    /// When focal length or f-number is not positive and finite, or the scene is not beyond the focal length (of a
    /// lens; a pinhole has no such limit).
    pub fn geometry(&self, distance_m: f64) -> Result<Geometry, OpticsError> {
        match self.model {
            OpticsModel::Pinhole => Geometry::pinhole(self.focal_length_m, self.f_number),
            _ => Geometry::thin_lens(self.focal_length_m, self.f_number, distance_m),
        }
    }

    /// Lens and infrared filter together on a wavelength grid, 0–1.
    ///
    /// # Errors
    /// When a value is not within 0–1, or a spectrum does not cover the grid.
    pub fn transmittance_on(&self, grid: WavelengthGrid) -> Result<Spectrum, OpticsError> {
        let lens = match &self.transmittance {
            Transmittance::Constant(t) => {
                require((0.0..=1.0).contains(t), "transmittance", *t, "0 to 1")?;
                Spectrum::constant(grid, *t)?
            }
            Transmittance::Spectral(t) => fraction("transmittance", t, grid)?,
        };
        match &self.ir_cut {
            None => Ok(lens),
            Some(filter) => Ok(lens.times(&fraction("ir_cut", filter, grid)?)?),
        }
    }

    /// The optical transfer function for a scene at `distance_m` (may be infinite) at a wavelength, of lens and
    /// low-pass filter. Its cut-off is 1 / (λ N (1 + |m|)).
    ///
    /// # Errors
    /// When a parameter is out of range, the point spread functions do not cover the wavelength, or the wavefront
    /// is too steep to be sampled.
    pub fn otf(&self, wavelength_nm: f64, distance_m: f64) -> Result<Otf, OpticsError> {
        require(wavelength_nm > 0.0, "wavelength_nm", wavelength_nm, "more than 0")?;
        let geometry = self.geometry(distance_m)?;
        Blur::new(self, &geometry, &[wavelength_nm])?.otf(wavelength_nm)
    }

    /// The point spread function for a scene at `distance_m` (may be infinite) at a wavelength: one plane of
    /// `size` × `size` samples `spacing_m` apart that sum to 1, with the axis at row and column `size / 2`. What reaches
    /// beyond the plane comes back in on the other side.
    ///
    /// # Errors
    /// As [`Optics::otf`], and when `size` is zero or above 8192, or the spacing not positive.
    pub fn psf(
        &self,
        wavelength_nm: f64,
        distance_m: f64,
        spacing_m: f64,
        size: usize,
    ) -> Result<Planes, OpticsError> {
        require((1..=8192).contains(&size), "size of the point spread function", size as f64, "1 to 8192")?;
        require(spacing_m > 0.0, "spacing_m", spacing_m, "more than 0")?;
        let otf = self.otf(wavelength_nm, distance_m)?;
        let otf = otf.on_grid(size, size, spacing_m);
        let fft = RealFft2::new(size, size)?;
        let mut spectrum = vec![Complex32::ZERO; size * fft.half_cols()];
        for (kx, column) in spectrum.chunks_exact_mut(size).enumerate().take(otf.passing()) {
            for (ky, v) in column.iter_mut().enumerate() {
                // A point at the centre.
                let turn = (size / 2) as f64 * (bin_frequency(kx, size) + bin_frequency(ky, size));
                let (sin, cos) = (-std::f64::consts::TAU * turn).sin_cos();
                *v = Complex32::new(cos as f32, sin as f32);
            }
            otf.apply(kx, column);
        }
        Ok(Planes::new(size, size, 1, fft.inverse(&spectrum)?)?)
    }
}

fn fraction(name: &'static str, t: &Spectrum, grid: WavelengthGrid) -> Result<Spectrum, OpticsError> {
    for &v in t.values() {
        require((0.0..=1.0).contains(&v), name, v, "0 to 1")?;
    }
    Ok(t.resampled(grid, Extrapolation::Error)?)
}

/// The blur of a lens at the wavelengths of a scene, with all that does not depend on wavelength worked out once.
pub(super) struct Blur<'a> {
    optics: &'a Optics,
    working_f_number: f64,
    pupil: Option<Pupil>,
    reach_m: f64,
}

impl<'a> Blur<'a> {
    pub(super) fn new(
        optics: &'a Optics,
        geometry: &Geometry,
        wavelengths_nm: &[f64],
    ) -> Result<Self, OpticsError> {
        if let Some(olpf) = &optics.olpf {
            olpf.check()?;
        }
        let working_f_number = geometry.working_f_number();
        let mut blur = Self { optics, working_f_number, pupil: None, reach_m: 0.0 };
        let shortest_m = 1e-9 * wavelengths_nm.iter().copied().fold(f64::INFINITY, f64::min);
        let none = Wavefront::default();
        let wavefront = match &optics.model {
            OpticsModel::Zernike { wavefront, .. } => wavefront,
            _ => &none,
        };
        let mut rim_m = 0.0f64;
        for &nm in wavelengths_nm {
            rim_m = rim_m.max(blur.rim_m(nm)?.abs());
        }
        // The slope of W₂₀ ρ² at the rim; that of the sum is no more than the sum.
        let slope_m = wavefront.steepest_m() + 2.0 * rim_m;
        match &optics.model {
            OpticsModel::Zernike { .. } => blur.pupil = Some(Pupil::new(wavefront, slope_m, shortest_m)?),
            OpticsModel::Psf(stack) => blur.reach_m = stack.reach_m(),
            OpticsModel::Diffraction { .. } if slope_m > STEEPEST_DEFOCUS * shortest_m => {
                let waves_per_radius = slope_m / shortest_m;
                return Err(OpticsError::WavefrontTooSteep { waves_per_radius, limit: STEEPEST_DEFOCUS });
            }
            OpticsModel::Diffraction { .. } | OpticsModel::Pinhole => {}
        }
        // A ray lands 2 N dW/dρ beside its aim.
        blur.reach_m += 2.0 * working_f_number * slope_m;
        blur.reach_m += optics.olpf.map_or(0.0, |f| f.reach_m());
        Ok(blur)
    }

    /// How far rays land beside their aim, m. What diffraction adds has no bound and is left out.
    pub(super) fn reach_m(&self) -> f64 {
        self.reach_m
    }

    /// Whether there is none at all.
    pub(super) fn is_none(&self) -> bool {
        self.optics.model == OpticsModel::Pinhole && self.optics.olpf.is_none()
    }

    fn rim_m(&self, wavelength_nm: f64) -> Result<f64, OpticsError> {
        match &self.optics.model {
            OpticsModel::Diffraction { defocus, chromatic }
            | OpticsModel::Zernike { defocus, chromatic, .. } => {
                let lens = (self.optics.focal_length_m, self.optics.f_number, self.working_f_number);
                rim_error_m(*defocus, chromatic, wavelength_nm, lens)
            }
            OpticsModel::Pinhole | OpticsModel::Psf(_) => Ok(0.0),
        }
    }

    pub(super) fn otf(&self, wavelength_nm: f64) -> Result<Otf, OpticsError> {
        let wavelength_m = wavelength_nm * 1e-9;
        let rim_m = self.rim_m(wavelength_nm)?;
        let limit = 1.0 / (wavelength_m * self.working_f_number);
        let (cutoff, lens) = match (&self.optics.model, &self.pupil) {
            (OpticsModel::Pinhole, _) => (f64::INFINITY, LensTransfer::Unity),
            (OpticsModel::Psf(stack), _) => {
                (stack.nyquist_cy_per_m(), LensTransfer::Sampled(stack.transfer(wavelength_nm)?))
            }
            (_, Some(pupil)) => {
                let mean_phase = pupil.mean_phase(wavelength_m, rim_m, limit)?;
                (limit, LensTransfer::Pupil { mean_phase, limit: in_focus() })
            }
            (_, None) => (limit, LensTransfer::Radial(out_of_focus(rim_m / wavelength_m))),
        };
        Ok(Otf::new(cutoff, lens, self.optics.olpf))
    }
}
