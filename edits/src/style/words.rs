//! What a component is, in words.
//!
//! Two poses of the component alone are compared: of posture, its mean over the first clip and over the second; of
//! rhythm, its mean in the clip that swings more and two standard deviations from it there, to either side. The
//! joints that turn most between them are named, with the share they have in the sum of the squared turns, and the axis: pitch about the axis to the left,
//! turn about the vertical, roll about the way ahead. A rhythm has a period, if it has one.

use motion::Vec3;
use motion::rotation::log;
use nalgebra::DMatrix;

use super::cycle::period;
use super::set::StyleSet;

/// Joints that are named.
const NAMED: usize = 3;
/// Turns below this are not worth a word, rad.
const LEAST: f64 = 0.017;
/// Heights below this are not worth a word, m.
const LEAST_M: f64 = 0.005;

impl StyleSet {
    /// What a component does, in words: `trunk pitches 18°, …; posture; separates 0.92`.
    pub fn words(&self, component: usize) -> String {
        describe(self, component)
    }
}

/// `LowerBack pitches 18° (31 %), …; 40 mm lower; posture; separates 0.92`.
fn describe(set: &StyleSet, component: usize) -> String {
    let separation = set.separation(component);
    let means = [0, 1].map(|clip| set.of_clip(clip).row_mean());
    let spread = |clip: usize| {
        let u = set.of_clip(clip);
        set.groups[component].iter().map(|i| u.column(*i).variance()).sum::<f64>()
    };
    let livelier = usize::from(spread(1) > spread(0));
    let k = set.activations.ncols();
    let two = DMatrix::from_fn(2, k, |row, c| {
        if !set.groups[component].contains(&c) {
            0.0
        } else if separation.is_posture() {
            means[row][c]
        } else {
            let sigma = set.of_clip(livelier).column(c).variance().sqrt();
            means[livelier][c] + if row == 0 { -sigma } else { sigma }
        }
    });
    let poses = set.postures(&two);
    let joint = |row: usize, bone: usize| {
        let turns = &poses.turns[row];
        set.figure.bones[bone].parent.map_or(turns[bone], |p| turns[p].inverse() * turns[bone])
    };
    // seen in the body's own axes, in the middle of both poses
    let mut turned: Vec<(usize, Vec3)> = (0..set.figure.bones.len())
        .map(|bone| (bone, log(&(joint(1, bone) * joint(0, bone).inverse()))))
        .collect();
    let all: f64 = turned.iter().map(|t| t.1.norm_squared()).sum();
    turned.sort_by(|a, b| b.1.norm().total_cmp(&a.1.norm()).then(a.0.cmp(&b.0)));
    let mut parts: Vec<String> = turned
        .iter()
        .take(NAMED)
        .filter(|t| t.1.norm() > LEAST)
        .map(|(bone, by)| {
            let verb = ["pitches", "turns", "rolls"][by.iamax()];
            let (deg, share) = (by[by.iamax()].to_degrees(), 100.0 * by.norm_squared() / all);
            format!("{} {verb} {deg:.0}° ({share:.0} %)", set.figure.bones[*bone].name)
        })
        .collect();
    if parts.is_empty() {
        parts.push("no joint turns by a degree".into());
    }
    let mut words = parts.join(", ");
    let up = poses.height[1] - poses.height[0];
    if up.abs() > LEAST_M {
        words += &format!("; {:.0} mm {}", 1e3 * up.abs(), if up > 0.0 { "higher" } else { "lower" });
    }
    if separation.is_posture() {
        words += &format!("; posture ({} to {})", set.names[0], set.names[1]);
    } else {
        words += &format!("; rhythm (more in {})", set.names[livelier]);
        let u = set.of_clip(livelier);
        let strongest = set.groups[component]
            .iter()
            .max_by(|a, b| u.column(**a).variance().total_cmp(&u.column(**b).variance()));
        if let Some(p) = strongest.and_then(|i| period(u.column(*i).as_slice(), set.rate_hz)) {
            words += &format!(", every {:.2} s", p.seconds);
        }
    }
    format!("{words}; separates {:.2}", separation.best())
}
