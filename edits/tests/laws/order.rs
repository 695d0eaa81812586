//! Whatever edits are stacked, the tracks stay tracks.

use std::collections::BTreeSet;

use edits::{
    Amount, Amplitude, EditLog, ExtentReach, ExtentShoulder, Parameter, Selector, Succession, Tension,
    TrackEdit,
};

use crate::body::dance;

/// Numbers in [0, 1) from a linear congruence (Knuth's MMIX constants): the same on every machine.
struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn pick<'a>(&mut self, from: &[&'a str]) -> &'a str {
        from[(self.roll() * from.len() as f64) as usize]
    }
}

/// Three hundred stacks of five edits: in time order, in the order the script gave each DOF, finite,
/// labelled once, continuous, and no longer than the last hold.
#[test]
fn stacked_edits_leave_tracks_in_order() {
    let places = ["bow", "wave", "bow_0_0", "wave_0", "wave_0_1", "wave_1", "wave_0_0_elbow_r_1", "nod"];
    let parts = ["trunk", "arm_r", "arm_l", "elbow_r", "pelvis_y", "leg_l"];
    let mut dice = Dice(2003);
    for stack in 0..300 {
        let (mut tracks, mut log) = (dance(), EditLog::default());
        for _ in 0..5 {
            let mut on = Selector::label(dice.pick(&places));
            if dice.roll() < 0.3 {
                on = Selector::default();
            }
            if dice.roll() < 0.3 {
                on = on.of([dice.pick(&parts), dice.pick(&parts)]);
            }
            let x = 0.2 + 2.0 * dice.roll();
            let edit: Box<dyn TrackEdit> = match (dice.roll() * 6.0) as usize {
                0 => Box::new(Amplitude::new(Parameter::OverRepetition(vec![(0.0, 1.0), (2.0, x)]))),
                1 => Box::new(Succession::forward(0.3 * x)),
                2 => Box::new(Succession::reverse(Parameter::OverTime(vec![(0.0, 0.0), (2.0, 0.3 * x)]))),
                3 => Box::new(ExtentShoulder::new(x)),
                4 => Box::new(ExtentReach::new(x)),
                _ => Box::new(Tension { amount: Amount::Factor(x.into()) }),
            };
            let selection = on.select(&tracks).unwrap();
            edit.apply(&mut tracks, &selection, &mut log).unwrap();
        }
        let mut seen = BTreeSet::new();
        let script = dance();
        for track in &tracks.tracks {
            let e = &track.elements;
            assert!(e.windows(2).all(|w| w[0].start_s <= w[1].start_s), "stack {stack}");
            assert!(e.iter().all(|e| e.start_s >= 0.0 && e.hold_s >= 0.0 && e.end.is_valid()));
            assert!(e.iter().all(|e| seen.insert(e.label.clone())), "a label twice in stack {stack}");
            assert!(e.iter().all(|e| e.ends_s() <= tracks.duration_s));
            let original = script.track(track.dof).map(|t| t.elements.as_slice()).unwrap_or_default();
            let kept: Vec<_> = e.iter().map(|e| &e.label).filter(|l| script.element(l).is_some()).collect();
            assert_eq!(kept, original.iter().map(|e| &e.label).collect::<Vec<_>>(), "stack {stack}");
            for pair in e.windows(2) {
                let t = pair[1].start_s;
                let jump = tracks.value_at(track.dof, t).distance(&tracks.value_at(track.dof, t - 1e-9));
                assert!(jump < 1e-6, "stack {stack}: {jump} at {t} s");
            }
        }
    }
}
