//! The kinds of processing in a comparison.

use crate::isp::Demosaic;
use crate::sensor::Mosaic;

/// A kind of processing in a comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Processing {
    /// An L³ pipeline trained for the camera.
    L3,
    /// Demosaicking and a colour matrix.
    Classic(Demosaic),
}

impl Processing {
    /// All kinds of processing, the learned one first.
    #[must_use]
    pub fn all() -> Vec<Self> {
        std::iter::once(Self::L3).chain(Demosaic::ALL.map(Self::Classic)).collect()
    }

    /// Its name on the command line and in results.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::L3 => "l3",
            Self::Classic(demosaic) => demosaic.name(),
        }
    }

    /// Whether it is defined for a mosaic.
    #[must_use]
    pub fn is_defined_for(self, mosaic: &Mosaic) -> bool {
        match self {
            Self::L3 => true,
            Self::Classic(demosaic) => demosaic.is_defined_for(mosaic),
        }
    }
}
