//! Progress on standard error: a bar with an estimate on a terminal, nothing when piped or quiet.

use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Steps of known number, the current one named.
pub(crate) struct Progress {
    bar: ProgressBar,
    quiet: bool,
}

impl Progress {
    pub(crate) fn new(steps: u64, quiet: bool) -> Self {
        // A terminal that only prints would keep each state of the bar.
        let dumb = std::env::var_os("TERM").is_some_and(|t| t == "dumb");
        let bar = if quiet || dumb {
            ProgressBar::hidden()
        } else {
            ProgressBar::with_draw_target(Some(steps), ProgressDrawTarget::stderr())
        };
        if let Ok(style) =
            ProgressStyle::with_template("{bar:24} {pos}/{len} {msg}  {elapsed}, about {eta} left")
        {
            bar.set_style(style);
        }
        bar.enable_steady_tick(Duration::from_millis(200));
        Self { bar, quiet }
    }

    /// Many short steps, of which the rate matters.
    pub(crate) fn of_many(steps: u64, quiet: bool) -> Self {
        let progress = Self::new(steps, quiet);
        let template = "{bar:24} {human_pos}/{human_len} {per_sec:.0}  {msg}  {elapsed}, about {eta} left";
        if let Ok(style) = ProgressStyle::with_template(template) {
            progress.bar.set_style(style);
        }
        progress
    }

    /// Names the step that begins.
    pub(crate) fn begin(&self, what: impl Into<String>) {
        self.bar.set_message(what.into());
    }

    /// There is more to do than was thought: so many steps.
    pub(crate) fn more(&self, steps: u64) {
        self.bar.inc_length(steps);
    }

    /// Counts a step as done.
    pub(crate) fn done(&self) {
        self.bar.inc(1);
    }

    /// Says something that is no error, above the bar; nothing when quiet.
    pub(crate) fn note(&self, text: &str) {
        if !self.quiet {
            self.bar.suspend(|| eprintln!("note: {text}"));
        }
    }

    /// Removes the bar.
    pub(crate) fn finish(&self) {
        self.bar.finish_and_clear();
    }
}
