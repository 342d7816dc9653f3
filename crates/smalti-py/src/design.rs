//! The search for the best colour filter array.

use std::path::PathBuf;

use pyo3::prelude::*;
use smalti::design::Design;
use smalti::experiment::{
    DesignStore, DesignedCfa, ForgetfulStore, NamedScene, Resources, analyse_design, design, light_statistics,
};
use smalti::scene::Scene;
use smalti::spectrum::Illuminant;
use smalti_io::designs::{self, LoadedDesign, SearchLog, task_text};
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

/// Searches the best colour filter array; see `smalti.design`.
#[pyfunction]
#[pyo3(signature = (source, scenes, training_set, resume, progress))]
pub(crate) fn find_design<'py>(
    py: Python<'py>,
    source: PathBuf,
    scenes: Option<Vec<Bound<'py, PyScene>>>,
    training_set: &str,
    resume: Option<PathBuf>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Found<'py>> {
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
    let (json, texts) = watched(py, progress.map(Told::Steps), |watch| {
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
        let statistics = task.illuminants.iter().map(under).collect::<PyResult<Vec<_>>>()?;
        let log =
            resume.map(|dir| SearchLog::open(&dir, &task_text(&task, &statistics)).or_raise()).transpose()?;
        let store: &dyn DesignStore = log.as_ref().map_or(&ForgetfulStore, |log| log);
        let begun = std::time::Instant::now();
        let found = design(&task, &statistics, store, watch).or_raise()?;
        let seconds = begun.elapsed().as_secs_f64();
        let best = found.searched.first().and_then(DesignedCfa::design);
        let best = best.ok_or_else(|| wrong("no mosaic was searched"))?;
        let text = |design: &Design, name: &str| designs::camera_toml(design, &description, name).or_raise();
        let of_rival = |rival: &DesignedCfa| {
            let design = rival.design()?;
            let named = format!("{}, filters of {}", rival.name, task.name);
            Some(text(&design, &named).map(|text| (rival.name.clone(), text)))
        };
        let rivals = found.rivals.iter().filter_map(of_rival).collect::<PyResult<Vec<_>>>()?;
        let of_point = |(number, point): (usize, &smalti::experiment::FrontPoint)| {
            Some(text(&point.cfa.design()?, &format!("{}, compromise {number}", task.name)))
        };
        let front = (1..).zip(&found.front).filter_map(of_point).collect::<PyResult<Vec<_>>>()?;
        let cfa = best.cfa(task.camera.grid()).or_raise()?;
        let first = statistics.first().ok_or_else(|| wrong("the design has no illuminant"))?;
        let analysis =
            analyse_design(&task.camera, first, &task.conditions, task.filters.clear(), &cfa).or_raise()?;
        let results =
            smalti_report::design::results(&task, &statistics, &found, &analysis, seconds).or_raise()?;
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

/// Names of the built-in designs with their summaries.
#[pyfunction(name = "designs")]
pub(crate) fn design_names() -> std::collections::BTreeMap<&'static str, &'static str> {
    designs::names().iter().map(|d| (d.name, d.summary)).collect()
}
