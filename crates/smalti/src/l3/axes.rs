//! How patches are put into classes.

use serde::{Deserialize, Serialize};

use super::error::within;
use super::lattice::{self, ContrastPairs};
use super::{L3Error, Levels};
use crate::sensor::{Mosaic, SignalNoise};

/// Largest side of a patch.
pub const MAX_SIDE: usize = 11;
/// Most channels whose saturation can be told apart.
const MAX_CHANNELS: usize = 32;
/// How many times the mean difference that noise alone makes a patch must show to be texture. Of the differences in a
/// patch of 5 × 5, the mean under noise spreads by a fifth around its expectation; three times that is rarely passed.
const TEXTURE_OVER_NOISE: f64 = 1.6;
/// What counts as flat without any noise: mean differences below this share of the response, about the contrast
/// that an eye just sees.
const FLAT_FRACTION: f64 = 0.02;

/// What is told apart by the structure within a patch.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Textures {
    /// Nothing.
    None,
    /// Flat patches and others.
    #[default]
    FlatTexture,
    /// Flat patches, texture without a direction, and edges in four directions by the structure tensor, as RAISR does
    /// ([romano2017]). The direction is that along which the patch changes: across (0°), 45°, down (90°), 135°.
    ///
    /// [romano2017]: https://doi.org/10.1109/TCI.2016.2629284
    Oriented,
}

impl Textures {
    /// How coherent the structure tensor of an edge is at least: (λ₁ − λ₂) / (λ₁ + λ₂) of its eigenvalues.
    pub const EDGE_COHERENCE: f64 = 0.5;

    /// Number of kinds.
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

/// The class of a patch, by its axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ClassKey {
    /// Cell of the tile at the centre of the patch, in row order.
    pub position: u32,
    /// Bit `c` is set when channel `c` is clipped somewhere in the patch.
    pub saturation: u32,
    /// Level of the mean response.
    pub level: u16,
    /// Kind of structure.
    pub texture: u16,
}

/// How patches are put into classes: position in the tile × saturated channels × level × texture.
#[derive(Debug, Clone, PartialEq)]
pub struct Axes {
    mosaic: Mosaic,
    side: usize,
    levels: Vec<Levels>,
    textures: Textures,
    noise: SignalNoise,
    /// Normalised response from which a sample counts as clipped.
    clip: f64,
    texture_over_noise: f64,
    flat_fraction: f64,
}

impl Axes {
    /// Axes for patches of `side` × `side` pixels (odd, 3 to 11) with levels that are the same at every position, flat and
    /// texture by contrast.
    ///
    /// # Errors
    /// When the side is impossible or the mosaic has more than 32 channels.
    pub fn new(mosaic: Mosaic, side: usize, levels: Levels, noise: SignalNoise) -> Result<Self, L3Error> {
        let expected = "3, 5, 7, 9 or 11";
        within("the side of a patch", side as f64, 3.0..=MAX_SIDE as f64, expected)?;
        if side.is_multiple_of(2) {
            return Err(L3Error::Parameter { name: "the side of a patch", value: side as f64, expected });
        }
        within("the number of channels", mosaic.channels() as f64, 1.0..=MAX_CHANNELS as f64, "1 to 32")?;
        let parts = [noise.constant, noise.per_signal, noise.per_signal_squared, noise.row, noise.column];
        for value in parts {
            within("a variance of the noise", value, 0.0..=1e6, "0 or more, finite")?;
        }
        // Noise that is added after a full well spreads the samples of saturated pixels below the white level.
        let clip = 1.0 - (4.0 * noise.variance(0.0).sqrt()).clamp(1e-5, 0.05);
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

    /// The same with cut points of each position's own: those of the axes times the mean response of the position's patch
    /// to white over that of a whole tile, so that a level is the same light at every position. `white` is the response of
    /// each channel to white.
    ///
    /// # Errors
    /// When there is not one positive response for each channel.
    pub fn with_levels_by_position(self, white: &[f64]) -> Result<Self, L3Error> {
        if white.len() != self.mosaic.channels() || white.iter().any(|w| !(*w > 0.0 && w.is_finite())) {
            let reason = format!("expected {} positive responses to white", self.mosaic.channels());
            return Err(L3Error::Levels { reason });
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

    /// The same with what is told apart by structure.
    #[must_use]
    pub fn with_textures(self, textures: Textures) -> Self {
        Self { textures, ..self }
    }

    /// The same with other thresholds: a patch is texture when the mean difference between its samples of like channels
    /// is above `over_noise` times what noise alone makes, and above `flat_fraction` of the response. (The two are added
    /// as squares.)
    ///
    /// # Errors
    /// When one is negative or not finite.
    pub fn with_contrast(self, over_noise: f64, flat_fraction: f64) -> Result<Self, L3Error> {
        within("contrast over noise", over_noise, 0.0..=1e3, "0 to 1000")?;
        within("the contrast that is flat", flat_fraction, 0.0..=1e3, "0 to 1000")?;
        Ok(Self { texture_over_noise: over_noise, flat_fraction, ..self })
    }

    /// The same with another normalised response from which samples count as clipped.
    ///
    /// # Errors
    /// When it is not above 0 and at most 1.
    pub fn with_clip(self, clip: f64) -> Result<Self, L3Error> {
        within("the response that is clipped", clip, 1e-3..=1.0, "0.001 to 1")?;
        Ok(Self { clip, ..self })
    }

    /// The same with cut points given for every position of the tile.
    ///
    /// # Errors
    /// When there is neither one set nor one for each position, or their numbers differ.
    pub fn with_levels(self, levels: Vec<Levels>) -> Result<Self, L3Error> {
        let positions = self.positions();
        let Some(first) = levels.first() else { return Err(L3Error::EmptyAxis { axis: "level" }) };
        if levels.len() != 1 && levels.len() != positions {
            let reason = format!("{} sets; 1 or {positions} expected, one for each position", levels.len());
            return Err(L3Error::Levels { reason });
        }
        if levels.iter().any(|l| l.count() != first.count()) {
            return Err(L3Error::Levels { reason: "every position needs as many".into() });
        }
        Ok(Self { levels, ..self })
    }

    /// The tile, its first cell at the top left pixel of raw images.
    #[must_use]
    pub fn mosaic(&self) -> &Mosaic {
        &self.mosaic
    }

    /// Side of the patch, pixels, odd.
    #[must_use]
    pub fn side(&self) -> usize {
        self.side
    }

    /// Pixels of the patch.
    #[must_use]
    pub fn taps(&self) -> usize {
        self.side * self.side
    }

    /// Cells of the tile.
    #[must_use]
    pub fn positions(&self) -> usize {
        self.mosaic.cells().len()
    }

    /// Cut points at a position.
    #[must_use]
    pub fn levels_at(&self, position: usize) -> &Levels {
        &self.levels[if self.levels.len() == 1 { 0 } else { position % self.levels.len() }]
    }

    /// Cut points, one set for all positions or one for each.
    #[must_use]
    pub fn levels(&self) -> &[Levels] {
        &self.levels
    }

    /// Number of levels.
    #[must_use]
    pub fn level_count(&self) -> usize {
        self.levels[0].count()
    }

    /// What is told apart by structure.
    #[must_use]
    pub fn textures(&self) -> Textures {
        self.textures
    }

    /// The noise that contrast is held against, and that training adds.
    #[must_use]
    pub fn noise(&self) -> &SignalNoise {
        &self.noise
    }

    /// Normalised response from which a sample counts as clipped.
    #[must_use]
    pub fn clip(&self) -> f64 {
        self.clip
    }

    /// Thresholds of contrast: over noise, and as a share of the response.
    #[must_use]
    pub fn contrast(&self) -> (f64, f64) {
        (self.texture_over_noise, self.flat_fraction)
    }

    /// The pairs of samples whose mean difference is the contrast of a patch: along the two shortest shifts that take the
    /// mosaic to itself.
    #[must_use]
    pub fn contrast_pairs(&self) -> [ContrastPairs; 2] {
        lattice::basis(&self.mosaic).map(|shift| ContrastPairs::new(shift, self.side / 2))
    }

    /// Coefficients v of the contrast that is still flat: a patch of mean response x (0 where negative) is texture when the
    /// square of its mean absolute difference is above `v[0] + v[1] x + v[2] x²`.
    #[must_use]
    pub fn contrast_limit(&self) -> [f64; 3] {
        let n = &self.noise;
        // Of the difference of two normal numbers of variance σ² the mean size is 2σ / √π.
        let scale = self.texture_over_noise.powi(2) * 4.0 / std::f64::consts::PI;
        let [v0, v1, v2] =
            [n.constant + n.row + n.column, n.per_signal, n.per_signal_squared].map(|v| v * scale);
        [v0, v1, v2 + self.flat_fraction.powi(2)]
    }

    /// The channel that a tap (row order) of the patch around a position sees.
    #[must_use]
    pub fn channel_of(&self, position: usize, tap: usize) -> usize {
        let (half, m) = (self.side / 2, &self.mosaic);
        // Adding whole tiles keeps the difference above zero.
        let row = position / m.cols() + tap / self.side + m.rows() * half - half;
        let col = position % m.cols() + tap % self.side + m.cols() * half - half;
        m.channel_at(row, col)
    }
}
