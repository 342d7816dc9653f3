//! The class axes of patches.

use serde::{Deserialize, Serialize};

use super::error::within;
use super::lattice::{self, ContrastPairs};
use super::{L3Error, Levels};
use crate::sensor::{Mosaic, SignalNoise};

/// Maximum side of a patch.
pub const MAX_SIDE: usize = 11;
/// Maximum number of channels, one bit each in the saturation axis.
const MAX_CHANNELS: usize = 32;
/// Ratio of a patch's mean difference to the value expected from noise alone, above which the patch is
/// texture. In a patch of 5 × 5 pixels, the mean difference under noise has a standard deviation of a fifth
/// of its expectation, so noise rarely exceeds three standard deviations.
const TEXTURE_OVER_NOISE: f64 = 1.6;
/// Contrast of a flat patch without noise: mean differences below this fraction of the response, which is
/// about the contrast threshold of the eye.
const FLAT_FRACTION: f64 = 0.02;

/// Texture classes: the structure within a patch.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Textures {
    /// One class for all patches.
    None,
    /// Two classes: flat patches and texture.
    #[default]
    FlatTexture,
    /// Six classes: flat patches, texture without a dominant orientation, and edges in four orientations from
    /// the structure tensor, as in RAISR ([romano2017]). The orientation is that of the gradient: horizontal
    /// (0°), 45°, vertical (90°), 135°.
    ///
    /// [romano2017]: https://doi.org/10.1109/TCI.2016.2629284
    Oriented,
}

impl Textures {
    /// Minimum coherence of the structure tensor for an edge: (λ₁ − λ₂) / (λ₁ + λ₂) of its eigenvalues.
    pub const EDGE_COHERENCE: f64 = 0.5;

    /// Number of texture classes.
    #[must_use]
    pub fn count(self) -> usize {
        self.names().len()
    }

    /// Their names, in order.
    #[must_use]
    pub fn names(self) -> &'static [&'static str] {
        match self {
            Self::None => &["any"],
            Self::FlatTexture => &["flat", "texture"],
            Self::Oriented => &["flat", "texture", "edge 0°", "edge 45°", "edge 90°", "edge 135°"],
        }
    }
}

/// The class of a patch: its coordinates on the class axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ClassKey {
    /// Cell of the mosaic's tile at the centre of the patch, in row order.
    pub position: u32,
    /// Bit `c` is set when a sample of channel `c` in the patch is clipped.
    pub saturation: u32,
    /// Response level: the interval of the mean response.
    pub level: u16,
    /// Texture class.
    pub texture: u16,
}

/// The class axes: position in the tile × saturated channels × response level × texture.
#[derive(Debug, Clone, PartialEq)]
pub struct Axes {
    mosaic: Mosaic,
    side: usize,
    levels: Vec<Levels>,
    textures: Textures,
    noise: SignalNoise,
    /// Normalised response above which a sample counts as clipped.
    clip: f64,
    texture_over_noise: f64,
    flat_fraction: f64,
}

impl Axes {
    /// Axes for patches of `side` × `side` pixels (odd, 3 to 11), with the same response levels at every
    /// position and the texture classes flat and texture.
    ///
    /// # Errors
    /// When the side is not allowed or the mosaic has more than 32 channels.
    pub fn new(mosaic: Mosaic, side: usize, levels: Levels, noise: SignalNoise) -> Result<Self, L3Error> {
        let expected = "3, 5, 7, 9 or 11";
        within("the side of a patch", side as f64, 3.0..=MAX_SIDE as f64, expected)?;
        if side.is_multiple_of(2) {
            return Err(L3Error::Parameter { name: "the side of a patch", value: side as f64, expected });
        }
        within("the number of channels", mosaic.channels() as f64, 1.0..=MAX_CHANNELS as f64, "1 to 32")?;
        let parts = [noise.constant, noise.per_signal, noise.per_signal_squared, noise.row, noise.column];
        let above = noise.above.map(|above| [above.constant, 1.0 / above.signal]);
        for value in parts.into_iter().chain(above.into_iter().flatten()) {
            within("a variance of the noise", value, 0.0..=1e6, "0 or more, finite")?;
        }
        // Noise that is added after the full well spreads the samples of saturated pixels below the white
        // level.
        let clip = 1.0 - (4.0 * noise.additive_at_saturation().sqrt()).clamp(1e-5, 0.05);
        Ok(Self {
            mosaic,
            side,
            levels: vec![levels],
            textures: Textures::default(),
            noise,
            clip,
            texture_over_noise: TEXTURE_OVER_NOISE,
            flat_fraction: FLAT_FRACTION,
        })
    }

    /// Axes with cut points per position: those of the given axes times the ratio of the mean white response
    /// of the patch at that position to that of a whole tile. A level then corresponds to the same
    /// illuminance at every position. `white` is the response of each channel to white.
    ///
    /// # Errors
    /// When there is not exactly one positive response per channel.
    pub fn with_levels_by_position(self, white: &[f64]) -> Result<Self, L3Error> {
        if white.len() != self.mosaic.channels() || white.iter().any(|w| !(*w > 0.0 && w.is_finite())) {
            let reason = format!("expected {} positive responses to white", self.mosaic.channels());
            return Err(L3Error::Levels(reason));
        }
        let cells = self.mosaic.cells();
        let tile = cells.iter().map(|&c| white[usize::from(c)]).sum::<f64>() / cells.len() as f64;
        let levels = (0..cells.len())
            .map(|position| {
                let patch = (0..self.taps()).map(|tap| white[self.channel_of(position, tap)]).sum::<f64>();
                let ratio = patch / self.taps() as f64 / tile;
                let base = self.levels[0].cuts();
                Levels::new(base.iter().map(|&c| (f64::from(c) * ratio) as f32).collect())
            })
            .collect::<Result<_, _>>()?;
        Ok(Self { levels, ..self })
    }

    /// Axes with other texture classes.
    #[must_use]
    pub fn with_textures(self, textures: Textures) -> Self {
        Self { textures, ..self }
    }

    /// Axes with other contrast thresholds. A patch is texture when the mean difference between its samples
    /// of equal channels exceeds the root sum of squares of two terms: `over_noise` times the expectation
    /// under noise alone, and `flat_fraction` times the response.
    ///
    /// # Errors
    /// When a threshold is negative or not finite.
    pub fn with_contrast(self, over_noise: f64, flat_fraction: f64) -> Result<Self, L3Error> {
        within("contrast over noise", over_noise, 0.0..=1e3, "0 to 1000")?;
        within("the contrast that is flat", flat_fraction, 0.0..=1e3, "0 to 1000")?;
        Ok(Self { texture_over_noise: over_noise, flat_fraction, ..self })
    }

    /// Axes with another clipping threshold, as a normalised response.
    ///
    /// # Errors
    /// When the threshold is not above 0 and at most 1.
    pub fn with_clip(self, clip: f64) -> Result<Self, L3Error> {
        within("the response that is clipped", clip, 1e-3..=1.0, "0.001 to 1")?;
        Ok(Self { clip, ..self })
    }

    /// Axes with given cut points for every position of the tile.
    ///
    /// # Errors
    /// When there is neither one set nor one per position, or the sets differ in length.
    pub fn with_levels(self, levels: Vec<Levels>) -> Result<Self, L3Error> {
        let positions = self.positions();
        let Some(first) = levels.first() else { return Err(L3Error::EmptyAxis("level")) };
        if levels.len() != 1 && levels.len() != positions {
            let reason = format!("{} sets; 1 or {positions} expected, one for each position", levels.len());
            return Err(L3Error::Levels(reason));
        }
        if levels.iter().any(|l| l.count() != first.count()) {
            return Err(L3Error::Levels("every position needs as many".into()));
        }
        Ok(Self { levels, ..self })
    }

    /// The tile of the mosaic; its first cell is at the top left pixel of the raw image.
    #[must_use]
    pub fn mosaic(&self) -> &Mosaic {
        &self.mosaic
    }

    /// Side of the patch in pixels, odd.
    #[must_use]
    pub fn side(&self) -> usize {
        self.side
    }

    /// Number of pixels of the patch.
    #[must_use]
    pub fn taps(&self) -> usize {
        self.side * self.side
    }

    /// Number of cells of the tile.
    #[must_use]
    pub fn positions(&self) -> usize {
        self.mosaic.cells().len()
    }

    /// Cut points at a position.
    #[must_use]
    pub fn levels_at(&self, position: usize) -> &Levels {
        &self.levels[if self.levels.len() == 1 { 0 } else { position % self.levels.len() }]
    }

    /// Cut points: one set for all positions, or one per position.
    #[must_use]
    pub fn levels(&self) -> &[Levels] {
        &self.levels
    }

    /// Number of response levels.
    #[must_use]
    pub fn level_count(&self) -> usize {
        self.levels[0].count()
    }

    /// The texture classes.
    #[must_use]
    pub fn textures(&self) -> Textures {
        self.textures
    }

    /// The noise model, for the contrast threshold and for training.
    #[must_use]
    pub fn noise(&self) -> &SignalNoise {
        &self.noise
    }

    /// Normalised response above which a sample counts as clipped.
    #[must_use]
    pub fn clip(&self) -> f64 {
        self.clip
    }

    /// Contrast thresholds: relative to noise, and as a fraction of the response.
    #[must_use]
    pub fn contrast(&self) -> (f64, f64) {
        (self.texture_over_noise, self.flat_fraction)
    }

    /// The sample pairs whose mean difference is the contrast of a patch. They lie along the two shortest
    /// translations that map the mosaic onto itself.
    #[must_use]
    pub fn contrast_pairs(&self) -> [ContrastPairs; 2] {
        lattice::basis(&self.mosaic).map(|shift| ContrastPairs::new(shift, self.side / 2))
    }

    /// Coefficients v of the contrast threshold. A patch with a mean response x (0 if negative) is texture
    /// when the square of its mean absolute difference exceeds `v[0] + v[1] x + v[2] x²`.
    #[must_use]
    pub fn contrast_limit(&self) -> [f64; 3] {
        let n = &self.noise;
        // The mean absolute difference of two normal deviates with variance σ² is 2σ / √π.
        let scale = self.texture_over_noise.powi(2) * 4.0 / std::f64::consts::PI;
        let [v0, v1, v2] = [n.constant + n.row + n.column, n.per_signal, n.quadratic()].map(|v| v * scale);
        [v0, v1, v2 + self.flat_fraction.powi(2)]
    }

    /// The same for the square of the sum of the absolute differences, in single precision, with which [`super::Pipeline::render_raw`] computes.
    #[must_use]
    pub fn summed_contrast_limit(&self) -> [f32; 3] {
        let count = self.contrast_pairs().iter().map(ContrastPairs::count).sum::<usize>() as f32;
        let noise = &self.noise;
        // As in `contrast_limit`.
        let over_noise = self.texture_over_noise * self.texture_over_noise;
        let scale = (over_noise * 4.0 / std::f64::consts::PI) as f32 * count * count;
        let [v0, v1] =
            [noise.constant + noise.row + noise.column, noise.per_signal].map(|v| v as f32 * scale);
        let flat = self.flat_fraction * self.flat_fraction;
        [v0, v1, noise.quadratic() as f32 * scale + flat as f32 * count * count]
    }

    /// The channel of a tap (row order) of the patch around a position.
    #[must_use]
    pub fn channel_of(&self, position: usize, tap: usize) -> usize {
        let (half, m) = (self.side / 2, &self.mosaic);
        // Adding whole tiles keeps the value non-negative.
        let row = position / m.cols() + tap / self.side + m.rows() * half - half;
        let col = position % m.cols() + tap % self.side + m.cols() * half - half;
        m.channel_at(row, col)
    }
}
