//! The plan and the manifest of a dataset.

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
/// Maximum size of a manifest, bytes. Its decoded JSON may take about 16 times as much memory.
const LIMIT: u64 = 64 << 20;

/// The study, the columns and the division into chunks. Runs with equal plans write identical parts.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// The resolved study. The order of its keys does not matter.
    pub study: Value,
    /// The columns.
    pub schema: Vec<ColumnSpec>,
    /// Number of trials, at least 1.
    pub trials: u64,
    /// Trials per chunk, 1 to [`MAX_CHUNK`]. The last chunk has the remainder. A plan has at most [`MAX_PARTS`] chunks.
    pub chunk: u64,
}

impl Plan {
    /// Number of chunks.
    #[must_use]
    pub fn chunks(&self) -> u64 {
        self.trials.div_ceil(self.chunk.max(1))
    }

    /// The trials of a chunk; an empty range if the chunk does not exist.
    #[must_use]
    pub fn trials_of(&self, chunk: u64) -> Range<u64> {
        let at = |c: u64| c.saturating_mul(self.chunk).min(self.trials);
        at(chunk)..at(chunk.saturating_add(1))
    }

    /// Number of trials in several chunks.
    #[must_use]
    pub fn trials_in(&self, chunks: impl IntoIterator<Item = u64>) -> u64 {
        chunks.into_iter().map(|c| self.trials_of(c)).map(|r| r.end - r.start).sum()
    }

    /// Number of trials in a chunk.
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

/// The record of a finished run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunRecord {
    /// The shard, such as `3/16`; `None` for a whole run.
    pub shard: Option<String>,
    /// Number of parts that it wrote.
    pub parts: u64,
    /// Timings, in the form that the caller chose.
    pub timings: Value,
}

/// A manifest: a plan, the version that computes it, and the finished runs.
#[derive(Debug, Clone, PartialEq)]
pub struct Manifest {
    /// Version of Smalti that computes the results.
    pub smalti: String,
    /// The plan.
    pub plan: Plan,
    /// The finished runs, in the order of their ends. This is the only content that differs between runs of equal plans.
    pub runs: Vec<RunRecord>,
    hash: String,
}

/// The JSON object of the file.
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
    /// The manifest, without runs, of a plan that this version of Smalti computes.
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
        // With line breaks and indents, the file may be twice as long as this text. It must not be too large to read back.
        if text.len() as u64 > LIMIT / 2 {
            let (found, expected) = (format!("{} bytes", text.len()), format!("at most {} bytes", LIMIT / 2));
            return Err(DatasetError::Plan { what: "the resolved study".into(), found, expected });
        }
        let hash = blake3::hash(text.as_bytes()).to_hex().to_string();
        Ok(Self { smalti, plan, runs, hash })
    }

    /// BLAKE3 hash of the manifest without runs, hexadecimal. Every part states it.
    #[must_use]
    pub fn hash(&self) -> &str {
        &self.hash
    }

    /// Reads the manifest of a folder; `None` if there is none.
    pub(super) fn read(dir: &Path) -> Result<Option<Self>, DatasetError> {
        let path = dir.join(FILE);
        match file::read(&path, LIMIT) {
            Ok(bytes) => Self::from_bytes(&bytes, &path).map(Some),
            Err(IoError::Read { source, .. }) if source.kind() == std::io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(error.into()),
        }
    }

    /// Decodes a manifest. `path` is used in error messages.
    ///
    /// # Errors
    /// When the bytes are not the JSON of a manifest, the revision is another one, the stated hash is wrong, or the plan is invalid.
    pub fn from_bytes(bytes: &[u8], path: &Path) -> Result<Self, DatasetError> {
        let decode = |message: String| IoError::decode(path, "manifest", message);
        let value: Value = serde_json::from_slice(bytes).map_err(|e| decode(e.to_string()))?;
        let at = |key: &str| value.get(key).map_or_else(|| "absent".to_owned(), Value::to_string);
        if value.get("format").and_then(Value::as_str) != Some(FORMAT) {
            return Err(IoError::field(path, "format", at("format"), format!("{FORMAT:?}")).into());
        }
        if value.get("revision").and_then(Value::as_u64) != Some(REVISION) {
            let (format, found, expected) = ("results", at("revision"), "2".into());
            return Err(IoError::Version { path: path.to_owned(), format, found, expected }.into());
        }
        let raw: Raw = serde_json::from_value(value).map_err(|e| decode(e.to_string()))?;
        let plan = Plan { study: raw.study, schema: raw.schema, trials: raw.trials, chunk: raw.chunk };
        let manifest = Self::with(raw.smalti, plan, raw.runs)
            .map_err(|e| decode(format!("its plan is invalid: {e}")))?;
        if manifest.hash != raw.plan_blake3 {
            let (found, stated) = (manifest.hash, raw.plan_blake3);
            return Err(IoError::Damaged { path: path.to_owned(), found, stated }.into());
        }
        Ok(manifest)
    }

    /// The text of the file.
    ///
    /// # Errors
    /// When a value cannot be converted to JSON, which is not known to occur.
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

    /// Refuses another plan than that of this manifest, which is stored in `dir`.
    pub(super) fn check_same(&self, now: &Self, dir: &Path) -> Result<(), DatasetError> {
        if self.hash == now.hash {
            return Ok(());
        }
        Err(DatasetError::OtherStudy { dir: dir.to_owned(), differences: self.differences(now) })
    }

    /// Differences between this plan and another. Keys of the study come first; all other keys are in parentheses.
    #[must_use]
    pub fn differences(&self, now: &Self) -> Differences {
        let all = |m: &Self| {
            let mut all = json!({});
            // A study that is not a JSON object is compared as a single value.
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

/// The content that the hash covers. It determines the parts.
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

/// Writes JSON with sorted keys, so that their order in a file does not affect the hash.
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
