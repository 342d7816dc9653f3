//! The search for the best colour filter array.

use std::path::{Path, PathBuf};

use pyo3::prelude::*;
use pyo3::types::PyBytes;
use smalti::camera::CameraDescription;
use smalti::design::Design;
use smalti::design::light::LightStatistics;
use smalti::experiment::{
    DesignStore, DesignTask, DesignedCfa, ExperimentError, FrontPoint, KeptFind, NamedScene, Resources,
    analyse_design, design, light_statistics,
};
use smalti::scene::Scene;
use smalti::spectrum::Illuminant;
use smalti_io::designs::{self, LoadedDesign, SearchLog, SharedSearch, task_hash, task_text};
use smalti_io::light;
use smalti_io::rendered::TrainingSet;

use crate::camera::{PyCamera, diagnosed};
use crate::error::{OrRaise, one_of, wrong};
use crate::json::loads;
use crate::l3::training_sets;
use crate::scene::PyScene;
use crate::spectrum::warn;
use crate::work::{Told, watched};

/// What `smalti.design` returns: the results as JSON objects, the camera, rivals by name, and the cameras of the front.
type Found<'py> = (Bound<'py, PyAny>, PyCamera, Vec<(String, PyCamera)>, Vec<PyCamera>);

/// A search for the best colour filter array: what is wanted, the statistics of the light, and what is known so far; see `smalti.design`.
#[pyclass(name = "DesignSearch", module = "smalti._smalti", frozen)]
pub(crate) struct PyDesignSearch {
    task: DesignTask,
    description: CameraDescription,
    statistics: Vec<LightStatistics>,
    known: SharedSearch,
    log: Option<SearchLog>,
}

/// Finds all that is known, searches the rest, and logs it.
struct Logged<'a> {
    known: &'a SharedSearch,
    log: Option<&'a SearchLog>,
}

impl DesignStore for Logged<'_> {
    fn find(&self, part: &str) -> Option<Vec<KeptFind>> {
        self.known.find(part)
    }

    fn keep(&self, part: &str, found: &[KeptFind]) {
        if let Some(log) = self.log {
            log.keep(part, found);
        }
    }
}

#[pymethods]
impl PyDesignSearch {
    /// Gathers the statistics of the light, unless they are given as the bytes of files.
    #[new]
    #[pyo3(signature = (source, scenes, training_set, resume, light, progress))]
    fn py_new(
        py: Python<'_>,
        source: PathBuf,
        scenes: Option<Vec<Bound<'_, PyScene>>>,
        training_set: &str,
        resume: Option<PathBuf>,
        light: Option<Vec<Vec<u8>>>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let name = source.to_string_lossy().into_owned();
        let LoadedDesign { task, camera: description, notes, .. } =
            designs::load(&name).map_err(|e| diagnosed(&name, &e.to_string()))?;
        warn(py, notes)?;
        let stored = one_of("training_set", training_set, &training_sets())?;
        let scene = |s: Bound<'_, PyScene>| {
            let PyScene { scene, source, fov_stated, is_file } = s.get().clone();
            NamedScene::for_camera(&task.camera, source, scene, is_file, fov_stated).or_raise()
        };
        let scenes: Option<Vec<NamedScene>> =
            scenes.map(|all| all.into_iter().map(scene).collect::<PyResult<_>>()).transpose()?;
        watched(py, progress.map(Told::Steps), |watch| {
            let resources = || Resources {
                training_scenes: TrainingSet::stored(stored),
                progress: watch,
                ..Resources::default()
            };
            let under = |light: &Illuminant| {
                let relit = |s: &NamedScene| s.scene.clone().relit(light).or_raise_about(&s.name);
                let scenes: Option<Vec<Scene>> =
                    scenes.as_ref().map(|all| all.iter().map(relit).collect::<PyResult<_>>()).transpose()?;
                light_statistics(&task.camera, light, scenes.as_deref(), &task.light, resources()).or_raise()
            };
            let statistics = match light {
                Some(files) => {
                    let sent = Path::new("the statistics that were sent");
                    files
                        .iter()
                        .map(|f| light::from_bytes(f, sent).or_raise())
                        .collect::<PyResult<Vec<_>>>()?
                }
                None => task.illuminants.iter().map(under).collect::<PyResult<Vec<_>>>()?,
            };
            let log = resume
                .map(|dir| SearchLog::open(&dir, &task_text(&task, &statistics)).or_raise())
                .transpose()?;
            let known = log.as_ref().map(|log| log.found().clone()).unwrap_or_default();
            let known = SharedSearch::new(known, Vec::new());
            Ok(Self { task, description, statistics, known, log })
        })
    }

    /// The statistics of the light, as the bytes of files.
    fn light<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyBytes>>> {
        let to_bytes = |s| light::to_bytes(s, Path::new("statistics of light")).or_raise();
        self.statistics.iter().map(|s| Ok(PyBytes::new(py, &to_bytes(s)?))).collect()
    }

    /// Equal for searches whose parts fit each other.
    fn hash(&self) -> String {
        task_hash(&task_text(&self.task, &self.statistics))
    }

    /// All that is known, a line for each part.
    fn known(&self) -> Vec<String> {
        self.known.lines()
    }

    /// Adds a line that another process found, and logs it.
    fn add(&self, line: &str) -> PyResult<()> {
        let (part, found) = self.known.add(line).or_raise()?;
        if let Some(log) = &self.log {
            log.keep(&part, &found);
        }
        Ok(())
    }

    /// The parts that can be searched now, with what is known.
    fn open_parts(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        watched(py, None, |watch| match design(&self.task, &self.statistics, &self.known, watch) {
            Ok(_) => Ok(Vec::new()),
            Err(ExperimentError::OpenParts) => Ok(self.known.take_open()),
            Err(e) => Err(e).or_raise(),
        })
    }

    /// Searches one part with the `known` ones, on one core, and returns its line.
    fn search(&self, py: Python<'_>, part: String, known: Vec<String>) -> PyResult<String> {
        watched(py, None, |watch| {
            let store = SharedSearch::new(self.known.found(), vec![part.clone()]);
            for line in &known {
                store.add(line).or_raise()?;
            }
            let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().or_raise()?;
            match pool.install(|| design(&self.task, &self.statistics, &store, watch)) {
                Ok(_) | Err(ExperimentError::OpenParts) => {}
                Err(e) => return Err(e).or_raise(),
            }
            store.line(&part).ok_or_else(|| wrong(format!("the search has no part '{part}'")))
        })
    }

    /// Searches what is not known, and returns the result.
    fn find<'py>(&self, py: Python<'py>, progress: Option<&Bound<'_, PyAny>>) -> PyResult<Found<'py>> {
        let Self { task, description, statistics, known, log } = self;
        let (json, texts) = watched(py, progress.map(Told::Steps), |watch| {
            let begun = std::time::Instant::now();
            let store = Logged { known, log: log.as_ref() };
            let found = design(task, statistics, &store, watch).or_raise()?;
            let seconds = begun.elapsed().as_secs_f64();
            let best = found.searched.first().and_then(DesignedCfa::design);
            let best = best.ok_or_else(|| wrong("no mosaic was searched"))?;
            let text =
                |design: &Design, name: &str| designs::camera_toml(design, description, name).or_raise();
            let of_rival = |rival: &DesignedCfa| {
                let design = rival.design()?;
                let named = format!("{}, filters of {}", rival.name, task.name);
                Some(text(&design, &named).map(|text| (rival.name.clone(), text)))
            };
            let rivals = found.rivals.iter().filter_map(of_rival).collect::<PyResult<Vec<_>>>()?;
            let of_point = |(number, point): (usize, &FrontPoint)| {
                Some(text(&point.cfa.design()?, &format!("{}, compromise {number}", task.name)))
            };
            let front = (1..).zip(&found.front).filter_map(of_point).collect::<PyResult<Vec<_>>>()?;
            let cfa = best.cfa(task.camera.grid()).or_raise()?;
            let first = statistics.first().ok_or_else(|| wrong("the design has no illuminant"))?;
            let analysis = analyse_design(&task.camera, first, &task.conditions, task.filters.clear(), &cfa)
                .or_raise()?;
            let results =
                smalti_report::design::results(task, statistics, &found, &analysis, seconds).or_raise()?;
            Ok((results.to_string(), (text(&best, &task.name)?, rivals, front)))
        })?;
        let (best, rivals, front) = texts;
        let camera = |text: String| PyCamera::from_text(text, PathBuf::new(), &[], None);
        let rival = |(name, text): (String, String)| Ok((name, camera(text)?));
        Ok((
            loads(py, &json)?,
            camera(best)?,
            rivals.into_iter().map(rival).collect::<PyResult<_>>()?,
            front.into_iter().map(camera).collect::<PyResult<_>>()?,
        ))
    }
}

/// Names of the built-in designs with their summaries.
#[pyfunction(name = "designs")]
pub(crate) fn design_names() -> std::collections::BTreeMap<&'static str, &'static str> {
    designs::names().iter().map(|d| (d.name, d.summary)).collect()
}
