//! Demosaicking: every channel at every pixel.

mod adams1997;
mod bayer;
mod bilinear;
mod delaunay;
mod malvar2004;
mod plan;
mod simd;

use super::IspError;
use super::source::Source;
use crate::numeric::Planes;
use crate::sensor::{Mosaic, RawImage, Sampling};
pub use bilinear::Bilinear;
pub(crate) use plan::{BAND_ROWS, bands};
use simd::Simd;

/// How the channels a pixel has not seen are estimated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Demosaic {
    /// Linear interpolation between the samples of a channel that enclose the pixel, for any mosaic.
    #[default]
    Bilinear,
    /// Malvar, He and Cutler 2004, linear with 5 × 5 filters, for Bayer mosaics.
    Malvar2004,
    /// Green along the smaller gradient, the other channels by their difference to green, for Bayer mosaics
    /// (Hamilton and Adams 1997).
    Adaptive,
}

impl Demosaic {
    /// One plane per channel, normalised: 0 at black level, 1 at white level; not clipped. Pixels keep the value
    /// of the channel they have seen. An image that has every channel at every pixel passes through.
    ///
    /// # Errors
    /// [`IspError::UnsupportedCfa`] when the method is not defined for the mosaic; [`IspError::ChannelNotSeen`] when
    /// the image is so small that it misses a channel; [`IspError::SparseChannel`] when samples of a channel are
    /// too far apart.
    pub fn apply(self, raw: &RawImage) -> Result<Planes, IspError> {
        self.apply_with(Simd::best(), raw)
    }

    /// Rows or columns, whichever is more, from which samples can reach a pixel.
    ///
    /// # Errors
    /// When the method is not defined for the mosaic.
    pub fn reach(self, mosaic: &Mosaic) -> Result<usize, IspError> {
        Ok(self.interpolation(mosaic)?.map_or(adams1997::REACH, |i| i.reach()))
    }

    /// The weights of the method for a mosaic; `None` where it has none that do not depend on the image.
    pub(crate) fn interpolation(self, mosaic: &Mosaic) -> Result<Option<Interpolation>, IspError> {
        Ok(match self {
            Self::Bilinear => Some(Interpolation(Bilinear::new(mosaic)?.into_plan())),
            Self::Malvar2004 => Some(Interpolation(malvar2004::plan(mosaic)?)),
            Self::Adaptive => None,
        })
    }

    fn apply_with(self, simd: Simd, raw: &RawImage) -> Result<Planes, IspError> {
        let mosaic = match raw.sampling() {
            Sampling::Full { channels } => {
                return Ok(Planes::new(raw.rows(), raw.cols(), *channels, raw.normalized())?);
            }
            Sampling::Mosaic(m) => m,
        };
        let mut out = Planes::zeros(raw.rows(), raw.cols(), mosaic.channels());
        let (source, planes) = (Source::of(raw), out.data_mut());
        match self {
            Self::Bilinear => Bilinear::new(mosaic)?.plan().apply(source, simd, planes)?,
            Self::Malvar2004 => malvar2004::plan(mosaic)?.apply(source, simd, planes)?,
            Self::Adaptive => adams1997::apply(mosaic, source, simd, planes)?,
        }
        Ok(out)
    }
}

/// The weights of a linear demosaicking method for one mosaic.
#[derive(Debug, Clone)]
pub(crate) struct Interpolation(plan::Plan);

impl Interpolation {
    /// Rows or columns, whichever is more, from which samples can reach a pixel.
    pub(crate) fn reach(&self) -> usize {
        self.0.reach()
    }

    /// Calls `each` with row and column from a pixel of the tile and the weight of every sample that a channel there is
    /// made of.
    pub(crate) fn each_weight(
        &self,
        row: usize,
        col: usize,
        channel: usize,
        mut each: impl FnMut([i32; 2], f32),
    ) {
        self.0.taps(row, col, channel).iter().for_each(|t| each([t.row, t.col], t.weight));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::philox::Stream;
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

    /// Every instruction set and the way pixel by pixel give the same bits.
    #[test]
    fn all_ways_agree() {
        for (mosaic, (rows, cols)) in
            mosaics().iter().flat_map(|m| [(5, 7), (33, 66), (19, 161), (40, 700)].map(|s| (m, s)))
        {
            let raw = raw(mosaic, rows, cols);
            let plan = Bilinear::new(mosaic).unwrap();
            let one_by_one = plan.plan().pixel_by_pixel(Source::of(&raw));
            let RawSamples::Digital(samples) = raw.samples() else { unreachable!() };
            let integers = |simd| {
                let mut out = vec![0; one_by_one.len()];
                plan.apply_u16_with(simd, samples, rows, cols, &mut out).unwrap();
                out
            };
            for simd in Simd::all() {
                let planes = Demosaic::Bilinear.apply_with(simd, &raw).unwrap();
                assert_eq!(planes.data(), one_by_one, "{simd:?} {mosaic:?} {rows} × {cols}");
                assert_eq!(integers(simd), integers(Simd::all()[0]), "{simd:?} {mosaic:?}");
            }
        }
    }
}
