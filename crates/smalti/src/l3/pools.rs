//! Moments of one class or of several pooled classes, including patches that are equivalent by symmetry.

use std::collections::BTreeMap;

use super::symmetry::{Isometry, Member, Symmetry};
use super::{Axes, Class, Moments, Statistics, Textures, pipeline};

/// The combinations of clipped channels on the saturation axis: none clipped, and every combination with at
/// least a given fraction of all patches. Ascending.
pub(super) fn kept_saturations(statistics: &Statistics, share: f64) -> Vec<u32> {
    let mut counts = BTreeMap::new();
    for (key, moments) in statistics.classes() {
        *counts.entry(key.saturation).or_insert(0.0) += moments.count() as f64;
    }
    saturation_axis(&counts, statistics.count() as f64, share)
}

/// The combinations of clipped channels on the saturation axis, from the number of patches of each and of all patches.
pub(crate) fn saturation_axis(counts: &BTreeMap<u32, f64>, total: f64, share: f64) -> Vec<u32> {
    let is_kept = |(mask, count): &(&u32, &f64)| **mask != 0 && **count > 0.0 && **count >= share * total;
    std::iter::once(0).chain(counts.iter().filter(is_kept).map(|(mask, _)| *mask)).collect()
}

/// The classes of a position to pool; `None` pools a whole axis.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pool {
    pub(super) saturation: Option<usize>,
    pub(super) level: Option<usize>,
    pub(super) texture: Option<usize>,
}

/// A class with training data, by its coordinates on the axes.
#[derive(Debug, Clone, Copy)]
pub(super) struct TrainedClass<'a> {
    pub(super) saturation: usize,
    pub(super) level: usize,
    pub(super) texture: usize,
    pub(super) moments: &'a Moments,
}

/// The classes with training data, for every position.
pub(super) struct Pools<'a> {
    axes: &'a Axes,
    outputs: usize,
    /// Per position. Combinations of clipped channels that are not on the axis count towards the nearest one.
    pub(super) seen: Vec<Vec<TrainedClass<'a>>>,
}

impl<'a> Pools<'a> {
    pub(super) fn new(statistics: &'a Statistics, saturations: &[u32]) -> Self {
        let axes = statistics.axes();
        let mut seen = vec![Vec::new(); axes.positions()];
        for (key, moments) in statistics.classes() {
            // Keys in the statistics lie within their axes.
            if let Some(list) = seen.get_mut(key.position as usize) {
                list.push(TrainedClass {
                    saturation: pipeline::nearest_saturation(saturations, key.saturation),
                    level: usize::from(key.level),
                    texture: usize::from(key.texture),
                    moments,
                });
            }
        }
        Self { axes, outputs: statistics.outputs().len(), seen }
    }

    /// Adds the numbers of patches to the classes of a pipeline.
    pub(super) fn count_into(&self, classes: &mut [Class], saturations: usize) {
        let (levels, textures) = (self.axes.level_count(), self.axes.textures().count());
        let per_position = saturations * levels * textures;
        for (own, seen) in classes.chunks_exact_mut(per_position).zip(&self.seen) {
            for seen in seen {
                own[(seen.saturation * levels + seen.level) * textures + seen.texture].count +=
                    seen.moments.count();
            }
        }
    }

    /// The classes of a pool around the representative position of a group, once for every symmetry operation
    /// that maps a member to it.
    fn chosen(&self, members: &[Member], pool: Pool) -> impl Iterator<Item = (Member, TrainedClass<'a>)> {
        let textures = self.axes.textures();
        let fits = |wanted: Option<usize>, got| wanted.is_none_or(|w| w == got);
        members.iter().flat_map(move |&member| {
            let here = self.seen.get(member.position).map_or(&[][..], Vec::as_slice);
            let chosen = here.iter().filter(move |s| {
                fits(pool.saturation, s.saturation)
                    && fits(pool.level, s.level)
                    && fits(pool.texture, member.isometry.texture(textures, s.texture))
            });
            chosen.map(move |s| (member, *s))
        })
    }

    /// Number of patches in a pool, without repetitions.
    pub(super) fn count(&self, position: usize, members: &[Member], pool: Pool) -> u64 {
        let all: u64 = self.chosen(members, pool).map(|(_, s)| s.moments.count()).sum();
        all / repeats(position, members, pool.texture, self.axes.textures())
    }

    /// Moments of a pool.
    pub(super) fn moments(&self, position: usize, members: &[Member], pool: Pool) -> Moments {
        let side = self.axes.side();
        let mut sum = Moments::new(self.axes.taps(), self.outputs);
        let mut last = None;
        let mut places: Vec<usize> = (0..sum.size()).collect();
        for (member, seen) in self.chosen(members, pool) {
            if member.isometry == Isometry::IDENTITY {
                sum.merge(seen.moments);
                continue;
            }
            if last != Some(member.isometry) {
                places[1..].iter_mut().zip(member.isometry.taps(side)).for_each(|(p, tap)| *p = 1 + tap);
                last = Some(member.isometry);
            }
            sum.merge_permuted(seen.moments, &places);
        }
        sum.divide(repeats(position, members, pool.texture, self.axes.textures()) as f64);
        sum
    }
}

/// Number of times a group repeats each patch of a texture class, or of all with `None`: the symmetry operations that keep the
/// position and the texture.
pub(super) fn repeats(
    position: usize,
    members: &[Member],
    texture: Option<usize>,
    textures: Textures,
) -> u64 {
    let stays =
        |m: &&Member| m.position == position && texture.is_none_or(|t| m.isometry.texture(textures, t) == t);
    (members.iter().filter(stays).count() as u64).max(1)
}

/// Whether a texture class is flat. Without texture classes, patches count as texture: detail lost by
/// smoothing cannot be restored.
pub(super) fn is_flat(textures: Textures, texture: usize) -> bool {
    textures != Textures::None && texture == 0
}

/// For symmetric positions: the smallest and largest mean response over all cells of the group.
pub(super) fn trained(statistics: &Statistics, symmetry: &Symmetry) -> Vec<[f32; 2]> {
    let own = statistics.trained();
    let mut by_group = own.to_vec();
    for (position, m) in symmetry.represented.iter().enumerate() {
        let [least, most] = own[position];
        let group = &mut by_group[m.position];
        *group = [group[0].min(least), group[1].max(most)];
    }
    symmetry.represented.iter().map(|m| by_group[m.position]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::l3::Levels;
    use crate::sensor::{Mosaic, SignalNoise};

    #[test]
    fn the_class_named_flat_is_flat() {
        for textures in [Textures::None, Textures::FlatTexture, Textures::Oriented] {
            for (texture, name) in textures.names().iter().enumerate() {
                assert_eq!(is_flat(textures, texture), *name == "flat", "{textures:?} {name}");
            }
        }
    }

    #[test]
    fn combinations_of_enough_patches_have_a_place() {
        let counts = BTreeMap::from([(0, 80.0), (1, 15.0), (2, 4.0), (4, 1.0), (6, 0.0)]);
        let axis = |share| saturation_axis(&counts, 100.0, share);
        assert_eq!(axis(0.0), [0, 1, 2, 4]);
        assert_eq!(axis(0.04), [0, 1, 2]);
        assert_eq!(axis(0.05), [0, 1]);
        assert_eq!(axis(0.9), [0]);
        assert_eq!(saturation_axis(&BTreeMap::new(), 0.0, 0.0), [0]);
    }

    /// A patch around red of a Bayer mosaic occurs in eight orientations, and one around green, with red beside and blue above, in four. Edges
    /// along rows and columns keep their direction in four of them.
    #[test]
    fn patches_repeat_as_often_as_their_mosaic_is_symmetric() {
        let mosaic = Mosaic::new(2, 2, vec![0, 1, 1, 2]).unwrap();
        let levels = Levels::new(vec![0.1]).unwrap();
        let symmetry = Symmetry::of(&Axes::new(mosaic, 5, levels, SignalNoise::default()).unwrap());
        let count = |position: usize, texture| {
            let (_, members) = symmetry.groups.iter().find(|(stands, _)| *stands == position).unwrap();
            repeats(position, members, texture, Textures::Oriented)
        };
        for (texture, red, green) in [(None, 8, 4), (Some(0), 8, 4), (Some(1), 8, 4), (Some(2), 4, 4)] {
            assert_eq!((count(0, texture), count(1, texture)), (red, green), "{texture:?}");
        }
        // The reflections of green swap the diagonals.
        assert_eq!((count(0, Some(3)), count(1, Some(3))), (4, 2));
        assert_eq!(repeats(0, &[], None, Textures::None), 1);
    }
}
