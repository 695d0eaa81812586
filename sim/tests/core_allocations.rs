//! A step of the core does not allocate, nor do saving and restoring.
//!
//! A binary of its own, because the counting allocator is global.

use allocation_counter::measure;
use bodies::anthropometry::human::human;
use bodies::{Character, Prop};
use controllers::{Drive, Rest, rest_of};
use dynamics::{Against, Wrench};
use motion::{Floor, Vec3};
use sim::{Core, Engine, EngineSettings};

#[test]
fn nothing_is_allocated_per_step() {
    let c = human().0;
    let settings = EngineSettings::free(240.0, 2, Some(Floor::level(0.0, 0.8)));
    // in the way of its fall
    let block = Prop::upright("block", Vec3::new(0.7, 0.0, 0.0), Vec3::new(0.6, 0.3, 2.0), 0.3, 0.8);
    let crowded = EngineSettings { props: vec![block].into(), self_collision: true, ..settings.clone() };
    for settings in [settings, crowded] {
        falls_without_memory(&c, settings);
    }
}

fn falls_without_memory(c: &Character, settings: EngineSettings) {
    let crowded = settings.self_collision;
    let mut core = Core::new(c, settings, &c.rest, &vec![0.0; c.skeleton.nv()]).unwrap();
    let bodies = core.model.bodies.len();
    let hold: Vec<Drive> = (0..bodies)
        .map(|i| Drive { stiffness: 400.0, damping: 40.0, rest: rest_of(&core.model, i, &c.rest) })
        .collect();
    let limp = vec![Drive { stiffness: 20.0, damping: 2.0, rest: Rest::None }; bodies];
    let mut saved = core.snapshot();
    let (mut contacts, mut most, mut others) = (Vec::with_capacity(1000), 0, [false; 2]);
    let count = measure(|| {
        // it stands, is pushed, and falls from head to foot
        for step in 0..400 {
            core.set_drives(if step < 100 { &hold } else { &limp });
            let force = Vec3::new(50.0, 0.0, 0.0);
            core.add_wrench(&Wrench { link: 1, point: Vec3::y(), force, moment: Vec3::zeros() });
            core.step().unwrap();
            contacts.clear();
            core.contacts(&mut contacts);
            others[0] |= contacts.iter().any(|c| matches!(c.against, Against::Prop(_)));
            others[1] |= contacts.iter().any(|c| matches!(c.against, Against::Link(_)));
            core.save(&mut saved);
            core.restore(&saved);
        }
        core.step().unwrap();
        contacts.clear();
        core.contacts(&mut contacts);
        most = contacts.len();
    });
    assert_eq!((count.count_total, count.bytes_total), (0, 0));
    assert!(most > 8, "{most}");
    assert_eq!(others, [crowded; 2], "props and links that it touched");
    // the counter counts
    assert_eq!(measure(|| drop(std::hint::black_box(vec![0.0; bodies]))).count_total, 1);
}
