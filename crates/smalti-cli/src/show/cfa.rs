//! A colour filter array: its tile, its spectra and its source.

use anyhow::Context;
use serde_json::json;
use smalti::sensor::cfa::{self, CfaInfo};
use smalti::spectrum::WavelengthGrid;

use super::datasheet::{Datasheet, Part};
use super::plot::{Curve, Plot};
use super::tile::{self, Tile};
use crate::resolve;
use crate::scene_args::SceneOptions;

/// The end of silicon's response, for filters that transmit infrared.
const INFRARED_END_NM: f64 = 1000.0;
const STEP_NM: f64 = 5.0;

pub(super) fn datasheet(name: &str, options: &SceneOptions) -> anyhow::Result<Datasheet> {
    let info = cfa::info(name)?;
    let infrared = info.filters.iter().any(|(_, filter)| filter.contains("infrared"));
    let grid = grid(options, if infrared { INFRARED_END_NM } else { 700.0 })?;
    let array = cfa::builtin(name, grid)?;
    let named = |letter: char| info.filters.iter().find(|(l, _)| *l == letter).map(|(_, f)| (*f).to_owned());
    let tile = Tile::of(&array, named)?;
    let mut title =
        format!("{}: a colour filter array, {} × {}", array.name(), tile.pattern().len(), tile.cols);
    if !info.aliases.is_empty() {
        title += &format!(", also called {}", info.aliases.join(", "));
    }
    let toml = toml(name, info, &tile);
    let mut json = json!({
        "kind": "cfa", "name": array.name(), "aliases": info.aliases, "summary": info.summary, "source": info.source,
        "filters": info.filters.iter().map(|(l, f)| (l.to_string(), json!(f))).collect::<serde_json::Map<_, _>>(),
        "wavelengths_nm": grid.wavelengths_nm().collect::<Vec<_>>(),
    });
    if let (Some(into), serde_json::Value::Object(from)) = (json.as_object_mut(), tile.json()) {
        into.extend(from);
    }
    let plot = spectra("Transmittance of the filters", "Transmittance", &tile);
    let about = vec![info.summary.to_owned(), info.source.to_owned()];
    Ok(Datasheet { title, about, parts: vec![Part::Tile(tile), Part::Plot(plot)], json, toml: Some(toml) })
}

/// The wavelengths of the command line, else 400 nm to `end_nm`.
pub(super) fn grid(options: &SceneOptions, end_nm: f64) -> anyhow::Result<WavelengthGrid> {
    match &options.wavelengths {
        Some(text) => resolve::wavelengths(text),
        None => {
            let count = ((end_nm - 400.0) / STEP_NM).round() as usize + 1;
            WavelengthGrid::new(400.0, STEP_NM, count).context("wavelengths")
        }
    }
}

/// The curves of the channels of a tile.
pub(super) fn spectra(title: &str, quantity: &'static str, tile: &Tile) -> Plot {
    let curve = |e: &tile::Entry| Curve {
        letter: e.letter,
        color: tile::for_lines(e.color),
        values: e.curve.clone(),
    };
    Plot { title: title.into(), quantity, curves: tile.channels.iter().map(curve).collect() }
}

/// The keys of a camera with this array; each filter is named, so that it can be replaced.
fn toml(name: &str, info: &CfaInfo, tile: &Tile) -> String {
    let pattern = match info.fixed_pattern() {
        Some(_) => format!("{:?}", tile.pattern()),
        // Mixtures and random tiles are generated from the name.
        None => format!("{name:?}"),
    };
    // The filters of a random tile depend on its parameters.
    let filters = info.filters.iter().map(|(l, f)| format!("{l} = {{ builtin = {f:?} }}\n"));
    let filters: String = filters.collect();
    let table = if filters.is_empty() { "" } else { "\n[sensor.cfa.filters]\n" };
    format!("# {}\n[sensor.cfa]\npattern = {pattern}\n{table}{filters}", info.summary)
}
