//! Filters, mosaics and pictures of chosen designs.

use smalti::design::{Design, TrialPhotographer, TrialScene};
use smalti::metrics::Better;
use smalti::sensor::NoiseMode;
use smalti::spectrum::WavelengthGrid;

use super::book::Book;
use super::pictures::{LEAVES, ZONE_PLATE, photographer_of};
use super::results::MAIN;
use super::sections::{ALIASING, Group, Section};
use crate::ReportError;
use crate::pictures;
use crate::{Cell, Line, Mosaics, Panels, Plot, Rgb, Sheet};

/// Panels or pictures in a row.
const ACROSS: usize = 3;
/// The first and last wavelength of spectra.
const FIRST_NM: f64 = 380.0;
const LAST_NM: f64 = 720.0;

/// Filters and mosaics of the best and worst designs, and their pictures of two scenes.
pub(super) fn of_section(section: &Section<'_>, book: &mut Book<'_>) -> Result<(), ReportError> {
    let best = |g: &Group| g.best.first().copied();
    spectra(section, "filters-best", "Filters of the best designs", best, book)?;
    spectra(section, "filters-worst", "Filters of the designs of largest colour error", |g| g.worst, book)?;
    mosaics(section, book)?;
    // The camera may need a file that is not part of the study.
    let photographer = photographer_of(section);
    let draws = [
        ("zone plates", zone_plates as fn(&TrialPhotographer, &Section<'_>, &mut Book<'_>) -> _),
        ("scene", leaves),
    ];
    for (what, draw) in draws {
        match &photographer {
            Ok(photographer) => {
                if let Err(error) = draw(photographer, section, book) {
                    book.note(section, what, &error)?;
                }
            }
            Err(error) => book.note(section, what, error)?,
        }
    }
    Ok(())
}

/// Wavelengths and transmittance of the filters of a design.
fn curves(section: &Section<'_>, design: &Design) -> Result<(Vec<f64>, Vec<Vec<f64>>), ReportError> {
    let fine = WavelengthGrid::new(FIRST_NM, 2.0, 171)?;
    let sampled = design.cfa(fine).map(|cfa| (fine, cfa));
    let (grid, cfa) = match (sampled, section.results.setup(section.setup)) {
        (Ok(sampled), _) => sampled,
        // Measured curves may cover the wavelengths of the camera only.
        (Err(_), Some((condition, _))) => {
            let grid = condition.camera.grid()?;
            (grid, design.cfa(grid)?)
        }
        (Err(error), None) => return Err(error.into()),
    };
    let curves = cfa.channels().iter().map(|c| c.transmittance.values().to_vec()).collect();
    Ok((grid.wavelengths_nm().collect(), curves))
}

fn caption(section: &Section<'_>, colors: u8, row: usize) -> String {
    let [delta_e, mtf50, _] = section.scores(row);
    if section.results.ranks_by_color() {
        return format!("{colors} colours\nΔE {delta_e:.2}, {mtf50:.1} cy/mm");
    }
    let first = section.results.in_order().first().copied();
    let score = first.map_or_else(String::new, |m| format!("{} {}", m.header, m.text(row)));
    format!("{colors} colours\n{score}")
}

fn spectra(
    section: &Section<'_>,
    name: &str,
    title: &str,
    which: impl Fn(&Group) -> Option<usize>,
    book: &mut Book<'_>,
) -> Result<(), ReportError> {
    let mut panels = Panels::new(ACROSS).title(format!("{title}, {}", section.title())).without_legend();
    let mut any = false;
    for group in &section.groups {
        let Some(row) = which(group) else { continue };
        let design = section.results.trial(row)?.design;
        let (nm, curves) = curves(section, &design)?;
        let mut plot = Plot::spectra("Transmittance")
            .title(caption(section, group.colors, row).replace('\n', ": "))
            .y_range(0.0, 1.05)
            .x_range(FIRST_NM, LAST_NM);
        for curve in curves {
            let color = Rgb::of_transmittance(&nm, &curve);
            plot = plot.line(Line::new("", &nm, &curve).color(color).filled().width(2.5));
        }
        panels = panels.panel(plot);
        any = true;
    }
    if any { book.save(name, &panels.draw()?, 2.0) } else { Ok(()) }
}

fn mosaics(section: &Section<'_>, book: &mut Book<'_>) -> Result<(), ReportError> {
    let mut mosaics = Mosaics::new()
        .title(format!("Mosaics of the best designs, {}", section.title()))
        .note("The colours of the cells are approximately those of their filters. A passes the shortest wavelengths. The frame marks one period.");
    let mut any = false;
    for group in &section.groups {
        let Some(&row) = group.best.first() else { continue };
        let design = section.results.trial(row)?.design;
        let (nm, curves) = curves(section, &design)?;
        let cell = |&c: &u8| Cell {
            letter: char::from(b'A' + c % 26).to_string(),
            color: curves.get(usize::from(c)).map_or(Rgb(128, 128, 128), |t| Rgb::of_transmittance(&nm, t)),
        };
        let cells: Vec<Cell> = design.mosaic.cells().iter().map(cell).collect();
        mosaics = mosaics.mosaic(caption(section, group.colors, row), design.mosaic.cols(), &cells);
        any = true;
    }
    if any { book.save("mosaics", &mosaics.draw()?, 2.0) } else { Ok(()) }
}

/// Pictures of the zone plate by the best designs of fewest and of most colours, and by the design with most aliasing.
fn zone_plates(
    photographer: &TrialPhotographer,
    section: &Section<'_>,
    book: &mut Book<'_>,
) -> Result<(), ReportError> {
    let best = |g: &Group| Some((g.colors, *g.best.first()?));
    let few = section.groups.iter().find_map(best);
    let many = section.groups.iter().rev().find_map(best).filter(|m| Some(*m) != few);
    let aliasing = section.results.measure(ALIASING);
    let most = section.rows.clone().filter_map(|r| Some((r, aliasing?.at(r)))).filter(|m| m.1.is_finite());
    let most = most.max_by(|a, b| a.1.total_cmp(&b.1));
    let blurred = || {
        let finite = section.rows.clone().filter(|&r| section.scores(r)[1].is_finite());
        finite.min_by(|&a, &b| section.scores(a)[1].total_cmp(&section.scores(b)[1]))
    };
    let last = match most {
        Some((row, percent)) => Some((row, format!("most aliasing: {percent:.1} %"))),
        None => blurred().map(|row| (row, format!("lowest MTF50: {:.1} cy/mm", section.scores(row)[1]))),
    };
    let mut shown: Vec<(usize, String)> =
        [few, many].into_iter().flatten().map(|(n, row)| (row, format!("best of {n} colours"))).collect();
    shown.extend(last);
    let scene = photographer.scene(ZONE_PLATE, NoiseMode::None)?;
    let sheet = Sheet::new(ACROSS)
        .title(format!("Zone plates, {}", section.title()))
        .note("The frequency of the rings rises outwards, to half a cycle per pixel in the middle of each side. Rings around other points, and colours, are aliasing. Without noise.");
    add(sheet, &scene, section, &shown, "zone-plates", book)
}

/// Pictures of a scene with natural colours by the best and by the worst design.
fn leaves(
    photographer: &TrialPhotographer,
    section: &Section<'_>,
    book: &mut Book<'_>,
) -> Result<(), ReportError> {
    let first = section.results.in_order().first().copied();
    let decisive = if section.results.ranks_by_color() { section.results.measure(MAIN[0]) } else { first };
    let delta_e = |r: &usize| match decisive {
        Some(m) if m.better == Better::Higher => -m.at(*r),
        Some(m) => m.at(*r),
        None => f64::NAN,
    };
    let best = section.groups.iter().filter_map(|g| g.best.first().copied());
    let worst = section.groups.iter().filter_map(|g| g.worst);
    let best = best.min_by(|a, b| delta_e(a).total_cmp(&delta_e(b)));
    let worst = worst.max_by(|a, b| delta_e(a).total_cmp(&delta_e(b))).filter(|w| Some(*w) != best);
    let shown: Vec<(usize, String)> = [(best, "best"), (worst, "worst")]
        .into_iter()
        .filter_map(|(row, what)| Some((row?, what.to_owned())))
        .collect();
    let scene = photographer.scene(LEAVES, NoiseMode::All)?;
    let sheet = Sheet::new(2).title(format!("A scene with natural colours, {}", section.title())).note(
        "The best and the worst design, by colour error or by the first metric of the study. With all noise; the brightness is adjusted for display.",
    );
    add(sheet, &scene, section, &shown, "scene", book)
}

fn add(
    mut sheet: Sheet,
    scene: &TrialScene<'_>,
    section: &Section<'_>,
    shown: &[(usize, String)],
    name: &str,
    book: &mut Book<'_>,
) -> Result<(), ReportError> {
    if shown.is_empty() {
        return Ok(());
    }
    for (row, what) in shown {
        let picture = scene.picture(&section.results.trial(*row)?.design)?;
        let colors = section.results.colors.get(*row).copied().unwrap_or_default();
        let number = section.results.data.numbers.get(*row).copied().unwrap_or_default();
        let caption =
            format!("{what}\n{}; trial {number}", caption(section, colors, *row).replace('\n', ", "));
        sheet = pictures::add(sheet, caption, &picture);
    }
    book.save(name, &sheet.enlarge(2).draw()?, 1.0)
}
