//! Arms that rise only while the body walks, through a stop: how smooth the transition is beside the script; prints the table of
//! `docs/BY_EXAMPLE.md`.
//!
//! `cargo run --release -p studies --example context -- [--path-weight W]`. Clips of `../shared/mocap`; the stop is that of 16_33. A row
//! says what was taught; `ours / script` are RMS jerk and peak speed of the hands over the transition.

use std::error::Error;
use std::sync::Arc;

use edits::by_example::{ByExample, ExampleEdit, ExampleOptions, Pair};
use edits::{Motion, Where};
use formats::bvh::ImportOptions;
use motion::Clip;
use studies::propagate::compare::{spread, taught};
use studies::propagate::rules::{Rule, pair};
use studies::propagate::transition::{smoothness, transition, turned};

/// Walks and standing.
const WALKS: [&str; 5] = ["16_16", "16_20", "16_30", "49_01", "16_02"];
/// A walk to a stop, and a run to a stop.
const STOP: &str = "16_33";
const OTHER_STOP: &str = "16_08";
/// A walk without a stop.
const WALK: &str = "16_13";

fn main() -> Result<(), Box<dyn Error>> {
    let mut options = ExampleOptions::default();
    let mut arguments = std::env::args().skip(1);
    while let Some(a) = arguments.next() {
        match a.as_str() {
            "--path-weight" => {
                options.path_weight = arguments.next().ok_or("--path-weight needs a number")?.parse()?;
            }
            other => return Err(format!("unknown `{other}`; known: --path-weight W").into()),
        }
    }
    let ruled = |name: &str, slower: f64| -> Result<Pair, Box<dyn Error>> {
        let path = support::shared(&format!("mocap/bvh/{name}.bvh"));
        let c = formats::open_clip(&path, &ImportOptions::default())?.0;
        let slow = Clip::new(c.skeleton.clone(), c.rate_hz / slower, c.data().to_vec());
        let clip = if slower == 1.0 { c } else { slow.resample(c.rate_hz) };
        Ok(pair(Rule::ArmsWhileWalking, name, &clip)?)
    };
    let learned = |stop: &str, keys: usize| -> Result<Arc<ExampleEdit>, Box<dyn Error>> {
        let names = WALKS.iter().copied().chain([stop]);
        let pairs = names.map(|n| ruled(n, 1.0)).collect::<Result<Vec<_>, _>>()?;
        let mut pairs = taught(&pairs, &spread(&pairs, 640, 1e9));
        if keys > 0 {
            // evenly over the transition of the stop that is asked about
            let keyed = ruled(STOP, 1.0)?;
            let arm = keyed.source.skeleton.link("LeftArm").ok_or("no LeftArm")?;
            let frames = transition(&keyed, arm);
            let (from, all) = (*frames.start(), frames.end() - frames.start());
            let at = |i: usize| (from + i * all / (keys - 1).max(1)) as f64 / keyed.source.rate_hz;
            pairs.push(Pair { spans_s: (0..keys).map(|i| (at(i), at(i))).collect(), ..keyed });
        }
        Ok(Arc::new(ExampleEdit::learn(&pairs, &options)?))
    };
    println!(
        "{:>44} {:>14} {:>9} {:>10} {:>18} {:>10} {:>18} {:>6}",
        "taught", "asked", "arms °", "jerk", "ours / script", "peak", "ours / script", ""
    );
    let same = learned(STOP, 0)?;
    let other = learned(OTHER_STOP, 0)?;
    let corrected = learned(OTHER_STOP, 8)?;
    for (taught, edit, name, slower) in [
        ("walks, the stop", &same, STOP, 1.0),
        ("walks, the stop", &same, STOP, 1.15),
        ("walks, the stop", &same, STOP, 1.3),
        ("walks, another stop", &other, STOP, 1.0),
        ("walks, another stop, 8 frames of the stop", &corrected, STOP, 1.0),
        ("walks, another stop, 8 frames of the stop", &corrected, STOP, 1.15),
        ("walks, the stop", &same, WALK, 1.0),
    ] {
        let truth = ruled(name, slower)?;
        let s = truth.source.skeleton.clone();
        let link = |name: &str| s.link(name).ok_or(format!("no {name}"));
        let (arm, hands) = (link("LeftArm")?, [link("LeftHand")?, link("RightHand")?]);
        let motion = Motion::of(truth.source.clone());
        let done = ByExample::new(edit.clone()).run(&motion, &Where::default().in_clip(&motion)?)?;
        let frames = if name == WALK { 0..=truth.source.frames() - 1 } else { transition(&truth, arm) };
        let [ours, script] = [&done.untimed, &truth.target].map(|c| smoothness(c, &hands, frames.clone()));
        let off = Pair { source: done.untimed.clone(), ..truth.clone() };
        let squares: f64 = frames.clone().map(|f| turned(&off, arm, f).powi(2)).sum();
        let rms = (squares / frames.clone().count() as f64).sqrt().to_degrees();
        println!(
            "{taught:>44} {:>14} {rms:>9.2} {:>10.2} {:>9.0}/{:>8.0} {:>10.2} {:>9.2}/{:>8.2}",
            format!("{name} × {slower}"),
            ours.jerk_rms / script.jerk_rms,
            ours.jerk_rms,
            script.jerk_rms,
            ours.peak_m_s / script.peak_m_s,
            ours.peak_m_s,
            script.peak_m_s
        );
    }
    Ok(())
}
