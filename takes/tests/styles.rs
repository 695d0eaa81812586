//! Styles that ship: they are what the command makes of the performances, and each changes what its word says.

use std::collections::BTreeMap;
use std::sync::Arc;

use edits::style::Transfer;
use motion::{Clip, Kinematics, Vec3};
use takes::styles::library::{SHIPPED, components, names_for};
use takes::styles::made::made;
use takes::styles::styled;
use takes::{Ask, Take};

/// `cargo run --release -p takes --example make_styles` makes these files again.
#[test]
fn shipped_styles_are_what_the_command_makes() {
    for style in &SHIPPED {
        let (shipped, again) = (style.set().unwrap(), made(style.name).unwrap().1);
        assert!(style.bytes().len() < 300_000, "{}: {} bytes", style.name, style.bytes().len());
        assert_eq!((&shipped.names, shipped.frames), (&again.names, again.frames), "{}", style.name);
        let apart = (&shipped.activations - &again.activations).amax();
        let mixing = (&shipped.mixing - &again.mixing).amax();
        // 0 seen; another processor rounds otherwise
        assert!(apart < 1e-5 && mixing < 1e-5, "{}: {apart} {mixing}; run the command", style.name);
    }
}

/// Means over a walk: what words of styles are about.
#[derive(Debug)]
struct Measures {
    /// Pitch of the chest forward, degrees.
    chest: f64,
    /// Pitch of the line of sight down, degrees.
    looks_down: f64,
    /// Height of the pelvis, m.
    height: f64,
    /// Standard deviation of that height, m.
    bounce: f64,
    /// Bend of the elbows, degrees.
    elbows: f64,
    /// Standard deviation of the way of the hands along the walk against the pelvis, m.
    swing: f64,
    /// How much lower the right side of the chest is than the left, degrees.
    leans: f64,
}

fn measures(clip: &Clip) -> Measures {
    let s = &clip.skeleton;
    let link = |name: &str| s.link(name).unwrap();
    // of the walk itself, not of standing before and after it
    let middle: Vec<usize> = (clip.frames() / 4..3 * clip.frames() / 4).collect();
    let all: Vec<Kinematics> = middle.iter().map(|&f| Kinematics::new(s, clip.pose(f))).collect();
    let mean = |of: &dyn Fn(&Kinematics) -> f64| all.iter().map(of).sum::<f64>() / all.len() as f64;
    let spread = |of: &dyn Fn(&Kinematics) -> f64| {
        let m = mean(of);
        mean(&|k| (of(k) - m).powi(2)).sqrt()
    };
    let up = |k: &Kinematics| k.world[link("chest")].rotation * Vec3::y();
    let looks = |k: &Kinematics| k.world[link("head")].rotation * Vec3::z();
    let bend = |k: &Kinematics, side: &str| {
        let at = |joint: &str| k.origin(link(&format!("{joint}_{side}")));
        (at("elbow") - at("shoulder")).angle(&(at("wrist") - at("elbow"))).to_degrees()
    };
    Measures {
        chest: mean(&|k| up(k).z.atan2(up(k).y).to_degrees()),
        looks_down: mean(&|k| -looks(k).y.asin().to_degrees()),
        height: mean(&|k| k.origin(0).y),
        bounce: spread(&|k| k.origin(0).y),
        elbows: mean(&|k| 0.5 * (bend(k, "l") + bend(k, "r"))),
        swing: spread(&|k| (k.origin(link("wrist_l")) - k.origin(0)).z),
        leans: mean(&|k| {
            let across = k.origin(link("shoulder_l")) - k.origin(link("shoulder_r"));
            across.y.atan2(across.x.hypot(across.z)).to_degrees()
        }),
    }
}

fn with(base: &Take, name: &str, amount: f64) -> Take {
    let set = Arc::new(SHIPPED.iter().find(|s| s.name == name).unwrap().set().unwrap());
    let how = Transfer::of(&set, 1, amount).only(&components(&set), amount);
    styled(base, &set, &how, &names_for(&base.body.character)).unwrap()
}

/// On a walk that none of them was made from.
#[test]
fn styles_change_what_their_words_say() {
    let base = takes::open(support::scene("performances/walk.ron").as_path(), &Ask::default()).unwrap();
    let plain = measures(&base.asked.clip);
    println!("as it is: {plain:.3?}");
    let of: BTreeMap<&str, Measures> =
        SHIPPED.iter().map(|s| (s.name, measures(&with(&base, s.name, 1.0).asked.clip))).collect();
    of.iter().for_each(|(name, m)| println!("{name}: {m:.3?}"));
    let (tired, proud, sneaky) = (&of["tired"], &of["proud"], &of["sneaky"]);
    assert!(tired.chest > plain.chest + 20.0 && tired.looks_down > plain.looks_down + 30.0);
    assert!(tired.swing < plain.swing);
    assert!(proud.chest < plain.chest - 10.0 && proud.looks_down < plain.looks_down - 10.0);
    assert!(proud.swing > 1.2 * plain.swing);
    assert!(sneaky.height < plain.height - 0.06 && sneaky.elbows > plain.elbows + 40.0);
    assert!(of["limping"].leans > plain.leans + 1.5 && of["limping"].height < plain.height);
    assert!(of["childish"].swing > 1.5 * plain.swing && of["childish"].elbows < plain.elbows - 4.0);
    assert!(of["childish"].bounce > 1.2 * plain.bounce);
    // nothing of it is nothing
    let none = with(&base, "sneaky", 0.0);
    let apart = none.asked.clip.data().iter().zip(base.asked.clip.data()).map(|(a, b)| (a - b).abs());
    assert!(apart.fold(0.0, f64::max) < 1e-9);
}

/// A captured walk has other names for its bones: they are told by what they are for.
#[test]
fn a_captured_walk_gets_a_style_that_ships() {
    let base = takes::open(support::shared("mocap/bvh/02_01.bvh"), &Ask::default()).unwrap();
    let names = names_for(&base.body.character);
    assert_eq!(
        (names["shoulder_l"].as_str(), names["knee_r"].as_str()),
        ("LeftArm", "RightLeg"),
        "{names:?}"
    );
    let tired = with(&base, "tired", 1.0);
    let head = |take: &Take| {
        let clip = &take.asked.clip;
        let link = clip.skeleton.link(&names["head"]).unwrap();
        let frames = 0..clip.frames();
        frames.map(|f| Kinematics::new(&clip.skeleton, clip.pose(f)).origin(link).y).sum::<f64>()
            / clip.frames() as f64
    };
    println!("head {:.3} m, tired {:.3} m", head(&base), head(&tired));
    assert!(head(&tired) < head(&base) - 0.05);
}
