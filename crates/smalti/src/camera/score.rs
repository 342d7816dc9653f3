//! Scores of a picture against the reference of the standard observer.

use serde::Serialize;

use super::CameraError;
use super::chart::LUMINANCE;
use crate::color::difference::LabReference;
use crate::color::scielab::Scielab;
use crate::color::{DeltaE, DifferenceMap, Image, difference};
use crate::metrics::psnr::psnr;
use crate::metrics::{MetricError, Rect};
use crate::numeric::simd::{Kernel, dispatch};
use crate::numeric::{Planes, ShapeError};

/// Viewing conditions of the scores.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScoreSettings {
    /// Viewing resolution, pixels per degree, 1 to 2000. A desktop display of 100 dpi at 0.7 m has about 48.
    pub samples_per_degree: f64,
    /// The fraction of the pixels of the reference, 0 to below 1, that may be brighter than display white. With 0 the brightest
    /// pixel is white, and lamps or specular highlights make the rest of the picture dark.
    pub highlight_share: f64,
}

impl Default for ScoreSettings {
    /// 60 pixels per degree; half a percent of the pixels may be brighter than white.
    fn default() -> Self {
        Self { samples_per_degree: 60.0, highlight_share: 0.005 }
    }
}

/// The metrics of [`PictureScores::figures`], by their names in the catalogue.
pub const PICTURE_METRICS: [&str; 3] = ["cpsnr_db", "pixel_delta_e_2000_mean", "scielab_mean"];

/// The differences of a picture from its reference. The fields have the names of the catalogue of metrics.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PictureScores {
    /// Peak signal-to-noise ratio over X, Y, Z together, peak at white, dB; infinite for equal pictures.
    pub cpsnr_db: f64,
    /// Mean CIEDE2000 of the pixels.
    pub pixel_delta_e_2000_mean: f64,
    /// 95th percentile of CIEDE2000 over the pixels.
    pub pixel_delta_e_2000_p95: f64,
    /// Mean S-CIELAB difference (ΔE 1976 after spatial filtering).
    pub scielab_mean: f64,
    /// The Y used as white, on the scale of the reference.
    pub white_y: f64,
    /// The CIEDE2000 difference at every pixel: one plane.
    #[serde(skip)]
    pub delta_e_2000_map: Planes,
    /// The S-CIELAB difference at every pixel: one plane.
    #[serde(skip)]
    pub scielab_map: Planes,
}

impl PictureScores {
    /// The values of [`PICTURE_METRICS`].
    #[must_use]
    pub fn figures(&self) -> [f64; PICTURE_METRICS.len()] {
        [self.cpsnr_db, self.pixel_delta_e_2000_mean, self.scielab_mean]
    }
}

/// Scores a picture against a reference on the same scale, both in X, Y, Z under the illuminant of the scene (not adapted), such
/// as that of [`Camera::reference_as_exposed`](super::Camera::reference_as_exposed). `white` is X, Y, Z of the illuminant with
/// Y = 1.
///
/// No scale is fitted, so that errors of overall brightness count. The peak of the CPSNR and the white of CIELAB is the Y that
/// all but [`ScoreSettings::highlight_share`] of the pixels of the reference do not exceed, so that scores at different
/// luminances are comparable. Both pictures are clipped at white like on a display: Y is limited and the chromaticity kept.
///
/// # Errors
/// [`MetricError::Undefined`] when the reference is dark; else when the pictures are not in XYZ, differ in size or hold
/// a value that is not finite, or a setting or the white is out of range.
pub fn score_picture(
    picture: &Image,
    reference: &Image,
    white: [f64; 3],
    settings: &ScoreSettings,
) -> Result<PictureScores, CameraError> {
    ReferenceToScore::new(reference, white, settings)?.score(picture)
}

/// A reference to which several pictures are compared by [`score_picture`].
pub(crate) struct ReferenceToScore {
    /// Clipped at white.
    reference: Image,
    /// The Y of white.
    white_y: f64,
    /// X, Y, Z of white.
    white: [f64; 3],
    lab: LabReference,
    scielab: Scielab,
    blurred: LabReference,
}

impl ReferenceToScore {
    /// As for [`score_picture`].
    ///
    /// # Errors
    /// As for [`score_picture`].
    pub(crate) fn new(
        reference: &Image,
        white: [f64; 3],
        settings: &ScoreSettings,
    ) -> Result<Self, CameraError> {
        check(white, settings)?;
        difference::check_pair(reference, reference)?;
        let (reference, white_y) = clipped_reference(reference, settings)?;
        let white = white.map(|v| v / white[LUMINANCE] * white_y);
        let scielab = Scielab::new(settings.samples_per_degree, DeltaE::Cie1976);
        let blurred = scielab.reference(&reference, white).map_err(MetricError::from)?;
        let lab = LabReference::new((reference.rows(), reference.cols()), reference.channels(), white);
        Ok(Self { reference, white_y, white, lab, scielab, blurred })
    }

    /// CIEDE2000 at every pixel between two pictures on the scale of the reference. Both are clipped at its white, which is the white of CIELAB.
    ///
    /// # Errors
    /// As for [`score_picture`].
    pub(crate) fn delta_e_2000_between(&self, picture: &Image, other: &Image) -> Result<Planes, CameraError> {
        let clipped = |image: &Image| {
            image.check_finite()?;
            difference::check_pair(&self.reference, image)?;
            clipped_at_white(image, self.white_y)
        };
        let (picture, other) = (clipped(picture)?, clipped(other)?);
        let lab = LabReference::new((other.rows(), other.cols()), other.channels(), self.white);
        Ok(one_plane(lab.map(picture.channels(), DeltaE::Ciede2000))?)
    }

    /// The scores of a picture.
    ///
    /// # Errors
    /// As for [`score_picture`].
    pub(crate) fn score(&self, picture: &Image) -> Result<PictureScores, CameraError> {
        picture.check_finite()?;
        difference::check_pair(&self.reference, picture)?;
        let picture = clipped_at_white(picture, self.white_y)?;
        let scielab = self.scielab.difference_from(&self.blurred, &picture).map_err(MetricError::from)?;
        let pixels = self.lab.map(picture.channels(), DeltaE::Ciede2000);
        Ok(PictureScores {
            cpsnr_db: cpsnr_db(&picture, &self.reference, self.white_y)?,
            pixel_delta_e_2000_mean: pixels.mean(),
            pixel_delta_e_2000_p95: f64::from(at_share(&mut pixels.values.clone(), 0.95)),
            scielab_mean: scielab.mean(),
            white_y: self.white_y,
            delta_e_2000_map: one_plane(pixels)?,
            scielab_map: one_plane(scielab)?,
        })
    }
}

/// The CPSNR of [`score_picture`] alone, dB, in a fraction of the time.
///
/// # Errors
/// As [`score_picture`].
pub(crate) fn picture_cpsnr_db(
    picture: &Image,
    reference: &Image,
    settings: &ScoreSettings,
) -> Result<f64, CameraError> {
    picture.check_finite()?;
    let (reference, white_y) = clipped_reference(reference, settings)?;
    cpsnr_db(&clipped_at_white(picture, white_y)?, &reference, white_y)
}

/// A reference clipped at white, and the Y of white.
fn clipped_reference(reference: &Image, settings: &ScoreSettings) -> Result<(Image, f64), CameraError> {
    reference.check_finite()?;
    let white_y = white_level(reference, settings.highlight_share);
    if white_y <= 0.0 {
        let (quantity, reason) = ("the distance from the reference", "the reference is dark");
        return Err(MetricError::Undefined { quantity, reason }.into());
    }
    Ok((clipped_at_white(reference, white_y)?, white_y))
}

fn cpsnr_db(picture: &Image, reference: &Image, white_y: f64) -> Result<f64, CameraError> {
    let region = Rect::whole(picture.rows(), picture.cols());
    Ok(psnr(picture.planes(), reference.planes(), region, white_y)?.cpsnr_db)
}

/// A map as a plane.
fn one_plane(map: DifferenceMap) -> Result<Planes, MetricError> {
    Ok(Planes::new(map.rows, map.cols, 1, map.values)?)
}

fn check(white: [f64; 3], settings: &ScoreSettings) -> Result<(), MetricError> {
    let share = settings.highlight_share;
    if !(0.0..1.0).contains(&share) {
        let expected = "0 to less than 1";
        return Err(MetricError::Parameter { name: "highlight_share", value: share, expected });
    }
    match white.iter().find(|v| !(v.is_finite() && **v > 0.0)) {
        Some(&value) => {
            Err(MetricError::Parameter { name: "white", value, expected: "a finite number above 0" })
        }
        None => Ok(()),
    }
}

/// The Y that all but a fraction of the pixels do not exceed.
fn white_level(reference: &Image, highlight_share: f64) -> f64 {
    let mut luminance = reference.channels()[LUMINANCE].to_vec();
    f64::from(at_share(&mut luminance, 1.0 - highlight_share))
}

/// The quantile of the values; 0 without values.
fn at_share(values: &mut [f32], share: f64) -> f32 {
    let Some(last) = values.len().checked_sub(1) else { return 0.0 };
    let at = (last as f64 * share) as usize;
    *values.select_nth_unstable_by(at.min(last), f32::total_cmp).1
}

/// A picture clipped at white: Y is limited to `white_y` and the chromaticity kept.
fn clipped_at_white(picture: &Image, white_y: f64) -> Result<Image, CameraError> {
    let mut planes = picture.planes().clone();
    limit_brightness(&mut planes, white_y as f32, Brightness::Plane(LUMINANCE))?;
    Ok(Image::new(picture.space(), planes)?)
}

/// What the brightness of a pixel is.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Brightness {
    /// The value of one plane.
    Plane(usize),
    /// The largest value of all planes, at least 0.
    Largest,
}

/// Scales the planes at every pixel whose brightness exceeds `limit` down to it, which keeps their ratios.
///
/// # Errors
/// When there is no such plane.
pub(crate) fn limit_brightness(
    planes: &mut Planes,
    limit: f32,
    brightness: Brightness,
) -> Result<(), ShapeError> {
    if let Brightness::Plane(index) = brightness {
        planes.plane(index)?;
    }
    dispatch(LimitBrightness { planes: planes.planes_mut().collect(), limit, brightness });
    Ok(())
}

/// [`limit_brightness`] of planes of equal length.
struct LimitBrightness<'a> {
    planes: Vec<&'a mut [f32]>,
    limit: f32,
    brightness: Brightness,
}

impl Kernel for LimitBrightness<'_> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        /// Pixels whose factors stay in the L1 cache.
        const PIECE: usize = 1024;
        let len = self.planes.first().map_or(0, |plane| plane.len());
        let mut factors = [0.0f32; PIECE];
        for first in (0..len).step_by(PIECE) {
            let piece = first..len.min(first + PIECE);
            let factors = &mut factors[..piece.len()];
            match self.brightness {
                Brightness::Plane(index) => factors.copy_from_slice(&self.planes[index][piece.clone()]),
                Brightness::Largest => {
                    factors.fill(0.0);
                    for plane in &self.planes {
                        factors.iter_mut().zip(&plane[piece.clone()]).for_each(|(l, v)| *l = l.max(*v));
                    }
                }
            }
            // A factor of 1 keeps the bits, so that no pixel is a case of its own and the loops are vector code.
            factors.iter_mut().for_each(|b| *b = if *b > self.limit { self.limit / *b } else { 1.0 });
            for plane in &mut self.planes {
                plane[piece.clone()].iter_mut().zip(&*factors).for_each(|(v, factor)| *v *= factor);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::ColorSpace;

    const WHITE: [f64; 3] = [0.9504, 1.0, 1.0888];

    /// As a loop over pixels does it, in pictures of several pieces.
    #[test]
    fn brightness_is_limited_pixel_by_pixel() {
        let count = 2 * 1024 + 5;
        let value = |i: usize| [0.3, 2.0, -1.0, 1.5, f32::NAN, 4.0][i * i % 31 % 6];
        let data: Vec<f32> = (0..3 * count).map(value).collect();
        let limited = |brightness| {
            let mut planes = Planes::new(1, count, 3, data.clone()).unwrap();
            limit_brightness(&mut planes, 1.5, brightness).map(|()| planes)
        };
        let check = |found: Planes, brightness: &dyn Fn([f32; 3]) -> f32| {
            for i in 0..count {
                let pixel = [0, 1, 2].map(|c| data[c * count + i]);
                let brightness = brightness(pixel);
                let factor = if brightness > 1.5 { 1.5 / brightness } else { 1.0 };
                let of_pixel = [0, 1, 2].map(|c| found.data()[c * count + i].to_bits());
                assert_eq!(of_pixel, pixel.map(|v| (v * factor).to_bits()), "{i}");
            }
        };
        check(limited(Brightness::Plane(1)).unwrap(), &|pixel| pixel[1]);
        check(limited(Brightness::Largest).unwrap(), &|pixel| pixel.into_iter().fold(0.0, f32::max));
        assert!(limited(Brightness::Plane(3)).is_err());
    }

    fn picture(y: impl Fn(usize) -> f32) -> Image {
        let data = WHITE.iter().flat_map(|&w| (0..40 * 50).map(|i| y(i) * w as f32).collect::<Vec<_>>());
        Image::new(ColorSpace::Xyz, Planes::new(40, 50, 3, data.collect()).unwrap()).unwrap()
    }

    fn ramp(i: usize) -> f32 {
        0.1 + 0.9 * (i % 50) as f32 / 49.0
    }

    fn score(picture: &Image, reference: &Image) -> PictureScores {
        score_picture(picture, reference, WHITE, &ScoreSettings::default()).unwrap()
    }

    #[test]
    fn a_map_of_another_size_is_an_error() {
        let map = |values| DifferenceMap { rows: 2, cols: 3, values };
        assert!(
            matches!(one_plane(map(vec![1.0; 5])), Err(MetricError::Shape(e)) if (e.expected, e.got) == (6, 5))
        );
        assert_eq!(one_plane(map(vec![1.0; 6])).unwrap().data(), [1.0; 6]);
    }

    #[test]
    fn the_reference_itself_is_perfect() {
        let s = score(&picture(ramp), &picture(ramp));
        assert_eq!(s.cpsnr_db, f64::INFINITY);
        assert_eq!((s.pixel_delta_e_2000_mean, s.pixel_delta_e_2000_p95, s.scielab_mean), (0.0, 0.0, 0.0));
        for map in [&s.delta_e_2000_map, &s.scielab_map] {
            assert_eq!((map.rows(), map.cols(), map.count()), (40, 50, 1));
            assert!(map.data().iter().all(|v| *v == 0.0));
        }
    }

    /// The map of CIEDE2000 is local, that of S-CIELAB is blurred. Mean and 95th percentile are those of the map.
    #[test]
    fn the_maps_show_where_pictures_differ() {
        let spoiled = |i: usize| ramp(i) * if (10..20).contains(&(i / 50)) { 0.8 } else { 1.0 };
        let s = score(&picture(spoiled), &picture(ramp));
        let rows: Vec<&[f32]> = s.delta_e_2000_map.data().chunks(50).collect();
        for (r, row) in rows.iter().enumerate() {
            assert!(row.iter().all(|v| (*v > 1.0) == (10..20).contains(&r)), "row {r}: {row:?}");
            assert!((10..20).contains(&r) || row.iter().all(|v| *v == 0.0), "row {r}: {row:?}");
        }
        assert!(s.scielab_map.data()[9 * 50 + 40] > 0.1, "blurred over the border");
        let mut sorted = s.delta_e_2000_map.data().to_vec();
        sorted.sort_by(f32::total_cmp);
        let mean = sorted.iter().map(|v| f64::from(*v)).sum::<f64>() / 2000.0;
        assert!((s.pixel_delta_e_2000_mean / mean - 1.0).abs() < 1e-6);
        assert_eq!(s.pixel_delta_e_2000_p95, f64::from(sorted[1999 * 95 / 100]));
    }

    /// No scale is fitted: 3 % less light is an error of 3 % in every value.
    #[test]
    fn an_error_of_brightness_counts() {
        let s = score(&picture(|i| 0.97 * ramp(i)), &picture(ramp));
        let square = |f: &dyn Fn(usize) -> f64| (0..2000).map(|i| f(i).powi(2)).sum::<f64>() / 2000.0;
        let xyz = WHITE.iter().map(|w| w * w).sum::<f64>() / 3.0;
        let expected = -10.0 * (square(&|i| 0.03 * f64::from(ramp(i))) * xyz).log10();
        assert!((s.cpsnr_db - expected).abs() < 1e-3, "{} dB, not {expected}", s.cpsnr_db);
        // White at Y = 97 has L* = 98.8; all pixels are darker and differ by no more.
        assert!(s.scielab_mean > 0.5 && s.scielab_mean < 1.3, "{}", s.scielab_mean);
        assert!(s.pixel_delta_e_2000_mean > 0.3 && s.pixel_delta_e_2000_p95 >= s.pixel_delta_e_2000_mean);
    }

    /// A common scale of picture and reference does not change the scores.
    #[test]
    fn scores_do_not_depend_on_the_common_scale() {
        let noisy = |i: usize| ramp(i) + 0.01 * ((i * 7919 % 101) as f32 / 50.0 - 1.0);
        let one = score(&picture(noisy), &picture(ramp));
        let other = score(&picture(|i| 0.01 * noisy(i)), &picture(|i| 0.01 * ramp(i)));
        assert!((one.cpsnr_db - other.cpsnr_db).abs() < 1e-3);
        assert!((one.scielab_mean / other.scielab_mean - 1.0).abs() < 1e-3);
        assert!((one.pixel_delta_e_2000_p95 / other.pixel_delta_e_2000_p95 - 1.0).abs() < 1e-2);
    }

    /// A clipped lamp, ten thousand times as bright as the rest, does not affect the scores of the rest.
    #[test]
    fn what_a_display_cannot_show_does_not_count() {
        let lamp = |i: usize| if i < 5 { 1e4 } else { ramp(i) };
        let clipped = |i: usize| if i < 5 { 1.7 } else { 0.97 * ramp(i) };
        let (with, without) =
            (score(&picture(clipped), &picture(lamp)), score(&picture(|i| 0.97 * ramp(i)), &picture(ramp)));
        assert!((with.cpsnr_db - without.cpsnr_db).abs() < 0.1, "{} {}", with.cpsnr_db, without.cpsnr_db);
        let all = ScoreSettings { highlight_share: 0.0, ..ScoreSettings::default() };
        let brightest = score_picture(&picture(clipped), &picture(lamp), WHITE, &all).unwrap();
        assert_eq!(brightest.white_y, 1e4);
    }

    #[test]
    fn what_cannot_be_scored_is_refused() {
        let score = |p: &Image, r: &Image, s| score_picture(p, r, WHITE, &s);
        let (good, settings) = (picture(ramp), ScoreSettings::default());
        let undefined = score(&good, &picture(|_| 0.0), settings);
        assert!(matches!(undefined, Err(CameraError::Metric(MetricError::Undefined { .. }))));
        assert!(matches!(score(&picture(|_| f32::NAN), &good, settings), Err(CameraError::Image(_))));
        let share = ScoreSettings { highlight_share: 1.0, ..settings };
        assert!(score(&good, &good, share).is_err());
        let small = Image::new(ColorSpace::Xyz, Planes::zeros(2, 2, 3)).unwrap();
        assert!(score(&small, &good, settings).is_err());
        let srgb = Image::new(ColorSpace::Srgb, good.planes().clone()).unwrap();
        assert!(score(&srgb, &good, settings).is_err());
    }
}
