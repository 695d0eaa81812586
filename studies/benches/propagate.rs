//! A correction shows: 30 corrected frames join 549 examples (and their mirror images), and the edit is applied again to 30 s at 30 Hz.
//!
//! `cargo bench -p studies --bench propagate`. Asked: at most 200 ms for all of it. Measured one by one too: growing, applying to all
//! 900 frames, and to the corrected second alone (`first`), which is what an animator sees. Medians of [`ROUNDS`]; of the clock, and of processor
//! time where the system tells it (Linux), which is the same on an idle core.

use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

use motion::rotation::exp;
use motion::{Clip, Vec3};
use studies::propagate::apply::{Use, apply, first};
use studies::propagate::project::{blended, changes};
use studies::propagate::route::Change;
use studies::propagate::shipped::{Shipped, clip, errand};
use studies::propagate::{ExampleEdit, Pair, PropagateError};

const ROUNDS: usize = 15;

fn main() -> Result<(), PropagateError> {
    let edit = Arc::new(Shipped::LeanBack.learn()?);
    let whole = clip(&errand(), Change::None)?.resample(30.0);
    let nq = whole.skeleton.nq();
    let source = Clip::new(whole.skeleton.clone(), 30.0, whole.data()[..900 * nq].to_vec());
    let how = Use::default();
    let done = apply(&edit, &source, &how)?.untimed;
    // the head is turned in 30 frames
    let mut edited = done.clone();
    let s = edited.skeleton.clone();
    let head = s.link("head").unwrap_or(0);
    for f in 400..430 {
        let turned = s.rotation(edited.pose(f), head) * exp(&Vec3::new(0.0, 0.35, 0.0));
        s.set_rotation(edited.pose_mut(f), head, &turned);
    }
    let found = || -> Result<Pair, PropagateError> {
        let (target, spans_s) = blended(&done, &edited, &changes(&done, &edited)?, 0.0);
        Ok(Pair { spans_s, ..Pair::new("correction", source.clone(), target) })
    };
    let correction = found()?;
    let grown = |pair: &Pair, mut edit: ExampleEdit| -> Result<ExampleEdit, PropagateError> {
        edit.grow(std::slice::from_ref(pair))?;
        Ok(edit)
    };
    timed(
        "correct 30 of 900 frames: find, grow, apply",
        || (*edit).clone(),
        |edit| apply(&Arc::new(grown(&found()?, edit)?), black_box(&source), &how),
    )?;
    timed("grow 549 examples by 30", || (*edit).clone(), |edit| grown(&correction, edit))?;
    timed("apply to 900 frames", || edit.clone(), |edit| apply(&edit, black_box(&source), &how))?;
    let second = (13.3, 14.3);
    timed(
        "the corrected second first",
        || edit.clone(),
        |edit| first(&edit, black_box(&source), &how, second),
    )
}

/// Prints the medians of a call; what `make` does is not counted.
fn timed<A, B>(
    what: &str,
    make: impl Fn() -> A,
    run: impl Fn(A) -> Result<B, PropagateError>,
) -> Result<(), PropagateError> {
    let (mut clock, mut processor) = (Vec::new(), Vec::new());
    for _ in 0..ROUNDS {
        let input = make();
        let (began, used) = (Instant::now(), processor_s());
        let _ = black_box(run(input)?);
        clock.push(began.elapsed().as_secs_f64());
        processor.extend(used.zip(processor_s()).map(|(a, b)| b - a));
    }
    let median = |of: &mut Vec<f64>| {
        of.sort_by(f64::total_cmp);
        of.get(of.len() / 2).map_or("-".into(), |s| format!("{:.1} ms", 1e3 * s))
    };
    println!("{what:<46} clock {:>10}  processor {:>10}", median(&mut clock), median(&mut processor));
    Ok(())
}

/// Processor time of this thread, s.
fn processor_s() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    Some(text.split_whitespace().next()?.parse::<f64>().ok()? * 1e-9)
}
