//! The proof of a design: its array against others, each with learned pipelines, on scenes that were not used for the search.
//!
//! "It beats every published mosaic at every luminance" is a statement about many differences. Each has two intervals: that of a
//! single comparison, and one that holds together with those of all other differences of the proof
//! ([`Resamples::simultaneous`](crate::numeric::bootstrap::Resamples::simultaneous)). Findings rest on the latter, for gains and for losses. (To claim nothing but that all
//! are beaten, the single intervals suffice: an intersection–union test needs no correction [berger1982]. The claim here also says which ones
//! are beaten.)
//!
//! [berger1982]: https://doi.org/10.1080/00401706.1982.10487790

use serde::Serialize;

use super::entrants::{Entrant, score_entrants};
use super::picture_figures::PictureFigures;
use super::verdict::sign;
use super::{ComparisonSettings, Estimate, ExperimentError, Finding, Resources};
use crate::camera::{PICTURE_METRICS, TrainingSettings};
use crate::l3::Training;
use crate::numeric::bootstrap::{Interval, Resamples, mean};

/// The metrics of the statement that all others are beaten: CPSNR and CIEDE2000.
const STATED: usize = 2;

/// The proof of a design.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Proof {
    /// Side of the patches of the pipelines.
    pub patch: usize,
    /// The scenes.
    pub scenes: Vec<String>,
    /// Number of seeds of each scene.
    pub seeds: u64,
    /// First seed.
    pub seed: u64,
    /// The illuminant of scenes that have none of their own.
    pub illuminant: String,
    /// Mean luminances, cd/m².
    pub luminances_cd_m2: Vec<f64>,
    /// The array that was found.
    pub found: Scored,
    /// The others, and how the array that was found differs from each.
    pub rivals: Vec<Rival>,
}

/// The scores of a camera.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Scored {
    /// Its name.
    pub label: String,
    /// For each luminance, the means of [`PICTURE_METRICS`].
    pub means: Vec<[f64; PICTURE_METRICS.len()]>,
    /// For each luminance, the mean exposure time, s.
    pub times_s: Vec<f64>,
}

impl Scored {
    fn new(label: &str, figures: &PictureFigures) -> Self {
        Self {
            label: label.to_owned(),
            means: figures.lights.iter().map(|l| l.metrics.each_ref().map(|v| mean(v))).collect(),
            times_s: figures.lights.iter().map(|l| l.time_s).collect(),
        }
    }
}

/// Another array of a proof.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Rival {
    /// Its scores.
    #[serde(flatten)]
    pub scored: Scored,
    /// For each luminance and each of [`PICTURE_METRICS`], the lead of the array that was found.
    pub leads: Vec<[ProvedLead; PICTURE_METRICS.len()]>,
}

/// How much better the array that was found is, in the unit of the metric; below 0 it is worse.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ProvedLead {
    /// The difference of the means, with the interval for it alone.
    pub by: Estimate,
    /// Its interval that holds together with those of all differences of the proof; `None` for a single picture.
    pub simultaneous: Option<Interval>,
    /// What the simultaneous interval shows. A lead below 0 is a loss.
    pub finding: Finding,
}

/// What a difference shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ProofResult {
    /// The array that was found is better.
    Wins,
    /// No relevant difference is shown.
    Ties,
    /// The array that was found is worse.
    Loses,
}

impl ProvedLead {
    /// Whether the array that was found wins, ties or loses.
    #[must_use]
    pub fn result(&self) -> ProofResult {
        match self.finding {
            Finding::Lead if self.by.value > 0.0 => ProofResult::Wins,
            Finding::Lead => ProofResult::Loses,
            Finding::NoDifference | Finding::Negligible => ProofResult::Ties,
        }
    }
}

impl Proof {
    /// Whether the array that was found is better than every other one at every luminance, in CPSNR and in CIEDE2000.
    #[must_use]
    pub fn beats_all(&self) -> bool {
        let stated = self.rivals.iter().flat_map(|r| &r.leads).flat_map(|leads| &leads[..STATED]);
        !self.rivals.is_empty() && stated.into_iter().all(|lead| lead.result() == ProofResult::Wins)
    }

    /// The names of the others against which the result at a luminance by a metric is this, with their leads, in the order of the leads.
    #[must_use]
    pub fn with_result(&self, light: usize, metric: usize, result: ProofResult) -> Vec<(&str, ProvedLead)> {
        let lead = |r: &Rival| r.leads.get(light).and_then(|leads| leads.get(metric)).copied();
        let all = self.rivals.iter().filter_map(|r| Some((r.scored.label.as_str(), lead(r)?)));
        let mut found: Vec<_> = all.filter(|(_, lead)| lead.result() == result).collect();
        found.sort_by(|a, b| a.1.by.value.total_cmp(&b.1.by.value));
        found
    }
}

/// Scores the array that was found and others, each with pipelines of its own, and compares them; see [`score_entrants`].
///
/// # Errors
/// As [`score_entrants`].
pub fn prove(
    found: &Entrant,
    rivals: &[Entrant],
    settings: &ComparisonSettings,
    learning: (&TrainingSettings, &Training),
    resources: Resources<'_>,
) -> Result<Proof, ExperimentError> {
    let entrants: Vec<Entrant> = std::iter::once(found).chain(rivals).cloned().collect();
    let figures = score_entrants(&entrants, settings, learning, resources)?;
    let (own, others) = figures.split_first().ok_or(ExperimentError::NothingToCompare)?;
    let labels: Vec<&str> = rivals.iter().map(|r| r.label.as_str()).collect();
    Ok(Proof {
        patch: learning.0.side,
        scenes: settings.scenes.iter().map(|s| s.name().to_owned()).collect(),
        seeds: settings.seed_count.max(1),
        seed: settings.seed,
        illuminant: settings.illuminant.name(),
        luminances_cd_m2: settings.luminances_cd_m2.clone(),
        found: Scored::new(&found.label, own),
        rivals: leads(own, &labels, others, settings),
    })
}

/// The leads of a camera over others, whose intervals hold together.
fn leads(
    own: &PictureFigures,
    labels: &[&str],
    others: &[PictureFigures],
    settings: &ComparisonSettings,
) -> Vec<Rival> {
    let (scenes, seeds) = (settings.scenes.len(), settings.seeds().count());
    let resamples = (scenes * seeds > 1).then(|| Resamples::new(scenes, seeds, settings.seed));
    let lights = settings.luminances_cd_m2.len();
    let places: Vec<[usize; 3]> = (0..others.len())
        .flat_map(|r| (0..lights).flat_map(move |l| (0..PICTURE_METRICS.len()).map(move |m| [r, l, m])))
        .collect();
    let difference = |&[rival, light, metric]: &[usize; 3]| -> Vec<f64> {
        let [a, b] = [own, &others[rival]].map(|f| &f.lights[light].metrics[metric]);
        a.iter().zip(b).map(|(a, b)| sign(metric) * (a - b)).collect()
    };
    let family: Vec<Vec<f64>> = places.iter().map(difference).collect();
    let together = resamples.as_ref().map_or_else(Vec::new, |r| r.simultaneous(&family));
    let lead = |(i, ([_, _, metric], values)): (usize, (&[usize; 3], &Vec<f64>))| {
        let simultaneous = together.get(i).copied().flatten();
        let value = mean(values);
        let finding = match value {
            0.0 => Finding::NoDifference,
            _ => Finding::of(&Estimate { value, interval: simultaneous }, PICTURE_METRICS[*metric]),
        };
        let interval = resamples.as_ref().and_then(|r| r.interval(values));
        ProvedLead { by: Estimate { value, interval }, simultaneous, finding }
    };
    let all: Vec<ProvedLead> = places.iter().zip(&family).enumerate().map(lead).collect();
    let (metrics, _) = all.as_chunks::<{ PICTURE_METRICS.len() }>();
    let of =
        |((label, figures), leads): ((&&str, &PictureFigures), &[[ProvedLead; PICTURE_METRICS.len()]])| {
            Rival { scored: Scored::new(label, figures), leads: leads.to_vec() }
        };
    labels.iter().zip(others).zip(metrics.chunks(lights.max(1))).map(of).collect()
}
