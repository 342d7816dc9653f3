//! The filter of a family that is the nearest to a given curve.

use super::SampledSpace;
use crate::design::search::lbfgs;
use crate::numeric::philox::Stream;
use crate::spectrum::Spectrum;

/// Purpose of the random numbers of starts.
const PURPOSE: u32 = 0x004e_4541;
const STARTS: u32 = 8;
const STEPS: usize = 100;
/// Steps by the divergence, which comes first: steep curves need more than a hundred.
const DIVERGENCE_STEPS: usize = 200;
/// Largest absolute parameter of a start. At the ends of their range, parameters have no derivative that a search could follow.
const LIMIT: f64 = 5.0;

impl SampledSpace {
    /// Parameters from which a search can start, of a filter like a curve at the wavelengths of the space: of those within the range where parameters have
    /// a derivative, some whose transmittance has a small squared difference. Steep curves lie outside this range.
    pub(crate) fn start_near(&self, wanted: &[f64]) -> Vec<f64> {
        self.least(wanted, STARTS, |start| {
            let mut at = lbfgs::minimise(start, STEPS, |p| self.difference(p, wanted), || false).at;
            at.iter_mut().for_each(|p| *p = p.clamp(-LIMIT, LIMIT));
            at
        })
    }

    /// The parameters of the filter whose transmittance has the least squared difference from a curve at the wavelengths of the space.
    ///
    /// The squared difference is flat where the transmittance is almost 0 or that of the clear filter, so that its search would end far from a
    /// steep curve. The divergence has no such places: its derivative there is the difference itself. Its minimum is the start.
    fn nearest(&self, wanted: &[f64]) -> Vec<f64> {
        let starts = if self.curves.is_divergence_convex() { 1 } else { STARTS };
        self.least(wanted, starts, |start| {
            let near = lbfgs::minimise(start, DIVERGENCE_STEPS, |p| self.divergence(p, wanted), || false).at;
            lbfgs::minimise(near, STEPS, |p| self.difference(p, wanted), || false).at
        })
    }

    /// The parameters with the least squared difference among the ends of searches from random starts; among all filters, if they are a choice.
    fn least(&self, wanted: &[f64], starts: u32, end: impl Fn(Vec<f64>) -> Vec<f64>) -> Vec<f64> {
        let ends: Vec<Vec<f64>> = match self.choices() {
            Some(choices) => (0..choices).map(|choice| vec![choice as f64]).collect(),
            None => (0..starts).map(|s| end(self.random(&mut Stream::new(0, PURPOSE, s)))).collect(),
        };
        let valued = ends.into_iter().map(|at| (self.difference(&at, wanted).0, at));
        valued.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, at)| at).unwrap_or_default()
    }

    /// The squared difference between the transmittance of a filter and a curve, and its derivative with respect to the parameters.
    fn difference(&self, parameters: &[f64], wanted: &[f64]) -> (f64, Vec<f64>) {
        let apart: Vec<f64> = self.transmittance(parameters).iter().zip(wanted).map(|(t, w)| t - w).collect();
        let square = apart.iter().map(|d| d * d).sum::<f64>();
        let by_transmittance: Vec<f64> = apart.iter().map(|d| 2.0 * d).collect();
        (square, self.by_parameters(parameters, &by_transmittance))
    }

    /// The Kullback–Leibler divergence of the shares of light that a filter passes and absorbs, relative to the clear filter, from those of a curve: its sum over
    /// the wavelengths, and its derivative with respect to the parameters.
    fn divergence(&self, parameters: &[f64], wanted: &[f64]) -> (f64, Vec<f64>) {
        let log = |share: f64| libm::log(share.max(f64::MIN_POSITIVE));
        let (mut sum, mut by_transmittance) = (0.0, Vec::with_capacity(wanted.len()));
        for (t, w) in self.transmittance(parameters).iter().zip(wanted) {
            let (t, w) = (t / self.clear, (w / self.clear).clamp(0.0, 1.0));
            sum += w * (log(w) - log(t)) + (1.0 - w) * (log(1.0 - w) - log(1.0 - t));
            by_transmittance.push((t - w) / (t * (1.0 - t)).max(f64::MIN_POSITIVE) / self.clear);
        }
        (sum, self.by_parameters(parameters, &by_transmittance))
    }

    /// How far a filter is from the family: the largest difference at a wavelength between its transmittance and that of the nearest filter of
    /// the family, 0 to 1. Transmittances above that of the clear filter count as that, which they are compared with apart. For filters of the family it is below 0.01, the
    /// accuracy of the search for the nearest one.
    #[must_use]
    pub fn distance(&self, transmittance: &Spectrum) -> f64 {
        let wanted: Vec<f64> = transmittance.values().iter().map(|t| t.min(self.clear)).collect();
        let nearest = self.transmittance(&self.nearest(&wanted));
        nearest.iter().zip(&wanted).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{builtin, continuous};
    use super::super::{FilterSpace, FreeCurves, Measured, Pigments};
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
                assert!(worst < 0.01, "{space:?}: {worst}");
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

    /// Optimised curves are steep: their parameters lie far beyond those of starts, and between their knots the transmittance depends on how far.
    #[test]
    fn steep_curves_are_their_own_nearest() {
        for knots in [9, 16] {
            let free = FilterSpace::Free(FreeCurves { knots, ..FreeCurves::default() });
            let space = free.sampled(WavelengthGrid::VISIBLE).unwrap();
            for number in 0..24 {
                let mut random = Stream::new(8, 1, number);
                let reach = if number % 2 == 0 { 20.0 } else { 80.0 };
                let steep: Vec<f64> = (0..knots).map(|_| reach * (random.uniform() - 0.5)).collect();
                let steep = space.spectrum(&steep).unwrap();
                let distance = space.distance(&steep);
                assert!(distance < 0.01, "{knots} knots, {number}: {distance}");
                // The range of starts has nothing like it.
                let start = space.transmittance(&space.start_near(steep.values()));
                let from_start = start.iter().zip(steep.values()).map(|(a, b)| (a - b).abs());
                assert!(from_start.fold(0.0, f64::max) > 0.05, "{knots} knots, {number}");
            }
        }
        // Filters without a pigment, and with as much of it as there can be.
        let space = FilterSpace::Pigments(Pigments::default()).sampled(WavelengthGrid::VISIBLE).unwrap();
        for ends in
            [[-60.0, 60.0, -60.0, -60.0, -60.0, -60.0], [0.5, -60.0, -60.0, -60.0, -60.0, 1.5], [-60.0; 6]]
        {
            let distance = space.distance(&space.spectrum(&ends).unwrap());
            assert!(distance < 0.01, "{ends:?}: {distance}");
        }
    }

    /// The shape counts, also where a curve passes more light than any filter of the family.
    #[test]
    fn a_higher_peak_is_no_other_shape() {
        let space = FilterSpace::Free(FreeCurves { knots: 16, ..FreeCurves::default() });
        let space = space.sampled(WavelengthGrid::VISIBLE).unwrap();
        let grid = space.grid();
        let gaussian = |nm: f64| libm::exp(-0.5 * ((nm - 550.0) / 40.0).powi(2));
        let high = Spectrum::new(grid, grid.wavelengths_nm().map(gaussian).collect()).unwrap();
        assert!(high.max() > 0.99 && space.distance(&high) < 0.03, "{}", space.distance(&high));
        let clear = Spectrum::constant(grid, 1.0).unwrap();
        assert!(space.distance(&clear) < 0.01, "{}", space.distance(&clear));
    }
}
