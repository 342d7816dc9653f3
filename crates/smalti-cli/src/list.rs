//! `smalti list`: lists built-in items, and the keys of camera and study files.

use anyhow::bail;
use clap::{Args, ValueEnum};
use serde_json::json;
use smalti::metrics;
use smalti::scene::catalog;
use smalti::sensor::cfa;
use smalti::spectrum::Illuminant;
use smalti_io::{BuiltinFile, cameras, studies};
use smalti_report::comparison::columns::where_shown;

use crate::keys::{Entry, keys};
use crate::{table, terminal};

#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:\n  \
    smalti list cfas\n  \
    smalti list scenes --json\n  \
    smalti list camera-keys                               the keys of a camera file, with defaults\n  \
    smalti list camera-keys --schema > camera.json        a JSON Schema for editors")]
pub(crate) struct List {
    /// What to list
    #[arg(value_enum)]
    pub(crate) what: Listing,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// Print Markdown, as in docs/reference
    #[arg(long, conflicts_with = "json")]
    pub(crate) markdown: bool,
    /// Print a JSON Schema, for camera-keys and study-keys
    #[arg(long, conflicts_with_all = ["json", "markdown"])]
    pub(crate) schema: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Listing {
    /// Built-in scenes and their parameters
    Scenes,
    /// Colour filter arrays, with their tiles and sources
    Cfas,
    /// Built-in cameras
    Cameras,
    /// Light sources
    Illuminants,
    /// Filter curves
    Filters,
    /// Metrics, with their units
    Metrics,
    /// Studies of many designs, for `smalti sweep`
    Studies,
    /// Keys of a camera file, with their defaults
    CameraKeys,
    /// Keys of a study file, with their defaults
    StudyKeys,
}

/// The least width of wrapped text.
const MIN_COLUMNS: usize = 24;

pub(crate) fn run(args: &List) -> anyhow::Result<()> {
    let entries = match args.what {
        Listing::Scenes => scenes(),
        Listing::Cfas => cfas()?,
        Listing::Cameras => files(cameras::names()),
        Listing::Illuminants => illuminants(),
        Listing::Filters => filters(),
        Listing::Metrics => metric_list(),
        Listing::Studies => files(studies::names()),
        Listing::CameraKeys => keys(&cameras::schema()),
        Listing::StudyKeys => keys(&studies::schema()),
    };
    if args.schema {
        let schema = match args.what {
            Listing::CameraKeys => cameras::schema(),
            Listing::StudyKeys => studies::schema(),
            _ => bail!("--schema applies to camera-keys and study-keys"),
        };
        return crate::output::print_json(&schema);
    }
    if args.markdown {
        return crate::print(&markdown(args.what, &entries));
    }
    if args.json {
        let json: Vec<_> = entries.iter().map(|e| e.json.clone()).collect();
        return crate::output::print_json(&json);
    }
    crate::print(&lines(&entries, terminal::columns()))
}

/// Names with their summaries and details, wrapped to a width if there is one.
fn lines(entries: &[Entry], columns: Option<usize>) -> String {
    let width = entries.iter().map(|e| e.name.chars().count()).max().unwrap_or(0);
    let broken = |text: &str, indent: usize| match columns {
        // Single words per line would be harder to read than long lines.
        Some(columns) if columns >= indent + MIN_COLUMNS => table::wrap(text, columns - indent),
        _ => vec![text.to_owned()],
    };
    let mut out = String::new();
    for e in entries {
        let mut name = e.name.as_str();
        for line in broken(&e.summary, width + 2) {
            out += &format!("{name:width$}  {line}\n");
            name = "";
        }
        for line in e.details.iter().flat_map(|line| broken(line, width + 4)) {
            out += &format!("{:width$}    {line}\n", "");
        }
    }
    out
}

/// A page of the reference. Colour filter arrays have pictures of their tiles, from `smalti show NAME -o FILE`.
fn markdown(what: Listing, entries: &[Entry]) -> String {
    let value = what.to_possible_value();
    let name = value.as_ref().map(|v| v.get_name().to_owned()).unwrap_or_default();
    let title = value.and_then(|v| v.get_help().map(ToString::to_string)).unwrap_or_default();
    // A bar would end the cell of a table, an angle bracket begin a tag.
    let cell = |s: &str| s.replace('|', "\\|").replace('<', "&lt;").replace("  ", " · ");
    let mut page = format!(
        "# {title}\n\nAs `smalti list {name}` prints them; this page is made by `just reference`.\n\n| name | |\n|---|---|\n",
    );
    for e in entries {
        let lines: Vec<String> = [&e.summary].into_iter().chain(&e.details).map(|l| cell(l)).collect();
        let picture = match what {
            Listing::Cfas => {
                format!("<br><img src=\"cfas/{0}.svg\" width=\"160\" alt=\"The tile of {0}\">", e.name)
            }
            _ => String::new(),
        };
        page += &format!("| `{}`{picture} | {} |\n", e.name, lines.join("<br>"));
    }
    page
}

fn scenes() -> Vec<Entry> {
    let entry = |s: &catalog::SceneInfo| {
        let parameter =
            |p: &catalog::ParamInfo| format!("?{}={}  {} ({})", p.name, p.default, p.doc, p.expected);
        let as_json = |p: &catalog::ParamInfo| json!({"name": p.name, "default": p.default, "expected": p.expected, "doc": p.doc});
        Entry {
            name: s.name.into(),
            summary: s.summary.into(),
            details: s.parameters.iter().map(parameter).collect(),
            json: json!({
                "name": s.name, "summary": s.summary,
                "parameters": s.parameters.iter().map(as_json).collect::<Vec<_>>(),
            }),
        }
    };
    catalog::names().iter().map(entry).collect()
}

fn cfas() -> Result<Vec<Entry>, cfa::CfaError> {
    let entry = |c: &cfa::CfaInfo| {
        let pattern = c.pattern()?;
        Ok(Entry {
            name: c.name.into(),
            summary: format!("{} ({} × {})", c.summary, c.rows(), c.cols()),
            details: pattern.iter().cloned().chain([c.source.to_owned()]).collect(),
            json: json!({
                "name": c.name, "aliases": c.aliases, "summary": c.summary, "source": c.source,
                "rows": c.rows(), "cols": c.cols(), "pattern": pattern,
            }),
        })
    };
    cfa::names().iter().map(entry).collect()
}

fn files(files: &[BuiltinFile]) -> Vec<Entry> {
    let entry = |f: &BuiltinFile| Entry {
        name: f.name.into(),
        summary: f.summary.into(),
        details: Vec::new(),
        json: json!({"name": f.name, "summary": f.summary, "toml": f.toml}),
    };
    files.iter().map(entry).collect()
}

fn illuminants() -> Vec<Entry> {
    let summary = |name: &str| match name {
        "A" => "CIE standard illuminant A, tungsten",
        "D50" | "D55" | "D65" | "D75" => "CIE daylight",
        "E" => "equal energy",
        "F2" => "CIE FL2, cool white fluorescent",
        "F11" => "CIE FL11, narrow-band fluorescent",
        "LED" => "CIE LED-B3, phosphor white near 4100 K",
        _ => "",
    };
    let entry = |(name, summary): (&str, &str)| Entry {
        name: name.into(),
        summary: summary.into(),
        details: Vec::new(),
        json: json!({"name": name, "summary": summary}),
    };
    let named = Illuminant::names().iter().map(|name| (*name, summary(name)));
    // A family is represented by an example.
    let families = [
        ("D:5600", "CIE daylight of any temperature, 4000 to 25000 K"),
        (
            "blackbody:3200",
            "Planckian radiator of any temperature; or a CSV of wavelength_nm and relative power",
        ),
    ];
    named.chain(families).map(entry).collect()
}

fn filters() -> Vec<Entry> {
    let entry = |f: &cfa::FilterInfo| Entry {
        name: f.name.into(),
        summary: f.summary.into(),
        details: vec![f.source.into()],
        json: json!({"name": f.name, "summary": f.summary, "source": f.source}),
    };
    cfa::builtin_filters().iter().map(entry).collect()
}

fn metric_list() -> Vec<Entry> {
    let entry = |m: &metrics::MetricInfo| Entry {
        name: m.name.into(),
        summary: format!("[{}] {}", m.unit, m.doc),
        details: where_shown(m.name).into_iter().chain([m.source.into()]).collect(),
        json: json!({"name": m.name, "unit": m.unit, "doc": m.doc, "source": m.source}),
    };
    metrics::CATALOG.iter().map(entry).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_fit_the_width() {
        for entries in [scenes(), cfas().unwrap(), metric_list(), keys(&cameras::schema())] {
            let whole = lines(&entries, None);
            let broken = lines(&entries, Some(80));
            assert!(broken.lines().count() > whole.lines().count());
            let words = |text: &str| text.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
            assert_eq!(words(&broken), words(&whole));
            for line in broken.lines() {
                let one_word = line.split_whitespace().count() <= 2;
                assert!(line.chars().count() <= 80 || one_word, "{line}");
            }
        }
    }
}
