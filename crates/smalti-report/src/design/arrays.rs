//! Mosaics and spectra of arrays, and their expected figures.

use super::document::{Array, Document};
use crate::comparison::figures::drawn;
use crate::page::{Markup, Table, el, figure, paragraph};
use crate::{Cell, Line, Mosaics, Plot, Rgb};

/// Colour of the curves that all filters share.
const SHARED: [Rgb; 2] = [Rgb(96, 96, 96), Rgb(150, 150, 150)];

/// The array that was found, the best published one with filters of the same kind, and the camera's own.
pub(super) fn compared(document: &Document) -> Vec<(String, &Array)> {
    let found = document.searched.first().map(|a| (document.name.clone(), a));
    let rival = document.rivals.first().map(|a| (format!("{}, filters of the same kind", a.name), a));
    let own = (format!("{} (the camera’s own)", document.own.name), &document.own);
    found.into_iter().chain(rival).chain([own]).collect()
}

/// Mosaics, spectra and expected figures.
pub(super) fn section(document: &Document) -> Markup {
    let arrays = compared(document);
    let each = arrays.iter().map(|(name, array)| drawing(document, name, array));
    Markup::from(el("div").class("cameras").children(each)).and(expectations(&arrays)).and(paragraph(
        "help",
        format!(
            "Figures are expectations of the closed form under {}, from {} patches of {} scenes. They rank arrays as learned pipelines do; their \
             absolute values differ from scores.",
            document.illuminants(),
            crate::words::grouped(document.light.iter().map(|light| light.patches).sum()),
            document.light.iter().map(|light| light.scenes).sum::<u64>(),
        ),
    ))
}

fn drawing(document: &Document, name: &str, array: &Array) -> Markup {
    let nm = &document.wavelengths_nm;
    let curves = array.transmittances.as_deref().unwrap_or_default();
    let colors: Vec<Rgb> = curves.iter().map(|t| Rgb::of_transmittance(nm, t)).collect();
    let (cols, cells) = array.cells();
    let cell = |&filter: &usize| Cell {
        letter: array.letter(filter).chars().take(3).collect(),
        color: colors.get(filter).copied().unwrap_or(Rgb(128, 128, 128)),
    };
    let cells: Vec<Cell> = cells.iter().map(cell).collect();
    let caption = format!("{} × {cols} pixels", cells.len() / cols.max(1));
    let tile = Mosaics::new().mosaic(caption, cols, &cells).draw();
    let tile = tile.map_or_else(|e| paragraph("none", format!("No tile: {e}.")), |f| figure(&f));
    let mut plot = Plot::spectra("Transmittance").y_range(0.0, 1.05).size(640.0, 400.0);
    for (i, (curve, color)) in curves.iter().zip(&colors).enumerate() {
        plot = plot.line(Line::new(array.letter(i), nm, curve).color(*color).filled().width(2.5));
    }
    let shared = [
        ("quantum efficiency", &document.quantum_efficiency),
        ("lens and infrared cut", &document.lens_and_ir_cut),
    ];
    for ((name, curve), color) in shared.into_iter().zip(SHARED) {
        plot = plot.line(Line::new(name, nm, curve).color(color).dashed().width(2.0));
    }
    let about = match array.cost {
        Some(cost) => format!("{} filters, cost {cost:.3}", array.filters),
        None => format!("{} filters", array.filters),
    };
    el("div")
        .class("camera")
        .child(el("h3").child(name))
        .child(paragraph("help", about.replace('-', "−")))
        .child(el("div").class("filters-of").child(tile).child(drawn(&plot)))
        .into()
}

fn expectations(arrays: &[(String, &Array)]) -> Markup {
    let lights = arrays.first().map_or(&[][..], |(_, a)| &a.expected);
    let is_single = lights.windows(2).all(|pair| pair[0].illuminant == pair[1].illuminant);
    let mut table = Table::new("Expected figures").text("Array");
    for (name, unit) in [("CPSNR", ", dB"), ("ΔE2000", ""), ("Exposure", ", ms")] {
        for light in lights {
            // One illuminant is named above the table.
            let under = if is_single { String::new() } else { format!("{}, ", light.illuminant) };
            table = table.number(format!("{name} at {under}{} cd/m²{unit}", light.luminance_cd_m2));
        }
    }
    for (i, (name, array)) in arrays.iter().enumerate() {
        let expected = || array.expected.iter();
        let cells = std::iter::once(name.clone())
            .chain(expected().map(|e| format!("{:.2}", e.cpsnr_db)))
            .chain(expected().map(|e| format!("{:.2}", e.delta_e_2000)))
            .chain(expected().map(|e| crate::words::time_ms(1e3 * e.time_s)));
        table = table.row(cells, i == 0);
    }
    table.into()
}
