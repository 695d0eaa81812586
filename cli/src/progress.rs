//! A progress bar on standard error for anything over a second; hidden when that is no terminal.

use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use takes::{Event, Progress};

/// Before this much time has passed nothing is shown.
const PATIENCE: Duration = Duration::from_secs(1);
const STEPS: u64 = 1000;

/// The bar of a whole command.
pub struct Bar {
    started: Instant,
    bar: Option<ProgressBar>,
    what: &'static str,
}

impl Bar {
    /// Begins to count time.
    pub fn new() -> Self {
        Self { started: Instant::now(), bar: None, what: "" }
    }

    /// Begins a part of the work.
    pub fn part(&mut self, what: &'static str) {
        self.what = what;
        if let Some(bar) = &self.bar {
            bar.set_message(what);
        }
        self.at(0.0);
    }

    /// This fraction of the part is done.
    pub fn at(&mut self, fraction: f64) {
        if self.started.elapsed() < PATIENCE {
            return;
        }
        let bar = self.bar.get_or_insert_with(|| {
            let bar = ProgressBar::with_draw_target(Some(STEPS), ProgressDrawTarget::stderr());
            let style = ProgressStyle::with_template("{msg:>10} [{bar:40}] {percent:>3} %  {elapsed}");
            bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()).progress_chars("=> "))
                .with_message(self.what)
                .with_elapsed(self.started.elapsed())
        });
        bar.set_position((fraction.clamp(0.0, 1.0) * STEPS as f64) as u64);
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

/// A bar that shows the events of a long call. Notes are printed above it.
pub fn progress() -> Progress<'static> {
    let mut bar = Bar::new();
    Progress::new(move |event| match event {
        Event::Part(name) => bar.part(name),
        Event::Fraction(fraction) => bar.at(fraction),
        Event::Note(text) => eprintln!("{text}"),
    })
}
