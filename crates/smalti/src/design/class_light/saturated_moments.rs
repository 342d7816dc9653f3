//! The moments of the patches that a design saturates.

use crate::l3::{ClassPool, Moments};

/// The moments of the samples of saturated patches, by position and class.
#[derive(Debug, Default)]
pub(in crate::design) struct Saturated {
    pub(super) classes: Vec<Option<Moments>>,
    /// Classes of a position, and textures of a level.
    pub(super) counts: [usize; 2],
}

impl Saturated {
    /// The moments of a pool at a position (by index), if there are any.
    pub(super) fn of(&self, at: usize, pool: ClassPool) -> Option<Moments> {
        let [classes, textures] = self.counts;
        let mut sum: Option<Moments> = None;
        for (class, moments) in self.classes.iter().skip(at * classes).take(classes).enumerate() {
            let fits = pool.level.is_none_or(|level| level == class / textures)
                && pool.texture.is_none_or(|texture| texture == class % textures);
            if let Some(moments) = moments.as_ref().filter(|_| fits) {
                match &mut sum {
                    Some(sum) => sum.merge(moments),
                    None => sum = Some(moments.clone()),
                }
            }
        }
        sum
    }

    /// Number of patches of a class at a position (by index), over all pixels.
    pub(in crate::design) fn count(&self, at: usize, level: usize, texture: usize) -> f64 {
        let [classes, textures] = self.counts;
        let of = self.classes.get(at * classes + level * textures + texture);
        of.and_then(Option::as_ref).map_or(0.0, |m| m.get(0, 0))
    }
}
