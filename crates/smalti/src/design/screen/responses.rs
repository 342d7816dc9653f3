//! The responses of filters to the spectral components of the light.

use std::borrow::Cow;

/// The filters of an array on a camera: photoelectrons per second for each spectral component, per cd/m² of the scene.
#[derive(Debug, Clone, PartialEq)]
pub struct FilterResponses(pub(super) Vec<Vec<f64>>);

impl FilterResponses {
    /// With as many filters and components: missing filters see no light, and further ones are in no cell.
    pub(super) fn fitted(&self, filters: usize, components: usize) -> Cow<'_, Self> {
        if self.0.len() == filters && self.0.iter().all(|f| f.len() == components) {
            return Cow::Borrowed(self);
        }
        let mut all = self.0.clone();
        all.resize(filters, Vec::new());
        all.iter_mut().for_each(|f| f.resize(components, 0.0));
        Cow::Owned(Self(all))
    }

    /// From the photoelectrons per second of each filter for each spectral component, per cd/m².
    #[must_use]
    pub fn new(responses: Vec<Vec<f64>>) -> Self {
        Self(responses)
    }
}

pub(super) fn sum_of_products(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
