//! Demosaicking: every channel at every pixel.

mod bayer;
mod bilinear;
mod delaunay;
mod hamilton_adams1997;
mod malvar2004;
mod plan;
mod simd;

use serde::{Deserialize, Serialize};

use super::IspError;
use super::source::Source;
use crate::numeric::Planes;
use crate::sensor::{Mosaic, RawImage, Sampling};
pub use bilinear::Bilinear;
pub(crate) use plan::{BAND_ROWS, Plan, bands};

/// A demosaicking method.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Demosaic {
    /// Linear interpolation between the samples of a channel that enclose the pixel, for any mosaic.
    #[default]
    Bilinear,
    /// Malvar, He and Cutler 2004: linear filters of 5 × 5 samples, for Bayer mosaics.
    Malvar2004,
    /// Hamilton and Adams 1997: green along the smaller gradient, the other channels by their difference to green, for Bayer mosaics.
    // Older descriptions use the name "adaptive".
    #[serde(alias = "adaptive")]
    HamiltonAdams1997,
}

impl Demosaic {
    /// Every method.
    pub const ALL: [Self; 3] = [Self::Bilinear, Self::Malvar2004, Self::HamiltonAdams1997];

    /// The name of the method in descriptions and on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Bilinear => "bilinear",
            Self::Malvar2004 => "malvar2004",
            Self::HamiltonAdams1997 => "hamilton-adams1997",
        }
    }

    /// Whether the method is defined for a mosaic.
    #[must_use]
    pub fn is_defined_for(self, mosaic: &Mosaic) -> bool {
        match self {
            Self::Bilinear => true,
            Self::Malvar2004 | Self::HamiltonAdams1997 => mosaic.bayer_phase().is_some(),
        }
    }

    /// Whether the method is defined for Bayer mosaics only.
    #[must_use]
    pub fn is_for_bayer(self) -> bool {
        match self {
            Self::Bilinear => false,
            Self::Malvar2004 | Self::HamiltonAdams1997 => true,
        }
    }

    /// One plane per channel, normalised to 0 at black level and 1 at white level, not clipped. Measured samples are kept. An
    /// image with all channels at every pixel is only normalised.
    ///
    /// # Errors
    /// [`IspError::UnsupportedCfa`] when the method is not defined for the mosaic; [`IspError::ChannelNotSeen`] when the image is
    /// so small that it has no sample of a channel; [`IspError::SparseChannel`] when samples of a channel are too far apart.
    pub fn apply(self, raw: &RawImage) -> Result<Planes, IspError> {
        let mosaic = match raw.sampling() {
            Sampling::Full { channels } => {
                return Ok(Planes::new(raw.rows(), raw.cols(), *channels, raw.normalized())?);
            }
            Sampling::Mosaic(m) => m,
        };
        let mut out = Planes::zeros(raw.rows(), raw.cols(), mosaic.channels());
        let (source, planes) = (Source::of(raw), out.data_mut());
        match self {
            Self::Bilinear => Bilinear::new(mosaic)?.plan.apply(source, planes)?,
            Self::Malvar2004 => malvar2004::plan(mosaic)?.apply(source, planes)?,
            Self::HamiltonAdams1997 => hamilton_adams1997::apply(mosaic, source, planes)?,
        }
        Ok(out)
    }

    /// The reach of the method: a pixel depends on samples at most that many rows or columns away.
    ///
    /// # Errors
    /// When the method is not defined for the mosaic.
    pub fn reach(self, mosaic: &Mosaic) -> Result<usize, IspError> {
        Ok(self.interpolation(mosaic)?.map_or(hamilton_adams1997::REACH, |i| i.reach()))
    }

    /// The weights of the method for a mosaic; `None` when the method is not linear.
    pub(crate) fn interpolation(self, mosaic: &Mosaic) -> Result<Option<Plan>, IspError> {
        Ok(match self {
            Self::Bilinear => Some(Bilinear::new(mosaic)?.plan),
            Self::Malvar2004 => Some(malvar2004::plan(mosaic)?),
            Self::HamiltonAdams1997 => None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::philox::Stream;
    use crate::numeric::simd::{Set, with_widest};
    use crate::sensor::RawSamples;

    fn raw(mosaic: &Mosaic, rows: usize, cols: usize) -> RawImage {
        let mut random = Stream::new(5, 0, 0);
        let samples = (0..rows * cols).map(|_| random.next_u32() as u16).collect();
        let names = (0..mosaic.channels()).map(|c| c.to_string()).collect();
        let sampling = Sampling::Mosaic(mosaic.clone());
        RawImage::new(rows, cols, RawSamples::Digital(samples), sampling, names, 64.0, 65535.0).unwrap()
    }

    fn mosaics() -> Vec<Mosaic> {
        let tile = |rows, cols, cells: &[u8]| Mosaic::new(rows, cols, cells.to_vec()).unwrap();
        vec![
            tile(2, 2, &[0, 1, 1, 2]),
            tile(2, 2, &[1, 0, 2, 1]),
            tile(2, 2, &[0, 1, 2, 3]),
            tile(3, 3, &[0, 1, 2, 3, 4, 5, 1, 2, 3]),
            tile(1, 5, &[0, 1, 2, 1, 3]),
        ]
    }

    #[test]
    fn names_are_those_of_descriptions() {
        for method in Demosaic::ALL {
            let named = serde_json::to_value(method).unwrap();
            assert_eq!(named, method.name());
            assert_eq!(serde_json::from_value::<Demosaic>(named).unwrap(), method);
        }
        assert_eq!(serde_json::from_str::<Demosaic>("\"adaptive\"").unwrap(), Demosaic::HamiltonAdams1997);
    }

    /// Every instruction set and the reference implementation give the same bits.
    #[test]
    fn all_ways_agree() {
        for (mosaic, (rows, cols)) in
            mosaics().iter().flat_map(|m| [(5, 7), (33, 66), (19, 161), (40, 700)].map(|s| (m, s)))
        {
            let raw = raw(mosaic, rows, cols);
            let plan = Bilinear::new(mosaic).unwrap();
            let one_by_one = plan.plan.pixel_by_pixel(Source::of(&raw));
            let RawSamples::Digital(samples) = raw.samples() else { unreachable!() };
            let integers = || {
                let mut out = vec![0; one_by_one.len()];
                plan.apply_u16(samples, rows, cols, &mut out).unwrap();
                out
            };
            let plain = with_widest(Set::Plain, integers);
            for set in [Set::Plain, Set::Avx2, Set::Avx512] {
                let planes = with_widest(set, || Demosaic::Bilinear.apply(&raw)).unwrap();
                assert_eq!(planes.data(), one_by_one, "{set:?} {mosaic:?} {rows} × {cols}");
                assert_eq!(with_widest(set, integers), plain, "{set:?} {mosaic:?}");
            }
        }
    }
}
