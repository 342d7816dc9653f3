//! `smalti evaluate`: the scores of cameras, as a table or as JSON.

use std::path::Path;

use anyhow::Context;
use serde_json::json;
use smalti::camera::{Camera, Evaluation, EvaluationPictures, EvaluationSettings, evaluate};
use smalti::color::{ColorSpace, Image};
use smalti::numeric::Planes;
use smalti::spectrum::{Observer, WavelengthGrid};
use smalti_io::cache::Cache;
use smalti_io::picture::{self, Depth};
use smalti_io::write;

use crate::args::{Common, Evaluate};
use crate::columns::headings;
use crate::compare_page::{self, Shots};
use crate::progress::Progress;
use crate::{columns, names, resolve, table};

pub(crate) fn run(args: &Evaluate, common: &Common) -> anyhow::Result<()> {
    let illuminant = resolve::illuminant(&args.illuminant)?;
    let cameras = args
        .cameras
        .iter()
        .map(|name| resolve::camera(name, &args.camera_options, None))
        .collect::<anyhow::Result<Vec<Camera>>>()?;
    if let Some(dir) = &args.output {
        write::ensure_can_fill(dir)?;
    }
    let cache = if args.no_cache { Cache::disabled() } else { Cache::open(None) };
    let progress = Progress::new((cameras.len() * args.luminance.len()) as u64, common.quiet);
    let (mut results, mut shots) = (Vec::new(), Vec::new());
    for camera in &cameras {
        for &luminance_cd_m2 in &args.luminance {
            let name = &camera.description().name;
            progress.begin(format!("{name} at {luminance_cd_m2} cd/m²"));
            let seed = args.camera_options.seed;
            let settings = EvaluationSettings { luminance_cd_m2, illuminant: illuminant.clone(), seed };
            let (scores, pictures) = evaluate(camera, &settings, &|key, make| cache.optical_image(key, make))
                .with_context(|| format!("{name} at {luminance_cd_m2} cd/m²"))?;
            shots.extend(args.output.is_some().then_some(pictures));
            results.push((camera, scores));
            progress.done();
        }
    }
    progress.finish();
    let document = json!({
        "smalti_version": env!("CARGO_PKG_VERSION"),
        "illuminant": args.illuminant,
        "cameras": results.iter().map(|(c, s)| entry(c, s)).collect::<anyhow::Result<Vec<_>>>()?,
    });
    let text = serde_json::to_string_pretty(&document)? + "\n";
    // Everything is computed before anything is written; a folder that has results.json is whole.
    if let Some(dir) = &args.output {
        write::begin_folder(dir, &["results.json"])?;
        let white = Observer::Cie1931.white(&illuminant.photons(WavelengthGrid::VISIBLE)?)?;
        let page = compare_page::evaluate_page(&Shots {
            words: &args.words,
            typed: &args.cameras,
            cameras: &cameras,
            labels: &names::numbered(cameras.iter().map(|c| c.description().name.clone()).collect()),
            luminances_cd_m2: &args.luminance,
            illuminant: &args.illuminant,
            white,
            seed: args.camera_options.seed,
            results: &results,
            pictures: &shots,
            aliasing: aliasing_picture,
        })?;
        let names = names::of_cameras(&cameras);
        let runs = names.iter().flat_map(|name| args.luminance.iter().map(move |cd_m2| (name, cd_m2)));
        for ((name, cd_m2), pictures) in runs.zip(&shots) {
            write_pictures(&dir.join(format!("{name}-{cd_m2}-cd-m2")), pictures)?;
        }
        write::bytes(&dir.join(compare_page::FILE), page.as_bytes())?;
        write::bytes(&dir.join("results.json"), text.as_bytes())?;
    }
    crate::print(&if args.json { text } else { scores_table(&results) })
}

fn entry(camera: &Camera, scores: &Evaluation) -> anyhow::Result<serde_json::Value> {
    let mut entry = json!({"camera": camera.description().name});
    if let (Some(into), serde_json::Value::Object(scores)) =
        (entry.as_object_mut(), serde_json::to_value(scores)?)
    {
        into.extend(scores);
        into.insert("description".into(), serde_json::to_value(camera.description())?);
    }
    Ok(entry)
}

fn scores_table(results: &[(&Camera, Evaluation)]) -> String {
    let header: Vec<&str> =
        ["camera", "cd/m²"].into_iter().chain(headings(&columns::EVALUATE)).chain(["exposure ms"]).collect();
    let row = |(camera, s): &(&Camera, Evaluation)| {
        vec![
            camera.description().name.clone(),
            format!("{}", s.luminance_cd_m2),
            format!("{:.2}", s.delta_e_76.mean),
            format!("{:.2}", s.delta_e_2000.mean),
            format!("{:.1}", s.mtf50_cy_per_mm),
            format!("{:.3}", s.mtf50_cy_per_px),
            format!("{:.2}", s.luminance_noise_percent.mean),
            format!("{:.1}", s.aliasing_percent),
            format!("{:.1}", s.saturated_percent),
            format!("{:.1}", s.dynamic_range_db),
            format!("{:.1}", s.exposure.macbeth_s * 1e3),
        ]
    };
    table::render(&header, &results.iter().map(row).collect::<Vec<_>>())
}

fn write_pictures(dir: &Path, pictures: &EvaluationPictures) -> anyhow::Result<()> {
    write::begin_folder(dir, &[])?;
    for (name, image) in
        [("macbeth", &pictures.macbeth), ("edge", &pictures.edge), ("zone-plate", &pictures.zone_plate)]
    {
        let shown = image.converted(ColorSpace::Srgb)?;
        picture::write_png(&dir.join(format!("{name}.png")), &shown, Depth::Eight)?;
    }
    picture::write_png(&dir.join("aliasing.png"), &aliasing_picture(pictures)?, Depth::Eight)?;
    Ok(())
}

/// What of the zone plate's picture is not in the zone plate. A difference has two signs: grey is none.
fn aliasing_picture(pictures: &EvaluationPictures) -> anyhow::Result<Image> {
    let planes = &pictures.aliasing;
    let largest = planes.data().iter().fold(0.0f32, |m, v| m.max(v.abs())).max(f32::MIN_POSITIVE);
    let data = planes.data().iter().map(|v| 0.5 + 0.5 * v / largest).collect();
    Ok(Image::new(ColorSpace::Srgb, Planes::new(planes.rows(), planes.cols(), 3, data)?)?)
}
