//! Mixtures of measured reflectances for a colour.

use crate::color::lab_from_xyz;
use crate::color::matrix::{Matrix3, apply, inverse};

/// A measured reflectance and its colour.
#[derive(Debug, Clone)]
pub(super) struct Measured {
    pub(super) reflectance: Vec<f64>,
    /// XYZ under D65 relative to white.
    pub(super) xyz: [f64; 3],
    /// CIELAB under D65.
    pub(super) lab: [f64; 3],
    /// The largest factor that keeps the reflectance below 1.
    pub(super) headroom: f64,
}

/// The difference of colour, ΔE*ab, below which measured reflectances count as equally near.
const NEAR: f64 = 2.0;
/// How much a difference in lightness counts beside one in colour at equal luminance. A surface in the shade has the
/// colour of its reflectance, darkened, but dark surfaces also differ from bright ones in shape.
const LIGHTNESS: f64 = 0.4;
/// Tolerance of the colour of a mixture relative to its luminance.
const SLACK: f64 = 1e-4;
/// Darker colours are mixed as if they had this luminance relative to white.
const DARKEST: f64 = 1e-4;

/// The reflectance that measured ones give to a colour (XYZ relative to white): the nonnegative weights w that minimise
/// |Σ w a − c|² / ε + Σ w² / k, where a are the colours and k falls with the difference d between a colour, brought to
/// the luminance of c, and c: k = exp(−d² / 2h²), with h the distance of the second nearest. A mixture thus changes
/// continuously with the colour, consists of a few reflectances that are near, and has the colour if nonnegative weights
/// can give it.
pub(super) fn mixture(all: &[Measured], xyz: [f64; 3]) -> Vec<f64> {
    let luminance = xyz[1].max(DARKEST);
    let target = xyz.map(|v| v.max(0.0) / luminance);
    let lab = lab_from_xyz(xyz, [1.0; 3]);
    let factors: Vec<f64> = all.iter().map(|m| (luminance / m.xyz[1]).min(m.headroom)).collect();
    let distances: Vec<f64> = all
        .iter()
        .zip(&factors)
        .map(|(m, &factor)| {
            let other = lab_from_xyz(m.xyz.map(|v| v * factor), [1.0; 3]);
            let colour: f64 = lab.iter().zip(other).map(|(a, b)| (a - b) * (a - b)).sum();
            let lightness = LIGHTNESS * (lab[0] - m.lab[0]);
            colour + lightness * lightness
        })
        .collect();
    let mut nearest = [f64::INFINITY; 2];
    for &d in &distances {
        if d < nearest[1] {
            nearest = [nearest[0].min(d), nearest[0].max(d)];
        }
    }
    let width = nearest[1].max(NEAR * NEAR);
    let candidates: Vec<Candidate> = all
        .iter()
        .zip(factors.iter().zip(&distances))
        .map(|(m, (&factor, &d))| Candidate {
            colour: m.xyz.map(|v| v * factor / luminance),
            nearness: libm::exp(-0.5 * d / width),
        })
        .collect();
    let dual = dual(&candidates, target);
    let mut reflectance = vec![0.0; all.first().map_or(0, |m| m.reflectance.len())];
    for (m, (candidate, &factor)) in all.iter().zip(candidates.iter().zip(&factors)) {
        let weight = candidate.weight(dual) * factor;
        if weight > 0.0 {
            reflectance.iter_mut().zip(&m.reflectance).for_each(|(sum, r)| *sum += weight * r);
        }
    }
    reflectance
}

struct Candidate {
    /// At a luminance of 1 or, without headroom, below.
    colour: [f64; 3],
    nearness: f64,
}

impl Candidate {
    fn weight(&self, dual: [f64; 3]) -> f64 {
        self.nearness * dot(self.colour, dual).max(0.0)
    }
}

/// The y that minimises ½ Σ k max(0, a · y)² + ½ ε |y|² − c · y. The weights are k max(0, a · y). Newton's method with
/// halved steps: the function is convex, and quadratic between changes of sign.
fn dual(candidates: &[Candidate], target: [f64; 3]) -> [f64; 3] {
    let value = |y: [f64; 3]| {
        let sum: f64 = candidates.iter().map(|c| c.nearness * dot(c.colour, y).max(0.0).powi(2)).sum();
        0.5 * (sum + SLACK * dot(y, y)) - dot(target, y)
    };
    let mut y = [0.0, 1.0, 0.0];
    let mut at = value(y);
    for _ in 0..40 {
        let mut gradient = [0, 1, 2].map(|i| SLACK * y[i] - target[i]);
        let mut hessian: Matrix3 = [[SLACK, 0.0, 0.0], [0.0, SLACK, 0.0], [0.0, 0.0, SLACK]];
        for c in candidates {
            let along = dot(c.colour, y);
            if along > 0.0 {
                for ((slope, row), v) in gradient.iter_mut().zip(&mut hessian).zip(c.colour) {
                    let k = c.nearness * v;
                    *slope += k * along;
                    row.iter_mut().zip(c.colour).for_each(|(h, u)| *h += k * u);
                }
            }
        }
        let Some(step) = inverse(&hessian).map(|h| apply(&h, gradient)) else { break };
        let mut scale = 1.0;
        let next = loop {
            let next = [0, 1, 2].map(|i| y[i] - scale * step[i]);
            let found = value(next);
            if found <= at || scale < 1e-6 {
                break (next, found);
            }
            scale *= 0.5;
        };
        let gain = at - next.1;
        (y, at) = next;
        if gain.abs() < 1e-12 {
            break;
        }
    }
    y
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn number(i: usize) -> f64 {
        0.5 + 0.5 * libm::sin(2.3 * i as f64 + 0.7)
    }

    fn candidates() -> Vec<Candidate> {
        let of = |i: usize| Candidate {
            colour: [0.3 + number(4 * i), 1.0, 0.2 + 1.5 * number(4 * i + 1)],
            nearness: 0.02 + number(4 * i + 2).powi(4),
        };
        (0..30).map(of).collect()
    }

    /// The gradient vanishes where the function is least. The targets lie among the colours, at their border, and beyond.
    #[test]
    fn the_weights_are_those_of_the_least_sum() {
        let candidates = candidates();
        for target in [[0.8, 1.0, 0.9], [0.35, 1.0, 0.9], [1.2, 1.0, 0.3], [0.1, 1.0, 1.9], [2.0, 1.0, 0.0]] {
            let y = dual(&candidates, target);
            let mut found = y.map(|v| SLACK * v);
            for c in &candidates {
                let weight = c.weight(y);
                assert!(weight >= 0.0);
                found.iter_mut().zip(c.colour).for_each(|(sum, v)| *sum += weight * v);
            }
            for (found, wanted) in found.iter().zip(target) {
                // Rounding, of weights with which y is multiplied.
                let size = y.iter().fold(1.0, |m: f64, v| m.max(v.abs()));
                assert!((found - wanted).abs() < 1e-11 * size, "{target:?}: {found} {wanted}, {y:?}");
            }
        }
    }

    /// Surfaces of three wavelengths that are seen as X, Y and Z.
    fn measured(xyz: [f64; 3]) -> Measured {
        let largest = xyz.iter().copied().fold(0.0, f64::max);
        Measured {
            reflectance: xyz.to_vec(),
            xyz,
            lab: lab_from_xyz(xyz, [1.0; 3]),
            headroom: 0.98 / largest,
        }
    }

    /// A mixture has its colour, to the tolerance, in light and in shade, and is of what is near.
    #[test]
    fn a_mixture_has_the_colour_that_it_is_made_for() {
        let all: Vec<Measured> = (0..40)
            .map(|i| [3 * i, 3 * i + 1, 3 * i + 2].map(|at| 0.1 + 0.6 * number(at)))
            .map(measured)
            .collect();
        for colour in [[0.4, 0.4, 0.4], [0.5, 0.4, 0.3], [0.3, 0.35, 0.45], [0.02, 0.02, 0.02]] {
            let found = mixture(&all, colour);
            for (found, wanted) in found.iter().zip(colour) {
                assert!((found / colour[1] - wanted / colour[1]).abs() < 0.01, "{colour:?}: {found}");
            }
        }
        // A surface far from all others is itself.
        let lone = measured([0.6, 0.3, 0.1]);
        let greys = [0.2, 0.4, 0.6].map(|v| measured([v; 3]));
        let found = mixture(&[&greys[..], std::slice::from_ref(&lone)].concat(), lone.xyz);
        for (found, wanted) in found.iter().zip(lone.xyz) {
            assert!((found / wanted - 1.0).abs() < 0.01, "{found} {wanted}");
        }
        assert_eq!(mixture(&greys, [0.0; 3]).len(), 3);
    }
}
