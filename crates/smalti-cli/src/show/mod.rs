//! `smalti show`: what a thing of a name looks like, in the terminal.

mod camera;
mod cfa;
mod curve;
mod find;
mod kitty;
mod picture;
mod plot;
mod scene;
mod sixel;
mod tile;

use std::path::{Path, PathBuf};

use anyhow::bail;
use clap::Args;
use serde_json::{Value, json};
use smalti_io::{Override, write};
use smalti_report::Figure;

use self::find::Kind;
use self::picture::Pixels;
use crate::resolve::has_extension;
use crate::scene_args::SceneOptions;
use crate::table::wrap;
use crate::terminal::{Graphics, Protocol, Screen, When};

/// No line of text is longer.
const TEXT_COLUMNS: usize = 100;

#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:\n  \
    smalti show rgbw                                 a camera: its description, mosaic, spectra\n  \
    smalti show quad-bayer                           a colour filter array\n  \
    smalti show bayer --as cfa --toml                its filters, to copy into a camera of yours\n  \
    smalti show phone --toml > mine.toml             a camera, as a start for your own\n  \
    smalti show zone-plate?frequency=0.3             a scene\n  \
    smalti show macbeth --illuminant A\n  \
    smalti show mine.toml --set sensor.cfa.pattern=xtrans\n  \
    smalti show silicon                              a curve; lights as well: smalti show LED\n  \
    smalti show xtrans -o xtrans.svg                 its mosaic as a picture\n\n\
    Pictures are drawn as the terminal can, as letters when piped. NO_COLOR is respected.")]
pub(crate) struct Show {
    /// A camera, a colour filter array, a scene, a study, an illuminant or a filter: a built-in name (smalti list) or a file
    pub(crate) name: String,
    /// What it is, where a name means several things
    #[arg(long = "as", value_enum, value_name = "KIND")]
    kind: Option<Kind>,
    /// Print the file of a camera or study, or the keys of a colour filter array, to copy and change
    #[arg(long, conflicts_with = "json")]
    toml: bool,
    /// Write the picture here instead: the mosaic of an array or a camera, the curve of a filter or a light (.svg, .png), a scene as
    /// it looks (.png)
    #[arg(short, long, value_name = "FILE", conflicts_with_all = ["json", "toml"])]
    output: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
    /// How to draw
    #[arg(long, value_enum, default_value_t = Graphics::Auto)]
    graphics: Graphics,
    /// Whether to use colours
    #[arg(long, value_enum, default_value_t = When::Auto)]
    color: When,
    /// Replace a key of the camera; may be given more than once. The unit is in the key
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<Override>,
    // Last: its heading would be that of all that follows.
    #[command(flatten, next_help_heading = "Scenes, and wavelengths of whatever is drawn")]
    scene_options: SceneOptions,
}

/// What is shown of a thing, before it is known how.
struct Shown {
    /// Its name, what it is, what else it could be.
    title: String,
    /// Lines of text, broken to fit.
    about: Vec<String>,
    /// Drawn below.
    parts: Vec<Part>,
    json: Value,
    toml: Option<String>,
}

enum Part {
    /// Lines as they are.
    Lines(String),
    Tile(tile::Tile),
    Plot(plot::Plot),
    Picture(Pixels),
}

pub(crate) fn run(args: &Show) -> anyhow::Result<()> {
    let (kind, others) = find::kind(&args.name, args.kind)?;
    refuse_what_is_not_used(args, kind)?;
    let mut shown = match kind {
        Kind::Camera => camera::show(args)?,
        Kind::Cfa => cfa::show(args)?,
        Kind::Scene => scene::show(args)?,
        Kind::Study => find::study(&args.name)?,
        Kind::Illuminant => curve::illuminant(args)?,
        Kind::Filter => curve::filter(args)?,
    };
    if args.toml {
        return match shown.toml {
            Some(text) => crate::print(&text),
            None => bail!("{}: {} has no TOML", args.name, kind.with_article()),
        };
    }
    if let Some(path) = &args.output {
        return save(&shown, kind, path);
    }
    if args.json {
        if let Value::Object(map) = &mut shown.json {
            map.insert("also".into(), json!(others.iter().map(|k| k.name()).collect::<Vec<_>>()));
        }
        return crate::print(&(serde_json::to_string_pretty(&shown.json)? + "\n"));
    }
    if !others.is_empty() {
        let also = others.iter().map(|k| format!("{} (--as {})", k.with_article(), k.name()));
        shown.title += &format!("; also {}", also.collect::<Vec<_>>().join(", "));
    }
    crate::print(&draw(&shown, &Screen::of_stdout(args.graphics, args.color))?)
}

/// An option that would change nothing is a mistake.
fn refuse_what_is_not_used(args: &Show, kind: Kind) -> anyhow::Result<()> {
    let options = &args.scene_options;
    let scene = [Kind::Scene];
    let of_light = [Kind::Scene, Kind::Cfa, Kind::Illuminant, Kind::Filter];
    for (option, given, kinds) in [
        ("--set", !args.overrides.is_empty(), &[Kind::Camera][..]),
        ("--luminance", options.luminance.is_some(), &scene),
        ("--distance", options.distance.is_some(), &scene),
        ("--fov", options.fov.is_some(), &scene),
        ("--illuminant", options.illuminant.is_some(), &scene),
        ("--wavelengths", options.wavelengths.is_some(), &of_light),
    ] {
        if given && !kinds.contains(&kind) {
            bail!("{}: {option} says nothing about {}", args.name, kind.with_article());
        }
    }
    if args.toml && !args.overrides.is_empty() {
        bail!("--toml prints the file as it is, without --set; for the resolved description: --json");
    }
    Ok(())
}

/// Writes the first picture of what is shown.
fn save(shown: &Shown, kind: Kind, path: &Path) -> anyhow::Result<()> {
    let drawing = shown.parts.iter().find_map(|part| match part {
        Part::Lines(_) => None,
        Part::Tile(tile) => Some(tile.figure().map(Drawing::Figure)),
        Part::Plot(plot) => Some(plot.figure().map(Drawing::Figure)),
        Part::Picture(pixels) => Some(Ok(Drawing::Picture(pixels))),
    });
    let Some(drawing) = drawing else { bail!("{} has no picture", kind.with_article()) };
    let bytes = match drawing? {
        Drawing::Figure(figure) if has_extension(path, &["svg"]) => figure.svg().as_bytes().to_vec(),
        Drawing::Figure(figure) if has_extension(path, &["png"]) => figure.png(1.0)?,
        Drawing::Picture(picture) if has_extension(path, &["png"]) => picture.png()?,
        Drawing::Figure(_) => bail!("{}: expected a name that ends in .svg or .png", path.display()),
        Drawing::Picture(_) => bail!("{}: expected a name that ends in .png", path.display()),
    };
    write::bytes(path, &bytes)?;
    crate::print(&format!("{}\n", path.display()))
}

/// What can be written.
enum Drawing<'a> {
    Figure(Figure),
    Picture(&'a Pixels),
}

fn draw(shown: &Shown, screen: &Screen) -> anyhow::Result<String> {
    let limit = screen.columns.min(TEXT_COLUMNS);
    let texts = std::iter::once(&shown.title).chain(&shown.about);
    let mut out: String = texts.flat_map(|text| wrap(text, limit)).map(|line| line + "\n").collect();
    for part in &shown.parts {
        out.push('\n');
        match (part, screen.protocol) {
            (Part::Lines(lines), _) => out += lines,
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

/// Four digits, and no more zeros than needed.
fn figure(v: f64) -> String {
    if v == 0.0 || !v.is_finite() {
        return v.to_string();
    }
    let digits = (3 - v.abs().log10().floor() as i32).clamp(0, 12) as usize;
    let text = format!("{v:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// A figure, in as many pixels as are shown.
fn drawn(figure: &Figure, columns: usize, screen: &Screen, protocol: Protocol) -> anyhow::Result<String> {
    let columns = columns.clamp(1, screen.columns);
    let scale = match protocol {
        // Scaled by the terminal, whose letters may be large.
        Protocol::Kitty => 1.5,
        Protocol::Sixel => (columns * sixel::COLUMN_PX) as f64 / figure.size().0,
    };
    sent(&Pixels::from_png(&figure.png(scale)?)?, columns, screen, protocol)
}

/// A picture for a terminal that shows some, so many columns wide.
fn sent(picture: &Pixels, columns: usize, screen: &Screen, protocol: Protocol) -> anyhow::Result<String> {
    let columns = columns.clamp(1, screen.columns);
    match protocol {
        Protocol::Kitty => kitty::encode(picture, columns),
        // Sixels know pixels only.
        Protocol::Sixel => Ok(sixel::encode(&picture.at_most(columns * sixel::COLUMN_PX))),
    }
}
