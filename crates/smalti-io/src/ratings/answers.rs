//! The answers of observers: for each a file of lines, JSON each, that are on the disk before the next pair is shown.
//!
//! The first line describes the observer; then a line states each pair that is shown, and a line each answer. A line that a crash cut
//! short is removed when the file is opened again. No line contains what would identify a person.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use serde::{Deserialize, Serialize};
use smalti::rating::{Side, Trial};

use super::manifest::Manifest;
use crate::{IoError, file, write};

/// The folder of the answers.
pub const ANSWERS: &str = "answers";
/// The version of the lines.
const VERSION: u32 = 1;
/// The largest file of an observer, bytes.
const LIMIT: u64 = 64 << 20;
const LOCK: &str = ".lock";

/// What the page found out about the display.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Display {
    /// Device pixels per CSS pixel.
    pub device_pixel_ratio: f64,
    /// Width and height of the screen, CSS pixels.
    pub screen_px: [u32; 2],
    /// CSS pixels per millimetre, by the width of a bank card; absent unless the observer made the comparison.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub px_per_mm: Option<f64>,
    /// The gamma of the display, by the grey that matches a pattern of black and white lines; absent unless the observer made the match.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gamma: Option<f64>,
}

impl Display {
    /// Whether all values are those of a display.
    #[must_use]
    pub fn is_plausible(&self) -> bool {
        let within = |v: Option<f64>, low: f64, high: f64| v.is_none_or(|v| (low..=high).contains(&v));
        within(Some(self.device_pixel_ratio), 0.1, 16.0)
            && self.screen_px.iter().all(|n| (1..=100_000).contains(n))
            && within(self.px_per_mm, 0.2, 100.0)
            && within(self.gamma, 0.5, 6.0)
    }
}

/// A line of the file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
enum Line {
    /// The observer.
    Observer {
        version: u32,
        smalti_version: String,
        /// [`Manifest::id`].
        experiment: String,
        number: u32,
        /// The BLAKE3 hash of the secret that the observer's browser keeps.
        secret_blake3: String,
        /// Whether the observer agreed to take part.
        consent: bool,
        display: Display,
        /// Seconds since 1970.
        unix_s: u64,
    },
    /// A pair that is shown.
    Shown { number: usize, trial: Trial, unix_s: u64 },
    /// An answer.
    Answer { number: usize, choice: Side, response_ms: u64, unix_s: u64 },
}

impl Line {
    /// The line with its end.
    fn text(&self, path: &Path) -> Result<Vec<u8>, IoError> {
        let mut text = serde_json::to_vec(self).map_err(|e| IoError::decode(path, "JSON", e))?;
        text.push(b'\n');
        Ok(text)
    }
}

/// The hash of the secret of an observer.
#[must_use]
pub fn secret_hash(secret: &str) -> String {
    blake3::hash(secret.as_bytes()).to_hex().to_string()
}

fn unix_s() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs())
}

/// A pair that was shown, and the answer if there is one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Answered {
    /// The pair.
    pub trial: Trial,
    /// The preferred side and the time to the answer, ms.
    pub answer: Option<(Side, u64)>,
}

/// An observer as the file describes it.
#[derive(Debug, Clone, PartialEq)]
pub struct Observer {
    /// The number, from 1.
    pub number: u32,
    /// The display.
    pub display: Display,
    /// The trials in their order. Only the last may have no answer.
    pub trials: Vec<Answered>,
    /// The hash of the secret.
    pub secret_blake3: String,
}

/// The folder of answers, locked for one server.
#[derive(Debug)]
pub struct AnswerFolder {
    dir: PathBuf,
    lock: File,
}

impl Drop for AnswerFolder {
    fn drop(&mut self) {
        // Closing the file would not do it at once while a program that is being started still has it.
        let _ = self.lock.unlock();
    }
}

impl AnswerFolder {
    /// Locks the answers of an experiment and makes their folder where it is absent.
    ///
    /// # Errors
    /// When another server has the lock, or the folder cannot be written.
    pub fn open(experiment: &Path) -> Result<Self, IoError> {
        let dir = experiment.join(ANSWERS);
        write::begin_folder(&dir, &[])?;
        let path = dir.join(LOCK);
        let io = IoError::writing(&path);
        let lock =
            File::options().read(true).write(true).create(true).truncate(false).open(&path).map_err(io)?;
        match lock.try_lock() {
            Ok(()) => Ok(Self { dir, lock }),
            Err(TryLockError::WouldBlock) => {
                let busy = "another server of this experiment is running; expected one at a time";
                Err(io(io::Error::new(io::ErrorKind::WouldBlock, busy)))
            }
            Err(TryLockError::Error(source)) => Err(io(source)),
        }
    }

    /// All observers with their files, opened for further answers.
    ///
    /// # Errors
    /// When a file is damaged or is of another experiment.
    pub fn resume(&self, manifest: &Manifest) -> Result<Vec<(Observer, AnswerFile)>, IoError> {
        let open = |path: &PathBuf| {
            let (observer, length) = parse(path, manifest)?;
            let io = IoError::writing(path);
            let file = OpenOptions::new().write(true).open(path).map_err(io)?;
            file.set_len(length).map_err(io)?;
            Ok((observer, AnswerFile::open(path.clone())?))
        };
        paths(&self.dir)?.iter().map(open).collect()
    }

    /// Begins the file of an observer. Consent was given. The file has its name only once its first line is on the disk, so that a full
    /// disk or a crash leaves no file without an observer.
    ///
    /// # Errors
    /// When the file exists or cannot be written.
    pub fn begin(
        &self,
        manifest: &Manifest,
        number: u32,
        secret_blake3: &str,
        display: &Display,
    ) -> Result<(Observer, AnswerFile), IoError> {
        let path = self.dir.join(format!("observer-{number:04}.jsonl"));
        let io = IoError::writing(&path);
        if path.exists() {
            return Err(io(io::ErrorKind::AlreadyExists.into()));
        }
        let first = Line::Observer {
            version: VERSION,
            smalti_version: env!("CARGO_PKG_VERSION").into(),
            experiment: manifest.id.clone(),
            number,
            secret_blake3: secret_blake3.into(),
            consent: true,
            display: display.clone(),
            unix_s: unix_s(),
        };
        write::durable(&path, &first.text(&path)?)?;
        // The name of a new file is durable once its folder is.
        write::sync_folder(&self.dir);
        let own = AnswerFile::open(path)?;
        let (display, secret_blake3) = (display.clone(), secret_blake3.to_owned());
        Ok((Observer { number, display, trials: Vec::new(), secret_blake3 }, own))
    }
}

/// The file of an observer.
#[derive(Debug)]
pub struct AnswerFile {
    file: File,
    path: PathBuf,
}

impl AnswerFile {
    /// Opens the file of an observer for further lines.
    fn open(path: PathBuf) -> Result<Self, IoError> {
        let io = IoError::writing(&path);
        let mut file = OpenOptions::new().write(true).open(&path).map_err(io)?;
        file.seek(SeekFrom::End(0)).map_err(io)?;
        Ok(Self { file, path })
    }

    fn append(&mut self, line: &Line) -> Result<(), IoError> {
        let io = IoError::writing(&self.path);
        let text = line.text(&self.path)?;
        let before = self.file.stream_position().map_err(io)?;
        let written = self.file.write_all(&text).and_then(|()| self.file.sync_data());
        written.map_err(|e| {
            // Half a line would make the next one unreadable.
            let _ = self.file.set_len(before).and_then(|()| self.file.seek(SeekFrom::Start(before)));
            io(e)
        })
    }

    /// Adds the pair with this number that is shown now, to the observer as well.
    ///
    /// # Errors
    /// When the line cannot be written; the observer then is as before.
    pub fn show(&mut self, observer: &mut Observer, trial: Trial) -> Result<(), IoError> {
        self.append(&Line::Shown { number: observer.trials.len(), trial, unix_s: unix_s() })?;
        observer.trials.push(Answered { trial, answer: None });
        Ok(())
    }

    /// Adds the answer to the last pair, to the observer as well.
    ///
    /// # Errors
    /// When the line cannot be written; the observer then is as before.
    pub fn answer(&mut self, observer: &mut Observer, choice: Side, response_ms: u64) -> Result<(), IoError> {
        let number = observer.trials.len().saturating_sub(1);
        self.append(&Line::Answer { number, choice, response_ms, unix_s: unix_s() })?;
        if let Some(last) = observer.trials.last_mut() {
            last.answer = Some((choice, response_ms));
        }
        Ok(())
    }
}

/// The files of observers in their order.
fn paths(dir: &Path) -> Result<Vec<PathBuf>, IoError> {
    let entries = match fs::read_dir(dir) {
        Ok(entries) => entries,
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(e) => return Err(IoError::reading(dir)(e)),
    };
    let mut paths = Vec::new();
    for entry in entries {
        let path = entry.map_err(IoError::reading(dir))?.path();
        if path.extension().is_some_and(|e| e == "jsonl") {
            paths.push(path);
        }
    }
    paths.sort();
    Ok(paths)
}

/// Reads the answers of all observers.
///
/// # Errors
/// When a file is damaged or is of another experiment.
pub fn read_observers(experiment: &Path, manifest: &Manifest) -> Result<Vec<Observer>, IoError> {
    let paths = paths(&experiment.join(ANSWERS))?;
    paths.iter().map(|path| Ok(parse(path, manifest)?.0)).collect()
}

/// An observer, and the length of the file without a line that was cut short.
fn parse(path: &Path, manifest: &Manifest) -> Result<(Observer, u64), IoError> {
    observer_from_bytes(&file::read(path, LIMIT)?, path, manifest)
}

/// An observer from the bytes of a file, and their number without a line that was cut short; `path` is only named in errors.
///
/// # Errors
/// When the bytes are no answers, or those of another experiment.
pub fn observer_from_bytes(
    bytes: &[u8],
    path: &Path,
    manifest: &Manifest,
) -> Result<(Observer, u64), IoError> {
    let length = bytes.iter().rposition(|b| *b == b'\n').map_or(0, |at| at + 1);
    let mut observer: Option<Observer> = None;
    for (i, text) in bytes[..length].split(|b| *b == b'\n').enumerate().filter(|(_, t)| !t.is_empty()) {
        let wrong = |found: String, expected: &str| IoError::line(path, i + 1, found, expected);
        let line: Line =
            serde_json::from_slice(text).map_err(|e| wrong(e.to_string(), "a line of answers"))?;
        match (line, &mut observer) {
            (Line::Observer { version, experiment, number, secret_blake3, display, .. }, None) => {
                if version != VERSION {
                    let (found, expected) = (version.to_string(), VERSION.to_string());
                    return Err(IoError::Version {
                        path: path.to_owned(),
                        format: "answers",
                        found,
                        expected,
                    });
                }
                if experiment != manifest.id {
                    return Err(wrong(format!("experiment {experiment}"), "answers to this experiment"));
                }
                observer = Some(Observer { number, display, trials: Vec::new(), secret_blake3 });
            }
            (Line::Shown { number, trial, .. }, Some(observer)) => {
                let is_answered = observer.trials.last().is_none_or(|t| t.answer.is_some());
                let is_known = trial.scene < manifest.scenes.len()
                    && trial.pair().is_none_or(|(_, b)| b < manifest.conditions.len());
                if number != observer.trials.len() || !is_answered || !is_known {
                    let expected =
                        format!("pair {} after the answer to the one before", observer.trials.len());
                    return Err(wrong(format!("pair {number}, scene {}", trial.scene), &expected));
                }
                observer.trials.push(Answered { trial, answer: None });
            }
            (Line::Answer { number, choice, response_ms, .. }, Some(observer)) => {
                let last = observer.trials.len().checked_sub(1);
                let open = observer.trials.last_mut().filter(|t| t.answer.is_none() && Some(number) == last);
                let Some(open) = open else {
                    return Err(wrong(format!("an answer to pair {number}"), "an answer to the last pair"));
                };
                open.answer = Some((choice, response_ms));
            }
            (Line::Observer { .. }, Some(_)) => {
                return Err(wrong("a second observer".into(), "one observer in a file"));
            }
            (_, None) => return Err(wrong("an answer".into(), "the observer on the first line")),
        }
    }
    let observer =
        observer.ok_or_else(|| IoError::truncated(path, "the line of the observer", 1, length as u64))?;
    Ok((observer, length as u64))
}

/// Writes all answers as a table: observer, number, role, scene, the pictures on both sides, the preferred side, the time.
///
/// # Errors
/// When the file cannot be written.
pub fn write_table(path: &Path, manifest: &Manifest, observers: &[Observer]) -> Result<(), IoError> {
    use smalti::rating::Shown;
    let quoted = |text: &str| format!("\"{}\"", text.replace('"', "\"\""));
    let shown = |shown: Shown| match shown {
        Shown::Condition(c) => quoted(manifest.conditions.get(c).map_or("", |c| c.name.as_str())),
        Shown::Reference => "reference".into(),
        Shown::Coarse => "coarse".into(),
    };
    let word = |value: &serde_json::Value| value.as_str().unwrap_or_default().to_owned();
    let mut text = String::from("observer,number,role,scene,left,right,preferred,response_ms\n");
    for observer in observers {
        for (number, Answered { trial, answer }) in observer.trials.iter().enumerate() {
            let Some((choice, response_ms)) = answer else { continue };
            let role = word(&serde_json::to_value(trial.role).unwrap_or_default());
            let choice = word(&serde_json::to_value(choice).unwrap_or_default());
            let scene = quoted(manifest.scenes.get(trial.scene).map_or("", |s| s.name.as_str()));
            let (left, right) = (shown(trial.left), shown(trial.right));
            text += &format!(
                "{},{},{role},{scene},{left},{right},{choice},{response_ms}\n",
                observer.number,
                number + 1
            );
        }
    }
    write::bytes(path, text.as_bytes())
}
