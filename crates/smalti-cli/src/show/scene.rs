//! A scene: its picture as the eye sees it, and its figures.

use anyhow::Context;
use serde_json::json;
use smalti::color::cct::PlanckianLocus;
use smalti::color::{ColorSpace, Image, SRGB_WHITE};
use smalti::spectrum::{Illuminant, Observer, Spectrum};

use super::picture::{self, Pixels};
use super::{Part, Show, Shown, figure};
use crate::resolve;

/// Pixels of a picture's width for terminals that show some; blocks need fewer.
const MOST_PX: usize = 960;

pub(super) fn show(args: &Show) -> anyhow::Result<Shown> {
    let scene = resolve::scene(&args.name, &args.scene_options).with_context(|| args.name.clone())?;
    let (radiance, light) = (scene.radiance(), scene.illuminant());
    let (rows, cols, grid) = (radiance.rows(), radiance.cols(), radiance.grid());
    let xyz = Observer::Cie1931.xyz_from_photons(light)?;
    let sum: f64 = xyz.iter().sum();
    let [x, y] = [xyz[0] / sum, xyz[1] / sum];
    let temperature_k = PlanckianLocus::new(Observer::Cie1931)?.cct(xyz).ok().map(|c| c.cct_k);
    let mean = scene.mean_luminance_cd_m2()?;
    let luminance = scene.luminance_cd_m2()?;
    let ends = luminance.iter().fold((f32::INFINITY, 0.0f32), |(l, h), &v| (l.min(v), h.max(v)));
    let image = picture::reduced(&Image::new(ColorSpace::Xyz, scene.xyz()?)?, MOST_PX)?;
    let white = Observer::Cie1931.white(light)?;
    let white = if white.iter().all(|v| v.is_finite()) { white } else { SRGB_WHITE };
    let seen = Pixels::of(&image.shown(Some(white), image.brightness_gain())?)?;
    let wavelengths = format!(
        "{:.0}–{:.0} nm in {} steps of {} nm",
        grid.start_nm(),
        grid.end_nm(),
        grid.len().saturating_sub(1),
        grid.step_nm()
    );
    let kelvin = temperature_k.map_or(String::new(), |k| format!(", {k:.0} K"));
    let name = name_of(light).map_or(String::new(), |name| format!("{name}, "));
    let lines = [
        ("size", format!("{cols} × {rows} pixels, {:.2}° wide", scene.horizontal_fov_deg())),
        ("distance", format!("{} m", scene.distance_m())),
        (
            "luminance",
            format!(
                "mean {} cd/m², from {} to {}",
                figure(mean),
                figure(ends.0.into()),
                figure(ends.1.into())
            ),
        ),
        ("illuminant", format!("{name}x = {x:.4}, y = {y:.4}{kelvin}")),
        ("wavelengths", wavelengths),
    ];
    let lines = lines.map(|(name, value)| format!("{name:<12} {value}\n")).concat();
    Ok(Shown {
        title: format!("{}: a scene", args.name),
        about: vec!["As the eye sees it, its light as white, all but the brightest half percent within the display's range.".into()],
        parts: vec![Part::Picture(seen), Part::Lines(lines)],
        json: json!({
            "kind": "scene", "name": args.name, "rows": rows, "cols": cols, "horizontal_fov_deg": scene.horizontal_fov_deg(),
            "distance_m": scene.distance_m(), "mean_luminance_cd_m2": mean, "least_luminance_cd_m2": ends.0,
            "largest_luminance_cd_m2": ends.1, "illuminant": name_of(light), "illuminant_xy": [x, y], "illuminant_temperature_k": temperature_k,
            "wavelengths_nm": grid.wavelengths_nm().collect::<Vec<_>>(), "illuminant_photons": light.values(),
        }),
        toml: None,
    })
}

/// A scene keeps the spectrum of its light: the named light that has the same.
fn name_of(light: &Spectrum) -> Option<&'static str> {
    let relative = |s: &Spectrum| s.scaled(1.0 / s.max().max(f64::MIN_POSITIVE));
    let own = relative(light);
    let same = |name: &&&str| {
        let other = Illuminant::from_name(name).ok().and_then(|l| l.photons(light.grid()).ok());
        other.is_some_and(|other| {
            own.values().iter().zip(relative(&other).values()).all(|(a, b)| (a - b).abs() < 1e-4)
        })
    };
    // A single wavelength is the same under every light.
    Illuminant::names().iter().find(same).copied().filter(|_| light.grid().len() > 2)
}
