//! The learned table: classes and their kernels.

use super::{Axes, ClassKey, L3Error};

/// Where the kernels of a class come from, in the order in which they are looked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Origin {
    /// Learned from patches of the class itself (and of those that symmetry makes equal).
    Learned = 0,
    /// Too few patches: between those of the nearest levels on both sides.
    Interpolated = 1,
    /// Learned from all textures of the level together.
    PooledTextures = 2,
    /// Learned from all combinations of saturated channels at the level together.
    PooledSaturations = 3,
    /// Those of the nearest level that has any.
    NearestLevel = 4,
    /// Learned from all patches of the position together.
    PooledLevels = 5,
}

impl Origin {
    /// All, in order.
    pub const ALL: [Self; 6] = [
        Self::Learned,
        Self::Interpolated,
        Self::PooledTextures,
        Self::PooledSaturations,
        Self::NearestLevel,
        Self::PooledLevels,
    ];

    /// From its number.
    #[must_use]
    pub fn from_code(code: u8) -> Option<Self> {
        Self::ALL.get(usize::from(code)).copied()
    }

    /// What it is called in reports.
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

/// A class and where its kernels come from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Class {
    /// Patches that were seen of it.
    pub count: u64,
    /// Where its kernels come from.
    pub origin: Origin,
}

/// The kernels of every class: for each class and output, a weight per tap of the patch (row order) and an offset.
#[derive(Debug, Clone, PartialEq)]
pub struct Kernels {
    /// Weights, ordered class, output, tap: output = offset + Σ weight · normalised sample.
    pub weights: Vec<f32>,
    /// Offsets, ordered class, output.
    pub offsets: Vec<f32>,
}

/// What a pipeline is made of.
#[derive(Debug, Clone, PartialEq)]
pub struct Pipeline {
    axes: Axes,
    saturations: Vec<u32>,
    outputs: Vec<String>,
    channel_names: Vec<String>,
    black_level: f64,
    white_level: f64,
    trained: Vec<[f32; 2]>,
    classes: Vec<Class>,
    kernels: Kernels,
    provenance: String,
    white: Option<[f64; 3]>,
}

/// The parts of a [`Pipeline`].
#[derive(Debug, Clone, PartialEq)]
pub struct PipelineParts {
    /// How patches are classified.
    pub axes: Axes,
    /// Combinations of saturated channels that are told apart, bit `c` for channel `c`, ascending, beginning with 0.
    pub saturations: Vec<u32>,
    /// Names of the outputs, `X`, `Y`, `Z` for a picture.
    pub outputs: Vec<String>,
    /// Names of the mosaic's channels.
    pub channel_names: Vec<String>,
    /// Black level of the raw images it is for, digital numbers.
    pub black_level: f64,
    /// White level of the raw images it is for, digital numbers.
    pub white_level: f64,
    /// Least and largest mean response that was trained with, for each position.
    pub trained: Vec<[f32; 2]>,
    /// The classes, position slowest, then saturation, level, texture.
    pub classes: Vec<Class>,
    /// Their kernels.
    pub kernels: Kernels,
    /// How it was trained, as JSON.
    pub provenance: String,
}

impl Pipeline {
    /// A pipeline from its parts.
    ///
    /// # Errors
    /// [`L3Error::Table`] says what does not fit.
    pub fn from_parts(parts: PipelineParts) -> Result<Self, L3Error> {
        let PipelineParts {
            axes,
            saturations,
            outputs,
            channel_names,
            black_level,
            white_level,
            trained,
            classes,
            kernels,
            provenance,
        } = parts;
        let wrong = |reason: String| Err(L3Error::Table { reason });
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
        if channel_names.len() != axes.mosaic().channels() {
            return wrong(format!(
                "{} channel names for {} channels",
                channel_names.len(),
                axes.mosaic().channels()
            ));
        }
        if !(black_level.is_finite() && white_level.is_finite() && white_level > black_level) {
            return wrong(format!("white level {white_level} must lie above black level {black_level}"));
        }
        if trained.len() != axes.positions() || trained.iter().flatten().any(|v| v.is_nan()) {
            return wrong(format!("{} trained ranges for {} positions", trained.len(), axes.positions()));
        }
        let count = axes.positions() * saturations.len() * axes.level_count() * axes.textures().count();
        let sizes = [
            ("classes", classes.len(), count),
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
        Ok(Self {
            axes,
            saturations,
            outputs,
            channel_names,
            black_level,
            white_level,
            trained,
            classes,
            kernels,
            provenance,
            white: None,
        })
    }

    /// How patches are classified.
    #[must_use]
    pub fn axes(&self) -> &Axes {
        &self.axes
    }

    /// Combinations of saturated channels that are told apart, ascending, the first 0.
    #[must_use]
    pub fn saturations(&self) -> &[u32] {
        &self.saturations
    }

    /// Names of the outputs.
    #[must_use]
    pub fn outputs(&self) -> &[String] {
        &self.outputs
    }

    /// Names of the mosaic's channels.
    #[must_use]
    pub fn channel_names(&self) -> &[String] {
        &self.channel_names
    }

    /// Black level of the raw images it is for.
    #[must_use]
    pub fn black_level(&self) -> f64 {
        self.black_level
    }

    /// White level of the raw images it is for.
    #[must_use]
    pub fn white_level(&self) -> f64 {
        self.white_level
    }

    /// Least and largest mean response that was trained with, for each position.
    #[must_use]
    pub fn trained(&self) -> &[[f32; 2]] {
        &self.trained
    }

    /// The same with what it gives for white: X, Y, Z of a perfect diffuser in the light that pictures are made for, Y = 1. It
    /// tells how to show them; rendering does not use it.
    #[must_use]
    pub fn with_white(self, white: Option<[f64; 3]>) -> Self {
        Self { white, ..self }
    }

    /// X, Y, Z of white, Y = 1, where the outputs are X, Y, Z and white is known.
    #[must_use]
    pub fn white(&self) -> Option<[f64; 3]> {
        self.white
    }

    /// How it was trained, as JSON.
    #[must_use]
    pub fn provenance(&self) -> &str {
        &self.provenance
    }

    /// The classes, position slowest, then saturation, level, texture.
    #[must_use]
    pub fn classes(&self) -> &[Class] {
        &self.classes
    }

    /// The kernels of all classes.
    #[must_use]
    pub fn kernels(&self) -> &Kernels {
        &self.kernels
    }

    /// The weights of a class for an output, in the order of the patch's rows. Empty when there is none such.
    #[must_use]
    pub fn weights(&self, class: usize, output: usize) -> &[f32] {
        let taps = self.axes.taps();
        let at = (class * self.outputs.len() + output) * taps;
        self.kernels.weights.get(at..at + taps).unwrap_or(&[])
    }

    /// The index of a class by the places of its coordinates on the axes.
    #[must_use]
    pub fn index(&self, position: usize, saturation: usize, level: usize, texture: usize) -> usize {
        let textures = self.axes.textures().count();
        ((position * self.saturations.len() + saturation) * self.axes.level_count() + level) * textures
            + texture
    }

    /// The class of an index.
    #[must_use]
    pub fn key(&self, index: usize) -> ClassKey {
        let (textures, levels) = (self.axes.textures().count(), self.axes.level_count());
        let saturation = index / (textures * levels) % self.saturations.len();
        ClassKey {
            position: (index / (textures * levels * self.saturations.len())) as u32,
            saturation: self.saturations[saturation],
            level: (index / textures % levels) as u16,
            texture: (index % textures) as u16,
        }
    }

    /// The place on the saturation axis of a combination of clipped channels: itself, or the one that differs in
    /// the fewest channels; of those the one with more channels clipped.
    #[must_use]
    pub fn saturation_place(&self, clipped: u32) -> usize {
        nearest_saturation(&self.saturations, clipped)
    }
}

/// The place of a combination of clipped channels, or of the one nearest to it: see [`Pipeline::saturation_place`].
pub(super) fn nearest_saturation(saturations: &[u32], clipped: u32) -> usize {
    let far = |mask: u32| ((mask ^ clipped).count_ones(), std::cmp::Reverse(mask.count_ones()));
    (0..saturations.len()).min_by_key(|&i| far(saturations[i])).unwrap_or(0)
}
