//! The learned table, `.l3`.

use std::path::Path;

use serde_json::json;
use smalti::l3::{Class, Kernels, Origin, Pipeline, PipelineParts};

use super::{axes, refinement};
use crate::container::{Content, Opened};
use crate::error::At;
use crate::{IoError, Limits, file};

const FORMAT: &str = "smalti-l3-table";
/// Versions from 2 on may have a second stage; tables without one are still written as version 1, which earlier programs read.
const VERSIONS: [&str; 5] = ["1", "2", "3", "4", "5"];

/// Writes a pipeline, to be read back bit for bit. Equal pipelines give equal files.
///
/// # Errors
/// [`IoError::Write`].
pub fn write_table(path: &Path, pipeline: &Pipeline) -> Result<(), IoError> {
    content(pipeline).write(path)
}

/// The bytes that [`write_table`] writes; `path` is only named in errors.
///
/// # Errors
/// [`IoError::Write`] when the pipeline has more classes than a file may have.
pub fn table_to_bytes(pipeline: &Pipeline, path: &Path) -> Result<Vec<u8>, IoError> {
    content(pipeline).into_bytes(path)
}

/// The bytes of the file in pieces.
pub(crate) fn table_pieces(pipeline: &Pipeline) -> Result<Vec<Vec<u8>>, IoError> {
    content(pipeline).into_pieces(Path::new("pipeline"))
}

/// Strings and arrays of a pipeline, as `docs/formats-l3.md` lists them.
pub(super) fn content(pipeline: &Pipeline) -> Content {
    let axes = pipeline.axes();
    let mut content = Content::default();
    content.text("format", FORMAT);
    content.text("version", VERSIONS[if pipeline.refinement().is_some() { 4 } else { 0 }]);
    axes::put(&mut content, axes);
    content.text("channel_names", json!(pipeline.channel_names()));
    content.text("outputs", json!(pipeline.outputs()));
    content.text("black_level", pipeline.black_level());
    content.text("white_level", pipeline.white_level());
    content.text("white", json!(pipeline.white()));
    content.text("provenance", pipeline.provenance());
    let classes =
        [axes.positions(), pipeline.saturations().len(), axes.level_count(), axes.textures().count()];
    let [outputs, side] = [pipeline.outputs().len(), axes.side()];
    let kernels = pipeline.kernels();
    let of_classes = |more: &[usize]| [&classes, more].concat();
    content.tensor("weights", &of_classes(&[outputs, side, side]), kernels.weights.iter().copied());
    content.tensor("offsets", &of_classes(&[outputs]), kernels.offsets.iter().copied());
    content.tensor("counts", &classes, pipeline.classes().iter().map(|c| c.count));
    content.tensor("origin", &classes, pipeline.classes().iter().map(|c| c.origin as u8));
    content.tensor("saturations", &[classes[1]], pipeline.saturations().iter().copied());
    content.tensor("trained", &[classes[0], 2], pipeline.trained().iter().flatten().copied());
    if let Some(second) = pipeline.refinement() {
        refinement::put(&mut content, second);
    }
    content
}

/// Reads a pipeline.
///
/// # Errors
/// When the file cannot be read or is larger than the default of [`Limits`], is no safetensors file or none of this kind and
/// version, is cut short or damaged, or its parts do not fit each other.
pub fn read_table(path: &Path) -> Result<Pipeline, IoError> {
    table_from_bytes(&file::read(path, Limits::default().file_bytes)?, path)
}

/// As [`read_table`], from memory; `path` is only named in errors.
pub fn table_from_bytes(bytes: &[u8], path: &Path) -> Result<Pipeline, IoError> {
    let opened = Opened::new(bytes, path, super::EXPECTED, (FORMAT, &VERSIONS))?;
    let axes = axes::read(&opened)?;
    let outputs: Vec<String> = opened.json("outputs")?;
    let (_, saturations) = opened.any::<u32>("saturations", 1)?;
    let classes = [axes.positions(), saturations.len(), axes.level_count(), axes.textures().count()];
    let of_classes = |more: &[usize]| [&classes, more].concat();
    let weights = opened.shaped("weights", &of_classes(&[outputs.len(), axes.side(), axes.side()]))?;
    let offsets = opened.shaped("offsets", &of_classes(&[outputs.len()]))?;
    let counts: Vec<u64> = opened.shaped("counts", &classes)?;
    let origins: Vec<u8> = opened.shaped("origin", &classes)?;
    let trained: Vec<f32> = opened.shaped("trained", &[classes[0], 2])?;
    let classes = counts.into_iter().zip(origins).enumerate().map(|(i, (count, code))| {
        let expected = || format!("a code from 0 to {}", Origin::ALL.len() - 1);
        let origin = Origin::from_code(code).ok_or_else(|| {
            opened.wrong("tensor 'origin'", format!("{code} at class {i} (counted from 0)"), expected())
        })?;
        Ok(Class { count, origin })
    });
    let (white, second) = (opened.json("white")?, refinement::read(&opened)?);
    Pipeline::from_parts(PipelineParts {
        saturations,
        outputs,
        channel_names: opened.json("channel_names")?,
        black_level: opened.number("black_level")?,
        white_level: opened.number("white_level")?,
        trained: trained.as_chunks().0.to_vec(),
        classes: classes.collect::<Result<_, IoError>>()?,
        kernels: Kernels { weights, offsets },
        provenance: opened.text("provenance")?.to_owned(),
        axes,
    })
    .and_then(|p| p.with_white(white).with_refinement(second))
    .at(path)
}
