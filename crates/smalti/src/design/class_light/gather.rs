//! Sums of products of the light on patches of pixels.

use std::collections::BTreeMap;

use rayon::prelude::*;

use crate::design::patch_products::{AddPatches, PatchSource};
use crate::design::pixel_light::PixelLight;
use crate::l3::{ClassMap, Moments};
use crate::numeric::Planes;
use crate::numeric::products::LANES;
use crate::numeric::simd::dispatch;

/// Patches per partial sum. The parts are added in order, so that the bits do not depend on the number of threads.
const PART_PATCHES: usize = 4096;
/// Patches whose z are gathered together.
const BATCH: usize = 32;

/// Sums z zᵀ over the patches of classes, z = (1, coefficients of every pixel, X, Y, Z of the middle pixel).
pub(super) struct Gatherer<'a> {
    side: usize,
    components: usize,
    cols: usize,
    /// Coefficients, pixel after pixel.
    values: Vec<f32>,
    targets: Vec<&'a [f32]>,
    /// The middle pixels of the patches of each class.
    members: BTreeMap<usize, Vec<u32>>,
}

impl<'a> Gatherer<'a> {
    pub(super) fn new(light: &PixelLight, target: &'a Planes, side: usize, map: &ClassMap) -> Self {
        let planes = light.planes();
        let cols = planes.cols();
        let mut members: BTreeMap<usize, Vec<u32>> = BTreeMap::new();
        for (i, class) in map.local.iter().enumerate() {
            let pixel = (map.first + i / map.cols) * cols + map.first + i % map.cols;
            members.entry(usize::from(*class)).or_default().push(pixel as u32);
        }
        let values = (0..planes.plane_len()).flat_map(|i| planes.planes().map(move |p| p[i])).collect();
        let targets = target.planes().collect();
        Self { side, components: light.spectra().len(), cols, values, targets, members }
    }

    pub(super) fn members(&self) -> impl Iterator<Item = (usize, &[u32])> {
        self.members.iter().map(|(class, pixels)| (*class, pixels.as_slice()))
    }

    /// The moments of the patches of a class.
    pub(super) fn moments(&self, class: usize) -> Moments {
        let coefficients = self.side * self.side * self.components;
        let stride = (1 + coefficients + self.targets.len()).next_multiple_of(LANES);
        let source = PatchSource {
            values: &self.values,
            count: self.components,
            cols: self.cols,
            side: self.side,
            targets: &self.targets,
        };
        let pixels = self.members.get(&class).map_or(&[][..], Vec::as_slice);
        let of_part = |part: &[u32]| {
            let mut sums = vec![0.0; stride * stride];
            let mut batch = vec![0.0; BATCH * stride];
            for pixels in part.chunks(BATCH) {
                let batch = &mut batch[..pixels.len() * stride];
                dispatch(AddPatches { source, pixels, batch, stride, sums: &mut sums });
            }
            sums
        };
        let parts: Vec<Vec<f64>> = pixels.par_chunks(PART_PATCHES).map(of_part).collect();
        let mut moments = Moments::new(coefficients, self.targets.len());
        parts.iter().for_each(|sums| moments.add_square(sums, stride));
        moments
    }
}
