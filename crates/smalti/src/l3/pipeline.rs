//! The learned table: classes and their kernels.

use super::{Axes, ClassKey, L3Error, Quality, Refinement};

/// Origin of the kernels of a class, in order of preference.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Origin {
    /// Learned from the patches of the class itself (and of classes that are equivalent by symmetry).
    Learned = 0,
    /// Interpolated between the nearest learned levels on both sides, for lack of patches.
    Interpolated = 1,
    /// Learned from all textures of the level.
    PooledTextures = 2,
    /// Learned from all combinations of saturated channels at the level.
    PooledSaturations = 3,
    /// Copied from the nearest level that has kernels.
    NearestLevel = 4,
    /// Learned from all patches of the position.
    PooledLevels = 5,
}

impl Origin {
    /// All origins, in order.
    pub const ALL: [Self; 6] = [
        Self::Learned,
        Self::Interpolated,
        Self::PooledTextures,
        Self::PooledSaturations,
        Self::NearestLevel,
        Self::PooledLevels,
    ];

    /// The origin with a number.
    #[must_use]
    pub fn from_code(code: u8) -> Option<Self> {
        Self::ALL.get(usize::from(code)).copied()
    }

    /// Its name in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Learned => "learned",
            Self::Interpolated => "interpolated along level",
            Self::PooledTextures => "pooled over texture",
            Self::PooledSaturations => "pooled over saturation",
            Self::NearestLevel => "nearest level",
            Self::PooledLevels => "pooled over level",
        }
    }
}

/// A class, and the origin of its kernels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Class {
    /// Number of training patches.
    pub count: u64,
    /// Origin of its kernels.
    pub origin: Origin,
}

/// The kernels of every class: for each class and output, one weight per tap of the patch (row order) and an
/// offset.
#[derive(Debug, Clone, PartialEq)]
pub struct Kernels {
    /// Weights, ordered class, output, tap: output = offset + Σ weight · normalised sample.
    pub weights: Vec<f32>,
    /// Offsets, ordered class, output.
    pub offsets: Vec<f32>,
}

/// A learned pipeline.
#[derive(Debug, Clone, PartialEq)]
pub struct Pipeline {
    parts: PipelineParts,
    white: Option<[f64; 3]>,
    refinement: Option<Refinement>,
}

/// The parts of a [`Pipeline`].
#[derive(Debug, Clone, PartialEq)]
pub struct PipelineParts {
    /// The class axes.
    pub axes: Axes,
    /// Combinations of saturated channels on the saturation axis, bit `c` for channel `c`, ascending from 0.
    pub saturations: Vec<u32>,
    /// Names of the outputs; `X`, `Y`, `Z` for a colour image.
    pub outputs: Vec<String>,
    /// Names of the mosaic's channels.
    pub channel_names: Vec<String>,
    /// Black level of the raw images, digital numbers.
    pub black_level: f64,
    /// White level of the raw images, digital numbers.
    pub white_level: f64,
    /// Smallest and largest mean response in the training data, for each position.
    pub trained: Vec<[f32; 2]>,
    /// The classes; the indices vary from position (slowest) through saturation and level to texture
    /// (fastest).
    pub classes: Vec<Class>,
    /// Their kernels.
    pub kernels: Kernels,
    /// Description of the training, as JSON.
    pub provenance: String,
}

impl Pipeline {
    /// A pipeline from its parts.
    ///
    /// # Errors
    /// [`L3Error::Table`], which names the inconsistency.
    pub fn from_parts(parts: PipelineParts) -> Result<Self, L3Error> {
        let PipelineParts { axes, saturations, outputs, channel_names, trained, kernels, .. } = &parts;
        let wrong = |reason: String| Err(L3Error::Table(reason));
        if saturations.first() != Some(&0) || saturations.windows(2).any(|w| w[0] >= w[1]) {
            return wrong("the saturation axis must ascend from 0".into());
        }
        let channels = axes.mosaic().channels();
        if saturations.last().is_some_and(|&mask| u64::from(mask) >> channels != 0) {
            return wrong(format!(
                "a combination of saturated channels names one beyond the {channels} there are"
            ));
        }
        if outputs.is_empty() || outputs.len() > 64 {
            return wrong(format!("{} outputs; 1 to 64 expected", outputs.len()));
        }
        if channel_names.len() != channels {
            return wrong(format!("{} channel names for {channels} channels", channel_names.len()));
        }
        let (black_level, white_level) = (parts.black_level, parts.white_level);
        if !(black_level.is_finite() && white_level.is_finite() && white_level > black_level) {
            return wrong(format!("white level {white_level} must lie above black level {black_level}"));
        }
        if trained.len() != axes.positions() || trained.iter().flatten().any(|v| v.is_nan()) {
            return wrong(format!("{} trained ranges for {} positions", trained.len(), axes.positions()));
        }
        let count = axes.positions() * saturations.len() * axes.level_count() * axes.textures().count();
        let sizes = [
            ("classes", parts.classes.len(), count),
            ("weights", kernels.weights.len(), count * outputs.len() * axes.taps()),
            ("offsets", kernels.offsets.len(), count * outputs.len()),
        ];
        for (what, got, expected) in sizes {
            if got != expected {
                return wrong(format!("{got} {what}, expected {expected}"));
            }
        }
        if kernels.weights.iter().chain(&kernels.offsets).any(|v| !v.is_finite()) {
            return wrong("a kernel holds a value that is not finite".into());
        }
        Ok(Self { parts, white: None, refinement: None })
    }

    /// The class axes.
    #[must_use]
    pub fn axes(&self) -> &Axes {
        &self.parts.axes
    }

    /// Combinations of saturated channels on the saturation axis, ascending from 0.
    #[must_use]
    pub fn saturations(&self) -> &[u32] {
        &self.parts.saturations
    }

    /// Names of the outputs.
    #[must_use]
    pub fn outputs(&self) -> &[String] {
        &self.parts.outputs
    }

    /// Names of the mosaic's channels.
    #[must_use]
    pub fn channel_names(&self) -> &[String] {
        &self.parts.channel_names
    }

    /// Black level of the raw images, digital numbers.
    #[must_use]
    pub fn black_level(&self) -> f64 {
        self.parts.black_level
    }

    /// White level of the raw images, digital numbers.
    #[must_use]
    pub fn white_level(&self) -> f64 {
        self.parts.white_level
    }

    /// Smallest and largest mean response in the training data, for each position.
    #[must_use]
    pub fn trained(&self) -> &[[f32; 2]] {
        &self.parts.trained
    }

    /// The pipeline with the white point of its output: X, Y, Z, Y = 1, of a perfect diffuser under the
    /// illuminant of the targets. It is needed for display; rendering does not use it.
    #[must_use]
    pub fn with_white(self, white: Option<[f64; 3]>) -> Self {
        Self { white, ..self }
    }

    /// The pipeline with another description of its training, JSON.
    #[must_use]
    pub fn with_provenance(mut self, provenance: String) -> Self {
        self.parts.provenance = provenance;
        self
    }

    /// The pipeline with a second stage, or without one.
    ///
    /// # Errors
    /// [`L3Error::NoPicture`] when its outputs are not X, Y, Z.
    pub fn with_refinement(self, refinement: Option<Refinement>) -> Result<Self, L3Error> {
        if refinement.is_some() {
            self.ensure_picture()?;
        }
        Ok(Self { refinement, ..self })
    }

    /// Checks that the outputs are X, Y, Z.
    ///
    /// # Errors
    /// [`L3Error::NoPicture`].
    pub fn ensure_picture(&self) -> Result<(), L3Error> {
        let outputs = self.outputs();
        if outputs == ["X", "Y", "Z"] { Ok(()) } else { Err(L3Error::NoPicture(outputs.join(", "))) }
    }

    /// The second stage, if there is one.
    #[must_use]
    pub fn refinement(&self) -> Option<&Refinement> {
        self.refinement.as_ref()
    }

    /// The quality that the pipeline was learned for.
    #[must_use]
    pub fn quality(&self) -> Quality {
        if self.refinement.is_some() { Quality::Best } else { Quality::Fast }
    }

    /// The pipeline with the stages of a quality: one of best quality also renders with its first stage alone.
    ///
    /// # Errors
    /// [`L3Error::NoSecondStage`] when best quality is asked of a pipeline of one stage.
    pub fn at_quality(self, quality: Quality) -> Result<Self, L3Error> {
        match (quality, &self.refinement) {
            (Quality::Best, None) => Err(L3Error::NoSecondStage),
            (Quality::Best, Some(_)) => Ok(self),
            (Quality::Fast, _) => Ok(Self { refinement: None, ..self }),
        }
    }

    /// White point of the output, X, Y, Z with Y = 1, where the outputs are X, Y, Z and it is known.
    #[must_use]
    pub fn white(&self) -> Option<[f64; 3]> {
        self.white
    }

    /// Description of the training, as JSON.
    #[must_use]
    pub fn provenance(&self) -> &str {
        &self.parts.provenance
    }

    /// The classes; the indices vary from position (slowest) through saturation and level to texture
    /// (fastest).
    #[must_use]
    pub fn classes(&self) -> &[Class] {
        &self.parts.classes
    }

    /// The kernels of all classes.
    #[must_use]
    pub fn kernels(&self) -> &Kernels {
        &self.parts.kernels
    }

    /// The weights of a class for an output, in the row order of the patch; `None` when there is no such class
    /// or output.
    #[must_use]
    pub fn weights(&self, class: usize, output: usize) -> Option<&[f32]> {
        let (taps, outputs) = (self.parts.axes.taps(), self.parts.outputs.len());
        if class >= self.parts.classes.len() || output >= outputs {
            return None;
        }
        let at = (class * outputs + output) * taps;
        self.parts.kernels.weights.get(at..at + taps)
    }

    /// The index of a class from its coordinates on the axes.
    #[must_use]
    pub fn index(&self, position: usize, saturation: usize, level: usize, texture: usize) -> usize {
        let textures = self.parts.axes.textures().count();
        ((position * self.parts.saturations.len() + saturation) * self.parts.axes.level_count() + level)
            * textures
            + texture
    }

    /// The class with an index.
    #[must_use]
    pub fn key(&self, index: usize) -> ClassKey {
        let (textures, levels) = (self.parts.axes.textures().count(), self.parts.axes.level_count());
        let saturation = index / (textures * levels) % self.parts.saturations.len();
        ClassKey {
            position: (index / (textures * levels * self.parts.saturations.len())) as u32,
            saturation: self.parts.saturations[saturation],
            level: (index / textures % levels) as u16,
            texture: (index % textures) as u16,
        }
    }

    /// Index on the saturation axis of a combination of clipped channels. For a combination that is not on
    /// the axis, it is that of the combination that differs in the fewest channels and, of several, has the
    /// most channels clipped.
    #[must_use]
    pub fn saturation_place(&self, clipped: u32) -> usize {
        nearest_saturation(&self.parts.saturations, clipped)
    }
}

/// Index of the nearest combination of clipped channels: see [`Pipeline::saturation_place`].
pub(crate) fn nearest_saturation(saturations: &[u32], clipped: u32) -> usize {
    let far = |mask: u32| ((mask ^ clipped).count_ones(), std::cmp::Reverse(mask.count_ones()));
    (0..saturations.len()).min_by_key(|&i| far(saturations[i])).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::l3::Levels;
    use crate::sensor::{Mosaic, SignalNoise};

    const OUTPUTS: usize = 2;
    const TAPS: usize = 9;

    /// Four positions, three combinations of clipped channels, five levels and two textures. Weights are numbered.
    fn parts() -> PipelineParts {
        let mosaic = Mosaic::new(2, 2, vec![0, 1, 1, 2]).unwrap();
        let levels = Levels::logarithmic(5, 0.02, 0.8).unwrap();
        let classes = 4 * 3 * 5 * 2;
        PipelineParts {
            axes: Axes::new(mosaic, 3, levels, SignalNoise::default()).unwrap(),
            saturations: vec![0, 1, 5],
            outputs: ["a", "b"].map(String::from).to_vec(),
            channel_names: ["R", "G", "B"].map(String::from).to_vec(),
            black_level: 64.0,
            white_level: 1023.0,
            trained: vec![[0.0, 1.0]; 4],
            classes: vec![Class { count: 1, origin: Origin::Learned }; classes],
            kernels: Kernels {
                weights: (0..classes * OUTPUTS * TAPS).map(|i| i as f32).collect(),
                offsets: vec![0.0; classes * OUTPUTS],
            },
            provenance: String::new(),
        }
    }

    #[test]
    fn every_class_has_one_index_and_one_key() {
        let p = Pipeline::from_parts(parts()).unwrap();
        let mut last = None;
        for index in 0..p.classes().len() {
            let key = p.key(index);
            let saturation = p.saturation_place(key.saturation);
            let place = [key.position as usize, saturation, usize::from(key.level), usize::from(key.texture)];
            let [position, saturation, level, texture] = place;
            assert_eq!(p.index(position, saturation, level, texture), index, "{key:?}");
            assert!(position < 4 && saturation < 3 && level < 5 && texture < 2, "{key:?}");
            // Position varies slowest, texture fastest.
            assert!(last < Some(place), "{key:?}");
            last = Some(place);
        }
    }

    #[test]
    fn weights_lie_in_the_order_class_output_tap() {
        let p = Pipeline::from_parts(parts()).unwrap();
        let mut all = Vec::new();
        for class in 0..p.classes().len() {
            (0..OUTPUTS).for_each(|output| all.extend_from_slice(p.weights(class, output).unwrap()));
        }
        assert_eq!(all, p.kernels().weights);
        assert_eq!((p.weights(p.classes().len(), 0), p.weights(0, OUTPUTS)), (None, None));
    }

    #[test]
    fn the_nearest_combination_stands_for_one_that_is_not_there() {
        let p = Pipeline::from_parts(parts()).unwrap();
        // Red alone and red with blue are on the axis.
        for (clipped, place) in [(0, 0), (1, 1), (5, 2), (2, 0), (3, 1), (7, 2), (4, 2)] {
            assert_eq!(p.saturation_place(clipped), place, "{clipped:b}");
        }
    }

    #[test]
    fn parts_that_do_not_fit_are_refused() {
        let changes: [fn(&mut PipelineParts); 15] = [
            |p| p.saturations = vec![1, 2, 3],
            |p| p.saturations = vec![0, 5, 5],
            |p| p.saturations = vec![0, 1, 8],
            |p| p.outputs.clear(),
            |p| p.channel_names.truncate(2),
            |p| p.white_level = p.black_level,
            |p| p.black_level = f64::NAN,
            |p| p.trained.truncate(3),
            |p| p.trained[3][1] = f32::NAN,
            |p| p.classes.truncate(119),
            |p| p.kernels.weights.push(0.0),
            |p| p.kernels.offsets.push(0.0),
            |p| p.kernels.weights[7] = f32::INFINITY,
            |p| p.kernels.offsets[7] = f32::NAN,
            |p| p.saturations = vec![0, 1],
        ];
        for (i, change) in changes.into_iter().enumerate() {
            let mut parts = parts();
            change(&mut parts);
            assert!(matches!(Pipeline::from_parts(parts), Err(L3Error::Table(_))), "{i}");
        }
    }

    #[test]
    fn codes_of_origins_are_their_places() {
        for (code, origin) in (0..).zip(Origin::ALL) {
            assert_eq!((Origin::from_code(code), origin as u8), (Some(origin), code));
        }
        assert_eq!(Origin::from_code(Origin::ALL.len() as u8), None);
    }
}
