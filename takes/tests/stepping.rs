//! Motion that steps, made possible: what it asks of the ground, how far it is from the capture, and that standing is left alone.

use motion::{Kinematics, Vec3};
use takes::overrides::RootChoice;
use takes::{Ask, Overrides, Possible, Take, open};

fn free(clip: &str) -> Take {
    let overrides = Overrides { root: Some(RootChoice::Free), ..Overrides::default() };
    open(support::shared(clip), &Ask { overrides, ..Ask::default() }).unwrap_or_else(|e| panic!("{e}"))
}

fn possible(take: &Take) -> Possible {
    take.possible().unwrap().expect("legs and ground")
}

/// Centre of mass of a frame, m, by the masses of the links.
fn com(take: &Take, p: &Possible, f: usize) -> Vec3 {
    let k = Kinematics::new(&p.clip.skeleton, p.clip.pose(f));
    let bodies = take.character().bodies.iter().enumerate();
    let (sum, mass) = bodies.fold((Vec3::zeros(), 0.0), |(sum, mass), (link, body)| {
        (sum + k.point(link, &body.com) * body.mass, mass + body.mass)
    });
    sum / mass
}

/// A high jump falls: by the links' masses, a road that passes through no dynamics. It starts and lands within 0.05 s of where the
/// plan that was found says, and its apex over the start is within 10 % of the captured one.
#[test]
fn slow_a_jump_falls() {
    let take = free("mocap/bvh/16_03.bvh");
    let p = possible(&take);
    let rate = p.clip.rate_hz;
    let flies: Vec<usize> =
        (1..p.clip.frames() - 1).filter(|f| p.plan.at(*f as f64 / rate).count() == 0).collect();
    assert!(flies.len() > 40, "{} frames", flies.len());
    let mut worst: f64 = 0.0;
    for &f in &flies {
        let bend = (com(&take, &p, f - 1) + com(&take, &p, f + 1) - com(&take, &p, f) * 2.0) * rate * rate;
        worst = worst.max((bend + Vec3::y() * 9.81).norm());
    }
    println!("falls at g within {worst:.1e} m/s² over {} frames", flies.len());
    assert!(worst < 1e-3, "{worst}"); // 4e-6 seen
    let top = |of: &motion::Clip| {
        let height = |f: usize| of.skeleton.position(of.pose(f), 0).y;
        (0..of.frames()).map(height).fold(0.0, f64::max) - height(0)
    };
    let (asked, made) = (top(&take.asked.clip), top(&p.clip));
    println!("apex {asked:.3} m asked, {made:.3} m made");
    assert!((made / asked - 1.0).abs() < 0.1, "{asked} {made}");
}

/// A walk: pressure inside the soles, near the capture; feet that stand do not slip; what stands comes back from a file as it was.
#[test]
fn slow_a_walk_is_carried() {
    let take = free("mocap/bvh/16_16.bvh");
    let p = possible(&take);
    let m = p.measures;
    println!("{m:?}");
    assert!(m.inside_after.unwrap() > 0.98 && m.inside_before.unwrap() < 0.8, "{m:?}");
    assert!(m.links_worst_m < 0.08 && m.out_of_reach_m < 0.01, "{m:?}");
    let stray = slip(&take, &p);
    println!("lowest corner of a standing sole moves by up to {:.1} mm a frame", 1e3 * stray);
    assert!(stray < 5e-3, "{stray}"); // 3.2e-3 seen, where knees are nearly straight
    // linear and local: the same again from its own result changes little
    let (again, _) = take.made_possible().unwrap();
    assert_eq!(again.asked.clip, p.clip);
    assert_eq!(again.asked.contacts, p.plan);
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("contacts.ron");
    std::fs::write(&file, scenes::contact_file::plan_text(&["leg_l", "leg_r"], &p.plan)).unwrap();
    let overrides = Overrides { root: Some(RootChoice::Free), ..Overrides::default() };
    let ask = Ask { overrides, contacts: Some(file), ..Ask::default() };
    let given = possible(&open(support::shared("mocap/bvh/16_16.bvh"), &ask).unwrap());
    let far = |a: &Vec3, b: &Vec3| (a - b).norm();
    let apart =
        (0..p.clip.frames()).map(|f| far(&com(&take, &p, f), &com(&take, &given, f))).fold(0.0, f64::max);
    println!("given back: {:.2} mm apart", 1e3 * apart);
    assert!(apart < 1e-3, "{apart} m");
}

/// How far the lowest corner of a standing sole goes in a frame, at most, m.
fn slip(take: &Take, p: &Possible) -> f64 {
    let mut worst: f64 = 0.0;
    let all: Vec<Kinematics> =
        (0..p.clip.frames()).map(|f| Kinematics::new(&p.clip.skeleton, p.clip.pose(f))).collect();
    for (limb, sole) in take.character().leg_soles() {
        for c in p.plan.of(&limb.name) {
            for f in c.frames(p.clip.rate_hz, p.clip.frames()).skip(1) {
                let now: Vec<Vec3> = sole.points(&all[f]).collect();
                let then: Vec<Vec3> = sole.points(&all[f - 1]).collect();
                let lowest = (0..now.len()).min_by(|a, b| now[*a].y.total_cmp(&now[*b].y)).unwrap();
                worst = worst.max((now[lowest] - then[lowest]).norm());
            }
        }
    }
    worst
}

/// What stands is left alone, to the byte.
#[test]
fn slow_standing_is_left_alone() {
    let take = free("mocap/bvh/14_37.bvh");
    if let Some(span) = take.asked.stance.clone().unwrap().standing().next() {
        let ground_m = take.asked.stance.as_ref().unwrap().ground_m;
        let standing = if take.asked.plants.is_empty() { take.stand(span, ground_m).unwrap() } else { take };
        let (same, said) = standing.made_possible().unwrap();
        assert_eq!(same.asked.clip, standing.asked.clip);
        assert_eq!(same.conditions.physics, standing.conditions.physics);
        assert!(said.unwrap().shifts.is_empty() && same.asked.stepping.is_empty());
        assert!(!standing.steps_blind());
        assert_eq!(standing.asked.contacts.contacts().len(), 2);
    } else {
        panic!("14_37 stands");
    }
}
