//! What a dataset is: the plan, its hash, and what the runs took.

use std::ops::Range;
use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::difference::Differences;
use super::error::DatasetError;
use super::schema::{self, ColumnSpec};
use super::{MAX_CHUNK, MAX_PARTS, REVISION};
use crate::{IoError, file, write};

/// Name of the manifest in its folder.
pub(super) const FILE: &str = "manifest.json";
const FORMAT: &str = "smalti-results";
/// Largest manifest, bytes. Its JSON takes some sixteen times as much memory at worst.
const LIMIT: u64 = 64 << 20;

/// What is to be computed, and how it is laid out. Two runs of equal plans write equal files.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// The resolved study. The order of its keys does not matter.
    pub study: Value,
    /// The columns.
    pub schema: Vec<ColumnSpec>,
    /// Number of trials, from 1.
    pub trials: u64,
    /// Trials in a part, from 1 to [`MAX_CHUNK`]; the last part has what is left. At most [`MAX_PARTS`] parts.
    pub chunk: u64,
}

impl Plan {
    /// Number of chunks.
    #[must_use]
    pub fn chunks(&self) -> u64 {
        self.trials.div_ceil(self.chunk.max(1))
    }

    /// The trials of a chunk; none where there is no such chunk.
    #[must_use]
    pub fn trials_of(&self, chunk: u64) -> Range<u64> {
        let at = |c: u64| c.saturating_mul(self.chunk).min(self.trials);
        at(chunk)..at(chunk.saturating_add(1))
    }

    /// Number of trials of a chunk.
    pub(super) fn rows(&self, chunk: u64) -> usize {
        let Range { start, end } = self.trials_of(chunk);
        usize::try_from(end - start).unwrap_or(usize::MAX)
    }

    fn check(&self) -> Result<(), DatasetError> {
        let error = |what: &str, found: u64, expected: String| {
            Err(DatasetError::Plan { what: what.into(), found: found.to_string(), expected })
        };
        if self.trials == 0 {
            return error("the number of trials", 0, "at least 1".into());
        }
        if self.chunk == 0 || self.chunk > MAX_CHUNK {
            return error("the number of trials in a chunk", self.chunk, format!("1 to {MAX_CHUNK}"));
        }
        if self.chunks() > MAX_PARTS {
            let expected = format!("at most {MAX_PARTS}; choose larger parts");
            return error("the number of parts", self.chunks(), expected);
        }
        schema::check(&self.schema)
    }
}

/// What one run did.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunRecord {
    /// Its shard, as `3/16`; `None` for a run of the whole.
    pub shard: Option<String>,
    /// Parts it wrote.
    pub parts: u64,
    /// What it took, as the caller gave it.
    pub timings: Value,
}

/// A manifest: a plan, who carries it out, and what the runs took.
#[derive(Debug, Clone, PartialEq)]
pub struct Manifest {
    /// Version of Smalti that computes.
    pub smalti: String,
    /// What is computed.
    pub plan: Plan,
    /// The runs that were finished, in the order of their ends. Alone of all that is written it is not the same in every run.
    pub runs: Vec<RunRecord>,
    hash: String,
}

/// The manifest as it is written.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Raw {
    format: String,
    revision: u64,
    smalti: String,
    plan_blake3: String,
    trials: u64,
    chunk: u64,
    schema: Vec<ColumnSpec>,
    study: Value,
    runs: Vec<RunRecord>,
}

impl Manifest {
    /// That of a plan which this version of Smalti is to carry out.
    ///
    /// # Errors
    /// [`DatasetError::Plan`].
    pub fn new(plan: &Plan) -> Result<Self, DatasetError> {
        Self::with(env!("CARGO_PKG_VERSION").to_owned(), plan.clone(), Vec::new())
    }

    fn with(smalti: String, plan: Plan, runs: Vec<RunRecord>) -> Result<Self, DatasetError> {
        plan.check()?;
        let mut text = String::new();
        canonical(&described(&smalti, &plan), &mut text);
        // As it is written, with line breaks and indents, it may be twice as long; what could not be read is not begun.
        if text.len() as u64 > LIMIT / 2 {
            let (found, expected) = (format!("{} bytes", text.len()), format!("at most {} bytes", LIMIT / 2));
            return Err(DatasetError::Plan { what: "the resolved study".into(), found, expected });
        }
        let hash = blake3::hash(text.as_bytes()).to_hex().to_string();
        Ok(Self { smalti, plan, runs, hash })
    }

    /// BLAKE3 hash, hexadecimal, of all but the runs. Every part carries it.
    #[must_use]
    pub fn hash(&self) -> &str {
        &self.hash
    }

    /// Reads the manifest in a folder; `None` where there is none.
    pub(super) fn read(dir: &Path) -> Result<Option<Self>, DatasetError> {
        let path = dir.join(FILE);
        match file::read(&path, LIMIT) {
            Ok(bytes) => Self::from_bytes(&bytes, &path).map(Some),
            Err(IoError::Read { source, .. }) if source.kind() == std::io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(error.into()),
        }
    }

    /// Reads a manifest from memory; `path` is only named in errors.
    ///
    /// # Errors
    /// When it is not JSON of this form, is of another revision, states a hash that is not its own, or has a plan that cannot be.
    pub fn from_bytes(bytes: &[u8], path: &Path) -> Result<Self, DatasetError> {
        let decode = |message: String| IoError::decode(path, "manifest", message);
        let value: Value = serde_json::from_slice(bytes).map_err(|e| decode(e.to_string()))?;
        let at = |key: &str| value.get(key).map_or_else(|| "absent".to_owned(), Value::to_string);
        if value.get("format").and_then(Value::as_str) != Some(FORMAT) {
            return Err(IoError::field(path, "format", at("format"), format!("{FORMAT:?}")).into());
        }
        if value.get("revision").and_then(Value::as_u64) != Some(REVISION) {
            let (format, found, expected) = ("results", at("revision"), "2");
            return Err(IoError::Version { path: path.to_owned(), format, found, expected }.into());
        }
        let raw: Raw = serde_json::from_value(value).map_err(|e| decode(e.to_string()))?;
        let plan = Plan { study: raw.study, schema: raw.schema, trials: raw.trials, chunk: raw.chunk };
        let manifest =
            Self::with(raw.smalti, plan, raw.runs).map_err(|e| decode(format!("its plan cannot be: {e}")))?;
        if manifest.hash != raw.plan_blake3 {
            let (found, stated) = (manifest.hash, raw.plan_blake3);
            return Err(IoError::Damaged { path: path.to_owned(), found, stated }.into());
        }
        Ok(manifest)
    }

    /// The text of the file.
    ///
    /// # Errors
    /// None that is known: what it holds can be stated as JSON.
    pub fn to_json(&self) -> Result<String, serde_json::Error> {
        let raw = Raw {
            format: FORMAT.into(),
            revision: REVISION,
            smalti: self.smalti.clone(),
            plan_blake3: self.hash.clone(),
            trials: self.plan.trials,
            chunk: self.plan.chunk,
            schema: self.plan.schema.clone(),
            study: self.plan.study.clone(),
            runs: self.runs.clone(),
        };
        Ok(serde_json::to_string_pretty(&raw)? + "\n")
    }

    pub(super) fn write(&self, dir: &Path) -> Result<(), IoError> {
        let path = dir.join(FILE);
        let text = self.to_json().map_err(|e| IoError::writing(&path)(e.into()))?;
        write::durable(&path, text.as_bytes())
    }

    /// Refuses to continue, in a place that has this manifest, with another plan.
    pub(super) fn check_same(&self, now: &Self, dir: &Path) -> Result<(), DatasetError> {
        if self.hash == now.hash {
            return Ok(());
        }
        Err(DatasetError::OtherStudy { dir: dir.to_owned(), differences: self.differences(now) })
    }

    /// Where the plan differs from another; keys of the study first, by their names alone.
    #[must_use]
    pub fn differences(&self, now: &Self) -> Differences {
        let all = |m: &Self| {
            let mut all = json!({});
            // A study is a table; whatever else it may be has one name.
            match &m.plan.study {
                Value::Object(study) => all = Value::Object(study.clone()),
                other => all["study"] = other.clone(),
            }
            for (key, value) in described(&m.smalti, &m.plan).as_object().into_iter().flatten() {
                if key != "study" {
                    all[format!("({key})")] = value.clone();
                }
            }
            all
        };
        Differences::of(&all(self), &all(now))
    }
}

/// All that decides what the parts hold.
fn described(smalti: &str, plan: &Plan) -> Value {
    let schema: Vec<Value> = plan
        .schema
        .iter()
        .map(|c| json!({"name": c.name, "kind": c.kind, "unit": c.unit, "doc": c.doc}))
        .collect();
    json!({
        "smalti": smalti,
        "revision": REVISION,
        "trials": plan.trials,
        "chunk": plan.chunk,
        "schema": schema,
        "study": plan.study,
    })
}

/// JSON with the keys of every object in order, so that their order in a file does not matter.
fn canonical(value: &Value, out: &mut String) {
    match value {
        Value::Object(map) => {
            let mut entries: Vec<_> = map.iter().collect();
            entries.sort_by_key(|(key, _)| key.as_str());
            out.push('{');
            for (i, (key, value)) in entries.into_iter().enumerate() {
                if i > 0 {
                    out.push(',');
                }
                out.push_str(&Value::from(key.as_str()).to_string());
                out.push(':');
                canonical(value, out);
            }
            out.push('}');
        }
        Value::Array(values) => {
            out.push('[');
            for (i, value) in values.iter().enumerate() {
                if i > 0 {
                    out.push(',');
                }
                canonical(value, out);
            }
            out.push(']');
        }
        plain => out.push_str(&plain.to_string()),
    }
}
