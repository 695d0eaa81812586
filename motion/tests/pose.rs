//! Laws of posing by dragging: bones keep their lengths, pins hold, twist is kept, nothing flips, and the answer is the paper's.

mod human;

use std::sync::Arc;

use motion::ik::pose::{Handle, MOST_TURN, Poser, Rules};
use motion::{Joint, Kinematics, Skeleton, Vec3};

/// The human, standing, and its links by name.
struct Human {
    s: Arc<Skeleton>,
    start: Vec<f64>,
    k: Kinematics,
}

impl Human {
    fn new() -> Self {
        let s = human::skeleton();
        let start = human::standing(&s);
        Self { k: Kinematics::new(&s, &start), s, start }
    }

    fn link(&self, name: &str) -> usize {
        self.s.link(name).unwrap()
    }

    fn at(&self, name: &str) -> Vec3 {
        self.k.origin(self.link(name))
    }

    fn drag(&self, name: &str, to: Vec3) -> Handle {
        Handle::drag(self.link(name), to)
    }

    fn pin(&self, name: &str) -> Handle {
        Handle::pin(self.link(name), self.at(name))
    }

    fn poser(&self, rules: Rules) -> Poser {
        let mut poser = Poser::new(&self.s);
        poser.begin(&self.start, rules).unwrap();
        poser
    }
}

/// Turns of each joint from one pose to another, rad.
fn turns(s: &Skeleton, from: &[f64], to: &[f64]) -> Vec<f64> {
    let mut v = vec![0.0; s.nv()];
    s.difference(from, to, 1.0, &mut v);
    let turn = |i: usize| {
        let at = s.v_at(i) + if s.links()[i].joint == Joint::Free { 3 } else { 0 };
        v[at..at + s.links()[i].joint.nv().min(3)].iter().map(|x| x * x).sum::<f64>().sqrt()
    };
    (0..s.links().len()).map(turn).collect()
}

/// Ways of the right wrist: name, corners, the most a joint may turn in a drag of 10 mm, degrees.
fn ways(h: &Human) -> Vec<(&'static str, Vec<Vec3>, f64)> {
    let (wrist, shoulder, chest) = (h.at("wrist_r"), h.at("shoulder_r"), h.at("chest"));
    let over = shoulder + Vec3::new(-0.1, 0.55, 0.1);
    vec![
        ("forward, out of reach", vec![wrist, wrist + Vec3::new(0.0, 0.3, 1.5)], 5.0),
        ("sideways, out of reach", vec![wrist, wrist + Vec3::new(-1.5, 0.3, 0.0)], 12.0),
        ("up, out of reach", vec![wrist, shoulder + Vec3::new(0.0, 2.0, 0.0)], 16.0),
        ("over the head", vec![wrist, over, shoulder + Vec3::new(0.8, 0.3, 0.1)], 8.0),
        (
            "behind the back",
            vec![wrist, wrist + Vec3::new(0.1, 0.1, -0.4), chest + Vec3::new(0.5, -0.1, -0.25)],
            5.0,
        ),
        ("through the shoulder", vec![wrist, shoulder, shoulder * 2.0 - wrist], 14.0),
        ("through the chest", vec![wrist, chest, chest * 2.0 - wrist], 7.0),
    ]
}

/// Along every way, 10 mm a drag, with the ankles pinned and without: joints turn by no more than the bound, which is never above
/// what one call may turn; bones have their lengths; pins hold, out of reach as within.
#[test]
fn nothing_flips_along_a_line() {
    let h = Human::new();
    for (name, corners, bound_deg) in ways(&h) {
        for pinned in [false, true] {
            let (mut poser, mut q) = (h.poser(Rules::default()), h.start.clone());
            let (mut before, mut worst) = (q.clone(), (0.0f64, 0.0, 0));
            let (mut bone, mut pin, mut travelled) = (0.0f64, 0.0f64, 0.0);
            for leg in corners.windows(2) {
                let strides = ((leg[1] - leg[0]).norm() / 0.01).ceil() as usize;
                for i in 1..=strides {
                    travelled += 0.01;
                    let to = leg[0] + (leg[1] - leg[0]) * (i as f64 / strides as f64);
                    let handles = [h.drag("wrist_r", to), h.pin("ankle_l"), h.pin("ankle_r")];
                    poser.drag(&handles[..if pinned { 3 } else { 1 }], &mut q).unwrap();
                    pin = poser.misses()[1..].iter().fold(pin, |m, x| m.max(*x));
                    for (i, turn) in turns(&h.s, &before, &q).into_iter().enumerate() {
                        if turn > worst.0 {
                            worst = (turn, travelled, i);
                        }
                    }
                    before.copy_from_slice(&q);
                    let k = Kinematics::new(&h.s, &q);
                    for (i, l) in h.s.links().iter().enumerate() {
                        let Some(p) = l.parent else { continue };
                        let length = (k.origin(i) - k.origin(p)).norm();
                        bone = bone.max((length - l.parent_from_zero.translation.vector.norm()).abs());
                    }
                }
            }
            let (turn, at, link) = worst;
            let link = &h.s.links()[link].name;
            println!(
                "{name}, pinned {pinned}: {:.2}° of {link} at {at:.2} m, pins {pin:.1e} m, bones {bone:.1e} m",
                turn.to_degrees()
            );
            assert!(
                turn.to_degrees() < bound_deg,
                "{name}, pinned {pinned}: {:.2}° of {link} at {at} m",
                turn.to_degrees()
            );
            assert!(turn < MOST_TURN + 0.03);
            assert!(bone < 1e-9, "{name}: {bone}"); // 7e-16 seen
            assert!(pin < 1e-6, "{name}: {pin}"); // 2.2e-8 seen, up, out of reach
        }
    }
}

/// What is dragged to where it is does not move, to the bit.
#[test]
fn no_drag_is_the_identity() {
    let h = Human::new();
    let (mut poser, mut q) = (h.poser(Rules::default()), h.start.clone());
    let handles = [h.drag("wrist_r", h.at("wrist_r")), h.drag("head", h.at("head")), h.pin("ankle_l")];
    let posed = poser.walk(&handles, 0.02, &mut q).unwrap();
    assert!(posed.still && posed.steps == 0, "{posed:?}");
    assert_eq!(q, h.start);
}

/// A drag does not allocate.
#[test]
fn drags_do_not_allocate() {
    let h = Human::new();
    let groups = [vec![h.link("wrist_l"), h.link("head")]];
    let (mut poser, mut q) =
        (h.poser(Rules { groups: &groups, limits: true, ..Rules::default() }), h.start.clone());
    let handles = |i: usize| {
        [
            h.drag("wrist_r", h.at("wrist_r") + Vec3::new(0.0, 0.02, 0.01) * i as f64),
            h.pin("ankle_l"),
            h.pin("ankle_r"),
        ]
    };
    poser.drag(&handles(1), &mut q).unwrap();
    let mut steps = 0;
    let counted = allocation_counter::measure(|| {
        for i in 2..30 {
            steps += poser.drag(&handles(i), &mut q).unwrap().steps;
        }
    });
    assert!(steps > 50 && counted.count_total == 0, "{steps} steps, {} allocations", counted.count_total);
}
