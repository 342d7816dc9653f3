//! Progress on standard error: a bar with an estimate on a terminal, nothing when piped or quiet.

use std::fmt::Write;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use smalti::names::in_one_line;

use crate::output::tell;
use crate::terminal;

/// Rows of a terminal that does not report them.
const USUAL_ROWS: usize = 24;
/// Rows for the bar, which may wrap, and the prompt.
const BAR_ROWS: usize = 4;
const TEMPLATE: &str = "{prefix}{bar:24} {human_pos}/{human_len}{rate}  {msg}  {elapsed}, about {eta} left";
/// Before the number of steps is known, a bar would be full.
const WITHOUT_STEPS: &str = "{prefix}{msg}  {elapsed}";

/// The number of steps, with the name of the current one.
pub(crate) struct Progress {
    bar: ProgressBar,
    quiet: bool,
}

impl Progress {
    /// `steps` are those of the command itself. Experiments announce theirs.
    pub(crate) fn new(steps: u64, quiet: bool) -> Self {
        // A dumb terminal would print every state of the bar.
        let dumb = std::env::var_os("TERM").is_some_and(|t| t == "dumb");
        let bar = if quiet || dumb {
            ProgressBar::hidden()
        } else {
            ProgressBar::with_draw_target(Some(steps), ProgressDrawTarget::stderr())
        };
        let progress = Self { bar, quiet };
        progress.style(if steps == 0 { WITHOUT_STEPS } else { TEMPLATE });
        progress.bar.enable_steady_tick(Duration::from_millis(200));
        progress
    }

    fn style(&self, template: &str) {
        if let Ok(style) = ProgressStyle::with_template(template) {
            let rate = |state: &ProgressState, out: &mut dyn Write| {
                let _ = out.write_str(&rate(state.per_sec()));
            };
            self.bar.set_style(style.with_key("rate", rate));
        }
    }

    /// Removes the bar.
    pub(crate) fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

impl smalti::experiment::Progress for Progress {
    fn expect(&self, steps: u64) {
        if self.bar.length() == Some(0) {
            self.style(TEMPLATE);
        }
        self.bar.inc_length(steps);
    }

    fn begin(&self, step: &str) {
        self.bar.set_message(in_one_line(step).into_owned());
    }

    fn done(&self) {
        self.bar.inc(1);
    }

    /// Shows preliminary results above the bar, as many lines as the terminal has room for; they disappear with it.
    fn preliminary(&self, table: &str) {
        let room = terminal::rows_of_errors().unwrap_or(USUAL_ROWS).saturating_sub(BAR_ROWS);
        let lines = table.lines().take(room);
        self.bar.set_prefix(lines.fold(String::new(), |shown, line| shown + &in_one_line(line) + "\n"));
    }

    /// Prints a note above the bar, unless quiet.
    fn note(&self, text: &str) {
        if !self.quiet {
            self.bar.suspend(|| tell(&format!("note: {}", in_one_line(text))));
        }
    }
}

/// The rate of steps; empty before the first.
fn rate(per_second: f64) -> String {
    if !per_second.is_finite() || per_second <= 0.0 {
        String::new()
    } else if per_second < 1.0 {
        format!("  {:.1} s each", 1.0 / per_second)
    } else {
        format!("  {per_second:.0}/s")
    }
}

#[cfg(test)]
mod tests {
    use super::rate;

    #[test]
    fn a_rate_is_per_second_or_per_step() {
        let rates = [0.0, f64::NAN, f64::INFINITY, 0.08, 0.99, 1.0, 5200.4].map(rate);
        assert_eq!(rates, ["", "", "", "  12.5 s each", "  1.0 s each", "  1/s", "  5200/s"]);
    }
}
