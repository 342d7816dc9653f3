//! `smalti show`: draws a camera, a colour filter array, a scene, a study, an illuminant or a filter in the terminal.

mod camera;
mod cfa;
mod curve;
mod datasheet;
pub(crate) mod find;
mod kitty;
mod picture;
mod plot;
mod scene;
mod sixel;
mod study;
mod tile;

use std::path::{Path, PathBuf};

use anyhow::bail;
use clap::Args;
use serde_json::{Value, json};
use smalti::names::{harmless, in_one_line};
use smalti::sensor::Cfa;
use smalti_io::{Override, write};
use smalti_report::Figure;

use self::datasheet::{Datasheet, Part};
use self::find::Kind;
use self::picture::Pixels;
use self::tile::Tile;
use crate::args::Common;
use crate::resolve::{self, has_extension};
use crate::scene_args::SceneOptions;
use crate::table::wrap;
use crate::terminal::{ColorChoice, GraphicsChoice, Protocol, Screen};

/// The longest line of text.
const TEXT_COLUMNS: usize = 100;

#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:\n  \
    smalti show rgbw                                 a camera: its description, mosaic and spectra\n  \
    smalti show quad-bayer                           a colour filter array\n  \
    smalti show bayer --as cfa --toml                its filters, to copy into your own camera\n  \
    smalti show phone --toml > mine.toml             a camera file to start your own from\n  \
    smalti show zone-plate?frequency=0.3             a scene\n  \
    smalti show macbeth --illuminant A\n  \
    smalti show mine.toml@xtrans                     a camera with another mosaic\n  \
    smalti show silicon                              a curve; smalti show LED draws an illuminant\n  \
    smalti show xtrans -o xtrans.svg                 its mosaic as a picture file\n\n\
    Pictures are drawn with the best graphics that the terminal is known to support, and as letters when piped. NO_COLOR is respected.")]
pub(crate) struct Show {
    /// A camera, a colour filter array, a scene, a study, an illuminant or a filter: a built-in name (smalti list) or a file
    pub(crate) name: String,
    /// The kind of item, where a name has several meanings
    #[arg(long = "as", value_enum, value_name = "KIND")]
    kind: Option<Kind>,
    /// Print the TOML file of a camera or study, or the keys of a colour filter array, as a template
    #[arg(long, conflicts_with = "json")]
    toml: bool,
    /// Write the picture to this file instead: the mosaic of an array or camera, the curve of a filter or illuminant (.svg, .png),
    /// or the appearance of a scene (.png)
    #[arg(short, long, value_name = "FILE", conflicts_with_all = ["json", "toml"])]
    output: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
    /// Graphics to draw with
    #[arg(long, value_enum, default_value_t = GraphicsChoice::Auto)]
    graphics: GraphicsChoice,
    /// When to use colours
    #[arg(long, value_enum, default_value_t = ColorChoice::Auto)]
    color: ColorChoice,
    /// Replace a key of the camera, whose name contains the unit; may be given more than once
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<Override>,
    /// Another mosaic for the camera: a name (smalti list cfas) or a TOML file; CAMERA@MOSAIC is the same
    #[arg(long, value_name = "MOSAIC")]
    cfa: Option<String>,
    // Last: the heading would apply to all arguments after it.
    #[command(flatten, next_help_heading = "Scenes, and wavelengths of every drawing")]
    scene_options: SceneOptions,
}

pub(crate) fn run(args: &Show, common: &Common) -> anyhow::Result<()> {
    let (kind, others) = find::kind(&args.name, args.kind)?;
    refuse_unused_options(args, kind)?;
    let options = &args.scene_options;
    let mut sheet = match kind {
        Kind::Camera => {
            camera::datasheet(&resolve::with_cfa(&args.name, args.cfa.as_deref())?, &args.overrides, common)?
        }
        Kind::Cfa => cfa::datasheet(&args.name, options)?,
        Kind::Scene => scene::datasheet(&args.name, options, common)?,
        Kind::Study => study::datasheet(&args.name)?,
        Kind::Illuminant => curve::illuminant(&args.name, options)?,
        Kind::Filter => curve::filter(&args.name, options)?,
    };
    if args.toml {
        return match sheet.toml {
            Some(text) => crate::print(&text),
            None => bail!("{}: {} has no TOML file", args.name, kind.with_article()),
        };
    }
    if let Some(path) = &args.output {
        return save(&sheet, kind, path);
    }
    if args.json {
        if let Value::Object(map) = &mut sheet.json {
            map.insert("also".into(), json!(others.iter().map(|k| k.name()).collect::<Vec<_>>()));
        }
        return crate::output::print_json(&sheet.json);
    }
    if !others.is_empty() {
        let also = others.iter().map(|k| format!("{} (--as {})", k.with_article(), k.name()));
        sheet.title += &format!("; also {}", also.collect::<Vec<_>>().join(", "));
    }
    crate::output::print_drawing(&draw(&sheet, &Screen::of_stdout(args.graphics, args.color))?)
}

/// Refuses options that would have no effect.
fn refuse_unused_options(args: &Show, kind: Kind) -> anyhow::Result<()> {
    let options = &args.scene_options;
    let scene = [Kind::Scene];
    let of_light = [Kind::Scene, Kind::Cfa, Kind::Illuminant, Kind::Filter];
    for (option, given, kinds) in [
        ("--set", !args.overrides.is_empty(), &[Kind::Camera][..]),
        ("--cfa", args.cfa.is_some(), &[Kind::Camera]),
        ("--luminance", options.luminance.is_some(), &scene),
        ("--distance", options.distance.is_some(), &scene),
        ("--fov", options.fov.is_some(), &scene),
        ("--illuminant", options.illuminant.is_some(), &scene),
        ("--wavelengths", options.wavelengths.is_some(), &of_light),
    ] {
        if given && !kinds.contains(&kind) {
            bail!("{}: {option} does not apply to {}", args.name, kind.with_article());
        }
    }
    if args.toml && !args.overrides.is_empty() {
        bail!("--toml prints the unchanged file and ignores --set; --json prints the resolved description");
    }
    Ok(())
}

/// The mosaic of an array as a figure.
pub(crate) fn mosaic_figure(array: &Cfa) -> anyhow::Result<Figure> {
    Tile::of(array, |_| None)?.figure()
}

/// Writes the first picture of a datasheet.
fn save(sheet: &Datasheet, kind: Kind, path: &Path) -> anyhow::Result<()> {
    let [svg, png] = ["svg", "png"].map(|extension| has_extension(path, &[extension]));
    let encoded = |figure: Figure| match (svg, png) {
        (true, _) => Ok(figure.svg().as_bytes().to_vec()),
        (_, true) => Ok(figure.png(1.0)?),
        _ => bail!("{}: expected a name that ends in .svg or .png", path.display()),
    };
    let bytes = match sheet.parts.iter().find(|part| !matches!(part, Part::Lines(_))) {
        Some(Part::Tile(tile)) => encoded(tile.figure()?)?,
        Some(Part::Plot(plot)) => encoded(plot.figure()?)?,
        Some(Part::Picture(picture)) if png => picture.png()?,
        Some(Part::Picture(_)) => bail!("{}: expected a name that ends in .png", path.display()),
        _ => bail!("{} has no picture", kind.with_article()),
    };
    write::bytes(path, &bytes)?;
    crate::print(&format!("{}\n", path.display()))
}

fn draw(sheet: &Datasheet, screen: &Screen) -> anyhow::Result<String> {
    let limit = screen.columns.min(TEXT_COLUMNS);
    let texts = std::iter::once(&sheet.title).chain(&sheet.about);
    let lines = texts.flat_map(|text| wrap(&in_one_line(text), limit));
    let mut out: String = lines.map(|line| line + "\n").collect();
    for part in &sheet.parts {
        out.push('\n');
        match (part, screen.protocol) {
            (Part::Lines(lines), _) => out += &harmless(lines),
            (Part::Tile(tile), None) => out += &tile.lines(screen),
            (Part::Tile(tile), Some(protocol)) => {
                out += &drawn(&tile.figure()?, tile.figure_columns(), screen, protocol)?;
                out += &tile.legend(screen);
            }
            (Part::Plot(plot), None) => out += &plot.lines(screen),
            (Part::Plot(plot), Some(protocol)) => {
                out += &drawn(&plot.figure()?, plot::COLUMNS + plot::MARGIN, screen, protocol)?;
            }
            (Part::Picture(picture), None) => out += &picture.lines(screen),
            (Part::Picture(picture), Some(protocol)) => {
                out += &sent(picture, picture.columns_on(screen), screen, protocol)?;
            }
        }
    }
    Ok(out)
}

/// Encodes a figure at the resolution of its display.
fn drawn(figure: &Figure, columns: usize, screen: &Screen, protocol: Protocol) -> anyhow::Result<String> {
    let columns = columns.clamp(1, screen.columns);
    let scale = match protocol {
        // The terminal scales the picture to its own characters.
        Protocol::Kitty => 1.5,
        Protocol::Sixel => (columns * sixel::COLUMN_PX) as f64 / figure.size().0,
    };
    sent(&Pixels::from_png(&figure.png(scale)?)?, columns, screen, protocol)
}

/// Encodes a picture for a terminal with a graphics protocol, `columns` wide.
fn sent(picture: &Pixels, columns: usize, screen: &Screen, protocol: Protocol) -> anyhow::Result<String> {
    let columns = columns.clamp(1, screen.columns);
    match protocol {
        Protocol::Kitty => kitty::encode(picture, columns),
        // The size of a sixel picture is in pixels.
        Protocol::Sixel => sixel::encode(&picture.at_most(columns * sixel::COLUMN_PX)),
    }
}
