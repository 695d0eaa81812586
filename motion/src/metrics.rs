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
    let (mut ka, mut kb) = (Kinematics::new(&a.skeleton, a.pose(0)), Kinematics::new(&b.skeleton, b.pose(0)));
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
    /// MANN skate measure, mean over points and frames, mm/s.
    pub skate_mm_s: f64,
    /// Largest depth of a point below the plane, mm.
    pub penetration_mm_max: f64,
    /// Largest height of the lowest point above the plane, mm: how far the body floats.
    pub float_mm_max: f64,
}

/// A point is down below this height above the plane, m.
const DOWN: f64 = 0.010;
/// Height scale of the skate measure, m.
const SKATE_HEIGHT: f64 = 0.025;

/// Foot numbers of `sites` over a plane at `ground_m`.
pub fn feet(clip: &Clip, sites: &[&Site], ground_m: f64) -> FeetMetrics {
    let mut out = FeetMetrics::default();
    if sites.is_empty() {
        return out;
    }
    let mut k = Kinematics::new(&clip.skeleton, clip.pose(0));
    let mut before: Vec<Vec3> = Vec::new();
    let mut landed: Vec<Option<Vec3>> = vec![None; sites.len()];
    let mut skate = 0.0;
    for f in 0..clip.frames() {
        k.update(&clip.skeleton, clip.pose(f));
        let points: Vec<Vec3> = sites.iter().map(|s| k.point(s.link, &s.at)).collect();
        let lowest = points.iter().map(|p| p.y - ground_m).fold(f64::INFINITY, f64::min);
        out.penetration_mm_max = out.penetration_mm_max.max(-1e3 * lowest);
        out.float_mm_max = out.float_mm_max.max(1e3 * lowest);
        for (i, p) in points.iter().enumerate() {
            if p.y - ground_m > DOWN {
                landed[i] = None;
            } else {
                let start = *landed[i].get_or_insert(*p);
                let travel = (p.x - start.x).hypot(p.z - start.z);
                out.slip_mm_max = out.slip_mm_max.max(1e3 * travel);
            }
            if let Some(b) = before.get(i) {
                let speed = (p.x - b.x).hypot(p.z - b.z) * clip.rate_hz;
                let weight = 2.0 - 2f64.powf(((p.y - ground_m) / SKATE_HEIGHT).clamp(0.0, 1.0));
                skate += 1e3 * speed * weight;
            }
        }
        before = points;
    }
    out.skate_mm_s = skate / (sites.len() * clip.frames().saturating_sub(1).max(1)) as f64;
    out
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
}
