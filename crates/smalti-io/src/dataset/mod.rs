//! Results of a sweep: a folder of Parquet files with one row per trial, and a manifest. `docs/formats-dataset.md` has the format.
//!
//! ```text
//! DIR/manifest.json                  the plan, its hash and the timings of the runs
//! DIR/trials/part-000000.parquet     one file per chunk of consecutive trials
//! ```
//!
//! [`Run::open`] creates or resumes such a folder, [`Dataset::open`] reads one, and [`merge`] combines the folders of shards. The
//! meaning of the columns is not known here: a [`Plan`] names them, and their values are plain [`Column`]s.
//!
//! The bytes of a part depend only on the plan and the values. They do not depend on the order of writing, the number of threads and
//! shards, or interruptions. Only the runs in the manifest differ.
//!
//! Each part is written under a temporary name, flushed to disk and then renamed. A part that exists is therefore complete, even
//! after a power failure. A killed run loses only its current chunks.

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

/// Revision of the format of folder, manifest and parts. Other revisions are refused.
pub const REVISION: u64 = 2;
/// Maximum number of trials in a chunk, since a part is held in memory.
pub const MAX_CHUNK: u64 = 1 << 20;
/// Maximum number of chunks in a dataset. Part numbers have six digits, so that files sort by name.
pub const MAX_PARTS: u64 = 1_000_000;
/// Maximum number of values in the lists of one column of a part.
pub const MAX_LIST_VALUES: usize = 1 << 24;
/// Maximum length of the text in one column of a part, bytes.
pub const MAX_TEXT_BYTES: usize = 1 << 28;
