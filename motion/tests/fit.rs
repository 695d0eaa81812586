//! Fits and blocking of sampled motion.

#[expect(dead_code, reason = "shared with other tests")]
mod human;

use std::f64::consts::TAU;

use motion::fit::blocking::{Blocking, LEAST_S};
use motion::fit::groups::groups;
use motion::fit::{FitError, lasting};
use motion::rotation::exp;
use motion::{Clip, Dof, Fit, Joint, Tolerance, Vec3};

/// Three seconds in which every joint swings, and the root goes its way.
fn clip() -> Clip {
    let s = human::skeleton();
    let mut q = Vec::new();
    for frame in 0..=270 {
        let t = f64::from(frame) / 90.0;
        let mut pose = s.zero_pose();
        for (link, l) in s.links().iter().enumerate() {
            let f = link as f64;
            let wave = |hz: f64| (TAU * hz * t + f).sin();
            match l.joint {
                Joint::Free => {
                    s.set_position(&mut pose, link, &Vec3::new(0.1 * wave(0.8), 0.9, 1.2 * t));
                    s.set_rotation(&mut pose, link, &exp(&Vec3::new(0.1 * wave(0.9), 0.7 * t, 0.0)));
                }
                Joint::Spherical => {
                    let r = Vec3::new(0.5 * wave(0.9), 0.3 * wave(1.3), 0.2 * wave(0.4));
                    s.set_rotation(&mut pose, link, &exp(&r));
                }
                Joint::Revolute(_) | Joint::Prismatic(_) => pose[s.q_at(link)] = 0.4 + 0.3 * wave(1.1),
                Joint::Fixed => {}
            }
        }
        q.extend(pose);
    }
    Clip::new(s, 90.0, q)
}

/// Every frame is within the tolerance, for close and coarse ones; a closer one takes more keys. What the report says is the largest.
#[test]
fn a_fit_keeps_its_tolerance() {
    let clip = clip();
    let s = &clip.skeleton;
    let mut keys = f64::INFINITY;
    for tolerance in
        [Tolerance { deg: 0.5, mm: 2.0 }, Tolerance::default(), Tolerance { deg: 10.0, mm: 50.0 }]
    {
        let fit = Fit::of(&clip, &tolerance).unwrap();
        let (mut deg, mut q) = (0.0_f64, vec![0.0; s.nq()]);
        for frame in 0..clip.frames() {
            fit.tracks.pose_at(frame as f64 / clip.rate_hz, &mut q);
            for dof in Dof::all(s).into_iter().filter(|d| !matches!(d, Dof::Coordinate(..))) {
                deg = deg.max(dof.read(s, &q).distance(&dof.read(s, clip.pose(frame))).to_degrees());
            }
            let way = 1e3 * (s.position(&q, 0) - s.position(clip.pose(frame), 0)).norm();
            assert!(way <= tolerance.mm, "{way} mm");
        }
        assert!(deg <= tolerance.deg && deg > 0.5 * tolerance.deg, "{deg}° of {}°", tolerance.deg);
        assert_eq!(fit.report.turned.as_ref().map(|r| r.amount), Some(deg));
        assert!(fit.report.keys_per_s < keys, "{}", fit.report);
        keys = fit.report.keys_per_s;
    }
}

/// Keys of a group are at the same times, so that each is a pose of it; elements follow one another.
#[test]
fn keys_are_poses() {
    let clip = clip();
    let fit = Fit::of(&clip, &Tolerance::default()).unwrap();
    for group in groups(&clip.skeleton) {
        let tracks = fit.tracks.tracks.iter().filter(|t| group.links.contains(&t.dof.link()));
        let times: Vec<Vec<(usize, u64, u64)>> = tracks
            .map(|t| {
                assert!(t.elements.windows(2).all(|p| p[0].arrives_s() <= p[1].start_s));
                assert!(t.elements.iter().all(|e| *e.label.action == *group.name));
                t.elements
                    .iter()
                    .map(|e| (e.label.pose, e.start_s.to_bits(), e.duration_s.to_bits()))
                    .collect()
            })
            .collect();
        assert!(!times.is_empty() && times.windows(2).all(|p| p[0] == p[1]), "{}", group.name);
    }
    assert!(fit.tracks.overlaps().is_empty());
}

/// Every moving link is in one group; an arm takes its clavicle and hand along, the trunk the rest.
#[test]
fn groups_share_out_the_body() {
    let s = human::skeleton();
    let mut all: Vec<usize> = groups(&s).into_iter().flat_map(|g| g.links).collect();
    all.sort_unstable();
    let moving = (0..s.links().len()).filter(|l| s.links()[*l].joint != Joint::Fixed);
    assert_eq!(all, moving.collect::<Vec<_>>());
    assert_eq!(groups(&s).len(), 1 + s.limbs().len());
}

#[test]
fn what_cannot_be_fitted_is_said() {
    let clip = clip();
    for (deg, mm) in [(0.0, 1.0), (1.0, -1.0), (f64::NAN, 1.0), (1.0, f64::INFINITY)] {
        assert!(matches!(Fit::of(&clip, &Tolerance { deg, mm }), Err(FitError::Tolerance { .. })));
    }
    let one = Clip::new(clip.skeleton.clone(), 90.0, clip.pose(0).to_vec());
    assert_eq!(Fit::of(&one, &Tolerance::default()), Err(FitError::Short(1)));
    // a clip that keeps still has no keys, and nothing to divide by
    let still = Clip::new(clip.skeleton.clone(), 90.0, clip.pose(0).repeat(4));
    let report = Fit::of(&still, &Tolerance::default()).unwrap().report;
    assert_eq!((report.joints, report.keys_per_s), (0, 0.0));
}

/// An element never arrives after the next begins, whatever rounding says.
#[test]
fn durations_end_in_time() {
    for i in 0..1000 {
        let (a, b) = (f64::from(i) / 119.88, f64::from(i + 7) / 119.88);
        let d = lasting(a, b);
        assert!(a + d <= b && b - a - d < 1e-12);
    }
}

/// Key poses are no nearer than a quarter of a second, and begin and end with the clip.
#[test]
fn key_poses_are_few_and_chosen() {
    let clip = clip();
    let keys = Blocking::of(&clip).keys;
    let times: Vec<f64> = keys.iter().map(|k| k.frame as f64 / clip.rate_hz).collect();
    assert!(times.windows(2).all(|p| p[1] - p[0] >= LEAST_S - 1e-9), "{times:?}");
    assert_eq!((keys[0].frame, keys[keys.len() - 1].frame), (0, clip.frames() - 1));
    let two = Clip::new(clip.skeleton.clone(), 90.0, clip.data()[..2 * clip.skeleton.nq()].to_vec());
    assert_eq!(Blocking::of(&two).keys.len(), 2);
}
