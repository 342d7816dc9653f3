//! What headers of both arithmetics state of the second stage.

use smalti::l3::{REFINEMENT_CORRECTED_REACH, Refinement, RefinementPicture};

use super::Header;

/// The rows of a picture that are kept.
const PICTURES: &str = include_str!("c/pictures.h");
/// The loop over an image.
const IMAGE: &str = include_str!("c/image.h");
/// X, Y and Z.
pub(super) const OUTPUTS: usize = 3;

impl Header<'_> {
    /// The last lines of the comment at the head, which begin with an end of a line; none without a second stage.
    pub(super) fn about_refinement(&self, refinement: Option<&Refinement>) -> String {
        let Some(refinement) = refinement else { return String::new() };
        let (lower, upper, (full, half)) = (self.lower, &self.upper, work(refinement));
        format!(
            "\n\n   {lower}_image renders with both stages, {lower}_fast_image with the first alone. The second stage keeps the latest rows of its\n   \
             pictures and no picture as a whole: {full} numbers for each column and {half} for every second one, of 4 bytes, {bytes} bytes per column.\n   \
             Its class = {upper}_STRUCTURES * level + structure.",
            bytes = 4 * full + 2 * half,
        )
    }

    /// Sizes of the axes and of the pictures.
    pub(super) fn refinement_axes(&mut self, refinement: &Refinement) {
        let (axes, upper) = (refinement.axes(), self.upper.clone());
        let (pictures, (full, half)) = (axes.pictures(), work(refinement));
        self.line("/* The second stage. */");
        self.define("PICTURES", pictures.len(), "");
        self.define("REFINED_LEVELS", axes.levels().count(), "");
        self.define("STRENGTHS", axes.strengths().len(), "");
        self.define("ORIENTATIONS", axes.orientations(), "of edges");
        let what = "flat, then for each strength texture and the orientations";
        self.define("STRUCTURES", axes.structures(), what);
        self.define("REFINED_CLASSES", axes.count(), "");
        self.define(
            "CORRECTED_REACH",
            REFINEMENT_CORRECTED_REACH,
            "rows around a pixel of the refined picture and of the raw image that its correction reads",
        );
        self.define(
            "WORK(cols)",
            format!("((size_t){full} * (size_t)(cols) + (size_t){half} * (((size_t)(cols) + 1) / 2))"),
            "",
        );
        self.line(
            "/* Of each picture: whether it has every second row and column, the rows beyond an output row that depends on it, the rows\n   \
             that are kept, and the distance of the neighbours it is averaged over (0: it is not). */",
        );
        let shape = format!("[{upper}_PICTURES]");
        let numbers = |of: fn(&RefinementPicture) -> usize| pictures.iter().map(of).collect::<Vec<_>>();
        self.table("uint8_t", "halved", &shape, &numbers(|p| usize::from(p.is_half)));
        self.table("int32_t", "beyond", &shape, &numbers(|p| p.beyond));
        self.table("int32_t", "kept", &shape, &numbers(|p| p.kept));
        self.table("int32_t", "steps", &shape, &numbers(|p| p.step.unwrap_or(0)));
    }

    /// The functions of the second stage: `stage` computes its pixels from pictures of a type of number, and `pixel` those of the first stage.
    pub(super) fn refined_image(&mut self, stage: &str, number: &str, pixel: &str) {
        self.code(&PICTURES.replace("@number@", number));
        self.code(stage);
        self.code(&IMAGE.replace("@number@", number).replace("@pixel@", pixel));
    }
}

/// The functions of the first stage, named by whether another stage follows.
pub(super) fn of_stage(code: &str, is_first_of_two: bool) -> String {
    let [of, first] =
        if is_first_of_two { [" with the first stage alone", "fast_image"] } else { ["", "image"] };
    code.replace("@of@", of).replace("@first@", first)
}

/// Numbers that the second stage keeps for each column, and for every second one.
fn work(refinement: &Refinement) -> (usize, usize) {
    let pictures = refinement.axes().pictures();
    let kept = |is_half: bool| -> usize {
        pictures.iter().filter(|p| p.is_half == is_half).map(|p| OUTPUTS * p.kept).sum()
    };
    const { assert!(REFINEMENT_CORRECTED_REACH == 4, "the C code has weights of four distances") }
    (kept(false) + OUTPUTS * (2 * REFINEMENT_CORRECTED_REACH + 1), kept(true))
}
