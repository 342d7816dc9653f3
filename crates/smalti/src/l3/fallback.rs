//! Kernels for classes with too few patches, so that every class has kernels.
//!
//! The sources, in order of preference ([`Origin`]): interpolation between the nearest learned levels on both
//! sides; all textures of the level; all combinations of clipped channels at the level; the nearest level
//! that has kernels; all patches of the position.

use rayon::prelude::*;

use super::pools::{Pool, is_flat};
use super::solve::Solution;
use super::{Axes, L3Error, Origin};

/// What the kernels of one position are solved from.
pub(super) trait Source: Sync {
    /// Number of patches in a pool of classes.
    fn count(&self, pool: Pool) -> u64;

    /// The kernels of a pool. `flat` states whether they are for flat patches; `class` is the index of the class, for error messages.
    fn solve(&self, pool: Pool, flat: bool, class: usize) -> Result<Solution, L3Error>;
}

/// The kernels of one position, by saturation, level and texture.
pub(super) struct Table<'a, S> {
    pub(super) position: usize,
    source: S,
    axes: &'a Axes,
    /// Numbers of saturations, levels and textures.
    sizes: [usize; 3],
    least: u64,
}

/// Kernels and their origins.
pub(super) type Filled = Vec<(Solution, Origin)>;

impl<'a, S: Source> Table<'a, S> {
    pub(super) fn new(position: usize, source: S, axes: &'a Axes, saturations: usize, least: u64) -> Self {
        let sizes = [saturations, axes.level_count(), axes.textures().count()];
        Self { position, source, axes, sizes, least }
    }

    /// Kernels of every class, in the order of a pipeline. For `smoothing`, see [`super::Training`].
    pub(super) fn filled(&self, smoothing: f64) -> Result<Filled, L3Error> {
        if self.count(Pool { saturation: None, level: None, texture: None }) == 0 {
            let cols = self.axes.mosaic().cols();
            return Err(L3Error::UnseenPosition { row: self.position / cols, col: self.position % cols });
        }
        let learned = self.smoothed(self.learned()?, smoothing);
        let mut filled: Vec<Option<(Solution, Origin)>> =
            learned.iter().map(|s| s.as_ref().map(|s| (s.clone(), Origin::Learned))).collect();
        self.interpolate(&learned, &mut filled);
        self.pool_textures(&mut filled)?;
        self.pool_saturations(&mut filled)?;
        self.nearest_level(&mut filled);
        self.pool_levels(filled)
    }

    fn index(&self, [saturation, level, texture]: [usize; 3]) -> usize {
        (saturation * self.sizes[1] + level) * self.sizes[2] + texture
    }

    fn place(&self, index: usize) -> [usize; 3] {
        let [_, levels, textures] = self.sizes;
        [index / (levels * textures), index / textures % levels, index % textures]
    }

    fn own(&self, index: usize) -> Pool {
        let [saturation, level, texture] = self.place(index).map(Some);
        Pool { saturation, level, texture }
    }

    fn count(&self, pool: Pool) -> u64 {
        self.source.count(pool)
    }

    /// Solves a pool for the kernels of a class.
    fn solve(&self, pool: Pool, index: usize) -> Result<Solution, L3Error> {
        let flat = is_flat(self.axes.textures(), self.place(index)[2]);
        let classes: usize = self.sizes.iter().product();
        self.source.solve(pool, flat, self.position * classes + index)
    }

    fn solve_when_enough(&self, pool: Pool, index: usize) -> Result<Option<Solution>, L3Error> {
        (self.count(pool) >= self.least).then(|| self.solve(pool, index)).transpose()
    }

    fn learned(&self) -> Result<Vec<Option<Solution>>, L3Error> {
        let all = (0..self.sizes.iter().product()).into_par_iter();
        all.map(|index| self.solve_when_enough(self.own(index), index)).collect()
    }

    /// Mixes learned kernels with those of the levels below and above. The weights are the numbers of
    /// patches; those of the neighbours are multiplied by `smoothing`.
    fn smoothed(&self, learned: Vec<Option<Solution>>, smoothing: f64) -> Vec<Option<Solution>> {
        if smoothing <= 0.0 {
            return learned;
        }
        let counts: Vec<f64> = (0..learned.len()).map(|index| self.count(self.own(index)) as f64).collect();
        let mixed = |index: usize| {
            let own = learned[index].as_ref()?;
            let [saturation, level, texture] = self.place(index);
            let neighbours = [level.checked_sub(1), Some(level + 1).filter(|l| *l < self.sizes[1])];
            let mut parts = vec![(counts[index], own)];
            for level in neighbours.into_iter().flatten() {
                let neighbour = self.index([saturation, level, texture]);
                parts.extend(learned[neighbour].as_ref().map(|s| (smoothing * counts[neighbour], s)));
            }
            let total: f64 = parts.iter().map(|p| p.0).sum();
            parts.iter_mut().for_each(|p| p.0 /= total);
            Solution::mixed(&parts)
        };
        (0..learned.len()).map(mixed).collect()
    }

    /// Interpolates linearly in the logarithm of the level.
    fn interpolate(&self, learned: &[Option<Solution>], filled: &mut [Option<(Solution, Origin)>]) {
        let levels = self.axes.levels_at(self.position);
        let log = |level: usize| libm::log(levels.middle(level).max(f64::MIN_POSITIVE));
        for (index, empty) in filled.iter_mut().enumerate().filter(|(_, f)| f.is_none()) {
            let [saturation, level, texture] = self.place(index);
            let at = |l: usize| learned[self.index([saturation, l, texture])].as_ref().map(|s| (l, s));
            let below = (0..level).rev().find_map(at);
            let above = (level + 1..self.sizes[1]).find_map(at);
            if let (Some((low, a)), Some((high, b))) = (below, above) {
                let share = (log(level) - log(low)) / (log(high) - log(low));
                // Non-positive cuts have no logarithm.
                let by_place = (level - low) as f64 / (high - low) as f64;
                let share = if (0.0..=1.0).contains(&share) { share } else { by_place };
                *empty = Solution::mixed(&[(1.0 - share, a), (share, b)]).map(|s| (s, Origin::Interpolated));
            }
        }
    }

    fn pool_textures(&self, filled: &mut [Option<(Solution, Origin)>]) -> Result<(), L3Error> {
        filled.par_iter_mut().enumerate().filter(|(_, f)| f.is_none()).try_for_each(|(index, empty)| {
            let pool = Pool { texture: None, ..self.own(index) };
            *empty = self.solve_when_enough(pool, index)?.map(|s| (s, Origin::PooledTextures));
            Ok(())
        })
    }

    /// Pools all saturations of a level: solves once for flat patches and once for the others.
    fn pool_saturations(&self, filled: &mut [Option<(Solution, Origin)>]) -> Result<(), L3Error> {
        let textures = self.sizes[2].min(2);
        let solved: Vec<Option<Solution>> = (0..self.sizes[1] * textures)
            .into_par_iter()
            .map(|i| {
                let (level, texture) = (i / textures, i % textures);
                let needed = |index: usize| {
                    let [_, l, t] = self.place(index);
                    filled[index].is_none() && l == level && t.min(1) == texture
                };
                let Some(index) = (0..filled.len()).find(|&index| needed(index)) else { return Ok(None) };
                self.solve_when_enough(Pool { saturation: None, level: Some(level), texture: None }, index)
            })
            .collect::<Result<_, _>>()?;
        for (index, empty) in filled.iter_mut().enumerate().filter(|(_, f)| f.is_none()) {
            let [_, level, texture] = self.place(index);
            let found = solved[level * textures + texture.min(1)].clone();
            *empty = found.map(|s| (s, Origin::PooledSaturations));
        }
        Ok(())
    }

    /// Takes the nearest level; of two equally near, the brighter, which is less noisy.
    fn nearest_level(&self, filled: &mut [Option<(Solution, Origin)>]) {
        let found: Vec<Option<Solution>> = (0..filled.len())
            .map(|index| {
                let [saturation, level, texture] = self.place(index);
                let at =
                    |l: usize| filled[self.index([saturation, l, texture])].as_ref().map(|f| f.0.clone());
                let mut order: Vec<usize> = (0..self.sizes[1]).collect();
                order.sort_by_key(|&l| (l.abs_diff(level), std::cmp::Reverse(l)));
                filled[index].is_none().then(|| order.into_iter().find_map(at)).flatten()
            })
            .collect();
        for (empty, found) in filled.iter_mut().zip(found).filter(|(f, _)| f.is_none()) {
            *empty = found.map(|s| (s, Origin::NearestLevel));
        }
    }

    fn pool_levels(&self, filled: Vec<Option<(Solution, Origin)>>) -> Result<Filled, L3Error> {
        let mut last: [Option<Solution>; 2] = [None, None];
        let mut whole = Vec::with_capacity(filled.len());
        for (index, kernels) in filled.into_iter().enumerate() {
            whole.push(match kernels {
                Some(kernels) => kernels,
                None => {
                    let kind = usize::from(is_flat(self.axes.textures(), self.place(index)[2]));
                    let pool = Pool { saturation: None, level: None, texture: None };
                    let solution = match last[kind].take() {
                        Some(solution) => solution,
                        None => self.solve(pool, index)?,
                    };
                    last[kind] = Some(solution.clone());
                    (solution, Origin::PooledLevels)
                }
            });
        }
        Ok(whole)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use crate::l3::Levels;
    use crate::sensor::{Mosaic, SignalNoise};

    fn axes(cuts: &[f32]) -> Axes {
        let noise = SignalNoise { constant: 1e-6, per_signal: 1e-4, ..SignalNoise::default() };
        let mosaic = Mosaic::new(2, 2, vec![0, 1, 1, 2]).unwrap();
        Axes::new(mosaic, 3, Levels::new(cuts.to_vec()).unwrap(), noise).unwrap()
    }

    /// Kernels of a single weight: the class that they are solved for.
    struct Classes;

    impl Source for Classes {
        fn count(&self, _: Pool) -> u64 {
            10
        }

        fn solve(&self, _: Pool, _: bool, class: usize) -> Result<Solution, L3Error> {
            Ok(Solution { weights: vec![class as f64], offsets: vec![0.0] })
        }
    }

    #[test]
    fn classes_are_numbered_through_all_positions() {
        let axes = axes(&[0.1, 0.4]);
        let mut next = 0;
        for position in 0..axes.positions() {
            for (solution, origin) in Table::new(position, Classes, &axes, 2, 10).filled(0.0).unwrap() {
                assert_eq!((solution.weights[0], origin), (f64::from(next), Origin::Learned));
                next += 1;
            }
        }
        assert_eq!(next as usize, axes.positions() * 2 * 3 * axes.textures().count());
    }

    /// Kernels of a single weight, their level. Only these levels have patches.
    struct LevelsSeen([usize; 2]);

    impl Source for LevelsSeen {
        fn count(&self, pool: Pool) -> u64 {
            if pool.level.is_none_or(|level| self.0.contains(&level)) { 10 } else { 0 }
        }

        fn solve(&self, pool: Pool, _: bool, _: usize) -> Result<Solution, L3Error> {
            Ok(Solution { weights: vec![pool.level.unwrap() as f64], offsets: vec![0.0] })
        }
    }

    #[test]
    fn levels_without_a_logarithm_are_interpolated_by_their_place() {
        let axes = axes(&[-0.5, -0.4, -0.3, -0.2, -0.1]);
        let table = Table::new(0, LevelsSeen([1, 4]), &axes, 1, 10);
        for (index, (solution, origin)) in table.filled(0.0).unwrap().into_iter().enumerate() {
            let level = table.place(index)[1];
            let (expected, from) = match level {
                1 | 4 => (level, Origin::Learned),
                2 | 3 => (level, Origin::Interpolated),
                _ => (level.clamp(1, 4), Origin::NearestLevel),
            };
            assert_eq!(origin, from, "level {level}");
            // Rounding of two shares.
            assert!((solution.weights[0] - expected as f64).abs() < 1e-12, "{level}: {:?}", solution.weights);
        }
    }
}
