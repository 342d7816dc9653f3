//! The built-in scenes by name, optionally with parameters: `zone-plate` or
//! `zone-plate?frequency=0.25&size=512`. `&` or `,` separates the parameters; the comma needs no quoting in a
//! shell.

mod params;

use std::borrow::Cow;

pub use self::params::ParamInfo;
use self::params::{Args, COMMON, Kind, choice, number, whole};
use super::{
    Checkerboard, ColorPatches, DeadLeaves, FrequencyOrientation, FrequencySweep, GlossyBalls, Gradients,
    GreySteps, PatternSampling, PointGrid, ResolutionChart, Scene, SceneError, Setting, SiemensStar,
    SlantedBar, ZonePlate, checkerboard, color_patches, dead_leaves, frequency_orientation, frequency_sweep,
    glossy_balls, gradients, grey_steps, hdr, macbeth, point_grid, resolution_chart, siemens_star,
    slanted_bar, uniform, zone_plate, zone_plate_isetcam,
};
use crate::names::nearest;
use crate::spectrum::{Spectrum, reflectance};

/// A built-in scene.
#[derive(Debug, Clone, Copy)]
pub struct SceneInfo {
    /// Its name.
    pub name: &'static str,
    /// What it shows, in one line.
    pub summary: &'static str,
    /// Its own parameters, in addition to [`common_parameters`].
    pub parameters: &'static [ParamInfo],
    build: fn(&Args<'_>, &Setting, &[Spectrum]) -> Result<Scene, SceneError>,
}

/// The built-in scenes.
#[must_use]
pub fn names() -> &'static [SceneInfo] {
    &SCENES
}

/// The scene of a name, with or without parameters.
///
/// # Errors
/// [`SceneError::UnknownScene`] with the closest known name.
pub fn find(spec: &str) -> Result<&'static SceneInfo, SceneError> {
    let name = spec.split_once('?').map_or(spec, |(name, _)| name).trim();
    SCENES.iter().find(|s| s.name == name).ok_or_else(|| {
        let names: Vec<&'static str> = SCENES.iter().map(|s| s.name).collect();
        SceneError::UnknownScene {
            name: name.to_owned(),
            suggestion: nearest(name, names.iter().copied()),
            known: names.join(", "),
        }
    })
}

/// The parameters that every scene accepts. They override the setting.
#[must_use]
pub fn common_parameters() -> &'static [ParamInfo] {
    &COMMON
}

/// [`build`] with all [natural reflectances](reflectance::natural).
///
/// # Errors
/// As [`build`].
pub fn build_natural(spec: &str, setting: &Setting) -> Result<Scene, SceneError> {
    let natural: Vec<Spectrum> = reflectance::natural(setting.grid)?.into_iter().map(|(_, s)| s).collect();
    build(spec, setting, &natural)
}

/// Builds a scene from its name and parameters. `natural` holds the reflectances, on the grid of the setting,
/// from which patterns of natural materials draw. When it is empty, the reflectances of the ColorChecker are
/// used.
///
/// # Errors
/// When the scene or a parameter is unknown (the error holds the closest known name), a value or the setting
/// is out of range, or the scene would be too large.
pub fn build(spec: &str, setting: &Setting, natural: &[Spectrum]) -> Result<Scene, SceneError> {
    let info = find(spec)?;
    let parameters = spec.split_once('?').map_or("", |(_, parameters)| parameters);
    let args = Args::parse(info.name, info.parameters, parameters)?;
    let setting = Setting {
        luminance_cd_m2: args.number_if("luminance")?.unwrap_or(setting.luminance_cd_m2),
        distance_m: args.number_if("distance")?.unwrap_or(setting.distance_m),
        horizontal_fov_deg: args.number_if("fov")?.unwrap_or(setting.horizontal_fov_deg),
        illuminant: args.light()?.unwrap_or_else(|| setting.illuminant.clone()),
        grid: setting.grid,
    };
    setting.check()?;
    (info.build)(&args, &setting, natural)
}

const SEED: ParamInfo = whole!("seed", 1, 0..=18446744073709551615, "seed of the random numbers");

/// The meaning of `sampling` where point samples follow ISETCam's rules.
const SAMPLING: &str = "point samples with ISETCam's rules, or the mean over each pixel";

fn sampling(args: &Args<'_>) -> Result<PatternSampling, SceneError> {
    let point = args.is_first_of("sampling", ["isetcam", "area"])?;
    Ok(if point { PatternSampling::Isetcam } else { PatternSampling::Area })
}

/// The reflectances for patterns of natural materials: those given, or those of the ColorChecker.
fn painted_with<'a>(natural: &'a [Spectrum], s: &Setting) -> Result<Cow<'a, [Spectrum]>, SceneError> {
    if natural.is_empty() {
        return Ok(Cow::Owned(macbeth::reflectances(s.grid)?));
    }
    Ok(Cow::Borrowed(natural))
}

static SCENES: [SceneInfo; 16] = [
    SceneInfo {
        name: "macbeth",
        summary: "ColorChecker, 24 patches in 4 rows of 6",
        parameters: &[whole!("patch", 32, 1..=4096, "rows and columns of a patch, pixels")],
        build: |a, s, _| macbeth::chart(a.count("patch")?, s),
    },
    SceneInfo {
        name: "slanted-bar",
        summary: "slanted edge for the spatial frequency response (ISO 12233)",
        parameters: &[
            whole!("size", 512, 2..=16384, "size, pixels; one more row and column are drawn"),
            number!("slope", "7/3", 0.01..=1e6, "slope of the edge, rows per column"),
            number!(
                "angle",
                "",
                0.01..=89.0,
                "angle of the edge from the vertical, degrees; instead of slope"
            ),
            number!("contrast", "1e6", 1.001..=1e9, "ratio of bright to dark luminance; 4 in ISO 12233:2017"),
            choice!("sampling", "isetcam", "isetcam" or "area", SAMPLING),
        ],
        build: |a, s, _| {
            let slope = match a.number_if("angle")? {
                Some(angle) => SlantedBar::slope_of_angle(angle),
                None => a.number("slope")?,
            };
            let (size, contrast_ratio) = (a.count("size")?, a.number("contrast")?);
            slanted_bar(&SlantedBar { size, slope, contrast_ratio, sampling: sampling(a)? }, s)
        },
    },
    SceneInfo {
        name: "zone-plate",
        summary: "circular zone plate, which shows aliasing",
        parameters: &[
            whole!("size", 384, 2..=16384, "rows and columns, pixels"),
            number!("frequency", "0.5", 1e-3..=2.0, "frequency at the sides, cycles per pixel"),
            number!("contrast", "1", 1e-3..=1.0, "contrast (Michelson)"),
            choice!(
                "sampling",
                "area",
                "isetcam" or "area",
                "ISETCam's plate (always 384 pixels, clipped), or the mean over each pixel"
            ),
        ],
        build: |a, s, _| match sampling(a)? {
            PatternSampling::Isetcam => zone_plate_isetcam(s),
            PatternSampling::Area => {
                let (frequency, contrast) = (a.number("frequency")?, a.number("contrast")?);
                zone_plate(&ZonePlate { size: a.count("size")?, frequency, contrast }, s)
            }
        },
    },
    SceneInfo {
        name: "uniform",
        summary: "uniform white field",
        parameters: &[whole!("size", 64, 1..=16384, "rows and columns, pixels")],
        build: |a, s, _| uniform(a.count("size")?, a.count("size")?, s),
    },
    SceneInfo {
        name: "grey-steps",
        summary: "wedge of grey bars in equal steps of density",
        parameters: &[
            whole!("steps", 20, 2..=4096, "number of bars"),
            whole!("step", 32, 1..=4096, "columns of a bar, pixels"),
            whole!("rows", 160, 1..=16384, "rows, pixels"),
            number!("density", "3", 0.01..=8.0, "density of the darkest bar"),
        ],
        build: |a, s, _| {
            let (steps, step_px, rows) = (a.count("steps")?, a.count("step")?, a.count("rows")?);
            grey_steps(&GreySteps { steps, step_px, rows, density: a.number("density")? }, s)
        },
    },
    SceneInfo {
        name: "frequency-sweep",
        summary: "grating whose frequency increases to the right and whose contrast increases downwards (Campbell-Robson)",
        parameters: &[
            whole!("rows", 384, 1..=16384, "rows, pixels"),
            whole!("cols", 768, 2..=16384, "columns, pixels"),
            number!("lowest", "1/256", 1e-6..=1.0, "frequency at the left, cycles per pixel"),
            number!("highest", "0.5", 1e-6..=2.0, "frequency at the right, cycles per pixel; above lowest"),
            number!("contrast", "0.01", 1e-6..=1.0, "contrast (Michelson) at the top; 1 at the bottom"),
        ],
        build: |a, s, _| {
            let (rows, cols) = (a.count("rows")?, a.count("cols")?);
            let (lowest, highest) = (a.number("lowest")?, a.number("highest")?);
            let least_contrast = a.number("contrast")?;
            frequency_sweep(&FrequencySweep { rows, cols, lowest, highest, least_contrast }, s)
        },
    },
    SceneInfo {
        name: "frequency-orientation",
        summary: "gratings whose frequency increases to the right and whose orientation changes downwards",
        parameters: &[
            whole!("block", 32, 2..=4096, "rows and columns of a grating, pixels"),
            whole!("frequencies", 8, 1..=64, "gratings from left to right, 1, 2, … cycles each"),
            whole!("angles", 8, 1..=64, "gratings from top to bottom, 0 to 90°"),
            number!("contrast", "1", 1e-3..=1.0, "contrast (Michelson)"),
            choice!("sampling", "area", "isetcam" or "area", SAMPLING),
        ],
        build: |a, s, _| {
            let target = FrequencyOrientation {
                block_px: a.count("block")?,
                frequencies: a.count("frequencies")?,
                angles: a.count("angles")?,
                contrast: a.number("contrast")?,
                sampling: sampling(a)?,
            };
            frequency_orientation(&target, s)
        },
    },
    SceneInfo {
        name: "siemens-star",
        summary: "dark spokes on white; the frequency increases towards the centre",
        parameters: &[
            whole!("size", 512, 8..=16384, "rows and columns, pixels"),
            whole!("cycles", 72, 2..=1024, "dark spokes"),
            number!("contrast", "1000", 1.001..=1e9, "ratio of bright to dark luminance"),
        ],
        build: |a, s, _| {
            let (size, cycles) = (a.count("size")?, a.count("cycles")?);
            siemens_star(&SiemensStar { size, cycles, contrast_ratio: a.number("contrast")? }, s)
        },
    },
    SceneInfo {
        name: "point-grid",
        summary: "bright points on black, which show the point spread function",
        parameters: &[
            whole!("points", 15, 1..=1024, "points in each direction"),
            whole!("spacing", 32, 2..=4096, "distance between points, pixels"),
            number!("diameter", "2", 0.1..=4096.0, "diameter of a point, pixels; less than spacing"),
        ],
        build: |a, s, _| {
            let (points, spacing_px) = (a.count("points")?, a.count("spacing")?);
            point_grid(&PointGrid { points, spacing_px, diameter_px: a.number("diameter")? }, s)
        },
    },
    SceneInfo {
        name: "checkerboard",
        summary: "alternating white and dark squares",
        parameters: &[
            whole!("squares", 16, 1..=4096, "squares in each direction"),
            whole!("square", 32, 1..=4096, "rows and columns of a square, pixels"),
            number!("contrast", "1000", 1.001..=1e9, "ratio of bright to dark luminance"),
        ],
        build: |a, s, _| {
            let (squares, square_px) = (a.count("squares")?, a.count("square")?);
            checkerboard(&Checkerboard { squares, square_px, contrast_ratio: a.number("contrast")? }, s)
        },
    },
    SceneInfo {
        name: "dead-leaves",
        summary: "dead leaves: overlapping discs with the power spectrum of natural images",
        parameters: &[
            whole!("rows", 512, 1..=16384, "rows, pixels"),
            whole!("cols", 512, 1..=16384, "columns, pixels"),
            number!("least", "1.5", 0.5..=1e4, "least radius, pixels"),
            number!("largest", "200", 0.6..=1e5, "largest radius, pixels; above least"),
            SEED,
        ],
        build: |a, s, natural| {
            let leaves = DeadLeaves {
                rows: a.count("rows")?,
                cols: a.count("cols")?,
                least_radius_px: a.number("least")?,
                largest_radius_px: a.number("largest")?,
                seed: a.whole("seed")?,
            };
            dead_leaves(&leaves, &painted_with(natural, s)?, s)
        },
    },
    SceneInfo {
        name: "color-patches",
        summary: "uniform square patches of several sizes",
        parameters: &[
            whole!("rows", 512, 1..=16384, "rows, pixels"),
            whole!("cols", 512, 1..=16384, "columns, pixels"),
            whole!("least", 8, 1..=4096, "side of the smallest patches, pixels"),
            whole!("doublings", 4, 0..=8, "number of doublings from the smallest to the largest side"),
            SEED,
        ],
        build: |a, s, natural| {
            let chart = ColorPatches {
                rows: a.count("rows")?,
                cols: a.count("cols")?,
                least_px: a.count("least")?,
                doublings: a.count("doublings")? as u32,
                seed: a.whole("seed")?,
            };
            color_patches(&chart, &painted_with(natural, s)?, s)
        },
    },
    SceneInfo {
        name: "gradients",
        summary: "smooth gradients of colour and illumination",
        parameters: &[
            whole!("rows", 512, 1..=16384, "rows, pixels"),
            whole!("cols", 512, 1..=16384, "columns, pixels"),
            whole!("cell", 64, 2..=16384, "distance from one colour to the next, pixels"),
            number!("contrast", "100", 1.0..=1e8, "ratio of the brightest to the darkest illumination"),
            choice!(
                "paint",
                "colors",
                "colors" or "white",
                "reflectances of the nodes: natural ones, or white only"
            ),
            SEED,
        ],
        build: |a, s, natural| {
            let pattern = Gradients {
                rows: a.count("rows")?,
                cols: a.count("cols")?,
                cell_px: a.count("cell")?,
                contrast_ratio: a.number("contrast")?,
                neutral: a.is_first_of("paint", ["white", "colors"])?,
                seed: a.whole("seed")?,
            };
            gradients(&pattern, &painted_with(natural, s)?, s)
        },
    },
    SceneInfo {
        name: "glossy-balls",
        summary: "high dynamic range: balls with highlights, lamps and deep shade against white paper",
        parameters: &[
            whole!("rows", 512, 8..=16384, "rows, pixels"),
            whole!("cols", 512, 8..=16384, "columns, pixels"),
            number!("shade", "1000", 1.0..=1e8, "ratio of full light to the deepest shade"),
            SEED,
        ],
        build: |a, s, natural| {
            let (rows, cols) = (a.count("rows")?, a.count("cols")?);
            let pattern = GlossyBalls { rows, cols, shade: a.number("shade")?, seed: a.whole("seed")? };
            glossy_balls(&pattern, &painted_with(natural, s)?, s)
        },
    },
    SceneInfo {
        name: "hdr",
        summary: "room with sunlit floor, window, bare bulb and dark corridor: more than 5 decades",
        parameters: &[whole!("rows", 384, 8..=16384, "rows, pixels; 3/2 as many columns")],
        build: |a, s, _| hdr(a.count("rows")?, s),
    },
    SceneInfo {
        name: "resolution-chart",
        summary: "slanted squares, wedges, lines, rings and text after ISO 12233",
        parameters: &[
            whole!("rows", 1080, 60..=16384, "rows, pixels; 4/3 as many columns"),
            number!("contrast", "40", 1.001..=1e9, "ratio of white to black luminance"),
        ],
        build: |a, s, _| {
            let chart = ResolutionChart { rows: a.count("rows")?, contrast_ratio: a.number("contrast")? };
            resolution_chart(&chart, s)
        },
    },
];
