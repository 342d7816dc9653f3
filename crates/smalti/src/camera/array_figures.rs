//! What a colour filter array makes of light and of colour, from its spectra alone. Nothing is rendered.

use serde::Serialize;

use super::{Camera, CameraError, ColorimetricObserver, SensorColorimetry};
use crate::isp::WhiteBalance;
use crate::numeric::dense::{Eigen, dot};
use crate::spectrum::Spectrum;

/// An eigenvalue below this share of the largest is 0 to the precision of the matrix.
const SINGULAR: f64 = 1e-13;
/// The share of the largest singular value of the responses up to which another one counts as 0. The third ones of the built-in cameras that see
/// colour are at least 0.19; a blue filter that is nine tenths green leaves 0.05.
const DEPENDENT: f64 = 0.05;

/// Figures of a colour filter array on a camera under a light.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ArrayFigures {
    /// The mean response of the pixels of the tile to a white object, relative to that of pixels without filters, 0 to 1.
    pub photon_efficiency: f64,
    /// Colorimetry of the channels.
    #[serde(flatten)]
    pub colorimetry: SensorColorimetry,
    /// The condition number of the colour matrix between channels that are 1 for white, and X, Y, Z that are: the ratio of its largest
    /// and its smallest singular value, at least 1. `None` if the matrix maps all colours to a plane.
    pub condition_number: Option<f64>,
    /// The standard deviation of Y after the colour matrix per that of independent, equal noise of the channels; see
    /// [`ColorMatrix::luminance_noise_gain`](crate::isp::ColorMatrix::luminance_noise_gain).
    pub luminance_noise_gain: f64,
}

impl Camera {
    /// The figures of the camera's array for an observer under a light on the grid of the camera. The colour matrix is that of the
    /// classic processing of the description.
    ///
    /// # Errors
    /// When a curve does not cover the wavelengths, or the camera or the observer does not respond to the light.
    pub fn array_figures(&self, observer: &ColorimetricObserver) -> Result<ArrayFigures, CameraError> {
        let light = observer.light();
        let matrix = self.isp(light, WhiteBalance::None)?.color_matrix;
        let white = matrix.xyz_white();
        let relative = |(column, camera): (&[f64; 3], &f64)| [0, 1, 2].map(|i| column[i] * camera / white[i]);
        let columns: Vec<[f64; 3]> =
            matrix.xyz_from_camera().iter().zip(matrix.camera_white()).map(relative).collect();
        Ok(ArrayFigures {
            photon_efficiency: self.photon_efficiency(light)?,
            colorimetry: observer.colorimetry(self)?,
            condition_number: condition_number(&columns),
            luminance_noise_gain: matrix.luminance_noise_gain(),
        })
    }

    /// In how many independent ways the channels respond to a light on the grid of the camera: the number of singular values above a twentieth of the largest
    /// of the spectral responses, each relative to that to white. Colour needs three.
    ///
    /// # Errors
    /// When a curve does not cover the wavelengths.
    pub fn independent_channels(&self, light: &Spectrum) -> Result<usize, CameraError> {
        let mut responses = Vec::new();
        for response in self.responsivities()? {
            let response = response.times(light)?;
            let white: f64 = response.values().iter().sum();
            if white > 0.0 {
                responses.push(response.scaled(1.0 / white)?);
            }
        }
        let products = responses.iter().flat_map(|a| responses.iter().map(|b| dot(a.values(), b.values())));
        let Some(found) = Eigen::of(&products.collect::<Vec<_>>(), responses.len()) else { return Ok(0) };
        let most = found.values.last().copied().unwrap_or_default();
        Ok(found.values.iter().filter(|v| **v > DEPENDENT * DEPENDENT * most).count())
    }

    /// See [`ArrayFigures::photon_efficiency`].
    fn photon_efficiency(&self, light: &Spectrum) -> Result<f64, CameraError> {
        let lens = self.optics.transmittance_on(light.grid())?;
        let bare = self.sensor.bare_responsivity_on(light.grid())?.times(&lens)?.times(light)?.integral();
        let white = |c: &Spectrum| Ok(c.times(light)?.integral());
        let whites = self.responsivities()?.iter().map(white).collect::<Result<Vec<f64>, CameraError>>()?;
        let cells = self.sensor.cfa.mosaic().cells();
        let sum: f64 = cells.iter().filter_map(|&cell| whites.get(usize::from(cell))).sum();
        Ok(sum / (cells.len() as f64 * bare))
    }
}

/// The condition number of a 3 × N matrix, given by columns.
fn condition_number(columns: &[[f64; 3]]) -> Option<f64> {
    let product = |i: usize, j: usize| columns.iter().map(|c| c[i] * c[j]).sum::<f64>();
    let gram: Vec<f64> = (0..9).map(|at| product(at / 3, at % 3)).collect();
    let values = Eigen::of(&gram, 3)?.values;
    let (least, most) = (*values.first()?, *values.last()?);
    (least > SINGULAR * most).then(|| (most / least).sqrt())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::camera::CameraDescription;
    use crate::sensor::{Cfa, Channel, Mosaic};
    use crate::spectrum::{Illuminant, WavelengthGrid};

    const GRID: WavelengthGrid = WavelengthGrid::VISIBLE;

    fn figures(transmittances: &[Spectrum], cells: &[u8]) -> ArrayFigures {
        let camera = Camera::new(CameraDescription::default(), GRID).unwrap();
        let channel = |(i, t): (usize, &Spectrum)| Channel { name: i.to_string(), transmittance: t.clone() };
        let channels = transmittances.iter().enumerate().map(channel).collect();
        let cfa = Cfa::new("test", Mosaic::new(2, 2, cells.to_vec()).unwrap(), channels).unwrap();
        let observer = ColorimetricObserver::new(&Illuminant::D65.photons(GRID).unwrap()).unwrap();
        camera.with_cfa(cfa).array_figures(&observer).unwrap()
    }

    fn band(first_nm: f64, last_nm: f64) -> Spectrum {
        let values = GRID.wavelengths_nm().map(|nm| if nm >= first_nm && nm < last_nm { 1.0 } else { 0.0 });
        Spectrum::new(GRID, values.collect()).unwrap()
    }

    /// Bands that share the spectrum among them pass, in the mean of the three, a third of it; a clear pixel passes all.
    #[test]
    fn the_efficiency_is_the_share_of_the_light_that_filters_pass() {
        let bands = [band(0.0, 500.0), band(500.0, 590.0), band(590.0, 1000.0)];
        let one = |cells: [u8; 4]| figures(&bands, &cells).photon_efficiency;
        let each = [one([0, 1, 2, 0]), one([0, 1, 2, 1]), one([0, 1, 2, 2])];
        // The three tiles have each band twice once: the sum of four times their efficiency has every band four times.
        assert!((4.0 * each.iter().sum::<f64>() - 4.0).abs() < 1e-12, "{each:?}");
        let with_clear = [bands.as_slice(), &[band(0.0, 1000.0)]].concat();
        let clear = figures(&with_clear, &[0, 1, 2, 3]).photon_efficiency;
        assert!((4.0 * clear - 2.0).abs() < 1e-12, "{clear}");
    }

    #[test]
    fn the_condition_number_is_that_of_the_singular_values() {
        let near = |found: Option<f64>, expected: f64| (found.unwrap() / expected - 1.0).abs() < 1e-9;
        assert!(near(condition_number(&[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]), 1.0));
        assert!(near(condition_number(&[[4.0, 0.0, 0.0], [0.0, -2.0, 0.0], [0.0, 0.0, 0.5]]), 8.0));
        assert_eq!(condition_number(&[[1.0, 2.0, 3.0], [2.0, 1.0, 0.0]]), None);
    }

    /// Apart, three bands are three; a third curve that is mixed of the other two adds none, nor does a dark one.
    #[test]
    fn independent_channels_are_counted() {
        let count = |transmittances: &[Spectrum], cells: &[u8]| {
            let camera = Camera::new(CameraDescription::default(), GRID).unwrap();
            let channel =
                |(i, t): (usize, &Spectrum)| Channel { name: i.to_string(), transmittance: t.clone() };
            let channels = transmittances.iter().enumerate().map(channel).collect();
            let cfa = Cfa::new("test", Mosaic::new(2, 2, cells.to_vec()).unwrap(), channels).unwrap();
            camera.with_cfa(cfa).independent_channels(&Illuminant::D65.photons(GRID).unwrap()).unwrap()
        };
        let [low, high, all] = [band(0.0, 500.0), band(590.0, 1000.0), band(0.0, 1000.0)];
        let (middle, dark) = (band(500.0, 590.0), band(2000.0, 3000.0));
        assert_eq!(count(&[low.clone(), middle.clone(), high.clone()], &[0, 1, 2, 1]), 3);
        assert_eq!(count(&[low.clone(), middle.clone(), high, all.clone()], &[0, 1, 2, 3]), 3);
        assert_eq!(count(&[low.clone(), middle.clone(), middle.clone()], &[0, 1, 2, 1]), 2);
        assert_eq!(count(&[low.clone(), middle.clone(), dark], &[0, 1, 2, 1]), 2);
        assert_eq!(count(&[low.clone(), middle.clone(), band(0.0, 590.0)], &[0, 1, 2, 1]), 2);
        assert_eq!(count(&[all], &[0, 0, 0, 0]), 1);
    }

    /// Bands that overlap need a matrix of large coefficients of opposite sign.
    #[test]
    fn overlapping_filters_amplify_noise() {
        let apart = figures(&[band(0.0, 500.0), band(500.0, 590.0), band(590.0, 1000.0)], &[0, 1, 2, 1]);
        let alike = figures(&[band(0.0, 600.0), band(480.0, 1000.0), band(0.0, 1000.0)], &[0, 1, 2, 1]);
        assert!(alike.condition_number.unwrap() > apart.condition_number.unwrap(), "{alike:?} {apart:?}");
        assert!(alike.luminance_noise_gain > apart.luminance_noise_gain, "{alike:?} {apart:?}");
    }
}
