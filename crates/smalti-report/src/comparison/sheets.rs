//! The files of a comparison: pictures side by side, maps of differences, kernels and the page.

use rayon::prelude::*;
use smalti::experiment::{Contender, Outcome};
use smalti::l3::Pipeline;

use super::page::page;
use super::results::Comparison;
use super::{kernels, maps};
use crate::pictures::add;
use crate::{FileSink, ReportError, Sheet, names};

/// The page of a comparison or an evaluation, in its folder.
pub const PAGE: &str = "report.html";
/// The folder of the pictures.
pub const SIDE_BY_SIDE: &str = "side-by-side";
/// The end of the names of maps, after that of their picture.
const MAPS: &str = "-differences";
/// Pictures in a row.
const ACROSS: usize = 4;
/// The number of drawings made at a time; it bounds the memory.
const AT_ONCE: usize = 16;

/// What one or two files show.
enum Drawing<'a> {
    /// The pictures of a scene in one light, and the maps of their differences; their name without extension.
    Pictures { light: usize, scene: usize, name: &'a str },
    /// The kernels of a pipeline, and the file of its table.
    Kernels { of: &'a Contender<'a>, pipeline: &'a Pipeline, file: &'a str },
}

/// The name and the content of a file.
type Drawn = (String, Vec<u8>);

impl Comparison<'_> {
    /// All files but the document, relative to the folder. The tables of pipelines (`.l3`) are among them, which
    /// [`draw`](Self::draw) does not make.
    #[must_use]
    pub fn files(&self) -> Vec<String> {
        let pictures = self.picture_names().into_iter().flatten();
        let pictures = pictures.flat_map(|p| ["", MAPS].map(|what| format!("{SIDE_BY_SIDE}/{p}{what}.png")));
        let kernels = self.learned().into_iter().map(|(_, _, file)| format!("{file}-kernels.png"));
        let tables = self.tables().into_iter().map(|(file, _)| file);
        pictures.chain(kernels).chain(tables).chain([PAGE.to_owned()]).collect()
    }

    /// Makes the page and the pictures and stores them, the page last.
    ///
    /// # Errors
    /// When a picture cannot be drawn or stored.
    pub fn draw(&self, store: &mut FileSink<'_>) -> Result<(), ReportError> {
        let (names, learned) = (self.picture_names(), self.learned());
        let pictures = names.iter().enumerate().flat_map(|(light, names)| {
            names.iter().enumerate().map(move |(scene, name)| Drawing::Pictures { light, scene, name })
        });
        let kernels = learned.iter().map(|(of, pipeline, file)| Drawing::Kernels { of, pipeline, file });
        let drawings: Vec<_> = pictures.chain(kernels).collect();
        let draw = |part: &[Drawing<'_>]| -> Vec<Result<Vec<Drawn>, ReportError>> {
            part.par_iter().map(|drawing| self.drawn(drawing)).collect()
        };
        let mut parts = drawings.chunks(AT_ONCE);
        // The page has single-threaded parts.
        let (page, mut part) = rayon::join(|| page(self), || parts.next().map(draw));
        let page = page?;
        while let Some(drawn) = part {
            for files in drawn {
                files?.iter().try_for_each(|(name, png)| store(name, png)).map_err(ReportError::Sink)?;
            }
            part = parts.next().map(draw);
        }
        store(PAGE, page.as_bytes()).map_err(ReportError::Sink)
    }

    fn drawn(&self, drawing: &Drawing<'_>) -> Result<Vec<Drawn>, ReportError> {
        let png = |name: String, sheet: Sheet| -> Result<Drawn, ReportError> { Ok((name, sheet.png()?)) };
        match drawing {
            Drawing::Pictures { light, scene, name } => {
                let luminance_cd_m2 = self.lights()[*light].luminance_cd_m2;
                let title = format!("{}, {luminance_cd_m2} cd/m²", self.scene_label(*scene));
                let pictures = self.side_by_side(&title, *light, *scene)?;
                let scored =
                    self.of_scene(*light, *scene).map(|(contender, s)| (contender.name(), &s.scores));
                let maps = maps::sheet(title, &scored.collect::<Vec<_>>());
                let pictures = png(format!("{SIDE_BY_SIDE}/{name}.png"), pictures)?;
                Ok(vec![pictures, png(format!("{SIDE_BY_SIDE}/{name}{MAPS}.png"), maps)?])
            }
            Drawing::Kernels { of, pipeline, file } => {
                let sheet = kernels::sheet(of.camera, of.label, pipeline)?;
                Ok(vec![png(format!("{file}-kernels.png"), sheet)?])
            }
        }
    }

    /// The reference of a scene in one light and the pictures of all contenders beside it.
    fn side_by_side(&self, title: &str, light: usize, scene: usize) -> Result<Sheet, ReportError> {
        let mut sheet = Sheet::new(ACROSS).title(title);
        for (i, (contender, scored)) in self.of_scene(light, scene).enumerate() {
            let scored = &scored.scores;
            if i == 0 {
                sheet = add(sheet, "reference", &self.as_seen(scored, &scored.reference)?);
            }
            let scores = &scored.scores;
            let caption = format!(
                "{} {}\n{:.1} dB, S-CIELAB {:.1}",
                contender.label,
                contender.method(),
                scores.cpsnr_db,
                scores.scielab_mean
            );
            sheet = add(sheet, caption, &self.as_seen(scored, &scored.picture)?);
        }
        Ok(sheet)
    }

    /// Names of the pictures without extension, for each light one for each scene.
    fn picture_names(&self) -> Vec<Vec<String>> {
        let of_light = |light: &Outcome| {
            let files = names::file_names(self.scene_labels.iter().map(String::as_str));
            files.into_iter().map(|f| format!("{f}-{}-cd-m2", light.luminance_cd_m2)).collect()
        };
        self.lights().iter().map(of_light).collect()
    }
}
