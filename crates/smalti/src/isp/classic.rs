//! The classic pipeline: black level, demosaicking, colour matrix, white balance.

use rayon::prelude::*;

use super::white_balance::output_matrix;
use super::{ColorMatrix, Demosaic, Isp, IspError, WhiteBalance};
use crate::color::{ColorSpace, Image};
use crate::numeric::Planes;
use crate::sensor::RawImage;

/// Pixels per partial sum. Partial sums are added in order, so that the mean does not depend on the number of threads.
const CHUNK: usize = 4096;

/// Demosaicking followed by one matrix for colour and white balance. The picture is linear in the raw samples (except with
/// adaptive demosaicking or grey-world balance) and not clipped.
///
/// The picture is CIE X, Y, Z with Y = `gain` for a perfect white diffuser that just saturates its brightest channel. With
/// [`WhiteBalance::None`] the values are those under the illuminant of the scene. Otherwise white is adapted to D65, so that
/// white at Y = 1 is (1, 1, 1) in [`ColorSpace::LinearSrgb`].
#[derive(Debug, Clone, PartialEq)]
pub struct Classic {
    /// The demosaicking method.
    pub demosaic: Demosaic,
    /// The matrix from camera channels to X, Y, Z.
    pub color_matrix: ColorMatrix,
    /// The white balance.
    pub white_balance: WhiteBalance,
    /// A finite factor on the picture; 1 keeps the exposure of the capture.
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

    /// The picture from demosaicked and normalised planes, one per channel.
    ///
    /// # Errors
    /// When the number of planes is not that of the channels of the colour matrix, the gain is not finite, or the white of the
    /// camera cannot be adapted to D65.
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
        let columns: Vec<[f32; 3]> = output_matrix(&self.color_matrix, self.white_balance, &means)?
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
