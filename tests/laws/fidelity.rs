//! Help from outside: on the record, never beyond its budget, and what it buys.

use rayon::ThreadPoolBuilder;
use sim::EngineEntry;
use studies::pareto::pareto;
use takes::Ask;

/// More fidelity follows closer; the help stays within its budget; none is none. The same on one thread.
#[test]
fn slow_fidelity_buys_tracking_within_its_budget() {
    let take = takes::open(support::scene("bow.ron"), &Ask::default()).unwrap();
    let curve = pareto(&take, &[1.0, 0.0, 0.3], &EngineEntry::default(), &|_| {}).unwrap();
    for p in &curve.points {
        println!(
            "{}: {:.1} of {:.1} N, {:.1} of {:.1} N·m, {:.1} mm, {:.2}°",
            p.fidelity,
            p.force_peak_n,
            p.force_budget_n,
            p.moment_peak_nm,
            p.moment_budget_nm,
            p.position_rms_mm,
            p.joint_rms_deg
        );
        assert!(p.stands(), "{} fell", p.fidelity);
        assert!(p.force_peak_n <= p.force_budget_n * (1.0 + 1e-12), "{} N", p.force_peak_n);
        assert!(p.moment_peak_nm <= p.moment_budget_nm * (1.0 + 1e-12), "{} N·m", p.moment_peak_nm);
        let weight = curve.weight_n;
        assert!((p.force_budget_n - p.fidelity.powi(2) * weight).abs() < 1e-9);
        assert!(p.force_rms_n <= p.force_peak_n);
    }
    let [free, some, all] = &curve.points[..] else { panic!("three points") };
    assert_eq!((free.fidelity, free.force_rms_n, free.impulse_ns), (0.0, 0.0, 0.0));
    assert!(some.force_rms_n > 1.0 && some.impulse_ns > 1.0);
    // 30, 22 and 11 mm seen
    assert!(some.position_rms_mm < 0.9 * free.position_rms_mm, "{}", some.position_rms_mm);
    assert!(all.position_rms_mm < 0.7 * some.position_rms_mm, "{}", all.position_rms_mm);
    assert!(all.joint_rms_deg < some.joint_rms_deg && some.joint_rms_deg < free.joint_rms_deg);

    let one = ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let again = one.install(|| pareto(&take, &[0.3], &EngineEntry::default(), &|_| {}).unwrap());
    assert_eq!(again.points[0].position_rms_mm, some.position_rms_mm);
    assert_eq!(again.points[0].impulse_ns, some.impulse_ns);
}
