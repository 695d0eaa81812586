//! Laws of contact plans: order, what stands when, retiming, refusals.

use motion::contact_plan::{Contact, ContactPlan};
use motion::{TimeMap, Transform, Vec3};

fn contact(point: &str, from_s: f64, to_s: f64) -> Contact {
    Contact { point: point.into(), from_s, to_s, world_from_point: None }
}

/// Two steps of a walk, given out of order.
fn walk() -> ContactPlan {
    let mut first = contact("leg_l", 0.0, 0.6);
    first.world_from_point = Some(Transform::translation(0.1, 0.0, 0.2));
    ContactPlan::new(vec![
        contact("leg_r", 0.5, 1.2),
        contact("leg_l", 1.1, 1.7),
        contact("heel_r", 0.5, 0.9),
        first,
    ])
    .unwrap()
}

fn points<'a>(contacts: impl Iterator<Item = &'a Contact>) -> Vec<(&'a str, f64)> {
    contacts.map(|c| (c.point.as_str(), c.from_s)).collect()
}

#[test]
fn plans_are_sorted_and_answer_by_time_and_by_point() {
    let plan = walk();
    let all = [("leg_l", 0.0), ("heel_r", 0.5), ("leg_r", 0.5), ("leg_l", 1.1)];
    assert_eq!(points(plan.contacts().iter()), all);
    assert_eq!(points(plan.of("leg_l")), [("leg_l", 0.0), ("leg_l", 1.1)]);
    assert_eq!(points(plan.of("tail")), []);
    // both ends belong to a contact
    for (t, standing) in [
        (-0.1, vec![]),
        (0.0, vec!["leg_l"]),
        (0.6, vec!["leg_l", "heel_r", "leg_r"]),
        (0.7, vec!["heel_r", "leg_r"]),
        (1.7, vec!["leg_l"]),
    ] {
        let found: Vec<&str> = plan.at(t).map(|c| c.point.as_str()).collect();
        assert_eq!(found, standing, "{t}");
    }
}

/// A part has its own clock, and what stands at any time of it is what stood then; frames are those at whose times a point stands.
#[test]
fn parts_and_frames_stand_when_the_whole_does() {
    let plan = walk();
    let part = plan.between(0.55, 1.15);
    assert_eq!(points(part.of("leg_l")), [("leg_l", 0.0), ("leg_l", 1.1 - 0.55)]);
    for t in [0.0, 0.04, 0.2, 0.4, 0.59] {
        let names = |p: &ContactPlan, t: f64| -> Vec<String> {
            let mut names: Vec<String> = p.at(t).map(|c| c.point.clone()).collect();
            names.sort();
            names
        };
        assert_eq!(names(&part, t), names(&plan, 0.55 + t), "{t}");
    }
    assert_eq!(plan.between(0.0, 2.0), plan);
    assert_eq!(plan.points(), ["heel_r", "leg_l", "leg_r"]);
    // 30 frames a second are not exact in binary
    for (from, to) in [(3usize, 7usize), (0, 0), (11, 29)] {
        let c = contact("leg_l", from as f64 / 30.0, to as f64 / 30.0);
        assert_eq!(c.frames(30.0, 30), from..to + 1);
    }
    assert!(contact("leg_l", 0.11, 0.12).frames(30.0, 30).is_empty());
    assert!(contact("leg_l", 3.0, 4.0).frames(30.0, 30).is_empty());
}

#[test]
fn contacts_follow_a_time_map_and_places_stay() {
    let plan = walk();
    assert_eq!(plan.retimed(&TimeMap::identity()), plan);
    let map = TimeMap::new(&[(0.0, 0.0), (0.6, 0.9), (1.7, 2.5)]).unwrap();
    let late = plan.retimed(&map);
    assert_eq!(points(late.of("leg_l")), [("leg_l", 0.0), ("leg_l", map.at(1.1))]);
    let ends: Vec<f64> = late.of("leg_l").map(|c| c.to_s).collect();
    assert_eq!(ends, [0.9, 2.5]);
    for (a, b) in plan.contacts().iter().zip(late.contacts()) {
        assert_eq!((&a.point, a.world_from_point), (&b.point, b.world_from_point));
    }
    // what a retimed plan holds is a plan
    assert_eq!(ContactPlan::new(late.contacts().to_vec()).unwrap(), late);
}

#[test]
fn refusals_say_what_was_found() {
    let words = |contacts: Vec<Contact>| ContactPlan::new(contacts).unwrap_err().to_string();
    assert_eq!(words(vec![contact("", 0.0, 1.0)]), "the contact from 0 s to 1 s names no point");
    let times = "allowed: finite times, the first no later than the last";
    assert_eq!(
        words(vec![contact("leg_l", 1.0, 0.5)]),
        format!("the contact of `leg_l` is from 1 s to 0.5 s; {times}")
    );
    assert_eq!(
        words(vec![contact("leg_l", 0.0, f64::INFINITY)]),
        format!("the contact of `leg_l` is from 0 s to inf s; {times}")
    );
    let overlap = "the contact of `leg_l` from 0.5 s begins before the one that ends at 1 s has ended; a point has one contact at a time";
    assert_eq!(
        words(vec![contact("leg_l", 0.5, 2.0), contact("leg_r", 0.2, 3.0), contact("leg_l", 0.0, 1.0)]),
        overlap
    );
    // ends count: two contacts of one point do not share a time
    assert!(ContactPlan::new(vec![contact("leg_l", 0.0, 1.0), contact("leg_l", 1.0, 2.0)]).is_err());
    // one moment is a contact
    assert!(ContactPlan::new(vec![contact("leg_l", 1.0, 1.0)]).is_ok());
    let mut nowhere = contact("toe_l", 0.0, 1.0);
    nowhere.world_from_point = Some(Transform::from(Vec3::new(0.0, f64::NAN, 0.0)));
    assert_eq!(
        words(vec![nowhere]),
        "the contact of `toe_l` from 0 s to 1 s has a place with a number that is not finite"
    );
}
