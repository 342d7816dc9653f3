//! Spectral upsampling of photographs with measured reflectances.
//!
//! The smooth reflectances of [`jakob_hanika2019`](super::jakob_hanika2019) have three coefficients, so that three
//! channels of a camera determine them, and they have none of the absorption bands of skin, leaves and dyes. Such scenes
//! flatter cameras with three filters. Here a pixel gets the reflectance of real surfaces of its colour:
//!
//! 1. The photograph is divided into segments of similar colour, some 16 pixels wide.
//! 2. Each segment gets a mixture of the measured reflectances whose colours under D65 are nearest to its mean colour.
//! 3. A pixel takes the mixtures of the segments around it, in shares that change smoothly, scaled to its luminance.
//! 4. What is missing to the colour of the pixel is added as a quadratic polynomial in wavelength to σ⁻¹ of that
//!    reflectance, with the sigmoid σ of Jakob and Hanika. The result lies between 0 and 1 and keeps the absorption bands.
//!
//! Under D65 the colours are those of the photograph, so no border of a segment can be seen. Under another light
//! they are those of surfaces that are plausible, and not those of the photographed ones: three numbers do not
//! determine a spectrum.

mod closure;
mod mixture;
mod segments;

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use self::closure::{LANES, Lanes, Wavelength, close};
use self::mixture::{Measured, mixture};
use self::segments::Segments;
use super::cie1976::lab_from_xyz;
use super::jakob_hanika2019::UpliftError;
use super::sigmoid::{Fit, polynomial, position, sigmoid};
use super::{ColorSpace, Image};
use crate::numeric::simd::{Kernel, dispatch};
use crate::numeric::{Planes, bands_of, require};
use crate::spectrum::{
    Extrapolation, Observer, SpectralCube, Spectrum, SpectrumError, WavelengthGrid, reflectance,
};

/// Spectral upsampling of sRGB images with measured reflectances.
#[derive(Debug, Clone)]
pub struct Repaint {
    grid: WavelengthGrid,
    fit: Fit,
    wavelengths: Vec<Wavelength>,
    measured: Vec<Measured>,
}

/// Bounds of linear RGB: no sigmoid is 0 or 1 at every wavelength.
const DARKEST: f32 = 1e-4;
const LIGHTEST: f32 = 0.9995;
/// Relative error of XYZ, with 0.02 added to the component, beyond which a pixel is fitted once more: at most 0.2 ΔE*ab.
const TOLERANCE: f32 = 1e-3;
/// Tolerance of that fit, ΔE*ab.
const FIT_TOLERANCE: f64 = 0.1;

/// An image as reflectances.
#[derive(Debug, Clone)]
pub struct Repainted {
    /// The reflectances.
    pub cube: SpectralCube,
    /// The number of pixels whose colour under D65 differs from that of the image by more than 0.1 ΔE*ab (CIE 1976), because it lies at the
    /// border of sRGB.
    pub missed: usize,
}

impl Repaint {
    /// With the measured reflectances of the library, [`reflectance::surfaces`].
    ///
    /// # Errors
    /// When the grid does not overlap the observer's sensitivity.
    pub fn new(grid: WavelengthGrid, observer: Observer) -> Result<Self, UpliftError> {
        let surfaces = reflectance::surfaces(grid)?;
        Self::with(grid, observer, surfaces.into_iter().map(|(_, spectrum)| spectrum))
    }

    /// With other reflectances, 0 to 1, held constant beyond their wavelengths. They should be many and of all hues; with few, the correction
    /// of step 4 makes most of the spectrum.
    ///
    /// # Errors
    /// When the grid does not overlap the observer's sensitivity, there is no reflectance, or one
    /// exceeds 1, is negative or is black.
    pub fn with(
        grid: WavelengthGrid,
        observer: Observer,
        reflectances: impl IntoIterator<Item = Spectrum>,
    ) -> Result<Self, UpliftError> {
        let fit = Fit::new(grid, observer)?;
        let mut measured = Vec::new();
        for spectrum in reflectances {
            let reflectance = spectrum.resampled(grid, Extrapolation::Hold)?.values().to_vec();
            let largest = reflectance.iter().copied().fold(0.0, f64::max);
            let xyz = fit.xyz_of(&reflectance);
            let inside = reflectance.iter().all(|r| (0.0..=1.0).contains(r)) && xyz[1] > 0.0;
            require(inside, "a measured reflectance", largest, "0 to 1, and above 0 somewhere")
                .map_err(SpectrumError::from)?;
            let lab = lab_from_xyz(xyz, [1.0; 3]);
            measured.push(Measured { reflectance, xyz, lab, headroom: 0.98 / largest });
        }
        let count = measured.len();
        require(count > 0, "the number of measured reflectances", count as f64, "at least 1")
            .map_err(SpectrumError::from)?;
        let wavelengths = Wavelength::all(&fit, grid.len());
        Ok(Self { grid, fit, wavelengths, measured })
    }

    /// The reflectances of an image in [`ColorSpace::LinearSrgb`]. Under D65 they reproduce the colours of the image
    /// relative to white, but for colours at the border of sRGB. Negative channels count as 0. A pixel whose largest
    /// channel exceeds 1 is divided by that channel before and multiplied by it afterwards; its "reflectance" exceeds
    /// 1, like that of a lamp.
    ///
    /// # Errors
    /// When the image is in another colour space, or contains a value that is not finite.
    pub fn repaint_image(&self, image: &Image) -> Result<SpectralCube, UpliftError> {
        Ok(self.repainted(image)?.cube)
    }

    /// [`Repaint::repaint_image`] with the number of pixels that have another colour.
    ///
    /// # Errors
    /// As [`Repaint::repaint_image`].
    pub fn repainted(&self, image: &Image) -> Result<Repainted, UpliftError> {
        let missed = AtomicUsize::new(0);
        image.check_space(ColorSpace::LinearSrgb)?;
        image.check_finite()?;
        let (rows, cols) = (image.rows(), image.cols());
        let mut planes = Planes::zeros(rows, cols, self.grid.len());
        if rows * cols > 0 {
            let picture = self.picture(image);
            let segments = Segments::new(&picture.lab, rows, cols);
            let rgb = [0, 1, 2].map(|c| picture.rgb[c].as_slice());
            let mixtures: Vec<PaddedSpectrum> = segments
                .means(&picture.lab, rgb)
                .into_par_iter()
                .map(|mean| {
                    let grey = mean.unwrap_or([0.5; 3]);
                    padded(&mixture(&self.measured, self.fit.xyz(grey)))
                })
                .collect();
            let tasks = bands_of(1, planes.data_mut(), rows, cols);
            tasks.into_par_iter().enumerate().for_each(|(row, mut bands)| {
                let mut work = vec![[0.0; LANES]; self.grid.len()];
                for first in (0..cols).step_by(LANES) {
                    let count = LANES.min(cols - first);
                    let (scale, far) =
                        self.paint(&picture, &segments, &mixtures, (row * cols + first, count), &mut work);
                    missed.fetch_add(far, Ordering::Relaxed);
                    for (band, lanes) in bands.iter_mut().zip(&work) {
                        let out = &mut band[first..first + count];
                        for ((o, r), s) in out.iter_mut().zip(lanes).zip(scale) {
                            *o = r * s;
                        }
                    }
                }
            });
        }
        Ok(Repainted { cube: SpectralCube::new(self.grid, planes)?, missed: missed.into_inner() })
    }

    /// The reflectances of some adjacent pixels of a row, from the first in the picture; the factors that bring back
    /// the values above 1; and the number of pixels whose colour is missed.
    fn paint(
        &self,
        picture: &Picture,
        segments: &Segments,
        mixtures: &[PaddedSpectrum],
        (first, count): (usize, usize),
        work: &mut [Lanes],
    ) -> (Lanes, usize) {
        let mixed = Mixed { repaint: self, picture, segments, mixtures, first, count, work };
        let (target, scale) = dispatch(mixed);
        let base = work.to_vec();
        let error = close(&self.wavelengths, work, target);
        let far = (0..count)
            .filter(|&l| error[l] > TOLERANCE)
            .filter(|&l| !self.fit_again(&base, work, l, target.map(|t| f64::from(t[l]))))
            .count();
        (scale, far)
    }

    /// The correction of one pixel in double precision, with damped steps; whether it has the colour.
    #[cold]
    fn fit_again(&self, base: &[Lanes], work: &mut [Lanes], lane: usize, xyz: [f64; 3]) -> bool {
        let logit = |r: f32| {
            let r = f64::from(r.clamp(closure::DARKEST, closure::LIGHTEST));
            (r - 0.5) / (r * (1.0 - r)).sqrt()
        };
        let fit = self.fit.on(base.iter().map(|lanes| logit(lanes[lane])));
        let target = lab_from_xyz(xyz, [1.0; 3]);
        let coefficients = fit.solved(target, [0.0; 3], FIT_TOLERANCE);
        for ((out, base), nm) in work.iter_mut().zip(base).zip(self.grid.wavelengths_nm()) {
            let x = logit(base[lane]) + polynomial(coefficients, position(nm));
            out[lane] = sigmoid(x) as f32;
        }
        let painted: Vec<f64> = work.iter().map(|lanes| f64::from(lanes[lane])).collect();
        let lab = lab_from_xyz(self.fit.xyz_of(&painted), [1.0; 3]);
        let square: f64 = lab.iter().zip(target).map(|(a, b)| (a - b) * (a - b)).sum();
        // Rounding to single precision costs up to 0.01.
        square.sqrt() <= FIT_TOLERANCE + 0.01
    }

    fn picture(&self, image: &Image) -> Picture {
        let n = image.planes().plane_len();
        let source = image.channels();
        let mut rgb = [(); 3].map(|()| vec![0.0f32; n]);
        let mut scale = vec![1.0f32; n];
        for i in 0..n {
            let v = source.map(|p| p[i].max(0.0));
            let largest = v[0].max(v[1]).max(v[2]);
            scale[i] = largest.max(1.0);
            // Black has no hue; it counts as grey.
            let limited = largest.clamp(DARKEST, LIGHTEST);
            for c in 0..3 {
                rgb[c][i] = if largest > 0.0 { v[c] / largest * limited } else { DARKEST };
            }
        }
        let pixels: Vec<[f32; 3]> = (0..n)
            .into_par_iter()
            .map(|i| self.fit.target(&[0, 1, 2].map(|c| f64::from(rgb[c][i]))).map(|v| v as f32))
            .collect();
        let lab = [0, 1, 2].map(|c| pixels.iter().map(|p| p[c]).collect());
        Picture { cols: image.cols(), rgb, lab, scale }
    }
}

/// A reflectance in whole registers, with zeros beyond its last wavelength.
type PaddedSpectrum = Vec<[f32; LANES]>;

fn padded(reflectance: &[f64]) -> PaddedSpectrum {
    let register =
        |values: &[f64]| std::array::from_fn(|i| values.get(i).copied().unwrap_or_default() as f32);
    reflectance.chunks(LANES).map(register).collect()
}

/// The mixtures of some adjacent pixels of a row, scaled to their luminance.
struct Mixed<'a> {
    repaint: &'a Repaint,
    picture: &'a Picture,
    segments: &'a Segments,
    mixtures: &'a [PaddedSpectrum],
    first: usize,
    count: usize,
    work: &'a mut [Lanes],
}

impl Kernel for Mixed<'_> {
    /// X, Y, Z of the pixels, and the factors that bring back the values above 1.
    type Output = ([Lanes; 3], Lanes);

    #[inline(always)]
    fn run(self) -> Self::Output {
        let Self {
            repaint: Repaint { fit, wavelengths, .. },
            picture,
            segments,
            mixtures,
            first,
            count,
            work,
        } = self;
        let mut target = [[0.5; LANES]; 3];
        let mut scale = [1.0; LANES];
        let mut sum = vec![[0.0f32; LANES]; work.len().div_ceil(LANES)];
        for l in 0..count {
            let i = first + l;
            let lab = [0, 1, 2].map(|c| picture.lab[c][i]);
            let shares = segments.shares(i / picture.cols, i % picture.cols, lab);
            sum.fill([0.0; LANES]);
            for (&segment, &weight) in shares.segments.iter().zip(&shares.weights).take(shares.count) {
                if weight > 0.0 {
                    for (sum, mixture) in sum.iter_mut().zip(&mixtures[segment]) {
                        for k in 0..LANES {
                            sum[k] += weight * mixture[k];
                        }
                    }
                }
            }
            let xyz = fit.xyz([0, 1, 2].map(|c| f64::from(picture.rgb[c][i])));
            for (lanes, s) in work.iter_mut().zip(sum.as_flattened()) {
                lanes[l] = *s;
            }
            for c in 0..3 {
                target[c][l] = xyz[c] as f32;
            }
            scale[l] = picture.scale[i];
        }
        // Lanes from `count` on have no meaning, and may be no number.
        let (mut luminance, mut largest) = ([0.0f32; LANES], [0.0f32; LANES]);
        for (lanes, w) in work.iter().zip(wavelengths) {
            for l in 0..LANES {
                luminance[l] += lanes[l] * w.weights[1];
                largest[l] = if lanes[l] > largest[l] { lanes[l] } else { largest[l] };
            }
        }
        let mut factor = [0.0f32; LANES];
        for l in 0..LANES {
            factor[l] = (target[1][l] / luminance[l]).min(closure::LIGHTEST / largest[l]);
        }
        for lanes in work.iter_mut() {
            for l in 0..LANES {
                lanes[l] *= factor[l];
            }
        }
        (target, scale)
    }
}

/// A photograph as planes.
struct Picture {
    cols: usize,
    /// Linear sRGB, within the bounds.
    rgb: [Vec<f32>; 3],
    /// CIELAB under D65.
    lab: [Vec<f32>; 3],
    /// What a pixel was divided by.
    scale: Vec<f32>,
}

#[cfg(test)]
mod tests;
