//! Searching for colour filter arrays: families of filters and mosaics, studies of them, their scores.

mod prepared;
mod targets;

pub use targets::{Scores, Targets};
