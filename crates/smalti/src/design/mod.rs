//! Many cameras: what a study of designs says.

pub mod statistics;
