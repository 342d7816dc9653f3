//! Work that is slow, not wrong, is done for some inputs alone.

/// Whether an input is one of the few, about one in `many`. Equal inputs give equal answers, so that findings can be reproduced.
pub fn one_in(many: u32, input: &[u8]) -> bool {
    let hash = input.iter().fold(0u32, |hash, byte| hash.wrapping_mul(31).wrapping_add((*byte).into()));
    hash % many == 0
}
