//! The statistics of the light in the layout of the kernels.

use super::color_error::{ColorError, PACKED};
use super::condition::{Level, ScreenCondition};
use super::crosstalk::Crosstalk;
use super::eye::Eye;
use super::lanes::{LANES, Lanes, ZERO};
use super::layout::Layout;
use super::responses::{FilterResponses, sum_of_products};
use crate::camera::{Camera, CameraError};
use crate::design::error::DesignError;
use crate::design::light::{LightClass, LightStatistics};
use crate::sensor::Mosaic;
use crate::spectrum::Spectrum;

/// Patches below which a class is not used.
pub(crate) const MIN_PATCHES: u64 = 64;
/// Least side of a patch of samples.
const MIN_SIDE: usize = 3;
/// The number of patches of all hues that the covariance of a hue is completed with: the covariance of a few hundred patches knows too
/// few of its several hundred rows.
const SHARED_PATCHES: f64 = 1000.0;

/// The expected errors of colour filter arrays on one camera, from the statistics of the light on its pixels.
#[derive(Debug, Clone)]
pub struct Screen {
    /// Number of samples of a patch.
    pub(super) taps: usize,
    /// Number of pixels of a patch of light: more than `taps` with crosstalk.
    pub(super) light_taps: usize,
    pub(super) crosstalk: Option<Crosstalk>,
    pub(super) components: usize,
    pub(super) side: usize,
    /// Number of vectors of classes.
    pub(super) groups: usize,
    /// Covariances of pixels i ≤ j, by pair, group, and the components of i and j.
    pub(super) covariances: Vec<Lanes>,
    /// Covariances of a pixel with X, Y, Z of the middle one, by pixel, group and component.
    pub(super) crossed: Vec<[Lanes; 3]>,
    /// Means, by pixel, group and component.
    pub(super) means: Vec<Lanes>,
    /// Variance of X, Y, Z of the middle pixel: (0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2), by group.
    pub(super) targets: Vec<[Lanes; 6]>,
    /// Share of the patches that are of a class, by group.
    pub(super) shares: Vec<Lanes>,
    /// The same for the classes of the highest contrast, 0 for all others.
    pub(super) detailed: Vec<Lanes>,
    /// The sum of `detailed`.
    pub(super) detailed_share: f64,
    /// Mean of 1/w² over the patches of a class, w the luminance of display white, by group.
    pub(super) per_white_squared: Vec<Lanes>,
    /// The opponent filters of the eye.
    pub(super) eye: Eye,
    /// Of each class, in the order of lanes.
    pub(super) colors: Vec<ColorError>,
    pub(super) levels: Vec<Level>,
    /// For each component, the spectrum whose scalar product with the transmittance of a filter is its response, electrons per second.
    pub(super) electrons: Vec<Spectrum>,
    /// Response of a bare pixel to white of display luminance, by component.
    pub(super) white: Vec<f64>,
}

impl Screen {
    /// A screen for a camera, whose own filters do not matter, under conditions.
    ///
    /// # Errors
    /// When the statistics are of another lens, pixel or light than the camera's or of patches that are too small for its crosstalk, no class
    /// has enough patches, or a condition is invalid.
    pub fn new(
        camera: &Camera,
        statistics: &LightStatistics,
        conditions: &[ScreenCondition],
    ) -> Result<Self, DesignError> {
        if statistics.basis().grid() != camera.grid() {
            return Err(DesignError::OtherLight { what: "wavelengths" });
        }
        let (light_side, components) = (statistics.settings().side, statistics.basis().len());
        let border = if camera.sensor.crosstalk.is_some() { Crosstalk::BORDER } else { 0 };
        let side = light_side - 2 * border;
        if side < MIN_SIDE {
            let expected = MIN_SIDE + 2 * border;
            let message = format!(
                "statistics of patches of {light_side} × {light_side} pixels; with crosstalk expected at least {expected}"
            );
            return Err(DesignError::key("light.side", message));
        }
        let (taps, light_taps) = (side * side, light_side * light_side);
        let classes = usable(statistics)?;
        let groups = classes.len().div_ceil(LANES);
        let pairs = light_taps * (light_taps + 1) / 2;
        let mut screen = Self {
            taps,
            light_taps,
            crosstalk: camera.sensor.crosstalk_between_samples().map(|kernel| Crosstalk::new(&kernel, side)),
            components,
            side,
            groups,
            covariances: vec![ZERO; pairs * groups * components * components],
            crossed: vec![[ZERO; 3]; light_taps * groups * components],
            means: vec![ZERO; light_taps * groups * components],
            targets: vec![[ZERO; 6]; groups],
            shares: vec![ZERO; groups],
            detailed: vec![ZERO; groups],
            detailed_share: 0.0,
            per_white_squared: vec![ZERO; groups],
            eye: Eye::new(side, statistics.white())?,
            colors: Vec::with_capacity(classes.len()),
            levels: Vec::new(),
            electrons: electrons(camera, statistics)?,
            white: statistics.white_coefficients().to_vec(),
        };
        let total: f64 = classes.iter().map(|c| c.patches).sum();
        // The highest contrast of which there are patches.
        let most = classes.iter().map(|c| c.contrast).max();
        for (at, class) in classes.iter().enumerate() {
            screen.fill(at, class, statistics, total);
        }
        // Lanes without a class would factor zeros; those of the first class are as good, with a share of 0.
        for at in classes.len()..groups * LANES {
            if let Some(class) = classes.first() {
                screen.fill(at, &Usable { patches: 0.0, ..class.clone() }, statistics, total);
            }
        }
        for (at, class) in classes.iter().enumerate().filter(|(_, c)| Some(c.contrast) == most) {
            screen.detailed[at / LANES][at % LANES] = class.patches / total;
            screen.detailed_share += class.patches / total;
        }
        let squares = |c: &Usable| c.patches * c.per_white_squared;
        let white_y = (total / classes.iter().map(squares).sum::<f64>()).sqrt();
        screen.white.iter_mut().for_each(|c| *c *= white_y);
        for condition in conditions {
            screen.levels.push(Level::new(camera, condition)?);
        }
        Ok(screen)
    }

    /// Puts a class into its lane.
    fn fill(&mut self, at: usize, class: &Usable, statistics: &LightStatistics, total: f64) {
        let (group, lane, k) = (at / LANES, at % LANES, self.components);
        let xyz = statistics.xyz();
        let width = self.light_taps * k;
        let covariance =
            |i: usize, a: usize, j: usize, b: usize| class.covariance[(i * k + a) * width + j * k + b];
        let mut pair = 0;
        for i in 0..self.light_taps {
            for j in i..self.light_taps {
                for a in 0..k {
                    for b in 0..k {
                        let place = ((pair * self.groups + group) * k + a) * k + b;
                        self.covariances[place][lane] = covariance(i, a, j, b);
                    }
                }
                pair += 1;
            }
        }
        let middle = self.light_taps / 2;
        let seen = |row: &dyn Fn(usize) -> f64, c: usize| (0..k).map(|b| row(b) * xyz[b][c]).sum::<f64>();
        for i in 0..self.light_taps {
            for a in 0..k {
                let place = (i * self.groups + group) * k + a;
                self.means[place][lane] = class.mean[i * k + a];
                for c in 0..3 {
                    self.crossed[place][c][lane] = seen(&|b| covariance(i, a, middle, b), c);
                }
            }
        }
        for (entry, (c, d)) in PACKED.into_iter().enumerate() {
            let row = |a: usize| seen(&|b| covariance(middle, a, middle, b), d);
            self.targets[group][entry][lane] = seen(&row, c);
        }
        self.shares[group][lane] = class.patches / total;
        self.per_white_squared[group][lane] = class.per_white_squared;
        if self.colors.len() == at {
            self.colors.push(ColorError::new(&class.colors, statistics.white()));
        }
    }

    /// The filters of the pixels of patches.
    pub(super) fn layout(&self, mosaic: &Mosaic) -> Layout {
        let border = if self.crosstalk.is_some() { Crosstalk::BORDER } else { 0 };
        Layout::new(self.side, border, mosaic)
    }

    /// Number of conditions.
    #[must_use]
    pub fn conditions(&self) -> usize {
        self.levels.len()
    }

    /// Number of classes.
    #[must_use]
    pub fn classes(&self) -> usize {
        self.shares.iter().flatten().filter(|share| **share > 0.0).count()
    }

    /// The responses of filters, given by their transmittances on the wavelengths of the camera.
    #[must_use]
    pub fn responses(&self, transmittances: &[Spectrum]) -> FilterResponses {
        let of =
            |t: &Spectrum| self.electrons.iter().map(|e| sum_of_products(e.values(), t.values())).collect();
        FilterResponses(transmittances.iter().map(of).collect())
    }

    /// For each spectral component, the spectrum whose scalar product with a transmittance is the response of the filter: the derivatives
    /// of [`Screen::responses`].
    #[must_use]
    pub fn response_spectra(&self) -> &[Spectrum] {
        &self.electrons
    }
}

/// A class with enough patches.
#[derive(Debug, Clone)]
struct Usable {
    patches: f64,
    /// The level of contrast, from the lowest.
    contrast: usize,
    mean: Vec<f64>,
    /// Square, row by row.
    covariance: Vec<f64>,
    per_white_squared: f64,
    /// Colours of the middle pixel, relative to display white, with their shares.
    colors: Vec<([f64; 3], f64)>,
}

/// The classes with enough patches, their covariances completed with those of all hues.
fn usable(statistics: &LightStatistics) -> Result<Vec<Usable>, DesignError> {
    let rule = &statistics.settings().classes;
    let n = statistics.coefficients();
    let enough = |c: &&LightClass| c.moments.count() >= MIN_PATCHES;
    let mut found = Vec::new();
    let mut group: Option<(std::ops::Range<usize>, Vec<f64>)> = None;
    for (number, class) in statistics.classes() {
        if !enough(&class) {
            continue;
        }
        let range = rule.of_all_hues(*number);
        if group.as_ref().is_none_or(|(of, _)| *of != range) {
            // The covariance about the mean of each hue.
            let (mut sum, mut patches) = (vec![0.0; n * n], 0.0);
            for (_, other) in statistics.classes().range(range.clone()) {
                let count = other.moments.count() as f64;
                let (_, covariance) = mean_and_covariance(other, n);
                sum.iter_mut().zip(covariance).for_each(|(s, c)| *s += count * c);
                patches += count;
            }
            sum.iter_mut().for_each(|s| *s /= patches);
            group = Some((range, sum));
        }
        let (mean, mut covariance) = mean_and_covariance(class, n);
        let patches = class.moments.count() as f64;
        if let Some((_, shared)) = group.as_ref().filter(|(range, _)| range.len() > 1) {
            let own = patches / (patches + SHARED_PATCHES);
            covariance.iter_mut().zip(shared).for_each(|(c, s)| *c = own * *c + (1.0 - own) * s);
        }
        found.push(Usable {
            patches,
            contrast: rule.contrast_of(*number),
            mean,
            covariance,
            per_white_squared: class.per_white_squared / patches,
            colors: class.colors.means().collect(),
        });
    }
    if found.is_empty() {
        return Err(DesignError::TooFewPatches { least: MIN_PATCHES });
    }
    Ok(found)
}

fn mean_and_covariance(class: &LightClass, n: usize) -> (Vec<f64>, Vec<f64>) {
    let m = &class.moments;
    let count = m.count().max(1) as f64;
    let mean: Vec<f64> = (0..n).map(|i| m.get(0, 1 + i) / count).collect();
    let mut covariance = vec![0.0; n * n];
    for i in 0..n {
        for j in i..n {
            let value = m.get(1 + i, 1 + j) / count - mean[i] * mean[j];
            covariance[i * n + j] = value;
            covariance[j * n + i] = value;
        }
    }
    (mean, covariance)
}

/// For each component, the electrons per second at each wavelength behind a filter of transmittance 1.
fn electrons(camera: &Camera, statistics: &LightStatistics) -> Result<Vec<Spectrum>, DesignError> {
    let grid = camera.grid();
    let bare = camera.sensor.bare_responsivity_on(grid).map_err(CameraError::from)?;
    let lens = camera.optics.transmittance_on(grid).map_err(CameraError::from)?;
    let pixel = bare.times(&lens).and_then(|s| s.scaled(grid.step_nm())).map_err(CameraError::from)?;
    let of = |c: &Spectrum| Ok(c.times(&pixel).map_err(CameraError::from)?);
    statistics.basis().components().iter().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::light::{COLOR_GROUPS, ClassParts, LightClasses, LightParts, LightSettings};
    use crate::l3::Moments;
    use crate::numeric::philox::Stream;
    use crate::spectrum::WavelengthGrid;

    /// Coefficients of patches of 3 × 3 pixels with one component.
    const N: usize = 9;

    /// Patches that vary the more, the further they are from the middle.
    fn patches(count: usize, seed: u64) -> Vec<[f64; N]> {
        let mut random = Stream::new(seed, 1, 2);
        let patch = |_| {
            let level = random.uniform();
            std::array::from_fn(|i| level + 0.2 * (i as f64 - 4.0 + seed as f64) * random.uniform())
        };
        (0..count).map(patch).collect()
    }

    /// Statistics with a class for each set of patches.
    fn statistics(sets: &[Vec<[f64; N]>], hues: bool) -> LightStatistics {
        let class = |(number, set): (usize, &Vec<[f64; N]>)| {
            let mut moments = Moments::new(N, 0);
            set.iter().for_each(|patch| moments.add(&[&[1.0], &patch[..]].concat(), 1.0));
            let mut colors = [[0.0; 4]; COLOR_GROUPS];
            colors[number] = [set.len() as f64, 1.0, 2.0, 3.0];
            let per_white_squared = 0.25 * set.len() as f64;
            ClassParts { number, sums: moments.sums().to_vec(), per_white_squared, colors }
        };
        let grid = WavelengthGrid::VISIBLE;
        let classes = LightClasses { contrast_cuts: Vec::new(), hues, ..LightClasses::default() };
        let ones = vec![vec![1.0; grid.len()]];
        let parts = LightParts {
            settings: LightSettings { side: 3, classes, ..LightSettings::default() },
            grid,
            components: ones.clone(),
            analysis: ones,
            left_out: 0.0,
            xyz: vec![[1.0; 3]],
            white: [1.0; 3],
            white_coefficients: vec![1.0],
            source: String::new(),
            scenes: 1,
            energy: [1.0, 0.0],
            classes: sets.iter().enumerate().filter(|(_, set)| !set.is_empty()).map(class).collect(),
        };
        LightStatistics::from_parts(parts).unwrap()
    }

    fn mean(set: &[[f64; N]]) -> [f64; N] {
        std::array::from_fn(|i| set.iter().map(|patch| patch[i]).sum::<f64>() / set.len() as f64)
    }

    /// What patches differ by from the mean of their set, with a weight for each.
    fn apart(set: &[[f64; N]], weight: f64) -> impl Iterator<Item = (f64, [f64; N])> {
        let mean = mean(set);
        set.iter().map(move |patch| (weight, std::array::from_fn(|i| patch[i] - mean[i])))
    }

    fn same(found: &Usable, expected: &[(f64, [f64; N])]) {
        let total: f64 = expected.iter().map(|(weight, _)| weight).sum();
        for (at, value) in found.covariance.iter().enumerate() {
            let products = expected.iter().map(|(weight, d)| weight * d[at / N] * d[at % N]);
            let expected = products.sum::<f64>() / total;
            // Rounding of the sums of a few thousand products.
            assert!((value - expected).abs() < 1e-10, "{at}: {value} {expected}");
        }
    }

    /// A hue has the covariance of its own patches and of a thousand of all hues, each about the mean of its hue. Those with too few patches
    /// for a class of their own are among these.
    #[test]
    fn hues_share_a_thousand_patches() {
        let sets = [patches(1000, 1), Vec::new(), patches(70, 2), patches(30, 3), patches(2500, 4)];
        let found = usable(&statistics(&sets, true)).unwrap();
        let used = [&sets[0], &sets[2], &sets[4]];
        assert_eq!(found.len(), used.len());
        let all = sets.iter().map(Vec::len).sum::<usize>() as f64;
        for (found, own) in found.iter().zip(used) {
            assert_eq!((found.patches, found.contrast, found.per_white_squared), (own.len() as f64, 0, 0.25));
            for (a, b) in found.mean.iter().zip(mean(own)) {
                assert!((a - b).abs() < 1e-10, "{a} {b}");
            }
            let shared = sets.iter().filter(|set| !set.is_empty()).flat_map(|set| apart(set, 1000.0 / all));
            same(found, &apart(own, 1.0).chain(shared).collect::<Vec<_>>());
            assert_eq!(found.colors, [([1.0, 2.0, 3.0].map(|v| v / own.len() as f64), 1.0)]);
        }
    }

    /// Without hues, classes have the covariances of their patches.
    #[test]
    fn classes_without_hues_share_nothing() {
        let sets = [patches(100, 5)];
        let found = usable(&statistics(&sets, false)).unwrap();
        same(&found[0], &apart(&sets[0], 1.0).collect::<Vec<_>>());
        let few = usable(&statistics(&[patches(63, 6)], false));
        assert!(matches!(few, Err(DesignError::TooFewPatches { least: MIN_PATCHES })));
        assert_eq!(usable(&statistics(&[patches(64, 6)], false)).unwrap().len(), 1);
    }
}
