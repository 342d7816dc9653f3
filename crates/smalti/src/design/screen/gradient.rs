//! The derivative of the expected errors with respect to the filters.
//!
//! With W = (A C Aᵀ + Σ)⁻¹ R, the change of the error covariance is dE = Wᵀ d(A C Aᵀ + Σ) W − dRᵀ W − Wᵀ dR: W itself is the best
//! estimate, so that its change does not matter. A figure with the derivative Φ with respect to E therefore has the derivative
//! Σᵢⱼ (W Φ Wᵀ)ᵢⱼ dGᵢⱼ − 2 Σᵢ (W Φ)ᵢ · dRᵢ.
//!
//! The error that the eye sees ([`super::eye`]) weights the noise Wᵀ Σ W differently, and W is not the best estimate for it. With the
//! derivative D of such a figure with respect to W and Λ = (A C Aᵀ + Σ)⁻¹ D, the change of W adds Σᵢ Λᵢ · dRᵢ − Σᵢⱼ (Λ Wᵀ)ᵢⱼ dGᵢⱼ.

use super::expected::ExpectedError;
use super::eye::SampleNoise;
use super::figures::Figures;
use super::kernel::{ErrorCovariances, MAX_COMPONENTS, System, add, pairs, signal_error, times};
use super::lanes::{Augmented, LANES, Lanes, ZERO, plus, plus_scaled};
use super::layout::Layout;
use super::model::Screen;
use super::responses::{FilterResponses, sum_of_products};
use super::weights::FigureWeights;
use crate::numeric::simd::{Kernel, dispatch};
use crate::sensor::Mosaic;

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
        let layout = self.layout(mosaic);
        let responses = responses.fitted(layout.filters(), self.components).into_owned();
        let mut forward = Forward::new(self, layout, responses, figures);
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

    /// Φ of each lane for the error that the eye sees.
    #[inline(always)]
    fn seen_derivatives(
        &self,
        error: &[Lanes; 6],
        group: usize,
        positions: usize,
        weight: f64,
    ) -> [[Lanes; 3]; 3] {
        let mut phi = [[ZERO; 3]; 3];
        for lane in 0..LANES {
            let share = self.shares[group][lane] / positions as f64;
            let Some(color) = self.colors.get(group * LANES + lane).filter(|_| share > 0.0) else { continue };
            let scale = self.per_white_squared[group][lane];
            let of_color = color.derivative(&error.map(|e| e[lane] * scale));
            for (row, of_color) in phi.iter_mut().zip(of_color) {
                for (value, d) in row.iter_mut().zip(of_color) {
                    value[lane] = share * scale * weight * d;
                }
            }
        }
        phi
    }
}

/// What the figure of the eye adds to the derivative of one condition and group, by position and pixel.
struct OfEye {
    /// Φ of the error that the eye sees, by position.
    phi: Vec<[[Lanes; 3]; 3]>,
    /// Λ.
    by_change: Vec<[Lanes; 3]>,
    /// The derivative with respect to the variance of each sample, beside that through G.
    by_variance: Vec<Lanes>,
}

/// Error covariances of one set of filters, and the best estimates.
struct Forward<'a> {
    screen: &'a Screen,
    layout: Layout,
    responses: FilterResponses,
    /// By condition.
    errors: Vec<ErrorCovariances>,
    /// The factored systems by condition, position and group; empty unless the eye's error is asked for.
    factors: Vec<Augmented>,
    /// W by condition, position, group and pixel.
    estimates: Vec<[Lanes; 3]>,
    /// Means by position, group and pixel.
    means: Vec<Lanes>,
}

impl<'a> Forward<'a> {
    fn new(screen: &'a Screen, layout: Layout, responses: FilterResponses, figures: Figures) -> Self {
        let each = layout.positions() * screen.groups;
        let factors = if figures == Figures::All { screen.levels.len() * each } else { 0 };
        Self {
            screen,
            layout,
            responses,
            errors: vec![ErrorCovariances::new(each, figures); screen.levels.len()],
            factors: vec![Augmented::new(screen.taps); factors],
            estimates: vec![[ZERO; 3]; screen.levels.len() * each * screen.taps],
            means: vec![ZERO; each * screen.taps],
        }
    }

    /// Index of the first pixel of a condition, position and group.
    #[inline(always)]
    fn at(&self, level: usize, position: usize, group: usize) -> usize {
        ((level * self.layout.positions() + position) * self.screen.groups + group) * self.screen.taps
    }

    /// The noise of a condition and group.
    #[inline(always)]
    fn noise(&self, level: usize, group: usize) -> SampleNoise {
        let (screen, taps) = (self.screen, self.screen.taps);
        let condition = &screen.levels[level];
        let scale = condition.scale(condition.time_s(&screen.white, &self.responses));
        let mut noise = SampleNoise::new(&self.layout);
        for position in 0..self.layout.positions() {
            let (first, means) = (self.at(level, position, group), self.at(0, position, group));
            for tap in 0..taps {
                noise.weights[position * taps + tap] = screen.eye.opponent(&self.estimates[first + tap]);
                noise.variances[position * taps + tap] = condition.noise(self.means[means + tap], scale);
            }
        }
        noise
    }
}

impl Kernel for &mut Forward<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (screen, layout) = (self.screen, &self.layout);
        let (positions, count, k) = (layout.positions(), pairs(screen.light_taps), screen.components);
        let mut products = vec![ZERO; positions * count];
        let mut system = System::new(screen);
        let mut right = vec![[ZERO; MAX_COMPONENTS]; layout.filters()];
        for group in 0..screen.groups {
            let mut pair = 0;
            for i in 0..screen.light_taps {
                for j in i..screen.light_taps {
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
                let products = &products[position * count..(position + 1) * count];
                system.gather(screen, &self.responses, layout.at(position), group, products);
                let first = self.at(0, position, group);
                self.means[first..first + screen.taps].copy_from_slice(&system.means);
                for (level, condition) in screen.levels.iter().enumerate() {
                    let time_s = condition.time_s(&screen.white, &self.responses);
                    system.factor(&screen.targets[group], condition, condition.scale(time_s));
                    let at = position * screen.groups + group;
                    self.errors[level].pixels[at] = system.matrix.complement();
                    let first = self.at(level, position, group);
                    system.matrix.solve(&mut self.estimates[first..first + screen.taps]);
                    if let Some(kept) = self.factors.get_mut(first / screen.taps) {
                        kept.clone_from(&system.matrix);
                    }
                }
            }
            if self.factors.is_empty() {
                continue;
            }
            for level in 0..screen.levels.len() {
                let noise = self.noise(level, group);
                let seen_noise = screen.eye.noise(&self.layout, &noise);
                for position in 0..positions {
                    let first = self.at(level, position, group);
                    let estimates = &self.estimates[first..first + screen.taps];
                    let variances = &noise.variances[position * screen.taps..][..screen.taps];
                    let at = position * screen.groups + group;
                    let mut seen = signal_error(&self.errors[level].pixels[at], estimates, variances);
                    add(&mut seen, &seen_noise);
                    self.errors[level].seen[at] = seen;
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

impl Backward<'_> {
    /// What the figure of the eye adds under a condition; `None` when it has no weight or was not computed.
    #[inline(always)]
    fn of_eye(&self, level: usize, group: usize) -> Option<OfEye> {
        let forward = self.forward;
        let (screen, layout, taps) = (forward.screen, &forward.layout, forward.screen.taps);
        let (weight, positions) = (self.weights[level].scielab, layout.positions());
        if weight == 0.0 || forward.factors.is_empty() {
            return None;
        }
        let noise = forward.noise(level, group);
        let mut of = OfEye {
            phi: Vec::with_capacity(positions),
            by_change: vec![[ZERO; 3]; positions * taps],
            by_variance: vec![ZERO; positions * taps],
        };
        let mut sum = [[ZERO; 3]; 3];
        for position in 0..positions {
            let error = &forward.errors[level].seen[position * screen.groups + group];
            let phi = screen.seen_derivatives(error, group, positions, weight);
            for (sum, value) in sum.as_flattened_mut().iter_mut().zip(phi.as_flattened()) {
                *sum = plus_scaled(*sum, 1.0, *value);
            }
            of.phi.push(phi);
        }
        screen.eye.derivative(layout, &noise, &sum, &mut of.by_change, &mut of.by_variance);
        for position in 0..positions {
            let first = forward.at(level, position, group);
            let own = position * taps..(position + 1) * taps;
            for (tap, w) in forward.estimates[first..first + taps].iter().enumerate() {
                let at = own.start + tap;
                // Of −Wᵀ Σ W.
                for c in 0..3 {
                    let mut sum = ZERO;
                    for d in 0..3 {
                        sum = plus(sum, of.phi[position][c][d], w[d]);
                    }
                    for lane in 0..LANES {
                        of.by_change[at][c][lane] -= 2.0 * noise.variances[at][lane] * sum[lane];
                        of.by_variance[at][lane] -= w[c][lane] * sum[lane];
                    }
                }
            }
            forward.factors[first / taps].solve_for(&mut of.by_change[own]);
        }
        Some(of)
    }
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
        // By sample and pixel: the derivatives with respect to its mean and its covariances with the target, over all conditions.
        let (mut by_sample, mut by_pixel) = (vec![[ZERO; 4]; taps], vec![[ZERO; 4]; screen.light_taps]);
        let mut pixel_pairs = vec![ZERO; positions * pairs(screen.light_taps)];
        let filters = layout.filters();
        let (mut straight, mut transposed) =
            (vec![[ZERO; MAX_COMPONENTS]; filters], vec![[ZERO; MAX_COMPONENTS]; filters]);
        for group in 0..screen.groups {
            outer.fill(ZERO);
            let of_eye: Vec<Option<OfEye>> =
                (0..screen.levels.len()).map(|level| self.of_eye(level, group)).collect();
            for position in 0..positions {
                by_sample.fill([ZERO; 4]);
                let first = forward.at(0, position, group);
                let means = &forward.means[first..first + taps];
                for (level, condition) in screen.levels.iter().enumerate() {
                    let error = &forward.errors[level].pixels[position * screen.groups + group];
                    let figures = (&self.expected[level], &self.weights[level]);
                    let mut phi = screen.derivatives(error, group, positions, figures);
                    let of_eye = of_eye[level].as_ref();
                    if let Some(eye) = of_eye {
                        let both = phi.as_flattened_mut().iter_mut().zip(eye.phi[position].as_flattened());
                        both.for_each(|(sum, value)| *sum = plus_scaled(*sum, 1.0, *value));
                    }
                    let change = of_eye.map(|eye| &eye.by_change[position * taps..(position + 1) * taps]);
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
                            if let Some(change) = change {
                                for c in 0..3 {
                                    let one = plus(ZERO, change[i][c], estimate[j][c]);
                                    let both = plus(one, change[j][c], estimate[i][c]);
                                    sum = plus_scaled(sum, -0.5, both);
                                }
                            }
                            for lane in 0..LANES {
                                outer[pair][lane] += sum[lane];
                            }
                            if i == j {
                                if let Some(eye) = of_eye {
                                    sum = plus_scaled(sum, 1.0, eye.by_variance[position * taps + i]);
                                }
                                // The variance of the noise: dark + μ per_e + μ² per_e².
                                for lane in 0..LANES {
                                    let mean = means[i][lane];
                                    let slope = per_e + 2.0 * condition.per_e2 * mean;
                                    by_sample[i][0][lane] += if mean > 0.0 { sum[lane] * slope } else { 0.0 };
                                    self.by_scale[level] -= sum[lane] * (mean * per_e + 2.0 * dark) / scale;
                                }
                            }
                            pair += 1;
                        }
                        for (c, sum) in by_sample[i][1..].iter_mut().enumerate() {
                            *sum = plus_scaled(*sum, -2.0, weighted[i][c]);
                            if let Some(change) = change {
                                *sum = plus_scaled(*sum, 1.0, change[i][c]);
                            }
                        }
                    }
                }
                let by_pixel = match &screen.crosstalk {
                    Some(crosstalk) => {
                        crosstalk.pixels(&by_sample, &mut by_pixel);
                        &by_pixel
                    }
                    None => &by_sample,
                };
                for (i, ([by_mean, by_crossed @ ..], filter)) in
                    by_pixel.iter().zip(layout.at(position)).enumerate()
                {
                    let at = (i * screen.groups + group) * k;
                    for (a, g) in self.by_response[usize::from(*filter)].iter_mut().enumerate() {
                        *g = plus(*g, *by_mean, screen.means[at + a]);
                        for (c, by) in by_crossed.iter().enumerate() {
                            *g = plus(*g, *by, screen.crossed[at + a][c]);
                        }
                    }
                }
            }
            let (outer, count) = match &screen.crosstalk {
                Some(crosstalk) => {
                    let count = pairs(screen.light_taps);
                    for position in 0..positions {
                        let from = &outer[position * pairs(taps)..(position + 1) * pairs(taps)];
                        let to = &mut pixel_pairs[position * count..(position + 1) * count];
                        crosstalk.pixel_pairs(from, to);
                    }
                    (&pixel_pairs, count)
                }
                None => (&outer, count),
            };
            let mut pair = 0;
            for i in 0..screen.light_taps {
                for j in i..screen.light_taps {
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
