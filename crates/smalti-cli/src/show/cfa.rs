//! A colour filter array: its tile, its spectra, where it is from.

use anyhow::Context;
use serde_json::json;
use smalti::sensor::cfa::{self, CfaInfo};
use smalti::spectrum::WavelengthGrid;

use super::plot::{Curve, Plot};
use super::tile::{self, Tile};
use super::{Part, Show, Shown};
use crate::resolve;

/// Up to the end of silicon's response, for filters that pass infrared.
const INFRARED_END_NM: f64 = 1000.0;
const STEP_NM: f64 = 5.0;

pub(super) fn show(args: &Show) -> anyhow::Result<Shown> {
    let info = cfa::info(&args.name)?;
    let infrared = info.filters.iter().any(|(_, filter)| filter.contains("infrared"));
    let grid = grid(args, if infrared { INFRARED_END_NM } else { 700.0 })?;
    let array = cfa::builtin(&args.name, grid)?;
    let named = |letter: char| info.filters.iter().find(|(l, _)| *l == letter).map(|(_, f)| (*f).to_owned());
    let tile = Tile::of(&array, named)?;
    let mut title =
        format!("{}: a colour filter array, {} × {}", array.name(), tile.pattern().len(), tile.cols);
    if !info.aliases.is_empty() {
        title += &format!(", also called {}", info.aliases.join(", "));
    }
    let toml = toml(&args.name, info, &tile);
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
    Ok(Shown { title, about, parts: vec![Part::Tile(tile), Part::Plot(plot)], json, toml: Some(toml) })
}

/// The wavelengths asked for, else from 400 nm to an end.
pub(super) fn grid(args: &Show, end_nm: f64) -> anyhow::Result<WavelengthGrid> {
    match &args.scene_options.wavelengths {
        Some(text) => resolve::wavelengths(text),
        None => {
            let count = ((end_nm - 400.0) / STEP_NM).round() as usize + 1;
            WavelengthGrid::new(400.0, STEP_NM, count).context("wavelengths")
        }
    }
}

/// The curves of a tile's channels.
pub(super) fn spectra(title: &str, quantity: &'static str, tile: &Tile) -> Plot {
    let curve = |e: &tile::Entry| Curve {
        letter: e.letter,
        color: tile::for_lines(e.color),
        values: e.curve.clone(),
    };
    Plot { title: title.into(), quantity, curves: tile.channels.iter().map(curve).collect() }
}

/// The keys that put the array into a camera, each filter named, so that it can be replaced.
fn toml(name: &str, info: &CfaInfo, tile: &Tile) -> String {
    let pattern = match info.fixed_pattern() {
        Some(_) => format!("{:?}", tile.pattern()),
        // Mixtures and random tiles are made from the name.
        None => format!("{name:?}"),
    };
    // The filters of a random tile depend on its parameters.
    let filters = info.filters.iter().map(|(l, f)| format!("{l} = {{ builtin = {f:?} }}\n"));
    let filters: String = filters.collect();
    let table = if filters.is_empty() { "" } else { "\n[sensor.cfa.filters]\n" };
    format!("# {}\n[sensor.cfa]\npattern = {pattern}\n{table}{filters}", info.summary)
}
