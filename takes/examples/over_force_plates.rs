//! A measured walk performed free: its ground forces against those of the force plates that it was measured on.
//!
//! In: `walk_overground_ik.json` (`shared/forceplate`, schema `forceplate-trial/1`), where to draw. Out: differences between performed, required and
//! measured forces, a picture.
//!
//! ```sh
//! cargo run --release -p takes --example over_force_plates -- ../shared/forceplate/walk_overground_ik.json --draw docs/images/plates
//! ```
//!
//! The skeleton is that of the file (places of joints, mean over the frames), the body on it guessed, with the measured mass. Poses are the unfiltered ones:
//! smoothing and what is made possible are those of any clip. The plates see all of the force from 0.45 to 1.80 s. All forces are low-passed at
//! 20 Hz (`motion::smooth::whittaker`, without delay); rRMSE is the RMS of the difference over the measured force's peak to peak.

use std::path::PathBuf;
use std::sync::Arc;

use bodies::anthropometry::{BodyOptions, guess_body_of_clip};
use controllers::Goal;
use dynamics::analysis::smoothed;
use dynamics::{Model, State, Trace, Walked};
use motion::smooth::whittaker::{Whittaker, lambda};
use motion::{Clip, Joint, Link, Quat, Skeleton, Vec3};
use plots::panel::{Clock, Key, Panel, Series, page};
use plots::style::{BLUE, REFERENCE, VERMILION};
use serde_json::Value;
use sim::Engines;
use sim::foresight::{Foreseen, Settings};
use takes::overrides::RootChoice;
use takes::{Ask, Input, LookAhead, Overrides, Take, open};

/// When the plates see all of the force, s.
const SEEN_S: [f64; 2] = [0.45, 1.80];
/// Forces are low-passed at this frequency, Hz.
const CUT_HZ: f64 = 20.0;
/// Link, its parent, the body of the file; in the order of the links.
const LINKS: [(&str, usize, &str); 14] = [
    ("Hips", 0, "pelvis"),
    ("LeftUpLeg", 0, "femur_l"),
    ("LeftLeg", 1, "tibia_l"),
    ("LeftFoot", 2, "talus_l"),
    ("LeftToeBase", 3, "toes_l"),
    ("RightUpLeg", 0, "femur_r"),
    ("RightLeg", 5, "tibia_r"),
    ("RightFoot", 6, "talus_r"),
    ("RightToeBase", 7, "toes_r"),
    ("Spine", 0, "torso"),
    ("LeftArm", 9, "humerus_l"),
    ("LeftForeArm", 10, "ulna_l"),
    ("RightArm", 9, "humerus_r"),
    ("RightForeArm", 12, "ulna_r"),
];
/// Hands hang on the forearms as they are; the head, which the file has no joint of, on the torso: link, parent, body whose origin it has, place
/// in the torso, m (left, up, forward).
const HANDS: [(&str, usize, &str); 2] = [("LeftHand", 11, "hand_l"), ("RightHand", 13, "hand_r")];
const HEAD: [f64; 3] = [0.0, 0.52, 0.03];
const CROWN: [f64; 3] = [0.0, 0.21, 0.0];
const HAND_TIP: [f64; 3] = [0.0, -0.15, 0.0];

type Failed = Box<dyn std::error::Error>;

fn list(v: &Value) -> Result<&Vec<Value>, Failed> {
    v.as_array().ok_or_else(|| "a list is missing".into())
}

fn numbers(v: &Value) -> Result<Vec<f64>, Failed> {
    list(v)?.iter().map(|x| x.as_f64().ok_or_else(|| "a number is missing".into())).collect()
}

/// From the file's axes (x forward, y up, z right) to ours (x left, y up, z forward).
fn axes() -> Quat {
    Quat::from_axis_angle(&Vec3::y_axis(), -std::f64::consts::FRAC_PI_2)
}

struct Measured {
    clip: Clip,
    mass_kg: f64,
    /// Total force, our axes, per frame, N.
    force: Vec<Vec3>,
}

fn read(path: &PathBuf, poses: &str, toe_m: f64) -> Result<Measured, Failed> {
    let json: Value = serde_json::from_slice(&std::fs::read(path)?)?;
    let bodies = list(&json["bodies"])?;
    let index = |name: &str| -> Result<usize, Failed> {
        bodies.iter().position(|b| b["name"] == name).ok_or_else(|| format!("no body `{name}`").into())
    };
    let turn = axes();
    let mut frames: Vec<Vec<(Vec3, Quat)>> = Vec::new();
    for frame in list(&json[poses])? {
        let pose = |p: &Value| -> Result<(Vec3, Quat), Failed> {
            let n = numbers(p)?;
            let r = Quat::new_normalize(nalgebra::Quaternion::new(n[3], n[4], n[5], n[6]));
            Ok((turn * Vec3::new(n[0], n[1], n[2]), turn * r * turn.inverse()))
        };
        frames.push(list(frame)?.iter().map(pose).collect::<Result<_, _>>()?);
    }
    let all: Vec<(&str, usize, usize)> = LINKS
        .iter()
        .chain(&HANDS)
        .map(|(name, parent, body)| Ok((*name, *parent, index(body)?)))
        .collect::<Result<_, Failed>>()?;
    let mut links = Vec::new();
    for (k, &(name, parent, body)) in all.iter().enumerate() {
        let above = all[parent].2;
        let apart = |f: &Vec<(Vec3, Quat)>| f[above].1.inverse() * (f[body].0 - f[above].0);
        let offset = frames.iter().map(apart).sum::<Vec3>() / frames.len() as f64;
        let (parent, offset, joint) = if k == 0 {
            (None, Vec3::zeros(), Joint::Free)
        } else {
            (Some(parent), offset, Joint::Spherical)
        };
        let mut link = Link::new(name, parent, offset, joint);
        link.end = match name {
            "LeftToeBase" | "RightToeBase" => Some(Vec3::z() * toe_m),
            "LeftHand" | "RightHand" => Some(HAND_TIP.into()),
            _ => None,
        };
        links.push(link);
    }
    let mut head = Link::new("Head", Some(9), HEAD.into(), Joint::Spherical);
    head.end = Some(CROWN.into());
    links.push(head);
    let skeleton = Arc::new(Skeleton::new(links)?);
    let mut q = Vec::new();
    for frame in &frames {
        let mut pose = skeleton.zero_pose();
        pose[..3].copy_from_slice(frame[all[0].2].0.as_slice());
        for (link, &(_, parent, body)) in all.iter().enumerate() {
            let r = if link == 0 { frame[body].1 } else { frame[all[parent].2].1.inverse() * frame[body].1 };
            skeleton.set_rotation(&mut pose, link, &r);
        }
        q.extend(pose);
    }
    let rate_hz = json["rate_hz"].as_f64().ok_or("no rate")?;
    let mut force = vec![Vec3::zeros(); frames.len()];
    for foot in list(&json["measured"]["feet"])? {
        for (sum, f) in force.iter_mut().zip(list(&foot["force"])?) {
            *sum += turn * Vec3::from_column_slice(&numbers(f)?);
        }
    }
    let mass_kg = bodies.iter().filter_map(|b| b["mass"].as_f64()).sum();
    Ok(Measured { clip: Clip::new(skeleton, rate_hz, q), mass_kg, force })
}

/// The walk as a take of a body of the measured mass.
fn take(
    measured: &Measured,
    settings: Settings,
    tension: f64,
    engine: Option<String>,
) -> Result<Take, Failed> {
    let options = BodyOptions { mass_kg: Some(measured.mass_kg), ..BodyOptions::default() };
    let (character, _) = guess_body_of_clip(&measured.clip, &options)?;
    let dir = tempfile::tempdir()?;
    let body = dir.path().join("subject.ron");
    std::fs::write(&body, scenes::character_file::write(&character, "The subject of the force plates."))?;
    let overrides = Overrides {
        root: Some(RootChoice::Free),
        tension: Some(tension),
        substeps: Some(2),
        ..Overrides::default()
    };
    let foresight = LookAhead::As(Foreseen::Search(settings));
    let ask = Ask { overrides, foresight, engine, body: Some(body), ..Ask::default() };
    Ok(open(Input::Clip { clip: measured.clip.clone(), name: "force_plates".into() }, &ask)?)
}

/// Low-passed forces at the frames of the measurement.
fn passed(force: &[Vec3], rate_hz: f64, to: &Clip) -> Vec<Vec3> {
    let flat: Vec<f64> = force.iter().flat_map(|f| [f.x, f.y, f.z]).collect();
    let smooth = Whittaker::new(force.len(), lambda(CUT_HZ, rate_hz)).smooth(&flat, 3);
    let at = |frame: usize| {
        let x = (frame as f64 / to.rate_hz * rate_hz).min((force.len() - 1) as f64);
        let (row, part) = ((x.floor() as usize).min(force.len().saturating_sub(2)), x.fract());
        let of = |row: usize| Vec3::from_column_slice(&smooth[3 * row..3 * row + 3]);
        of(row) * (1.0 - part) + of((row + 1).min(force.len() - 1)) * part
    };
    (0..to.frames()).map(at).collect()
}

/// Force that a motion requires, N: change of momentum and weight.
fn required(model: &Model, goal: &Goal) -> Vec<Vec3> {
    let mut state = State::new(model);
    let momentum: Vec<Vec3> = (0..goal.rows())
        .map(|row| {
            state.update(model, goal.pose(row), goal.velocity(row));
            state.momentum(model).linear
        })
        .collect();
    let n = momentum.len();
    let rate = |row: usize| {
        let (a, b) = (row.saturating_sub(1), (row + 1).min(n - 1));
        (momentum[b] - momentum[a]) * (goal.rate_hz / (b - a) as f64)
    };
    (0..n).map(|row| rate(row) - model.gravity * model.mass).collect()
}

/// (largest minus least of the measured, RMS of the difference over it in percent) of an axis while the plates see all.
fn differ(ours: &[Vec3], measured: &[Vec3], rate_hz: f64, axis: usize) -> (f64, f64) {
    let frame = |t: f64| (t * rate_hz).round() as usize;
    let seen = frame(SEEN_S[0])..=frame(SEEN_S[1]).min(ours.len() - 1);
    let of = |f: &[Vec3]| seen.clone().map(|k| f[k][axis]).collect::<Vec<f64>>();
    let (a, b) = (of(ours), of(measured));
    let high = b.iter().fold(f64::NEG_INFINITY, |m, x| m.max(*x));
    let low = b.iter().fold(f64::INFINITY, |m, x| m.min(*x));
    let square = a.iter().zip(&b).map(|(x, y)| (x - y).powi(2)).sum::<f64>() / a.len() as f64;
    (high - low, 100.0 * square.sqrt() / (high - low))
}

fn main() -> Result<(), Failed> {
    let mut settings = Settings::default();
    let (mut tension, mut engine, mut draw, mut file) = (2.0, None, None, None);
    let (mut poses, mut toe_m) = ("poses_raw", 0.06);
    let mut args = std::env::args().skip(1);
    while let Some(arg) = args.next() {
        let mut value = || args.next().ok_or(format!("{arg} needs a value"));
        match arg.as_str() {
            "--tension" => tension = value()?.parse()?,
            "--seed" => settings.seed = value()?.parse()?,
            "--rollouts" => settings.rollouts = value()?.parse()?,
            "--toe" => toe_m = value()?.parse()?,
            "--filtered" => poses = "poses_filtered",
            "--engine" => engine = Some(value()?),
            "--draw" => draw = Some(PathBuf::from(value()?)),
            _ => file = Some(PathBuf::from(arg)),
        }
    }
    let measured = read(&file.ok_or("no file")?, poses, toe_m)?;
    let take = take(&measured, settings, tension, engine)?;
    take.asked.stepping.iter().for_each(|line| println!("{line}"));
    for c in take.asked.contacts.contacts() {
        println!("{} stands from {:.2} s to {:.2} s", c.point, c.from_s, c.to_s);
    }
    let goal = Goal::new(&take.asked.clip, take.control_rate_hz());
    let trace: Trace = take.outcome(&Engines::default(), &mut |_| {})?.trace;
    let walked = Walked::of(&trace, goal.rows());
    match &walked.lost {
        None => println!(
            "kept its feet for {:.2} s; links {:.0} mm from what was asked",
            walked.kept_s, walked.links_mm
        ),
        Some((t, loss)) => println!("{t:.2} s: {loss}"),
    }
    let clip = &measured.clip;
    let plates = passed(&measured.force, clip.rate_hz, clip);
    let ours = passed(&trace.contact_sums(), trace.rate_hz, clip);
    let model = Model::new(take.character(), take.conditions.physics.gravity);
    let asked = passed(&required(&model, &goal), goal.rate_hz, clip);
    // what the capture needs before it is made possible
    let smooth = Goal::new(&smoothed(&model, &take.unedited), take.control_rate_hz());
    let captured = passed(&required(&model, &smooth), smooth.rate_hz, clip);
    let weight = measured.mass_kg * take.conditions.physics.gravity.norm();
    let mut panels = Vec::new();
    for (name, axis) in [("vertical", 1), ("fore-aft", 2), ("lateral", 0)] {
        let (range, performed) = differ(&ours, &plates, clip.rate_hz, axis);
        let [required, smoothed] = [&asked, &captured].map(|f| differ(f, &plates, clip.rate_hz, axis).1);
        println!(
            "{name:<9} performed {performed:>5.1} % rRMSE, asked {required:>5.1} %, captured and smoothed {smoothed:>5.1} %, of {range:>4.0} N peak to peak"
        );
        let clock = Clock { rate_hz: clip.rate_hz, start_s: 0.0 };
        let curve = |force: &[Vec3], color| {
            let frame = |t: f64| (t * clip.rate_hz).round() as usize;
            let seen = frame(SEEN_S[0])..=frame(SEEN_S[1]).min(force.len() - 1);
            let mut series = Series::over_time(clock, std::iter::empty(), color);
            series.points = seen.map(|k| [clock.at(k), force[k][axis] / weight]).collect();
            series
        };
        panels.push(Panel {
            title: format!("{name}: {performed:.1} % of peak to peak"),
            x_label: if axis == 0 { "time, s".into() } else { String::new() },
            y_label: "body weights".into(),
            series: vec![
                curve(&plates, REFERENCE).wide(4.0),
                curve(&asked, BLUE).dashed(),
                curve(&ours, VERMILION),
            ],
            least_span: 0.1,
            ..Panel::default()
        });
    }
    if let Some(stem) = draw {
        let keys = [
            Key::line("measured by the plates", REFERENCE),
            Key::dashed("required by the motion asked for", BLUE),
            Key::line("performed free", VERMILION),
        ];
        let note = format!(
            "Total ground force, low-passed at {CUT_HZ} Hz; {:.1} kg, tension {tension}; root free",
            measured.mass_kg
        );
        let figure = page("A walk over force plates, performed", &note, &keys, &panels, 1, 900.0, 190.0);
        figure.save_png(&stem.with_extension("png"))?;
        println!("drawn: {}", stem.with_extension("png").display());
    }
    Ok(())
}
