//! The filters of designs as data of the page: figures, colours and curves, computed by the library so that scripts only draw them.

use std::collections::HashMap;

use serde_json::{Value, json};
use smalti::camera::CameraError;
use smalti::design::FilterFigures;
use smalti::sensor::Filter;
use smalti::spectrum::{Extrapolation, WavelengthGrid};

use super::choice::Choice;
use super::sources::Sources;
use crate::page::{packed, whole_pictures};
use crate::{ReportError, Rgb};

/// The wavelengths of curves: first, step and number, nm.
const CURVE_NM: (f64, f64, usize) = (380.0, 2.0, 171);
/// Steps of a curve from 0 to 1, finer than a script draws.
const CURVE_STEPS: f64 = 2000.0;
/// Curves that are compressed together.
const CURVES_IN_BLOCK: usize = 1000;
/// The largest number of bytes of curves in a page.
const MAX_CURVE_BYTES: usize = 700_000;
/// The scale below curves, whose segments have the colours of their middle wavelengths: first wavelength, width and number, nm.
const SCALE_NM: (f64, f64, usize) = (380.0, 4.0, 85);

/// A filter, which many designs may share.
struct PageFilter {
    /// Its place in the order of first use.
    first_use: usize,
    figures: FilterFigures,
    color: Rgb,
    curve: Vec<i32>,
}

/// The different filters, the number of each filter of each design among them, and the colours of wavelengths.
pub(super) fn filters(sources: &Sources<'_>, choice: &Choice) -> Result<Value, ReportError> {
    let (first_nm, step_nm, count) = CURVE_NM;
    let grid = WavelengthGrid::new(first_nm, step_nm, count)?;
    let wavelengths: Vec<f64> = grid.wavelengths_nm().collect();
    let cameras = camera_grids(sources);
    let (mut places, mut used, mut filters) =
        (HashMap::<String, usize>::new(), Vec::<usize>::new(), Vec::<PageFilter>::new());
    for row in &choice.rows {
        let Some((results, _)) = sources.all.get(row.study) else { continue };
        for filter in &results.trial(row.row)?.design.filters.filters {
            let first_use = filters.len();
            let place = *places.entry(serde_json::to_string(filter)?).or_insert(first_use);
            used.push(place);
            if place < first_use {
                continue;
            }
            let curve = sampled(filter, grid, &cameras);
            filters.push(PageFilter {
                first_use,
                figures: FilterFigures::new(filter).map_err(CameraError::from)?,
                color: Rgb::of_transmittance(&wavelengths, &curve),
                curve: curve.iter().map(|t| (t * CURVE_STEPS).round() as i32).collect(),
            });
        }
    }
    // A curve takes the fewest bytes beside a similar one.
    filters.sort_by(|a, b| {
        let by = |of: &dyn Fn(&FilterFigures) -> f64| of(&a.figures).total_cmp(&of(&b.figures));
        by(&|f| f.fwhm_nm).then_with(|| by(&|f| f.center_nm)).then_with(|| by(&|f| f.peak))
    });
    let mut numbers = vec![0.0; filters.len()];
    for (number, filter) in filters.iter().enumerate() {
        if let Some(of) = numbers.get_mut(filter.first_use) {
            *of = number as f64;
        }
    }
    let used: Vec<f64> = used.iter().filter_map(|place| numbers.get(*place).copied()).collect();
    let column = |of: &dyn Fn(&PageFilter) -> f64| packed(&filters.iter().map(of).collect::<Vec<_>>());
    let (first_nm, step_nm, count) = SCALE_NM;
    let scale = (0..count).map(|i| number_of(Rgb::of_wavelength(first_nm + (i as f64 + 0.5) * step_nm)));
    Ok(json!({
        "used": packed(&used),
        "center": column(&|f| f.figures.center_nm),
        "fwhm": column(&|f| f.figures.fwhm_nm),
        "peak": column(&|f| f.figures.peak),
        "color": column(&|f| number_of(f.color)),
        "curves": {
            "first_nm": grid.start_nm(), "step_nm": grid.step_nm(), "count": grid.len(), "steps": CURVE_STEPS,
            "in_block": CURVES_IN_BLOCK, "blocks": blocks(&filters, grid.len()),
        },
        "scale": {"first_nm": first_nm, "step_nm": step_nm, "color": packed(&scale.collect::<Vec<_>>())},
    }))
}

/// The curves as far as there is room, in blocks: pictures of a row per filter and a column per wavelength.
fn blocks(filters: &[PageFilter], cols: usize) -> Vec<Value> {
    let mut bytes = 0;
    let block = |filters: &[PageFilter]| {
        let codes: Vec<i32> = filters.iter().flat_map(|f| f.curve.iter().copied()).collect();
        let mut block = whole_pictures(std::iter::once(codes.as_slice()), cols);
        (block["rows"], block["cols"]) = (json!(filters.len()), json!(cols));
        bytes += block.to_string().len();
        (bytes <= MAX_CURVE_BYTES).then_some(block)
    };
    filters.chunks(CURVES_IN_BLOCK).map_while(block).collect()
}

/// A colour as one number, 65536 R + 256 G + B.
fn number_of(Rgb(r, g, b): Rgb) -> f64 {
    f64::from(u32::from_be_bytes([0, r, g, b]))
}

/// The wavelength grids of all cameras, the widest first.
fn camera_grids(sources: &Sources<'_>) -> Vec<WavelengthGrid> {
    let conditions = sources.all.iter().flat_map(|(results, _)| &results.study().conditions);
    let mut grids: Vec<WavelengthGrid> = Vec::new();
    for grid in conditions.filter_map(|c| c.camera.grid().ok()) {
        if !grids.contains(&grid) {
            grids.push(grid);
        }
    }
    let width = |g: &WavelengthGrid| g.end_nm() - g.start_nm();
    grids.sort_by(|a, b| width(b).total_cmp(&width(a)));
    grids
}

/// A curve on a grid. A measured curve may cover the wavelengths of its camera only; it is 0 beyond them.
fn sampled(filter: &Filter, grid: WavelengthGrid, cameras: &[WavelengthGrid]) -> Vec<f64> {
    let known = std::iter::once(&grid).chain(cameras).find_map(|own| filter.spectrum(*own).ok());
    let on_grid = known.and_then(|curve| curve.resampled(grid, Extrapolation::Zero).ok());
    on_grid.map_or_else(|| vec![0.0; grid.len()], |curve| curve.values().to_vec())
}
