//! A request for some of the mosaics of a family, and their choice.

use crate::design::error::DesignError;
use crate::design::permutation::Permutation;
use crate::sensor::Mosaic;

/// Purpose key of the random numbers that choose mosaics.
pub(super) const PURPOSE: u32 = 0x4453_4E02;

/// The name of a `[mosaics.tile]` in errors.
pub(super) const THIS_TILE: &str = "this tile";

/// Number of requested mosaics, number of available mosaics, and the limit of a list.
#[derive(Debug, Clone, Copy)]
pub(in crate::design) struct MosaicRequest {
    pub(in crate::design) count: u64,
    pub(super) available: u128,
    pub(in crate::design) limit: u64,
}

/// All mosaics in their order, or a random sample of them.
pub(super) fn sampled(
    all: Vec<Mosaic>,
    count: u64,
    colors: usize,
    seed: u64,
) -> Result<Vec<Mosaic>, DesignError> {
    if count == all.len() as u64 {
        return Ok(all);
    }
    let order = Permutation::new(all.len() as u128, seed, PURPOSE, colors as u32);
    let places = (0..u128::from(count)).filter_map(|i| order.at(i));
    Ok(places.filter_map(|i| all.get(i as usize).cloned()).collect())
}
