//! Foresight: a captured walk keeps its feet, the same on any number of threads, and again from its file, also when it is pushed; who stands does
//! not notice.

use dynamics::Walked;
use sim::foresight::{Foreseen, Replay, Settings};
use sim::{Engines, Outcome};
use std::sync::Arc;
use takes::overrides::RootChoice;
use takes::{Ask, LookAhead, Overrides, open};

/// Seconds of the walk: three quarters of a step beyond where it falls by itself.
const WALK_S: f64 = 1.2;

fn ask(foresight: Option<Foreseen>, tension: f64, until_s: f64) -> Ask {
    let overrides = Overrides {
        root: Some(RootChoice::Free),
        tension: Some(tension),
        span_s: Some((0.0, until_s)),
        ..Overrides::default()
    };
    Ask { overrides, foresight: foresight.map_or(LookAhead::Off, LookAhead::As), ..Ask::default() }
}

fn perform(clip: &str, ask: &Ask) -> Outcome {
    let take = open(support::shared(clip), ask).unwrap_or_else(|e| panic!("{e}"));
    take.outcome(&Engines::default(), &mut |_| {}).unwrap_or_else(|e| panic!("{e}"))
}

fn on_threads<T: Send>(threads: usize, run: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(run)
}

fn bits(numbers: &[f64]) -> Vec<u64> {
    numbers.iter().map(|x| x.to_bits()).collect()
}

/// A walk falls by itself and keeps its feet by looking ahead: nothing holds its root, and offsets of 1° to 5° do it. One and three threads
/// come to the same bytes, and so does a replay, which is refused to another tension.
#[test]
fn slow_a_walk_keeps_its_feet() {
    const CLIP: &str = "mocap/bvh/16_16.bvh";
    let search = Some(Foreseen::Search(Settings { rollouts: 120, ..Settings::default() }));
    let rows = (WALK_S * 240.0) as usize;
    let blind = Walked::of(&perform(CLIP, &ask(None, 2.0, WALK_S)).trace, rows);
    assert!(blind.lost.is_some(), "{blind:?}"); // 0.91 s seen
    let walk = ask(search, 2.0, WALK_S);
    let one = on_threads(1, || perform(CLIP, &walk));
    let walked = Walked::of(&one.trace, rows);
    assert_eq!(walked.lost, None, "{walked:?}");
    assert!(one.trace.root_wrench.iter().all(|x| *x == 0.0));
    let used = one.foresight.as_ref().unwrap();
    let deg = used.offset_rms().to_degrees();
    println!("{deg:.2}°, links {:.0} mm", walked.links_mm);
    assert!(walked.links_mm < 120.0 && (0.3..6.0).contains(&deg), "{} mm, {deg}°", walked.links_mm);

    let three = on_threads(3, || perform(CLIP, &walk));
    assert_eq!(bits(&three.trace.q), bits(&one.trace.q));
    assert_eq!(three.foresight.as_ref().unwrap(), used);

    let replay = Replay { input: used.input, channels: used.channels.len(), offsets: used.offsets.clone() };
    let replay = Some(Foreseen::Replay(Arc::new(replay)));
    let again = perform(CLIP, &ask(replay.clone(), 2.0, WALK_S));
    assert_eq!(bits(&again.trace.q), bits(&one.trace.q));
    let tense = open(support::shared(CLIP), &ask(replay, 2.1, WALK_S)).unwrap();
    let refused = tense.outcome(&Engines::default(), &mut |_| {}).map(|_| ()).unwrap_err();
    assert!(refused.is_input() && refused.to_string().contains("another input"), "{refused}");
}

/// Planted feet are the affair of the balance: asked for or not, foresight changes no bit of a clip that stands.
#[test]
fn who_stands_does_not_look_ahead() {
    const CLIP: &str = "mocap/bvh/14_37.bvh";
    let asked = perform(CLIP, &ask(Some(Foreseen::Search(Settings::default())), 1.0, 1.6));
    assert!(asked.foresight.is_none());
    let plain = perform(CLIP, &ask(None, 1.0, 1.6));
    assert_eq!(bits(&asked.trace.q), bits(&plain.trace.q));
}

/// A push in mid-walk: nobody knows of it before it begins, so the walk is to the bit the one without it until then; the offsets of the one are no
/// replay of the other; its own come to the same bytes; and it keeps its feet.
#[test]
fn slow_a_push_is_answered_when_it_comes() {
    const CLIP: &str = "mocap/bvh/16_16.bvh";
    const AT_S: f64 = 0.55;
    let search = Settings { rollouts: 120, ..Settings::default() };
    let push = format!("(link: \"Spine1\", impulse_ns: 8, towards_deg: 0, start_s: {AT_S})");
    let pushed = |foresight| Ask { pushes: vec![push.clone()], ..ask(Some(foresight), 2.0, WALK_S) };
    let hit = perform(CLIP, &pushed(Foreseen::Search(search)));
    let walked = Walked::of(&hit.trace, (WALK_S * 240.0) as usize);
    assert_eq!(walked.lost, None, "{walked:?}");
    let free = perform(CLIP, &ask(Some(Foreseen::Search(search)), 2.0, WALK_S));
    let before = (AT_S * hit.trace.rate_hz).round() as usize + 1;
    let nq = hit.trace.character.skeleton.nq();
    assert_eq!(bits(&hit.trace.q[..before * nq]), bits(&free.trace.q[..before * nq]));
    assert_ne!(bits(&hit.trace.q[..(before + 1) * nq]), bits(&free.trace.q[..(before + 1) * nq]));
    // searched for once more, when it began
    let searches = |o: &Outcome| o.foresight.as_ref().unwrap().costs.len();
    assert!(searches(&hit) > searches(&free), "{} {}", searches(&hit), searches(&free));

    let replay = |o: &Outcome| {
        let used = o.foresight.as_ref().unwrap();
        let (input, channels) = (used.input, used.channels.len());
        Foreseen::Replay(Arc::new(Replay { input, channels, offsets: used.offsets.clone() }))
    };
    let again = perform(CLIP, &pushed(replay(&hit)));
    assert_eq!(bits(&again.trace.q), bits(&hit.trace.q));
    let other = open(support::shared(CLIP), &pushed(replay(&free))).unwrap();
    let refused = other.outcome(&Engines::default(), &mut |_| {}).map(|_| ()).unwrap_err();
    assert!(refused.is_input() && refused.to_string().contains("pushes"), "{refused}");
}

/// A push keeps the time of the clip, also of a part of it; one that nobody would see, and one of no link, are refused at their place.
#[test]
fn pushes_asked_for_are_those_of_the_clip() {
    const CLIP: &str = "mocap/bvh/09_01.bvh";
    let asked = |push: &str, span_s| {
        let overrides = Overrides { root: Some(RootChoice::Free), span_s, ..Overrides::default() };
        open(support::shared(CLIP), &Ask { overrides, pushes: vec![push.into()], ..Ask::default() })
    };
    let push = "(link: \"Spine1\", impulse_ns: (4, 0, 3), start_s: 0.6, duration_s: 0.05)";
    let of = |span| asked(push, span).unwrap().conditions.pushes.remove(0);
    let whole = of(None);
    assert!((whole.force.norm() - 100.0).abs() < 1e-9 && whole.start_s == 0.6 && whole.duration_s == 0.05);
    assert!((of(Some((0.5, 1.0))).start_s - 0.1).abs() < 0.5 / 120.0);
    for (push, span, said) in [
        (push, Some((0.0, 0.5)), "allowed: while the motion lasts, 0.000 to 0.5"),
        (push, Some((0.7, 1.0)), "allowed: while the motion lasts, 0.7"),
        ("(link: \"Spine1\", impulse_ns: 4, start_s: 0.6)", None, "without a direction"),
        ("(link: \"tail\", impulse_ns: (4, 0, 3), start_s: 0.6)", None, "tail"),
    ] {
        let refused = asked(push, span).map(|_| ()).unwrap_err().to_string();
        assert!(refused.contains(said) && refused.contains("--push"), "{refused}");
    }
}
