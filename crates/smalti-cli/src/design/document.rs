//! `results.json` of a search.

use serde_json::{Value, json};
use smalti::design::Design;
use smalti::design::light::LightStatistics;
use smalti::design::screen::{ExpectedError, ScreenCondition};
use smalti::experiment::{DesignTask, DesignedCfa, Designs, FrontPoint};

/// Expected errors with the illuminants and luminances of their conditions.
fn expected(expected: &[ExpectedError], task: &DesignTask) -> Vec<Value> {
    let conditions =
        task.illuminants.iter().flat_map(|light| task.conditions.iter().map(move |c| (light.name(), c)));
    let of = |(e, (light, c)): (&ExpectedError, (String, &ScreenCondition))| {
        json!({
            "illuminant": light, "luminance_cd_m2": c.luminance_cd_m2, "cpsnr_db": e.cpsnr_db,
            "detail_db": e.detail_db, "delta_e_2000": e.delta_e_2000, "time_s": e.time_s,
        })
    };
    expected.iter().zip(conditions).map(of).collect()
}

/// Everything that was found.
pub(super) fn document(
    task: &DesignTask,
    statistics: &[LightStatistics],
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
    let point = |p: &FrontPoint| json!({ "shares": p.shares, "costs": p.costs, "design": design(&p.cfa) });
    let light = |s: &LightStatistics| {
        json!({
            "scenes": s.scenes(), "patches": s.patches(), "components": s.basis().len(),
            "energy_left_out": s.basis().left_out(), "luminance_error": s.luminance_error(),
        })
    };
    json!({
        "name": task.name,
        "camera": task.camera.description().name,
        "illuminants": task.illuminants.iter().map(|light| light.name()).collect::<Vec<_>>(),
        "objective": task.objective,
        "search": task.search,
        "family": task.filters,
        "wavelengths_nm": task.camera.grid().wavelengths_nm().collect::<Vec<_>>(),
        "tolerance": task.tolerance,
        "rules": task.rules,
        "light": statistics.iter().map(light).collect::<Vec<_>>(),
        "seconds": seconds,
        "own": { "cost": found.goal.cost(&found.own), "expected": expected(&found.own, task) },
        "searched": found.searched.iter().map(design).collect::<Vec<_>>(),
        "rivals": found.rivals.iter().map(design).collect::<Vec<_>>(),
        "front": {
            "aims": task.front.as_ref().map(|front| &front.aims),
            "points": found.front.iter().map(point).collect::<Vec<_>>(),
        },
    })
}
