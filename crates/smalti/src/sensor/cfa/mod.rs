//! Colour filter arrays: a tile of channel indices and one spectral sensitivity per channel.
//!
//! [`Mosaic`] and [`Cfa`] are the types; [`Filter`] gives curves by formula or name, [`builtin`] whole arrays by
//! name, [`WeightedMosaic`] those whose cells are mixtures, [`blue_noise`] random ones.

mod catalog;
mod catalog_data;
mod filters;
mod generated;
mod mixture;
mod mosaic;
mod named;
mod pattern;
mod random;

pub use catalog::{CfaInfo, builtin, builtin_with, info, names, pattern};
pub use filters::{AbsorptionBand, Filter};
pub use mixture::{Modulation, WeightedMosaic};
pub use mosaic::{Cfa, CfaError, Channel, Mosaic};
pub use named::{FilterInfo, builtin_filters};
pub use pattern::BayerPhase;
pub use random::blue_noise;
