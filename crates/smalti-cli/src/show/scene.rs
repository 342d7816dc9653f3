//! A scene: its appearance to the standard observer, and its properties.

use anyhow::Context;
use serde_json::json;
use smalti::color::cct::PlanckianLocus;
use smalti::color::{ColorSpace, Image, SRGB_WHITE};
use smalti::spectrum::{Illuminant, Observer, Spectrum};

use super::datasheet::{Datasheet, Part, four_digits};
use super::picture::{self, Pixels};

use crate::args::Common;
use crate::resolve;
use crate::scene_args::SceneOptions;

/// The largest width of a picture in pixels.
const MAX_PX: usize = 960;

pub(super) fn datasheet(name: &str, options: &SceneOptions, common: &Common) -> anyhow::Result<Datasheet> {
    let scene = resolve::scene(name, options, common).with_context(|| name.to_owned())?;
    let (radiance, light) = (scene.radiance(), scene.illuminant());
    let (rows, cols, grid) = (radiance.rows(), radiance.cols(), radiance.grid());
    let xyz = Observer::Cie1931.xyz_from_photons(light)?;
    let sum: f64 = xyz.iter().sum();
    let [x, y] = [xyz[0] / sum, xyz[1] / sum];
    let temperature_k = PlanckianLocus::new(Observer::Cie1931)?.cct(xyz).ok().map(|c| c.cct_k);
    let mean = scene.mean_luminance_cd_m2()?;
    let luminance = scene.luminance_cd_m2()?;
    let ends = luminance.iter().fold((f32::INFINITY, 0.0f32), |(l, h), &v| (l.min(v), h.max(v)));
    let image = picture::reduced(&Image::new(ColorSpace::Xyz, scene.xyz()?)?, MAX_PX)?;
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
    let light_name = name_of(light).map_or(String::new(), |name| format!("{name}, "));
    let lines = [
        ("size", format!("{cols} × {rows} pixels, {:.2}° wide", scene.horizontal_fov_deg())),
        ("distance", format!("{} m", scene.distance_m())),
        (
            "luminance",
            format!(
                "mean {} cd/m², from {} to {}",
                four_digits(mean),
                four_digits(ends.0.into()),
                four_digits(ends.1.into())
            ),
        ),
        ("illuminant", format!("{light_name}x = {x:.4}, y = {y:.4}{kelvin}")),
        ("wavelengths", wavelengths),
    ];
    let lines = lines.map(|(name, value)| format!("{name:<12} {value}\n")).concat();
    Ok(Datasheet {
        title: format!("{name}: a scene"),
        about: vec!["As the CIE 1931 observer sees it, adapted to its illuminant. The brightest half percent exceeds the range of the display.".into()],
        parts: vec![Part::Picture(seen), Part::Lines(lines)],
        json: json!({
            "kind": "scene", "name": name, "rows": rows, "cols": cols, "horizontal_fov_deg": scene.horizontal_fov_deg(),
            "distance_m": scene.distance_m(), "mean_luminance_cd_m2": mean, "least_luminance_cd_m2": ends.0,
            "largest_luminance_cd_m2": ends.1, "illuminant": name_of(light), "illuminant_xy": [x, y], "illuminant_temperature_k": temperature_k,
            "wavelengths_nm": grid.wavelengths_nm().collect::<Vec<_>>(), "illuminant_photons": light.values(),
        }),
        toml: None,
    })
}

/// The name of the built-in illuminant with this spectrum; a scene keeps only the spectrum.
fn name_of(light: &Spectrum) -> Option<&'static str> {
    let relative = |s: &Spectrum| -> Vec<f64> {
        let peak = s.max().max(f64::MIN_POSITIVE);
        s.values().iter().map(|v| v / peak).collect()
    };
    let own = relative(light);
    let same = |name: &&&str| {
        let other = Illuminant::from_name(name).ok().and_then(|l| l.photons(light.grid()).ok());
        other.is_some_and(|other| own.iter().zip(relative(&other)).all(|(a, b)| (a - b).abs() < 1e-4))
    };
    // All illuminants are equal at one or two wavelengths.
    Illuminant::names().iter().find(same).copied().filter(|_| light.grid().len() > 2)
}
