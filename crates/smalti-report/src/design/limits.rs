//! What limits the array that was found: the shares of its error by cause.

use super::document::{Cause, ClassLimits, Document, Limits};
use crate::figure::Figure;
use crate::page::{Markup, Table, el, figure, paragraph};
use crate::svg::{Anchor, Area, INK, Paint, SOFT, Svg};
use crate::text::{bold, fit, plain};
use crate::{FigureError, OKABE_ITO, Rgb};

/// The causes with their colours.
const CAUSES: [(&str, Rgb); 3] =
    [("noise", OKABE_ITO[0]), ("sampling", OKABE_ITO[5]), ("colour", OKABE_ITO[2])];

const WIDTH: f64 = 760.0;
const LEFT: f64 = 232.0;
const BAR: f64 = 24.0;
const STEP: f64 = 31.0;
const RIGHT: f64 = 20.0;

/// A part of the error by cause.
type Of = fn(&Cause) -> f64;

/// The mean over the patches of a luminance, then each class, with its share of the patches.
fn rows(limits: &Limits, of: Of) -> Vec<(String, f64, [f64; 3])> {
    let parts = |c: &ClassLimits| [&c.noise, &c.sampling, &c.color].map(of);
    let mut all = [0.0; 3];
    for class in &limits.classes {
        all.iter_mut().zip(parts(class)).for_each(|(sum, part)| *sum += class.patches * part);
    }
    let mut rows = vec![("all patches".to_owned(), 1.0, all)];
    if limits.classes.len() > 1 {
        rows.extend(limits.classes.iter().map(|c| (c.class.clone(), c.patches, parts(c))));
    }
    rows
}

/// Shares as figures and as numbers.
pub(super) fn section(document: &Document) -> Markup {
    let limits = &document.analysis.limits;
    let kinds: [(&str, Of); 2] =
        [("squared error, that of CPSNR", |c| c.squared_error), ("ΔE2000", |c| c.delta_e_2000)];
    let figures = kinds.map(|(name, of)| {
        bars(&format!("Shares of the {name}"), limits, of)
            .map_or_else(|e| paragraph("none", format!("No figure: {e}.")), |f| figure(&f))
    });
    let mut table = Table::new("Causes of the expected error")
        .number("Luminance, cd/m²")
        .text("Patches")
        .number("Share of patches, %");
    for (name, _) in CAUSES {
        table = table.number(format!("RMS error by {name}, % of white"));
    }
    for (name, _) in CAUSES {
        table = table.number(format!("ΔE2000 by {name}"));
    }
    for light in limits {
        let [squared, delta_e] = kinds.map(|(_, of)| rows(light, of));
        for ((name, patches, squared), (_, _, delta_e)) in squared.into_iter().zip(delta_e) {
            let cells = [light.luminance_cd_m2.to_string(), name, format!("{:.1}", 100.0 * patches)];
            let cells = cells
                .into_iter()
                .chain(squared.map(|e| format!("{:.2}", 100.0 * e.max(0.0).sqrt())))
                .chain(delta_e.map(|e| format!("{e:.2}")));
            table = table.row(cells, false);
        }
    }
    Markup::from(el("div").class("beside").children(figures))
        .and(paragraph(
            "help",
            "Noise is the difference from a sensor without noise. Sampling is the difference between that sensor and one that has every filter at \
             every pixel: aliasing and blur. Colour is the rest: the filters do not span the functions of the observer. Each is an expectation of the \
             closed form, and the three add up to the whole.",
        ))
        .and(el("details").child(el("summary").child("The shares as numbers")).child(table))
}

/// A bar for each luminance and class.
fn bars(title: &str, limits: &[Limits], of: Of) -> Result<Figure, FigureError> {
    let mut svg = Svg::default();
    let mut y = 38.0;
    svg.text((20.0, 28.0), Anchor::Start, bold(19.0), INK, title);
    let mut described = String::new();
    let mut x = LEFT;
    y += 8.0;
    for (name, color) in CAUSES {
        svg.rect(Area { x, y, width: 15.0, height: 15.0 }, Paint::fill(color, 1.0));
        svg.text((x + 21.0, y + 13.0), Anchor::Start, plain(16.0), INK, name);
        x += 130.0;
    }
    y += 32.0;
    for light in limits {
        svg.text(
            (20.0, y + 15.0),
            Anchor::Start,
            bold(16.0),
            INK,
            &format!("{} cd/m²", light.luminance_cd_m2),
        );
        y += 24.0;
        for (name, patches, parts) in rows(light, of) {
            let label = if patches < 1.0 { format!("{name} ({:.0} %)", 100.0 * patches) } else { name };
            let label = fit(&label, plain(15.0), LEFT - 40.0);
            svg.text((LEFT - 10.0, y + 17.0), Anchor::End, plain(15.0), SOFT, &label);
            let whole: f64 = parts.iter().map(|p| p.max(0.0)).sum();
            let mut x = LEFT;
            for (part, (cause, color)) in parts.into_iter().zip(CAUSES) {
                let share = if whole > 0.0 { part.max(0.0) / whole } else { 0.0 };
                let width = share * (WIDTH - LEFT - RIGHT);
                svg.open("", &format!("{cause}: {:.0} %", 100.0 * share));
                svg.rect(Area { x, y, width, height: BAR }, Paint::fill(color, 1.0));
                if width > 40.0 {
                    let at = (x + 0.5 * width, y + 17.0);
                    svg.text(at, Anchor::Middle, bold(14.0), color.ink(), &format!("{:.0} %", 100.0 * share));
                }
                svg.close();
                described +=
                    &format!("{} cd/m², {label}: {cause} {:.0} %. ", light.luminance_cd_m2, 100.0 * share);
                x += width;
            }
            y += STEP;
        }
        y += 8.0;
    }
    Figure::new(svg, WIDTH, y + 6.0, title, &described)
}
