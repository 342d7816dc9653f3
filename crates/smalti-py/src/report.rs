//! The report of studies.

use std::path::PathBuf;

use pyo3::prelude::*;
use smalti_io::sweeps::read_results;
use smalti_io::write;
use smalti_report::study::{DOCUMENT, PAGE, Report, ReportSettings, Results, figure_files};

use crate::error::{OrRaise, wrong};
use crate::json::loads;
use crate::work::{Told, watched};

#[pyfunction]
pub(crate) fn write_report<'py>(
    py: Python<'py>,
    results: Vec<PathBuf>,
    output: Option<PathBuf>,
    pictures: u16,
    picture: Vec<u64>,
    draw: Vec<String>,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let settings = ReportSettings { pictures: usize::from(pictures), requested: picture, draw };
    let Some(first) = results.first() else {
        return Err(wrong("no results are given; expected a folder that a sweep wrote"));
    };
    let folder = output.unwrap_or_else(|| first.join("report"));
    let document = watched(py, progress.map(Told::Pictures), |watch| {
        let read = |dir: &PathBuf| {
            watch.check()?;
            Results::new(read_results(dir).or_raise()?).or_raise()
        };
        let studies = results.iter().map(read).collect::<PyResult<Vec<_>>>()?;
        let page_alone = folder.extension().is_some_and(|e| e.eq_ignore_ascii_case("html"));
        if page_alone { write::ensure_can_write(&folder) } else { write::ensure_can_fill(&folder) }
            .or_raise()?;
        let mut report = Report::new(&studies, &settings).or_raise()?;
        let page = report.page(watch).or_raise()?;
        if page_alone {
            write::bytes(&folder, page.as_bytes()).or_raise()?;
            return report.document().or_raise();
        }
        let mut files = write::Files::new(&folder, &[DOCUMENT, PAGE], &figure_files());
        report.store(&page, &mut |name, bytes| Ok(files.write(name, bytes)?), watch).or_raise()
    })?;
    loads(py, &document)
}
