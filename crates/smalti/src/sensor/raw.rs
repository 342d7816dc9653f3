//! Raw images, simulated or from a real camera.

use thiserror::Error;

use super::Mosaic;
use crate::numeric::ShapeError;

/// Errors of a raw image.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum RawError {
    /// The number of samples does not match the size.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// The white level is not above the black level.
    #[error("white level {white} must lie above black level {black}, both finite")]
    Levels {
        /// Black level, digital numbers.
        black: f64,
        /// White level, digital numbers.
        white: f64,
    },
    /// The number of names differs from the number of channels.
    #[error("expected {expected} channel names, got {got}")]
    Names {
        /// Channels.
        expected: usize,
        /// Names given.
        got: usize,
    },
}

/// The samples of a raw image.
#[derive(Debug, Clone, PartialEq)]
pub enum RawSamples {
    /// Digital numbers of a converter of at most 16 bits.
    Digital(Vec<u16>),
    /// Volts at the pixel output, without a converter (`adc_bits = 0`).
    Analog(Vec<f32>),
}

impl RawSamples {
    /// Number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        match self {
            Self::Digital(v) => v.len(),
            Self::Analog(v) => v.len(),
        }
    }

    /// Whether there are no samples.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// The channels that each pixel samples.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Sampling {
    /// One channel per pixel: a colour filter array.
    Mosaic(Mosaic),
    /// Every channel at every pixel, one plane per channel: a prism with one sensor per channel, or
    /// sequential captures.
    Full {
        /// Number of channels.
        channels: usize,
    },
}

impl Sampling {
    /// Number of channels.
    #[must_use]
    pub fn channels(&self) -> usize {
        match self {
            Self::Mosaic(m) => m.channels(),
            Self::Full { channels } => *channels,
        }
    }

    /// Number of planes of samples.
    #[must_use]
    pub fn planes(&self) -> usize {
        match self {
            Self::Mosaic(_) => 1,
            Self::Full { channels } => *channels,
        }
    }
}

/// Raw samples with their interpretation.
#[derive(Debug, Clone, PartialEq)]
pub struct RawImage {
    rows: usize,
    cols: usize,
    samples: RawSamples,
    sampling: Sampling,
    channel_names: Vec<String>,
    black_level: f64,
    white_level: f64,
}

impl RawImage {
    /// A raw image from its parts, with samples ordered plane, row, column. `black_level` is the sample
    /// without light, `white_level` that at saturation, both in the unit of the samples.
    ///
    /// # Errors
    /// When sizes do not match, or the white level is not above the black level.
    pub fn new(
        rows: usize,
        cols: usize,
        samples: RawSamples,
        sampling: Sampling,
        channel_names: Vec<String>,
        black_level: f64,
        white_level: f64,
    ) -> Result<Self, RawError> {
        let count = sampling.planes();
        let expected = rows.checked_mul(cols).and_then(|n| n.checked_mul(count)).unwrap_or(usize::MAX);
        if samples.len() != expected || expected == 0 {
            return Err(ShapeError { count, rows, cols, expected, got: samples.len() }.into());
        }
        if channel_names.len() != sampling.channels() {
            return Err(RawError::Names { expected: sampling.channels(), got: channel_names.len() });
        }
        if !(black_level.is_finite() && white_level.is_finite() && white_level > black_level) {
            return Err(RawError::Levels { black: black_level, white: white_level });
        }
        Ok(Self { rows, cols, samples, sampling, channel_names, black_level, white_level })
    }

    /// Rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Columns.
    #[must_use]
    pub fn cols(&self) -> usize {
        self.cols
    }

    /// The samples, ordered plane, row, column.
    #[must_use]
    pub fn samples(&self) -> &RawSamples {
        &self.samples
    }

    /// The channels that each pixel samples.
    #[must_use]
    pub fn sampling(&self) -> &Sampling {
        &self.sampling
    }

    /// Names of the channels.
    #[must_use]
    pub fn channel_names(&self) -> &[String] {
        &self.channel_names
    }

    /// Black level: the sample without light.
    #[must_use]
    pub fn black_level(&self) -> f64 {
        self.black_level
    }

    /// White level: the sample at saturation.
    #[must_use]
    pub fn white_level(&self) -> f64 {
        self.white_level
    }

    /// The image with its channels in the order of `names`; unchanged where these are not the names of its
    /// channels. A clear channel is called W by some and C by others: W is taken for C, and C for W, where only one of
    /// the two occurs on each side.
    #[must_use]
    pub fn with_channels(self, names: &[String]) -> Self {
        let find = |wanted: &str| names.iter().position(|n| n == wanted);
        let has = |wanted: &str| self.channel_names.iter().any(|n| n == wanted);
        let place = |name: &String| {
            find(name).or_else(|| match name.as_str() {
                "W" if !has("C") => find("C"),
                "C" if !has("W") => find("W"),
                _ => None,
            })
        };
        let places: Option<Vec<usize>> = self.channel_names.iter().map(place).collect();
        let (Some(places), Sampling::Mosaic(mosaic)) = (places, &self.sampling) else { return self };
        let cells = mosaic.cells().iter().map(|&c| places[usize::from(c)] as u8).collect();
        match Mosaic::new(mosaic.rows(), mosaic.cols(), cells) {
            Ok(mosaic) if names.len() == self.channel_names.len() && mosaic.channels() == names.len() => {
                Self { sampling: Sampling::Mosaic(mosaic), channel_names: names.to_vec(), ..self }
            }
            _ => self,
        }
    }

    /// Percentage of samples at or above the white level.
    #[must_use]
    pub fn saturated_percent(&self) -> f64 {
        let white = self.white_level;
        let count = match &self.samples {
            RawSamples::Digital(v) => v.iter().filter(|&&x| f64::from(x) >= white).count(),
            RawSamples::Analog(v) => v.iter().filter(|&&x| x >= white as f32).count(),
        };
        100.0 * count as f64 / self.samples.len() as f64
    }

    /// All samples as `(value − black) / (white − black)`; noise can make them negative.
    #[must_use]
    pub fn normalized(&self) -> Vec<f32> {
        let gain = 1.0 / (self.white_level - self.black_level);
        let (gain, black) = (gain as f32, self.black_level as f32);
        match &self.samples {
            RawSamples::Digital(v) => v.iter().map(|&x| (f32::from(x) - black) * gain).collect(),
            RawSamples::Analog(v) => v.iter().map(|&x| (x - black) * gain).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channels_are_reordered_only_to_names_of_as_many() {
        let names = |all: &str| all.chars().map(String::from).collect::<Vec<_>>();
        let mosaic = Mosaic::new(2, 2, vec![0, 1, 1, 2]).unwrap();
        let samples = RawSamples::Analog(vec![0.1, 0.2, 0.3, 0.4]);
        let raw = RawImage::new(2, 2, samples, Sampling::Mosaic(mosaic), names("RGB"), 0.0, 1.0).unwrap();
        let reordered = raw.clone().with_channels(&names("BGR"));
        assert_eq!(reordered.channel_names, names("BGR"));
        assert!(matches!(&reordered.sampling, Sampling::Mosaic(m) if m.cells() == [2, 1, 1, 0]));
        for others in ["RGBW", "RGW", "RG"] {
            assert_eq!(raw.clone().with_channels(&names(others)), raw, "{others}");
        }
    }
}
