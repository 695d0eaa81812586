//! MuJoCo from the table of engines: engines that live at once do not share a process.
//!
//! MuJoCo's Python environment is made on the first run.

use bodies::anthropometry::human::human;
use motion::{Floor, Vec3};
use sim::{ContactLaw, Engine, EngineError, EngineSettings, Engines};

fn engines() -> Engines {
    let mut all = Engines::default();
    all.add(crosscheck::engine(|_| {}));
    all
}

fn settings() -> EngineSettings {
    EngineSettings {
        rate_hz: 240.0,
        substeps: 1,
        gravity: Vec3::new(0.0, -9.81, 0.0),
        ground: None,
        pinned: false,
        contact: ContactLaw::Stiff,
        props: Default::default(),
        self_collision: false,
    }
}

/// Two bodies stepped in turn, one after the other's end, move as each does alone, to the bit.
#[test]
fn slow_engines_that_live_at_once_do_not_meet() {
    let engines = engines();
    let mujoco = engines.get("mujoco").unwrap();
    let human = human().0;
    let build = |scale: f64| -> Box<dyn Engine> {
        let v: Vec<f64> = (0..human.skeleton.nv()).map(|i| scale * (i as f64 * 2.3).cos()).collect();
        mujoco.build(&human, settings(), &human.rest, &v).unwrap()
    };
    let alone = [0.5, -0.3].map(|scale| {
        let mut engine = build(scale);
        (0..10).for_each(|_| engine.step().unwrap());
        engine.q().to_vec()
    });
    let mut together = [build(0.5), build(-0.3)];
    for _ in 0..10 {
        together.iter_mut().for_each(|engine| engine.step().unwrap());
    }
    for (engine, alone) in together.iter().zip(&alone) {
        assert_eq!(engine.name(), "mujoco");
        assert_eq!(engine.q(), alone);
    }
    assert_ne!(alone[0], alone[1]);
}

/// As many steps as are asked for: one Runge–Kutta step in place of eight leaves another motion; what is not asked for are eight.
#[test]
fn slow_substeps_are_those_asked_for() {
    let engines = engines();
    let mujoco = engines.get("mujoco").unwrap();
    assert_eq!(mujoco.substeps(), Some(8));
    let human = human().0;
    let v: Vec<f64> = (0..human.skeleton.nv()).map(|i| (i as f64 * 2.3).cos()).collect();
    let end = |substeps: usize| {
        let settings = EngineSettings { substeps, ..settings() };
        let mut engine = mujoco.build(&human, settings, &human.rest, &v).unwrap();
        (0..10).for_each(|_| engine.step().unwrap());
        engine.q().to_vec()
    };
    let apart = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
    let [one, two, eight] = [1, 2, 8].map(end);
    // fourth order: the error of one step is some sixteen times that of two
    let (coarse, fine) = (apart(&one, &eight), apart(&two, &eight));
    assert!(fine > 0.0 && coarse > 8.0 * fine && coarse < 1e-3, "{coarse} {fine}");
}

/// Contacts of a given compliance have no translation that holds for any body: refused, not ignored.
#[test]
fn spring_contacts_are_refused() {
    let contact = ContactLaw::Spring { natural_frequency_hz: 8.0, damping_ratio: 0.2 };
    let settings = EngineSettings { ground: Some(Floor::level(0.0, 0.8)), contact, ..settings() };
    let human = human().0;
    let still = vec![0.0; human.skeleton.nv()];
    let refused = engines().get("mujoco").unwrap().build(&human, settings, &human.rest, &still).err();
    assert!(matches!(&refused, Some(EngineError::Failed(why)) if why.contains("spring")), "{refused:?}");
}
