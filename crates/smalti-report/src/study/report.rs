//! The report of one or several studies: tables, one document, a page and figures.

use smalti::experiment::Progress;

use super::book::{Book, DRAWN};
use super::page::{self, Sources};
use super::results::Results;
use super::sections::Section;
use super::{document, figures, text};
use crate::words::TextTable;
use crate::{FileSink, ReportError, names};

/// The file of the document. A report writes it last, so that its presence shows that a folder is complete.
pub const DOCUMENT: &str = "report.json";
/// The file of the page.
pub const PAGE: &str = "report.html";

/// What a report is to contain.
#[derive(Debug, Clone, Default)]
pub struct ReportSettings {
    /// How many trials with learned pipelines have embedded pictures in the page.
    pub pictures: usize,
    /// Trials of the first study, by their numbers, with embedded pictures in the page.
    pub requested: Vec<u64>,
    /// A condition has its own tables in the text and its own figures if its name contains one of these texts. If empty, the first
    /// conditions have them.
    pub draw: Vec<String>,
}

/// The report of studies.
///
/// The page and the figures are the long work: [`page`](Self::page) and [`store`](Self::store) call
/// [`Progress::picture`] after each picture and ask [`Progress::is_stopped`] before.
pub struct Report<'a> {
    all: Vec<(&'a Results, Vec<Section<'a>>)>,
    settings: &'a ReportSettings,
    figures: Vec<String>,
    notes: Vec<String>,
}

impl<'a> Report<'a> {
    /// Finds the best designs, the means and the fronts of each condition and processing.
    ///
    /// # Errors
    /// When statistics cannot be computed, or a design cannot be made.
    pub fn new(studies: &'a [Results], settings: &'a ReportSettings) -> Result<Self, ReportError> {
        let all = studies.iter().map(|r| Ok((r, Section::all(r)?))).collect::<Result<_, ReportError>>()?;
        Ok(Self { all, settings, figures: Vec::new(), notes: Vec::new() })
    }

    /// The report in words and tables. `table` lays out a header and rows of cells as lines.
    ///
    /// # Errors
    /// [`ReportError::NoSuchCondition`]; when a design cannot be made.
    pub fn text(&self, table: &TextTable<'_>) -> Result<String, ReportError> {
        let wanted = &self.settings.draw;
        if wanted.is_empty() {
            let first: Vec<Vec<&Section<'_>>> =
                self.all.iter().map(|(_, sections)| sections.iter().take(text::TABLES).collect()).collect();
            return text::text(&self.all, &first, table);
        }
        let sections: Vec<&Section<'_>> = self.all.iter().flat_map(|(_, s)| s).collect();
        let named = chosen(&sections, wanted)?;
        let of_study = |(results, _): &(&Results, _)| {
            named.iter().copied().filter(|s| std::ptr::eq(s.results, *results)).collect()
        };
        let shown: Vec<Vec<&Section<'_>>> = self.all.iter().map(of_study).collect();
        text::text(&self.all, &shown, table)
    }

    /// The page as HTML.
    ///
    /// # Errors
    /// [`ReportError::NoSuchPicture`]; [`ReportError::Stopped`]; when a design cannot be made. Pictures that cannot be drawn are
    /// notes instead.
    pub fn page(&mut self, progress: &dyn Progress) -> Result<String, ReportError> {
        let sources = Sources {
            all: &self.all,
            pictures: self.settings.pictures,
            requested: &self.settings.requested,
            progress,
        };
        let (html, notes) = page::page(&sources)?;
        self.notes.extend(notes);
        Ok(html)
    }

    /// Draws the figures as SVG and PNG and stores them.
    ///
    /// # Errors
    /// [`ReportError::NoSuchCondition`]; [`ReportError::Stopped`]; when a figure cannot be drawn or stored. Pictures that cannot be
    /// drawn are notes instead.
    fn figures<'s>(
        &mut self,
        store: &'s mut FileSink<'s>,
        progress: &'s dyn Progress,
    ) -> Result<(), ReportError> {
        let mut book = Book::new(store, progress);
        self.draw(&mut book)?;
        let Book { files, notes, .. } = book;
        self.figures.extend(files);
        self.notes.extend(notes);
        Ok(())
    }

    /// Stores the figures, then the page, then the document, which it returns: a folder with the document is complete.
    ///
    /// # Errors
    /// When a picture or a figure cannot be made, when the work is stopped, and when a file cannot be stored.
    pub fn store(
        &mut self,
        page: &str,
        store: &mut FileSink<'_>,
        progress: &dyn Progress,
    ) -> Result<String, ReportError> {
        self.figures(&mut |name, bytes| store(name, bytes), progress)?;
        store(PAGE, page.as_bytes()).map_err(ReportError::Sink)?;
        let document = self.document()?;
        store(DOCUMENT, document.as_bytes()).map_err(ReportError::Sink)?;
        Ok(document)
    }

    /// The number of figures that have been stored, each as SVG and PNG.
    #[must_use]
    pub fn figure_count(&self) -> usize {
        self.figures.len() / 2
    }

    /// What could not be shown in the page and figures, and why.
    #[must_use]
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// All that the tables contain and more as one JSON document, with the files of the figures and the notes.
    ///
    /// # Errors
    /// When a design cannot be made, or a value cannot be written as JSON.
    pub fn document(&self) -> Result<String, ReportError> {
        let document = document::document(&self.all, &self.figures, &self.notes)?;
        Ok(serde_json::to_string_pretty(&document)? + "\n")
    }

    /// The number of the trial in the first row of the tables: the best one of the fewest colours in the first condition. `None` without trials.
    ///
    /// # Errors
    /// When its design cannot be made.
    pub fn first_best(&self) -> Result<Option<u64>, ReportError> {
        let section = self.all.first().and_then(|(_, sections)| sections.first());
        let found = section.and_then(|s| Some((s, *s.groups.iter().find_map(|g| g.best.first())?)));
        found.map(|(section, row)| Ok(section.results.trial(row)?.number)).transpose()
    }

    fn draw(&self, book: &mut Book<'_>) -> Result<(), ReportError> {
        let sections: Vec<&Section<'_>> = self.all.iter().flat_map(|(_, s)| s).collect();
        figures::together(&sections, book)?;
        if let [only] = sections[..] {
            return figures::of_section(only, book);
        }
        let drawn = chosen(&sections, &self.settings.draw)?;
        if drawn.len() < sections.len() {
            book.notes.push(format!(
                "figures are of {} of {} conditions and processings; --draw TEXT chooses others",
                drawn.len(),
                sections.len()
            ));
        }
        let titles: Vec<String> = drawn.iter().map(|s| s.title()).collect();
        let names = names::file_names(titles.iter().map(String::as_str));
        for (section, name) in drawn.iter().zip(names) {
            book.enter(&name);
            figures::of_section(section, book)?;
        }
        Ok(())
    }
}

/// The sections that have figures of their own: those with a wanted text in their title, or else the first.
fn chosen<'a, 'b>(
    sections: &[&'a Section<'b>],
    wanted: &[String],
) -> Result<Vec<&'a Section<'b>>, ReportError> {
    if wanted.is_empty() {
        return Ok(sections.iter().copied().take(DRAWN).collect());
    }
    // The text may be of the title, or of the keys of the study.
    let told = |s: &&Section<'_>| format!("{}\n{}", s.title(), s.results.setup_keys(s.setup)).to_lowercase();
    let titles: Vec<String> = sections.iter().map(told).collect();
    let holds = |text: &String, title: &String| title.contains(&text.to_lowercase());
    if let Some(text) = wanted.iter().find(|text| !titles.iter().any(|title| holds(text, title))) {
        let known: Vec<String> = sections.iter().map(|s| s.title()).collect();
        return Err(ReportError::NoSuchCondition { text: text.clone(), known: known.join("; ") });
    }
    let named =
        sections.iter().zip(&titles).filter(|(_, title)| wanted.iter().any(|text| holds(text, title)));
    Ok(named.map(|(section, _)| *section).collect())
}
