//! A single curve: a light, or a filter.

use std::path::Path;

use serde_json::json;
use smalti::sensor::{Filter, cfa as filters};
use smalti::spectrum::{Observer, Spectrum, WavelengthGrid};
use smalti_io::spectrum_csv;
use smalti_report::Rgb;

use super::plot::{Curve, Plot};
use super::{Part, Show, Shown, cfa, tile};
use crate::resolve::{self, has_extension};

/// Where curves are looked at that may reach beyond the visible.
const END_NM: f64 = 1000.0;

fn is_csv(name: &str) -> bool {
    has_extension(Path::new(name.split('#').next().unwrap_or(name)), &["csv"])
}

/// A filter by name or file, on its own wavelengths where it is a file.
pub(super) fn filter(args: &Show) -> anyhow::Result<Shown> {
    let asked = args.scene_options.wavelengths.is_some();
    let curve = match (is_csv(&args.name), asked) {
        (true, false) => spectrum_csv::read_spectrum(&args.name)?,
        (true, true) => {
            let curve = spectrum_csv::read_spectrum(&args.name)?;
            curve.resampled(cfa::grid(args, END_NM)?, smalti::spectrum::Outside::Error)?
        }
        (false, _) => {
            let infrared = args.name.contains("infrared") || args.name == "silicon";
            let end_nm = if infrared { END_NM } else { 700.0 };
            Filter::Builtin(args.name.clone()).spectrum(cfa::grid(args, end_nm)?)?
        }
    };
    let info = filters::builtin_filters().iter().find(|f| f.name == args.name);
    let (nm, peak) = tile::peak(&curve);
    let about = info.map(|f| vec![f.summary.to_owned(), f.source.to_owned()]).unwrap_or_default();
    let title = format!("{}: a curve of transmittance, peak {peak:.2} at {nm:.0} nm", args.name);
    let color = tile::looks(&curve.map(|_, v| v.clamp(0.0, 1.0)))?;
    let parts = vec![Part::Plot(plot("Transmittance", "Transmittance", &args.name, color, curve.clone()))];
    let json = json!({
        "kind": "filter", "name": args.name, "summary": info.map(|f| f.summary), "source": info.map(|f| f.source),
        "color": color.to_string(), "wavelengths_nm": curve.grid().wavelengths_nm().collect::<Vec<_>>(), "transmittance": curve.values(),
    });
    Ok(Shown { title, about, parts, json, toml: None })
}

/// A light by name or file: power relative to its peak.
pub(super) fn illuminant(args: &Show) -> anyhow::Result<Shown> {
    let light = resolve::illuminant(&args.name)?;
    let grid = cfa::grid(args, 700.0)?;
    let energy = light.energy(grid)?;
    let highest = energy.max();
    let energy = if highest > 0.0 { energy.scaled(1.0 / highest) } else { energy };
    let fine = WavelengthGrid::VISIBLE;
    let xyz = Observer::Cie1931.xyz_from_photons(&light.photons(fine).or_else(|_| light.photons(grid))?)?;
    let sum: f64 = xyz.iter().sum();
    let [x, y] = [xyz[0] / sum, xyz[1] / sum];
    let color = color_of(xyz)?;
    let title = format!("{}: a light, x = {x:.4}, y = {y:.4} (CIE 1931)", light.name());
    let json = json!({
        "kind": "illuminant", "name": light.name(), "xy": [x, y], "color": color.to_string(),
        "wavelengths_nm": grid.wavelengths_nm().collect::<Vec<_>>(), "relative_power": energy.values(),
    });
    let parts =
        vec![Part::Plot(plot("Power relative to the peak", "Relative power", &args.name, color, energy))];
    Ok(Shown { title, about: Vec::new(), parts, json, toml: None })
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

/// A light on a screen adapted to daylight, its brightest channel full.
fn color_of(xyz: [f64; 3]) -> anyhow::Result<Rgb> {
    use smalti::color::{ColorSpace, Image};
    use smalti::numeric::Planes;
    let linear = Image::new(ColorSpace::Xyz, Planes::new(1, 1, 3, xyz.map(|v| v as f32).to_vec())?)?;
    let linear = linear.converted(ColorSpace::LinearSrgb)?;
    let rgb = [0, 1, 2].map(|c| f64::from(linear.planes().plane(c)[0].max(0.0)));
    let top = rgb.into_iter().fold(f64::MIN_POSITIVE, f64::max);
    let [r, g, b] = rgb.map(|v| (smalti::color::display::encode_srgb(v / top) * 255.0).round() as u8);
    Ok(Rgb(r, g, b))
}
