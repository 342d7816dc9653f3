//! A server on 127.0.0.1 for pages of Smalti that need one.
//!
//! [`LocalServer`] admits a request only if it has the token of the address and comes from a page of its own origin, and states a strict
//! content security policy with every answer. [`rating`] has the pages of a rating experiment, [`studio`] the page on which designs are made. A page is a
//! router of `axum`; its files are embedded in the program.

#![forbid(unsafe_code)]

mod address;
mod error;
mod guard;
mod local;
mod opening;
mod pages;
pub mod rating;
pub mod studio;

pub use address::Address;
pub use error::ServeError;
pub use local::LocalServer;
pub use opening::OpeningFile;
