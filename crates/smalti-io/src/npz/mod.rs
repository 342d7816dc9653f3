//! NumPy: a single array (`.npy`) or an archive of named ones (`.npz`) that holds a cube and its wavelengths.

mod array;
mod read;
mod write;
mod zip;
pub(crate) mod zip_write;

pub use read::{from_bytes, open};
pub use write::{write, write_npy};
