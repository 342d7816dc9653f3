//! Tables and statistics come back as they were, and nothing else is taken for them.

use std::path::Path;

use safetensors::tensor::TensorView;
use safetensors::{Dtype, SafeTensors};
use smalti::l3::{
    Pair, Pipeline, Quality, REFINEMENT_INPUTS, REFINEMENT_LINEAR_INPUTS, Refinement, RefinementClass,
};
use smalti::numeric::Planes;
use smalti_io::IoError;
use smalti_io::l3::{
    read_statistics, read_table, statistics_from_bytes, table_from_bytes, write_npz, write_statistics,
    write_table,
};

use super::fixtures::{
    axes, bayer, outputs, parts, picture_pipeline, pipeline, raw, recipes, second_stage, statistics,
};

fn bits(p: &Pipeline) -> Vec<u32> {
    p.kernels().weights.iter().chain(&p.kernels().offsets).map(|v| v.to_bits()).collect()
}

fn bytes_of(p: &Pipeline) -> Vec<u8> {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.l3");
    write_table(&path, p).unwrap();
    std::fs::read(path).unwrap()
}

fn error(bytes: &[u8]) -> IoError {
    table_from_bytes(bytes, Path::new("a.l3")).unwrap_err()
}

#[test]
fn tables_come_back_bit_for_bit() {
    let dir = tempfile::tempdir().unwrap();
    for r in recipes() {
        let before = pipeline(&r);
        let path = dir.path().join("a.l3");
        write_table(&path, &before).unwrap();
        let after = read_table(&path).unwrap();
        assert_eq!(before, after, "{r:?}");
        // Equal numbers may differ in their bits: −0 does from 0.
        assert_eq!(bits(&before), bits(&after));
        // And equal tables make equal files.
        assert_eq!(std::fs::read(&path).unwrap(), bytes_of(&after));
    }
}

/// Tables of version 2 state no structures: they have three strengths and four orientations.
#[test]
fn a_second_stage_of_version_2_is_read() {
    let axes = second_stage().axes().clone().with_structures(vec![0.02, 0.1, 0.5], 4).unwrap();
    let classes = vec![RefinementClass { count: 9, is_learned: true }; axes.count()];
    let weights = vec![0.02; axes.count() * 3 * REFINEMENT_INPUTS];
    let offsets = vec![0.001; axes.count() * 3];
    let second = Refinement::new(axes, classes, weights, offsets).unwrap();
    let both = picture_pipeline().with_refinement(Some(second)).unwrap();
    // Both fields, and the spaces that replace them.
    let bytes = bytes_of(&both);
    let text = String::from_utf8_lossy(&bytes);
    let first = text.find(r#",\"orientations\":4"#).unwrap();
    let stated = &text[first..first + text[first..].find('}').unwrap()];
    let earlier = with(&bytes, stated, &" ".repeat(stated.len()));
    let earlier = with(&earlier, r#""version":"5""#, r#""version":"2""#);
    assert_eq!(table_from_bytes(&restated(&earlier), Path::new("a.l3")).unwrap(), both);
}

/// Tables before version 5 lack the weights of the roots, which are then 0.
#[test]
fn a_second_stage_of_version_4_is_read() {
    let axes = second_stage().axes().clone().with_structures(vec![0.5], 4).unwrap();
    let classes = vec![RefinementClass { count: 9, is_learned: true }; axes.count()];
    let is_root = |i: usize| i % REFINEMENT_INPUTS >= REFINEMENT_LINEAR_INPUTS;
    let weight = |i: usize| if is_root(i) { 0.0 } else { 0.001 * (i % 1009) as f32 };
    let weights: Vec<f32> = (0..axes.count() * 3 * REFINEMENT_INPUTS).map(weight).collect();
    let second = Refinement::new(axes.clone(), classes, weights, vec![0.001; axes.count() * 3]).unwrap();
    let both = picture_pipeline().with_refinement(Some(second)).unwrap();
    let bytes = bytes_of(&both);
    // The file without these weights.
    let (_, header) = SafeTensors::read_metadata(&bytes).unwrap();
    let opened = SafeTensors::deserialize(&bytes).unwrap();
    let shape = [axes.levels().count(), axes.structures(), 3, REFINEMENT_LINEAR_INPUTS];
    let kernels = opened.tensor("refinement_weights").unwrap().data().chunks_exact(4 * REFINEMENT_INPUTS);
    let linear =
        kernels.flat_map(|kernel| &kernel[..4 * REFINEMENT_LINEAR_INPUTS]).copied().collect::<Vec<u8>>();
    let tensors = opened.iter().map(|(name, view)| match name {
        "refinement_weights" => (name, TensorView::new(Dtype::F32, shape.to_vec(), &linear).unwrap()),
        _ => (name, view),
    });
    let earlier = safetensors::serialize(tensors, header.metadata().clone()).unwrap();
    let earlier = with(&earlier, r#""version":"5""#, r#""version":"4""#);
    assert_eq!(table_from_bytes(&restated(&earlier), Path::new("a.l3")).unwrap(), both);
}

/// A second stage comes back bit for bit and is version 5 of the format; tables of one stage stay version 1.
#[test]
fn a_second_stage_comes_back_bit_for_bit() {
    let first = picture_pipeline();
    let version = |bytes: &[u8], n: u32| {
        let text = format!(r#""version":"{n}""#);
        bytes.windows(text.len()).any(|w| w == text.as_bytes())
    };
    assert!(version(&bytes_of(&first), 1));
    let both = first.clone().with_refinement(Some(second_stage())).unwrap();
    let bytes = bytes_of(&both);
    assert!(version(&bytes, 5));
    let read = table_from_bytes(&bytes, Path::new("a.l3")).unwrap();
    assert_eq!(read, both);
    assert_eq!(read.quality(), Quality::Best);
    assert_ne!(read, first);
    // Neither damage nor nonsense behind a right hash is taken for it.
    let forged = |from: &str, to: &str| {
        let bad = with(&bytes, from, to);
        match error(&bad) {
            IoError::Damaged { found, stated, .. } => error(&with(&bad, &stated, &found)).to_string(),
            other => other.to_string(),
        }
    };
    let reason = forged(r#"\"orientations\":8"#, r#"\"orientations\":5"#);
    assert!(reason.contains("5 orientations of the second stage; expected 4 or 8"), "{reason}");
    let reason = forged(r#"\"noise\":[0.0000"#, r#"\"noise\":[-0.000"#);
    assert!(reason.contains("the variance of the noise at Y = 0 is -"), "{reason}");
    let reason = forged("refinement_offsets", "refinement_offzets");
    assert!(reason.contains("refinement_offsets"), "{reason}");
}

#[test]
fn statistics_come_back_bit_for_bit_and_go_on() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.l3s");
    for r in recipes() {
        for levels in [None, Some(r.levels)] {
            let before = statistics(&r, levels);
            write_statistics(&path, &before).unwrap();
            assert_eq!(before, read_statistics(&path).unwrap());
        }
    }
    // Of nothing yet, then of a pair, then of another: as if it had never left memory.
    let r = bayer();
    let pairs = [raw(&r, 40, 60, [0, 0]).0, raw(&r, 31, 45, [1, 0]).0];
    let mut whole = smalti::l3::Statistics::new(axes(&r), outputs(&r), false).unwrap();
    let mut parts = whole.clone();
    for raw in &pairs {
        let (rows, cols) = (raw.rows(), raw.cols());
        let target = raw.normalized().repeat(3);
        let target = Planes::new(rows, cols, 3, target).unwrap();
        let pair = Pair { raw, seen: None, target: &target };
        write_statistics(&path, &parts).unwrap();
        parts = read_statistics(&path).unwrap();
        whole.add(&pair).unwrap();
        parts.add(&pair).unwrap();
    }
    assert!(whole.count() > 0);
    assert_eq!(whole, parts);
}

/// Any changed bit, anywhere, is seen: in numbers and names by the hash, in the structure by what no longer fits.
#[test]
fn damage_is_found_wherever_it_is() {
    let good = bytes_of(&pipeline(&bayer()));
    assert!(table_from_bytes(&good, Path::new("a")).is_ok());
    let header = 8 + u64::from_le_bytes(*good.first_chunk().unwrap()) as usize;
    // The blanks that fill the header up to whole words say nothing.
    let text_end = good[..header].iter().rposition(|&b| b != b' ').unwrap() + 1;
    // All of the header, and the data in steps that meet every array.
    let places = (0..text_end).chain((header..good.len()).step_by(97)).chain([good.len() - 1]);
    for i in places {
        for bit in [0, 7] {
            let mut bad = good.clone();
            bad[i] ^= 1 << bit;
            let result = table_from_bytes(&bad, Path::new("a.l3"));
            let error = result.err().unwrap_or_else(|| panic!("bit {bit} of byte {i} went unseen"));
            assert!(error.to_string().starts_with("a.l3: "), "{error}");
            if i >= header {
                assert!(matches!(error, IoError::Damaged { .. }), "{error}");
            }
        }
    }
    for len in 0..good.len().min(header + 200) {
        assert!(table_from_bytes(&good[..len], Path::new("a.l3")).is_err(), "{len}");
    }
    let mut longer = good;
    longer.push(0);
    assert!(matches!(error(&longer), IoError::Decode { .. }));
}

/// The bytes with a text replaced by one as long.
/// A changed file that states its own hash.
fn restated(changed: &[u8]) -> Vec<u8> {
    match error(changed) {
        IoError::Damaged { found, stated, .. } => with(changed, &stated, &found),
        other => panic!("{other}"),
    }
}

fn with(bytes: &[u8], from: &str, to: &str) -> Vec<u8> {
    assert_eq!(from.len(), to.len());
    let at =
        bytes.windows(from.len()).position(|w| w == from.as_bytes()).unwrap_or_else(|| panic!("no {from}"));
    [&bytes[..at], to.as_bytes(), &bytes[at + from.len()..]].concat()
}

#[test]
fn what_is_wrong_is_said() {
    let good = bytes_of(&pipeline(&bayer()));
    let message = |bytes: &[u8]| error(bytes).to_string();
    assert_eq!(
        message(b"PK\x03\x04 something else entirely"),
        "a.l3: expected a learned table of Smalti (.l3, a safetensors file)"
    );
    let have = good.len();
    let cut = message(&good[..have - 10]);
    assert!(cut.starts_with("a.l3: its arrays needs") && cut.contains("cut short"), "{cut}");
    let cut = message(&good[..300]);
    assert!(cut.starts_with("a.l3: its header needs") && cut.contains("cut short"), "{cut}");
    let other = message(&with(&good, r#""version":"1""#, r#""version":"6""#));
    assert_eq!(
        other,
        "a.l3: it is version 6 of the smalti-l3-table format; version 1 or 2 or 3 or 4 or 5 is read here"
    );
    let other = message(&with(&good, "smalti-l3-table", "someone-s-table"));
    assert_eq!(other, "a.l3: format is 'someone-s-table'; expected 'smalti-l3-table'");
    let damaged = message(&with(&good, r#""white_level":"1023""#, r#""white_level":"1032""#));
    assert!(damaged.contains("it is damaged"), "{damaged}");
    // Statistics are no table, and the other way round.
    let found = statistics_from_bytes(&good, Path::new("a")).unwrap_err().to_string();
    assert_eq!(found, "a: format is 'smalti-l3-table'; expected 'smalti-l3-statistics'");
    let missing = read_table(Path::new("no-such.l3")).unwrap_err().to_string();
    assert!(missing.starts_with("cannot read no-such.l3"), "{missing}");
}

/// Another program may write what has the right hash and no sense.
#[test]
fn what_does_not_fit_is_refused_behind_a_right_hash() {
    let good = bytes_of(&pipeline(&bayer()));
    // The error names the hash that would be right: a forger's way to it.
    let forged = |from: &str, to: &str| {
        let bad = with(&good, from, to);
        match error(&bad) {
            IoError::Damaged { found, stated, .. } => error(&with(&bad, &stated, &found)).to_string(),
            other => other.to_string(),
        }
    };
    for (from, to, expected) in [
        (
            r#""side":"5""#,
            r#""side":"7""#,
            "tensor 'weights' is of shape [4, 4, 5, 2, 3, 5, 5]; expected shape [4, 4, 5, 2, 3, 7, 7]",
        ),
        (r#""side":"5""#, r#""side":"4""#, "the side of a patch is 4; expected 3, 5, 7, 9 or 11"),
        (r#""side":"5""#, r#""side":"x""#, "side is 'x'; expected a number"),
        (r#""clip":"0.98""#, r#""clip":"9.98""#, "the response that is clipped is 9.98; expected 0.001 to 1"),
        (r#""clip":"0.98""#, r#""clap":"0.98""#, "clip is missing; expected a string"),
        (r#""clip":"0.98""#, r#""clip":"-NaN""#, "the response that is clipped is NaN; expected 0.001 to 1"),
        (
            "flat-texture",
            "flat-textile",
            "textures is 'flat-textile'; expected 'none', 'flat-texture' or 'oriented'",
        ),
        (
            r#""white_level":"1023""#,
            r#""white_level":"0.23""#,
            "white level 0.23 must lie above black level 64",
        ),
        (r#""white_level":"1023""#, r#""white_level":"inf ""#, "white_level is 'inf '; expected a number"),
        (r#"[\"X\",\"Y\","#, r#"[\"X\",\"Y\";"#, "outputs is invalid"),
        (r#"[\"C0\",\"C1\",\"C2\"]"#, r#"[\"C0\",\"C1,    C2\"]"#, "2 channel names for 3 channels"),
        (r#"\"constant\":3"#, r#"\"constamt\":3"#, "noise is invalid"),
        (
            r#""saturations":{"dtype":"U32","shape":[4]"#,
            r#""saturations":{"dtype":"F32","shape":[4]"#,
            "tensor 'saturations' is F32 [4]; expected U32 of 1 axes",
        ),
    ] {
        let message = forged(from, to);
        assert!(message.starts_with("a.l3: ") && message.contains(expected), "{message}\n{expected}");
    }
}

/// Where there are no cuts, sets of them without number take no bytes, and must take no memory.
#[test]
fn arrays_of_no_bytes_are_counted_before_they_are_made() {
    let good = bytes_of(&pipeline(&recipes()[3]));
    let bad = with(&good, r#""shape":[3,0],"data_offsets""#, r#""shape":[9,0],"data_offsets""#);
    let IoError::Damaged { found, stated, .. } = error(&bad) else { panic!() };
    let message = error(&with(&bad, &stated, &found)).to_string();
    assert_eq!(message, "a.l3: tensor 'cuts' is of shape [9, 0]; expected 1 or 3 sets");
}

/// What the library refuses to make is refused in a file too.
#[test]
fn saturated_channels_are_those_of_the_mosaic() {
    let mut parts = parts(&bayer());
    parts.saturations = vec![0, 1, 2, 8];
    assert!(Pipeline::from_parts(parts).unwrap_err().to_string().contains("beyond the 3 there are"));
}

#[test]
fn archives_are_equal_for_equal_tables() {
    let dir = tempfile::tempdir().unwrap();
    let bytes = ["a.npz", "b.npz"].map(|name| {
        write_npz(&dir.path().join(name), &pipeline(&bayer())).unwrap();
        std::fs::read(dir.path().join(name)).unwrap()
    });
    assert_eq!(bytes[0], bytes[1]);
    assert!(write_npz(dir.path(), &pipeline(&bayer())).is_err());
}
