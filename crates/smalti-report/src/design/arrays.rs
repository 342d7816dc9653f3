//! Mosaics and spectra of arrays, and their expected figures.

use smalti::spectrum::Illuminant;

use super::document::{Array, ArrayFigures, Document};
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
    Markup::from(el("div").class("cameras").children(each)).and(expectations(&arrays)).and(spectral(document, &arrays)).and(paragraph(
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

/// What follows from the spectra of the arrays alone.
fn spectral(document: &Document, arrays: &[(String, &Array)]) -> Markup {
    if arrays.iter().all(|(_, array)| array.figures.is_none()) {
        return Markup::default();
    }
    let light = document.illuminants.first().map_or_else(String::new, Illuminant::name);
    let headings = [
        "Photon efficiency, %",
        "Vora value",
        "SMI",
        "Metamer mismatch, %",
        "Condition number",
        "Luminance noise gain",
    ];
    let table = Table::new(format!("Light and colour under {light}")).text("Array");
    let mut table = headings.into_iter().fold(table, Table::number);
    for (i, (name, array)) in arrays.iter().enumerate() {
        let of = |f: fn(&ArrayFigures) -> Option<f64>, digits: usize| {
            let value = array.figures.as_ref().and_then(f);
            value.map_or_else(|| "–".to_owned(), |v| format!("{v:.digits$}"))
        };
        let cells = [
            name.clone(),
            of(|f| Some(100.0 * f.photon_efficiency), 1),
            of(|f| Some(f.vora_value), 3),
            of(|f| Some(f.sensitivity_metamerism_index), 1),
            of(|f| Some(f.metamer_mismatch_percent), 1),
            of(|f| f.condition_number, 1),
            of(|f| Some(f.luminance_noise_gain), 2),
        ];
        table = table.row(cells, i == 0);
    }
    Markup::from(table).and(paragraph(
        "help",
        "Photon efficiency is the mean response of the pixels to white, relative to pixels without filters. The Vora value is 1 and the sensitivity \
         metamerism index (SMI) 100 for filters that tell colours apart as the observer does. The condition number is that of the matrix from the \
         channels to X, Y, Z, each relative to white; the noise gain is that of the matrix for Y.",
    ))
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
