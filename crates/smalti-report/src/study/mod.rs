//! The report of studies: the best designs, means and fronts of many designs as tables, a page, figures and one JSON document.
//!
//! Everything is made from plain data, [`StudyResults`](smalti::design::StudyResults). The caller reads the results and stores the files.

mod book;
mod camera;
mod document;
mod figures;
mod filters;
mod page;
mod pictures;
mod report;
mod results;
mod sections;
mod text;

pub use camera::camera_toml;
pub use figures::figure_files;
pub use report::{DOCUMENT, PAGE, Report, ReportSettings};
pub use results::Results;
