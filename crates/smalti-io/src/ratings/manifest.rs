//! The manifest of an experiment.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Component, Path};

use serde::{Deserialize, Serialize};
use smalti::color::Image;
use smalti::experiment::RatedScene;
use smalti::rating::{Question, Schedule};

use crate::picture::{Depth, write_png};
use crate::{IoError, file, write as files};

/// The file of the manifest. It is removed first and written last, so that a folder that contains it is complete.
pub const MANIFEST: &str = "experiment.json";
/// The folder of the pictures.
pub const PICTURES: &str = "pictures";
/// What the manifest says it is.
const FORMAT: &str = "smalti rating experiment";
const VERSION: u32 = 1;
/// The largest manifest and the largest picture, bytes.
const MANIFEST_LIMIT: u64 = 16 << 20;
const PICTURE_LIMIT: u64 = 64 << 20;
/// The most trials of each role.
const MOST_TRIALS: usize = 10_000;

/// An experiment.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// The format.
    format: String,
    /// Its version.
    version: u32,
    /// The version of the program that made it.
    pub smalti_version: String,
    /// The hash of everything else, which answers refer to.
    pub id: String,
    /// The title, which observers do not see.
    pub title: String,
    /// The command that made it, without the name of the program.
    pub command: Vec<String>,
    /// What is asked.
    pub question: Question,
    /// The trials of each observer.
    pub schedule: Schedule,
    /// The seed of the order, of the sides and of the noise.
    pub seed: u64,
    /// The conditions.
    pub conditions: Vec<Condition>,
    /// The scenes.
    pub scenes: Vec<SceneFiles>,
}

/// A camera with its processing in an amount of light.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Condition {
    /// Its unique name.
    pub name: String,
    /// The label of the camera.
    pub camera: String,
    /// The processing.
    pub processing: String,
    /// Mean luminance of the scene, cd/m², with which the exposure time was chosen.
    pub luminance_cd_m2: f64,
    /// Light beyond it, stops.
    pub stops: f64,
}

/// The pictures of a scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneFiles {
    /// The name of the scene.
    pub name: String,
    /// Rows of all its pictures.
    pub rows: usize,
    /// Columns of all its pictures.
    pub cols: usize,
    /// The reference.
    pub reference: PictureFile,
    /// The picture that is plainly worse.
    pub coarse: PictureFile,
    /// The picture of each condition.
    pub pictures: Vec<PictureFile>,
}

/// A picture in sRGB.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PictureFile {
    /// Its file, relative to the folder of the experiment.
    pub file: String,
    /// The BLAKE3 hash of the file.
    pub blake3: String,
    /// The factor from the scale of the picture to that of the display; absent for references.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gain: Option<f64>,
    /// Exposure time, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub exposure_time_s: Option<f64>,
    /// The metrics, by their names in the catalogue.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub metrics: BTreeMap<String, f64>,
}

impl Manifest {
    /// The hash of everything but the hash.
    fn hash(&self) -> String {
        let without = Self { id: String::new(), ..self.clone() };
        let text = serde_json::to_vec(&without).unwrap_or_default();
        blake3::hash(&text).to_hex().to_string()
    }

    fn files(&self) -> impl Iterator<Item = &PictureFile> {
        self.scenes.iter().flat_map(|s| [&s.reference, &s.coarse].into_iter().chain(&s.pictures))
    }

    /// Checks what reading does not.
    fn check(&self, path: &Path) -> Result<(), IoError> {
        let wrong =
            |field: String, found: String, expected: &str| Err(IoError::field(path, field, found, expected));
        if self.format != FORMAT {
            return Err(IoError::unknown(path, "an experiment that smalti rate init has made"));
        }
        if self.version != VERSION {
            return Err(IoError::Version {
                path: path.to_owned(),
                format: "experiment",
                found: self.version.to_string(),
                expected: VERSION.to_string(),
            });
        }
        let names: BTreeSet<&str> = self.conditions.iter().map(|c| c.name.as_str()).collect();
        if self.conditions.len() < 2 || names.len() < self.conditions.len() {
            let found = format!("{} with {} names", self.conditions.len(), names.len());
            return wrong("conditions".into(), found, "at least two, of different names");
        }
        if let Question::Light { standard } = self.question
            && standard >= self.conditions.len()
        {
            return wrong(
                "question.standard".into(),
                standard.to_string(),
                "the number of a condition, from 0",
            );
        }
        if self.scenes.is_empty() {
            return wrong("scenes".into(), "empty".into(), "at least one");
        }
        for (i, scene) in self.scenes.iter().enumerate() {
            if scene.pictures.len() != self.conditions.len() {
                let found = format!("{} pictures", scene.pictures.len());
                return wrong(format!("scenes[{i}].pictures"), found, "one for each condition");
            }
            if !(1..=1 << 14).contains(&scene.rows) || !(1..=1 << 14).contains(&scene.cols) {
                let found = format!("{} × {}", scene.rows, scene.cols);
                return wrong(format!("scenes[{i}].rows × cols"), found, "1 to 16384 each");
            }
        }
        for picture in self.files() {
            let parts: Vec<Component<'_>> = Path::new(&picture.file).components().collect();
            let is_own =
                matches!(parts[..], [Component::Normal(dir), Component::Normal(_)] if dir == PICTURES);
            if !is_own || !picture.file.ends_with(".png") {
                return wrong("file".into(), picture.file.clone(), "a PNG file in the folder pictures");
            }
        }
        let Schedule { ratings, repeats, traps, training, break_every } = self.schedule;
        let counts = [ratings, repeats, traps, training];
        if ratings == 0 || break_every == 0 || counts.iter().any(|n| *n > MOST_TRIALS) {
            return wrong(
                "schedule".into(),
                format!("{:?}", self.schedule),
                "at least one rating, and at most 10000 trials of each role",
            );
        }
        if self.id != self.hash() {
            let (found, stated) = (self.hash(), self.id.clone());
            return Err(IoError::Damaged { path: path.to_owned(), found, stated });
        }
        Ok(())
    }
}

/// Reads the manifest of a folder and checks it. With `pictures`, the pictures are read as well and compared with their hashes.
///
/// # Errors
/// When a file cannot be read or is not what the manifest states.
pub fn read(dir: &Path, pictures: bool) -> Result<Manifest, IoError> {
    let path = dir.join(MANIFEST);
    let manifest = from_bytes(&file::read(&path, MANIFEST_LIMIT)?, &path)?;
    for picture in manifest.files().filter(|_| pictures) {
        picture.read(dir)?;
    }
    Ok(manifest)
}

/// As [`read`] without pictures, from memory; `path` is only named in errors.
///
/// # Errors
/// When the bytes are no manifest.
pub fn from_bytes(bytes: &[u8], path: &Path) -> Result<Manifest, IoError> {
    let value: serde_json::Value =
        serde_json::from_slice(bytes).map_err(|e| IoError::decode(path, "JSON", e))?;
    if value.get("format").and_then(|f| f.as_str()) != Some(FORMAT) {
        return Err(IoError::unknown(path, "an experiment that smalti rate init has made"));
    }
    let version = value.get("version").cloned().unwrap_or_default();
    if version != VERSION {
        let (found, expected) = (version.to_string(), VERSION.to_string());
        return Err(IoError::Version { path: path.to_owned(), format: "experiment", found, expected });
    }
    let manifest: Manifest =
        serde_json::from_value(value).map_err(|e| IoError::decode(path, "experiment", e))?;
    manifest.check(path)?;
    Ok(manifest)
}

impl PictureFile {
    /// The bytes of the file in the folder of the experiment.
    ///
    /// # Errors
    /// When the file cannot be read or is not that of the manifest.
    pub fn read(&self, dir: &Path) -> Result<Vec<u8>, IoError> {
        let path = dir.join(&self.file);
        let bytes = file::read(&path, PICTURE_LIMIT)?;
        let found = blake3::hash(&bytes).to_hex().to_string();
        if found != self.blake3 {
            return Err(IoError::Damaged { path, found, stated: self.blake3.clone() });
        }
        Ok(bytes)
    }
}

/// An experiment before its pictures are written.
#[derive(Debug, Clone)]
pub struct Planned {
    /// The title.
    pub title: String,
    /// The command.
    pub command: Vec<String>,
    /// What is asked.
    pub question: Question,
    /// The trials of each observer.
    pub schedule: Schedule,
    /// The seed.
    pub seed: u64,
    /// The conditions.
    pub conditions: Vec<Condition>,
}

/// Writes the pictures and the manifest of an experiment.
///
/// # Errors
/// When a file cannot be written, or the experiment is one that [`read`] would refuse.
pub fn write(dir: &Path, planned: &Planned, scenes: &[RatedScene]) -> Result<Manifest, IoError> {
    files::begin_folder(dir, &[MANIFEST])?;
    files::begin_folder(&dir.join(PICTURES), &[])?;
    let picture = |name: String, image: &Image| -> Result<PictureFile, IoError> {
        let file = format!("{PICTURES}/{name}.png");
        let path = dir.join(&file);
        write_png(&path, image, Depth::Eight)?;
        let blake3 = blake3::hash(&file::read(&path, PICTURE_LIMIT)?).to_hex().to_string();
        Ok(PictureFile { file, blake3, gain: None, exposure_time_s: None, metrics: BTreeMap::new() })
    };
    let scene = |(i, scene): (usize, &RatedScene)| -> Result<SceneFiles, IoError> {
        let rated = |(c, rated): (usize, &smalti::experiment::RatedPicture)| {
            Ok(PictureFile {
                gain: Some(rated.gain),
                exposure_time_s: Some(rated.exposure_time_s),
                metrics: rated.metrics.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect(),
                ..picture(format!("scene-{}-condition-{}", i + 1, c + 1), &rated.image)?
            })
        };
        Ok(SceneFiles {
            name: scene.name.clone(),
            rows: scene.reference.rows(),
            cols: scene.reference.cols(),
            reference: picture(format!("scene-{}-reference", i + 1), &scene.reference)?,
            coarse: picture(format!("scene-{}-coarse", i + 1), &scene.trap)?,
            pictures: scene.pictures.iter().enumerate().map(rated).collect::<Result<_, IoError>>()?,
        })
    };
    let scenes = scenes.iter().enumerate().map(scene).collect::<Result<Vec<_>, _>>()?;
    let Planned { title, command, question, schedule, seed, conditions } = planned.clone();
    let mut manifest = Manifest {
        format: FORMAT.into(),
        version: VERSION,
        smalti_version: env!("CARGO_PKG_VERSION").into(),
        id: String::new(),
        title,
        command,
        question,
        schedule,
        seed,
        conditions,
        scenes,
    };
    manifest.id = manifest.hash();
    let path = dir.join(MANIFEST);
    manifest.check(&path)?;
    let text = serde_json::to_string_pretty(&manifest).map_err(|e| IoError::decode(&path, "JSON", e))?;
    files::durable(&path, (text + "\n").as_bytes())?;
    Ok(manifest)
}
