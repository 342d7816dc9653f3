//! Learned pipelines and the statistics they are solved from.
//!
//! | door | file |
//! |---|---|
//! | [`write_table`], [`read_table`] | `.l3`: a [`Pipeline`], exactly |
//! | [`write_statistics`], [`read_statistics`] | `.l3s`: [`Statistics`], exactly, so that training can be shared out and continued |
//! | [`write_npz`] | `.npz`: the arrays of a table for NumPy |
//! | [`write_c_header`] | `.h`: the table in fixed point or single precision with a reference implementation in C99 |
//!
//! `.l3` and `.l3s` are [safetensors](https://huggingface.co/docs/safetensors) files; any program that reads these reads
//! them. `docs/formats-l3.md` lists their tensors and states how a raw image is rendered with them.
//!
//! [`Pipeline`]: smalti::l3::Pipeline
//! [`Statistics`]: smalti::l3::Statistics

mod axes;
mod c_header;
mod npz;
mod refinement;
mod statistics;
mod table;

pub use c_header::{CArithmetic, Operations, c_prefix, operations, write_c_header};
pub use npz::write_npz;
pub(crate) use statistics::statistics_pieces;
pub use statistics::{read_statistics, statistics_from_bytes, write_statistics};
pub(crate) use table::table_pieces;
pub use table::{read_table, table_from_bytes, table_to_bytes, write_table};

/// What a file of another kind is not.
const EXPECTED: &str = "a learned table of Smalti (.l3, a safetensors file)";
