//! The state of an experiment: its observers and the answers so far.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use smalti::rating::{Counts, Role, Shown, Side, Trial};
use smalti_io::ratings::{
    self, ANSWERS, AnswerFile, AnswerFolder, Display, Manifest, Observer, PictureFile, secret_hash,
};
use smalti_io::{IoError, write};

use crate::ServeError;
use crate::address::{Address, is_token};

/// The file of the address, which a later server uses again.
const ADDRESS: &str = ".address.json";
/// The most observers of an experiment.
const MOST_OBSERVERS: usize = 9999;
/// The longest time of an answer that is recorded as it is, ms: a day.
const LONGEST_MS: u64 = 86_400_000;

/// An experiment that is run.
#[derive(Debug)]
pub struct Experiment {
    dir: PathBuf,
    manifest: Manifest,
    folder: AnswerFolder,
    sessions: Vec<Session>,
    /// The answers of all observers on each scene.
    answers: Vec<Counts>,
}

#[derive(Debug)]
struct Session {
    observer: Observer,
    file: AnswerFile,
}

/// What the page shows at the start.
#[derive(Debug, Serialize)]
pub(super) struct About {
    experiment: String,
    pairs: usize,
    training: usize,
    break_every: usize,
    rows: usize,
    cols: usize,
}

/// Who an observer is.
#[derive(Debug, Serialize)]
pub(super) struct Joined {
    number: u32,
}

/// A request to take part.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Join {
    consent: bool,
    /// What later requests of the observer send: 32 random hexadecimal digits.
    secret: String,
    display: Display,
}

/// An answer to a pair.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Answer {
    number: usize,
    choice: Side,
    response_ms: u64,
}

/// The pair to judge.
#[derive(Debug, Serialize)]
pub(super) struct Pair {
    /// The number of the observer.
    observer: u32,
    /// Its number, from 0; that of all pairs at the end.
    number: usize,
    pairs: usize,
    training: usize,
    /// Whether all pairs are judged.
    done: bool,
    rows: usize,
    cols: usize,
}

/// Why a request is refused.
#[derive(Debug)]
pub(super) enum Refused {
    /// The request is not what was expected.
    Invalid(&'static str),
    /// There is no such observer.
    Unknown,
    /// The pair is another one now.
    Other,
    /// There is no such picture.
    Absent,
    /// Too many observers.
    Full,
    /// The system failed.
    Failed(ServeError),
}

impl From<IoError> for Refused {
    fn from(error: IoError) -> Self {
        Self::Failed(error.into())
    }
}

impl Experiment {
    /// Opens an experiment with the answers so far and locks it. All pictures are compared with their hashes.
    ///
    /// # Errors
    /// When a file is damaged, or another server runs the experiment.
    pub fn open(dir: &Path) -> Result<Self, ServeError> {
        let manifest = ratings::read(dir, true)?;
        let folder = AnswerFolder::open(dir)?;
        let mut answers = vec![Counts::new(manifest.conditions.len()); manifest.scenes.len()];
        let mut sessions = Vec::new();
        for (observer, file) in folder.resume(&manifest)? {
            for answered in &observer.trials {
                if let Some((side, _)) = answered.answer {
                    count(&mut answers, &answered.trial, side);
                }
            }
            sessions.push(Session { observer, file });
        }
        Ok(Self { dir: dir.to_owned(), manifest, folder, sessions, answers })
    }

    /// The address of an earlier server of this experiment.
    #[must_use]
    pub fn kept_address(&self) -> Option<Address> {
        let text = std::fs::read(self.dir.join(ANSWERS).join(ADDRESS)).ok()?;
        serde_json::from_slice(&text).ok()
    }

    /// Keeps the address for later servers.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn keep_address(&self, address: &Address) -> Result<(), ServeError> {
        let text = serde_json::to_vec(address).map_err(|error| ServeError::Server(error.into()))?;
        Ok(write::secret(&self.dir.join(ANSWERS).join(ADDRESS), &text)?)
    }

    pub(super) fn about(&self) -> About {
        let largest = |of: fn(&ratings::SceneFiles) -> usize| self.manifest.scenes.iter().map(of).max();
        About {
            experiment: self.manifest.id.clone(),
            pairs: self.manifest.schedule.trials(),
            training: self.manifest.schedule.training,
            break_every: self.manifest.schedule.break_every,
            rows: largest(|s| s.rows).unwrap_or_default(),
            cols: largest(|s| s.cols).unwrap_or_default(),
        }
    }

    /// Adds an observer. A request that the page sends again, since it did not learn of the first one, adds no other observer.
    pub(super) fn join(&mut self, join: &Join) -> Result<Joined, Refused> {
        if !join.consent {
            return Err(Refused::Invalid("nobody takes part without consent"));
        }
        if !join.display.is_plausible() {
            return Err(Refused::Invalid("the display has values that no display has"));
        }
        if !is_token(&join.secret) {
            return Err(Refused::Invalid("the secret is not one of 32 hexadecimal digits"));
        }
        if let Ok(at) = self.find(&join.secret) {
            return Ok(Joined { number: self.sessions[at].observer.number });
        }
        let last = self.sessions.iter().map(|s| s.observer.number).max().unwrap_or_default();
        if last as usize >= MOST_OBSERVERS {
            return Err(Refused::Full);
        }
        let (number, hash) = (last + 1, secret_hash(&join.secret));
        let (observer, file) = self.folder.begin(&self.manifest, number, &hash, &join.display)?;
        self.sessions.push(Session { observer, file });
        Ok(Joined { number })
    }

    fn find(&self, secret: &str) -> Result<usize, Refused> {
        // The hashes of secrets tell nothing by the time that their comparison takes.
        let hash = secret_hash(secret);
        self.sessions.iter().position(|s| s.observer.secret_blake3 == hash).ok_or(Refused::Unknown)
    }

    /// The pair that an observer judges now. It is chosen and recorded when the one before is answered.
    pub(super) fn pair(&mut self, secret: &str) -> Result<Pair, Refused> {
        let at = self.find(secret)?;
        self.pair_of(at)
    }

    fn pair_of(&mut self, at: usize) -> Result<Pair, Refused> {
        let schedule = self.manifest.schedule;
        let is_open = self.sessions[at].observer.trials.last().is_some_and(|t| t.answer.is_none());
        if !is_open {
            let own: Vec<Trial> = self.sessions[at].observer.trials.iter().map(|t| t.trial).collect();
            let pending = self.pending(at);
            let who = (self.manifest.seed, self.sessions[at].observer.number);
            if let Some(trial) = schedule.next(self.manifest.question, who, &own, &self.answers, &pending) {
                let Session { observer, file } = &mut self.sessions[at];
                file.show(observer, trial)?;
            }
        }
        let trials = &self.sessions[at].observer.trials;
        let open = trials.last().filter(|t| t.answer.is_none());
        let scene = open.and_then(|t| self.manifest.scenes.get(t.trial.scene));
        Ok(Pair {
            observer: self.sessions[at].observer.number,
            number: trials.len() - usize::from(open.is_some()),
            pairs: schedule.trials(),
            training: schedule.training,
            done: open.is_none(),
            rows: scene.map_or(0, |s| s.rows),
            cols: scene.map_or(0, |s| s.cols),
        })
    }

    /// The pairs that other observers look at.
    fn pending(&self, at: usize) -> Vec<(usize, (usize, usize))> {
        let others = self.sessions.iter().enumerate().filter(|(number, _)| *number != at);
        let open = others.filter_map(|(_, s)| s.observer.trials.last().filter(|t| t.answer.is_none()));
        open.filter_map(|t| Some((t.trial.scene, t.trial.pair()?))).collect()
    }

    /// Records an answer. An answer that was recorded before, which the page sends again when it did not learn of it, changes nothing.
    pub(super) fn answer(&mut self, secret: &str, answer: &Answer) -> Result<Pair, Refused> {
        let at = self.find(secret)?;
        let Session { observer, file } = &mut self.sessions[at];
        match observer.trials.get(answer.number).map(|t| t.answer) {
            None => return Err(Refused::Other),
            Some(Some((recorded, _))) if recorded == answer.choice => {}
            Some(Some(_)) => return Err(Refused::Other),
            Some(None) => {
                file.answer(observer, answer.choice, answer.response_ms.min(LONGEST_MS))?;
                if let Some(last) = observer.trials.last() {
                    count(&mut self.answers, &last.trial, answer.choice);
                }
            }
        }
        self.pair_of(at)
    }

    /// The file of a picture of the pair that an observer judges now.
    pub(super) fn picture(
        &self,
        secret: &str,
        number: usize,
        which: &str,
    ) -> Result<(PathBuf, PictureFile), Refused> {
        let observer = &self.sessions[self.find(secret)?].observer;
        let is_last = number + 1 == observer.trials.len();
        let open = observer.trials.get(number).filter(|t| is_last && t.answer.is_none());
        let trial = open.ok_or(Refused::Other)?.trial;
        let scene = self.manifest.scenes.get(trial.scene).ok_or(Refused::Absent)?;
        let shown = match which {
            "reference" => Shown::Reference,
            "left" => trial.left,
            "right" => trial.right,
            _ => return Err(Refused::Absent),
        };
        let picture = match shown {
            Shown::Condition(condition) => scene.pictures.get(condition).ok_or(Refused::Absent)?,
            Shown::Reference => &scene.reference,
            Shown::Coarse => &scene.coarse,
        };
        Ok((self.dir.clone(), picture.clone()))
    }
}

/// Adds the answer to a rating. Repeats, traps and training do not choose later pairs.
fn count(answers: &mut [Counts], trial: &Trial, side: Side) {
    let other = match side {
        Side::Left => Side::Right,
        Side::Right => Side::Left,
    };
    if let (Role::Rating, Shown::Condition(preferred), Shown::Condition(other), Some(counts)) =
        (trial.role, trial.on(side), trial.on(other), answers.get_mut(trial.scene))
    {
        counts.add(preferred, other, 1.0);
    }
}
