//! How the search went.

use std::collections::BTreeMap;

use super::document::{Array, Document, Front, means};
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

/// The front between the first two aims, and a table of all; `None` for fewer than two compromises.
pub(super) fn front(front: &Front) -> Option<Markup> {
    let aims: Vec<&str> = front.aims.iter().flatten().map(|aim| aim.name.as_str()).collect();
    let ([first, second, ..], true) = (&aims[..], front.points.len() > 1) else { return None };
    let mut plot = Plot::new(*first, *second)
        .title("The best compromises that were found")
        .note(format!(
            "Costs of two aims, less is better: a figure in dB counts negative. No array that was found{} is better in every aim than one of these.",
            if front.filters { " with as few filters" } else { "" }
        ))
        .size(760.0, 480.0);
    let mut groups: BTreeMap<usize, (Vec<f64>, Vec<f64>)> = BTreeMap::new();
    for point in &front.points {
        if let [x, y, ..] = point.costs[..] {
            let group = groups.entry(if front.filters { point.design.filters } else { 0 }).or_default();
            group.0.push(x);
            group.1.push(y);
        }
    }
    for (i, (filters, (x, y))) in groups.iter().enumerate() {
        let name = if front.filters { format!("{filters} filters") } else { "compromises".to_owned() };
        let (color, symbol) = look(i);
        plot = plot.points(Points::new(name, x, y).color(color).symbol(symbol).radius(6.0).marks());
        // Between three aims, a line would join points that are not neighbours.
        if aims.len() == 2 {
            plot = plot.line(Line::new("", x, y).color(color).width(1.5));
        }
    }
    let mut table = Table::new("Compromises").text("File").text("Mosaic").number("Filters");
    for aim in &aims {
        table = table.number(*aim);
    }
    table = table.number("CPSNR, dB").number("ΔE2000");
    for (number, point) in (1..).zip(&front.points) {
        let [cpsnr_db, delta_e] = means(&point.design.expected);
        let costs = point.costs.iter().take(aims.len()).map(|cost| format!("{cost:.3}").replace('-', "−"));
        let cells =
            [format!("front/{number}.toml"), point.design.name.clone(), point.design.filters.to_string()]
                .into_iter()
                .chain(costs)
                .chain([format!("{cpsnr_db:.2}"), format!("{delta_e:.2}")]);
        table = table.row(cells, false);
    }
    Some(drawn(&plot).and(table))
}
