//! Files of learned pipelines.

mod c_header;
mod c_header_float;
mod cache;
mod files;
mod fixtures;
mod judges;
