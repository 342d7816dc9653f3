//! What `smalti compare` says and leaves behind: tables, results.json, pictures, learned tables.

use std::path::Path;

use serde_json::{Map, Value, json};
use smalti::camera::{Camera, SceneScores};
use smalti::color::Image;
use smalti::l3::Pipeline;
use smalti::spectrum::{Observer, WavelengthGrid};
use smalti_io::{l3, write};
use smalti_report::Sheet;

use crate::args::{Compare, Processing};
use crate::columns::{self, headings};
use crate::compare::{Gain, Outcome, Way};
use crate::pictures::{self, dark_and_bright};
use crate::{compare_page, names, resolve, table};

/// The file that tells that a folder is whole.
pub(crate) const RESULTS: &str = "results.json";
/// The folder of the pictures.
pub(crate) const SIDE_BY_SIDE: &str = "side-by-side";
/// What follows the name of a picture in that of its maps.
const MAPS: &str = "-differences";
/// Pictures in a row.
const ACROSS: usize = 4;

/// All that was found.
pub(crate) struct Report<'a> {
    pub(crate) args: &'a Compare,
    pub(crate) cameras: &'a [Camera],
    /// What they are called.
    pub(crate) labels: &'a [String],
    pub(crate) ways: &'a [Way<'a>],
    /// Ways that are not defined for their camera.
    pub(crate) left_out: &'a [String],
    /// For each way, one for each light.
    pub(crate) outcomes: &'a [Vec<Outcome>],
    pub(crate) gains: &'a [Gain],
}

/// The mean of a score over the scenes.
pub(crate) fn mean(outcome: &Outcome, of: impl Fn(&SceneScores) -> f64) -> f64 {
    outcome.scenes.iter().map(|(_, s)| of(s)).sum::<f64>() / outcome.scenes.len().max(1) as f64
}

impl Report<'_> {
    /// One row for each light and way.
    pub(crate) fn scores_table(&self) -> String {
        let header: Vec<&str> =
            ["camera", "pipeline", "cd/m²"].into_iter().chain(headings(&columns::COMPARE)).collect();
        let mut rows = Vec::new();
        let lights = self.outcomes.first().map_or(0, Vec::len);
        for light in 0..lights {
            for (way, outcomes) in self.ways.iter().zip(self.outcomes) {
                let o = &outcomes[light];
                rows.push(vec![
                    way.label.to_owned(),
                    way.processing.name().to_owned(),
                    o.luminance_cd_m2.to_string(),
                    format!("{:.2}", mean(o, |s| s.scores.cpsnr_db)),
                    format!("{:.2}", mean(o, |s| s.scores.pixel_delta_e_2000_mean)),
                    format!("{:.2}", mean(o, |s| s.scores.scielab_mean)),
                    format!("{:.1}", o.targets.mtf50_cy_per_mm),
                    format!("{:.3}", o.targets.visual_snr.median),
                    format!("{:.1}", o.targets.luminance_noise_percent.mean),
                ]);
            }
        }
        table::render(&header, &rows)
    }

    /// How far fixed point is from single precision, at worst.
    pub(crate) fn fixed_point_line(&self) -> String {
        let all = self.outcomes.iter().flatten().flat_map(|o| o.fixed_point_psnr_db.iter().flatten());
        match all.copied().reduce(f64::min) {
            Some(db) => format!(
                "fixed point (16-bit samples and kernels) is within {db:.1} dB PSNR of single precision\n"
            ),
            None => String::new(),
        }
    }

    /// A table for each camera that is to be equalled, in each light.
    pub(crate) fn gains_table(&self) -> String {
        let mut out = String::new();
        for Gain { first, other, gains, scenes } in self.gains {
            let header = ["metric", first.as_str(), other.as_str(), "light gain"];
            let row = |g: &smalti::camera::MetricGain| {
                vec![
                    g.metric.to_owned(),
                    format!("{:.3}", g.own),
                    format!("{:.3}", g.target),
                    g.gain.to_string(),
                ]
            };
            let rows: Vec<Vec<String>> = gains.metrics.iter().map(row).collect();
            out += &format!(
                "\nmore light that {first} needs to equal {other} at {} cd/m²\n{}of {}, and of four captures of the chart: \
                 other pictures than those of the first table\n",
                gains.luminance_cd_m2,
                table::render(&header, &rows),
                scenes.join(" and "),
            );
        }
        out
    }

    /// results.json.
    pub(crate) fn document(&self) -> anyhow::Result<Value> {
        let mut entries = Vec::new();
        for (way, outcomes) in self.ways.iter().zip(self.outcomes) {
            for o in outcomes {
                let scenes: Vec<Value> = o
                    .scenes
                    .iter()
                    .zip(&o.fixed_point_psnr_db)
                    .map(|((name, s), fixed)| {
                        let scores = serde_json::to_value(s)?;
                        Ok(json!({"scene": name, "scores": scores, "fixed_point_psnr_db": fixed}))
                    })
                    .collect::<anyhow::Result<_>>()?;
                entries.push(json!({
                    "camera": way.label,
                    "pipeline": way.processing.name(),
                    "luminance_cd_m2": o.luminance_cd_m2,
                    "cpsnr_db": mean(o, |s| s.scores.cpsnr_db),
                    "pixel_delta_e_2000_mean": mean(o, |s| s.scores.pixel_delta_e_2000_mean),
                    "scielab_mean": mean(o, |s| s.scores.scielab_mean),
                    "targets": serde_json::to_value(&o.targets)?,
                    "scenes": scenes,
                }));
            }
        }
        let learned = self.learned();
        Ok(json!({
            "smalti_version": env!("CARGO_PKG_VERSION"),
            "illuminant": self.args.illuminant,
            "seed": self.args.camera_options.seed,
            "left_out": self.left_out,
            "files": self.files(),
            "results": entries,
            "light_gains": self.gains.iter().map(|g| Ok(json!({
                "needs_more_light": g.first,
                "to_equal": g.other,
                "scenes": g.scenes,
                "gains": serde_json::to_value(&g.gains)?,
            }))).collect::<anyhow::Result<Vec<Value>>>()?,
            "learned": learned.iter().map(|(w, p, _)| kernels_as_json(w.label, p)).collect::<Vec<_>>(),
            "cameras": self.cameras.iter().map(|c| serde_json::to_value(c.description())).collect::<Result<Vec<_>, _>>()?,
        }))
    }

    /// Names of the pictures without extension, for each light one for each scene.
    fn picture_names(&self) -> Vec<Vec<String>> {
        let lights = self.outcomes.first().map_or(&[][..], Vec::as_slice);
        let of_light = |light: &Outcome| {
            let stems: Vec<String> = light.scenes.iter().map(|(scene, _)| stem(scene)).collect();
            let files = names::file_names(stems.iter().map(String::as_str));
            files.into_iter().map(|f| format!("{f}-{}-cd-m2", light.luminance_cd_m2)).collect()
        };
        lights.iter().map(of_light).collect()
    }

    /// Luminances that were compared.
    pub(crate) fn light_count(&self) -> usize {
        self.outcomes.first().map_or(0, Vec::len)
    }

    /// One of them, cd/m².
    pub(crate) fn luminance(&self, light: usize) -> f64 {
        self.outcomes.first().and_then(|o| o.get(light)).map_or(f64::NAN, |o| o.luminance_cd_m2)
    }

    /// The scenes, as [`scene::catalog`](smalti::scene::catalog) takes them, or files.
    pub(crate) fn scene_names(&self) -> Vec<String> {
        let scenes = self.outcomes.first().and_then(|o| o.first()).map_or(&[][..], |o| o.scenes.as_slice());
        scenes.iter().map(|(name, _)| name.clone()).collect()
    }

    /// Scenes that were compared on.
    pub(crate) fn scene_count(&self) -> usize {
        self.outcomes.first().and_then(|o| o.first()).map_or(0, |o| o.scenes.len())
    }

    /// The learned ways.
    pub(crate) fn learned_ways(&self) -> Vec<(&Way<'_>, &Pipeline)> {
        self.learned().into_iter().map(|(way, pipeline, _)| (way, pipeline)).collect()
    }

    /// The learned ways with the names of their files.
    fn learned(&self) -> Vec<(&Way<'_>, &Pipeline, String)> {
        let learned: Vec<&Way<'_>> = self.ways.iter().filter(|w| w.processing == Processing::L3).collect();
        let files = names::file_names(learned.iter().map(|w| w.label));
        learned.into_iter().zip(files).filter_map(|(w, file)| Some((w, w.pipeline?, file))).collect()
    }

    /// All files but results.json, relative to the folder.
    fn files(&self) -> Vec<String> {
        let pictures = self.picture_names().into_iter().flatten();
        let pictures = pictures.flat_map(|p| ["", MAPS].map(|what| format!("{SIDE_BY_SIDE}/{p}{what}.png")));
        let tables = self.learned().into_iter();
        let tables = tables.flat_map(|(_, _, f)| [format!("{f}-kernels.png"), format!("{f}.l3")]);
        pictures.chain(tables).chain([compare_page::FILE.to_owned()]).collect()
    }

    /// Removes what an earlier comparison says in its results.json that it has written here, but what is written again.
    fn remove_earlier(&self) {
        let dir = &self.args.output;
        let Some(files) = std::fs::read(dir.join(RESULTS))
            .ok()
            .and_then(|text| serde_json::from_slice::<Value>(&text).ok())
            .and_then(|results| results.get("files")?.as_array().cloned())
        else {
            return;
        };
        let new = self.files();
        for file in files.iter().filter_map(Value::as_str).filter(|f| !new.iter().any(|n| n == f)) {
            // A name that leads elsewhere is none that a comparison gives.
            let name = file.strip_prefix(SIDE_BY_SIDE).and_then(|f| f.strip_prefix('/')).unwrap_or(file);
            let own = name.ends_with(".png") || name.ends_with(".l3") || file == compare_page::FILE;
            if own && Path::new(name).file_name().is_some_and(|n| n == name) {
                // One that is gone, or cannot be removed, is no reason to lose what was computed.
                let _ = std::fs::remove_file(dir.join(file));
            }
        }
    }

    /// Writes everything; `text` is results.json.
    pub(crate) fn write(&self, text: &str) -> anyhow::Result<()> {
        // A folder that has results.json is whole: that of an earlier run goes first, the new one comes last.
        let dir = &self.args.output;
        self.remove_earlier();
        let page = compare_page::page(self)?;
        write::begin_folder(dir, &[RESULTS])?;
        let folder = dir.join(SIDE_BY_SIDE);
        write::begin_folder(&folder, &[])?;
        let lights = self.outcomes.first().map_or(&[][..], Vec::as_slice);
        for (l, (light, names)) in lights.iter().zip(self.picture_names()).enumerate() {
            for (s, ((scene, first), name)) in light.scenes.iter().zip(names).enumerate() {
                let title = format!("{}, {} cd/m²", stem(scene), light.luminance_cd_m2);
                let reference = self.as_seen(first, &first.reference)?;
                let mut sheet = pictures::add(Sheet::new(ACROSS).title(&title), "reference", &reference);
                for (way, outcomes) in self.ways.iter().zip(self.outcomes) {
                    let scored = &outcomes[l].scenes[s].1;
                    let scores = &scored.scores;
                    let caption = format!(
                        "{} {}\n{:.1} dB, S-CIELAB {:.1}",
                        way.label,
                        way.processing.name(),
                        scores.cpsnr_db,
                        scores.scielab_mean
                    );
                    sheet = pictures::add(sheet, caption, &self.as_seen(scored, &scored.picture)?);
                }
                write::bytes(&folder.join(format!("{name}.png")), &sheet.draw()?.png(1.0)?)?;
                let maps = compare_page::maps_sheet(self, title, l, s);
                write::bytes(&folder.join(format!("{name}{MAPS}.png")), &maps.draw()?.png(1.0)?)?;
            }
        }
        for (way, pipeline, file) in self.learned() {
            let sheet = pictures::kernels(way.camera, way.label, pipeline)?;
            write::bytes(&dir.join(format!("{file}-kernels.png")), &sheet.draw()?.png(1.0)?)?;
            l3::write_table(&dir.join(format!("{file}.l3")), pipeline)?;
        }
        write::bytes(&dir.join(compare_page::FILE), page.as_bytes())?;
        write::bytes(&dir.join(RESULTS), text.as_bytes())?;
        Ok(())
    }

    /// A picture of a scored scene as shown on a screen: white is that of the reference.
    pub(crate) fn as_seen(&self, scores: &SceneScores, picture: &Image) -> anyhow::Result<Image> {
        let grid = WavelengthGrid::VISIBLE;
        let white = Observer::Cie1931.white(&resolve::illuminant(&self.args.illuminant)?.photons(grid)?)?;
        Ok(picture.shown(Some(white), 1.0 / scores.scores.white_y)?)
    }
}

/// The classes of a pipeline in numbers, and the kernels that are drawn.
fn kernels_as_json(camera: &str, pipeline: &Pipeline) -> Value {
    let summary = pipeline.summary();
    let drawn: Vec<Value> = dark_and_bright(pipeline)
        .into_iter()
        .map(|class| {
            let key = pipeline.key(class);
            let outputs: Map<String, Value> = pipeline
                .outputs()
                .iter()
                .enumerate()
                .map(|(o, name)| (name.clone(), json!(pipeline.weights(class, o))))
                .collect();
            json!({
                "position": key.position,
                "level": key.level,
                "texture": pipeline.axes().textures().names()[usize::from(key.texture)],
                "weights": outputs,
            })
        })
        .collect();
    json!({
        "camera": camera,
        "classes": summary.classes,
        "classes_that_occur": summary.occupied,
        "operators": summary.operators,
        "patches": summary.patches,
        "kernels": drawn,
    })
}

/// The name of a scene without its folder, parameters and extension.
pub(crate) fn stem(scene: &str) -> String {
    let name = if resolve::is_file(scene) { scene } else { scene.split('?').next().unwrap_or(scene) };
    Path::new(name).file_stem().map_or_else(|| scene.to_owned(), |s| s.to_string_lossy().into_owned())
}
