//! Fitting a sum of Gaussians to a curve: damped Gauss-Newton steps (Levenberg's), each brought back to what the
//! constraints allow. The error never grows, the number of steps is bounded, and plain loops with `libm` give the same
//! bits on every machine.

/// Steps of the fit.
const MAX_STEPS: usize = 300;

/// A sum this near to its curve, 1 % root mean square, is near enough. A Gaussian is the sum of many sets of Gaussians,
/// the last of them one filter and nothing else; the fit is to end at a near one.
const CLOSE: f64 = 1e-4;

/// Bisections of the largest height, more than a double has bits.
const BISECTIONS: usize = 64;

/// A Gaussian of the sum. Lengths are in units of the distance of the filters of the uniform rule.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bell {
    pub center: f64,
    pub sigma: f64,
    pub height: f64,
}

/// What the sum may be made of.
#[derive(Debug, Clone)]
pub(super) struct Bounds {
    pub center: [f64; 2],
    pub sigma: [f64; 2],
    /// Smallest distance of neighbours.
    pub spacing: f64,
    /// Smallest height as a share of the largest.
    pub height: f64,
}

/// What a fit may change.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Free {
    Heights,
    All,
}

/// A curve to fit.
#[derive(Debug)]
pub(super) struct Curve {
    pub at: Vec<f64>,
    pub values: Vec<f64>,
}

impl Bell {
    fn value(&self, at: f64) -> f64 {
        let x = (at - self.center) / self.sigma;
        libm::exp(-0.5 * x * x)
    }
}

impl Curve {
    fn sum(&self, bells: &[Bell]) -> Vec<f64> {
        self.at.iter().map(|&at| bells.iter().map(|b| b.height * b.value(at)).sum()).collect()
    }

    fn squared_error(&self, bells: &[Bell]) -> f64 {
        self.sum(bells).iter().zip(&self.values).map(|(s, v)| (s - v) * (s - v)).sum()
    }

    /// The bells with their heights times the factor that brings their sum nearest to the curve.
    pub(super) fn scaled(&self, bells: &[Bell]) -> Vec<Bell> {
        let sum = self.sum(bells);
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let square = dot(&sum, &sum);
        let factor = if square > 0.0 { dot(&sum, &self.values) / square } else { 0.0 };
        bells.iter().map(|b| Bell { height: b.height * factor, ..*b }).collect()
    }

    /// Squared error of the sum at its best scale, as a share of the squared curve.
    pub(super) fn relative_error(&self, bells: &[Bell]) -> f64 {
        self.squared_error(&self.scaled(bells)) / self.values.iter().map(|v| v * v).sum::<f64>()
    }

    /// Bells within the bounds whose sum is nearer to the curve than that of `start`, or as near.
    pub(super) fn fitted(&self, start: &[Bell], free: Free, bounds: &Bounds) -> Vec<Bell> {
        let mut bells = bounds.nearest(start.to_vec());
        let mut error = self.squared_error(&bells);
        let close = CLOSE * self.values.iter().map(|v| v * v).sum::<f64>();
        let mut damping = 1.0;
        for _ in 0..MAX_STEPS {
            if free == Free::All && error <= close {
                break;
            }
            let (curvature, slope) = self.normal_equations(&bells, free, bounds);
            let before = error;
            while damping < 1e12 {
                let step = solved(&curvature, &slope, damping);
                let trial = bounds.nearest(moved(&bells, &step, free));
                let trial_error = self.squared_error(&trial);
                if trial_error < error {
                    (bells, error) = (trial, trial_error);
                    damping = (damping * 0.1f64).max(1e-12);
                    break;
                }
                damping *= 10.0;
            }
            if before - error <= 1e-12 * before {
                break;
            }
        }
        bells
    }

    /// Jᵀ J and −Jᵀ r over the free parameters. Those at a bound that the slope would take beyond it stay.
    fn normal_equations(&self, bells: &[Bell], free: Free, bounds: &Bounds) -> (Vec<Vec<f64>>, Vec<f64>) {
        let per_bell = if free == Free::All { 3 } else { 1 };
        let n = bells.len() * per_bell;
        let mut curvature = vec![vec![0.0; n]; n];
        let mut slope = vec![0.0; n];
        let mut row = vec![0.0; n];
        for ((&at, &value), sum) in self.at.iter().zip(&self.values).zip(self.sum(bells)) {
            for (bell, row) in bells.iter().zip(row.chunks_exact_mut(per_bell)) {
                let (shape, x) = (bell.value(at), (at - bell.center) / bell.sigma);
                let by_center = bell.height * shape * x / bell.sigma;
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
        for (i, bell) in bells.iter().enumerate() {
            let mut hold = |parameter: usize, at_low: bool, at_high: bool| {
                let k = i * per_bell + parameter;
                if (at_low && slope[k] < 0.0) || (at_high && slope[k] > 0.0) {
                    (0..n).for_each(|j| curvature[k.max(j)][k.min(j)] = 0.0);
                    slope[k] = 0.0;
                }
            };
            hold(0, bell.height <= 0.0, false);
            if free == Free::All {
                hold(2, bell.sigma <= sigma[0], bell.sigma >= sigma[1]);
            }
        }
        (curvature, slope)
    }
}

fn moved(bells: &[Bell], step: &[f64], free: Free) -> Vec<Bell> {
    let moved = |(bell, step): (&Bell, &[f64])| match (free, step) {
        (Free::All, &[height, center, sigma]) => {
            Bell { height: bell.height + height, center: bell.center + center, sigma: bell.sigma + sigma }
        }
        (_, step) => Bell { height: bell.height + step.first().unwrap_or(&0.0), ..*bell },
    };
    let per_bell = if free == Free::All { 3 } else { 1 };
    bells.iter().zip(step.chunks_exact(per_bell)).map(moved).collect()
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
            // A pivot that rounding has taken is as small as the ridge.
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
    /// The bells within the bounds that are nearest to some bells.
    fn nearest(&self, mut bells: Vec<Bell>) -> Vec<Bell> {
        // Less what must lie before each centre, centres need only ascend: regression by pooling neighbours.
        let mut pools: Vec<(f64, usize)> = Vec::new();
        for (i, bell) in bells.iter().enumerate() {
            pools.push((bell.center - i as f64 * self.spacing, 1));
            while let &[.., (a, m), (b, n)] = pools.as_slice() {
                if a <= b {
                    break;
                }
                pools.truncate(pools.len() - 2);
                pools.push(((a * m as f64 + b * n as f64) / (m + n) as f64, m + n));
            }
        }
        let last = self.center[1] - bells.len().saturating_sub(1) as f64 * self.spacing;
        let centers = pools.into_iter().flat_map(|(center, n)| std::iter::repeat_n(center, n));
        for (i, (bell, center)) in bells.iter_mut().zip(centers).enumerate() {
            bell.center = center.max(self.center[0]).min(last.max(self.center[0])) + i as f64 * self.spacing;
            bell.sigma = bell.sigma.max(self.sigma[0]).min(self.sigma[1]);
        }
        let largest = self.largest_height(&bells);
        for bell in &mut bells {
            bell.height = bell.height.max(self.height * largest).min(largest);
        }
        bells
    }

    /// The largest height of the nearest allowed heights: where what is cut from the higher ones equals `self.height`
    /// times what is added to the lower ones.
    fn largest_height(&self, bells: &[Bell]) -> f64 {
        let (mut low, mut high) = (0.0, bells.iter().map(|b| b.height).fold(0.0, f64::max));
        if self.height <= 0.0 {
            return high;
        }
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            let excess = |b: &Bell| {
                (b.height - middle).max(0.0) - self.height * (self.height * middle - b.height).max(0.0)
            };
            if bells.iter().map(excess).sum::<f64>() > 0.0 { low = middle } else { high = middle }
        }
        high
    }
}
