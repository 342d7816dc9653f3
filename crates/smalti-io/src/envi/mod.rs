//! ENVI: a text header (`.hdr`) and a file of samples beside it.

mod header;
mod read;
mod write;

pub(crate) use read::header_beside;
pub use read::{from_bytes, open};
pub use write::{Interleave, write};
