//! The folder of a rating experiment: its manifest, its pictures, and the answers of each observer in a file of their own. Files of
//! experiments that can be made.

mod answers;
mod choices;
mod manifest;
mod preset;

pub use answers::{
    ANSWERS, AnswerFile, AnswerFolder, Answered, Display, Observer, observer_from_bytes, read_observers,
    secret_hash, write_table,
};
pub use choices::choices;
pub use manifest::{
    Condition, MANIFEST, Manifest, PICTURES, PictureFile, Planned, SceneFiles, from_bytes, read, write,
};
pub use preset::{LightExperiment, load, names};
