//! `results.json` of a search.

use serde_json::{Value, json};
use smalti::design::Design;
use smalti::design::light::LightStatistics;
use smalti::design::screen::{ExpectedError, ScreenCondition};
use smalti::experiment::{DesignTask, DesignedCfa, Designs};

/// Expected errors with the luminances of their conditions.
fn expected(expected: &[ExpectedError], task: &DesignTask) -> Vec<Value> {
    let of = |(e, c): (&ExpectedError, &ScreenCondition)| {
        json!({
            "luminance_cd_m2": c.luminance_cd_m2, "cpsnr_db": e.cpsnr_db,
            "delta_e_2000": e.delta_e_2000, "time_s": e.time_s,
        })
    };
    expected.iter().zip(&task.conditions).map(of).collect()
}

/// Everything that was found.
pub(super) fn document(
    task: &DesignTask,
    statistics: &LightStatistics,
    found: &Designs,
    seconds: f64,
) -> Value {
    let design = |d: &DesignedCfa| {
        let best = d.best();
        let expected = expected(best.map_or(&[], |b| &b.expected), task);
        let arranged = d.design();
        json!({
            "name": d.name, "published": d.is_published, "tile": arranged.as_ref().map(Design::tile),
            "filters": d.mosaic.channels(), "cost": best.map(|b| b.cost), "expected": expected,
            "costs_of_starts": d.found.iter().map(|f| f.cost).collect::<Vec<_>>(),
            "transmittances": best.map(|b| b.transmittances.iter().map(|t| t.values().to_vec()).collect::<Vec<_>>()),
        })
    };
    json!({
        "name": task.name,
        "camera": task.camera.description().name,
        "illuminant": task.illuminant.name(),
        "objective": task.objective,
        "search": task.search,
        "family": task.filters,
        "wavelengths_nm": task.camera.grid().wavelengths_nm().collect::<Vec<_>>(),
        "light": {
            "scenes": statistics.scenes(), "patches": statistics.patches(),
            "components": statistics.basis().len(), "energy_left_out": statistics.basis().left_out(),
            "luminance_error": statistics.luminance_error(),
        },
        "seconds": seconds,
        "own": { "cost": task.objective.cost(&found.own), "expected": expected(&found.own, task) },
        "searched": found.searched.iter().map(design).collect::<Vec<_>>(),
        "rivals": found.rivals.iter().map(design).collect::<Vec<_>>(),
    })
}
