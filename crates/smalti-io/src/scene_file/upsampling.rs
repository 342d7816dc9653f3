//! How pictures become spectra.

use smalti::color::Image;
use smalti::color::jakob_hanika2019::{Uplift, UpliftError};
use smalti::color::repaint::Repaint;
use smalti::spectrum::{Observer, SpectralCube, WavelengthGrid};

/// How the pixels of a picture are upsampled to reflectances. Both have the colours of the picture under D65.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Upsampling {
    /// Smooth reflectances with three coefficients ([`Uplift`]). They depend on the colour of the pixel alone.
    #[default]
    Smooth,
    /// Mixtures of measured reflectances whose colours are near that of the segment around the pixel ([`Repaint`]).
    Measured,
}

impl Upsampling {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Smooth, Self::Measured];

    /// The name in options.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Smooth => "smooth",
            Self::Measured => "measured",
        }
    }

    /// The reflectances of a picture in linear sRGB.
    pub(crate) fn spectra(self, image: &Image, grid: WavelengthGrid) -> Result<SpectralCube, UpliftError> {
        match self {
            Self::Smooth => Uplift::new(grid, Observer::Cie1931)?.uplift_image(image),
            Self::Measured => Repaint::new(grid, Observer::Cie1931)?.repaint_image(image),
        }
    }
}
