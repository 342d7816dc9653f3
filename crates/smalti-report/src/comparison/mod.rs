//! The report of a comparison or an evaluation of cameras: pages, tables, pictures and one JSON document.
//!
//! All is made of plain data, [`Comparison`] and [`Evaluations`]. The caller stores what is made.

mod again;
pub mod columns;
mod conditions;
mod document;
mod evaluated;
mod figures;
mod gallery;
mod kernels;
mod learned;
mod maps;
mod page;
mod results;
mod sheets;
mod tables;
mod text;

pub use evaluated::{Evaluations, aliasing_picture, page as evaluation_page};
pub use page::page;
pub use results::{CameraArgument, CommandLine, Comparison};
pub use sheets::{PAGE, SIDE_BY_SIDE};
