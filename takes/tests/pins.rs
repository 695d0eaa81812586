//! Pins of scenes: held in the world, on a link and by the eyes, through every other edit, in the motion that is asked for.

use motion::{Clip, Joint, Kinematics, Vec3};
use takes::{Ask, Input, Take};

/// A scene of the library, its lines changed by `edit`.
fn scene(name: &str, edit: impl Fn(&str) -> String) -> Take {
    let text = std::fs::read_to_string(support::scene(name)).unwrap();
    let ron = text.lines().map(|l| edit(l) + "\n").collect();
    takes::open(Input::Text { ron, base: support::scene("") }, &Ask::default()).unwrap()
}

fn pinned(name: &str) -> Take {
    scene(name, str::to_owned)
}

/// The same without its pins.
fn unpinned(name: &str) -> Take {
    scene(name, |line| if line.trim_start().starts_with("Pin(") { String::new() } else { line.to_owned() })
}

/// Frames from one time to another, s.
fn frames(clip: &Clip, from_s: f64, to_s: f64) -> std::ops::RangeInclusive<usize> {
    let frame = |t_s: f64| (t_s * clip.rate_hz).round() as usize;
    frame(from_s)..=frame(to_s)
}

/// The fastest joint between two times: rad/s, its name. The root's turn counts, its way does not.
fn fastest(clip: &Clip, from_s: f64, to_s: f64) -> (f64, String) {
    let s = &clip.skeleton;
    let mut v = vec![0.0; s.nv()];
    let mut found = (0.0, String::new());
    for f in frames(clip, from_s, to_s).skip(1) {
        s.difference(clip.pose(f - 1), clip.pose(f), 1.0 / clip.rate_hz, &mut v);
        for (i, link) in s.links().iter().enumerate() {
            let at = s.v_at(i);
            let own = match link.joint {
                Joint::Free => &v[at + 3..at + 6],
                _ => &v[at..at + link.joint.nv()],
            };
            let speed = own.iter().map(|x| x * x).sum::<f64>().sqrt();
            if speed > found.0 {
                found = (speed, link.name.clone());
            }
        }
    }
    found
}

/// What holds of every pinned scene: limits, feet, nothing outside the blends changed, no joint faster in the blends than 1.5 × the
/// fastest of the motion without pins.
fn lawful(name: &str, (from_s, to_s, blend_s): (f64, f64, f64)) -> Take {
    let (take, plain) = (pinned(name), unpinned(name));
    let (clip, free) = (&take.asked.clip, &plain.asked.clip);
    let s = &clip.skeleton;
    let (mut beyond, mut slip) = (0.0_f64, 0.0_f64);
    for f in 0..clip.frames() {
        let mut q = clip.pose(f).to_vec();
        s.clamp_to_limits(&mut q);
        let mut v = vec![0.0; s.nv()];
        s.difference(clip.pose(f), &q, 1.0, &mut v);
        beyond = v.iter().fold(beyond, |m, x| m.max(x.abs()));
        let k = Kinematics::new(s, clip.pose(f));
        for plant in &take.asked.plants {
            for at in [Vec3::zeros(), Vec3::x() * 0.1, Vec3::z() * 0.2] {
                let wanted = (plant.world_from_end * nalgebra::Point3::from(at)).coords;
                slip = slip.max((k.point(plant.limb.end, &at) - wanted).norm());
            }
        }
    }
    assert!(beyond < 1e-6, "{name}: {beyond} rad beyond limits"); // 1e-16 seen
    assert!(slip < 1e-4, "{name}: feet slip {slip} m"); // 1e-8 seen
    let peak = fastest(free, 0.0, free.duration_s());
    for (a, b) in [(from_s - blend_s, from_s), (to_s, to_s + blend_s)] {
        let own = fastest(clip, a, b);
        println!(
            "{name}: {a:.2} s to {b:.2} s fastest {:.2} rad/s ({}); unpinned peak {:.2} ({}): {:.2} ×",
            own.0,
            own.1,
            peak.0,
            peak.1,
            own.0 / peak.0
        );
        assert!(own.0 <= 1.5 * peak.0, "{name}: {own:?} against {peak:?}");
    }
    println!("{name}: limits {beyond:.1e} rad, feet {slip:.1e} m");
    take
}

fn hand(clip: &Clip, f: usize, link: &str, at: Vec3) -> Vec3 {
    let s = &clip.skeleton;
    Kinematics::new(s, clip.pose(f)).point(s.link(link).unwrap(), &at)
}

#[test]
fn a_hand_stays_on_the_hip_through_the_bow() {
    let take = lawful("bow-hip.ron", (1.5, 3.2, 1.1));
    let (clip, s) = (&take.asked.clip, &take.asked.clip.skeleton);
    let hip = Vec3::new(0.1, 0.06, 0.15);
    let miss = frames(clip, 1.5, 3.2).map(|f| {
        let k = Kinematics::new(s, clip.pose(f));
        (hand(clip, f, "wrist_r", Vec3::x() * -0.09) - k.point(0, &hip)).norm()
    });
    let miss = miss.fold(0.0, f64::max);
    println!("hand on hip: {:.4} mm", 1e3 * miss);
    assert!(miss < 1e-3, "{miss}"); // 2e-6 seen
}

#[test]
fn both_hands_stay_on_a_rail_through_the_twist() {
    let take = lawful("twist-rail.ron", (1.0, 6.7, 0.6));
    let clip = &take.asked.clip;
    for (link, side) in [("wrist_l", 1.0), ("wrist_r", -1.0)] {
        let rail = Vec3::new(0.24 * side, 1.02, 0.36);
        let at = Vec3::new(0.09 * side, 0.0, 0.0);
        let miss =
            frames(clip, 1.0, 6.7).map(|f| (hand(clip, f, link, at) - rail).norm()).fold(0.0, f64::max);
        println!("{link} on the rail: {:.4} mm", 1e3 * miss);
        assert!(miss < 1e-3, "{link}: {miss}"); // 1e-8 seen
    }
    // the crescendo is kept: hips still turn more at the end than at the beginning
    let turn = |from_s, to_s| {
        let yaw = frames(clip, from_s, to_s).map(|f| {
            let ahead = clip.skeleton.rotation(clip.pose(f), 0) * Vec3::z();
            ahead.x.atan2(ahead.z)
        });
        let yaw: Vec<f64> = yaw.collect();
        yaw.iter().fold(0.0_f64, |m, x| m.max(x.abs()))
    };
    let (begins, ends) = (turn(1.4, 2.4), turn(5.4, 6.6));
    println!("hips turn {:.1}° at first, {:.1}° in the end", begins.to_degrees(), ends.to_degrees());
    assert!(ends > 1.5 * begins, "{begins} {ends}");
}

#[test]
fn eyes_stay_on_a_point_through_the_bow() {
    let take = lawful("bow-gaze.ron", (0.8, 3.8, 0.6));
    let (clip, s) = (&take.asked.clip, &take.asked.clip.skeleton);
    let eyes = s.site("eyes").unwrap();
    let miss = frames(clip, 0.8, 3.8).map(|f| {
        let k = Kinematics::new(s, clip.pose(f));
        let (from, sight) = (k.point(eyes.link, &eyes.at), k.world[eyes.link].rotation * Vec3::z());
        let way = Vec3::new(0.3, 1.3, 3.0) - from;
        sight.cross(&way).norm().atan2(sight.dot(&way)).to_degrees()
    });
    let miss = miss.fold(0.0, f64::max);
    println!("eyes off the point: {miss:.4}°");
    assert!(miss < 0.5, "{miss}"); // 3e-5 seen
}
