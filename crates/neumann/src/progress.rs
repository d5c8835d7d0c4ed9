//! How far rendering has come: a bar where somebody watches, now and then a line otherwise.

use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use crate::console;
use crate::session::Goal;

/// How rendering is going.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Standing {
    /// Iterations in the film.
    pub(crate) n_iterations: u32,
    /// Time spent on them, seconds.
    pub(crate) seconds: f64,
    /// Estimated relative error, if it has been found.
    pub(crate) error: Option<f64>,
}

/// Says what is being waited for, and for how long, where somebody watches.
pub(crate) fn while_waiting<T>(what: &str, work: impl FnOnce() -> T) -> T {
    let spinner = console::is_watched().then(|| {
        let spinner = ProgressBar::new_spinner();
        if let Ok(style) = ProgressStyle::with_template("{spinner} {msg}, {elapsed}") {
            spinner.set_style(style);
        }
        spinner.set_message(what.to_owned());
        spinner.enable_steady_tick(Duration::from_millis(100));
        spinner
    });
    let done = work();
    if let Some(spinner) = spinner {
        spinner.finish_and_clear();
    }
    done
}

/// Shows how rendering is going.
pub(crate) struct Progress {
    goal: Goal,
    bar: Option<ProgressBar>,
    next_line: Instant,
}

/// Steps of a bar that counts no iterations.
const STEPS: u64 = 1000;
/// Between two lines where nobody watches.
const LINE_PERIOD: Duration = Duration::from_secs(15);

impl Progress {
    pub(crate) fn new(goal: Goal) -> Self {
        let bar = console::is_watched().then(|| {
            let bar = ProgressBar::new(STEPS);
            let template = "{bar:32} {percent:>3} %  {msg}";
            if let Ok(style) = ProgressStyle::with_template(template) {
                bar.set_style(style.progress_chars("━━╌"));
            }
            bar
        });
        Self {
            goal,
            bar,
            next_line: Instant::now() + LINE_PERIOD,
        }
    }

    /// Says how rendering is going, if it is time to.
    pub(crate) fn update(&mut self, standing: Standing) {
        let part = self.goal.part_done(standing);
        match &self.bar {
            Some(bar) => {
                bar.set_position((part * STEPS as f64) as u64);
                bar.set_message(self.message(standing, part));
            }
            None if Instant::now() >= self.next_line => {
                self.next_line = Instant::now() + LINE_PERIOD;
                let message = self.message(standing, part);
                console::note(&format!("{:.0} %  {message}", part * 100.0));
            }
            None => {}
        }
    }

    /// Takes the bar away.
    pub(crate) fn finish(self) {
        if let Some(bar) = self.bar {
            bar.finish_and_clear();
        }
    }

    fn message(&self, standing: Standing, part: f64) -> String {
        let mut text = match self.goal.iterations {
            Some(n) => format!("{} of {n} iterations", standing.n_iterations),
            None => format!("{} iterations", standing.n_iterations),
        };
        if let Some(error) = standing.error {
            text += &format!(", error {:.2} %", error * 100.0);
        }
        text += &format!(", {}", duration(standing.seconds));
        if part > 0.02 && part < 1.0 {
            let left = standing.seconds * (1.0 - part) / part;
            text += &format!(", {} left", duration(left));
        }
        text
    }
}

/// A time for people.
pub(crate) fn duration(seconds: f64) -> String {
    if seconds < 9.95 {
        format!("{seconds:.1} s")
    } else if seconds < 120.0 {
        format!("{seconds:.0} s")
    } else if seconds < 7200.0 {
        format!("{:.0} min", seconds / 60.0)
    } else {
        format!("{:.1} h", seconds / 3600.0)
    }
}

#[cfg(test)]
mod tests {
    use super::duration;

    #[test]
    fn times_are_rounded_for_people() {
        assert_eq!(duration(0.04), "0.0 s");
        assert_eq!(duration(9.96), "10 s");
        assert_eq!(duration(150.0), "2 min");
        assert_eq!(duration(9000.0), "2.5 h");
    }
}
