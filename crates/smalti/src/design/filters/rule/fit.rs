//! Fits a sum of Gaussians to a curve by damped Gauss-Newton steps (Levenberg), each projected onto the constraints. The error
//! never grows and the number of steps is bounded. Plain loops and `libm` give the same bits on every machine.

/// Maximum number of steps of the fit.
const MAX_STEPS: usize = 300;

/// Relative squared error at which the fit ends: 1 % root mean square. Many sets of Gaussians sum to nearly the same curve,
/// down to a single filter, and the fit should stop at one close to its start.
const CLOSE: f64 = 1e-4;

/// Bisections for the largest height, more than the bits of an `f64`.
const BISECTIONS: usize = 64;

/// A Gaussian of the sum. The unit of wavelength is the spacing of the filters of the uniform rule.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Gaussian {
    pub center: f64,
    pub sigma: f64,
    pub height: f64,
}

/// Constraints on the Gaussians of the sum.
#[derive(Debug, Clone)]
pub(super) struct Bounds {
    pub center: [f64; 2],
    pub sigma: [f64; 2],
    /// Smallest distance between neighbouring centres.
    pub spacing: f64,
    /// Smallest height as a fraction of the largest.
    pub height: f64,
}

/// The parameters that a fit varies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FreeParameters {
    Heights,
    All,
}

/// A curve to fit.
#[derive(Debug)]
pub(super) struct Curve {
    pub at: Vec<f64>,
    pub values: Vec<f64>,
}

impl Gaussian {
    fn value(&self, at: f64) -> f64 {
        let x = (at - self.center) / self.sigma;
        libm::exp(-0.5 * x * x)
    }
}

impl Curve {
    fn sum(&self, gaussians: &[Gaussian]) -> Vec<f64> {
        self.at.iter().map(|&at| gaussians.iter().map(|b| b.height * b.value(at)).sum()).collect()
    }

    fn squared_error(&self, gaussians: &[Gaussian]) -> f64 {
        self.sum(gaussians).iter().zip(&self.values).map(|(s, v)| (s - v) * (s - v)).sum()
    }

    /// The Gaussians with their heights scaled so that the sum has the least squared error.
    pub(super) fn scaled(&self, gaussians: &[Gaussian]) -> Vec<Gaussian> {
        let sum = self.sum(gaussians);
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let square = dot(&sum, &sum);
        let factor = if square > 0.0 { dot(&sum, &self.values) / square } else { 0.0 };
        gaussians.iter().map(|b| Gaussian { height: b.height * factor, ..*b }).collect()
    }

    /// Squared error of the sum at its best scale, as a fraction of the squared curve.
    pub(super) fn relative_error(&self, gaussians: &[Gaussian]) -> f64 {
        self.squared_error(&self.scaled(gaussians)) / self.values.iter().map(|v| v * v).sum::<f64>()
    }

    /// Gaussians within the bounds whose sum has at most the squared error of `start` within the bounds.
    pub(super) fn fitted(&self, start: &[Gaussian], free: FreeParameters, bounds: &Bounds) -> Vec<Gaussian> {
        let mut gaussians = bounds.nearest(start.to_vec());
        let mut error = self.squared_error(&gaussians);
        let close = CLOSE * self.values.iter().map(|v| v * v).sum::<f64>();
        let mut damping = 1.0;
        for _ in 0..MAX_STEPS {
            if free == FreeParameters::All && error <= close {
                break;
            }
            let (curvature, slope) = self.normal_equations(&gaussians, free, bounds);
            let before = error;
            while damping < 1e12 {
                let step = solved(&curvature, &slope, damping);
                let trial = bounds.nearest(moved(&gaussians, &step, free));
                let trial_error = self.squared_error(&trial);
                if trial_error < error {
                    (gaussians, error) = (trial, trial_error);
                    damping = (damping * 0.1f64).max(1e-12);
                    break;
                }
                damping *= 10.0;
            }
            if before - error <= 1e-12 * before {
                break;
            }
        }
        gaussians
    }

    /// Jᵀ J and −Jᵀ r over the free parameters. A parameter at a bound is held when its slope points beyond the bound.
    fn normal_equations(
        &self,
        gaussians: &[Gaussian],
        free: FreeParameters,
        bounds: &Bounds,
    ) -> (Vec<Vec<f64>>, Vec<f64>) {
        let per_gaussian = if free == FreeParameters::All { 3 } else { 1 };
        let n = gaussians.len() * per_gaussian;
        let mut curvature = vec![vec![0.0; n]; n];
        let mut slope = vec![0.0; n];
        let mut row = vec![0.0; n];
        for ((&at, &value), sum) in self.at.iter().zip(&self.values).zip(self.sum(gaussians)) {
            for (gaussian, row) in gaussians.iter().zip(row.chunks_exact_mut(per_gaussian)) {
                let (shape, x) = (gaussian.value(at), (at - gaussian.center) / gaussian.sigma);
                let by_center = gaussian.height * shape * x / gaussian.sigma;
                for (entry, d) in row.iter_mut().zip([shape, by_center, by_center * x]) {
                    *entry = d;
                }
            }
            for i in 0..n {
                slope[i] -= row[i] * (sum - value);
                for j in 0..=i {
                    curvature[i][j] += row[i] * row[j];
                }
            }
        }
        let sigma = bounds.sigma;
        for (i, gaussian) in gaussians.iter().enumerate() {
            let mut hold = |parameter: usize, at_low: bool, at_high: bool| {
                let k = i * per_gaussian + parameter;
                if (at_low && slope[k] < 0.0) || (at_high && slope[k] > 0.0) {
                    (0..n).for_each(|j| curvature[k.max(j)][k.min(j)] = 0.0);
                    slope[k] = 0.0;
                }
            };
            hold(0, gaussian.height <= 0.0, false);
            if free == FreeParameters::All {
                hold(2, gaussian.sigma <= sigma[0], gaussian.sigma >= sigma[1]);
            }
        }
        (curvature, slope)
    }
}

fn moved(gaussians: &[Gaussian], step: &[f64], free: FreeParameters) -> Vec<Gaussian> {
    let moved = |(gaussian, step): (&Gaussian, &[f64])| match (free, step) {
        (FreeParameters::All, &[height, center, sigma]) => Gaussian {
            height: gaussian.height + height,
            center: gaussian.center + center,
            sigma: gaussian.sigma + sigma,
        },
        (_, step) => Gaussian { height: gaussian.height + step.first().unwrap_or(&0.0), ..*gaussian },
    };
    let per_gaussian = if free == FreeParameters::All { 3 } else { 1 };
    gaussians.iter().zip(step.chunks_exact(per_gaussian)).map(moved).collect()
}

/// The solution of (A + damping·mean diagonal·1) x = b by Cholesky's method, A given by its lower triangle.
fn solved(a: &[Vec<f64>], b: &[f64], damping: f64) -> Vec<f64> {
    let n = b.len();
    let ridge = damping * (0..n).map(|i| a[i][i]).sum::<f64>().max(f64::MIN_POSITIVE) / n.max(1) as f64;
    let mut l = a.to_vec();
    let mut x = b.to_vec();
    for i in 0..n {
        l[i][i] += ridge;
        for j in 0..=i {
            let sum: f64 = (0..j).map(|k| l[i][k] * l[j][k]).sum();
            // Rounding can make a pivot vanish; the ridge is its lower limit.
            l[i][j] = if i == j { (l[i][i] - sum).max(ridge).sqrt() } else { (l[i][j] - sum) / l[j][j] };
        }
        let sum: f64 = (0..i).map(|k| l[i][k] * x[k]).sum();
        x[i] = (x[i] - sum) / l[i][i];
    }
    for i in (0..n).rev() {
        let sum: f64 = (i + 1..n).map(|k| l[k][i] * x[k]).sum();
        x[i] = (x[i] - sum) / l[i][i];
    }
    x
}

impl Bounds {
    /// The Gaussians projected onto the bounds.
    fn nearest(&self, mut gaussians: Vec<Gaussian>) -> Vec<Gaussian> {
        // After subtracting the mandatory spacing, centres need only ascend: isotonic regression by pooling neighbours.
        let mut pools: Vec<(f64, usize)> = Vec::new();
        for (i, gaussian) in gaussians.iter().enumerate() {
            pools.push((gaussian.center - i as f64 * self.spacing, 1));
            while let &[.., (a, m), (b, n)] = pools.as_slice() {
                if a <= b {
                    break;
                }
                pools.truncate(pools.len() - 2);
                pools.push(((a * m as f64 + b * n as f64) / (m + n) as f64, m + n));
            }
        }
        let last = self.center[1] - gaussians.len().saturating_sub(1) as f64 * self.spacing;
        let centers = pools.into_iter().flat_map(|(center, n)| std::iter::repeat_n(center, n));
        for (i, (gaussian, center)) in gaussians.iter_mut().zip(centers).enumerate() {
            gaussian.center =
                center.max(self.center[0]).min(last.max(self.center[0])) + i as f64 * self.spacing;
            gaussian.sigma = gaussian.sigma.max(self.sigma[0]).min(self.sigma[1]);
        }
        let largest = self.largest_height(&gaussians);
        for gaussian in &mut gaussians {
            gaussian.height = gaussian.height.max(self.height * largest).min(largest);
        }
        gaussians
    }

    /// The largest height after projection: there, the sum cut from higher heights equals `self.height` times the sum added to
    /// lower heights.
    fn largest_height(&self, gaussians: &[Gaussian]) -> f64 {
        let (mut low, mut high) = (0.0, gaussians.iter().map(|b| b.height).fold(0.0, f64::max));
        if self.height <= 0.0 {
            return high;
        }
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            let excess = |b: &Gaussian| {
                (b.height - middle).max(0.0) - self.height * (self.height * middle - b.height).max(0.0)
            };
            if gaussians.iter().map(excess).sum::<f64>() > 0.0 { low = middle } else { high = middle }
        }
        high
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::philox::Stream;

    /// The solution fulfils the equations, of which only the lower triangle is stated.
    #[test]
    fn damped_equations_are_solved() {
        let mut random = Stream::new(2, 3, 4);
        for n in 1..=6 {
            for damping in [0.0, 1e-3, 10.0] {
                // J Jᵀ and a diagonal are positive definite.
                let j: Vec<Vec<f64>> =
                    (0..n).map(|_| (0..n).map(|_| random.uniform() - 0.5).collect()).collect();
                let product = |a: usize, b: usize| (0..n).map(|k| j[a][k] * j[b][k]).sum::<f64>();
                let full = |a: usize, b: usize| product(a, b) + if a == b { 0.2 } else { 0.0 };
                let lower: Vec<Vec<f64>> = (0..n)
                    .map(|a| (0..n).map(|b| if b <= a { full(a, b) } else { f64::NAN }).collect())
                    .collect();
                let b: Vec<f64> = (0..n).map(|_| random.uniform() - 0.5).collect();
                let x = solved(&lower, &b, damping);
                let ridge = damping * (0..n).map(|a| full(a, a)).sum::<f64>() / n as f64;
                for (row, value) in b.iter().enumerate() {
                    let found = (0..n).map(|col| full(row, col) * x[col]).sum::<f64>() + ridge * x[row];
                    assert!((found - value).abs() < 1e-12, "{n}, {damping}: {found} is not {value}");
                }
            }
        }
    }
}
