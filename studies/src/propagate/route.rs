//! Walks as scripts: from a route of stands, steps and turns to the text of a scene.
//!
//! In: what a body does one after another ([`Leg`]s), and what an artist would change of it ([`Change`]). Out: the text of a [`Scene`] of the standard
//! figure with every key written down: pelvis, trunk, arms and steps. A source and its edited version are the same route with and without a
//! change, so that frame n of one is frame n of the other, and the truth on a route that was never taught is known.
//!
//! Both feet are on the ground at the moments m₀, m₁, …; between mᵢ and mᵢ₊₁ one foot swings while the pelvis goes by Dᵢ and turns by dᵢ. The
//! first and the last step of a bout are half as long. The foot lands `Dᵢ₊₁/2` in front of where the pelvis then is, so that it is as
//! far behind at the next moment.
//!
//! Units: m, s, degrees; x is left, z front, turns are to the left.

use std::fmt::Write;

use bodies::anthropometry::human::human;
use motion::Kinematics;

/// What a body does, one after another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Leg {
    /// Stands, looks to a side and back.
    Stand {
        /// How long, s.
        seconds: f64,
        /// How far the head turns, degrees.
        look_deg: f64,
    },
    /// Steps; of length zero they turn on the spot.
    Steps {
        /// How many; the first and the last of a bout are half as long.
        count: usize,
        /// Length, m.
        stride_m: f64,
        /// Time from step to step, s.
        beat_s: f64,
        /// Turn of each, degrees.
        turn_deg: f64,
    },
}

/// What an artist changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// Nothing.
    None,
    /// The trunk leans back by 20° while the body walks; the head stays level.
    LeanBack,
    /// The arms are held out while the body walks, and hang while it stands.
    ArmsOut,
}

/// A step that is taken.
struct Taken {
    left: bool,
    /// When the moment before it is, and how long until the next, s.
    from_s: f64,
    beat_s: f64,
    /// Way and turn of the pelvis.
    way_m: f64,
    turn_deg: f64,
    /// The same of the next step of the bout; zero after the last.
    next_m: f64,
    next_deg: f64,
    /// Whether the next one is the last.
    ends_next: bool,
}

/// Where the pelvis is.
#[derive(Clone, Copy, Default)]
struct At {
    x: f64,
    z: f64,
    deg: f64,
}

impl At {
    fn go(self, way_m: f64, turn_deg: f64) -> Self {
        let middle = (self.deg + 0.5 * turn_deg).to_radians();
        let (x, z) = (self.x + way_m * middle.sin(), self.z + way_m * middle.cos());
        Self { x, z, deg: self.deg + turn_deg }
    }

    /// A place beside (left) and in front.
    fn beside(self, left: f64, front: f64) -> [f64; 2] {
        let (s, c) = self.deg.to_radians().sin_cos();
        [self.x + left * c + front * s, self.z - left * s + front * c]
    }
}

/// A key of the pelvis.
struct PelvisKey {
    at_s: f64,
    place: [f64; 2],
    height: f64,
    /// Whether it rests there.
    still: bool,
}

/// A route as a scene of the standard figure.
#[derive(Clone, Copy, Debug)]
pub struct Scene<'a> {
    /// What the body does.
    pub legs: &'a [Leg],
    /// What is changed of it.
    pub change: Change,
    /// Path of the standard figure.
    pub character: &'a str,
    /// Its first lines: what to look at.
    pub about: &'a str,
    /// Edits, as a scene has them in its list.
    pub edits: &'a str,
}

impl Scene<'_> {
    /// The text of the scene.
    pub fn text(&self) -> String {
        let mut pelvis = vec![PelvisKey { at_s: START_S, place: [0.0; 2], height: 0.0, still: true }];
        let (mut gait, mut feet) = (String::new(), String::new());
        let (mut now, mut at) = (START_S, At::default());
        let feet_at = feet_at_rest();
        let mut rest = self.legs;
        while let Some(leg) = rest.first() {
            let bout = rest.iter().take_while(|l| matches!(l, Leg::Steps { .. })).count();
            if let Leg::Stand { seconds, look_deg } = *leg {
                stand(&mut pelvis, &mut gait, (now, seconds), at, look_deg);
                now += seconds;
            }
            for step in taken(&rest[..bout], now) {
                at = take(feet_at, &step, at, self.change, &mut pelvis, &mut gait, &mut feet);
                now = step.from_s + step.beat_s;
            }
            rest = &rest[bout.max(1)..];
        }
        let mut out = String::new();
        for line in self.about.lines() {
            let _ = writeln!(out, "// {line}");
        }
        let character = self.character;
        let edits =
            if self.edits.is_empty() { String::new() } else { format!("    edits: [{}],\n", self.edits) };
        let keys = keys(&pelvis);
        let _ = write!(
            out,
            "// Made by: cargo run --release -p studies --example shipped_edits\n\
             Scene(\n    character: \"{character}\",\n    rate_hz: 60,\n    properties: (curve: EaseInOut),\n    script: [\n        \
             Action(name: \"pelvis\", start_s: {START_S}, cycles: [Cycle(poses: [\n{keys}        ])]),\n        \
             Action(name: \"gait\", start_s: {START_S}, cycles: [Cycle(poses: [\n{gait}        ])]),\n    ],\n\
             {edits}    footwork: [\n{feet}    ],\n    \
             root: Pinned,\n    settle_s: 0.5,\n    strip: (figures: 14, yaw_deg: 60),\n)\n"
        );
        out
    }
}

/// When the first leg begins, s.
const START_S: f64 = 0.2;
/// Steps this long are walked, m; shorter ones shuffle.
const WALKED_M: f64 = 0.15;
/// Length from hip to ankle, m.
const LEG_M: f64 = 0.85;

/// Where the left ankle of the standard figure is at rest: left of its pelvis and in front of it, m.
fn feet_at_rest() -> [f64; 2] {
    let (human, _) = human();
    let k = Kinematics::new(&human.skeleton, &human.rest);
    let left = human.legs().map(|leg| k.origin(leg.end) - k.origin(0)).max_by(|a, b| a.x.total_cmp(&b.x));
    left.map_or([0.0; 2], |at| [at.x, at.z])
}

/// The steps of a bout, one after another.
fn taken(bout: &[Leg], from_s: f64) -> Vec<Taken> {
    let mut all: Vec<(f64, f64, f64)> = Vec::new();
    for leg in bout {
        if let Leg::Steps { count, stride_m, beat_s, turn_deg } = *leg {
            all.extend(std::iter::repeat_n((stride_m, beat_s, turn_deg), count));
        }
    }
    if let [first, .., last] = all.as_mut_slice() {
        for end in [first, last] {
            (end.0, end.2) = (0.5 * end.0, 0.5 * end.2);
        }
    }
    // a turn on the spot begins with the foot on its side
    let mut left = all.first().is_none_or(|first| first.2 >= 0.0);
    let mut now = from_s;
    let mut out = Vec::new();
    for (i, &(way_m, beat_s, turn_deg)) in all.iter().enumerate() {
        let (next_m, _, next_deg) = all.get(i + 1).copied().unwrap_or_default();
        let ends_next = i + 2 == all.len();
        out.push(Taken { left, from_s: now, beat_s, way_m, turn_deg, next_m, next_deg, ends_next });
        (left, now) = (!left, now + beat_s);
    }
    out
}

/// Writes a step; returns where the pelvis is after it.
fn take(
    rest: [f64; 2],
    step: &Taken,
    at: At,
    change: Change,
    pelvis: &mut Vec<PelvisKey>,
    gait: &mut String,
    feet: &mut String,
) -> At {
    let side = if step.left { 1.0 } else { -1.0 };
    let (half, after) = (at.go(0.5 * step.way_m, 0.5 * step.turn_deg), at.go(step.way_m, step.turn_deg));
    // highest, and over the foot that stands, in the middle
    let sway = 0.028 * (step.beat_s / 0.55);
    let middle_s = step.from_s + 0.5 * step.beat_s;
    pelvis.push(PelvisKey {
        at_s: middle_s,
        place: half.beside(-side * sway, 0.0),
        height: -0.02,
        still: false,
    });
    let stops = step.next_m == 0.0 && step.next_deg == 0.0;
    let (front, turned) =
        if step.ends_next { (step.next_m, step.next_deg) } else { (0.5 * step.next_m, 0.5 * step.next_deg) };
    let reach = front.max(0.5 * step.way_m);
    let low = if stops { 0.0 } else { -0.016 - 1.15 * reach * reach / (2.0 * LEG_M) };
    let end_s = step.from_s + step.beat_s;
    pelvis.push(PelvisKey { at_s: end_s, place: [after.x, after.z], height: low, still: stops });
    let lands = after.go(front, turned);
    let foot = [side * rest[0], rest[1]];
    let [x, z] = lands.beside(foot[0], foot[1]);
    let swing = 0.74 * step.beat_s;
    let _ = writeln!(
        feet,
        "        Step(limb: \"leg_{}\", start_s: {}, duration_s: {}, to_m: ({}, {}), turn_deg: {}, lift_m: {}),",
        if step.left { "l" } else { "r" },
        short(step.from_s + 0.13 * step.beat_s, 3),
        short(swing, 3),
        short(x - foot[0], 3),
        short(z - foot[1], 3),
        short(lands.deg, 1),
        short(if step.way_m > WALKED_M { 0.07 } else { 0.05 }, 3),
    );
    let walks = (step.way_m.min(step.next_m) / WALKED_M).clamp(0.0, 1.0);
    let swings = (0.5 * (step.way_m + step.next_m) / 0.5).min(1.2);
    pose(
        gait,
        step.beat_s,
        &Posture { deg: after.deg, side, walks, swings, look: 0.6 * step.next_deg, change },
    );
    after
}

/// How the body is held at a moment with both feet on the ground.
struct Posture {
    /// Heading, degrees.
    deg: f64,
    /// 1 if the left foot is in front, −1 if the right one is.
    side: f64,
    /// Whether it walks, 0 to 1.
    walks: f64,
    /// How much arms and trunk swing; 1 for steps of half a metre.
    swings: f64,
    /// How far the head turns, degrees.
    look: f64,
    change: Change,
}

fn pose(gait: &mut String, seconds: f64, p: &Posture) {
    let (s, a) = (p.side, p.swings);
    let lean = if p.change == Change::LeanBack { p.walks } else { 0.0 };
    let out = if p.change == Change::ArmsOut { p.walks } else { 0.0 };
    let (nod, look) = (-4.0 * a.min(1.0), p.look);
    let _ = write!(gait, "            Pose(duration_s: {}, set_deg: {{ ", short(seconds, 3));
    let mut ball = |name: &str, v: [f64; 3]| {
        let [x, y, z] = v.map(|v| short(v, 1));
        let _ = write!(gait, "\"{name}\": ({x}, {y}, {z}), ");
    };
    ball("pelvis", [2.0 * a, p.deg - 6.0 * a * s, 0.0]);
    ball("abdomen", [0.9 * a - 9.0 * lean, 4.5 * a * s, 0.0]);
    ball("chest", [1.1 * a - 11.0 * lean, 5.5 * a * s, 0.0]);
    ball("neck", [0.45 * nod + 8.0 * lean, -1.8 * a * s + 0.45 * look, 0.0]);
    ball("head", [0.55 * nod + 10.0 * lean, -2.2 * a * s + 0.55 * look, 0.0]);
    let mut elbows = [0.0; 2];
    for (i, (name, left)) in [("shoulder_l", 1.0), ("shoulder_r", -1.0)].into_iter().enumerate() {
        // the arm of the foot in front is behind
        let (hangs, held, bent) = if left * s > 0.0 {
            ([44.0, 50.0, -82.0 + 8.0 * a], [0.0, 8.0, -14.0], 10.0 + 2.0 * a)
        } else {
            ([-58.0, -64.0, -82.0 + 14.0 * a], [0.0, -8.0, -14.0], 10.0 + 16.0 * a)
        };
        let v: [f64; 3] = std::array::from_fn(|c| hangs[c] + out * (held[c] - hangs[c]));
        ball(name, [v[0], left * v[1], left * v[2]]);
        elbows[i] = bent + out * (8.0 - bent);
    }
    let [l, r] = elbows.map(|e| short(e, 1));
    let _ = writeln!(gait, "\"elbow_l\": {l}, \"elbow_r\": {r} }}),");
}

/// Stands: the weight goes to one side, the head looks to the other, and back.
fn stand(pelvis: &mut Vec<PelvisKey>, gait: &mut String, (from_s, seconds): (f64, f64), at: At, look: f64) {
    let side = look.signum();
    for (until, there) in [(0.45, 1.0), (1.0, 0.0)] {
        let place = at.beside(-0.02 * side * there, 0.0);
        pelvis.push(PelvisKey { at_s: from_s + until * seconds, place, height: -0.004 * there, still: true });
        let part = if there > 0.0 { 0.45 } else { 0.55 };
        let (l, b) = (look * there, side * there);
        let _ = writeln!(
            gait,
            "            Pose(duration_s: {}, rest: [\"shoulder_l\", \"shoulder_r\", \"elbow_l\", \"elbow_r\"], set_deg: {{ \"pelvis\": (0, {}, {}), \
             \"abdomen\": (0, {}, {}), \"chest\": (0, {}, 0), \"neck\": (0, {}, 0), \"head\": ({}, {}, 0) }}),",
            short(part * seconds, 3),
            short(at.deg, 1),
            short(-1.5 * b, 1),
            short(0.1 * l, 1),
            short(1.5 * b, 1),
            short(0.15 * l, 1),
            short(0.35 * l, 1),
            short(-2.0 * there, 1),
            short(0.4 * l, 1),
        );
    }
}

/// Keys of the pelvis as poses, smooth in speed: a Bezier with handles at a third and two thirds is a cubic of time.
fn keys(pelvis: &[PelvisKey]) -> String {
    let speed = |i: usize, c: usize| {
        if pelvis[i].still || i == 0 || i + 1 == pelvis.len() {
            return 0.0;
        }
        let (a, b) = (&pelvis[i - 1], &pelvis[i + 1]);
        (b.place[c] - a.place[c]) / (b.at_s - a.at_s)
    };
    let mut out = String::new();
    for i in 1..pelvis.len() {
        let (a, b) = (&pelvis[i - 1], &pelvis[i]);
        let seconds = b.at_s - a.at_s;
        let mut curves = Vec::new();
        for (c, name) in ["pelvis_x", "pelvis_z"].into_iter().enumerate() {
            let way = b.place[c] - a.place[c];
            if way.abs() > 1e-3 {
                let handle = |v: f64| v * seconds / (3.0 * way);
                let (y1, y2) = (handle(speed(i - 1, c)), 1.0 - handle(speed(i, c)));
                curves.push(format!(
                    "\"{name}\": (curve: Bezier(0.3333, {}, 0.6667, {}))",
                    short(y1, 3),
                    short(y2, 3)
                ));
            }
        }
        let elements = if curves.is_empty() {
            String::new()
        } else {
            format!(", elements: {{ {} }}", curves.join(", "))
        };
        let _ = writeln!(
            out,
            "            Pose(duration_s: {}, set_m: {{ \"pelvis_x\": {}, \"pelvis_y\": {}, \"pelvis_z\": {} }}{elements}),",
            short(seconds, 4),
            short(b.place[0], 4),
            short(b.height, 4),
            short(b.place[1], 4)
        );
    }
    out
}

/// A number with at most so many digits after the point.
fn short(x: f64, digits: usize) -> String {
    let text = format!("{x:.digits$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".into() } else { text.into() }
}
