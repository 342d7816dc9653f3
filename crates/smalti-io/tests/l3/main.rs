//! Files of learned pipelines.
#![allow(clippy::unwrap_used, clippy::panic)]

mod c_header;
mod c_header_float;
mod cache;
mod files;
mod fixtures;
mod judges;
#[path = "../support/python.rs"]
mod python;
