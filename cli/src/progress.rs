//! What is seen of a long command on standard error: a bar where that is a terminal, else a line now and then.
//!
//! A thread keeps the clock going between two events, so that a command whose first part takes a minute does not look as if it
//! hung. Nothing is shown of what is done within a second, and no line of what is done within thirty.

use std::io::IsTerminal;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use takes::{Event, Progress};

/// Before this much time has passed no bar is shown.
const PATIENCE: Duration = Duration::from_secs(1);
/// Time between two lines where standard error is no terminal.
const BETWEEN_LINES: Duration = Duration::from_secs(30);
/// Time between two looks at the clock.
const TICK: Duration = Duration::from_millis(200);
const STEPS: u64 = 1000;

/// What is shown of a whole command.
struct Shown {
    started: Instant,
    bar: Option<ProgressBar>,
    /// When the last line was written, where there is no bar.
    line: Option<Instant>,
    what: &'static str,
    fraction: f64,
}

impl Shown {
    fn new() -> Self {
        let started = Instant::now();
        let line = (!std::io::stderr().is_terminal()).then_some(started);
        Self { started, bar: None, line, what: "", fraction: 0.0 }
    }

    /// Begins a part of the work.
    fn part(&mut self, what: &'static str) {
        self.what = what;
        if let Some(bar) = &self.bar {
            bar.set_message(what);
        }
        self.at(0.0);
    }

    /// This fraction of the part is done.
    fn at(&mut self, fraction: f64) {
        self.fraction = fraction.clamp(0.0, 1.0);
        self.show();
    }

    fn show(&mut self) {
        let elapsed = self.started.elapsed();
        if let Some(last) = self.line {
            if last.elapsed() >= BETWEEN_LINES {
                self.line = Some(Instant::now());
                let (percent, s) = (100.0 * self.fraction, elapsed.as_secs());
                eprintln!("{}: {percent:.0} %, {s} s", self.what);
            }
            return;
        }
        if elapsed < PATIENCE {
            return;
        }
        let bar = self.bar.get_or_insert_with(|| {
            let bar = ProgressBar::with_draw_target(Some(STEPS), ProgressDrawTarget::stderr());
            let style = ProgressStyle::with_template("{msg:>10} [{bar:40}] {percent:>3} %  {elapsed}");
            bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()).progress_chars("=> "))
                .with_message(self.what)
                .with_elapsed(elapsed)
        });
        bar.set_position((self.fraction * STEPS as f64) as u64);
        bar.tick();
    }
}

/// What is shown, until this is dropped.
struct Bar(Arc<Mutex<Option<Shown>>>);

fn lock(shown: &Mutex<Option<Shown>>) -> MutexGuard<'_, Option<Shown>> {
    shown.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Bar {
    fn new() -> Self {
        let shown = Arc::new(Mutex::new(Some(Shown::new())));
        let ticked = Arc::downgrade(&shown);
        // without the thread the bar moves with the events only
        let _ = thread::Builder::new().name("progress".into()).spawn(move || {
            while let Some(shown) = ticked.upgrade() {
                match lock(&shown).as_mut() {
                    Some(shown) => shown.show(),
                    None => return,
                }
                drop(shown);
                thread::sleep(TICK);
            }
        });
        Self(shown)
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        if let Some(bar) = lock(&self.0).take().and_then(|shown| shown.bar) {
            bar.finish_and_clear();
        }
    }
}

/// Shows the events of a long call. Notes are printed above the bar.
pub fn progress() -> Progress<'static> {
    let bar = Bar::new();
    Progress::new(move |event| {
        let mut shown = lock(&bar.0);
        let Some(shown) = shown.as_mut() else { return };
        match event {
            Event::Part(name) => shown.part(name),
            Event::Fraction(fraction) => shown.at(fraction),
            Event::Note(text) => match &shown.bar {
                Some(bar) => bar.suspend(|| eprintln!("{text}")),
                None => eprintln!("{text}"),
            },
        }
    })
}
