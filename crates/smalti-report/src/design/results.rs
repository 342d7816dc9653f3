//! The results of a search as JSON: `results.json` of the command, and what Python returns.

use serde_json::{Value, json};
use smalti::camera::{CameraError, ColorimetricObserver};
use smalti::design::Design;
use smalti::design::light::LightStatistics;
use smalti::design::screen::{CausedError, ClassLimits};
use smalti::design::screen::{ExpectedError, ScreenCondition};
use smalti::experiment::{DesignAnalysis, DesignTask, DesignedCfa, Designs, FrontPoint, Sensitivity};
use smalti::sensor::{Cfa, Filter};
use smalti::spectrum::Extrapolation;

use crate::ReportError;

/// Expected errors with the illuminants and luminances of their conditions.
fn expected(expected: &[ExpectedError], task: &DesignTask) -> Vec<Value> {
    let conditions =
        task.illuminants.iter().flat_map(|light| task.conditions.iter().map(move |c| (light.name(), c)));
    let of = |(e, (light, c)): (&ExpectedError, (String, &ScreenCondition))| {
        json!({
            "illuminant": light, "luminance_cd_m2": c.luminance_cd_m2, "cpsnr_db": e.cpsnr_db,
            "detail_db": e.detail_db, "delta_e_2000": e.delta_e_2000, "scielab": e.scielab, "time_s": e.time_s,
        })
    };
    expected.iter().zip(conditions).map(of).collect()
}

/// Everything that a search found and its analysis. `statistics` has an entry for each illuminant; `seconds` is how long the search took.
///
/// # Errors
/// When a curve of the camera does not cover its wavelengths.
pub fn results(
    task: &DesignTask,
    statistics: &[LightStatistics],
    found: &Designs,
    analysis: &DesignAnalysis,
    seconds: f64,
) -> Result<Value, ReportError> {
    let curve = |f: &Filter| Some(f.spectrum(task.camera.grid()).ok()?.values().to_vec());
    let light = task.illuminants.first().and_then(|light| light.photons(task.camera.grid()).ok());
    let observer = light.and_then(|light| ColorimetricObserver::new(&light).ok());
    // Not defined for an array that is blind to much of the light.
    let figures_of = |cfa: Cfa| task.camera.with_cfa(cfa).array_figures(observer.as_ref()?).ok();
    let design = |d: &DesignedCfa| {
        let best = d.best();
        let expected = expected(best.map_or(&[], |b| &b.expected), task);
        let arranged = d.design();
        // In the order of the letters of the tile.
        let transmittances: Option<Vec<Vec<f64>>> =
            arranged.as_ref().and_then(|a| a.filters.filters.iter().map(curve).collect());
        let figures = arranged.as_ref().and_then(|a| figures_of(a.cfa(task.camera.grid()).ok()?));
        json!({
            "figures": figures, "name": d.name, "published": d.is_published, "tile": arranged.as_ref().map(Design::tile),
            "filters": d.mosaic.channels(), "cost": best.map(|b| b.cost), "expected": expected,
            "costs_of_starts": d.found.iter().map(|f| f.cost).collect::<Vec<_>>(),
            "transmittances": transmittances,
        })
    };
    let point = |p: &FrontPoint| json!({ "shares": p.shares, "costs": p.costs, "design": design(&p.cfa) });
    let light = |s: &LightStatistics| {
        json!({
            "scenes": s.scenes(), "patches": s.patches(), "components": s.basis().len(),
            "energy_left_out": s.basis().left_out(), "luminance_error": s.luminance_error(),
        })
    };
    let own = &task.camera.sensor.cfa;
    let grid = task.camera.grid();
    let sensor = &task.camera.sensor;
    let mut shared = task.camera.optics.transmittance_on(grid).map_err(CameraError::from)?;
    if let Some(cut) = &sensor.ir_cut {
        shared = shared.times(&cut.resampled(grid, Extrapolation::Error)?)?;
    }
    Ok(json!({
        "name": task.name,
        "camera": task.camera.description().name,
        "illuminants": task.illuminants,
        "objective": task.objective,
        "search": task.search,
        "family": task.filters,
        "wavelengths_nm": grid.wavelengths_nm().collect::<Vec<_>>(),
        "quantum_efficiency": sensor.quantum_efficiency.resampled(grid, Extrapolation::Error)?.values(),
        "lens_and_ir_cut": shared.values(),
        "tolerance": task.tolerance,
        "rules": task.rules,
        "light": statistics.iter().map(light).collect::<Vec<_>>(),
        "seconds": seconds,
        "own": {
            "name": own.name(), "tile": tile(own), "filters": own.channels().len(),
            "letters": own.channels().iter().map(|c| c.name.clone()).collect::<Vec<_>>(),
            "figures": figures_of(own.clone()), "cost": found.goal.cost(&found.own), "expected": expected(&found.own, task),
            "transmittances": own.channels().iter().map(|c| c.transmittance.values()).collect::<Vec<_>>(),
        },
        "analysis": analysed(analysis, task),
        "searched": found.searched.iter().map(design).collect::<Vec<_>>(),
        "rivals": found.rivals.iter().map(design).collect::<Vec<_>>(),
        "front": {
            "aims": task.front.as_ref().map(|front| &front.aims),
            "filters": task.front.as_ref().is_some_and(|front| front.filters),
            "points": found.front.iter().map(point).collect::<Vec<_>>(),
        },
    }))
}

/// The tile of an array in letters: `a` for its first channel.
fn tile(cfa: &Cfa) -> String {
    let letter = |&cell: &u8| char::from(b'a' + cell % 26);
    let rows = cfa.mosaic().cells().chunks(cfa.mosaic().cols().max(1));
    rows.map(|row| row.iter().map(letter).collect::<String>()).collect::<Vec<_>>().join("/")
}

/// What the array that was found depends on and what limits it.
fn analysed(analysis: &DesignAnalysis, task: &DesignTask) -> Value {
    let of = |s: &Sensitivity| {
        json!({
            "filter": s.filter, "deviation": s.deviation, "words": s.deviation.to_string(),
            "expected": expected(&s.expected, task),
        })
    };
    let cause = |c: &CausedError| json!({ "squared_error": c.squared_error, "delta_e_2000": c.delta_e_2000 });
    let class = |(name, l): (&String, &ClassLimits)| {
        json!({
            "class": name, "patches": l.patches,
            "noise": cause(&l.noise), "sampling": cause(&l.sampling), "color": cause(&l.color),
        })
    };
    let condition = |(limits, c): (&Vec<ClassLimits>, &ScreenCondition)| {
        let classes = analysis.classes.iter().zip(limits).map(class).collect::<Vec<_>>();
        json!({ "luminance_cd_m2": c.luminance_cd_m2, "classes": classes })
    };
    json!({
        "expected": expected(&analysis.expected, task),
        "sensitivities": analysis.sensitivities.iter().map(of).collect::<Vec<_>>(),
        "limits": analysis.limits.iter().zip(&task.conditions).map(condition).collect::<Vec<_>>(),
    })
}
