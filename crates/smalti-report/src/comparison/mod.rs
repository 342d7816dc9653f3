//! The report of a comparison or an evaluation of cameras: pages, tables, pictures and one JSON document.
//!
//! Everything is made from plain data, [`Comparison`] and [`Evaluations`]. The caller stores the files.

mod again;
mod chart;
pub mod columns;
mod conditions;
mod crops;
mod document;
mod evaluated;
mod evaluated_text;
pub(crate) mod figures;
mod gallery;
mod kernels;
mod learned;
mod maps;
mod page;
mod results;
mod sheets;
mod stated;
mod summary;
mod tables;
mod target_times;
mod text;
pub(crate) mod verdict;

pub use conditions::Conditions;
pub use evaluated::{Evaluations, aliasing_picture, page as evaluation_page};
pub use evaluated_text::text as evaluation_text;
pub use page::page;
pub use results::{CameraArgument, CommandLine, Comparison};
pub use sheets::{PAGE, SIDE_BY_SIDE};
pub use stated::Stated;
