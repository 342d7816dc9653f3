//! The optical low-pass filter in front of a sensor.

use serde::Serialize;

use crate::numeric::{OutOfRange, require};

/// Two crossed birefringent plates that split every ray into four, at the corners of a rectangle. Their transfer
/// function is cos(π a fx) · cos(π b fy) (Greivenkamp 1990): the first zero lies at half the inverse separation,
/// so a separation of one pixel pitch removes what alternates from pixel to pixel.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct BirefringentLowPass {
    /// Distance of the spots along rows, m.
    pub horizontal_separation_m: f64,
    /// Distance of the spots along columns, m.
    pub vertical_separation_m: f64,
}

impl BirefringentLowPass {
    pub(super) fn check(&self) -> Result<(), OutOfRange> {
        for (name, v) in [
            ("olpf.horizontal_separation_m", self.horizontal_separation_m),
            ("olpf.vertical_separation_m", self.vertical_separation_m),
        ] {
            require(v >= 0.0, name, v, "0 or more")?;
        }
        Ok(())
    }

    /// Transfer at a frequency, cycles/m; −1 to 1.
    #[must_use]
    pub fn transfer(&self, fx_cy_per_m: f64, fy_cy_per_m: f64) -> f64 {
        use std::f64::consts::PI;
        (PI * self.horizontal_separation_m * fx_cy_per_m).cos()
            * (PI * self.vertical_separation_m * fy_cy_per_m).cos()
    }

    /// How far light is moved at most in one direction, m.
    pub(super) fn reach_m(&self) -> f64 {
        self.horizontal_separation_m.max(self.vertical_separation_m) / 2.0
    }
}
