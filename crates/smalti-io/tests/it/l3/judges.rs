//! The `safetensors` package and NumPy read what we write, and a program that follows `docs/formats-l3.md` renders with it.

use serde_json::Value;
use smalti_io::l3::{write_npz, write_statistics, write_table};
use smalti_io::npy;

use super::fixtures::{bayer, picture_pipeline, pipeline, raw, recipes, second_stage, statistics};
use crate::python::python;

fn floats(v: &Value) -> Vec<f64> {
    v.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

#[test]
fn safetensors_and_numpy_see_the_table() {
    let dir = tempfile::tempdir().unwrap();
    for (i, r) in recipes().iter().enumerate() {
        let p = pipeline(r);
        let [table, archive, stats] = ["l3", "npz", "l3s"].map(|e| dir.path().join(format!("{i}.{e}")));
        write_table(&table, &p).unwrap();
        write_npz(&archive, &p).unwrap();
        let s = statistics(r, Some(r.levels));
        write_statistics(&stats, &s).unwrap();
        let Some(seen) = python("check_l3.py", "safetensors, numpy, blake3", &[&table, &archive, &stats])
        else {
            return;
        };
        let axes = p.axes();
        let classes = [axes.positions(), p.saturations().len(), axes.level_count(), axes.textures().count()];
        let (outputs, side) = (p.outputs().len(), axes.side());
        let shape = |more: &[usize]| serde_json::json!([&classes[..], more].concat());
        let positions = axes.positions();
        for (seen, what) in seen.iter().zip(["safetensors", "npz"]) {
            let arrays = &seen["arrays"];
            for (name, dtype, expected) in [
                ("weights", "float32", shape(&[outputs, side, side])),
                ("offsets", "float32", shape(&[outputs])),
                ("counts", "uint64", shape(&[])),
                ("origin", "uint8", shape(&[])),
                ("saturations", "uint32", serde_json::json!([classes[1]])),
                ("trained", "float32", serde_json::json!([positions, 2])),
                ("mosaic", "uint8", serde_json::json!([r.tile.0, r.tile.1])),
                ("cuts", "float32", serde_json::json!([axes.levels().len(), classes[2] - 1])),
            ] {
                assert_eq!(arrays[name]["dtype"], dtype, "{what} {name}");
                assert_eq!(arrays[name]["shape"], expected, "{what} {name}");
            }
            let weights = floats(&arrays["weights"]["values"]);
            assert!(weights.iter().copied().eq(p.kernels().weights.iter().map(|&w| f64::from(w))), "{what}");
            let counts = arrays["counts"]["values"].as_array().unwrap().iter().map(|v| v.as_u64().unwrap());
            assert!(counts.eq(p.classes().iter().map(|c| c.count)));
            let m = &seen["metadata"];
            assert_eq!(m["outputs"], serde_json::json!(p.outputs()), "{what}");
            assert_eq!(m["noise"]["constant"].as_f64(), Some(axes.noise().constant));
            assert_eq!(m["white_level"].as_f64(), Some(p.white_level()));
            assert_eq!(m["provenance"], serde_json::from_str::<Value>(p.provenance()).unwrap());
        }
        // The hash as the documentation defines it.
        assert_eq!(seen[0]["hash_is_right"], true);
        assert_eq!(seen[2]["hash_is_right"], true);
        let sums = floats(&seen[2]["arrays"]["sums"]["values"]);
        assert!(sums.iter().eq(s.classes().values().flat_map(|m| m.sums())));
        let keys = floats(&seen[2]["arrays"]["keys"]["values"]);
        assert_eq!(keys.len(), 4 * s.classes().len());
    }
}

/// The rendering formula of the documentation, in Python, against the one of the C header's test.
#[test]
fn the_documented_formula_renders() {
    let dir = tempfile::tempdir().unwrap();
    for r in recipes() {
        let p = pipeline(&r);
        let (table, image) = (dir.path().join("a.l3"), dir.path().join("raw.bin"));
        write_table(&table, &p).unwrap();
        let (_, samples) = raw(&r, 24, 31, [0, 0]);
        let bytes: Vec<u8> = samples.iter().flat_map(|s| s.to_le_bytes()).collect();
        std::fs::write(&image, bytes).unwrap();
        let size = [std::path::Path::new("24"), std::path::Path::new("31")];
        let Some(seen) = python("render_l3.py", "safetensors, numpy", &[&table, &image, size[0], size[1]])
        else {
            return;
        };
        let expected = super::c_header::definition(&p, &samples, 24, 31, [0, 0]);
        let classes: Vec<f64> = expected.iter().map(|(class, _)| *class as f64).collect();
        assert_eq!(floats(&seen[0]["classes"]), classes, "{r:?}");
        let outputs = floats(&seen[0]["outputs"]);
        for (i, (_, values)) in expected.iter().enumerate() {
            for (o, v) in values.iter().enumerate() {
                // Both in double precision.
                assert!((outputs[o * expected.len() + i] - v).abs() < 1e-9, "{i} {o}");
            }
        }
    }
}

/// The refinement of the documentation, in Python and in double precision, of a picture with corrected pixels. Where rounding moves a pixel across a
/// threshold, its class differs.
#[test]
fn the_documented_refinement_refines() {
    let dir = tempfile::tempdir().unwrap();
    let first = picture_pipeline();
    let (raw, _) = raw(&bayer(), 60, 71, [0, 0]);
    let both = super::c_header_float::best_of(&first, second_stage().axes().clone(), &raw);
    let [table, picture, samples] = ["a.l3", "xyz.npy", "raw.npy"].map(|name| dir.path().join(name));
    write_table(&table, &both).unwrap();
    let rendered = first.render_raw(&raw).unwrap().planes;
    npy::write(&picture, &[3, 60, 71], rendered.data()).unwrap();
    npy::write(&samples, &[60, 71], &raw.normalized()).unwrap();
    let Some(seen) = python("refine_l3.py", "safetensors, numpy", &[&table, &picture, &samples]) else {
        return;
    };
    let (documented, ours) = (floats(&seen[0]["outputs"]), both.render_raw(&raw).unwrap().planes);
    assert_eq!(documented.len(), ours.data().len());
    let far = documented.iter().zip(ours.data()).filter(|(a, b)| (*a - f64::from(**b)).abs() > 1e-5).count();
    assert!(far * 500 < documented.len(), "{far} of {}", documented.len());
    let mut alone = rendered.clone();
    both.refinement().unwrap().apply(&mut alone, None).unwrap();
    let compared = ours.data().iter().zip(alone.data()).filter(|(a, b)| (*a - *b).abs() > 1e-3).count();
    assert!(compared > 100, "{compared}");
    let moved = ours.data().iter().zip(rendered.data()).filter(|(a, b)| (*a - *b).abs() > 1e-3).count();
    assert!(moved * 2 > documented.len(), "{moved}");
}
