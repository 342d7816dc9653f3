//! `smalti report`: what a study found, as tables, one document and figures.

mod answers;
pub(crate) mod camera;
mod document;
mod figures;
mod filters;
mod page;
mod pictures;
mod results;
mod tables;

pub(crate) use page::{grouped, quoted};

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use smalti_io::write;
use smalti_report::Figure;

use crate::args::{Common, ReportArgs, ReportOptions};
use crate::progress::Progress;
use crate::{Watch, names};
use answers::Section;
use results::Results;

/// The file that tells that a folder is whole.
const DOCUMENT: &str = "report.json";
/// The page.
const PAGE: &str = "report.html";
/// Conditions and processings that get figures of their own: each has a dozen.
const DRAWN: usize = 8;
/// Bytes of a PNG from which it gets fewer pixels: a cloud of a million dots compresses badly.
const LARGE: usize = 1_000_000;

pub(crate) fn run(args: &ReportArgs, common: &Common) -> anyhow::Result<()> {
    if let (Some(number), Some(dir)) = (args.camera, args.of.results.first()) {
        return crate::print(&camera::toml(dir, number)?);
    }
    let progress = Progress::new(args.of.results.len() as u64 + 2, common.quiet);
    let made = report(&args.of, &progress, &Watch::NOBODY)?;
    crate::print(if args.json { &made.document } else { &made.text })
}

/// What a report says.
pub(crate) struct Made {
    /// As JSON: `report.json`.
    pub(crate) document: String,
    /// In words and tables.
    text: String,
}

/// Makes the report and its files.
pub(crate) fn report(of: &ReportOptions, progress: &Progress, watch: &Watch<'_>) -> anyhow::Result<Made> {
    let alone = of.output.as_ref().filter(|o| o.extension().is_some_and(|e| e.eq_ignore_ascii_case("html")));
    let folder = match (&of.output, of.results.first()) {
        (Some(folder), _) => folder.clone(),
        (None, Some(first)) => first.join("report"),
        (None, None) => bail!("which results? Name a folder that `smalti sweep` wrote"),
    };
    let mut read = Vec::new();
    for dir in &of.results {
        progress.begin(results::plain(&dir.display().to_string()));
        read.push(Results::read(dir)?);
        progress.done();
    }
    match alone {
        Some(file) => write::ensure_can_write(file)?,
        None => write::ensure_can_fill(&folder)?,
    }
    let all = read.iter().map(|r| Ok((r, Section::all(r)?))).collect::<anyhow::Result<Vec<_>>>()?;
    let text = tables::text(&all)?;
    let sources = page::Sources {
        all: &all,
        dirs: &of.results,
        pictures: usize::from(of.pictures),
        wanted: &of.picture,
        watch,
    };
    progress.begin("page");
    let (html, mut notes) = page::page(&sources)?;
    progress.done();
    let mut files = Vec::new();
    if alone.is_none() {
        progress.begin("figures");
        let mut book = Book::begin(&folder, watch)?;
        book.notes = notes;
        draw(&all, &of.draw, &mut book)?;
        (files, notes) = (book.files, book.notes);
    }
    watch.ask()?;
    let document = serde_json::to_string_pretty(&document::document(&all, &files, &notes)?)? + "\n";
    let seen = match alone {
        Some(file) => {
            write::bytes(file, html.as_bytes())?;
            format!("See {}\n", file.display())
        }
        None => {
            write::bytes(&folder.join(PAGE), html.as_bytes())?;
            write::bytes(&folder.join(DOCUMENT), document.as_bytes())?;
            let (count, folder) = (files.len() / 2, folder.display());
            format!("{count} figures in {folder}, all of this in {folder}/{DOCUMENT}; see {folder}/{PAGE}\n")
        }
    };
    progress.finish();
    notes.iter().for_each(|note| progress.note(note));
    Ok(Made { document, text: text + &seen })
}

/// The figures of a report, as they are written.
struct Book<'a> {
    watch: &'a Watch<'a>,
    folder: PathBuf,
    /// Folder of the section at work, relative to that of the report; empty where there is one section.
    part: PathBuf,
    files: Vec<String>,
    notes: Vec<String>,
}

impl<'a> Book<'a> {
    /// What an earlier report left goes first, so that no figure of it stands beside those of this one.
    fn begin(folder: &Path, watch: &'a Watch<'a>) -> anyhow::Result<Self> {
        clear(folder)?;
        let (files, notes) = (Vec::new(), Vec::new());
        Ok(Self { watch, folder: folder.to_owned(), part: PathBuf::new(), files, notes })
    }

    fn enter(&mut self, part: &str) -> anyhow::Result<()> {
        self.part = PathBuf::from(part);
        clear(&self.folder.join(part))
    }

    /// Writes a figure as SVG, and as PNG with so many pixels for one of the SVG; with fewer where the file would be large.
    fn save(&mut self, name: &str, figure: &Figure, scale: f64) -> anyhow::Result<()> {
        self.watch.ask()?;
        let draw = |scale: f64| figure.png(scale).with_context(|| name.to_owned());
        let mut png = draw(scale)?;
        if png.len() > LARGE && scale > 1.5 {
            png = draw(1.5)?;
        }
        for (extension, bytes) in [("svg", figure.svg().as_bytes()), ("png", &png)] {
            let file = self.part.join(format!("{name}.{extension}"));
            write::bytes(&self.folder.join(&file), bytes)?;
            self.files.push(file.to_string_lossy().into_owned());
        }
        (self.watch.done)();
        Ok(())
    }

    /// What cannot be drawn is said; the rest of the report is none the worse, unless it was asked to stop.
    fn note(&mut self, about: &Section<'_>, what: &str, error: &anyhow::Error) -> anyhow::Result<()> {
        self.watch.ask()?;
        self.notes.push(format!(
            "{}: no {what}: {}",
            about.title(),
            results::plain(&crate::in_one_line(error.as_ref()))
        ));
        Ok(())
    }
}

fn clear(folder: &Path) -> anyhow::Result<()> {
    let files: Vec<String> =
        figures::NAMES.iter().flat_map(|n| ["svg", "png"].map(|e| format!("{n}.{e}"))).collect();
    let mut names = vec![DOCUMENT, PAGE];
    names.extend(files.iter().map(String::as_str));
    Ok(write::begin_folder(folder, &names)?)
}

fn draw(all: &[(&Results, Vec<Section<'_>>)], wanted: &[String], book: &mut Book<'_>) -> anyhow::Result<()> {
    let sections: Vec<&Section<'_>> = all.iter().flat_map(|(_, s)| s).collect();
    figures::together(&sections, book)?;
    if let [only] = sections[..] {
        return figures::of_section(only, book);
    }
    let drawn = chosen(&sections, wanted)?;
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
        book.enter(&name)?;
        figures::of_section(section, book)?;
    }
    Ok(())
}

/// The sections that get figures of their own: those whose title holds what was asked for, else the first.
fn chosen<'a, 'b>(sections: &[&'a Section<'b>], wanted: &[String]) -> anyhow::Result<Vec<&'a Section<'b>>> {
    if wanted.is_empty() {
        return Ok(sections.iter().copied().take(DRAWN).collect());
    }
    // By its words, or by the keys of the study.
    let told = |s: &&Section<'_>| format!("{}\n{}", s.title(), s.results.setup_keys(s.setup)).to_lowercase();
    let titles: Vec<String> = sections.iter().map(told).collect();
    let holds = |text: &String, title: &String| title.contains(&text.to_lowercase());
    if let Some(text) = wanted.iter().find(|text| !titles.iter().any(|title| holds(text, title))) {
        let names: Vec<String> = sections.iter().map(|s| s.title()).collect();
        bail!("{text} is in the name of no condition to draw: {}", names.join("; "));
    }
    let named =
        sections.iter().zip(&titles).filter(|(_, title)| wanted.iter().any(|text| holds(text, title)));
    Ok(named.map(|(section, _)| *section).collect())
}
