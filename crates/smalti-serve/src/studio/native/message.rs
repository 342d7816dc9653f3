//! The messages of the page about heavy work, and the answers.
//!
//! Both are JSON, an object with one key. Files follow the answer that announces them, each as one binary message, in their order.

use serde::{Deserialize, Serialize};
use serde_json::Value;
use smalti::design::live::LiveFamily;
use smalti::l3::Quality;
use thiserror::Error;

use super::error::JobError;

/// The longest message of the page, bytes. The largest design of the page, 16 × 16 cells and 26 sampled filters, takes less than a tenth of it.
pub const MOST_MESSAGE_BYTES: usize = 1 << 20;
/// Luminances of a report.
const MOST_LUMINANCES: usize = 8;
/// The range of luminances, cd/m².
const LUMINANCES_CD_M2: std::ops::RangeInclusive<f64> = 1e-4..=1e6;

/// A message of the page.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Request {
    /// Begins work. A page has one job at a time.
    Start {
        /// What answers name.
        id: u32,
        /// The work.
        job: Job,
    },
    /// Ends the work of this number, unless it has ended.
    Cancel {
        /// That of its start.
        id: u32,
    },
}

/// Work for the native library. Designs are camera descriptions; they hold no names of files.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Job {
    /// The pipeline of a design as a table, learned as by `smalti train --illuminants D65`.
    Table {
        /// The camera.
        design: Value,
        /// What it may spend on a picture.
        #[serde(default)]
        quality: Quality,
    },
    /// A capture of a scene by the whole simulation at the size of the sensor, as by `smalti simulate`: the raw image, and the picture when it is processed.
    Capture(Capture),
    /// A search for better filters and a better mosaic, as by `smalti design`.
    Search(Search),
    /// A comparison with another design over luminances as a page, as by `smalti compare`.
    Report(Report),
    /// The scores of a design over luminances, with filters as designed and with filters that deviate.
    Sweep(Sweep),
}

/// A capture.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Capture {
    /// The camera.
    pub design: Value,
    /// The identifier of a scene of the studio.
    pub scene: String,
    /// The mean luminance of the scene, cd/m².
    pub luminance_cd_m2: f64,
    /// What the pipeline of the design may spend on the picture. Without it, the raw image alone is wanted, and nothing is learned.
    #[serde(default)]
    pub pipeline: Option<Quality>,
}

/// What is compared.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Report {
    /// The camera.
    pub design: Value,
    /// The camera that it is compared with.
    #[serde(default)]
    pub rival: Option<Value>,
    /// The identifier of the only scene. Without it, the natural scenes of the command.
    #[serde(default)]
    pub scene: Option<String>,
    /// Mean luminances of the scenes, cd/m².
    pub luminances_cd_m2: Vec<f64>,
    /// What pipelines may spend on a picture.
    #[serde(default)]
    pub quality: Quality,
}

/// What is swept: a design over luminances, and deviations of its filters.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sweep {
    /// The camera.
    pub design: Value,
    /// The name of a set of test scenes: `charts`, `natural` or `all`.
    pub set: String,
    /// Mean luminances of the scenes, cd/m².
    pub luminances_cd_m2: Vec<f64>,
    /// What pipelines may spend on a picture.
    #[serde(default)]
    pub quality: Quality,
    /// The family of the filters, which says what a filter without absorbance transmits.
    #[serde(default)]
    pub family: LiveFamily,
}

/// What a search begins with and keeps.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Search {
    /// The camera.
    pub design: Value,
    /// Letters of the filters that stay, with the cells that they have.
    #[serde(default)]
    pub filters: Vec<String>,
    /// Row and column of the cells that stay.
    #[serde(default)]
    pub cells: Vec<[usize; 2]>,
    /// Whether all cells stay.
    #[serde(default)]
    pub mosaic: bool,
    /// Mean luminances, cd/m².
    pub luminances_cd_m2: Vec<f64>,
    /// The family of the filters.
    #[serde(default)]
    pub family: LiveFamily,
}

/// Why a message is none of the page.
#[derive(Debug, Error)]
pub enum MessageError {
    /// It is too long.
    #[error("a message of {bytes} bytes; expected at most {MOST_MESSAGE_BYTES}")]
    Long {
        /// Its length.
        bytes: usize,
    },
    /// It is no request.
    #[error("the message is no request: {0}")]
    Malformed(#[from] serde_json::Error),
}

impl Request {
    /// Reads a message.
    ///
    /// # Errors
    /// When it is longer than [`MOST_MESSAGE_BYTES`], no JSON, or no request.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, MessageError> {
        if bytes.len() > MOST_MESSAGE_BYTES {
            return Err(MessageError::Long { bytes: bytes.len() });
        }
        Ok(serde_json::from_slice(bytes)?)
    }
}

/// Checks luminances.
pub(super) fn ensure_luminances(all: &[f64]) -> Result<(), JobError> {
    if all.is_empty() || all.len() > MOST_LUMINANCES {
        return Err(JobError::Wrong(format!("{} luminances; expected 1 to {MOST_LUMINANCES}", all.len())));
    }
    match all.iter().find(|l| !LUMINANCES_CD_M2.contains(l)) {
        Some(wrong) => Err(JobError::Wrong(format!(
            "a luminance of {wrong} cd/m²; expected {} to {}",
            LUMINANCES_CD_M2.start(),
            LUMINANCES_CD_M2.end()
        ))),
        None => Ok(()),
    }
}

/// An answer to the page.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Said {
    /// How far the work is.
    Progress {
        /// The number of the job.
        id: u32,
        /// The step at work.
        step: String,
        /// Steps that are done.
        done: u64,
        /// Steps that are known.
        of: u64,
    },
    /// The work is done.
    Result {
        /// The number of the job.
        id: u32,
        /// What was found.
        said: Value,
        /// The files that follow.
        files: Vec<FileSaid>,
    },
    /// The work was ended by the page.
    Cancelled {
        /// The number of the job.
        id: u32,
    },
    /// There is no result.
    Failed {
        /// The number of the job.
        id: u32,
        /// Why.
        message: String,
    },
    /// The message was none of this page. The connection ends.
    Refused {
        /// Why.
        message: String,
    },
}

/// A file that follows.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub(super) struct FileSaid {
    /// What it is: `table`, `raw`, `picture`, `page` or `csv`.
    pub(super) kind: &'static str,
    /// Its length.
    pub(super) bytes: usize,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_request_is_read_strictly() {
        let read = |text: &str| Request::from_bytes(text.as_bytes());
        let cancel = read(r#"{"cancel": {"id": 3}}"#).unwrap();
        assert_eq!(cancel, Request::Cancel { id: 3 });
        let start = r#"{"start": {"id": 1, "job": {"capture": {"design": {}, "scene": "spices", "luminance_cd_m2": 5, "pipeline": "best"}}}}"#;
        let Request::Start { id: 1, job: Job::Capture(capture) } = read(start).unwrap() else {
            panic!("a capture is asked for");
        };
        assert_eq!((capture.scene.as_str(), capture.luminance_cd_m2), ("spices", 5.0));
        assert_eq!(capture.pipeline, Some(Quality::Best));
        for wrong in [
            "",
            "[]",
            "null",
            "{\"start\": {\"id\": 1}}",
            "{\"cancel\": {\"id\": -1}}",
            "{\"cancel\": {\"id\": 1, \"file\": \"/etc/passwd\"}}",
            "{\"cancel\": {\"id\": 1}, \"start\": {}}",
            "{\"start\": {\"id\": 1, \"job\": {\"open\": {\"path\": \"../x\"}}}}",
            "{\"start\": {\"id\": 1, \"job\": {\"table\": {\"design\": {}, \"file\": \"x\"}}}}",
            "{\"start\": {\"id\": 1, \"job\": {\"capture\": {\"design\": {}, \"scene\": 1, \"luminance_cd_m2\": 1}}}}",
        ] {
            assert!(matches!(read(wrong), Err(MessageError::Malformed(_))), "{wrong}");
        }
        // Deep nesting ends the reading, not the program.
        assert!(read(&"[".repeat(MOST_MESSAGE_BYTES)).is_err());
        let long = " ".repeat(MOST_MESSAGE_BYTES + 1);
        assert_eq!(
            read(&long).unwrap_err().to_string(),
            "a message of 1048577 bytes; expected at most 1048576"
        );
    }

    #[test]
    fn luminances_have_a_range() {
        assert!(ensure_luminances(&[1.0, 100.0]).is_ok());
        for wrong in [&[][..], &[1.0; 9], &[0.0], &[-1.0], &[f64::NAN], &[1e300]] {
            assert!(ensure_luminances(wrong).is_err(), "{wrong:?}");
        }
    }
}
