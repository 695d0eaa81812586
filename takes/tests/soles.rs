//! Soles of takes: who stands on pads stands, at the height of rigid soles; bodies without feet are told.

use std::path::Path;

use sim::Engines;
use takes::{Ask, Input, Take, open};

fn take(body: &str, text: &str) -> Take {
    let ron = format!(
        "Scene(character: \"characters/{body}.ron\", rate_hz: 60, settle_s: 1.5, root: Free, {text})"
    );
    let base = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes");
    open(Input::Text { ron, base }, &Ask::default()).unwrap_or_else(|e| panic!("{text}: {e}"))
}

/// The human stands on pads in both engines as high as on rigid soles, and its trace has nothing of the pads but their forces.
#[test]
fn who_stands_on_pads_stands_as_high() {
    let engines = Engines::default();
    for engine in ["rapier", "core"] {
        let stand = |soles: &str| {
            let take = take("human", &format!("engine: \"{engine}\", physics: (soles: {soles})"));
            let outcome = take.outcome(&engines, &mut |_| {}).unwrap();
            assert_eq!(outcome.fell_s, None, "{engine} {soles}");
            outcome.trace
        };
        let (hard, soft) = (stand("Rigid"), stand("Pads()"));
        let nq = soft.character.skeleton.nq();
        assert_eq!((nq, soft.v.len()), (hard.character.skeleton.nq(), hard.v.len()));
        let row = soft.rows() - 1;
        let low = soft.pose(row)[1] - hard.pose(row)[1];
        let weight = soft.character.mass() * soft.gravity.norm();
        let force = soft.contact_sums()[row].y / weight;
        let unexplained = soft.residual().iter().map(|x| x.abs()).fold(0.0, f64::max) / weight;
        println!("{engine}: {:.2} mm, {force:.4} of the weight, unexplained {unexplained:.1e}", 1e3 * low);
        assert!(low.abs() < 2e-3, "{low}");
        assert!((force - 1.0).abs() < 0.02, "{force}");
        assert!(soft.contacts_in(row).iter().all(|c| c.link < soft.character.bodies.len()));
        assert_ne!(soft.q, hard.q);
    }
}

/// A lamp has no feet: asked for pads, it says so before anything is simulated.
#[test]
fn a_body_without_feet_is_refused() {
    let asked = take("lamp", "physics: (soles: Pads())");
    let refused = asked.outcome(&Engines::default(), &mut |_| {}).map(|_| ()).unwrap_err();
    assert!(refused.is_input() && refused.to_string().contains("soles that yield need feet"), "{refused}");
    let bent = take("human", "physics: (toes: Bend(stiffness_nm_rad: 40))");
    let refused = bent.outcome(&Engines::default(), &mut |_| {}).map(|_| ()).unwrap_err();
    assert!(refused.is_input() && refused.to_string().contains("has no toes to bend"), "{refused}");
}
