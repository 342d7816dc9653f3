//! The derivative of the expected errors with respect to the filters.
//!
//! With W = (A C Aᵀ + Σ)⁻¹ R, the change of the error covariance is dE = Wᵀ d(A C Aᵀ + Σ) W − dRᵀ W − Wᵀ dR: W itself is the best
//! estimate, so that its change does not matter. A figure with the derivative Φ with respect to E therefore has the derivative
//! Σᵢⱼ (W Φ Wᵀ)ᵢⱼ dGᵢⱼ − 2 Σᵢ (W Φ)ᵢ · dRᵢ.

use super::expected::{ExpectedError, Figures};
use super::kernel::{Layout, MAX_COMPONENTS, System, pairs};
use super::lanes::{LANES, Lanes, ZERO, plus, plus_scaled};
use super::model::Screen;
use super::responses::{FilterResponses, sum_of_products};
use crate::numeric::simd::{Kernel, dispatch};
use crate::sensor::Mosaic;

/// The weights of the figures of one condition in a sum.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FigureWeights {
    /// Of the CPSNR, per dB.
    pub cpsnr_db: f64,
    /// Of the detail, per dB.
    pub detail_db: f64,
    /// Of the mean CIEDE2000, per unit.
    pub delta_e_2000: f64,
}

impl FigureWeights {
    /// The weighted sum of expected figures. A figure without a weight does not count, even if it was not computed.
    #[must_use]
    pub fn of(&self, expected: &ExpectedError) -> f64 {
        let part = |weight: f64, figure: f64| if weight == 0.0 { 0.0 } else { weight * figure };
        part(self.cpsnr_db, expected.cpsnr_db)
            + part(self.detail_db, expected.detail_db)
            + part(self.delta_e_2000, expected.delta_e_2000)
    }

    /// All weights times a factor.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        let Self { cpsnr_db, detail_db, delta_e_2000 } = self;
        Self {
            cpsnr_db: cpsnr_db * factor,
            detail_db: detail_db * factor,
            delta_e_2000: delta_e_2000 * factor,
        }
    }

    /// The sums of two sets of weights.
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            cpsnr_db: self.cpsnr_db + other.cpsnr_db,
            detail_db: self.detail_db + other.detail_db,
            delta_e_2000: self.delta_e_2000 + other.delta_e_2000,
        }
    }
}

/// The expected errors of filters in a mosaic, with what their derivatives need.
pub struct Differentiable<'a> {
    forward: Forward<'a>,
    /// The exposure time of each condition, s, and the filter that limits it.
    times: Vec<(f64, Option<usize>)>,
    expected: Vec<ExpectedError>,
}

impl Differentiable<'_> {
    /// The expected errors, one for each condition.
    #[must_use]
    pub fn expected(&self) -> &[ExpectedError] {
        &self.expected
    }

    /// The derivative of a weighted sum of the figures with respect to the response of each filter to each component. `weights` has an
    /// entry for each condition; conditions without one do not count. A colour difference that was not computed cannot be weighted.
    #[must_use]
    pub fn by_response(&self, weights: &[FigureWeights]) -> Vec<Vec<f64>> {
        let Forward { screen, layout, responses, .. } = &self.forward;
        let mut weights = weights.to_vec();
        weights.resize(screen.levels.len(), FigureWeights::default());
        let mut backward = Backward {
            forward: &self.forward,
            expected: &self.expected,
            weights: &weights,
            by_response: vec![vec![ZERO; screen.components]; layout.filters()],
            by_scale: vec![0.0; screen.levels.len()],
        };
        dispatch(&mut backward);
        let mut by_response: Vec<Vec<f64>> =
            backward.by_response.iter().map(|f| f.iter().map(|lanes| lanes.iter().sum()).collect()).collect();
        let limits = backward.by_scale.iter().zip(&self.times).zip(&screen.levels);
        for ((by_scale, (time_s, limit)), level) in limits {
            // The time that white allows is saturation / rate, and its derivative −time / rate · d rate.
            let Some(channel) = *limit else { continue };
            let rate = sum_of_products(&responses.0[channel], &screen.white);
            let factor = -by_scale * level.scale(*time_s) / rate;
            by_response[channel].iter_mut().zip(&screen.white).for_each(|(g, w)| *g += factor * w);
        }
        by_response
    }
}

impl Screen {
    /// The expected errors of filters in a mosaic, which can be differentiated.
    #[must_use]
    pub fn differentiable(
        &self,
        mosaic: &Mosaic,
        responses: &FilterResponses,
        figures: Figures,
    ) -> Differentiable<'_> {
        let layout = Layout::new(self, mosaic);
        let responses = responses.fitted(layout.filters(), self.components).into_owned();
        let mut forward = Forward::new(self, layout, responses);
        dispatch(&mut forward);
        let times: Vec<_> =
            self.levels.iter().map(|l| l.limited_time(&self.white, &forward.responses)).collect();
        let of = |level: usize| {
            self.figures(&forward.errors[level], forward.layout.positions(), figures, times[level].0)
        };
        let expected = (0..self.levels.len()).map(of).collect();
        Differentiable { forward, times, expected }
    }

    /// Φ of each lane for the error covariance of a position and group.
    #[inline(always)]
    fn derivatives(
        &self,
        error: &[Lanes; 6],
        group: usize,
        positions: usize,
        (expected, weights): (&ExpectedError, &FigureWeights),
    ) -> [[Lanes; 3]; 3] {
        let mut phi = [[ZERO; 3]; 3];
        // CPSNR = −10 log₁₀ (mean square): its derivative with respect to the mean square.
        let by_square = |db: f64| -10.0 / std::f64::consts::LN_10 / libm::pow(10.0, -0.1 * db);
        let by_color = by_square(expected.cpsnr_db) * weights.cpsnr_db / 3.0;
        let by_detail = by_square(expected.detail_db) * weights.detail_db / self.detailed_share;
        for lane in 0..LANES {
            let share = self.shares[group][lane] / positions as f64;
            if share <= 0.0 {
                continue;
            }
            let scale = self.per_white_squared[group][lane];
            for (i, row) in phi.iter_mut().enumerate() {
                row[i][lane] = share * scale * by_color;
            }
            phi[1][1][lane] += scale * by_detail * self.detailed[group][lane] / positions as f64;
            if weights.delta_e_2000 != 0.0
                && let Some(color) = self.colors.get(group * LANES + lane)
            {
                let of_color = color.derivative(&error.map(|e| e[lane] * scale));
                for (row, of_color) in phi.iter_mut().zip(of_color) {
                    for (value, d) in row.iter_mut().zip(of_color) {
                        value[lane] += share * scale * weights.delta_e_2000 * d;
                    }
                }
            }
        }
        phi
    }
}

/// Error covariances of one set of filters, and the best estimates.
struct Forward<'a> {
    screen: &'a Screen,
    layout: Layout,
    responses: FilterResponses,
    /// By condition, position and group.
    errors: Vec<Vec<[Lanes; 6]>>,
    /// W by condition, position, group and pixel.
    estimates: Vec<[Lanes; 3]>,
    /// Means by position, group and pixel.
    means: Vec<Lanes>,
}

impl<'a> Forward<'a> {
    fn new(screen: &'a Screen, layout: Layout, responses: FilterResponses) -> Self {
        let each = layout.positions() * screen.groups;
        Self {
            screen,
            layout,
            responses,
            errors: vec![vec![[ZERO; 6]; each]; screen.levels.len()],
            estimates: vec![[ZERO; 3]; screen.levels.len() * each * screen.taps],
            means: vec![ZERO; each * screen.taps],
        }
    }

    /// Index of the first pixel of a condition, position and group.
    #[inline(always)]
    fn at(&self, level: usize, position: usize, group: usize) -> usize {
        ((level * self.layout.positions() + position) * self.screen.groups + group) * self.screen.taps
    }
}

/// The covariance of a pair of pixels times the response of a filter: C f, or Cᵀ f.
#[inline(always)]
fn times(covariance: &[Lanes], response: &[f64], transposed: bool, out: &mut [Lanes; MAX_COMPONENTS]) {
    let k = response.len();
    out[..k].fill(ZERO);
    for (a, row) in covariance.chunks_exact(k).enumerate() {
        for (b, c) in row.iter().enumerate() {
            if transposed {
                out[b] = plus_scaled(out[b], response[a], *c);
            } else {
                out[a] = plus_scaled(out[a], response[b], *c);
            }
        }
    }
}

impl Kernel for &mut Forward<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (screen, layout) = (self.screen, &self.layout);
        let (positions, count, k) = (layout.positions(), pairs(screen.taps), screen.components);
        let mut products = vec![ZERO; positions * count];
        let mut system = System::new(screen);
        let mut right = vec![[ZERO; MAX_COMPONENTS]; layout.filters()];
        for group in 0..screen.groups {
            let mut pair = 0;
            for i in 0..screen.taps {
                for j in i..screen.taps {
                    let covariance = &screen.covariances[(pair * screen.groups + group) * k * k..][..k * k];
                    for (response, right) in self.responses.0.iter().zip(&mut right) {
                        times(covariance, &response[..k], false, right);
                    }
                    for position in 0..positions {
                        let at = layout.at(position);
                        let left = &self.responses.0[usize::from(at[i])];
                        let right = &right[usize::from(at[j])];
                        let mut sum = ZERO;
                        for (f, r) in left.iter().zip(right) {
                            sum = plus_scaled(sum, *f, *r);
                        }
                        products[position * count + pair] = sum;
                    }
                    pair += 1;
                }
            }
            for position in 0..positions {
                system.gather(screen, &self.responses, layout.at(position), group);
                let first = self.at(0, position, group);
                self.means[first..first + screen.taps].copy_from_slice(&system.means);
                for (level, condition) in screen.levels.iter().enumerate() {
                    let time_s = condition.time_s(&screen.white, &self.responses);
                    let products = &products[position * count..(position + 1) * count];
                    system.factor(products, &screen.targets[group], condition, condition.scale(time_s));
                    self.errors[level][position * screen.groups + group] = system.matrix.complement();
                    let first = self.at(level, position, group);
                    system.matrix.solve(&mut self.estimates[first..first + screen.taps]);
                }
            }
        }
    }
}

struct Backward<'a> {
    forward: &'a Forward<'a>,
    expected: &'a [ExpectedError],
    weights: &'a [FigureWeights],
    /// By filter and component.
    by_response: Vec<Vec<Lanes>>,
    /// By the product of luminance and time of each condition.
    by_scale: Vec<f64>,
}

impl Kernel for &mut Backward<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let forward = self.forward;
        let (screen, layout) = (forward.screen, &forward.layout);
        let (positions, taps, k) = (layout.positions(), screen.taps, screen.components);
        // Σ over conditions of W Φ Wᵀ by position and pair.
        let count = pairs(taps);
        let mut outer = vec![ZERO; positions * count];
        let mut weighted = vec![[ZERO; 3]; taps];
        let filters = layout.filters();
        let (mut straight, mut transposed) =
            (vec![[ZERO; MAX_COMPONENTS]; filters], vec![[ZERO; MAX_COMPONENTS]; filters]);
        for group in 0..screen.groups {
            outer.fill(ZERO);
            for position in 0..positions {
                let filter = layout.at(position);
                let first = forward.at(0, position, group);
                let means = &forward.means[first..first + taps];
                for (level, condition) in screen.levels.iter().enumerate() {
                    let error = &forward.errors[level][position * screen.groups + group];
                    let figures = (&self.expected[level], &self.weights[level]);
                    let phi = screen.derivatives(error, group, positions, figures);
                    let first = forward.at(level, position, group);
                    let estimate = &forward.estimates[first..first + taps];
                    for (out, w) in weighted.iter_mut().zip(estimate) {
                        for (c, out) in out.iter_mut().enumerate() {
                            let mut sum = ZERO;
                            for d in 0..3 {
                                sum = plus(sum, w[d], phi[d][c]);
                            }
                            *out = sum;
                        }
                    }
                    let time_s = self.expected[level].time_s;
                    let scale = condition.scale(time_s);
                    let (per_e, dark) = (condition.per_e / scale, condition.dark_e2 / (scale * scale));
                    let mut pair = position * count;
                    for i in 0..taps {
                        for j in i..taps {
                            let mut sum = ZERO;
                            for c in 0..3 {
                                sum = plus(sum, weighted[i][c], estimate[j][c]);
                            }
                            for lane in 0..LANES {
                                outer[pair][lane] += sum[lane];
                            }
                            if i == j {
                                // The variance of the noise: dark + μ per_e + μ² per_e².
                                let gradient = &mut self.by_response[usize::from(filter[i])];
                                let means_at = (i * screen.groups + group) * k;
                                let mut by_mean = ZERO;
                                for lane in 0..LANES {
                                    let mean = means[i][lane];
                                    let slope = per_e + 2.0 * condition.per_e2 * mean;
                                    by_mean[lane] = if mean > 0.0 { sum[lane] * slope } else { 0.0 };
                                    self.by_scale[level] -= sum[lane] * (mean * per_e + 2.0 * dark) / scale;
                                }
                                for (a, g) in gradient.iter_mut().enumerate() {
                                    *g = plus(*g, by_mean, screen.means[means_at + a]);
                                }
                            }
                            pair += 1;
                        }
                        let gradient = &mut self.by_response[usize::from(filter[i])];
                        let crossed_at = (i * screen.groups + group) * k;
                        for (a, g) in gradient.iter_mut().enumerate() {
                            let mut sum = ZERO;
                            for c in 0..3 {
                                sum = plus(sum, weighted[i][c], screen.crossed[crossed_at + a][c]);
                            }
                            *g = plus_scaled(*g, -2.0, sum);
                        }
                    }
                }
            }
            let mut pair = 0;
            for i in 0..taps {
                for j in i..taps {
                    let covariance = &screen.covariances[(pair * screen.groups + group) * k * k..][..k * k];
                    for (filter, response) in forward.responses.0.iter().enumerate() {
                        times(covariance, &response[..k], false, &mut straight[filter]);
                        if i < j {
                            times(covariance, &response[..k], true, &mut transposed[filter]);
                        }
                    }
                    for position in 0..positions {
                        let at = layout.at(position);
                        let (a, b) = (usize::from(at[i]), usize::from(at[j]));
                        let q = outer[position * count + pair];
                        let twice = q.map(|v| 2.0 * v);
                        // The pair (j, i) has the same products as (i, j); a pixel with itself has both factors.
                        for (g, c) in self.by_response[a].iter_mut().zip(&straight[b]) {
                            *g = plus(*g, twice, *c);
                        }
                        if i < j {
                            for (g, c) in self.by_response[b].iter_mut().zip(&transposed[a]) {
                                *g = plus(*g, twice, *c);
                            }
                        }
                    }
                    pair += 1;
                }
            }
        }
    }
}
