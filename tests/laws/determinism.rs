//! The same pass gives the same trace, to the bit, alone or beside others.

use std::sync::Arc;

use dynamics::{RootMode, Trace};

use super::bodies::human;
use super::stage::{bow, perform, run};

/// Everything but the wall time, as bits.
fn bits(t: &Trace) -> Vec<u64> {
    let contacts = t.contacts.iter().flat_map(|c| {
        [
            c.row as f64,
            c.link as f64,
            c.point.x,
            c.point.y,
            c.point.z,
            c.force.x,
            c.force.y,
            c.force.z,
            c.depth,
        ]
    });
    let columns =
        [&t.q, &t.v, &t.target, &t.torque, &t.k_lo, &t.k_hi, &t.kd, &t.root_wrench, &t.com, &t.momentum];
    let rest = [&t.link_com, &t.energy];
    columns.into_iter().chain(rest).flatten().copied().chain(contacts).map(f64::to_bits).collect()
}

#[test]
fn slow_the_same_pass_gives_the_same_bits() {
    let c = Arc::new(human());
    let tracks = bow(&c);
    for root in [RootMode::Free, RootMode::Pinned] {
        let once = || bits(&run(perform(&c, &tracks, root, 240.0, 2)).trace);
        let alone = once();
        assert!(alone.len() > 100_000);
        assert_eq!(alone, once(), "{root:?}: a second run differs");
        let together: Vec<Vec<u64>> = std::thread::scope(|s| {
            let runs: Vec<_> = (0..3).map(|_| s.spawn(once)).collect();
            runs.into_iter().map(|r| r.join().unwrap()).collect()
        });
        for other in together {
            assert!(alone == other, "{root:?}: a run beside others differs");
        }
    }
}
