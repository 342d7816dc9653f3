//! Visual SNR: visibility of noise at a viewing distance.

use super::error::{at_least, finite};
use super::patch::check_region;
use super::{MetricError, Rect};
use crate::color::scielab::Scielab;
use crate::color::{DeltaE, Image};
use crate::numeric::Planes;

/// Pixels per degree of visual angle of a picture with `pixels_per_inch` at a viewing distance of `distance_m`.
#[must_use]
pub fn samples_per_degree(pixels_per_inch: f64, distance_m: f64) -> f64 {
    pixels_per_inch / 0.0254 * distance_m * 2.0 * 0.5f64.to_radians().tan()
}

/// Visual signal-to-noise ratio of a uniform region of a picture in XYZ ([farrell2010]): the reciprocal of the standard
/// deviation of its S-CIELAB values, √(var L* + var a* + var b*), taken as the RMS of ΔE 1976 between the region and
/// its own mean. 1 means that the noise is about as large as a just visible difference; infinite without noise.
///
/// `white` is on the scale of the picture; `samples_per_degree` is the viewing resolution.
///
/// # Errors
/// When the picture is not in XYZ, the region extends beyond it or has fewer than two pixels, a value is not finite, or
/// `samples_per_degree` is not within 1–2000.
///
/// [farrell2010]: https://doi.org/10.1117/12.839149
pub fn visual_snr(
    picture: &Image,
    region: Rect,
    white: [f64; 3],
    samples_per_degree: f64,
) -> Result<f64, MetricError> {
    check_region(region, picture.rows(), picture.cols())?;
    at_least("pixels in the region", 2, region.len())?;
    let planes = picture.planes();
    let cut: Vec<f64> = planes.planes().flat_map(|p| region.values(p, planes.cols())).collect();
    finite("the region", cut.iter().copied())?;
    let means: Vec<f64> = cut.chunks(region.len()).map(|p| p.iter().sum::<f64>() / p.len() as f64).collect();
    let uniform = means.iter().flat_map(|&m| std::iter::repeat_n(m as f32, region.len())).collect();
    let image = |data: Vec<f32>| -> Result<Image, MetricError> {
        Ok(Image::new(picture.space(), Planes::new(region.rows, region.cols, 3, data)?)?)
    };
    let noisy = image(cut.iter().map(|&v| v as f32).collect())?;
    let map = Scielab::new(samples_per_degree, DeltaE::Cie1976).compare(&image(uniform)?, &noisy, white)?;
    let squares: f64 = map.values.iter().map(|&v| f64::from(v) * f64::from(v)).sum();
    let variance = squares / (region.len() - 1) as f64;
    // Rounding in single precision limits the variance of a uniform picture after filtering to this.
    Ok(if variance < 1e-10 { f64::INFINITY } else { 1.0 / variance.sqrt() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::ColorSpace;
    use crate::numeric::philox::Stream;

    const WHITE: [f64; 3] = [95.047, 100.0, 108.883];

    fn grey(noise: f64) -> Image {
        let mut s = Stream::new(5, 0, 0);
        let y: Vec<f64> = (0..80 * 80).map(|_| 40.0 + noise * (s.uniform() - 0.5)).collect();
        let data = WHITE.iter().flat_map(|w| y.iter().map(move |y| (y * w / 100.0) as f32)).collect();
        Image::new(ColorSpace::Xyz, Planes::new(80, 80, 3, data).unwrap()).unwrap()
    }

    #[test]
    fn noise_weighs_less_from_afar_and_halves_when_halved() {
        let region = Rect { row: 4, col: 4, rows: 72, cols: 72 };
        let snr = |noise, samples| visual_snr(&grey(noise), region, WHITE, samples).unwrap();
        let near = snr(2.0, 20.0);
        assert!(snr(2.0, 60.0) > 2.0 * near);
        assert!((snr(1.0, 20.0) / near - 2.0).abs() < 0.01);
        assert_eq!(snr(0.0, 20.0), f64::INFINITY);
    }

    /// Where every pixel subtends a degree, the eye blurs little, and visual SNR is the reciprocal of the standard deviation of L*.
    #[test]
    fn without_blur_it_is_the_reciprocal_of_the_deviation() {
        let region = Rect { row: 4, col: 4, rows: 72, cols: 72 };
        let picture = grey(2.0);
        let lightness = |y: f64| 116.0 * (y / 100.0).cbrt() - 16.0;
        let y: Vec<f64> = region.values(picture.channels()[1], 80).collect();
        let mean = lightness(y.iter().sum::<f64>() / y.len() as f64);
        let variance = y.iter().map(|&y| (lightness(y) - mean).powi(2)).sum::<f64>() / (y.len() - 1) as f64;
        let snr = visual_snr(&picture, region, WHITE, 1.0).unwrap();
        assert!((0.8..1.25).contains(&(snr * variance.sqrt())), "{snr} {variance}");
    }

    #[test]
    fn resolution_of_a_display() {
        // ISETCam's default display: 41 samples per degree at 120 dots per inch and half a metre.
        assert!((samples_per_degree(120.0, 0.5) - 41.0).abs() < 0.5);
    }

    #[test]
    fn bad_input_is_refused() {
        let run = |image: &Image, rows, samples| {
            visual_snr(image, Rect { row: 0, col: 0, rows, cols: 4 }, WHITE, samples).unwrap_err()
        };
        assert!(matches!(run(&grey(1.0), 81, 30.0), MetricError::Region { .. }));
        let pixel = Rect { row: 0, col: 0, rows: 1, cols: 1 };
        let refused = visual_snr(&grey(1.0), pixel, WHITE, 30.0).unwrap_err();
        assert!(matches!(refused, MetricError::TooFew { minimum: 2, got: 1, .. }));
        assert!(matches!(run(&grey(1.0), 4, 0.0), MetricError::Scielab(_)));
        let srgb = Image::new(ColorSpace::Srgb, Planes::zeros(4, 4, 3)).unwrap();
        assert!(matches!(run(&srgb, 4, 30.0), MetricError::Scielab(_)));
        let mut hole = Planes::zeros(4, 4, 3);
        hole.data_mut()[1] = f32::NAN;
        let hole = Image::new(ColorSpace::Xyz, hole).unwrap();
        assert!(matches!(run(&hole, 4, 30.0), MetricError::NotFinite { .. }));
    }
}
