//! A program that reacts: what it writes are goals and tensions of one step, what it keeps is its memory.

use bodies::anthropometry::human::human;
use controllers::{ControlStep, Drive, Impedance, Reactive, Rest, SetPoints, rest_of};
use dynamics::{ContactSample, Model};
use motion::rotation::log;
use motion::{Skeleton, Vec3};
use programs::Reaction;

use crate::program;

/// A body at rest, with muscles that carry a load.
struct Stage {
    model: Model,
    set_points: Vec<SetPoints>,
    impedances: Vec<Impedance>,
    q: Vec<f64>,
    v: Vec<f64>,
    contacts: Vec<ContactSample>,
    drives: Vec<Drive>,
}

const STIFFNESS: f64 = 60.0;
const LOAD: f64 = 3.0;

impl Stage {
    fn new() -> Self {
        let c = human().0;
        let model = Model::new(&c, Vec3::new(0.0, -9.81, 0.0));
        let of =
            |b: &dynamics::MovingBody| SetPoints::of(&b.joint, c.skeleton.links()[b.link].limits.as_ref());
        let set_points: Vec<SetPoints> = model.bodies.iter().map(of).collect();
        let load = Vec3::new(LOAD, 0.0, 0.0);
        let drive = |i: usize| match rest_of(&model, i, &c.rest) {
            Rest::None => Drive::NONE,
            rest => {
                Drive { stiffness: STIFFNESS, damping: 4.0, rest: set_points[i].rest(&rest, load, STIFFNESS) }
            }
        };
        let drives = (0..model.bodies.len()).map(drive).collect();
        let impedances = vec![Impedance { stiffness: STIFFNESS, damping: 4.0 }; model.bodies.len()];
        let foot = model.skeleton.link("ankle_l").unwrap();
        let contacts = vec![ContactSample {
            against: Default::default(),
            row: 0,
            link: foot,
            point: Vec3::zeros(),
            force: Vec3::new(0.0, 400.0, 0.0),
            depth: 0.0,
        }];
        Self { v: vec![0.0; model.nv()], q: c.rest.clone(), model, set_points, impedances, contacts, drives }
    }

    fn skeleton(&self) -> &Skeleton {
        &self.model.skeleton
    }

    fn body(&self, joint: &str) -> usize {
        let link = self.skeleton().link(joint).unwrap();
        self.model.bodies.iter().position(|b| b.link == link).unwrap()
    }

    /// Drives after one step of the reaction, from those of the stage.
    fn react(&self, reaction: &mut Reaction, time_s: f64) -> Result<Vec<Drive>, String> {
        let step = ControlStep {
            model: &self.model,
            set_points: &self.set_points,
            impedances: &self.impedances,
            q: &self.q,
            v: &self.v,
            contacts: &self.contacts,
            goal_q: &self.q,
            goal_v: &self.v,
            lift: 0.0,
            feed: None,
            time_s,
            dt: 1.0 / 240.0,
        };
        let mut drives = self.drives.clone();
        reaction.react(&step, &mut drives).map_err(|e| e.to_string())?;
        Ok(drives)
    }
}

fn reaction(text: &str) -> Reaction {
    Reaction::new(program(text)).unwrap()
}

fn once(body: &str) -> Result<Vec<Drive>, String> {
    Stage::new().react(&mut reaction(&format!("fn react(body, params) {{\n{body}\n}}")), 0.5)
}

/// A program that writes nothing leaves every drive to the bit; what was written in one step is gone in the next.
#[test]
fn nothing_written_is_nothing_changed() {
    let stage = Stage::new();
    assert_eq!(once("let x = body.com_m; let j = body[\"elbow_r\"].angle_deg;").unwrap(), stage.drives);
    let mut first =
        reaction("fn react(body, params) { if body.time_s < 1.0 { body[\"elbow_r\"].turn_deg = 10; } }");
    assert_ne!(stage.react(&mut first, 0.5).unwrap(), stage.drives);
    assert_eq!(stage.react(&mut first, 1.5).unwrap(), stage.drives);
}

/// A hinge's and a ball's rest turn by what was asked, load and stiffness as they were.
#[test]
fn goals_turn() {
    let stage = Stage::new();
    let drives = once("body[\"elbow_r\"].turn_deg = 10; body[\"neck\"].turn_deg = [0, 8, 0];").unwrap();
    let (elbow, neck) = (stage.body("elbow_r"), stage.body("neck"));
    let (Rest::Scalar(a), Rest::Scalar(b)) = (stage.drives[elbow].rest, drives[elbow].rest) else { panic!() };
    assert!(((b - a).to_degrees() - 10.0).abs() < 1e-9, "{}", (b - a).to_degrees()); // 1e-14 seen
    let (Rest::Ball { target: a, shift: s }, Rest::Ball { target: b, shift: t }) =
        (stage.drives[neck].rest, drives[neck].rest)
    else {
        panic!()
    };
    assert!((log(&(b * a.inverse())).y.to_degrees() - 8.0).abs() < 1e-9 && (s - t).norm() < 1e-12);
    let changed = (0..drives.len()).filter(|&i| drives[i] != stage.drives[i]).count();
    assert_eq!(changed, 2);
}

/// More tension stiffens the joint; it must not move the pose: the torque at the goal stays the load.
#[test]
fn tension_carries_what_it_carried() {
    let stage = Stage::new();
    let drives = once("body[\"elbow_r\"].tension = 4; body[\"neck\"].tension = 2;").unwrap();
    for (name, factor) in [("elbow_r", 4.0), ("neck", 2.0)] {
        let i = stage.body(name);
        let torque = |d: &Drive| d.torque(&stage.model.bodies[i], &stage.q, &stage.v);
        assert!((torque(&drives[i]) - torque(&stage.drives[i])).norm() < 1e-9, "{name}"); // 4e-15 seen
        assert_eq!(drives[i].stiffness, factor * STIFFNESS);
        assert!((drives[i].damping - 4.0 * f64::sqrt(factor)).abs() < 1e-12);
    }
}

/// Goals stay within the limits of a joint.
#[test]
fn limits_are_kept() {
    let stage = Stage::new();
    let drives = once("body[\"elbow_r\"].turn_deg = -170;").unwrap();
    let i = stage.body("elbow_r");
    let (Rest::Scalar(a), Rest::Scalar(b)) = (stage.drives[i].rest, drives[i].rest) else { panic!() };
    let link = &stage.skeleton().links()[stage.model.bodies[i].link];
    let Some(motion::Limits::Axis(range)) = &link.limits else { panic!() };
    let lowest = (range.lo - stage.q[stage.model.bodies[i].q_at]).min(0.0);
    assert!((b - a - lowest).abs() < 1e-9, "{} {lowest}", b - a);
}

/// A copy goes on as the original: its memory is its own. Contacts and motion are as they are.
#[test]
fn memory_is_copied() {
    let text = "
        fn memory() { #{ n: 0, list: [] } }
        fn react(body, params) {
            this.n += 1;
            this.list.push(noise(3, body.time_s));
            let load = body.force_n(\"ankle_l\")[1] / 400.0;
            body[\"elbow_r\"].turn_deg = load * this.n + this.list[this.list.len() - 1];
        }";
    let stage = Stage::new();
    let mut own = reaction(text);
    for i in 0..5 {
        stage.react(&mut own, i as f64 / 240.0).unwrap();
    }
    let mut ahead = own.clone();
    let looked: Vec<_> = (5..10).map(|i| stage.react(&mut ahead, i as f64 / 240.0).unwrap()).collect();
    let lived: Vec<_> = (5..10).map(|i| stage.react(&mut own, i as f64 / 240.0).unwrap()).collect();
    assert_eq!(looked, lived);
    assert_ne!(lived[0], lived[1]);
    let turned = own.reacted()[0].turned_deg;
    assert!(turned > 9.0 && turned < 11.0, "{turned}");
    assert!(own.lines()[0].starts_with("mine.rhai: elbow_r turned by at most"), "{:?}", own.lines());
}

/// What is wrong is said with its place, a loop without end among it.
#[test]
fn faults_have_their_place() {
    for (body, message, place) in [
        (
            "body[\"elbow_r\"].turn_deg = 0.0 / 0.0;",
            "turn_deg is NaN; allowed: a finite number",
            "mine.rhai:2:",
        ),
        (
            "body[\"elbw_r\"];",
            "there is no joint `elbw_r` that muscles move; did you mean `elbow_r`?",
            "mine.rhai:2:",
        ),
        ("body[\"pelvis\"];", "there is no joint `pelvis` that muscles move", "mine.rhai:2:"),
        ("body[\"neck\"].turn_deg = 3;", "turn_deg takes a list of three numbers", "mine.rhai:2:"),
        (
            "body[\"neck\"].turn_deg = [200, 0, 0];",
            "turn_deg turns by 200°; allowed: up to 180°",
            "mine.rhai:2:",
        ),
        ("body[\"neck\"].tension = 0;", "tension is 0; allowed: 0.05 to 20", "mine.rhai:2:"),
        ("let i = 0;\nwhile true { i += 1; }", "more steps than are allowed", "mine.rhai:3:"),
        ("this.kept = body[\"neck\"];", "belongs to one step", "mine.rhai:1:1"),
    ] {
        let said = once(body).unwrap_err();
        assert!(said.contains(message) && said.contains(place), "{body}: {said}");
    }
}
