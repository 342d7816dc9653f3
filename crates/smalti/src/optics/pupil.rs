//! The sampled pupil of an aberrated lens, and its autocorrelation.

use std::f64::consts::TAU;

use super::error::OpticsError;
use super::otf::FrequencyGrid;
use super::zernike::Wavefront;
use crate::numeric::fft::{Complex32, RealFft2};

/// Samples over the diameter of the pupil: the available sizes.
const SAMPLES: [usize; 3] = [256, 512, 1024];
/// Largest change of the wavefront between samples, waves. With 16 samples per fringe the interpolation error
/// is 10⁻³.
const WAVES_PER_SAMPLE: f64 = 1.0 / 16.0;

/// A wavefront sampled over the pupil, and the number of sample pairs within both pupils at every shift.
///
/// The autocorrelation of the pupil function is the diffraction limit times the mean phase factor over the
/// overlap of the two shifted pupils. The diffraction limit is known exactly; only the mean is sampled.
pub(super) struct Pupil {
    fft: RealFft2,
    /// Wavefront error in m inside the pupil, NaN outside.
    error_m: Vec<f64>,
    /// ρ² at the samples of `error_m`.
    rho2: Vec<f64>,
    pairs: Vec<Complex32>,
}

impl Pupil {
    /// `slope_m` is the largest change per pupil radius; `shortest_m` is the shortest wavelength in use.
    pub(super) fn new(wavefront: &Wavefront, slope_m: f64, shortest_m: f64) -> Result<Self, OpticsError> {
        let waves_per_radius = slope_m / shortest_m;
        let limit = |n: usize| WAVES_PER_SAMPLE * n as f64 / 2.0;
        let Some(n) = SAMPLES.into_iter().find(|&n| waves_per_radius <= limit(n)) else {
            return Err(OpticsError::WavefrontTooSteep { waves_per_radius, limit: limit(SAMPLES[2]) });
        };
        // Twice the diameter, so that the autocorrelation does not wrap around.
        let side = 2 * n;
        let fft = RealFft2::new(side, side)?;
        let mut error_m = vec![f64::NAN; side * side];
        let mut rho2 = vec![0.0; side * side];
        let at = |i: usize| (i as f64 - (n / 2) as f64) * 2.0 / n as f64;
        for r in 0..=n {
            for c in 0..=n {
                let (x, y) = (at(c), -at(r));
                if x * x + y * y < 1.0 {
                    error_m[r * side + c] = wavefront.at_m(x, y);
                    rho2[r * side + c] = x * x + y * y;
                }
            }
        }
        let mut pupil = Self { fft, error_m, rho2, pairs: Vec::new() };
        pupil.pairs = pupil.autocorrelation(|_| (1.0, 0.0))?;
        for v in &mut pupil.pairs {
            // Counts are whole numbers; a fraction is rounding error of the transform.
            *v = Complex32::new(v.re.round(), 0.0);
        }
        Ok(pupil)
    }

    /// Mean phase factor at every frequency, for a wavelength and an additional defocus W₂₀ (m).
    pub(super) fn mean_phase(
        &self,
        wavelength_m: f64,
        rim_m: f64,
        cutoff_cy_per_m: f64,
    ) -> Result<FrequencyGrid, OpticsError> {
        let mut mean = self.autocorrelation(|i| {
            let (sin, cos) = (TAU * (self.error_m[i] + rim_m * self.rho2[i]) / wavelength_m).sin_cos();
            (cos as f32, sin as f32)
        })?;
        for (v, pairs) in mean.iter_mut().zip(&self.pairs) {
            *v = if pairs.re > 0.0 { *v / pairs.re } else { Complex32::default() };
        }
        let side = self.fft.rows();
        // One sample of shift in the pupil is 1 / (samples per diameter) of the cut-off.
        Ok(FrequencyGrid::new(side, cutoff_cy_per_m / (side / 2) as f64, mean))
    }

    /// Σ P(x) P*(x + shift) of the pupil function, as a half spectrum in the order of [`RealFft2`].
    fn autocorrelation(&self, value: impl Fn(usize) -> (f32, f32)) -> Result<Vec<Complex32>, OpticsError> {
        let side = self.fft.rows();
        let mut re = vec![0.0; side * side];
        let mut im = vec![0.0; side * side];
        for i in 0..side * side {
            if !self.error_m[i].is_nan() {
                (re[i], im[i]) = value(i);
            }
        }
        let (a, b) = (self.fft.forward(&re)?, self.fft.forward(&im)?);
        let mut psf = re;
        let i = Complex32::i();
        for (at, (a, b)) in a.iter().zip(&b).enumerate() {
            let (kx, ky) = (at / side, at % side);
            psf[ky * side + kx] = (a + i * b).norm_sqr();
            let opposite = (side - ky) % side * side + (side - kx) % side;
            psf[opposite] = (a.conj() + i * b.conj()).norm_sqr();
        }
        let scale = 1.0 / (side * side) as f32;
        let mut sums = self.fft.forward(&psf)?;
        sums.iter_mut().for_each(|v| *v *= scale);
        Ok(sums)
    }
}

#[cfg(test)]
mod tests {
    use super::super::diffraction::{diffraction_limit, out_of_focus};
    use super::super::otf::lookup;
    use super::super::zernike::{Wavefront, WavefrontUnit, ZernikeIndex, ZernikeMode};
    use super::*;

    #[test]
    fn the_autocorrelation_of_a_clear_pupil_is_the_diffraction_limit() {
        let pupil = Pupil::new(&Wavefront::default(), 0.0, 500e-9).unwrap();
        let side = pupil.fft.rows();
        let total = pupil.pairs[0].re;
        for kx in 0..=side / 2 {
            for ky in 0..side / 2 {
                let nu = (kx as f64).hypot(ky as f64) / (side / 2) as f64;
                let got = f64::from(pupil.pairs[kx * side + ky].re / total);
                // The counts are lattice points in an overlap of this size: the error is a few points along
                // its rim.
                assert!((got - diffraction_limit(nu)).abs() < 1e-3, "{nu} {got} {}", diffraction_limit(nu));
            }
        }
    }

    #[test]
    fn defocus_agrees_with_hopkins() {
        for waves in [0.25, 1.0, 3.0] {
            let pupil = Pupil::new(&Wavefront::default(), 2.0 * waves * 500e-9, 500e-9).unwrap();
            let grid = pupil.mean_phase(500e-9, waves * 500e-9, 1.0).unwrap();
            let table = out_of_focus(waves);
            for i in 0..60 {
                for angle in [0.0f64, 0.3, 0.785, 2.0] {
                    let nu = f64::from(i) / 60.0;
                    let got = grid.at(nu * angle.cos(), nu * angle.sin()) * diffraction_limit(nu) as f32;
                    let want = lookup(&table, nu as f32);
                    assert!((got.re - want).abs() < 2e-3, "{waves} {nu} {angle} {got} {want}");
                    assert!(got.im.abs() < 2e-3);
                }
            }
        }
    }

    #[test]
    fn a_tilt_is_a_shift() {
        // Z2 with coefficient c is 2 c x: by 2c per radius, 2N · 2c on the sensor; with N λ = 1, 4c / λ.
        let unit = WavefrontUnit::Waves { at_nm: 500.0 };
        for (number, dx, dy) in [(2, 1.0, 0.0), (3, 0.0, 1.0)] {
            let mode = ZernikeMode::from_index(ZernikeIndex::Noll, number).unwrap();
            let tilt = Wavefront::new(&[(mode, 0.5)], unit).unwrap();
            let pupil = Pupil::new(&tilt, tilt.steepest_m(), 500e-9).unwrap();
            let grid = pupil.mean_phase(500e-9, 0.0, 1.0).unwrap();
            for (fx, fy) in [(0.1, 0.0), (0.0, 0.2), (0.3, 0.4), (-0.3, 0.2), (0.2, -0.3)] {
                let got = grid.at(fx, fy);
                // Rows increase downwards, y upwards.
                let turn = -TAU * (fx * dx - fy * dy) * 2.0;
                assert!((f64::from(got.re) - turn.cos()).abs() < 1e-3, "{fx} {fy} {got}");
                assert!((f64::from(got.im) - turn.sin()).abs() < 1e-3, "{fx} {fy} {got}");
            }
        }
    }

    #[test]
    fn too_steep_is_refused() {
        let r = Pupil::new(&Wavefront::default(), 1e-3, 500e-9);
        assert!(matches!(r, Err(OpticsError::WavefrontTooSteep { .. })));
        assert!(Pupil::new(&Wavefront::default(), f64::NAN, 500e-9).is_err());
    }
}
