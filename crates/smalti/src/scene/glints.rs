//! Glints: reflections of the light source that are smaller than a sample.

use super::SceneError;
use crate::numeric::philox::Stream;
use crate::numeric::require;

/// Separates the random numbers of glints from other uses of a seed.
const PURPOSE: u32 = 0x676c_696e;
/// No glint is brighter than so many times white.
const BRIGHTEST: f64 = 30.0;

/// Reflections of the light source on facets that are smaller than a sample, such as those of water, varnish, metal and leaves in the
/// sun. They have the colour of the light, and their radiance follows a Pareto distribution, as that of random facets does: few are much
/// brighter than most.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Glints {
    /// The share of the samples that have one, 0 to 1.
    pub share: f64,
    /// The least radiance of one, relative to that of a white diffuser in the scene, 10⁻³ to 30. None exceeds 30.
    pub least: f64,
    /// The exponent of the distribution: a glint exceeds k times the least radiance with the probability k⁻ᵉ. Above 0, at most 100.
    pub exponent: f64,
    /// Seed of the random numbers.
    pub seed: u64,
}

impl Glints {
    /// The indices of the samples that have one, of `count`, and the radiance relative to white.
    ///
    /// # Errors
    /// When a parameter is out of range.
    pub(super) fn draw(&self, count: usize) -> Result<Vec<(usize, f64)>, SceneError> {
        let Self { share, least, exponent, seed } = *self;
        require((0.0..=1.0).contains(&share), "share", share, "0 to 1")?;
        require((1e-3..=BRIGHTEST).contains(&least), "least", least, "0.001 to 30")?;
        require(exponent > 0.0 && exponent <= 100.0, "exponent", exponent, "above 0, at most 100")?;
        let mut random = Stream::new(seed, PURPOSE, 0);
        let mut drawn = Vec::new();
        for sample in 0..count {
            if random.uniform() < share {
                let brightness = least * (1.0 - random.uniform()).powf(-exponent.recip());
                drawn.push((sample, brightness.min(BRIGHTEST)));
            }
        }
        Ok(drawn)
    }
}
