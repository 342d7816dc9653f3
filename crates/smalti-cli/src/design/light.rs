//! The statistics of light of a search: of the default training set, of given scenes, or from files.

use std::path::{Path, PathBuf};

use anyhow::bail;
use smalti::design::light::LightStatistics;
use smalti::experiment::{DesignTask, NamedScene, Resources, light_gatherer, light_statistics};
use smalti::scene::Scene;
use smalti::spectrum::Illuminant;
use smalti_io::{light, write};

use super::args::DesignArgs;
use crate::args::Common;
use crate::output::note;
use crate::progress::Progress;
use crate::resolve;

/// The statistics under each illuminant.
pub(super) fn statistics(
    task: &DesignTask,
    args: &DesignArgs,
    common: &Common,
    progress: &Progress,
) -> anyhow::Result<Vec<LightStatistics>> {
    if !args.light.is_empty() {
        return read(task, &args.light, common);
    }
    let stored = args.learning.training_set.stored();
    let under = |illuminant: &Illuminant| {
        let scenes = scenes(task, args, illuminant, common)?;
        let resources = Resources { training_scenes: stored, progress, ..Resources::default() };
        Ok(light_statistics(&task.camera, illuminant, scenes.as_deref(), &task.light, resources)?)
    };
    task.illuminants.iter().map(under).collect()
}

/// The scenes of the command line under an illuminant.
fn scenes(
    task: &DesignTask,
    args: &DesignArgs,
    illuminant: &Illuminant,
    common: &Common,
) -> anyhow::Result<Option<Vec<Scene>>> {
    let scene = |name: &String| {
        let scene = resolve::scene_for(name, &args.scene_options, &task.camera, common)?;
        let keeps_fov = args.scene_options.states_fov(name);
        let named =
            NamedScene::for_camera(&task.camera, name.clone(), scene, resolve::is_file(name), keeps_fov)?;
        Ok(named.scene.relit(illuminant)?)
    };
    if args.light_scenes.is_empty() {
        return Ok(None);
    }
    args.light_scenes.iter().map(scene).collect::<anyhow::Result<_>>().map(Some)
}

/// The statistics in files, those of one illuminant merged.
fn read(task: &DesignTask, files: &[PathBuf], common: &Common) -> anyhow::Result<Vec<LightStatistics>> {
    let mut read = files.iter().map(|f| Ok((f, light::read(f)?))).collect::<anyhow::Result<Vec<_>>>()?;
    let wanted = task.light.around(&task.camera)?;
    if read.iter().any(|(_, s)| *s.settings() != wanted) {
        note("the settings of the statistics are those of their files, not those of the design", common);
    }
    let mut all = Vec::new();
    for illuminant in &task.illuminants {
        let mut merged: Option<LightStatistics> = None;
        let mut others = Vec::new();
        for (file, statistics) in read {
            let expected = light_gatherer(&task.camera, illuminant, statistics.settings())?;
            if statistics.source() != expected.statistics().source() {
                others.push((file, statistics));
            } else if let Some(merged) = &mut merged {
                merged.merge(&statistics).map_err(|e| anyhow::anyhow!("{}: {e}", file.display()))?;
            } else {
                merged = Some(statistics);
            }
        }
        let Some(merged) = merged else {
            let name = illuminant.name();
            bail!(
                "--light: no file has the light of {name} behind the lens and on the pixels of camera {}. Statistics hold for one lens, pixel geometry, \
                 set of wavelengths and illuminant; without --light they are gathered",
                task.camera.description().name,
            );
        };
        all.push(merged);
        read = others;
    }
    if let Some((file, _)) = read.first() {
        bail!(
            "{}: statistics of a light that the design does not have; expected its lens, pixel and illuminants",
            file.display()
        );
    }
    Ok(all)
}

/// Keeps the statistics in the folder of the results, for further searches.
pub(super) fn keep(dir: &Path, task: &DesignTask, statistics: &[LightStatistics]) -> anyhow::Result<()> {
    let names: Vec<String> = task.illuminants.iter().map(Illuminant::name).collect();
    let names = smalti_report::names::file_names(names.iter().map(String::as_str));
    write::begin_folder(&dir.join("light"), &[])?;
    for (name, statistics) in names.iter().zip(statistics) {
        light::write(&dir.join("light").join(format!("{name}.light")), statistics)?;
    }
    Ok(())
}
