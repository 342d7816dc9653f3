//! Position and size of the image.

use super::error::OpticsError;
use crate::numeric::{OutOfRange, require};

/// A thin lens in front of a plane scene, in air.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Geometry {
    image_distance_m: f64,
    magnification: f64,
    working_f_number: f64,
}

impl Geometry {
    /// The image of a scene at `distance_m` (may be infinite), by the lens equation 1/f = 1/s + 1/s'.
    ///
    /// # Errors
    /// When focal length or f-number is not positive and finite, or the scene is not beyond the focal length.
    pub fn thin_lens(focal_length_m: f64, f_number: f64, distance_m: f64) -> Result<Self, OpticsError> {
        check_lens(focal_length_m, f_number)?;
        let too_near = OpticsError::SceneTooNear { distance_m, focal_length_m };
        if distance_m.is_nan() || distance_m <= focal_length_m {
            return Err(too_near);
        }
        let magnification = -focal_length_m / (distance_m - focal_length_m);
        let image_distance_m = focal_length_m * (1.0 - magnification);
        // A scene that is beyond the focal length by a rounding error is imaged at infinity.
        if !image_distance_m.is_finite() {
            return Err(too_near);
        }
        let working_f_number = f_number * (1.0 - magnification);
        Ok(Self { image_distance_m, magnification, working_f_number })
    }

    /// The geometry of a pinhole, which does not focus. The image plane is at the focal length for any scene
    /// distance, and the magnification term of the camera equation is absent.
    ///
    /// # Errors
    /// When focal length or f-number is not positive and finite.
    pub fn pinhole(focal_length_m: f64, f_number: f64) -> Result<Self, OpticsError> {
        check_lens(focal_length_m, f_number)?;
        Ok(Self { image_distance_m: focal_length_m, magnification: 0.0, working_f_number: f_number })
    }

    /// Distance from the lens to the image, m.
    #[must_use]
    pub fn image_distance_m(&self) -> f64 {
        self.image_distance_m
    }

    /// Image size over object size. It is negative because the image is inverted; the samples ignore the
    /// inversion (row 0 remains the top of the scene).
    #[must_use]
    pub fn magnification(&self) -> f64 {
        self.magnification
    }

    /// The working f-number N (1 + |m|), which determines irradiance and diffraction.
    #[must_use]
    pub fn working_f_number(&self) -> f64 {
        self.working_f_number
    }

    /// On-axis irradiance over radiance of a lossless lens, sr: π / (1 + 4 N² (1 + |m|)²).
    #[must_use]
    pub fn irradiance_per_radiance_sr(&self) -> f64 {
        std::f64::consts::PI / (1.0 + 4.0 * self.working_f_number * self.working_f_number)
    }

    /// Sample spacing on the sensor, m, for a scene with `cols` samples over a field of view: 2 s' tan(fov /
    /// 2) / cols.
    #[must_use]
    pub fn sample_spacing_m(&self, horizontal_fov_deg: f64, cols: usize) -> f64 {
        2.0 * self.image_distance_m * (horizontal_fov_deg.to_radians() / 2.0).tan() / cols as f64
    }
}

fn check_lens(focal_length_m: f64, f_number: f64) -> Result<(), OutOfRange> {
    require(focal_length_m > 0.0, "focal_length_m", focal_length_m, "more than 0")?;
    require(f_number > 0.0, "f_number", f_number, "more than 0")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lens_equation_holds() {
        let g = Geometry::thin_lens(0.05, 2.0, 0.4).unwrap();
        assert!((1.0 / 0.05 - 1.0 / 0.4 - 1.0 / g.image_distance_m()).abs() < 1e-12);
        assert!((g.magnification() + g.image_distance_m() / 0.4).abs() < 1e-12);
    }

    #[test]
    fn unit_magnification_at_twice_the_focal_length() {
        let g = Geometry::thin_lens(0.05, 2.0, 0.1).unwrap();
        assert!((g.magnification() + 1.0).abs() < 1e-12 && (g.working_f_number() - 4.0).abs() < 1e-12);
    }

    #[test]
    fn a_scene_at_infinity_images_at_the_focal_length() {
        let g = Geometry::thin_lens(0.05, 2.0, f64::INFINITY).unwrap();
        assert_eq!((g.image_distance_m(), g.working_f_number()), (0.05, 2.0));
    }

    #[test]
    fn impossible_lenses_are_refused() {
        for (f, n, d) in [(0.0, 2.0, 1.0), (0.05, 0.0, 1.0), (0.05, f64::NAN, 1.0), (f64::NAN, 2.0, 1.0)] {
            assert!(matches!(Geometry::thin_lens(f, n, d), Err(OpticsError::Parameter { .. })));
        }
        for d in [0.05, 0.01, -1.0, f64::NAN] {
            assert!(matches!(Geometry::thin_lens(0.05, 2.0, d), Err(OpticsError::SceneTooNear { .. })));
        }
    }

    proptest::proptest! {
        #[test]
        fn any_lens_before_any_scene_has_an_image(f in 1e-4..1.0f64, n in 0.5..64.0f64, d in 1e-4..1e6f64) {
            match Geometry::thin_lens(f, n, d) {
                Ok(g) => {
                    assert!(d > f && g.magnification() < 0.0 && g.image_distance_m() >= f);
                    assert!((1.0 / f - 1.0 / d - 1.0 / g.image_distance_m()).abs() < 1e-9 / f);
                    assert!(g.working_f_number() >= n && g.irradiance_per_radiance_sr() > 0.0);
                }
                Err(e) => assert!(d <= f, "{e}"),
            }
        }
    }
}
