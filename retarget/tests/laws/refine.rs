//! Physics refinement.

use motion::{Clip, Kinematics, Vec3};
use retarget::refine::solids::Solids;
use retarget::refine::{apart, refine};
use retarget::{Guard, RefineDofs, RefineOptions, RefinementReport, WorldOptions};

use crate::bodies::{Held, held};

/// Shares by which Z_p falls: vertical, all.
fn falls(r: &RefinementReport) -> (f64, f64) {
    let sum = |x: &[f64; 6]| x.iter().sum::<f64>();
    (1.0 - r.after[1] / r.before[1], 1.0 - sum(&r.after) / sum(&r.before))
}

const CLIPS: [(&str, f64, f64); 4] =
    [("14_37", 0.7, 1.0), ("127_01", 1.0, 1.0), ("16_21", 0.6, 0.8), ("16_21", 1.0, 1.0)];

fn say(what: &str, r: &RefinementReport) {
    let each: Vec<f64> = (0..6).map(|c| (100.0 * (1.0 - r.after[c] / r.before[c])).round()).collect();
    println!(
        "{what}: {each:?} % {:?}, root {:.1} / {:.1} mm, slip {:.2} mm, cone {} → {}, touch {:.1} → {:.1} mm, {} steps",
        falls(r),
        1e3 * r.root_median_m,
        1e3 * r.root_largest_m,
        1e3 * r.slip_m,
        r.cone_before.len(),
        r.cone_after.len(),
        1e3 * r.collision_m[0],
        1e3 * r.collision_m[1],
        r.iterations
    );
}

/// With the root's height alone the vertical force comes to match.
#[test]
fn the_root_s_height_matches_the_vertical_force() {
    for (clip, size, legs) in CLIPS {
        let Held { puppet, clip: held, phases: found, .. } = held(clip, size, legs);
        let variance = vec![4e-4; held.frames()];
        let options = RefineOptions { collisions: false, ..RefineOptions::default() };
        let (_, r) = refine(&puppet, &held, &found, &variance, &WorldOptions::default(), &options).unwrap();
        say(&format!("{clip} × {size}, height"), &r);
        assert!(falls(&r).0 >= 0.8, "{clip}"); // 93 % seen of a walk, 99.9 % of standing
        assert!(r.root_median_m <= 0.02 && r.slip_m <= 2e-3);
    }
}

/// With root and legs, all six components.
#[test]
fn slow_root_and_legs_match_all_six() {
    for (clip, size, legs) in CLIPS {
        let Held { puppet, clip: held, phases: found, .. } = held(clip, size, legs);
        let variance = vec![4e-4; held.frames()];
        let options = RefineOptions { dofs: RefineDofs::RootAndLegs, ..RefineOptions::default() };
        let (_, r) = refine(&puppet, &held, &found, &variance, &WorldOptions::default(), &options).unwrap();
        say(&format!("{clip} × {size}, root and legs"), &r);
        assert!(falls(&r).1 >= 0.8, "{clip}"); // 88 % seen of a walk, 99.8 % of standing
        assert!(r.root_median_m <= 0.02 && r.slip_m <= 2e-3);
    }
}

/// Gravity and friction are those of the world: a body weighs what it weighs there, and a slippery ground has a narrow cone.
#[test]
fn the_world_says_what_a_body_weighs_and_where_it_slips() {
    let Held { puppet, clip, phases: found, .. } = held("16_21", 0.6, 0.8);
    let variance = vec![4e-4; clip.frames()];
    let options = RefineOptions { collisions: false, iterations: 1, ..RefineOptions::default() };
    let on = |gravity_m_s2: f64, friction: f64| {
        let world = WorldOptions { gravity_m_s2, friction, ..WorldOptions::default() };
        refine(&puppet, &clip, &found, &variance, &world, &options).unwrap().1
    };
    let (earth, mars, ice) = (on(9.81, 0.8), on(3.71, 0.8), on(9.81, 0.02));
    let mean = |r: &RefinementReport| {
        r.required_before.iter().map(|f| f.y).sum::<f64>() / r.required_before.len() as f64
    };
    let mass = puppet.character.mass();
    assert!((earth.weight_n - mass * 9.81).abs() < 1e-9 && (mars.weight_n - mass * 3.71).abs() < 1e-9);
    let lighter = mean(&earth) - mean(&mars);
    assert!((lighter - mass * 6.1).abs() < 1e-6 * mass, "{lighter}"); // accelerations are the same
    println!("outside the cone: {} frames, on ice {}", earth.cone_before.len(), ice.cone_before.len());
    assert!(ice.cone_before.len() > earth.cone_before.len() + clip.frames() / 10);
}

/// A body that hovers above the ground it should stand on feels nothing of it, and comes down all the same.
#[test]
fn the_ground_is_found_from_above() {
    for above_m in [0.005, 0.02] {
        let Held { puppet, mut clip, phases: found, .. } = held("14_37", 0.7, 1.0);
        let s = clip.skeleton.clone();
        for i in 0..clip.frames() {
            let p = s.position(clip.pose(i), 0) + Vec3::y() * above_m;
            s.set_position(clip.pose_mut(i), 0, &p);
        }
        let variance = vec![4e-4; clip.frames()];
        let options = RefineOptions { collisions: false, ..RefineOptions::default() };
        let (_, r) = refine(&puppet, &clip, &found, &variance, &WorldOptions::default(), &options).unwrap();
        say(&format!("{above_m} m above the ground"), &r);
        assert!(falls(&r).0 >= 0.99, "{above_m}"); // 99.98 % seen; 33 % from 5 mm by tangents alone
        assert!((r.root_median_m - above_m).abs() < 0.003, "{above_m}"); // and sinks in by 1.5 mm
    }
}

/// An arm in the trunk in one stretch of a long clip, a leg in the other leg in another: each comes out or stays as it is,
/// whatever else the clip has.
#[test]
fn touches_of_arms_and_of_legs_in_one_clip() {
    let Held { puppet, clip, .. } = held("14_37", 0.7, 1.0);
    let s = clip.skeleton.clone();
    let solids = Solids::new(&puppet, &[], &[]);
    let stands =
        |link: usize| puppet.contacts.iter().any(|c| s.ancestors(s.sites()[c.site].link).any(|l| l == link));
    // a turn of one joint that lets only legs touch, or something else
    let touching = |legs: bool| {
        let turned = (6..s.nv()).flat_map(|dof| [-0.9, 0.9].map(|angle| (dof, angle)));
        let pose = |(dof, angle): (usize, f64)| {
            let (mut q, mut v) = (clip.pose(0).to_vec(), vec![0.0; s.nv()]);
            v[dof] = angle;
            s.integrate(&mut q, &v, 1.0);
            q
        };
        let is = |q: &Vec<f64>| {
            let mut found = Vec::new();
            solids.penetrations(&Kinematics::new(&s, q), &mut found);
            let deep = found.iter().filter(|t| t.depth_m > 0.002);
            let of_legs = |t: &retarget::refine::solids::Penetration| {
                stands(t.first.0) && t.second.is_some_and(|(l, _)| stands(l))
            };
            let all: Vec<bool> = deep.map(of_legs).collect();
            !all.is_empty() && all.iter().all(|x| *x == legs)
        };
        turned.map(pose).find(is).expect("some joint reaches")
    };
    let (arm, leg) = (touching(false), touching(true));
    let q = (0..750).flat_map(|i| if i < 120 { arm.clone() } else { leg.clone() }).collect();
    let long = Clip::new(s, 30.0, q);
    let variance = vec![4e-4; 750];
    let (world, options) = (WorldOptions::default(), RefineOptions::default());
    let out = apart(&puppet, &long, &[], &variance, &world, &options).unwrap();
    let guard = Guard::new(&puppet, &[], world.gravity_m_s2);
    let deepest = |clip: &Clip| guard.depths(clip).into_iter().fold(0.0, f64::max);
    let (before, after) = (deepest(&long), deepest(&out));
    println!("arms, then legs: {:.1} → {:.1} mm", 1e3 * before, 1e3 * after);
    assert!(before > 2e-3 && after <= before, "{before} {after}");
}

/// What is not asked to move does not: with the root's height alone no joint turns and the root goes up and down, also where an arm
/// is in the trunk.
#[test]
fn with_the_root_s_height_no_joint_turns() {
    let Held { puppet, mut clip, phases: found, .. } = held("14_37", 0.7, 1.0);
    let s = clip.skeleton.clone();
    let solids = Solids::new(&puppet, &[], &[]);
    let mut v = vec![0.0; s.nv()];
    let deep = (6..s.nv()).flat_map(|dof| [-0.9, 0.9].map(|angle| (dof, angle))).find(|(dof, angle)| {
        let (mut q, mut touches) = (clip.pose(0).to_vec(), Vec::new());
        v.fill(0.0);
        v[*dof] = *angle;
        s.integrate(&mut q, &v, 1.0);
        solids.penetrations(&Kinematics::new(&s, &q), &mut touches);
        touches.iter().any(|t| t.depth_m > 0.005 && t.second.is_some())
    });
    let (dof, angle) = deep.expect("some joint reaches");
    v.fill(0.0);
    v[dof] = angle;
    (0..clip.frames()).for_each(|i| s.integrate(clip.pose_mut(i), &v, 1.0));
    let (variance, world) = (vec![4e-4; clip.frames()], WorldOptions::default());
    let (out, r) = refine(&puppet, &clip, &found, &variance, &world, &RefineOptions::default()).unwrap();
    say("an arm in the trunk", &r);
    let (mut most, mut up) = (0.0f64, 0.0f64);
    for i in 0..clip.frames() {
        s.difference(clip.pose(i), out.pose(i), 1.0, &mut v);
        up = up.max(v[1].abs());
        v[1] = 0.0;
        most = v.iter().fold(most, |m, x| m.max(x.abs()));
    }
    assert!(r.collision_m[0] > 0.005 && up > 1e-4, "{r:?}");
    assert!(most < 1e-12, "{most}"); // 0 to 1e-16 seen
}

/// The motion that costs least is the same at any frame rate: of one path at 30 and at 120 Hz the root's ways differ by little.
#[test]
fn the_refinement_does_not_depend_on_the_frame_rate() {
    let Held { puppet, clip, phases: found, .. } = held("14_37", 0.7, 1.0);
    let variance = 4e-4;
    let way = |rate_hz: f64| {
        let clip = motion::smooth(&clip.resample(rate_hz), motion::Smoothing::CutoffHz(8.0)).clip;
        let options = RefineOptions { collisions: false, ..RefineOptions::default() };
        let variance = vec![variance; clip.frames()];
        let (out, _) = refine(&puppet, &clip, &found, &variance, &WorldOptions::default(), &options).unwrap();
        let up =
            |i: usize| out.skeleton.position(out.pose(i), 0).y - clip.skeleton.position(clip.pose(i), 0).y;
        (0..clip.frames()).step_by((rate_hz / 30.0) as usize).map(up).collect::<Vec<f64>>()
    };
    let (slow, fast) = (way(30.0), way(120.0));
    let off = slow.iter().zip(&fast).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    println!("{:.2} mm apart, of {:.2}", 1e3 * off, 1e3 * slow.iter().fold(0.0f64, |m, x| m.max(x.abs())));
    assert!(off < 5e-4, "{off}");
}
