//! Figures of cameras: filters, edge response, noise, and quality against luminance.

use smalti::camera::{Camera, Evaluation};
use smalti::metrics::esfr::EdgeSfr;
use smalti::sensor::ColorArchitecture;

use crate::page::{Markup, el, figure, paragraph};
use crate::{Cell, Line, Mosaics, OKABE_ITO, Plot, Points, Rgb, Scale, Symbol};

const SYMBOLS: [Symbol; 5] =
    [Symbol::Circle, Symbol::Square, Symbol::TriangleUp, Symbol::Diamond, Symbol::Star];
const SIZE: (f64, f64) = (640.0, 440.0);
/// Of figures against light, which also phones shall show legibly.
pub(super) const LIGHT_SIZE: (f64, f64) = (540.0, 420.0);
/// The largest number of cells of a tile with readable letters.
const MAX_CELLS: usize = 32 * 32;

/// The scores of one camera with one processing in one light.
pub(super) struct Scored<'a> {
    pub(super) name: String,
    pub(super) luminance_cd_m2: f64,
    pub(super) evaluation: &'a Evaluation,
    pub(super) edge: Option<&'a EdgeSfr>,
    pub(super) pitch_m: f64,
}

/// Names, each with its values.
pub(super) type Named = Vec<(String, Vec<f64>)>;

/// The colour and symbol of a place in a list.
pub(crate) fn look(i: usize) -> (Rgb, Symbol) {
    let colors = &OKABE_ITO[..7];
    (colors[i % colors.len()], SYMBOLS[i % SYMBOLS.len()])
}

/// Points of a series joined by a line.
fn series(plot: Plot, name: &str, i: usize, x: &[f64], y: &[f64]) -> Plot {
    let (color, symbol) = look(i);
    plot.line(Line::new("", x, y).color(color).width(2.0))
        .points(Points::new(name, x, y).color(color).symbol(symbol).radius(5.0).marks())
}

/// A figure, or the reason why it cannot be drawn.
pub(crate) fn drawn(plot: &Plot) -> Markup {
    plot.draw().map_or_else(|e| paragraph("none", format!("No figure: {e}.")), |f| figure(&f))
}

pub(crate) fn beside(figures: impl IntoIterator<Item = Markup>) -> Markup {
    el("div").class("beside").children(figures).into()
}

/// A quantity against luminance: its label, and for each name its values.
pub(super) fn against_light(luminances: &[f64], label: &str, ways: &Named) -> Markup {
    let mut plot = Plot::new("Luminance (cd/m²)", label)
        .title(label.split(" (").next().unwrap_or(label))
        .x_scale(Scale::Log)
        .x_ticks(luminances)
        .size(LIGHT_SIZE.0, height(ways.len()))
        .direct_labels();
    for (i, (name, values)) in ways.iter().enumerate() {
        let mut points: Vec<(f64, f64)> = luminances.iter().copied().zip(values.iter().copied()).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (x, y): (Vec<f64>, Vec<f64>) = points.into_iter().unzip();
        plot = series(plot, name, i, &x, &y);
    }
    drawn(&plot)
}

/// The height of a figure with names beside its lines, pixels.
pub(super) fn height(names: usize) -> f64 {
    const EACH: f64 = 22.0;
    const REST: f64 = 170.0;
    LIGHT_SIZE.1.max(REST + EACH * names as f64)
}

/// The response to the slanted edge, a figure for each luminance.
pub(super) fn edges(scored: &[Vec<Scored<'_>>]) -> Markup {
    beside(scored.iter().filter_map(|of_light| {
        let first = of_light.first()?;
        let mut plot = Plot::new("Spatial frequency (cy/mm)", "Response to the edge (MTF)")
            .title(format!("Edge at {} cd/m²", first.luminance_cd_m2))
            .note("The response of Y to the slanted edge without noise (ISO 12233). MTF50 is the frequency at which a curve crosses one half.")
            .y_range(0.0, 1.2)
            .size(SIZE.0, SIZE.1);
        let mut end: f64 = 0.0;
        for (i, s) in of_light.iter().enumerate() {
            let Some(edge) = s.edge else { continue };
            let x = edge.frequency_cy_per_mm(s.pitch_m);
            // The response is meaningless beyond the sampling frequency.
            let within = edge.frequency_cy_per_px.iter().filter(|f| **f <= 0.75).count();
            let (x, y) = (x.get(..within)?, edge.sfr.get(..within)?);
            end = end.max(x.last().copied().unwrap_or(0.0));
            let mut line = Line::new(&s.name, x, y).color(look(i).0).width(2.2);
            if i % 2 == 1 {
                line = line.dashed();
            }
            plot = plot.line(line);
        }
        if end > 0.0 {
            plot = plot.line(Line::new("", &[0.0, end], &[0.5, 0.5]).color(Rgb(150, 150, 150)).width(1.0));
        }
        Some(if end > 0.0 { drawn(&plot) } else { paragraph("none", "No edge was found in the pictures.") })
    }))
}

/// Noise of the grey patches, a figure for each luminance.
pub(super) fn noise(scored: &[Vec<Scored<'_>>]) -> Markup {
    beside(scored.iter().filter_map(|of_light| {
        let first = of_light.first()?;
        let captures = match first.evaluation.noise_captures {
            1 => "one capture".to_owned(),
            count => format!("{count} captures"),
        };
        let mut plot = Plot::new("Grey patch, 1 white to 6 black", "Luminance noise (%)")
            .title(format!("Noise at {} cd/m²", first.luminance_cd_m2))
            .note(format!("Standard deviation of Y divided by its mean, from {captures} with all noise."))
            .size(SIZE.0, SIZE.1);
        let all = of_light.iter().flat_map(|s| &s.evaluation.luminance_noise_percent.per_patch);
        let (low, high) =
            all.filter(|v| **v > 0.0).fold((f64::INFINITY, 0.0f64), |(l, h), &v| (l.min(v), h.max(v)));
        if high > 8.0 * low {
            plot = plot.y_scale(Scale::Log);
        } else if high > 0.0 {
            plot = plot.y_range(0.0, high * 1.08);
        }
        for (i, s) in of_light.iter().enumerate() {
            let y = &s.evaluation.luminance_noise_percent.per_patch;
            let x: Vec<f64> = (1..=y.len()).map(|p| p as f64).collect();
            plot = series(plot, &s.name, i, &x, y);
        }
        Some(drawn(&plot))
    }))
}

/// Approximate colours of the filters of a camera.
pub(super) fn filter_colors(camera: &Camera) -> Vec<Rgb> {
    let color = |c: &smalti::sensor::Channel| {
        let nm: Vec<f64> = c.transmittance.grid().wavelengths_nm().collect();
        Rgb::of_transmittance(&nm, c.transmittance.values())
    };
    camera.sensor.cfa.channels().iter().map(color).collect()
}

/// Tiles and spectra of all cameras.
pub(super) fn all_filters(cameras: &[Camera], labels: &[String]) -> Markup {
    let each = cameras.iter().zip(labels).map(|(camera, label)| filters(camera, label));
    el("div").class("cameras").children(each).into()
}

/// Tiles and spectra of a camera.
fn filters(camera: &Camera, label: &str) -> Markup {
    let (cfa, colors) = (&camera.sensor.cfa, filter_colors(camera));
    let mosaic = cfa.mosaic();
    let tiles = match camera.sensor.architecture {
        ColorArchitecture::Mosaic if mosaic.cells().len() <= MAX_CELLS => {
            let cell = |&c: &u8| Cell {
                letter: cfa
                    .channels()
                    .get(usize::from(c))
                    .map_or_else(String::new, |c| c.name.chars().take(3).collect()),
                color: colors.get(usize::from(c)).copied().unwrap_or(Rgb(128, 128, 128)),
            };
            let cells: Vec<Cell> = mosaic.cells().iter().map(cell).collect();
            let caption = format!("{} × {} cells", mosaic.rows(), mosaic.cols());
            let drawn = Mosaics::new().mosaic(caption, mosaic.cols(), &cells).draw();
            drawn.map_or_else(|e| paragraph("none", format!("No tile: {e}.")), |f| figure(&f))
        }
        ColorArchitecture::Mosaic => paragraph(
            "none",
            format!("A tile of {} × {} cells is too large to draw.", mosaic.rows(), mosaic.cols()),
        ),
        _ => paragraph("none", "No mosaic: every pixel sees every channel."),
    };
    let mut plot = Plot::spectra("Transmittance").y_range(0.0, 1.05).size(SIZE.0, 380.0);
    for (channel, color) in cfa.channels().iter().zip(&colors) {
        let spectrum = &channel.transmittance;
        let nm: Vec<f64> = spectrum.grid().wavelengths_nm().collect();
        plot = plot.line(Line::new(&channel.name, &nm, spectrum.values()).color(*color).filled().width(2.5));
    }
    let about = format!(
        "{}, {} colours, pitch {:.2} µm",
        cfa.name(),
        colors.len(),
        camera.sensor.pixel.pitch_m * 1e6
    );
    el("div")
        .class("camera")
        .child(el("h3").child(label))
        .child(paragraph("help", about))
        .child(el("div").class("filters-of").child(tiles).child(drawn(&plot)))
        .into()
}
