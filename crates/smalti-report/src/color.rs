//! Colours that readers with any colour vision can distinguish, and the colours of wavelengths.

use std::fmt;

/// A colour of the display, 8-bit sRGB.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Rgb(
    /// Red.
    pub u8,
    /// Green.
    pub u8,
    /// Blue.
    pub u8,
);

impl fmt::Display for Rgb {
    /// As in SVG, `#rrggbb`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "#{:02x}{:02x}{:02x}", self.0, self.1, self.2)
    }
}

/// The palette of [okabe2008] for categories, with darker colours first and yellow, which is too pale for dots on white, last.
///
/// [okabe2008]: https://jfly.uni-koeln.de/color/
pub const OKABE_ITO: [Rgb; 8] = [
    Rgb(0, 114, 178),
    Rgb(213, 94, 0),
    Rgb(0, 158, 115),
    Rgb(204, 121, 167),
    Rgb(86, 180, 233),
    Rgb(230, 159, 0),
    Rgb(60, 60, 60),
    Rgb(240, 228, 66),
];

/// Every 15th entry of Matplotlib's viridis ([smith2015]); linear interpolation is within 5 of 255.
const VIRIDIS: [u32; 18] = [
    0x440154, 0x481769, 0x472a7a, 0x433d84, 0x3d4e8a, 0x355e8d, 0x2e6d8e, 0x297b8e, 0x23898e, 0x1f978b,
    0x21a585, 0x2eb37c, 0x46c06f, 0x65cb5e, 0x89d548, 0xb0dd2f, 0xd8e219, 0xfde725,
];

impl Rgb {
    /// The colour of viridis at `t` from 0 to 1, whose equal steps look equal, also in grey. Values outside have the colour of the nearer
    /// end, and NaN that of the low end.
    #[must_use]
    pub fn viridis(t: f64) -> Self {
        let t = if t.is_nan() { 0.0 } else { t.clamp(0.0, 1.0) };
        let position = t * (VIRIDIS.len() - 1) as f64;
        let index = (position as usize).min(VIRIDIS.len() - 2);
        let at = |i: usize| {
            VIRIDIS.get(i).map_or(Self(0, 0, 0), |v| Self((v >> 16) as u8, (v >> 8) as u8, *v as u8))
        };
        at(index).mix(at(index + 1), position - index as f64)
    }

    /// The colour `t` of the way to another, 0 to 1, in sRGB values.
    #[must_use]
    pub fn mix(self, other: Self, t: f64) -> Self {
        let one = |a: u8, b: u8| (f64::from(a) + (f64::from(b) - f64::from(a)) * t).round() as u8;
        Self(one(self.0, other.0), one(self.1, other.1), one(self.2, other.2))
    }

    /// The approximate colour of a wavelength at the maximum brightness of the display; near black beyond 380–720 nm.
    #[must_use]
    pub fn of_wavelength(wavelength_nm: f64) -> Self {
        // The ends of the visible range fade as in a photograph of a spectrum.
        let fade = ((wavelength_nm - 375.0) / 45.0).min((730.0 - wavelength_nm) / 60.0).clamp(0.12, 1.0);
        display(matching(wavelength_nm), fade)
    }

    /// The approximate colour of a filter under equal-energy light, for curves and for cells of mosaics: the perceived hue, dark enough to
    /// contrast with white. A filter that transmits all wavelengths is light grey.
    ///
    /// Takes wavelengths in nanometres and as many transmittances on any scale; values that are not positive are ignored.
    #[must_use]
    pub fn of_transmittance(wavelengths_nm: &[f64], transmittance: &[f64]) -> Self {
        let mut xyz = [0.0; 3];
        for (wavelength, t) in wavelengths_nm.iter().zip(transmittance) {
            if *t > 0.0 && t.is_finite() {
                xyz.iter_mut().zip(matching(*wavelength)).for_each(|(sum, m)| *sum += m * t);
            }
        }
        let full = display(xyz, 0.75).mix(Self(128, 128, 128), 0.1);
        // Light colours (yellow, cyan, white) are darkened so that lines are visible on white.
        full.mix(Self(0, 0, 0), (1.0 - 145.0 / full.luma()).clamp(0.0, 1.0))
    }

    /// Black or white, whichever is more legible on this colour.
    #[must_use]
    pub fn ink(self) -> Self {
        if self.luma() > 120.0 { Self(0, 0, 0) } else { Self(255, 255, 255) }
    }

    fn luma(self) -> f64 {
        (0.299 * f64::from(self.0) + 0.587 * f64::from(self.1) + 0.114 * f64::from(self.2)).max(1.0)
    }
}

/// The CIE 1931 colour-matching functions after the fit of [wyman2013]. Its tails have the wrong hue, so beyond
/// 415–655 nm, where hue hardly changes, the functions fade out like those of the eye.
fn matching(wavelength_nm: f64) -> [f64; 3] {
    let nm = wavelength_nm.clamp(415.0, 655.0);
    let fade = libm::exp(-((nm - wavelength_nm) / 9.0).max((wavelength_nm - nm) / 15.0).max(0.0));
    let lobe = |center: f64, left: f64, right: f64| {
        let t = (nm - center) * if nm < center { left } else { right };
        fade * libm::exp(-0.5 * t * t)
    };
    [
        0.362 * lobe(442.0, 0.0624, 0.0374) + 1.056 * lobe(599.8, 0.0264, 0.0323)
            - 0.065 * lobe(501.1, 0.0490, 0.0382),
        0.821 * lobe(568.8, 0.0213, 0.0247) + 0.286 * lobe(530.9, 0.0613, 0.0322),
        1.217 * lobe(437.0, 0.0845, 0.0278) + 0.681 * lobe(459.0, 0.0385, 0.0725),
    ]
}

/// XYZ as sRGB. Colours outside the gamut are desaturated with white, and the brightest channel becomes `peak`.
fn display(xyz: [f64; 3], peak: f64) -> Rgb {
    let [x, y, z] = xyz;
    let mut linear = [
        3.2406 * x - 1.5372 * y - 0.4986 * z,
        -0.9689 * x + 1.8758 * y + 0.0415 * z,
        0.0557 * x - 0.2040 * y + 1.0570 * z,
    ];
    let missing = linear.iter().copied().fold(0.0, f64::min);
    linear.iter_mut().for_each(|v| *v -= missing);
    let top = linear.iter().copied().fold(0.0, f64::max);
    let [r, g, b] = linear.map(|v| {
        let v = if top > 0.0 { v / top * peak } else { 0.0 };
        let coded = if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * libm::pow(v, 1.0 / 2.4) - 0.055 };
        (coded * 255.0).round() as u8
    });
    Rgb(r, g, b)
}
