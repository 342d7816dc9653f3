//! The classic pipeline: black level, demosaicking, colour matrix, white balance.

use rayon::prelude::*;

use super::white_balance::output_matrix;
use super::{ColorMatrix, Demosaic, Isp, IspError, WhiteBalance};
use crate::color::{ColorSpace, Image};
use crate::numeric::Planes;
use crate::sensor::RawImage;

/// Pixels summed at a time, and sums added in order: the mean is the same for any number of threads.
const CHUNK: usize = 4096;

/// Demosaicking, then one matrix for colour and white balance; the result is linear in the raw samples (but for
/// adaptive demosaicking and grey-world balance) and not clipped.
///
/// The picture is CIE X, Y, Z with Y = `gain` for a perfect white diffuser that just saturates the channel that sees it
/// brightest. With [`WhiteBalance::None`] it is that under the scene's light; otherwise white is D65, so that
/// [`ColorSpace::LinearSrgb`] of white at Y = 1 is (1, 1, 1).
#[derive(Debug, Clone, PartialEq)]
pub struct Classic {
    /// How channels a pixel has not seen are estimated.
    pub demosaic: Demosaic,
    /// X, Y, Z from the camera's channels.
    pub color_matrix: ColorMatrix,
    /// What is done about the colour of the light.
    pub white_balance: WhiteBalance,
    /// A factor on the picture, finite; 1 leaves the exposure as it was taken.
    pub gain: f64,
}

impl Classic {
    /// Bilinear demosaicking, white balance for the illuminant of the matrix, gain 1.
    #[must_use]
    pub fn new(color_matrix: ColorMatrix) -> Self {
        Self {
            demosaic: Demosaic::default(),
            color_matrix,
            white_balance: WhiteBalance::default(),
            gain: 1.0,
        }
    }

    /// X, Y, Z of planes that have been demosaicked, one per channel, normalised.
    ///
    /// # Errors
    /// When there is not one plane for each channel of the colour matrix, or the gain is not finite.
    pub fn render_planes(&self, camera: &Planes) -> Result<Image, IspError> {
        let expected = self.color_matrix.camera_white().len();
        if camera.count() != expected {
            return Err(IspError::Channels { what: "the raw image", expected, got: camera.count() });
        }
        if !self.gain.is_finite() {
            let (name, expected) = ("gain", "a finite number");
            return Err(IspError::Parameter { name, value: self.gain, expected });
        }
        let means = match self.white_balance {
            WhiteBalance::GrayWorld => camera.planes().map(mean).collect(),
            _ => Vec::new(),
        };
        let columns: Vec<[f32; 3]> = output_matrix(&self.color_matrix, self.white_balance, &means)
            .into_iter()
            .map(|c| c.map(|v| (v * self.gain) as f32))
            .collect();
        let mut out = Planes::zeros(camera.rows(), camera.cols(), 3);
        let n = camera.plane_len();
        for (i, plane) in out.data_mut().chunks_mut(n.max(1)).enumerate() {
            plane.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, out)| {
                let at = chunk * CHUNK..chunk * CHUNK + out.len();
                for (channel, column) in camera.planes().zip(&columns) {
                    for (o, &v) in out.iter_mut().zip(&channel[at.clone()]) {
                        *o += column[i] * v;
                    }
                }
            });
        }
        Ok(Image::new(ColorSpace::Xyz, out)?)
    }
}

impl Isp for Classic {
    fn render(&self, raw: &RawImage) -> Result<Image, IspError> {
        self.render_planes(&self.demosaic.apply(raw)?)
    }
}

fn mean(plane: &[f32]) -> f64 {
    let sum = |chunk: &[f32]| chunk.iter().map(|&v| f64::from(v)).sum::<f64>();
    let sums: Vec<f64> = plane.par_chunks(CHUNK).map(sum).collect();
    sums.iter().sum::<f64>() / plane.len().max(1) as f64
}
