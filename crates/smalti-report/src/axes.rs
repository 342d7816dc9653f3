//! The axes of a panel: grid, ticks with their labels, and the colours of the spectrum below wavelengths.

use crate::FigureError;
use crate::color::Rgb;
use crate::figure::{Compression, encode};
use crate::scale::{Axis, Tick};
use crate::svg::{Anchor, Area, FRAME, GRID, INK, Paint, Svg, path_of};
use crate::text::{TICK, width};

/// Which axes of a panel carry labels at their ticks.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Edges {
    pub(crate) left: bool,
    pub(crate) bottom: bool,
}

/// Draws the grid, the two axes, their ticks and labels. `own_ticks` are those of x instead of round values; `wavelengths` leaves room
/// for the spectrum below the axis.
pub(crate) fn draw_axes(
    svg: &mut Svg,
    area: Area,
    (x, own_ticks): (&Axis, &[f64]),
    y: &Axis,
    edges: Edges,
    wavelengths: bool,
) {
    let (left, right, top, bottom) = (area.x, area.x + area.width, area.y, area.y + area.height);
    let columns: Vec<(f64, String)> = placed(x, x_ticks(x, own_ticks, area.width), left, area.width);
    let y_ticks = y.ticks(tick_count(area.height, 62.0));
    let rows: Vec<(f64, String)> = placed(y, y_ticks, bottom, -area.height);
    columns.iter().for_each(|(at, _)| svg.line((*at, top), (*at, bottom), GRID, 1.0));
    rows.iter().for_each(|(at, _)| svg.line((left, *at), (right, *at), GRID, 1.0));
    let corner = path_of(&[(left, top), (left, bottom), (right, bottom)], false);
    svg.raw_path(&corner, &Paint::stroke(FRAME, 1.4).attributes());
    let mark = if wavelengths { 10.0 } else { 5.0 };
    for (at, label) in columns {
        svg.line((at, bottom), (at, bottom + mark), FRAME, 1.4);
        if edges.bottom {
            let base = bottom + 2.0 * mark + 0.94 * TICK.size;
            svg.text((at, base), Anchor::Middle, TICK, INK, &label);
        }
    }
    for (at, label) in rows {
        svg.line((left - 5.0, at), (left, at), FRAME, 1.4);
        if edges.left {
            svg.text((left - 10.0, at + 0.36 * TICK.size), Anchor::End, TICK, INK, &label);
        }
    }
}

/// Positions and labels of ticks on an axis that begins at the pixel `start` and is `length` pixels long.
fn placed(axis: &Axis, ticks: Vec<Tick>, start: f64, length: f64) -> Vec<(f64, String)> {
    ticks
        .into_iter()
        .filter_map(|(value, label)| Some((start + length * axis.place(value)?, label)))
        .collect()
}

fn tick_count(length: f64, spacing: f64) -> usize {
    ((length / spacing) as usize).clamp(2, 12)
}

/// Ticks of the horizontal axis; about half as many round ones where their labels would touch.
fn x_ticks(axis: &Axis, own: &[f64], length: f64) -> Vec<Tick> {
    if !own.is_empty() {
        return own_ticks(axis, own, length);
    }
    let count = tick_count(length, 95.0);
    let ticks = axis.ticks(count);
    let widest = ticks.iter().map(|(_, label)| width(label, TICK)).fold(0.0, f64::max);
    let touching = ticks.len() as f64 * (widest + 14.0) > length + widest;
    if touching { axis.ticks(count / 2) } else { ticks }
}

/// Ticks at given values within the axis, from the left, as far as their labels do not touch the one before.
fn own_ticks(axis: &Axis, values: &[f64], length: f64) -> Vec<Tick> {
    let mut sorted: Vec<f64> = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let mut free = f64::NEG_INFINITY;
    let mut ticks = Vec::new();
    for value in sorted {
        let Some(place) = axis.place(value).filter(|t| (0.0..=1.0).contains(t)) else { continue };
        let label = value.to_string();
        let half = 0.5 * width(&label, TICK);
        if place * length - half > free {
            free = place * length + half + 8.0;
            ticks.push((value, label));
        }
    }
    ticks
}

/// The visible spectrum as a strip below the axis of wavelengths.
pub(crate) fn draw_spectrum(svg: &mut Svg, area: Area, axis: &Axis) -> Result<(), FigureError> {
    let strip = Area { y: area.y + area.height + 5.0, height: 9.0, ..area };
    let columns = area.width as usize;
    let row: Vec<u8> = (0..columns)
        .map(|i| Rgb::of_wavelength(axis.low + (i as f64 + 0.5) / columns as f64 * (axis.high - axis.low)))
        .flat_map(|c| [c.0, c.1, c.2])
        .collect();
    let png = encode(&row.repeat(2), [columns as u32, 2], png::ColorType::Rgb, Compression::Small)?;
    svg.image(strip, &png, true);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scale::Scale;

    #[test]
    fn ticks_of_ones_own_are_those_values_unless_their_labels_touch() {
        let axis = Axis { scale: Scale::Log, low: 0.9, high: 90.0 };
        let labels =
            |values: &[f64]| own_ticks(&axis, values, 400.0).into_iter().map(|t| t.1).collect::<Vec<_>>();
        assert_eq!(labels(&[80.0, 1.0, 10.0]), ["1", "10", "80"]);
        assert_eq!(labels(&[1.0, 1.01, 10.0, 100.0]), ["1", "10"]);
    }
}
