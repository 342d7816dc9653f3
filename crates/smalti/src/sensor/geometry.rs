//! The samples of the optical image that each pixel collects, and their weights. Rows and columns are
//! separable.

use std::ops::Range;

use super::Aperture;

/// One axis of the sensor relative to one axis of the image.
pub(super) struct AxisGeometry {
    /// Pixels along the whole axis, centred on the optical axis.
    pub(super) pixels: usize,
    /// Pixel pitch over sample spacing.
    pub(super) pitch_in_samples: f64,
    /// Side of the photodetector over sample spacing.
    pub(super) side_in_samples: f64,
    /// Samples of the image, centred on the optical axis.
    pub(super) samples: usize,
    /// The pixel aperture.
    pub(super) aperture: Aperture,
}

/// Weights of a run of pixels. A pixel outside the image has none; one that is partly outside has weights
/// that sum to the fraction inside.
pub(super) struct Taps {
    first_sample: Vec<u32>,
    first_weight: Vec<u32>,
    weights: Vec<f32>,
    /// The samples in use, relative to the start of the image.
    pub(super) used: Range<usize>,
    /// Maximum number of weights of a pixel.
    pub(super) most: usize,
}

impl AxisGeometry {
    /// The weights of pixels `range`; indices below 0 and beyond the end are dummy pixels.
    pub(super) fn taps(&self, range: Range<i64>) -> Taps {
        let mut first_sample = Vec::with_capacity((range.end - range.start).max(0) as usize);
        let mut first_weight = Vec::with_capacity(first_sample.capacity() + 1);
        let mut weights: Vec<f32> = Vec::new();
        for pixel in range {
            first_weight.push(weights.len() as u32);
            let centre = (pixel as f64 - (self.pixels as f64 - 1.0) / 2.0) * self.pitch_in_samples
                + self.samples as f64 / 2.0;
            first_sample.push(match self.aperture {
                Aperture::Area => self.push_area(centre, &mut weights),
                Aperture::Point => self.push_point(centre, &mut weights),
            });
        }
        first_weight.push(weights.len() as u32);
        let mut taps = Taps { first_sample, first_weight, weights, used: 0..0, most: 0 };
        let (mut low, mut high) = (usize::MAX, 0);
        for i in 0..taps.first_sample.len() {
            let n = taps.weights_of(i).len();
            if n > 0 {
                let first = taps.first_sample[i] as usize;
                (low, high) = (low.min(first), high.max(first + n));
                taps.most = taps.most.max(n);
            }
        }
        taps.used = low.min(high)..high;
        for (i, first) in taps.first_sample.iter_mut().enumerate() {
            let empty = taps.first_weight[i] == taps.first_weight[i + 1];
            *first = if empty { 0 } else { *first - taps.used.start as u32 };
        }
        taps
    }

    /// Overlap of the photodetector with the square of each sample, relative to the photodetector.
    fn push_area(&self, centre: f64, weights: &mut Vec<f32>) -> u32 {
        let (low, high) = (centre - self.side_in_samples / 2.0, centre + self.side_in_samples / 2.0);
        let (from, to) = (low.max(0.0), high.min(self.samples as f64));
        if from >= to {
            return 0;
        }
        let first = from.floor();
        let mut sample = first;
        while sample < to {
            let overlap = to.min(sample + 1.0) - from.max(sample);
            weights.push((overlap / (high - low)) as f32);
            sample += 1.0;
        }
        first as u32
    }

    /// Linear interpolation between sample centres, zero beyond the outermost.
    fn push_point(&self, centre: f64, weights: &mut Vec<f32>) -> u32 {
        let at = centre - 0.5;
        let last = self.samples as f64 - 1.0;
        // Rounding must not place a pixel on the outermost sample outside the image.
        if at < -1e-9 || at > last + 1e-9 {
            return 0;
        }
        let at = at.clamp(0.0, last);
        let first = at.floor().min((last - 1.0).max(0.0));
        let t = (at - first) as f32;
        weights.push(1.0 - t);
        if last > 0.0 {
            weights.push(t);
        }
        first as u32
    }
}

/// Pixels of a run with equally many weights each, whose first samples are equally far apart.
pub(super) struct EvenTaps {
    pub(super) pixels: Range<usize>,
    /// First sample of the first pixel, and the distance to that of the next.
    pub(super) first: usize,
    pub(super) step: usize,
    /// For each weight of a pixel, those of all pixels.
    pub(super) weights: Vec<Vec<f32>>,
}

impl Taps {
    /// The first run of evenly spaced pixels that all have the largest number of weights. Where pixels are a whole number of samples apart,
    /// these are nearly all, unless rounding gives some of them a further, negligible weight.
    pub(super) fn even(&self) -> EvenTaps {
        let weights = |i: usize| self.weights_of(i).len();
        let pixels = self.first_sample.len();
        let start = (0..pixels).find(|&i| weights(i) == self.most).unwrap_or(pixels);
        let step =
            |i: usize| self.first_sample.get(i + 1).and_then(|next| next.checked_sub(self.first_sample[i]));
        let regular = step(start).unwrap_or(0);
        let ends = |&i: &usize| step(i) != Some(regular) || weights(i + 1) != self.most;
        let end = (start..pixels).find(ends).map_or(pixels, |last| last + 1);
        let of_all = |t: usize| (start..end).map(|i| self.weights_of(i)[t]).collect();
        EvenTaps {
            pixels: start..end,
            first: self.first_sample.get(start).map_or(0, |first| *first as usize),
            step: regular as usize,
            weights: (0..self.most).map(of_all).collect(),
        }
    }

    /// First sample of a pixel, relative to the start of `used`.
    #[inline(always)]
    pub(super) fn first(&self, pixel: usize) -> usize {
        self.first_sample[pixel] as usize
    }

    /// Weights of a pixel, for the samples from its first.
    #[inline(always)]
    pub(super) fn weights_of(&self, pixel: usize) -> &[f32] {
        &self.weights[self.first_weight[pixel] as usize..self.first_weight[pixel + 1] as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn taps(pixels: usize, pitch: f64, side: f64, samples: usize, aperture: Aperture) -> Taps {
        AxisGeometry { pixels, pitch_in_samples: pitch, side_in_samples: side, samples, aperture }
            .taps(0..pixels as i64)
    }

    /// Pixels of an even run have the samples and weights that each has alone. Where a pixel is a whole number of samples wide, nearly all
    /// belong to it.
    #[test]
    fn an_even_run_has_the_weights_of_its_pixels() {
        for (pixels, pitch, side, samples) in [
            (20, 2.0, 2.0, 40),
            (20, 2.0, 1.6, 60),
            (20, 1.0, 1.0, 15),
            (20, 2.7, 1.9, 50),
            (3, 9.0, 8.5, 20),
            (5, 1.0, 1.0, 0),
        ] {
            for aperture in [Aperture::Area, Aperture::Point] {
                let taps = taps(pixels, pitch, side, samples, aperture);
                let even = taps.even();
                for (i, pixel) in even.pixels.clone().enumerate() {
                    assert_eq!(taps.first(pixel), even.first + i * even.step);
                    let weights: Vec<f32> = even.weights.iter().map(|of_all| of_all[i]).collect();
                    assert_eq!(weights, taps.weights_of(pixel));
                }
                let inside = (samples as f64 / pitch) as usize;
                assert!(
                    pitch.fract() > 0.0 || even.pixels.len() + 2 >= inside.min(pixels),
                    "{pitch}, {side}"
                );
            }
        }
    }

    #[test]
    fn weights_inside_the_image_sum_to_one() {
        for (pitch, side) in [(0.3, 0.2), (1.0, 1.0), (2.7, 1.9), (9.3, 9.3)] {
            for aperture in [Aperture::Area, Aperture::Point] {
                let t = taps(11, pitch, side, 200, aperture);
                for i in 0..11 {
                    let sum: f32 = t.weights_of(i).iter().sum();
                    assert!((sum - 1.0).abs() < 1e-6, "{sum}");
                }
            }
        }
    }

    /// With full fill factor the pixels tile the image: every sample is used exactly once.
    #[test]
    fn pixels_tile_the_image() {
        let t = taps(40, 1.7, 1.7, 30, Aperture::Area);
        let mut share = vec![0.0f64; 30];
        for i in 0..40 {
            for (j, w) in t.weights_of(i).iter().enumerate() {
                share[t.used.start + t.first(i) + j] += f64::from(*w) * 1.7;
            }
        }
        assert!(share.iter().all(|s| (s - 1.0).abs() < 1e-6), "{share:?}");
    }

    #[test]
    fn pixels_beyond_the_image_see_nothing() {
        let t = taps(9, 1.0, 0.5, 3, Aperture::Area);
        assert_eq!((t.used.clone(), t.most), (0..3, 1));
        assert!((0..9).all(|i| t.weights_of(i).is_empty() != (3..6).contains(&i)));
        let none = AxisGeometry {
            pixels: 9,
            pitch_in_samples: 1.0,
            side_in_samples: 0.5,
            samples: 3,
            aperture: Aperture::Area,
        }
        .taps(0..2);
        assert!(none.used.is_empty());
    }
}
