//! A body for any human-like skeleton.
//!
//! In: a [`Skeleton`] in metres whose root is `Free`. Out: a [`Character`] with the same links at the
//! same indices, and a [`BodyReport`] that says what was guessed and how. Fingers, toes and helper
//! links are welded (`Fixed`, massless); everything else keeps its joint.
//!
//! Rules: stature from crown to sole in the neutral pose; mass from a body-mass index of 23 kg/m² (the
//! middle of the normal range, 18.5–24.9, of WHO Technical Report 894, 2000) unless given; segment
//! masses, centres and radii of gyration from [`segments`](super::segments), lengths from the
//! skeleton; the trunk's mass goes to its links by the slice of the trunk between their joints; a
//! fifth of head-with-neck goes to the neck joints by length, a tenth of the upper trunk to each
//! collar bone (the table has neither).

use argmin::core::{CostFunction, Executor};
use argmin::solver::brent::BrentRoot;
use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;

use motion::rotation::exp;
use motion::skeleton::SkeletonError;
use motion::{Joint, Limb, LimbKind, Quat, Shape, Site, Skeleton, Vec3};
use nalgebra::Matrix3;

use super::aliases::{Anatomy, Role, Side};
use super::error::GuessError;
use super::frame::{Neutral, Posed, UP};
use super::limits::{NeckShare, center_rotation, joint_limits};
use super::segments::{Segment, Sex, Table};
use super::shapes::{self, FootBox};
use crate::character::{Body, Character};

/// What may be told about a body; everything has a default.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BodyOptions {
    /// Name of the character; `body` if none.
    pub name: Option<String>,
    /// Mass, kg; by default 23 kg/m² times the square of the stature.
    pub mass_kg: Option<f64>,
    /// Which column of the segment table.
    pub sex: Sex,
    /// A standing pose to read left, front and limb directions from; by default the zero pose. With it the zero frames of the
    /// character are turned to the centres of its joints' ranges: see [`crate::PoseMap`].
    pub reference: Option<Vec<f64>>,
    /// What the motion that the reference is a frame of says of its limbs.
    pub posed: Posed,
    /// Angle between the hanging arms and the vertical in the rest pose, rad; by default 8°.
    pub rest_abduction: Option<f64>,
    /// How the joints of the neck and the head share the cervical range.
    pub neck: NeckShare,
}

/// One line of a [`BodyReport`].
#[derive(Clone, Debug, PartialEq)]
pub struct ReportRow {
    /// Link.
    pub link: String,
    /// What it was taken for.
    pub role: Role,
    /// Mass, kg.
    pub mass: f64,
    /// Whether it was welded to its parent.
    pub welded: bool,
}

/// What was guessed, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyReport {
    /// Crown to sole in the neutral pose, m.
    pub stature: f64,
    /// Total mass, kg.
    pub mass: f64,
    /// Height of the centre of mass above the soles in the rest pose, as part of the stature.
    pub com_height: f64,
    /// Links in order.
    pub rows: Vec<ReportRow>,
    /// Decisions in words.
    pub notes: Vec<String>,
}

impl fmt::Display for BodyReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (s, m, c) = (self.stature, self.mass, 100.0 * self.com_height);
        writeln!(f, "body: stature {s:.3} m, mass {m:.1} kg, centre of mass at {c:.1} % of stature")?;
        for row in self.rows.iter().filter(|r| !r.welded) {
            writeln!(f, "  {:<20} {:<16} {:>7.3} kg", row.link, row.role, row.mass)?;
        }
        let welded: Vec<_> = self.rows.iter().filter(|r| r.welded).map(|r| r.link.as_str()).collect();
        if !welded.is_empty() {
            writeln!(f, "  welded: {}", welded.join(", "))?;
        }
        self.notes.iter().try_for_each(|n| writeln!(f, "  note: {n}"))
    }
}

/// Body-mass index that gives the mass of a body of unknown mass, kg/m².
pub const DEFAULT_BMI: f64 = 23.0;

/// Builds a body for a human-like skeleton; see the module header.
///
/// # Errors
/// See [`GuessError`].
pub fn guess_body(skeleton: &Skeleton, options: &BodyOptions) -> Result<(Character, BodyReport), GuessError> {
    if let Some(m) = options.mass_kg.filter(|m| !(*m > 0.0 && m.is_finite())) {
        return Err(GuessError::Mass(m));
    }
    if skeleton.links()[0].joint != Joint::Free {
        return Err(GuessError::Root(skeleton.links()[0].name.clone()));
    }
    let anatomy = Anatomy::of(skeleton)?;
    let reference = options.reference.clone().unwrap_or_else(|| skeleton.zero_pose());
    if reference.len() != skeleton.nq() {
        return Err(GuessError::Reference { found: reference.len(), needed: skeleton.nq() });
    }
    let table = Table::of(options.sex);
    let posed = options.reference.is_some();
    let motion = posed.then_some(&options.posed);
    let neutral = Neutral::new(skeleton, &anatomy, &reference, motion, table)?;
    let centred = if posed { Some(centred(skeleton, &anatomy, &neutral, &reference)?) } else { None };
    let skeleton = centred.as_ref().unwrap_or(skeleton);
    let mut builder = Builder::new(skeleton, &anatomy, &neutral, table, options);
    builder.segments();
    let (skeleton, contacts) = builder.skeleton()?;
    let rest = builder.rest(&skeleton, options.rest_abduction.unwrap_or(8f64.to_radians()));
    let character = Character {
        name: options.name.clone().unwrap_or_else(|| "body".into()),
        classes: anatomy.roles.iter().map(|r| r.class()).collect(),
        bodies: builder.bodies.clone(),
        skeleton: Arc::new(skeleton),
        contacts,
        rest,
    }
    .check()?;
    let report = builder.report(&character, options);
    Ok((character, report))
}

/// The skeleton with its zero frames turned so that its zero pose says something: balls at the centre of their ranges,
/// everything else as in the reference.
fn centred(
    skeleton: &Skeleton,
    anatomy: &Anatomy,
    neutral: &Neutral,
    reference: &[f64],
) -> Result<Skeleton, SkeletonError> {
    let mut links = skeleton.links().to_vec();
    for (i, link) in links.iter_mut().enumerate().skip(1) {
        let turn = match link.joint {
            Joint::Spherical => center_rotation(skeleton, anatomy, neutral, i)
                .unwrap_or_else(|| skeleton.rotation(reference, i)),
            Joint::Revolute(_) => skeleton.rotation(reference, i),
            Joint::Free | Joint::Prismatic(_) | Joint::Fixed => continue,
        };
        link.parent_from_zero.rotation *= turn;
    }
    Skeleton::new(links)
}

struct Builder<'a> {
    source: &'a Skeleton,
    anatomy: &'a Anatomy,
    n: &'a Neutral,
    table: &'static Table,
    stature: f64,
    mass: f64,
    /// Crown of the head, neutral, world, m.
    crown: Vec3,
    feet: [FootBox; 2],
    bodies: Vec<Body>,
    neck: NeckShare,
}

impl<'a> Builder<'a> {
    fn new(
        s: &'a Skeleton,
        anatomy: &'a Anatomy,
        n: &'a Neutral,
        table: &'static Table,
        options: &BodyOptions,
    ) -> Self {
        let mass = options.mass_kg;
        let crown = n.origin[anatomy.head] + n.bone_in_world(anatomy.head);
        let feet = [0, 1].map(|side| FootBox::of_foot(s, n, anatomy.legs[side][2]));
        let ground = 0.5 * (feet[0].under_ankle.y + feet[1].under_ankle.y);
        let stature = crown.y - ground;
        let foot = table.foot.length / table.stature * stature.min(n.leg_stature);
        let feet = feet.map(|f| f.with_length(foot));
        let empty = Body { mass: 0.0, com: Vec3::zeros(), inertia: Matrix3::zeros(), shapes: Vec::new() };
        Self {
            source: s,
            anatomy,
            n,
            table,
            stature,
            mass: mass.unwrap_or(DEFAULT_BMI * stature * stature),
            crown,
            feet,
            bodies: vec![empty; s.links().len()],
            neck: options.neck,
        }
    }

    /// Mass of a fraction of the body; the table's own rounding is divided out.
    fn kg(&self, fraction: f64) -> f64 {
        self.mass * fraction / self.table.total()
    }

    fn segments(&mut self) {
        self.trunk();
        self.head_and_neck();
        for side in 0..2 {
            let [upper, fore, hand] = self.anatomy.arms[side];
            let [thigh, shin, foot] = self.anatomy.legs[side];
            self.limb_segment(upper, self.table.upper_arm, shapes::upper_arm(self.n, upper, self.stature));
            self.limb_segment(fore, self.table.forearm, shapes::forearm(self.n, fore, self.stature));
            self.limb_segment(thigh, self.table.thigh, shapes::thigh(self.n, thigh, self.stature));
            self.limb_segment(shin, self.table.shank, shapes::shin(self.n, shin, self.stature));
            // The table's hand ends at the third knuckle, whatever the rig has for fingers.
            let length = self.table.hand.length * self.stature / self.table.stature;
            let along = self.n.bone_in_world(hand).normalize() * length;
            self.segment(hand, self.table.hand, self.n.origin[hand], along);
            self.bodies[hand].shapes = shapes::hand(self.n, hand, self.stature);
            let flesh = self.feet[side];
            let heel = self.n.offset(&flesh.under_ankle, 0.0, 0.45 * flesh.height, -flesh.back);
            self.segment(foot, self.table.foot, heel, self.n.front * (flesh.front + flesh.back));
            self.bodies[foot].shapes = vec![flesh.shape(self.n, foot)];
        }
    }

    /// A limb segment between its joint and the next.
    fn limb_segment(&mut self, link: usize, row: Segment, shapes: Vec<Shape>) {
        self.segment(link, row, self.n.origin[link], self.n.bone_in_world(link));
        self.bodies[link].shapes = shapes;
    }

    /// Mass, centre and inertia of a segment that starts at `from` and runs `along` (world, m).
    fn segment(&mut self, link: usize, row: Segment, from: Vec3, along: Vec3) {
        let length = along.norm();
        let long = along / length;
        let side = (self.n.left - long * self.n.left.dot(&long)).normalize();
        let sagittal = long.cross(&side);
        let [s, t, l] = row.gyration.map(|r| (r * length).powi(2));
        let per_kg = outer(&sagittal) * s + outer(&side) * t + outer(&long) * l;
        self.set_body(link, self.kg(row.mass), from + along * row.com, per_kg);
    }

    /// Stores a body given in the neutral world.
    fn set_body(&mut self, link: usize, mass: f64, com: Vec3, inertia_per_kg: Matrix3<f64>) {
        let r = self.n.rotation[link].to_rotation_matrix();
        let local = r.matrix().transpose() * inertia_per_kg * r.matrix() * mass;
        let body = &mut self.bodies[link];
        body.mass = mass;
        body.com = self.n.to_link(link, &com);
        body.inertia = (local + local.transpose()) * 0.5;
    }

    /// Pelvis and spine: each takes the slice of the trunk between its joint and the next.
    fn trunk(&mut self) {
        let (a, n) = (self.anatomy, self.n);
        let hips = n.middle(a.legs[0][0], a.legs[1][0]);
        let shoulders = n.middle(a.arms[0][0], a.arms[1][0]);
        let neck = n.origin[a.neck.first().copied().unwrap_or(a.head)];
        // files of amc2bvh have no bone below the neck, so that the neck is too low: the trunk then ends at the shoulders
        let top =
            Vec3::new(0.5 * (neck.x + shoulders.x), neck.y.max(shoulders.y), 0.5 * (neck.z + shoulders.z));
        let at = |s: f64| hips + (top - hips) * s;
        let length = (top - hips).norm();
        let mut links = vec![0];
        links.extend(&a.spine);
        let k = links.len();
        let mut cuts: Vec<f64> = vec![-0.2];
        for (i, &link) in links.iter().enumerate().skip(1) {
            let s = (n.origin[link].y - hips.y) / (top.y - hips.y);
            // every link of the trunk keeps at least 6 % of its length: a link without mass could not move what it carries
            let least = cuts[i - 1].max(0.0) + 0.06;
            cuts.push(s.max(least).min(1.0 - 0.06 * (k - i) as f64));
        }
        cuts.push(1.05);
        let trunk = self.table.trunk();
        let clavicle_share = 0.1 * self.table.upper_trunk.mass;
        let clavicles = a.clavicles.iter().flatten().count() as f64;
        for (i, &link) in links.iter().enumerate() {
            let slab = trunk.slab(cuts[i], cuts[i + 1]);
            let mut mass = slab.mass;
            if i == k - 1 {
                mass -= clavicle_share * clavicles;
            }
            // spreads are of the table's subjects; breadth goes with stature
            let scale = (self.stature / self.table.stature).powi(2);
            let (x, z) = (slab.spread[0] * scale, slab.spread[1] * scale);
            let y = slab.height_spread * length * length;
            let per_kg = outer(&n.left) * (y + z) + outer(&UP) * (x + z) + outer(&n.front) * (x + y);
            self.set_body(link, self.kg(mass), at(slab.height), per_kg);
            let hi = if i == k - 1 { 1.0 } else { cuts[i + 1] };
            let lo = if i == 0 { -0.12 } else { cuts[i] };
            self.bodies[link].shapes = shapes::trunk_slab(n, link, self.stature, lo, hi, at);
        }
        for &c in a.clavicles.iter().flatten() {
            let bone = n.bone_in_world(c);
            let radius = 0.034 * self.stature;
            // a solid capsule, near enough: r²/2 along, r²/4 + l²/12 across
            let l2 = bone.norm_squared();
            let long = bone.normalize();
            let across = radius * radius / 4.0 + l2 / 12.0;
            let per_kg =
                outer(&long) * (radius * radius / 2.0) + (Matrix3::identity() - outer(&long)) * across;
            self.set_body(c, self.kg(clavicle_share), n.origin[c] + bone * 0.6, per_kg);
            self.bodies[c].shapes = shapes::clavicle(n, c, self.stature);
        }
    }

    /// Head with neck: together they have the table's mass and centre.
    fn head_and_neck(&mut self) {
        let (a, n, row) = (self.anatomy, self.n, self.table.head);
        let length = row.length * self.stature / self.table.stature;
        let bones: Vec<f64> = a.neck.iter().map(|&i| n.bone[i].norm().max(1e-3)).collect();
        let total: f64 = bones.iter().sum();
        let neck_share = if a.neck.is_empty() { 0.0 } else { 0.2 };
        let mut neck_moment = Vec3::zeros();
        for (&i, bone) in a.neck.iter().zip(&bones) {
            let share = neck_share * bone / total;
            let com = n.origin[i] + n.bone_in_world(i) * 0.5;
            neck_moment += com * share;
            let (r2, l2) = ((0.032 * self.stature).powi(2), bone * bone);
            let upright =
                outer(&UP) * (r2 / 2.0) + (Matrix3::identity() - outer(&UP)) * (r2 / 4.0 + l2 / 12.0);
            self.set_body(i, self.kg(row.mass * share), com, upright);
            self.bodies[i].shapes = shapes::neck(n, i, self.stature);
        }
        let both = self.crown - UP * (row.com * length);
        let com = (both - neck_moment) / (1.0 - neck_share);
        let [s, t, l] = row.gyration.map(|r| (r * length).powi(2));
        let per_kg = outer(&n.front) * s + outer(&n.left) * t + outer(&UP) * l;
        self.set_body(a.head, self.kg(row.mass * (1.0 - neck_share)), com, per_kg);
        self.bodies[a.head].shapes = shapes::head(n, a.head, self.stature, &self.crown);
    }

    /// The character's skeleton and the indices of its contact sites.
    fn skeleton(&self) -> Result<(Skeleton, Vec<usize>), SkeletonError> {
        let (a, n) = (self.anatomy, self.n);
        let mut links = self.source.links().to_vec();
        for (i, link) in links.iter_mut().enumerate() {
            if a.roles[i].is_welded() {
                (link.joint, link.limits) = (Joint::Fixed, None);
            } else {
                link.limits = joint_limits(self.source, a, n, self.neck, i);
            }
        }
        let mut sites = Vec::new();
        for (side, leg) in Side::BOTH.into_iter().zip(a.legs) {
            let foot = &self.feet[if side == Side::Left { 0 } else { 1 }];
            for (name, at) in foot.corners(n, leg[2], side) {
                sites.push(Site { name, link: leg[2], at });
            }
        }
        let contacts = (0..sites.len()).collect();
        for (side, arm) in Side::BOTH.into_iter().zip(a.arms) {
            let name = format!("hand_tip_{}", side.letter());
            sites.push(Site { name, link: arm[2], at: n.bone[arm[2]] });
        }
        let eyes = n.offset(&self.crown, 0.0, -0.064 * self.stature, 0.055 * self.stature);
        sites.push(Site { name: "eyes".into(), link: a.head, at: n.to_link(a.head, &eyes) });
        sites.push(Site { name: "crown".into(), link: a.head, at: n.to_link(a.head, &self.crown) });

        let limb = |kind, side: Side, [upper, lower, end]: [usize; 3]| {
            let word = if kind == LimbKind::Arm { "arm" } else { "leg" };
            Limb { name: format!("{word}_{}", side.letter()), kind, upper, lower, end }
        };
        let mut limbs = Vec::new();
        for (k, side) in Side::BOTH.into_iter().enumerate() {
            limbs.push(limb(LimbKind::Arm, side, a.arms[k]));
            limbs.push(limb(LimbKind::Leg, side, a.legs[k]));
        }
        let of = |keep: &dyn Fn(Role) -> bool| -> Vec<usize> {
            (0..links.len()).filter(|&i| keep(a.roles[i]) && !a.roles[i].is_welded()).collect()
        };
        let is_leg = |r: Role| matches!(r, Role::Thigh(_) | Role::Shin(_) | Role::Foot(_));
        let parts = BTreeMap::from([
            ("trunk".to_string(), of(&|r| matches!(r, Role::Pelvis | Role::Spine))),
            ("head".to_string(), of(&|r| matches!(r, Role::Neck | Role::Head))),
            ("upper".to_string(), of(&|r| r != Role::Pelvis && !is_leg(r))),
            ("lower".to_string(), of(&|r| r == Role::Pelvis || is_leg(r))),
        ]);
        let skeleton = Skeleton::new(links)?.with_sites(sites)?.with_limbs(limbs)?.with_parts(parts)?;
        Ok((skeleton, contacts))
    }

    /// Standing at ease: arms hang away from the trunk, elbows and knees a little bent, feet flat on
    /// height 0, the legs leaning so that the centre of mass is above the middle of the soles.
    fn rest(&self, skeleton: &Skeleton, abduction: f64) -> Vec<f64> {
        // The centre of mass moves forward with the lean, monotonically.
        let (back, front) = (-10f64.to_radians(), 15f64.to_radians());
        let lean = root_between(back, front, |lean| self.standing_pose(skeleton, abduction, lean).1);
        self.standing_pose(skeleton, abduction, lean).0
    }

    /// The pose with a given lean of the thighs, and how far the centre of mass is ahead of the soles.
    fn standing_pose(&self, skeleton: &Skeleton, abduction: f64, lean: f64) -> (Vec<f64>, f64) {
        const KNEE: f64 = 3.0 * std::f64::consts::PI / 180.0;
        const ELBOW: f64 = 10.0 * std::f64::consts::PI / 180.0;
        let n = self.n;
        let mut q = skeleton.zero_pose();
        let mut world: Vec<Quat> = Vec::new();
        for (i, link) in skeleton.links().iter().enumerate() {
            let turn = match self.anatomy.roles[i] {
                Role::Thigh(_) => exp(&(n.left * lean)),
                Role::Shin(_) => exp(&(n.left * (lean + KNEE))),
                Role::UpperArm(s) => exp(&(n.front * (s.sign() * abduction))),
                Role::Forearm(s) | Role::Hand(s) => {
                    exp(&(n.front * (s.sign() * abduction))) * exp(&(n.left * -ELBOW))
                }
                _ => Quat::identity(),
            };
            let zero = link.parent.map_or(Quat::identity(), |p| world[p]) * link.parent_from_zero.rotation;
            let wanted = zero.inverse() * turn * n.rotation[i];
            match link.joint {
                Joint::Free | Joint::Spherical => skeleton.set_rotation(&mut q, i, &wanted),
                Joint::Revolute(axis) => q[skeleton.q_at(i)] = motion::rotation::log(&wanted).dot(&axis),
                Joint::Prismatic(_) | Joint::Fixed => {}
            }
            world.push(zero * skeleton.rotation(&q, i));
        }
        // Put the soles on height 0 and their middle on the vertical through the origin.
        let k = motion::Kinematics::new(skeleton, &q);
        let corners: Vec<Vec3> = skeleton.sites()[..8].iter().map(|s| k.point(s.link, &s.at)).collect();
        let middle = corners.iter().sum::<Vec3>() / 8.0;
        let com = self.bodies.iter().enumerate().map(|(i, b)| k.point(i, &b.com) * b.mass).sum::<Vec3>()
            / self.mass;
        let root = skeleton.position(&q, 0) - middle;
        skeleton.set_position(&mut q, 0, &root);
        (q, (com - middle).dot(&n.front))
    }

    fn report(&self, c: &Character, options: &BodyOptions) -> BodyReport {
        let k = motion::Kinematics::new(&c.skeleton, &c.rest);
        let com =
            c.bodies.iter().enumerate().map(|(i, b)| k.point(i, &b.com).y * b.mass).sum::<f64>() / self.mass;
        let rows = c.skeleton.links().iter().zip(&self.anatomy.roles).zip(&c.bodies);
        let rows = rows.map(|((l, &role), b)| ReportRow {
            link: l.name.clone(),
            role,
            mass: b.mass,
            welded: l.joint == Joint::Fixed,
        });
        let mut notes = Vec::new();
        if options.mass_kg.is_none() {
            notes.push(format!("mass from stature at {DEFAULT_BMI} kg/m²"));
        }
        let sex = match options.sex {
            Sex::Female => "women",
            Sex::Male => "men",
        };
        notes.push(format!("segment masses, centres and radii of gyration: de Leva 1996, Table 4, {sex}"));
        notes.push("limits: Boone & Azen 1979, AAOS 1965, Inman 1944, widened for dance".into());
        let pose = if options.reference.is_some() { "given reference pose" } else { "zero pose" };
        notes.push(format!("left, front and limb directions from the {pose}"));
        let (x, z) = (self.n.front.x, self.n.front.z);
        notes.push(format!(
            "front ({x:.2}, 0, {z:.2}) from the hips, soles from what hangs on the ankles; a character file says others"
        ));
        let suggested = self.n.leg_stature;
        if (self.stature / suggested - 1.0).abs() > 0.12 {
            notes.push(format!("the legs suggest a stature of {suggested:.3} m: unusual proportions"));
        }
        BodyReport {
            stature: self.stature,
            mass: self.mass,
            com_height: com / self.stature,
            rows: rows.collect(),
            notes,
        }
    }
}

fn outer(v: &Vec3) -> Matrix3<f64> {
    v * v.transpose()
}

/// Root of an increasing function between `lo` and `hi` by Brent's method, to 1e-12; the nearer end where it
/// has none.
fn root_between(lo: f64, hi: f64, f: impl Fn(f64) -> f64) -> f64 {
    struct Function<F>(F);
    impl<F: Fn(f64) -> f64> CostFunction for Function<F> {
        type Param = f64;
        type Output = f64;
        fn cost(&self, x: &f64) -> Result<f64, argmin::core::Error> {
            Ok(self.0(*x))
        }
    }
    if f(lo) >= 0.0 {
        return lo;
    }
    if f(hi) <= 0.0 {
        return hi;
    }
    let solver = BrentRoot::new(lo, hi, 1e-12);
    let run = Executor::new(Function(f), solver).configure(|s| s.param(0.5 * (lo + hi)).max_iters(100)).run();
    run.ok().and_then(|r| r.state.best_param).unwrap_or(0.5 * (lo + hi))
}
