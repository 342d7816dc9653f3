//! Files of learned pipelines.

mod c_header;
mod cache;
mod files;
mod fixtures;
mod judges;
