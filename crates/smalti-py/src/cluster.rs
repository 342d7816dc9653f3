//! Sweeps on a cluster: the client that requests parts, and the workers that compute them. `python/smalti/_cluster.py` connects both.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use pyo3::prelude::*;
use pyo3::types::PyBytes;
use smalti::camera::CameraError;
use smalti::design::Sweep;
use smalti::optics::OpticalImage;
use smalti_io::dataset::{self, Manifest, RemoteDataset, RunRecord};
use smalti_io::studies;
use smalti_io::sweeps::{self, SweepRun};

use crate::error::{OrRaise, wrong};
use crate::evaluate::cache;
use crate::study::PyStudy;
use crate::work::{detached, watched};

type Made = Result<OpticalImage, CameraError>;

/// Without a cache where its limits are invalid, which [`PyPartMaker::py_new`] reports.
fn kept(key: &str, make: &dyn Fn() -> Made) -> Made {
    cache(true).map_or_else(|_| make(), |cache| cache.optical_image(key, make))
}

fn fresh(_: &str, make: &dyn Fn() -> Made) -> Made {
    make()
}

/// The scenes of a study that its description does not contain.
#[pyfunction]
pub(crate) fn scenes_in_files<'py>(py: Python<'py>, study: &PyStudy) -> Bound<'py, PyBytes> {
    PyBytes::new(py, &studies::scenes_as_bytes(study.trials.study()))
}

/// A prepared study on a worker, which computes any part of its results.
#[pyclass(name = "PartMaker", module = "smalti._smalti", frozen)]
pub(crate) struct PyPartMaker {
    sweep: Sweep<'static>,
    manifest: Manifest,
}

#[pymethods]
impl PyPartMaker {
    #[new]
    fn py_new(py: Python<'_>, manifest: &str, scenes: &[u8], cache: bool) -> PyResult<Self> {
        self::cache(cache)?;
        detached(py, || {
            let sent = Manifest::from_bytes(manifest.as_bytes(), Path::new("manifest.json")).or_raise()?;
            let (trials, about) = studies::from_json("the study that was sent", manifest, scenes)
                .map_err(|e| wrong(e.to_string()))?;
            let plan = sweeps::plan_after(&trials, about, Some(sent.plan.chunk), || None).or_raise()?;
            let own = Manifest::new(&plan).or_raise()?;
            if own.hash() != sent.hash() {
                let differences = sent.differences(&own);
                return Err(wrong(format!(
                    "a worker has another version of Smalti than the client, or other arithmetic. Differences of its results:\n{differences}"
                )));
            }
            let sweep = Sweep::owning(trials, if cache { &kept } else { &fresh });
            Ok(Self { sweep, manifest: own })
        })
    }

    /// The path of a part within the results.
    fn name(&self, part: u64) -> String {
        dataset::part_name(part)
    }

    /// Computes the bytes of a part on one core, since a worker runs one task per thread.
    fn encode<'py>(&self, py: Python<'py>, part: u64) -> PyResult<Bound<'py, PyBytes>> {
        Ok(PyBytes::new(py, &self.bytes(py, part)?))
    }

    /// Computes a part, writes it to a folder and returns its size in bytes.
    fn write(&self, py: Python<'_>, part: u64, dir: PathBuf) -> PyResult<usize> {
        let bytes = self.bytes(py, part)?;
        detached(py, || dataset::write_part(&dir, part, &bytes).or_raise())?;
        Ok(bytes.len())
    }
}

impl PyPartMaker {
    fn bytes(&self, py: Python<'_>, part: u64) -> PyResult<Vec<u8>> {
        watched(py, None, |watch| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().or_raise()?;
            pool.install(|| sweeps::encode_part(&self.sweep, &self.manifest, part, watch)).or_raise()
        })
    }
}

/// A folder that workers fill. It is locked until `finish` or `close`.
#[pyclass(name = "SharedFolder", module = "smalti._smalti", frozen)]
pub(crate) struct PySharedFolder {
    run: Mutex<Option<SweepRun>>,
    manifest: Manifest,
    missing: Vec<u64>,
}

#[pymethods]
impl PySharedFolder {
    #[new]
    fn py_new(py: Python<'_>, study: &PyStudy, out: PathBuf, part_size: Option<u64>) -> PyResult<Self> {
        detached(py, || {
            let run = SweepRun::open(&study.trials, study.about.clone(), part_size, &out, None).or_raise()?;
            let missing = run.missing().to_vec();
            Ok(Self { manifest: run.manifest().clone(), missing, run: Mutex::new(Some(run)) })
        })
    }

    /// The manifest, which is sent to workers.
    fn manifest(&self) -> PyResult<String> {
        self.manifest.to_json().or_raise()
    }

    /// The missing parts.
    fn missing(&self) -> Vec<u64> {
        self.missing.clone()
    }

    /// Number of trials of a part.
    fn trials_of(&self, part: u64) -> u64 {
        self.manifest.plan.trials_in([part])
    }

    /// Counts a part that a worker has written.
    fn adopt(&self, part: u64) -> PyResult<()> {
        let run = self.run.lock().unwrap_or_else(PoisonError::into_inner);
        run.as_ref().map_or(Ok(()), |r| r.adopt(part).or_raise())
    }

    /// Records the run in the manifest and unlocks the folder.
    fn finish(&self, py: Python<'_>, seconds: f64, threads: usize) -> PyResult<()> {
        let run = self.run.lock().unwrap_or_else(PoisonError::into_inner).take();
        detached(py, || run.map_or(Ok(()), |r| r.finish(seconds, threads).or_raise().map(drop)))
    }

    /// Unlocks the folder.
    fn close(&self) {
        drop(self.run.lock().unwrap_or_else(PoisonError::into_inner).take());
    }
}

/// Results on a file system that only Python can open.
#[pyclass(name = "SharedPlace", module = "smalti._smalti", frozen)]
pub(crate) struct PySharedPlace(RemoteDataset);

#[pymethods]
impl PySharedPlace {
    #[new]
    fn py_new(
        study: &PyStudy,
        place: PathBuf,
        part_size: Option<u64>,
        names: Vec<String>,
        manifest: Option<&[u8]>,
    ) -> PyResult<Self> {
        // An unreadable manifest is reported by `RemoteDataset::open`.
        let there = || Some(Manifest::from_bytes(manifest?, &place).ok()?.plan);
        let plan = sweeps::plan_after(&study.trials, study.about.clone(), part_size, there).or_raise()?;
        Ok(Self(RemoteDataset::open(&place, &plan, &names, manifest).or_raise()?))
    }

    /// The manifest, which is sent to workers.
    fn manifest(&self) -> PyResult<String> {
        self.0.manifest().to_json().or_raise()
    }

    /// The missing parts, from the names of existing files.
    fn missing(&self, names: Vec<String>) -> PyResult<Vec<u64>> {
        self.0.missing(&names).or_raise()
    }

    /// Number of trials of a part.
    fn trials_of(&self, part: u64) -> u64 {
        self.0.manifest().plan.trials_in([part])
    }

    /// The existing manifest with one more run.
    fn with_run(
        &self,
        manifest: &[u8],
        parts: u64,
        trials: u64,
        seconds: f64,
        threads: usize,
    ) -> PyResult<String> {
        let record = RunRecord { shard: None, parts, timings: sweeps::timings(seconds, trials, threads) };
        self.0.with_run(manifest, record).or_raise()?.to_json().or_raise()
    }
}
