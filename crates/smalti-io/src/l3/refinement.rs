//! The second stage of a learned table.

use serde_json::json;
use smalti::l3::{REFINEMENT_INPUTS, REFINEMENT_LINEAR_INPUTS, Refinement, RefinementAxes, RefinementClass};

use crate::IoError;
use crate::container::{Content, Opened};
use crate::error::At;

/// The string that states the axes of the second stage; tables of one stage lack it.
const AXES: &str = "refinement";
/// X, Y, Z.
const OUTPUTS: usize = 3;

/// Adds all that `read` needs.
pub(super) fn put(content: &mut Content, refinement: &Refinement) {
    let axes = refinement.axes();
    content.text(AXES, json!(axes));
    let classes = [axes.levels().count(), axes.structures()];
    let of_classes = |more: &[usize]| [&classes, more].concat();
    content.tensor("refinement_weights", &of_classes(&[OUTPUTS, REFINEMENT_INPUTS]), refinement.weights());
    content.tensor("refinement_offsets", &of_classes(&[OUTPUTS]), refinement.offsets().iter().copied());
    content.tensor("refinement_counts", &classes, refinement.classes().iter().map(|c| c.count));
    let learned = refinement.classes().iter().map(|c| u8::from(c.is_learned));
    content.tensor("refinement_learned", &classes, learned);
}

/// The second stage, if there is one, exactly as it was put.
pub(super) fn read(opened: &Opened<'_>) -> Result<Option<Refinement>, IoError> {
    if !opened.has(AXES) {
        return Ok(None);
    }
    let axes: RefinementAxes = opened.json(AXES)?;
    let classes = [axes.levels().count(), axes.structures()];
    let of_classes = |more: &[usize]| [&classes, more].concat();
    let weights = weights(opened, &of_classes(&[OUTPUTS]))?;
    let offsets = opened.shaped("refinement_offsets", &of_classes(&[OUTPUTS]))?;
    let counts: Vec<u64> = opened.shaped("refinement_counts", &classes)?;
    let learned: Vec<u8> = opened.shaped("refinement_learned", &classes)?;
    let class = |(i, (count, learned)): (usize, (u64, u8))| match learned {
        0 | 1 => Ok(RefinementClass { count, is_learned: learned == 1 }),
        other => {
            let found = format!("{other} at class {i} (counted from 0)");
            Err(opened.wrong("tensor 'refinement_learned'", found, "0 or 1"))
        }
    };
    let classes = counts.into_iter().zip(learned).enumerate().map(class).collect::<Result<_, _>>()?;
    Refinement::new(axes, classes, weights, offsets).map(Some).at(opened.path())
}

/// The weights of all inputs. Those of the inputs that tables before version 5 lack are 0.
fn weights(opened: &Opened<'_>, outputs: &[usize]) -> Result<Vec<f32>, IoError> {
    const NAME: &str = "refinement_weights";
    let of = |inputs: usize| [outputs, &[inputs]].concat();
    let (shape, stored): (Vec<usize>, Vec<f32>) = opened.any(NAME, outputs.len() + 1)?;
    if shape != of(REFINEMENT_LINEAR_INPUTS) {
        return opened.shaped(NAME, &of(REFINEMENT_INPUTS));
    }
    let absent = [0.0; REFINEMENT_INPUTS - REFINEMENT_LINEAR_INPUTS];
    let kernels = stored.chunks_exact(REFINEMENT_LINEAR_INPUTS);
    Ok(kernels.flat_map(|kernel| kernel.iter().copied().chain(absent)).collect())
}
