//! What is written: the variables of a scene, or of a bare cube.

use smalti::numeric::Planes;

use crate::scene_file::facts::Comment;
use crate::{Quantity, SpectralFile};

/// A variable or field.
pub(super) enum Item<'a> {
    /// Rows × columns × bands, in single precision.
    Cube(&'a Planes),
    /// A column of numbers.
    Column(Vec<f64>),
    Text(String),
    Struct(Vec<(&'static str, Item<'a>)>),
}

// What ISETCam takes where nothing is said (`ieSaveMultiSpectralImage`); its scenes have both fields always.
const DISTANCE_M: f64 = 1.2;
const FOV_DEG: f64 = 10.0;

/// The variables that stand for a file: photons as a `scene` of ISETCam, other quantities as `cube` and `bands`, as in
/// the data sets of ARAD. `comment` has what else is known.
pub(super) fn of(file: &SpectralFile) -> Vec<(&'static str, Item<'_>)> {
    let grid = file.cube.grid();
    let wave = || Item::Column(grid.wavelengths_nm().collect());
    let cube = Item::Cube(file.cube.planes());
    let text = |text: &str| Item::Text(text.to_owned());
    // Numbers and strings only: there is nothing that JSON could not say.
    let comment = Item::Text(serde_json::to_string(&Comment::of(file)).unwrap_or_default());
    if file.quantity != Quantity::Photons {
        return vec![("cube", cube), ("bands", wave()), ("comment", comment)];
    }
    let spectrum = || Item::Struct(vec![("wave", wave())]);
    let mut scene = vec![
        ("type", text("scene")),
        ("name", text(&file.name)),
        ("filename", text("")),
        ("spectrum", spectrum()),
        ("data", Item::Struct(vec![("photons", cube)])),
        ("distance", Item::Column(vec![file.distance_m.unwrap_or(DISTANCE_M)])),
        ("wAngular", Item::Column(vec![file.horizontal_fov_deg.unwrap_or(FOV_DEG)])),
        ("magnification", Item::Column(vec![1.0])),
    ];
    if let Some(light) = &file.illuminant {
        let photons = Item::Struct(vec![("photons", Item::Column(light.values().to_vec()))]);
        let light = vec![
            ("name", text("illuminant")),
            ("type", text("illuminant")),
            ("spectrum", spectrum()),
            ("data", photons),
        ];
        scene.push(("illuminant", Item::Struct(light)));
    }
    vec![("scene", Item::Struct(scene)), ("comment", comment)]
}

/// A plane in the order of MATLAB, column after column.
pub(super) fn column_major(plane: &[f32], rows: usize) -> impl Iterator<Item = f32> {
    let cols = plane.len() / rows.max(1);
    (0..cols).flat_map(move |c| plane.iter().skip(c).step_by(cols).copied())
}
