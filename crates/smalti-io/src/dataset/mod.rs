//! The results of a sweep: a folder of Parquet files, one row a trial, and a manifest. `docs/formats-dataset.md` describes it.
//!
//! ```text
//! DIR/manifest.json                   what was computed (the plan), its hash, how long each run took
//! DIR/trials/part-000000.parquet     one file per chunk of consecutive trials
//! ```
//!
//! [`Run::open`] makes or continues such a folder, [`Dataset::open`] reads one, [`merge`] puts those of shards together. Nothing
//! here knows what the columns mean: a [`Plan`] names them, and rows come as [`Column`]s of plain values.
//!
//! The bytes of a part follow from the plan and its values alone. Whoever writes it, in whatever order, with whatever threads,
//! shards or interruptions: the files are the same. Only the timings in the manifest differ.
//!
//! Every part is written whole under a temporary name, forced to the disk and renamed. A part that is there is complete, also
//! after a loss of power; a run that is killed loses only the chunks it was at.

mod difference;
mod error;
mod folder;
mod lock;
mod manifest;
mod merge;
mod part;
mod read;
mod remote;
mod run;
mod schema;
mod shard;

pub use difference::{Difference, Differences};
pub use error::{DatasetError, PartProblem};
pub use folder::{part_name, write_part};
pub use manifest::{Manifest, Plan, RunRecord};
pub use merge::merge;
pub use part::{encode, part_from_bytes};
pub use read::{Dataset, Part, Rows};
pub use remote::RemoteDataset;
pub use run::Run;
pub use schema::{Column, ColumnKind, ColumnSpec};
pub use shard::{Shard, ShardError};

/// Revision of the layout of folder, manifest and parts. Another one is refused.
pub const REVISION: u64 = 2;
/// Most trials of a chunk: a part is held in memory.
pub const MAX_CHUNK: u64 = 1 << 20;
/// Most chunks of a dataset: part numbers have six digits, so that files sort by name.
pub const MAX_PARTS: u64 = 1_000_000;
/// Most values in the lists of one column of one part.
pub const MAX_LIST_VALUES: usize = 1 << 24;
/// Most bytes of text in one column of one part.
pub const MAX_TEXT_BYTES: usize = 1 << 28;
