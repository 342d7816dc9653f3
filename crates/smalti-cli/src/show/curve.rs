//! A single curve: an illuminant or a filter.

use std::path::Path;

use serde_json::json;
use smalti::sensor::{Filter, cfa as filters};
use smalti::spectrum::{Extrapolation, Observer, Spectrum, WavelengthGrid};
use smalti_io::{lights, spectrum_csv};
use smalti_report::Rgb;

use super::datasheet::{Datasheet, Part};
use super::plot::{Curve, Plot};
use super::{cfa, tile};
use crate::resolve::has_extension;
use crate::scene_args::SceneOptions;

/// The last wavelength of curves that may extend beyond the visible.
const END_NM: f64 = 1000.0;

/// Whether a name is that of a CSV file, which may end in `#` and a column.
pub(super) fn is_csv(name: &str) -> bool {
    has_extension(Path::new(name.split('#').next().unwrap_or(name)), &["csv"])
}

/// A filter by name or file; a file keeps its own wavelengths.
pub(super) fn filter(name: &str, options: &SceneOptions) -> anyhow::Result<Datasheet> {
    let infrared = name.contains("infrared") || name == "silicon";
    let grid = cfa::grid(options, if infrared { END_NM } else { 700.0 })?;
    let (curve, told) = if is_csv(name) {
        let (read, told) = spectrum_csv::read_transmittance(name)?;
        (if options.wavelengths.is_some() { read.resampled(grid, Extrapolation::Error)? } else { read }, told)
    } else {
        (Filter::Builtin(name.to_owned()).spectrum(grid)?, None)
    };
    let info = filters::builtin_filters().iter().find(|f| f.name == name);
    let (nm, peak) = tile::peak(&curve);
    let about = info.map(|f| vec![f.summary.to_owned(), f.source.to_owned()]).unwrap_or_default();
    let about = about.into_iter().chain(told).collect();
    let title = format!("{name}: a transmittance curve, peak {peak:.2} at {nm:.0} nm");
    let color = tile::looks(&curve.map(|_, v| v.clamp(0.0, 1.0))?)?;
    let parts = vec![Part::Plot(plot("Transmittance", "Transmittance", name, color, curve.clone()))];
    let json = json!({
        "kind": "filter", "name": name, "summary": info.map(|f| f.summary), "source": info.map(|f| f.source),
        "color": color.to_string(), "wavelengths_nm": curve.grid().wavelengths_nm().collect::<Vec<_>>(), "transmittance": curve.values(),
    });
    Ok(Datasheet { title, about, parts, json, toml: None })
}

/// An illuminant by name or file, as power relative to its peak.
pub(super) fn illuminant(name: &str, options: &SceneOptions) -> anyhow::Result<Datasheet> {
    let (light, told) = lights::load_with_note(name, Path::new(""))?;
    let grid = cfa::grid(options, 700.0)?;
    let energy = light.energy(grid)?;
    let highest = energy.max();
    let energy = if highest > 0.0 { energy.scaled(1.0 / highest)? } else { energy };
    let fine = WavelengthGrid::VISIBLE;
    let xyz = Observer::Cie1931.xyz_from_photons(&light.photons(fine).or_else(|_| light.photons(grid))?)?;
    let sum: f64 = xyz.iter().sum();
    let [x, y] = [xyz[0] / sum, xyz[1] / sum];
    let color = color_of(xyz)?;
    let title = format!("{}: an illuminant, x = {x:.4}, y = {y:.4} (CIE 1931)", light.name());
    let json = json!({
        "kind": "illuminant", "name": light.name(), "xy": [x, y], "color": color.to_string(),
        "wavelengths_nm": grid.wavelengths_nm().collect::<Vec<_>>(), "relative_power": energy.values(),
    });
    let parts = vec![Part::Plot(plot("Power relative to the peak", "Relative power", name, color, energy))];
    Ok(Datasheet { title, about: told.into_iter().collect(), parts, json, toml: None })
}

fn plot(title: &str, quantity: &'static str, name: &str, color: Rgb, values: Spectrum) -> Plot {
    let last = name.rsplit('/').next().unwrap_or(name);
    let letter = last.chars().next().unwrap_or('*');
    Plot {
        title: title.into(),
        quantity,
        curves: vec![Curve { letter, color: tile::for_lines(color), values }],
    }
}

/// The colour of an illuminant on a display adapted to daylight, with the brightest channel at its maximum.
fn color_of(xyz: [f64; 3]) -> anyhow::Result<Rgb> {
    use smalti::color::{ColorSpace, Image};
    use smalti::numeric::Planes;
    let linear = Image::new(ColorSpace::Xyz, Planes::new(1, 1, 3, xyz.map(|v| v as f32).to_vec())?)?;
    let linear = linear.converted(ColorSpace::LinearSrgb)?;
    let rgb = linear.channels().map(|c| f64::from(c[0].max(0.0)));
    let top = rgb.into_iter().fold(f64::MIN_POSITIVE, f64::max);
    let [r, g, b] = rgb.map(|v| (smalti::color::display::encode_srgb(v / top) * 255.0).round() as u8);
    Ok(Rgb(r, g, b))
}
