//! `smalti studio`: the page on which a mosaic and its filters are drawn and their picture is seen.

use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::{Context, bail};
use clap::Args;
use serde::Deserialize;
use serde_json::{Value, json};
use smalti::camera::Camera;
use smalti::camera::description::{
    CameraDescription, CfaDescription, ExposureDescription, IspDescription, SensorDescription,
};
use smalti::design::live::LiveFamily;
use smalti::experiment::Silent;
use smalti_io::cache::Cache;
use smalti_io::cameras::LoadedCamera;
use smalti_io::dataset::Dataset;
use smalti_io::studio::{Extent, StudioAsset};
use smalti_io::sweeps::{read_results, read_trials};
use smalti_io::{TomlSource, cameras, designs, studies, text, write};
use smalti_report::study::{Report, ReportSettings, Results, camera_toml};
use smalti_serve::studio::{LateFiles, Native, Opening};
use smalti_serve::{LocalServer, OpeningFile, studio};

use crate::args::Common;
use crate::output::note;
use crate::progress::Progress;
use crate::resolve;
use crate::show::find::{Kind, kind};

/// When the rest of the light is gathered: after the first seconds on the page, which needs the processor then.
const LATER: Duration = Duration::from_secs(15);
/// How long a browser has to read the file that leads it to the page.
const OPENED: Duration = Duration::from_secs(60);
/// The camera in the folder of `smalti design`.
const DESIGNED: &str = "camera.toml";
/// What marks the folder of `smalti sweep`.
const SWEPT: &str = "manifest.json";
/// The results of `smalti compare` and of `smalti design`.
const RESULTS: &str = "results.json";

#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:\n  \
    smalti studio                            start with the camera bayer\n  \
    smalti studio phone@quad-bayer           start with another camera and mosaic\n  \
    smalti studio best                       start with what `smalti design -o best` found\n  \
    smalti studio table2                     start with the first design of a study\n  \
    smalti studio study                      start with the best design that `smalti sweep -o study` found\n  \
    smalti studio out                        start with the cameras of `smalti compare -o out`, the second one pinned\n  \
    smalti studio rgbw --export site         write the page as a folder for a web server\n\n\
    The page simulates the camera in the browser and learns a pipeline for every design. The address has a token and answers to browsers of \
    this machine alone; Ctrl-C ends the server. The folder of --export needs neither this server nor the command, but a web server: any can serve it.")]
pub(crate) struct Studio {
    /// Camera, study or folder of `smalti design`, `sweep` or `compare` with whose design the page opens
    #[arg(default_value = "bayer", value_name = "CAMERA|STUDY|DIR")]
    pub(crate) start: String,
    /// Port on 127.0.0.1 [default: a free one]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) port: Option<u16>,
    /// Print the address without opening a browser
    #[arg(long)]
    pub(crate) no_open: bool,
    /// Print the address as JSON without opening a browser
    #[arg(long)]
    pub(crate) json: bool,
    /// Do not use the cache of the light ($SMALTI_CACHE_DIR, else the user's cache folder)
    #[arg(long)]
    pub(crate) no_cache: bool,
    /// Write the page to a new or empty folder, in place of serving it
    #[arg(long, value_name = "DIR", conflicts_with_all = ["port", "no_open", "json"])]
    pub(crate) export: Option<PathBuf>,
}

pub(crate) fn run(args: &Studio, common: &Common) -> anyhow::Result<()> {
    let Start { camera, pinned, family } = start(&args.start, common)?;
    let text = |camera: &Camera| designs::own_camera_toml(camera.description()).map_err(anyhow::Error::from);
    let opening = Opening { camera: text(&camera)?, pinned: pinned.as_ref().map(text).transpose()?, family };
    let cache = resolve::cache(args.no_cache)?;
    if let Some(dir) = &args.export {
        write::ensure_is_new(dir)?;
        write::ensure_can_fill(dir)?;
        let light = with_sources(all_light(&bare(&camera)?, &cache, common)?);
        let files = studio::files(&opening, light, false);
        write::folder(dir, files.iter().map(|file| (file.path.as_str(), file.content.as_ref())))?;
        let serve = format!(
            "the page needs a web server, for example `python3 -m http.server --directory {}`; a browser does not run it from a file",
            dir.display()
        );
        note(&serve, common);
        return crate::print(&format!("{}\n", dir.join("index.html").display()));
    }
    let server = LocalServer::bind(args.port, None)?;
    let (bare, late) = (bare(&camera)?, LateFiles::default());
    let kept = cache.studio_assets(&key(&bare)?);
    let manifest = kept.is_none().then(|| smalti_io::studio::manifest(&bare, Extent::First));
    let files = studio::files(&opening, with_sources(manifest), true);
    let routes = studio::routes(files, late.clone(), Native::new(cache.clone()));
    let address = server.url();
    if args.json {
        crate::output::print_document(&format!("{}\n", json!({"address": address})))?;
    } else {
        crate::print(&format!("{address}\n"))?;
        if !args.no_open && open_page(&address).is_err() {
            note("no browser could be started; open this address in one", common);
        }
        note("Ctrl-C ends the server", common);
    }
    match kept {
        Some(light) => late.set(Ok(light)),
        None => {
            let (common, keeps) = (common.clone(), !args.no_cache);
            std::thread::spawn(move || {
                // The page loads meanwhile.
                let light = gathered(&common, |progress| {
                    Ok(smalti_io::studio::light_files(&bare, Extent::First, progress)?)
                });
                if let Err(error) = &light {
                    crate::output::error(error.as_ref(), "");
                }
                late.set(light.map_err(|error| format!("{error:#}")));
                if keeps {
                    std::thread::sleep(LATER);
                    keep_all(&bare, &cache);
                }
            });
        }
    }
    Ok(server.run(routes)?)
}

/// Opens the page in a browser through a file that leads to it: the command line of a browser, which other accounts can read, must not have the token.
fn open_page(address: &str) -> anyhow::Result<()> {
    let file = OpeningFile::new(address)?;
    open::that_detached(file.path())?;
    std::thread::spawn(move || {
        std::thread::sleep(OPENED);
        drop(file);
    });
    Ok(())
}

/// The files of the light with those from which the page gathers it for other lenses.
fn with_sources(light: impl IntoIterator<Item = StudioAsset>) -> Vec<StudioAsset> {
    light.into_iter().chain(smalti_io::studio::sources()).collect()
}

/// The camera without what the light of the scenes does not depend on, so that cameras share it, and without crosstalk, which the page does not
/// simulate and for which statistics need a larger patch.
fn bare(camera: &Camera) -> anyhow::Result<Camera> {
    let own = camera.description();
    let bare = CameraDescription {
        name: format!("f/{}, {} µm", own.optics.f_number, own.sensor.pixel.pitch_um),
        sensor: SensorDescription {
            cfa: CfaDescription::default(),
            binning: None,
            crosstalk_percent: 0.0,
            ..own.sensor.clone()
        },
        exposure: ExposureDescription::default(),
        isp: IspDescription::default(),
        ..own.clone()
    };
    Ok(Camera::new(bare, camera.grid())?)
}

/// The key of the light of a bare camera in the cache.
fn key(bare: &Camera) -> anyhow::Result<String> {
    Ok(serde_json::to_string(bare.description())?)
}

/// Gathers light with a progress bar.
fn gathered(
    common: &Common,
    gather: impl FnOnce(&Progress) -> anyhow::Result<Vec<StudioAsset>>,
) -> anyhow::Result<Vec<StudioAsset>> {
    let progress = Progress::new(0, common.quiet);
    let light = gather(&progress)?;
    progress.finish();
    Ok(light)
}

/// All of the light of a bare camera, from the cache or gathered.
fn all_light(bare: &Camera, cache: &Cache, common: &Common) -> anyhow::Result<Vec<StudioAsset>> {
    let key = key(bare)?;
    if let Some(light) = cache.studio_assets(&key) {
        return Ok(light);
    }
    let light = gathered(common, |progress| Ok(smalti_io::studio::assets(bare, progress)?))?;
    cache.keep_studio_assets(&key, &light);
    Ok(light)
}

/// Keeps all of the light for the next start, gathered by one thread beside the page. Without it, the next start is as this one.
fn keep_all(bare: &Camera, cache: &Cache) {
    let Ok(key) = key(bare) else { return };
    let Ok(pool) = rayon::ThreadPoolBuilder::new().num_threads(1).build() else { return };
    if let Some(light) = pool.install(|| smalti_io::studio::assets(bare, &Silent).ok()) {
        cache.keep_studio_assets(&key, &light);
    }
}

/// The camera with which the page opens, one that it is compared with, and the family of its filters, if it is known.
struct Start {
    camera: Camera,
    pinned: Option<Camera>,
    family: Option<LiveFamily>,
}

fn start(name: &str, common: &Common) -> anyhow::Result<Start> {
    let told = |loaded: LoadedCamera| {
        loaded.notes.iter().for_each(|text| note(text, common));
        loaded.camera
    };
    let camera =
        |name: &str| cameras::load_with_notes(name, &[], None).map(told).map_err(anyhow::Error::from);
    let alone = |camera: Camera| Start { camera, pinned: None, family: None };
    let folder = Path::new(name);
    if folder.is_dir() {
        let has = |file: &str| folder.join(file).is_file();
        if has(DESIGNED) {
            let path = folder.join(DESIGNED);
            let camera = camera(path.to_str().context("the path of the folder is not Unicode")?)?;
            return Ok(Start { family: family_of(&folder.join(RESULTS))?, ..alone(camera) });
        }
        if has(SWEPT) {
            return best_of(folder, common).map(alone);
        }
        if has(RESULTS) {
            return compared(&folder.join(RESULTS), common);
        }
        bail!(
            "{name}: the folder has no {DESIGNED}, {SWEPT} or {RESULTS}; expected one that `smalti design`, `sweep` or `compare` wrote"
        );
    }
    match kind(name, None)?.0 {
        Kind::Camera => camera(name).map(alone),
        Kind::Study => {
            let study = studies::load_with_notes(name).map_err(anyhow::Error::from)?;
            study.notes.iter().for_each(|text| note(text, common));
            of_text(name, camera_toml(&study.trials, 0)?).map(alone)
        }
        other => bail!(
            "{name} is {}; expected a camera, a study or a folder that `smalti design`, `sweep` or `compare` wrote. A mosaic is opened with a camera, such as bayer@quad-bayer",
            other.with_article()
        ),
    }
}

/// A camera file that is a text.
fn of_text(name: &str, text: String) -> anyhow::Result<Camera> {
    let source = TomlSource { name: name.to_owned(), folder: PathBuf::new(), text };
    cameras::from_source(&source, &[], None).map_err(anyhow::Error::from)
}

/// The best design of a sweep: that in the first row of the tables of `smalti report`.
fn best_of(folder: &Path, common: &Common) -> anyhow::Result<Camera> {
    let studies = [Results::new(read_results(folder)?)?];
    let settings = ReportSettings::default();
    let best = Report::new(&studies, &settings)?.first_best()?;
    let about = folder.display();
    let number = best.with_context(|| format!("{about}: no trial is scored; expected complete results"))?;
    note(&format!("{about}: trial {number}, the best of the fewest colours (`smalti report`)"), common);
    of_text(&about.to_string(), camera_toml(&read_trials(&Dataset::open(folder)?)?, number)?)
}

/// The family of the filters of a search, as its results state it. `None` without results, as where only the camera file was kept, and for families that the
/// page does not have.
fn family_of(path: &Path) -> anyhow::Result<Option<LiveFamily>> {
    #[derive(Deserialize)]
    struct Document {
        #[serde(default)]
        family: serde_json::Map<String, Value>,
    }
    if !path.is_file() {
        return Ok(None);
    }
    let about = path.display();
    let read: Result<Document, _> = serde_json::from_str(&text::read_to_string(path)?);
    let document = read.map_err(|error| {
        anyhow::anyhow!("{about}: no results of a search ({error}); expected those of `smalti design`")
    })?;
    let name = document.family.keys().next().cloned();
    Ok(name.and_then(|name| serde_json::from_value(Value::String(name)).ok()))
}

/// The cameras of a comparison.
fn compared(path: &Path, common: &Common) -> anyhow::Result<Start> {
    #[derive(Deserialize)]
    struct Document {
        cameras: Vec<CameraDescription>,
    }
    let about = path.display();
    let read: Result<Document, _> = serde_json::from_str(&text::read_to_string(path)?);
    let document = read.map_err(|error| {
        anyhow::anyhow!(
            "{about}: no cameras of a comparison ({error}); expected the results of `smalti compare`"
        )
    })?;
    let camera = |own: &CameraDescription| Ok::<_, anyhow::Error>(Camera::new(own.clone(), own.grid()?)?);
    if document.cameras.len() > 2 {
        let more = document.cameras.len() - 2;
        note(
            &format!("{about}: the first two cameras are shown; {more} more can be opened on the page"),
            common,
        );
    }
    let first = document.cameras.first().with_context(|| format!("{about}: it has no camera"))?;
    let pinned = document.cameras.get(1).map(camera).transpose()?;
    Ok(Start { camera: camera(first)?, pinned, family: None })
}
