//! What limits a colour filter array: the shares of its expected error by cause.
//!
//! The error of the best linear estimate falls in two steps. Without noise, what is left is the limit of the mosaic and its filters; the
//! difference is due to noise. With a sample of every filter at every pixel and without noise, what is left is the limit of the filters; the
//! difference is due to sampling, which pictures show as aliasing and blur, and to crosstalk. The rest is due to colour: the filters do not span the functions of the
//! observer. Each step has more information than the one before, so that no share is negative, and the three add up to the whole.

use super::color_error::PACKED;
use super::condition::Level;
use super::figures::Figures;
use super::kernel;
use super::lanes::{Augmented, LANES, Lanes, ZERO, plus_scaled};
use super::model::Screen;
use super::responses::FilterResponses;
use crate::sensor::Mosaic;

/// A cause's part of an error.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct CausedError {
    /// Mean squared error over X, Y, Z, relative to display white.
    pub squared_error: f64,
    /// Mean CIEDE2000.
    pub delta_e_2000: f64,
}

impl CausedError {
    fn minus(self, other: Self) -> Self {
        Self {
            squared_error: self.squared_error - other.squared_error,
            delta_e_2000: self.delta_e_2000 - other.delta_e_2000,
        }
    }
}

/// The expected error of the patches of a class, by cause. The parts add up to the whole.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClassLimits {
    /// Share of the patches that are of the class.
    pub patches: f64,
    /// What noise adds.
    pub noise: CausedError,
    /// What the mosaic adds, which has one filter at a pixel, and crosstalk.
    pub sampling: CausedError,
    /// What is left with every filter at every pixel and without noise.
    pub color: CausedError,
}

impl ClassLimits {
    /// The whole error of the class.
    #[must_use]
    pub fn total(&self) -> CausedError {
        let sum = |of: fn(&CausedError) -> f64| of(&self.noise) + of(&self.sampling) + of(&self.color);
        CausedError { squared_error: sum(|c| c.squared_error), delta_e_2000: sum(|c| c.delta_e_2000) }
    }
}

impl Screen {
    /// The causes of the expected error of a colour filter array, for each condition and class. The means over the classes, weighted with
    /// their patches, are the errors of [`Screen::expected_of`].
    #[must_use]
    pub fn limits(&self, mosaic: &Mosaic, responses: &FilterResponses) -> Vec<Vec<ClassLimits>> {
        let layout = self.layout(mosaic);
        let responses = responses.fitted(layout.filters(), self.components).into_owned();
        let set = std::slice::from_ref(&responses);
        let classes = |errors: &[[Lanes; 6]]| self.by_class(errors);
        let of =
            |screen: &Self| kernel::errors(screen, &layout, set, Figures::Color).pop().unwrap_or_default();
        let noisy: Vec<Vec<CausedError>> = of(self).iter().map(|e| classes(&e.pixels)).collect();
        let levels = self.levels.iter().map(Level::without_noise).collect();
        let noiseless: Vec<Vec<CausedError>> =
            of(&Self { levels, ..self.clone() }).iter().map(|e| classes(&e.pixels)).collect();
        let everywhere = classes(&self.with_every_filter(&responses));
        let patches: Vec<f64> = self.shares.iter().flatten().copied().filter(|s| *s > 0.0).collect();
        let of_condition = |(noisy, noiseless): (&Vec<CausedError>, &Vec<CausedError>)| {
            let of_class =
                |(((patches, total), still), color): (((&f64, &CausedError), &CausedError), &CausedError)| {
                    ClassLimits {
                        patches: *patches,
                        noise: total.minus(*still),
                        sampling: still.minus(*color),
                        color: *color,
                    }
                };
            patches.iter().zip(noisy).zip(noiseless).zip(&everywhere).map(of_class).collect()
        };
        noisy.iter().zip(&noiseless).map(of_condition).collect()
    }

    /// The mean error of each class over the positions. `errors` are by position and group.
    fn by_class(&self, errors: &[[Lanes; 6]]) -> Vec<CausedError> {
        let positions = (errors.len() / self.groups.max(1)).max(1) as f64;
        let mut out = Vec::new();
        for group in 0..self.groups {
            for lane in 0..LANES {
                if self.shares[group][lane] <= 0.0 {
                    continue;
                }
                let mut sum = CausedError::default();
                for error in errors.iter().skip(group).step_by(self.groups) {
                    let figures = self.figures_of(error, group, lane, Figures::Color);
                    sum.squared_error += figures[0] / positions;
                    sum.delta_e_2000 += figures[1] / positions;
                }
                out.push(sum);
            }
        }
        out
    }

    /// The error covariances of a sensor without noise and crosstalk that samples every filter at every pixel, by group.
    fn with_every_filter(&self, responses: &FilterResponses) -> Vec<[Lanes; 6]> {
        let (k, filters) = (self.components, responses.0.len());
        let samples = self.light_taps * filters;
        // The factorisation takes one more than a multiple of four. Samples that see no light add nothing.
        let padded = samples.div_ceil(4) * 4 + 1;
        let of_group = |group: usize| {
            let mut matrix = Augmented::new(padded);
            let mut pair = 0;
            for i in 0..self.light_taps {
                for j in i..self.light_taps {
                    let covariance = &self.covariances[(pair * self.groups + group) * k * k..][..k * k];
                    for (a, left) in responses.0.iter().enumerate() {
                        for (b, right) in responses.0.iter().enumerate() {
                            let (row, col) = (j * filters + b, i * filters + a);
                            if row < col {
                                continue;
                            }
                            let mut sum = ZERO;
                            for (l, row) in left.iter().zip(covariance.chunks_exact(k)) {
                                for (r, c) in right.iter().zip(row) {
                                    sum = plus_scaled(sum, l * r, *c);
                                }
                            }
                            matrix.set(row, col, sum);
                        }
                    }
                    pair += 1;
                }
            }
            for i in 0..self.light_taps {
                for (a, response) in responses.0.iter().enumerate() {
                    let first = (i * self.groups + group) * k;
                    let mut crossed = [ZERO; 3];
                    let mut mean = ZERO;
                    for (f, at) in response.iter().zip(first..) {
                        mean = plus_scaled(mean, *f, self.means[at]);
                        for (sum, c) in crossed.iter_mut().zip(&self.crossed[at]) {
                            *sum = plus_scaled(*sum, *f, *c);
                        }
                    }
                    let at = i * filters + a;
                    let mut diagonal = matrix.get(at, at);
                    for lane in 0..LANES {
                        diagonal[lane] += Level::UNKNOWN * mean[lane] * mean[lane];
                    }
                    matrix.set(at, at, diagonal);
                    for (c, value) in crossed.into_iter().enumerate() {
                        matrix.set(padded + c, at, value);
                    }
                }
            }
            for ((c, d), value) in PACKED.into_iter().zip(&self.targets[group]) {
                matrix.set(padded + c, padded + d, *value);
            }
            matrix.factor();
            matrix.complement()
        };
        (0..self.groups).map(of_group).collect()
    }
}
