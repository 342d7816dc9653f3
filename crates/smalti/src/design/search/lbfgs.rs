//! Minimisation of a smooth function by the limited-memory BFGS method ([nocedal1980]; [nocedal2006], algorithms 7.4 and 3.1).
//!
//! [nocedal1980]: https://doi.org/10.1090/S0025-5718-1980-0572855-7
//! [nocedal2006]: https://doi.org/10.1007/978-0-387-40065-5

use std::collections::VecDeque;

use crate::numeric::dense::dot;

/// Steps that the curvature is estimated from.
const MEMORY: usize = 8;
/// The decrease of an accepted step, relative to that of the tangent.
const DECREASE: f64 = 1e-4;
/// Halvings of a step before the search ends.
const MAX_HALVINGS: usize = 30;
/// The search ends when ten steps lower the value by less than this share of it.
const TOLERANCE: f64 = 1e-7;
const PATIENCE: usize = 10;

/// A point with its value and gradient.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Point {
    pub(super) at: Vec<f64>,
    pub(super) value: f64,
    gradient: Vec<f64>,
}

/// Minimises a function from a starting point; `function` gives value and gradient. Ends after `steps`, when the value no longer falls, or
/// when `is_stopped`.
pub(super) fn minimise(
    start: Vec<f64>,
    steps: usize,
    mut function: impl FnMut(&[f64]) -> (f64, Vec<f64>),
    is_stopped: impl Fn() -> bool,
) -> Point {
    let (value, gradient) = function(&start);
    let mut best = Point { at: start, value, gradient };
    // Steps, changes of the gradient, and the reciprocal of their product.
    let mut memory: VecDeque<(Vec<f64>, Vec<f64>, f64)> = VecDeque::new();
    let mut before = VecDeque::from([best.value]);
    for _ in 0..steps {
        if is_stopped() || !best.value.is_finite() {
            break;
        }
        let mut direction = direction(&best.gradient, &memory);
        let mut slope = dot(&direction, &best.gradient);
        if slope >= 0.0 {
            memory.clear();
            direction = best.gradient.iter().map(|g| -g).collect();
            slope = dot(&direction, &best.gradient);
        }
        // Without knowledge of the curvature, a step of one unit at most.
        let length = dot(&direction, &direction).sqrt();
        let mut step = if memory.is_empty() { 1.0 / length.max(1.0) } else { 1.0 };
        let mut next = None;
        for _ in 0..MAX_HALVINGS {
            let at: Vec<f64> = best.at.iter().zip(&direction).map(|(x, d)| x + step * d).collect();
            let (value, gradient) = function(&at);
            if value <= best.value + DECREASE * step * slope {
                next = Some(Point { at, value, gradient });
                break;
            }
            step *= 0.5;
        }
        let Some(next) = next else { break };
        let moved: Vec<f64> = next.at.iter().zip(&best.at).map(|(a, b)| a - b).collect();
        let turned: Vec<f64> = next.gradient.iter().zip(&best.gradient).map(|(a, b)| a - b).collect();
        let curvature = dot(&moved, &turned);
        if curvature > 1e-12 * dot(&turned, &turned) {
            if memory.len() == MEMORY {
                memory.pop_front();
            }
            memory.push_back((moved, turned, 1.0 / curvature));
        }
        best = next;
        before.push_back(best.value);
        if before.len() > PATIENCE {
            let earlier = before.pop_front().unwrap_or(f64::INFINITY);
            if earlier - best.value < TOLERANCE * best.value.abs() {
                break;
            }
        }
    }
    best
}

/// The two loops of algorithm 7.4: the inverse Hessian's estimate times the negative gradient.
fn direction(gradient: &[f64], memory: &VecDeque<(Vec<f64>, Vec<f64>, f64)>) -> Vec<f64> {
    let mut q: Vec<f64> = gradient.iter().map(|g| -g).collect();
    let mut alphas = Vec::with_capacity(memory.len());
    for (moved, turned, inverse) in memory.iter().rev() {
        let alpha = inverse * dot(moved, &q);
        q.iter_mut().zip(turned).for_each(|(q, y)| *q -= alpha * y);
        alphas.push(alpha);
    }
    if let Some((moved, turned, _)) = memory.back() {
        let scale = dot(moved, turned) / dot(turned, turned);
        q.iter_mut().for_each(|q| *q *= scale);
    }
    for ((moved, turned, inverse), alpha) in memory.iter().zip(alphas.into_iter().rev()) {
        let beta = inverse * dot(turned, &q);
        q.iter_mut().zip(moved).for_each(|(q, s)| *q += (alpha - beta) * s);
    }
    q
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::philox::Stream;

    /// Rosenbrock's valley, whose minimum 0 is at (1, 1).
    #[test]
    fn the_minimum_of_a_curved_valley_is_found() {
        let valley = |x: &[f64]| {
            let (a, b) = (1.0 - x[0], x[1] - x[0] * x[0]);
            (a * a + 100.0 * b * b + 1.0, vec![-2.0 * a - 400.0 * x[0] * b, 200.0 * b])
        };
        let found = minimise(vec![-1.2, 1.0], 200, valley, || false);
        assert!(found.at.iter().all(|x| (x - 1.0).abs() < 1e-4), "{found:?}");
        // A stop keeps the best point so far.
        assert_eq!(minimise(vec![-1.2, 1.0], 200, valley, || true).at, [-1.2, 1.0]);
    }

    /// docs/reliability.md promises it: functions without a minimum, with a false gradient and with NaN end as well.
    #[test]
    fn a_start_takes_at_most_its_steps_and_their_halvings() {
        let functions: [fn(f64) -> [f64; 2]; 5] = [
            |x| [-x, -1.0],
            |x| [x.abs(), -x.signum()],
            |x| [(50.0 * x).sin(), 50.0 * (50.0 * x).cos()],
            |x| [x.exp(), x.exp()],
            |x| [if x > 0.5 { f64::NAN } else { -x }, -1.0],
        ];
        for (i, function) in functions.into_iter().enumerate() {
            for steps in [0, 1, 7, 300] {
                let mut calls = 0;
                let counted = |x: &[f64]| {
                    calls += 1;
                    let [value, slope] = function(x[0]);
                    (value, vec![slope])
                };
                let found = minimise(vec![0.3], steps, counted, || false);
                assert!(
                    (1..=1 + steps * MAX_HALVINGS).contains(&calls),
                    "function {i}, {steps} steps: {calls} calls"
                );
                assert!(
                    found.value.is_finite() && found.value <= function(0.3)[0],
                    "function {i}: {found:?}"
                );
            }
        }
    }

    /// The two loops are the dense update of the inverse Hessian, and the latest change of the gradient gives the latest step.
    #[test]
    fn the_direction_is_that_of_the_dense_update() {
        const N: usize = 5;
        let mut random = Stream::new(7, 8, 9);
        let mut vector = || -> Vec<f64> { (0..N).map(|_| random.uniform() - 0.5).collect() };
        // Gradients of a quadratic function with the curvatures 1 to 5.
        let turned =
            |moved: &[f64]| -> Vec<f64> { moved.iter().zip(1u32..).map(|(s, c)| f64::from(c) * s).collect() };
        let mut memory = VecDeque::new();
        for _ in 0..4 {
            let s = vector();
            let y = turned(&s);
            let inverse = 1.0 / dot(&s, &y);
            memory.push_back((s, y, inverse));
        }
        let (last, last_turned, _) = memory.back().unwrap();
        let scale = dot(last, last_turned) / dot(last_turned, last_turned);
        let mut dense = [[0.0; N]; N];
        (0..N).for_each(|i| dense[i][i] = scale);
        for (s, y, inverse) in &memory {
            // (1 − ρ s yᵀ) H (1 − ρ y sᵀ) + ρ s sᵀ.
            let left = |i: usize, j: usize| f64::from(u8::from(i == j)) - inverse * s[i] * y[j];
            let entry = |i: usize, j: usize| {
                let all = (0..N * N).map(|at| left(i, at / N) * dense[at / N][at % N] * left(j, at % N));
                all.sum::<f64>() + inverse * s[i] * s[j]
            };
            dense = std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)));
        }
        let gradient = vector();
        for (found, row) in direction(&gradient, &memory).iter().zip(&dense) {
            let expected = -dot(row, &gradient);
            assert!((found - expected).abs() < 1e-10, "{found} is not {expected}");
        }
        for (found, step) in direction(last_turned, &memory).iter().zip(last) {
            assert!((found + step).abs() < 1e-12, "{found} is not {}", -step);
        }
    }
}
