//! Learning and applying beside a program that goes on: progress, an end to it, a changed span first.
//!
//! In: pairs, or an edit and a clip. Out: handles of threads. What they return is what the same call without a thread returns, to the bit:
//! nothing depends on when it is asked for. A handle that is dropped ends its thread; a training waits for it (one evaluation of a
//! likelihood), an application does not.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};

use edits::by_example::edit::Applied;
use edits::by_example::{ExampleEdit, ExampleError, ExampleOptions, Learning, Pair, Part};
use motion::Clip;

use super::PropagateError;
use super::apply::{Use, apply, first};

/// How far a training is. See [`Training::progress`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrainingProgress {
    /// The last that was told; nothing before the first evaluation.
    pub learning: Option<Learning>,
    /// Evaluations of both models.
    pub evaluations: usize,
}

impl TrainingProgress {
    /// Part that is done at least, 0 to 1, as far as that can be known: a search may end before its last iteration.
    pub fn fraction(&self) -> f64 {
        let Some(l) = self.learning else { return 0.0 };
        let before = if l.model == "configurations" { 0.0 } else { 0.5 };
        before + 0.5 * (l.evaluations as f64 / l.of.max(1) as f64).min(1.0)
    }
}

/// What both threads see.
struct Shared {
    cancelled: AtomicBool,
    told: Mutex<TrainingProgress>,
}

/// An edit that is being learned.
pub struct Training {
    thread: Option<JoinHandle<Result<ExampleEdit, ExampleError>>>,
    shared: Arc<Shared>,
}

impl Training {
    /// Begins to learn the edit of the pairs; those of a project are `project.pairs(context)?`, and `project.save(&edit)?` keeps what is learned.
    ///
    /// # Errors
    /// No thread to be had.
    pub fn start(pairs: Vec<Pair>, options: ExampleOptions) -> Result<Self, PropagateError> {
        let told = Mutex::new(TrainingProgress { learning: None, evaluations: 0 });
        let shared = Arc::new(Shared { cancelled: AtomicBool::new(false), told });
        let theirs = shared.clone();
        let work = move || {
            ExampleEdit::learn_watched(&pairs, &options, &|learning| {
                let mut told = theirs.told.lock().unwrap_or_else(PoisonError::into_inner);
                told.learning = Some(learning);
                told.evaluations += 1;
                if theirs.cancelled.load(Ordering::Relaxed) {
                    ControlFlow::Break(())
                } else {
                    ControlFlow::Continue(())
                }
            })
        };
        let thread = thread::Builder::new().name("training".into()).spawn(work);
        Ok(Self { thread: Some(thread.map_err(PropagateError::Thread)?), shared })
    }

    /// How far it is.
    pub fn progress(&self) -> TrainingProgress {
        *self.shared.told.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether [`Training::finish`] would return at once.
    pub fn is_finished(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// Ends it before the next evaluation; [`Training::finish`] then returns [`ExampleError::Cancelled`], or the edit if it was done.
    pub fn cancel(&self) {
        self.shared.cancelled.store(true, Ordering::Relaxed);
    }

    /// Waits for the edit.
    ///
    /// # Errors
    /// Of learning; [`ExampleError::Cancelled`].
    pub fn finish(mut self) -> Result<ExampleEdit, PropagateError> {
        let Some(thread) = self.thread.take() else {
            return Err(PropagateError::Example(ExampleError::NoPairs));
        };
        Ok(joined(thread)?)
    }
}

impl Drop for Training {
    fn drop(&mut self) {
        self.cancel();
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// What a thread returned; its panic goes on here.
fn joined<T>(thread: JoinHandle<T>) -> T {
    thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
}

/// An edit that is being applied: a span first, then all of it.
pub struct Applying {
    first: Receiver<Result<Part, PropagateError>>,
    thread: JoinHandle<Result<Applied, PropagateError>>,
    cancelled: Arc<AtomicBool>,
}

impl Applying {
    /// Begins to apply an edit to a clip: to `span_s` first.
    ///
    /// # Errors
    /// No thread to be had.
    pub fn start(
        edit: Arc<ExampleEdit>,
        clip: Clip,
        how: Use,
        span_s: (f64, f64),
    ) -> Result<Self, PropagateError> {
        let (tell, part): (Sender<Result<Part, PropagateError>>, _) = channel();
        let cancelled = Arc::new(AtomicBool::new(false));
        let ended = cancelled.clone();
        let work = move || {
            // nobody may be listening any more
            let _ = tell.send(first(&edit, &clip, &how, span_s));
            if ended.load(Ordering::Relaxed) {
                return Err(PropagateError::Cancelled);
            }
            apply(&edit, &clip, &how)
        };
        let thread = thread::Builder::new().name("applying".into()).spawn(work);
        Ok(Self { first: part, thread: thread.map_err(PropagateError::Thread)?, cancelled })
    }

    /// The span, once it is there; `None` before, and after it was taken.
    pub fn first(&self) -> Option<Result<Part, PropagateError>> {
        self.first.try_recv().ok()
    }

    /// Waits for the span; `None` after it was taken.
    pub fn wait_first(&self) -> Option<Result<Part, PropagateError>> {
        self.first.recv().ok()
    }

    /// Whether all of it is done.
    pub fn is_finished(&self) -> bool {
        self.thread.is_finished()
    }

    /// Ends it after the span; [`Applying::finish`] then returns [`PropagateError::Cancelled`], unless the rest had begun.
    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }

    /// Waits for all of it: the whole clip, the span included, as [`apply`] returns it.
    ///
    /// # Errors
    /// As [`apply`]; [`PropagateError::Cancelled`].
    pub fn finish(self) -> Result<Applied, PropagateError> {
        joined(self.thread)
    }
}
