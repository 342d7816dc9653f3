//! A part as a Parquet file: encoding, metadata and decoding.

mod decode;
mod encode;
mod marks;
#[cfg(test)]
mod tests;

pub use decode::part_from_bytes;
pub(super) use decode::{LIMIT, read};
pub use encode::encode;
pub(super) use marks::{quick_check, stated_hash};
