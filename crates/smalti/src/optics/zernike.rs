//! Zernike polynomials, orthonormal on the unit disc: the RMS wavefront error of a term is its coefficient.
//!
//! Numbered as by Noll (1976) or by OSA/ANSI Z80.28. Angles are counted from the pupil's x axis (to the right in
//! the picture) towards y (up).

use serde::{Deserialize, Serialize};

use super::error::OpticsError;
use crate::numeric::require;

/// Modes up to a radial order of 20; beyond it the sums below would lose digits.
const MODES: usize = 231;

/// One polynomial, by radial order `n` and azimuthal frequency `m` (negative: sine).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
pub struct ZernikeMode {
    n: u32,
    m: i32,
}

/// How modes are numbered. Defocus is 4 in both.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum ZernikeIndex {
    /// Noll 1976, counted from 1 (piston).
    Noll,
    /// OSA/ANSI Z80.28, counted from 0 (piston).
    Osa,
}

impl ZernikeMode {
    /// The mode with a number.
    ///
    /// # Errors
    /// When there is none, or its order is above 20.
    pub fn from_index(index: ZernikeIndex, number: usize) -> Result<Self, OpticsError> {
        let (first, expected) = match index {
            ZernikeIndex::Noll => (1, "1 to 231 (Noll)"),
            ZernikeIndex::Osa => (0, "0 to 230 (OSA/ANSI)"),
        };
        if !(first..first + MODES).contains(&number) {
            return Err(OpticsError::ZernikeNumber { number, expected });
        }
        // Both numberings run through the orders one after another: the order is known from the count.
        let mut n = 0u32;
        while (n as usize + 1) * (n as usize + 2) / 2 <= number - first {
            n += 1;
        }
        let signed = n as i32;
        (-signed..=signed)
            .step_by(2)
            .map(|m| Self { n, m })
            .find(|mode| mode.number(index) == number)
            .ok_or(OpticsError::ZernikeNumber { number, expected })
    }

    /// Its number.
    #[must_use]
    pub fn number(self, index: ZernikeIndex) -> usize {
        let (n, m) = (self.n as usize, self.m);
        match index {
            ZernikeIndex::Osa => ((n * (n + 2)) as i64 + i64::from(m)) as usize / 2,
            ZernikeIndex::Noll => {
                // Even numbers are cosines; which of ±m comes first depends on the order.
                let cosine_first = n % 4 < 2;
                let second = if cosine_first { m <= 0 } else { m >= 0 };
                n * (n + 1) / 2 + m.unsigned_abs() as usize + usize::from(second)
            }
        }
    }

    /// Value at a point of the unit disc.
    #[must_use]
    pub fn at(self, x: f64, y: f64) -> f64 {
        let (n, m) = (self.n, self.m.unsigned_abs());
        let rho2 = x * x + y * y;
        // R = Σ (−1)^k (n−k)! / (k! (p−k)! (q−k)!) ρ^(n−2k), p and q = (n ± m) / 2; Horner in ρ² from k = 0.
        let (p, q) = (f64::from((n + m) / 2), f64::from((n - m) / 2));
        let mut term = (0..(n - m) / 2).fold(1.0, |b, i| b * f64::from(n - i) / (q - f64::from(i)));
        let mut radial = term;
        for k in 0..(n - m) / 2 {
            let k = f64::from(k);
            term *= -(p - k) * (q - k) / ((k + 1.0) * (f64::from(n) - k));
            radial = radial * rho2 + term;
        }
        // ρ^m cos mθ and ρ^m sin mθ are the parts of (x + iy)^m.
        let (re, im) = (0..m).fold((1.0, 0.0), |(re, im), _| (re * x - im * y, re * y + im * x));
        let norm = f64::from((n + 1) * if m == 0 { 1 } else { 2 }).sqrt();
        norm * radial * if self.m < 0 { im } else { re }
    }
}

/// Unit of Zernike coefficients.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub enum WavefrontUnit {
    /// µm.
    Micrometres,
    /// Waves of this length, nm.
    Waves {
        /// The wavelength, nm. The error in metres is the same at all wavelengths.
        at_nm: f64,
    },
}

/// A wavefront error as a sum of Zernike modes, the same length at every wavelength.
///
/// The sign is fixed by the image: a tilt with a positive coefficient moves it towards +x (right) or +y (up).
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Wavefront {
    /// Modes and their coefficients, m.
    terms: Vec<(ZernikeMode, f64)>,
}

impl Wavefront {
    /// From coefficients of single modes; a mode may come more than once.
    ///
    /// # Errors
    /// When a coefficient is not finite, or the wavelength of the unit is not positive.
    pub fn new(terms: &[(ZernikeMode, f64)], unit: WavefrontUnit) -> Result<Self, OpticsError> {
        let metres = match unit {
            WavefrontUnit::Micrometres => 1e-6,
            WavefrontUnit::Waves { at_nm } => {
                require(at_nm > 0.0, "wavelength of the Zernike coefficients", at_nm, "more than 0")?;
                at_nm * 1e-9
            }
        };
        let scaled = terms.iter().map(|&(mode, c)| {
            require(true, "a Zernike coefficient", c, "a finite number")?;
            Ok((mode, c * metres))
        });
        let mut terms = scaled.collect::<Result<Vec<_>, OpticsError>>()?;
        terms.retain(|&(_, c)| c != 0.0);
        Ok(Self { terms })
    }

    /// The error at a point of the pupil (unit disc), m.
    #[must_use]
    pub fn at_m(&self, x: f64, y: f64) -> f64 {
        self.terms.iter().map(|(mode, c)| c * mode.at(x, y)).sum()
    }

    /// Largest slope over the pupil, m per pupil radius.
    pub(super) fn steepest_m(&self) -> f64 {
        const N: i32 = 64;
        const STEP: f64 = 1.0 / 1024.0;
        let mut steepest = 0.0f64;
        if self.terms.is_empty() {
            return steepest;
        }
        for (r, c) in (-N..=N).flat_map(|r| (-N..=N).map(move |c| (r, c))) {
            let (x, y) = (f64::from(c) / f64::from(N), f64::from(r) / f64::from(N));
            if x * x + y * y <= 1.0 {
                let dx = self.at_m(x + STEP, y) - self.at_m(x - STEP, y);
                let dy = self.at_m(x, y + STEP) - self.at_m(x, y - STEP);
                steepest = steepest.max(dx.hypot(dy) / (2.0 * STEP));
            }
        }
        steepest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn published_numbers() {
        // n, m, Noll, OSA: Noll 1976 table I; ANSI Z80.28 table 1.
        let table = [
            (0, 0, 1, 0),
            (1, 1, 2, 2),
            (1, -1, 3, 1),
            (2, 0, 4, 4),
            (2, -2, 5, 3),
            (2, 2, 6, 5),
            (3, -1, 7, 7),
            (3, 1, 8, 8),
            (3, -3, 9, 6),
            (3, 3, 10, 9),
            (4, 0, 11, 12),
            (4, 2, 12, 13),
            (4, -2, 13, 11),
            (4, 4, 14, 14),
            (4, -4, 15, 10),
            (5, 1, 16, 18),
            (5, -1, 17, 17),
            (6, 0, 22, 24),
        ];
        for (n, m, noll, osa) in table {
            let mode = ZernikeMode { n, m };
            assert_eq!(
                (mode.number(ZernikeIndex::Noll), mode.number(ZernikeIndex::Osa)),
                (noll, osa),
                "{n} {m}"
            );
        }
    }

    #[test]
    fn numbers_convert_both_ways() {
        for (index, first) in [(ZernikeIndex::Noll, 1), (ZernikeIndex::Osa, 0)] {
            for j in first..first + MODES {
                assert_eq!(ZernikeMode::from_index(index, j).unwrap().number(index), j);
            }
            assert!(ZernikeMode::from_index(index, first + MODES).is_err());
        }
        assert!(ZernikeMode::from_index(ZernikeIndex::Noll, 0).is_err());
    }

    #[test]
    fn polynomials_as_published() {
        let (x, y) = (0.3, -0.5);
        let r2: f64 = x * x + y * y;
        let value = |n, m| ZernikeMode { n, m }.at(x, y);
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
        close(value(1, -1), 2.0 * y);
        close(value(2, 0), 3f64.sqrt() * (2.0 * r2 - 1.0));
        close(value(2, -2), 6f64.sqrt() * 2.0 * x * y);
        close(value(3, 1), 8f64.sqrt() * (3.0 * r2 - 2.0) * x);
        close(value(4, 0), 5f64.sqrt() * (6.0 * r2 * r2 - 6.0 * r2 + 1.0));
    }

    #[test]
    fn modes_are_orthonormal() {
        // Gauss-free check: a fine polar midpoint rule.
        let modes: Vec<_> = (0..28).map(|j| ZernikeMode::from_index(ZernikeIndex::Osa, j).unwrap()).collect();
        let mut gram = vec![0.0; 28 * 28];
        let (nr, nt) = (200, 32);
        for i in 0..nr {
            let r = (i as f64 + 0.5) / f64::from(nr);
            for t in 0..nt {
                let (s, c) = (std::f64::consts::TAU * f64::from(t) / f64::from(nt)).sin_cos();
                let v: Vec<f64> = modes.iter().map(|z| z.at(r * c, r * s)).collect();
                for a in 0..28 {
                    for b in 0..28 {
                        gram[a * 28 + b] += v[a] * v[b] * 2.0 * r / f64::from(nr * nt);
                    }
                }
            }
        }
        for a in 0..28 {
            for b in 0..28 {
                let want = if a == b { 1.0 } else { 0.0 };
                assert!((gram[a * 28 + b] - want).abs() < 2e-3, "{a} {b} {}", gram[a * 28 + b]);
            }
        }
    }

    #[test]
    fn slopes_of_tilt_and_defocus() {
        let mode = |number| ZernikeMode::from_index(ZernikeIndex::Noll, number).unwrap();
        let steepest = |terms: &[(ZernikeMode, f64)]| {
            Wavefront::new(terms, WavefrontUnit::Micrometres).unwrap().steepest_m() * 1e6
        };
        assert!((steepest(&[(mode(1), 5.0), (mode(2), 1.0)]) - 2.0).abs() < 1e-9);
        assert!((steepest(&[(mode(4), 1.0)]) - 4.0 * 3f64.sqrt()).abs() < 1e-6);
    }

    #[test]
    fn waves_and_micrometres_agree() {
        let unit = WavefrontUnit::Waves { at_nm: 500.0 };
        let defocus = [ZernikeIndex::Noll, ZernikeIndex::Osa].map(|i| ZernikeMode::from_index(i, 4).unwrap());
        let a = Wavefront::new(&[(defocus[0], 0.2)], unit).unwrap();
        let b = Wavefront::new(&[(defocus[1], 0.1)], WavefrontUnit::Micrometres).unwrap();
        assert!((a.at_m(0.3, 0.1) - b.at_m(0.3, 0.1)).abs() < 1e-18);
        for (c, at_nm) in [(f64::NAN, 500.0), (1.0, 0.0), (1.0, f64::NAN)] {
            assert!(Wavefront::new(&[(defocus[0], c)], WavefrontUnit::Waves { at_nm }).is_err());
        }
    }
}
