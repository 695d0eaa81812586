//! Physics refinement.

use motion::{Clip, Kinematics, Vec3};
use retarget::refine::refine;
use retarget::refine::solids::Solids;
use retarget::{RefineDofs, RefineOptions, RefinementReport, WorldOptions};

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
    let (_, r) =
        refine(&puppet, &long, &[], &vec![4e-4; 750], &WorldOptions::default(), &RefineOptions::default())
            .unwrap();
    say("arms, then legs", &r);
    assert!(r.collision_m[1] <= r.collision_m[0]);
}
