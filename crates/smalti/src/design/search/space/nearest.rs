//! The filter of a family that is the nearest to a given curve.

use super::SampledSpace;
use crate::design::search::lbfgs;
use crate::numeric::philox::Stream;
use crate::spectrum::Spectrum;

/// Purpose of the random numbers of starts.
const PURPOSE: u32 = 0x004e_4541;
const STARTS: u32 = 8;
const STEPS: usize = 100;
/// Largest absolute parameter. At the ends of their range, parameters have no derivative that a search could follow.
const LIMIT: f64 = 5.0;

impl SampledSpace {
    /// The parameters of the filter whose transmittance has the least squared difference from a curve at the wavelengths of the space, as a start for a search.
    pub(crate) fn nearest(&self, wanted: &[f64]) -> Vec<f64> {
        let difference = |parameters: &[f64]| {
            let apart: Vec<f64> =
                self.transmittance(parameters).iter().zip(wanted).map(|(t, w)| t - w).collect();
            let square = apart.iter().map(|d| d * d).sum::<f64>();
            let by_transmittance: Vec<f64> = apart.iter().map(|d| 2.0 * d).collect();
            (square, self.by_parameters(parameters, &by_transmittance))
        };
        let ends: Vec<(f64, Vec<f64>)> = match self.choices() {
            Some(choices) => (0..choices)
                .map(|choice| vec![choice as f64])
                .map(|parameters| (difference(&parameters).0, parameters))
                .collect(),
            None => (0..STARTS)
                .map(|start| {
                    let start = self.random(&mut Stream::new(0, PURPOSE, start));
                    let mut at = lbfgs::minimise(start, STEPS, difference, || false).at;
                    at.iter_mut().for_each(|p| *p = p.clamp(-LIMIT, LIMIT));
                    (difference(&at).0, at)
                })
                .collect(),
        };
        ends.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, at)| at).unwrap_or_default()
    }

    /// How far a filter is from the family: the largest difference at a wavelength between its transmittance and that of the nearest filter of
    /// the family, 0 to 1. For filters of the family it is below 0.02, the accuracy of the search for the nearest one.
    #[must_use]
    pub fn distance(&self, transmittance: &Spectrum) -> f64 {
        let nearest = self.transmittance(&self.nearest(transmittance.values()));
        nearest.iter().zip(transmittance.values()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{builtin, continuous};
    use super::super::{FilterSpace, Measured};
    use super::*;
    use crate::spectrum::WavelengthGrid;

    /// The nearest filter to one of the family is that filter.
    #[test]
    fn filters_of_the_family_are_their_own_nearest() {
        for space in continuous() {
            let space = space.sampled(WavelengthGrid::VISIBLE).unwrap();
            let mut random = Stream::new(3, 1, 4);
            for _ in 0..4 {
                let wanted = space.transmittance(&space.random(&mut random));
                let found = space.transmittance(&space.nearest(&wanted));
                let worst = found.iter().zip(&wanted).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(worst < 0.02, "{space:?}: {worst}");
                let wanted = Spectrum::new(space.grid(), wanted).unwrap();
                assert_eq!(space.distance(&wanted), worst);
            }
            // A comb is none of any family.
            let comb = (0..space.grid().len()).map(|i| (i % 2) as f64).collect();
            let distance = space.distance(&Spectrum::new(space.grid(), comb).unwrap());
            assert!(distance > 0.3, "{space:?}: {distance}");
        }
        let measured = Measured { library: builtin(&["pigment/R", "pigment/G", "pigment/B"]) };
        let space = FilterSpace::Measured(measured).sampled(WavelengthGrid::VISIBLE).unwrap();
        assert_eq!(space.nearest(&space.transmittance(&[1.0])), [1.0]);
    }
}
