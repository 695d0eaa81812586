//! Bad input is told with what was found.

use std::sync::Arc;

use motion::{Clip, Joint, Link, Skeleton, Vec3};
use retarget::contacts::phases;
use retarget::refine::refine;
use retarget::{
    ContactPoint, Features, Follow, GplvmOptions, KeyPose, KeyPoses, Mapping, MappingModel, Options, Phase,
    Puppet, RefineDofs, RefineOptions, RetargetError, WorldOptions, run,
};

use crate::bodies::{key_poses, mocap, puppet, same_angles, scaled};

#[test]
fn bad_requests_are_told() {
    let (performer, human) = mocap("16_21");
    let body = scaled(&performer.character, 0.5, 1.0);
    let puppet = puppet(body.clone());
    let own = same_angles(&human, &puppet.character, 0.5);
    let keys = key_poses(&performer, &human, &puppet, 0.5, 10);
    let learn = |k: &KeyPoses| {
        Mapping::learn(&puppet, k, MappingModel::Gp, &GplvmOptions::default()).map(|_| ()).unwrap_err()
    };
    let say = |e: &RetargetError| println!("{e}");

    let few = KeyPoses { pairs: keys.pairs[..2].to_vec() };
    let e = learn(&few);
    say(&e);
    assert!(matches!(e, RetargetError::TooFewKeyPoses { found: 2, least: 3 }));

    let mut twice = keys.clone();
    twice.pairs.push(KeyPose { name: "again".into(), ..keys.pairs[1].clone() });
    let e = learn(&twice);
    say(&e);
    assert!(matches!(&e, RetargetError::Duplicate { second, .. } if second == "again"));

    let mut contrary = keys.clone();
    let other = keys.pairs[4].character.clone();
    contrary.pairs.push(KeyPose { name: "other".into(), character: other, ..keys.pairs[1].clone() });
    let e = learn(&contrary);
    say(&e);
    assert!(matches!(e, RetargetError::Contradiction { apart_mm, .. } if apart_mm > 5.0));

    let whose = Arc::new(performer.clone());
    let e = KeyPose::of_frame("late", "walk", &whose, &human, 900, 0.0, own.pose(0).to_vec()).unwrap_err();
    say(&e);
    assert!(matches!(e, RetargetError::Frame { frame: 900, frames: 78, .. }));

    let stick = Skeleton::new(vec![Link::new("stick", None, Vec3::zeros(), Joint::Free)]).unwrap();
    let strange = Clip::new(Arc::new(stick.clone()), 30.0, stick.zero_pose().repeat(10));
    let e = run(&strange, &performer, &puppet, &keys, &Options::default()).unwrap_err();
    say(&e);
    assert!(matches!(e, RetargetError::Skeleton(_)));

    let mut poor = performer.clone();
    poor.features.points.retain(|p| p.name != "crown");
    let e = run(&human, &poor, &puppet, &keys, &Options::default()).unwrap_err();
    say(&e);
    assert!(matches!(&e, RetargetError::MarkersMissing { missing, .. } if missing == &["crown"]));

    let e = Features::named(&puppet.character.skeleton, &["crwn"], puppet.features.root).unwrap_err();
    say(&e);
    assert!(matches!(&e, RetargetError::Marker { hint, .. } if hint.contains("crown")));

    let e = Puppet::new(body.clone(), Vec::new()).unwrap_err();
    say(&e);
    assert!(
        matches!(&e, RetargetError::NothingFollows { points, .. } if points.len() == body.contacts.len())
    );
    let floating = bodies::Character { contacts: Vec::new(), ..body.clone() };
    let e = Puppet::new(floating, Vec::new()).unwrap_err();
    say(&e);
    assert!(matches!(e, RetargetError::NoContactPoint { .. }));

    let wrong = ContactPoint { site: body.contacts[0], human: vec!["heal_l".into()], follow: Follow::Any };
    let odd = Puppet::new(body, vec![wrong]).unwrap();
    let e = phases::find(&performer, &human, &odd, &Options::default().contact).unwrap_err();
    say(&e);
    assert!(matches!(&e, RetargetError::Counterpart { human, .. } if human == "heal_l"));

    let phase = |point: &str, from_s, to_s| vec![Phase { point: point.into(), from_s, to_s }];
    for given in [phase("heel_x", 0.0, 1.0), phase("heel_l_in", 1.0, 0.0), phase("heel_l_in", 0.0, 99.0)] {
        let e = phases::frames_of_phases(&puppet, &given, &own).unwrap_err();
        say(&e);
        assert!(matches!(e, RetargetError::Phase { .. }));
    }

    let dofs = RefineDofs::Links(vec!["Hed".into()]);
    let o = RefineOptions { dofs, ..RefineOptions::default() };
    let e = refine(&puppet, &own, &[], &vec![1e-3; own.frames()], &WorldOptions::default(), &o).unwrap_err();
    say(&e);
    assert!(matches!(&e, RetargetError::RefineLink { hint, .. } if hint.contains("Head")));

    let mut o = Options::default();
    o.world.gravity_m_s2 = 0.0;
    let e = run(&human, &performer, &puppet, &keys, &o).unwrap_err();
    say(&e);
    assert!(matches!(e, RetargetError::Option { name, .. } if name.starts_with("gravity")));

    let o = Options { rate_hz: Some(-1.0), ..Options::default() };
    let e = run(&human, &performer, &puppet, &keys, &o).unwrap_err();
    say(&e);
    assert!(matches!(e, RetargetError::Option { .. }));
}
