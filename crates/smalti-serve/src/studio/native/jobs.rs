//! Which function does which job, and what is checked before.

use smalti::experiment::Progress as _;
use smalti_io::studio;

use super::error::JobError;
use super::material::{Found, Native};
use super::message::{Job, Request, ensure_luminances};
use super::watch::Watch;
use super::{capture, design, report, search, sweep};

/// Does a job.
pub(super) fn run(native: &Native, job: &Job, watch: &Watch) -> Result<Found, JobError> {
    if watch.is_stopped() {
        return Err(JobError::Stopped);
    }
    job.check()?;
    let found = match job {
        Job::Table { design, quality } => capture::table(native, design, *quality, watch),
        Job::Capture(capture) => capture::capture(native, capture, watch),
        Job::Search(search) => search::search(native, search, watch),
        Job::Report(wanted) => report::report(native, wanted, watch),
        Job::Sweep(wanted) => sweep::sweep(native, wanted, watch),
    };
    // A result that comes after the wish to end it is none.
    if watch.is_stopped() { Err(JobError::Stopped) } else { found }
}

impl Request {
    /// Checks everything that is known before the work begins: that designs are cameras, scenes those of the studio, and luminances within their range.
    ///
    /// # Errors
    /// With the first that is wrong.
    pub fn check(&self) -> Result<(), JobError> {
        match self {
            Self::Start { job, .. } => job.check(),
            Self::Cancel { .. } => Ok(()),
        }
    }
}

impl Job {
    fn check(&self) -> Result<(), JobError> {
        let scene = |id: &str| match studio::catalogue_name(id) {
            Some(_) => Ok(()),
            None => Err(JobError::Wrong(format!("there is no scene {id:?} in the studio"))),
        };
        match self {
            Self::Table { design, .. } => design::camera(design).map(drop),
            Self::Capture(capture) => {
                scene(&capture.scene)?;
                ensure_luminances(&[capture.luminance_cd_m2])?;
                design::camera(&capture.design).map(drop)
            }
            Self::Search(search) => {
                ensure_luminances(&search.luminances_cd_m2)?;
                search::locks(&design::camera(&search.design)?, search).map(drop)
            }
            Self::Sweep(wanted) => {
                sweep::set(&wanted.set)?;
                ensure_luminances(&wanted.luminances_cd_m2)?;
                design::camera(&wanted.design).map(drop)
            }
            Self::Report(report) => {
                report.scene.as_deref().map_or(Ok(()), scene)?;
                ensure_luminances(&report.luminances_cd_m2)?;
                std::iter::once(&report.design)
                    .chain(&report.rival)
                    .try_for_each(|design| design::camera(design).map(drop))
            }
        }
    }
}
