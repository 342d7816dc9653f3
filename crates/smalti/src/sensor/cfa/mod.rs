//! Colour filter arrays: a tile of channel indices and one spectral sensitivity per channel.
//!
//! The types are [`Mosaic`] and [`Cfa`]. [`Filter`] provides curves by formula or name, [`builtin`] whole
//! arrays by name, [`WeightedMosaic`] arrays whose cells are mixtures, and [`blue_noise`] random arrays.

mod catalog;
mod catalog_data;
mod catalog_entry;
mod curves;
mod filters;
mod generated;
mod mixture;
mod mosaic;
mod named;
mod pattern;
mod random;
mod shapes;

pub use catalog::{builtin, builtin_with, default_filters, info, names, pattern};
pub use catalog_entry::CfaInfo;
pub use filters::{AbsorptionBand, Filter};
pub use mixture::{Modulation, WeightedMosaic};
pub use mosaic::{Cfa, CfaError, Channel, Mosaic};
pub use named::{FilterInfo, builtin_filters};
pub use pattern::BayerPhase;
pub use random::blue_noise;
