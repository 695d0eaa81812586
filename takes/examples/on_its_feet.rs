//! Captured clips performed free: which keep their feet, how near they stay, what it costs.
//!
//! In: clips, scenes, or folders of clips (those that stand from beginning to end are left out), and how to perform. Out: a line per clip and seed; of several
//! seeds the worst of a clip counts in the summary, which says how many clips keep each bound.
//!
//! ```sh
//! cargo run --release -p takes --example on_its_feet -- --tension 2 --seeds 1,2,3 ../shared/mocap/bvh
//! cargo run --release -p takes --example on_its_feet -- --tension 2 --draft ../shared/mocap/bvh/16_16.bvh
//! ```

mod common;

use common::{Failed, Options};
use controllers::Goal;
use controllers::likeness::Likeness;
use dynamics::analysis::{AnalysisError, AnalysisOptions, analyze, smoothed};
use dynamics::{Model, Trace, Walked};
use motion::Kinematics;
use sim::Engines;
use std::path::{Path, PathBuf};
use takes::{Ask, Take};

struct Line {
    name: String,
    seconds: f64,
    walked: Walked,
    /// Whether it leaves the ground: a run, a jump.
    flies: bool,
    /// Distance of the centres of all links of the motion made possible from the capture, RMS, mm.
    made_mm: f64,
    /// How near the motion made possible is to its capture; `None` where an edit changed its times.
    likeness: Option<Likeness>,
    /// Largest vertical force over 20 ms that inverse dynamics of the capture requires, in weights.
    required_peak: f64,
    /// Distance of the centres of all links from the capture while it kept its feet, RMS, mm.
    capture_mm: f64,
    /// Joint acceleration over that of the smoothed capture.
    acceleration: f64,
    offsets_deg: f64,
    cost_s: f64,
}

/// Processor time of this process so far, s; not a number where the system does not say.
fn cpu_s() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields: Vec<&str> = stat.rsplit(')').next().unwrap_or("").split_whitespace().collect();
    // fields 14 and 15 of the whole line, in hundredths of a second
    let ticks = |k: usize| fields.get(k).and_then(|x| x.parse::<f64>().ok()).unwrap_or(f64::NAN);
    (ticks(11) + ticks(12)) / 100.0
}

/// RMS joint acceleration of the smoothed capture, rad/s².
fn asked_acceleration(take: &Take) -> f64 {
    let model = Model::new(take.character(), take.conditions.physics.gravity);
    let goal = Goal::new(&smoothed(&model, &take.unedited), take.control_rate_hz());
    let nv = model.nv();
    let all = (0..goal.rows()).flat_map(|row| goal.acceleration(row)[6..].to_vec());
    let sum: f64 = all.map(|x| x * x).sum();
    (sum / (goal.rows() * (nv - 6)).max(1) as f64).sqrt()
}

/// Distance of the centres of all links from the clip as captured, over its frames for which there is a pose, RMS, mm.
fn capture_mm<'a>(take: &Take, pose: impl Fn(f64) -> Option<&'a [f64]>) -> f64 {
    let character = take.character();
    let (skeleton, clip) = (&character.skeleton, &take.unedited);
    let (mut sum, mut count) = (0.0, 0);
    for frame in 0..clip.frames() {
        let Some(pose) = pose(frame as f64 / clip.rate_hz) else { break };
        let performed = Kinematics::new(skeleton, pose);
        let captured = Kinematics::new(skeleton, clip.pose(frame));
        for (link, body) in character.bodies.iter().enumerate().filter(|(_, b)| b.mass > 0.0) {
            let apart = performed.point(link, &body.com) - captured.point(link, &body.com);
            sum += apart.norm_squared();
            count += 1;
        }
    }
    1e3 * (sum / f64::from(count.max(1))).sqrt()
}

/// Vertical force over time as CSV: s, body weights, mean over 20 ms, of all and of each leg's foot.
fn vertical(trace: &Trace) -> String {
    let model = Model::new(&trace.character, trace.gravity);
    let weight = model.mass * trace.gravity.norm();
    let feet: Vec<usize> = trace.character.legs().map(|l| model.body_of[l.end].0).collect();
    let of_row = |row: usize| {
        let of = |foot: &dyn Fn(usize) -> bool| {
            let here = trace.contacts_in(row).iter().filter(|c| foot(model.body_of[c.link].0));
            here.map(|c| c.force.y).sum::<f64>() / weight
        };
        let each = feet.iter().map(|foot| of(&|body| body == *foot));
        std::iter::once(of(&|_| true)).chain(each).collect::<Vec<f64>>()
    };
    let rows: Vec<Vec<f64>> = (0..trace.rows()).map(of_row).collect();
    let width = ((0.02 * trace.rate_hz).round() as usize).max(1);
    let mut text = String::from("time_s,all_bw");
    trace.character.legs().for_each(|l| text += &format!(",{}_bw", l.name));
    for (i, window) in rows.windows(width).enumerate() {
        text += &format!("\n{:.4}", (i as f64 + 0.5 * width as f64) / trace.rate_hz);
        for k in 0..=feet.len() {
            text += &format!(",{:.4}", window.iter().map(|r| r[k]).sum::<f64>() / width as f64);
        }
    }
    text + "\n"
}

/// The same of the pose that a trace has at a time, until `until_s`.
fn performed_mm(take: &Take, trace: &Trace, until_s: f64) -> f64 {
    capture_mm(take, |t| {
        let row = (t * trace.rate_hz).round() as usize;
        (t <= until_s && row < trace.rows()).then(|| trace.pose(row))
    })
}

/// Largest mean over 20 ms of the vertical force that the capture requires of the ground, in weights.
fn required_peak(take: &Take) -> Result<f64, AnalysisError> {
    let options = AnalysisOptions { gravity: take.conditions.physics.gravity, ..AnalysisOptions::default() };
    let a = analyze(take.character(), &take.unedited, &options)?;
    let width = ((0.02 * a.rate_hz()).round() as usize).max(1);
    let up: Vec<f64> = a.required_force.chunks_exact(3).map(|f| f[1]).collect();
    let means = up[a.ends.graded.clone()].windows(width).map(|w| w.iter().sum::<f64>() / width as f64);
    Ok(means.fold(0.0, f64::max) / a.weight())
}

fn perform(path: &Path, ask: &Ask, forces: Option<&Path>) -> Result<Line, Failed> {
    let take = takes::open(path, ask)?;
    let required_peak = required_peak(&take)?;
    // what is opened with foresight is made possible already
    let asked = &take.asked.clip;
    let flies =
        (0..asked.frames()).any(|f| take.asked.contacts.at(f as f64 / asked.rate_hz).next().is_none());
    let made_mm = capture_mm(&take, |t| {
        let frame = (t * asked.rate_hz).round() as usize;
        (frame < asked.frames()).then(|| asked.pose(frame))
    });
    let physics = take.conditions.physics;
    let likeness = physics.ground.and_then(|ground| {
        let (character, plan) = (take.character(), (&take.asked.contacts, take.asked.contacts_given));
        let smooth = smoothed(&Model::new(character, physics.gravity), &take.unedited);
        Likeness::of(character, (&take.unedited, &smooth), asked, plan, ground.height_m, physics.gravity)
    });
    let started = cpu_s();
    let asked = asked_acceleration(&take);
    let rows = Goal::new(&take.asked.clip, take.control_rate_hz()).rows();
    let seconds = take.asked.clip.duration_s();
    let outcome = take.outcome(&Engines::default(), &mut |_| {})?;
    if let Some(file) = forces {
        std::fs::write(file, vertical(&outcome.trace))?;
    }
    let walked = Walked::of(&outcome.trace, rows);
    Ok(Line {
        name: path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
        seconds,
        acceleration: walked.acceleration / asked.max(1e-9),
        offsets_deg: outcome.foresight.as_ref().map_or(0.0, |f| f.offset_rms().to_degrees()),
        flies,
        made_mm,
        likeness,
        required_peak,
        capture_mm: performed_mm(&take, &outcome.trace, walked.kept_s),
        cost_s: (cpu_s() - started) / walked.kept_s.max(1e-9),
        walked,
    })
}

/// What the worst seeds of all clips come to, bound by bound.
fn summary(worst: &[Line]) {
    let kept: Vec<&Line> = worst.iter().filter(|l| l.walked.lost.is_none()).collect();
    let count = |of: &dyn Fn(&Line) -> bool| kept.iter().filter(|l| of(l)).count();
    let median = |of: &dyn Fn(&Line) -> f64| {
        let mut all: Vec<f64> = kept.iter().map(|l| of(l)).collect();
        all.sort_by(f64::total_cmp);
        all.get(all.len() / 2).copied().unwrap_or(f64::NAN)
    };
    let n = kept.len();
    let counts = |l: &Line| l.likeness.as_ref().is_some_and(|of| of.unlike().is_empty());
    let (walks, flying) = (count(&|l| !l.flies), count(&|l| l.flies));
    println!(
        "{n} of {} keep their feet; of the {} whose motion made possible is as captured: {}",
        worst.len(),
        worst.iter().filter(|l| counts(l)).count(),
        count(&counts)
    );
    for line in worst.iter().filter(|l| !counts(l)) {
        let said: Vec<String> =
            line.likeness.iter().flat_map(|l| l.unlike()).map(|u| u.to_string()).collect();
        println!(
            "  {} does not count: {}",
            line.name,
            if said.is_empty() { "other times".into() } else { said.join("; ") }
        );
    }
    println!(
        "links from the capture: {} within 60 mm, median {:.0} mm; of what was asked: median {:.0} mm; the motion made possible: median {:.0} mm",
        count(&|l| l.capture_mm <= 60.0),
        median(&|l| l.capture_mm),
        median(&|l| l.walked.links_mm),
        median(&|l| l.made_mm)
    );
    println!(
        "joint acceleration: median {:.2} of the asked, {} of {n} within 1.25",
        median(&|l| l.acceleration),
        count(&|l| l.acceleration <= 1.25)
    );
    let stances: Vec<f64> = kept.iter().flat_map(|l| l.walked.slips_mm.iter().copied()).collect();
    println!(
        "slip: {} of {} stances within 15 mm, every stance of {} of {n} clips; worst {:.0} mm",
        stances.iter().filter(|s| **s <= 15.0).count(),
        stances.len(),
        count(&|l| l.walked.slip_mm_max() <= 15.0),
        stances.iter().copied().fold(0.0, f64::max)
    );
    let near = |l: &Line| (l.walked.peak / l.required_peak - 1.0).abs() <= 0.25;
    println!(
        "vertical peaks within 25 % of the required: {} of {walks} that walk, {} of {flying} that fly; over the required: median {:.2}",
        count(&|l| !l.flies && near(l)),
        count(&|l| l.flies && near(l)),
        median(&|l| l.walked.peak / l.required_peak)
    );
    println!(
        "unexplained force: {} of {walks} that walk within 0.5 %, {} of {flying} that fly within 1.5 %",
        count(&|l| !l.flies && l.walked.unexplained <= 0.5),
        count(&|l| l.flies && l.walked.unexplained <= 1.5)
    );
    let cost = kept.iter().map(|l| l.cost_s).fold(0.0, f64::max);
    println!("CPU-s per second of clip: median {:.1}, worst {cost:.1}", median(&|l| l.cost_s));
}

fn print(line: &Line, seed: u64) {
    let w = &line.walked;
    let end = match &w.lost {
        None => "kept".to_owned(),
        Some((t, loss)) => format!("{t:.2} s: {loss}"),
    };
    println!(
        "{:<18} {seed:>2} {:>6.2} of {:>5.2} s  {:>4.0} mm (capture {:>4.0}, made {:>3.0}) {:>5.1}°  slip {:>4.0} (worst {:>4.0}) mm  acc {:>4.2}  peak {:>4.2} of {:>4.2}  unexpl {:>5.2} %  offsets {:>4.1}°  {:>5.1} CPU-s/s  {end}",
        line.name,
        w.kept_s,
        line.seconds,
        w.links_mm,
        line.capture_mm,
        line.made_mm,
        w.joints_deg,
        w.slip_mm(),
        w.slip_mm_max(),
        line.acceleration,
        w.peak,
        line.required_peak,
        w.unexplained,
        line.offsets_deg,
        line.cost_s,
    );
}

fn main() -> Result<(), Failed> {
    let mut forces: Option<PathBuf> = None;
    let options = Options::read(Some(2), |word, words| {
        if word == "--forces" {
            forces = Some(words.value(word)?);
        }
        Ok(word == "--forces")
    })?;
    let mut worst: Vec<Line> = Vec::new();
    for file in &options.files {
        let mut lines: Vec<Line> = Vec::new();
        for &seed in &options.seeds {
            let ask = options.ask(seed);
            let line = perform(file, &ask, forces.as_deref())?;
            print(&line, seed);
            lines.push(line);
        }
        let order = |a: &Line, b: &Line| {
            let fell = |l: &Line| (l.walked.lost.is_some(), l.capture_mm);
            let ((fa, a), (fb, b)) = (fell(a), fell(b));
            fa.cmp(&fb).then(a.total_cmp(&b))
        };
        worst.extend(lines.into_iter().max_by(order));
    }
    summary(&worst);
    Ok(())
}
