//! Numbers that speak: how far a motion is from another, and what its feet do.
//!
//! In: clips. Out: degrees and millimetres, as people read them. DESIGN §9.
//!
//! Foot skate is the measure of MANN [Zhang et al., Mode-Adaptive Neural Networks, SIGGRAPH 2018]: the
//! horizontal speed of a point weighted by `2 − 2^{clamp(h/H, 0, 1)}`, H = 25 mm above the point's own rest
//! height.

use crate::rotation::log;
use crate::skeleton::{Joint, Site};
use crate::{Clip, Kinematics, Vec3};

/// RMS angle between two motions of one joint.
#[derive(Clone, Debug, PartialEq)]
pub struct JointError {
    /// The link.
    pub link: usize,
    /// RMS angle over the frames, degrees.
    pub rms_deg: f64,
    /// Largest angle, degrees.
    pub peak_deg: f64,
}

/// RMS angle of every rotating joint below the root between two clips of one skeleton, over the frames
/// both have. Balls count the angle of the whole rotation between them.
///
/// # Panics
/// If the skeletons differ in layout.
pub fn joint_errors(a: &Clip, b: &Clip) -> Vec<JointError> {
    assert_eq!(a.skeleton.nq(), b.skeleton.nq(), "clips of different skeletons");
    let frames = a.frames().min(b.frames());
    let mut out = Vec::new();
    for (link, l) in a.skeleton.links().iter().enumerate().skip(1) {
        if !matches!(l.joint, Joint::Spherical | Joint::Revolute(_)) {
            continue;
        }
        let (mut sum, mut peak) = (0.0, 0.0_f64);
        for f in 0..frames {
            let (qa, qb) = (a.pose(f), b.pose(f));
            let angle = match l.joint {
                Joint::Revolute(_) => (qa[a.skeleton.q_at(link)] - qb[b.skeleton.q_at(link)]).abs(),
                _ => {
                    let turn = a.skeleton.rotation(qa, link) * b.skeleton.rotation(qb, link).inverse();
                    log(&turn).norm()
                }
            };
            sum += angle * angle;
            peak = peak.max(angle);
        }
        let rms_deg = (sum / frames.max(1) as f64).sqrt().to_degrees();
        out.push(JointError { link, rms_deg, peak_deg: peak.to_degrees() });
    }
    out
}

/// RMS over joints of their RMS angles, degrees; zero without joints.
pub fn joint_rms_deg<'a>(errors: impl IntoIterator<Item = &'a JointError>) -> f64 {
    let (sum, n) = errors.into_iter().fold((0.0, 0), |(s, n), e| (s + e.rms_deg * e.rms_deg, n + 1));
    if n == 0 { 0.0 } else { (sum / f64::from(n)).sqrt() }
}

/// RMS distance between the links' origins of two clips, mm.
pub fn position_rms_mm(a: &Clip, b: &Clip) -> f64 {
    let frames = a.frames().min(b.frames());
    let mut ka = Kinematics::new(&a.skeleton, &a.skeleton.zero_pose());
    let mut kb = ka.clone();
    let mut sum = 0.0;
    for f in 0..frames {
        ka.update(&a.skeleton, a.pose(f));
        kb.update(&b.skeleton, b.pose(f));
        for (x, y) in ka.world.iter().zip(&kb.world) {
            sum += (x.translation.vector - y.translation.vector).norm_squared();
        }
    }
    1e3 * (sum / (frames * ka.world.len()).max(1) as f64).sqrt()
}

/// What the contact points of a motion do on a plane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FeetMetrics {
    /// Largest horizontal travel of a point while it stays down, mm.
    pub slip_mm_max: f64,
    /// Which point that was.
    pub slip_point: usize,
    /// The frame in which it had travelled so far.
    pub slip_frame: usize,
    /// MANN skate measure, mean over points and frames, mm/s.
    pub skate_mm_s: f64,
    /// Largest depth of a point below the plane, mm.
    pub penetration_mm_max: f64,
    /// Largest height of the lowest point above the plane, mm: how far the body floats.
    pub float_mm_max: f64,
}

/// A point is down below this height above the plane, m, ...
const DOWN: f64 = 0.010;
/// ... and below this speed along it, m/s. A swinging foot passes the ground by a centimetre or two, and the tips of welded
/// toes, which rolled under the ground, by less; it is faster than this from the last centimetre of its roll on.
const SWINGS: f64 = 0.6;
/// Height scale of the skate measure, m.
const SKATE_HEIGHT: f64 = 0.025;

/// Foot numbers of `sites` over a plane at `ground_m`.
pub fn feet(clip: &Clip, sites: &[&Site], ground_m: f64) -> FeetMetrics {
    let mut meter = FeetMeter::new(sites.len(), clip.rate_hz);
    let mut k = Kinematics::new(&clip.skeleton, &clip.skeleton.zero_pose());
    for f in 0..clip.frames() {
        k.update(&clip.skeleton, clip.pose(f));
        meter.add(sites.iter().map(|s| (k.point(s.link, &s.at) - Vec3::y() * ground_m, false)));
    }
    meter.finish()
}

/// Follows contact points over the ground, frame by frame: what [`feet`] measures.
#[derive(Clone, Debug)]
pub struct FeetMeter {
    rate_hz: f64,
    /// Where each point came down, while it is.
    landed: Vec<Option<Vec3>>,
    before: Vec<Vec3>,
    now: Vec<Vec3>,
    loaded: Vec<bool>,
    frames: usize,
    skate: f64,
    out: FeetMetrics,
}

impl FeetMeter {
    /// Of so many points, no frame yet.
    pub fn new(points: usize, rate_hz: f64) -> Self {
        Self {
            rate_hz,
            landed: vec![None; points],
            before: Vec::with_capacity(points),
            now: Vec::with_capacity(points),
            loaded: Vec::with_capacity(points),
            frames: 0,
            skate: 0.0,
            out: FeetMetrics::default(),
        }
    }

    /// Adds a frame: every point with its height over the ground as `y`, and as `x`, `z` its place on it, m; and whether
    /// its foot is known to bear load. Such a foot slides, however fast it is.
    pub fn add(&mut self, points: impl IntoIterator<Item = (Vec3, bool)>) {
        self.now.clear();
        self.loaded.clear();
        for (p, loaded) in points {
            self.now.push(p);
            self.loaded.push(loaded);
        }
        let frame = self.frames;
        self.frames += 1;
        if self.now.is_empty() {
            return;
        }
        let lowest = self.now.iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
        let out = &mut self.out;
        out.penetration_mm_max = out.penetration_mm_max.max(-1e3 * lowest);
        out.float_mm_max = out.float_mm_max.max(1e3 * lowest);
        for (i, p) in self.now.iter().enumerate() {
            let speed = self.before.get(i).map_or(0.0, |b| (p.x - b.x).hypot(p.z - b.z) * self.rate_hz);
            if p.y > DOWN || (speed > SWINGS && !self.loaded[i]) {
                self.landed[i] = None;
            } else {
                let start = *self.landed[i].get_or_insert(*p);
                let travel = 1e3 * (p.x - start.x).hypot(p.z - start.z);
                if travel > out.slip_mm_max {
                    (out.slip_mm_max, out.slip_point, out.slip_frame) = (travel, i, frame);
                }
            }
            let weight = 2.0 - 2f64.powf((p.y / SKATE_HEIGHT).clamp(0.0, 1.0));
            self.skate += 1e3 * speed * weight;
        }
        std::mem::swap(&mut self.before, &mut self.now);
    }

    /// The numbers so far; all zero without points.
    pub fn finish(&self) -> FeetMetrics {
        let counted = self.landed.len() * self.frames.saturating_sub(1);
        FeetMetrics { skate_mm_s: self.skate / counted.max(1) as f64, ..self.out }
    }
}

/// RMS jerk (third derivative) of the links' origins, m/s³, by central differences.
pub fn jerk_rms(clip: &Clip) -> f64 {
    let n = clip.frames();
    if n < 4 {
        return 0.0;
    }
    let rate = clip.rate_hz;
    let places: Vec<Vec<Vec3>> = (0..n)
        .map(|f| {
            let k = Kinematics::new(&clip.skeleton, clip.pose(f));
            k.world.iter().map(|t| t.translation.vector).collect()
        })
        .collect();
    let mut sum = 0.0;
    for f in 0..n - 3 {
        for l in 0..places[0].len() {
            let third = places[f + 3][l] - places[f + 2][l] * 3.0 + places[f + 1][l] * 3.0 - places[f][l];
            sum += (third * rate.powi(3)).norm_squared();
        }
    }
    (sum / ((n - 3) * places[0].len()) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Link, Skeleton};
    use std::sync::Arc;

    fn slider() -> Arc<Skeleton> {
        let links = vec![
            Link::new("root", None, Vec3::zeros(), Joint::Free),
            Link::new("arm", Some(0), Vec3::y(), Joint::Revolute(Vec3::x())),
        ];
        Arc::new(Skeleton::new(links).unwrap())
    }

    #[test]
    fn a_constant_offset_is_its_own_rms() {
        let s = slider();
        let (mut a, mut b) = (s.zero_pose(), s.zero_pose());
        b[7] = 0.1;
        a.extend(a.clone());
        b.extend(b.clone());
        let errors = joint_errors(&Clip::new(s.clone(), 10.0, a), &Clip::new(s, 10.0, b));
        assert!((joint_rms_deg(&errors) - 0.1_f64.to_degrees()).abs() < 1e-12);
        assert!((errors[0].peak_deg - 0.1_f64.to_degrees()).abs() < 1e-12);
    }

    /// A point that slides 1 cm/s on the plane for a second, then lifts.
    #[test]
    fn feet_numbers_have_known_values() {
        let s = slider();
        let mut q = Vec::new();
        for f in 0..=20 {
            let mut pose = s.zero_pose();
            let t = f64::from(f) / 10.0;
            let lift = if t > 1.0 { 0.05 } else { -0.002 };
            s.set_position(&mut pose, 0, &Vec3::new(0.01 * t, lift, 0.0));
            q.extend(pose);
        }
        let clip = Clip::new(s, 10.0, q);
        let site = Site { name: "toe".into(), link: 0, at: Vec3::zeros() };
        let m = feet(&clip, &[&site], 0.0);
        assert!((m.slip_mm_max - 10.0).abs() < 1e-9);
        assert!((m.penetration_mm_max - 2.0).abs() < 1e-9);
        assert!((m.float_mm_max - 50.0).abs() < 1e-9);
        assert!((m.skate_mm_s - 5.0).abs() < 1e-9); // 10 mm/s for half the time
        assert!(jerk_rms(&clip) > 0.0);
    }

    /// A foot that swings a centimetre over the ground does not slip; one that bears load does, however fast.
    #[test]
    fn what_swings_does_not_slip() {
        let slip = |loaded: bool| {
            let mut meter = FeetMeter::new(1, 100.0);
            (0..50).for_each(|f| meter.add([(Vec3::new(0.02 * f64::from(f), 0.005, 0.0), loaded)]));
            meter.finish().slip_mm_max
        };
        assert_eq!(slip(false), 0.0); // 2 m/s
        assert!((slip(true) - 980.0).abs() < 1e-9);
    }

    /// Nothing to measure is zero, and so is what stands still.
    #[test]
    fn numbers_of_nothing_are_zero() {
        let s = slider();
        let still = Clip::new(s.clone(), 10.0, s.zero_pose());
        let none = Clip::new(s, 10.0, Vec::new());
        assert_eq!(feet(&still, &[], 0.0), FeetMetrics::default());
        let site = Site { name: "toe".into(), link: 0, at: Vec3::zeros() };
        for clip in [&still, &none] {
            assert_eq!(feet(clip, &[&site], 0.0), FeetMetrics::default());
            assert_eq!(joint_errors(clip, clip), [JointError { link: 1, rms_deg: 0.0, peak_deg: 0.0 }]);
            assert_eq!((position_rms_mm(clip, clip), jerk_rms(clip)), (0.0, 0.0));
        }
        assert_eq!(joint_rms_deg(&[]), 0.0);
    }
}
