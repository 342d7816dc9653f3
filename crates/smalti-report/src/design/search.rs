//! How the search went.

use super::document::{Array, Document, FrontPoint, means};
use crate::comparison::figures::{drawn, look};
use crate::page::{Markup, Table, el, paragraph};
use crate::{Line, Plot, Points};

/// Mosaics of each kind whose starts are drawn.
const DRAWN: usize = 4;

/// The costs of the starts, and all mosaics.
pub(super) fn section(document: &Document) -> Markup {
    let searched = document.searched.iter().take(DRAWN);
    let rivals = document.rivals.iter().take(DRAWN);
    let mut plot = Plot::new("Starts, best first", "Cost")
        .title("Costs of the starts of a mosaic")
        .note("Each start of a search ends in a minimum of its own. Where the best starts of a mosaic have the same cost, more starts would hardly find better filters.")
        .size(760.0, 460.0);
    for (i, array) in searched.chain(rivals).enumerate() {
        let mut costs = array.costs_of_starts.clone();
        costs.sort_by(f64::total_cmp);
        let x: Vec<f64> = (1..=costs.len()).map(|n| n as f64).collect();
        let (color, symbol) = look(i);
        plot = plot
            .line(Line::new("", &x, &costs).color(color).width(1.5))
            .points(Points::new(&array.name, &x, &costs).color(color).symbol(symbol).radius(5.0).marks());
    }
    let mut table = Table::new("All mosaics, each with its best filters")
        .text("Mosaic")
        .text("Kind")
        .number("Filters")
        .number("Cost")
        .number("CPSNR, dB")
        .number("ΔE2000")
        .number("Starts");
    let kinds = [("searched", &document.searched), ("published", &document.rivals)];
    for (kind, arrays) in kinds {
        for array in arrays {
            table = table.row(row(array, kind), false);
        }
    }
    table = table.row(row(&document.own, "the camera’s own"), true);
    drawn(&plot)
        .and(paragraph(
            "help",
            format!(
                "{} searched and {} published mosaics in {:.0} s. CPSNR and ΔE2000 are means over the luminances.",
                document.searched.len(),
                document.rivals.len(),
                document.seconds
            ),
        ))
        .and(el("details").child(el("summary").child("All mosaics as numbers")).child(table))
}

fn row(array: &Array, kind: &str) -> [String; 7] {
    let [cpsnr_db, delta_e] = means(&array.expected);
    [
        array.name.clone(),
        kind.to_owned(),
        array.filters.to_string(),
        array.cost.map_or_else(String::new, |c| format!("{c:.3}")).replace('-', "−"),
        format!("{cpsnr_db:.2}"),
        format!("{delta_e:.2}"),
        array.costs_of_starts.len().to_string(),
    ]
}

/// The front of the trade-offs between CPSNR and ΔE2000; `None` for fewer than two designs.
pub(super) fn front(points: &[FrontPoint]) -> Option<Markup> {
    if points.len() < 2 {
        return None;
    }
    let mut sorted: Vec<(&FrontPoint, [f64; 2])> = points.iter().map(|p| (p, means(&p.expected))).collect();
    sorted.sort_by(|a, b| a.1[0].total_cmp(&b.1[0]));
    let (x, y): (Vec<f64>, Vec<f64>) = sorted.iter().map(|(_, [x, y])| (*x, *y)).unzip();
    let plot = Plot::new("Expected CPSNR (dB)", "Expected ΔE2000")
        .title("Designs of several objectives")
        .note("Means over the luminances. To the right and below is better.")
        .line(Line::new("", &x, &y).width(1.5))
        .points(Points::new("designs", &x, &y).radius(6.0).marks())
        .size(760.0, 480.0);
    let mut table = Table::new("Designs of the front").text("Design").number("CPSNR, dB").number("ΔE2000");
    for (point, [cpsnr_db, delta_e]) in sorted {
        table = table.row([point.name.clone(), format!("{cpsnr_db:.2}"), format!("{delta_e:.2}")], false);
    }
    Some(drawn(&plot).and(table))
}
