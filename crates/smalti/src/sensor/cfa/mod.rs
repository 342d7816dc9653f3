//! Colour filter arrays: a tile of channel indices and one spectral sensitivity per channel.

mod mosaic;

pub use mosaic::{Cfa, CfaError, Channel, Mosaic};
