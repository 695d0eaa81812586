//! Identity edits change nothing, to the bit, and nearly identity edits nearly nothing.

use edits::{
    Amount, Amplitude, ExtentReach, ExtentShoulder, Parameter, Selector, Succession, Tension, TrackEdit,
};
use motion::Tracks;

use crate::body::{apply, base, dance, skeleton};

/// Every edit, `by` away from its identity.
fn nearly(by: f64) -> Vec<Box<dyn TrackEdit>> {
    let one = Parameter::Constant(1.0 + by);
    vec![
        Box::new(Amplitude::new(1.0 + by)),
        Box::new(Amplitude::about(1.0 + by, base(&skeleton()))),
        Box::new(Amplitude { factor: Parameter::OverRepetition(vec![(0.0, 1.0 + by)]), reference: None }),
        Box::new(ExtentShoulder::new(1.0 + by)),
        Box::new(ExtentReach::new(1.0 + by)),
        Box::new(Tension { amount: Amount::Factor(one) }),
        Box::new(Succession::forward(by.abs())),
        Box::new(Succession::reverse(by.abs())),
    ]
}

/// A dance with one value outside its limits and one straight arm.
fn awkward() -> Tracks {
    let mut tracks = dance();
    for (_, e) in tracks.elements_mut() {
        match e.label.to_string().as_str() {
            "wave_0_1_13_1" => e.end = motion::Value::Scalar(0.0),
            "bow_0_0_9" => e.end = motion::Value::Scalar(-0.2),
            "wave_1_0_12" => e.end = motion::Value::Rotation(crate::body::turn(0.2, 0.1, 2.4)),
            _ => {}
        }
    }
    tracks
}

#[test]
fn identity_to_the_bit() {
    for edit in nearly(0.0) {
        let mut tracks = awkward();
        let log = apply(edit.as_ref(), &mut tracks, &Selector::default());
        // Debug prints every bit of every number
        assert_eq!(format!("{tracks:?}"), format!("{:?}", awkward()), "{}", edit.name());
        assert!(log.written_by(0).is_empty() && log.clamped().is_empty(), "{}", edit.name());
    }
}

/// 1 ± 1e-9 moves no joint by more than 1e-6 rad or m at any time. 1.5e-8 seen.
#[test]
fn nearly_identity_nearly_nothing() {
    let before = awkward();
    let still = before.sample(120.0);
    let nq = before.skeleton.nq();
    for edit in nearly(1e-9).into_iter().chain(nearly(-1e-9)) {
        let mut tracks = before.clone();
        apply(edit.as_ref(), &mut tracks, &Selector::default());
        assert!(tracks.duration_s - before.duration_s <= 1e-8);
        let mut q = vec![0.0; nq];
        let mut v = vec![0.0; before.skeleton.nv()];
        for frame in 0..still.frames() {
            tracks.pose_at(frame as f64 / 120.0, &mut q);
            before.skeleton.difference(still.pose(frame), &q, 1.0, &mut v);
            let worst = v.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
            assert!(worst < 1e-6, "{} frame {frame}: {worst}", edit.name());
        }
    }
}
