//! What `render` says of a clip is what `analyze` says.

use formats::bvh::ImportOptions;
use takes::{AnalysisReport, AnalysisSettings, Ask, Report, analysis};

/// Walks, idling, gestures: one grade, one slip, one share of frames outside the soles. The feet of the motion asked for (within
/// joint limits, not smoothed) slip as those of the analysis do, to centimetres: both are measured over the same ground, and
/// neither takes a swing for a slip (260 mm once).
#[test]
fn slow_a_render_and_an_analysis_agree() {
    for name in ["16_21", "16_16", "02_01", "127_01", "14_37"] {
        let path = support::shared(&format!("mocap/bvh/{name}.bvh"));
        let report = Report::new(&takes::open(&path, &Ask::default()).unwrap().preview());
        let input = analysis::open(&path, None, &ImportOptions::default()).unwrap();
        let analysed = AnalysisReport::new(&input, &input.analyze(&AnalysisSettings::default()).unwrap());
        let said = report.plausibility.unwrap();
        let slip = analysed.ground.feet.unwrap().slip_mm_max;
        let asked = report.kinematic.feet.unwrap().slip_mm_max;
        println!(
            "{name}: {}; slip {slip:.1} mm and {asked:.1} mm, {:.1} % outside",
            said.text,
            100.0 * said.outside_soles_share
        );
        assert_eq!((&said.grade, said.text), (&analysed.plausible, analysed.verdict()));
        assert_eq!(said.slip_mm_max, Some(slip));
        assert_eq!(said.outside_soles_share, analysed.support.share);
        assert!((asked - slip).abs() < 15.0, "{name}: {asked} mm and {slip} mm"); // 6 seen
        assert!(slip < 50.0, "{name}: {slip} mm"); // 38 seen
        assert!(said.outside_soles_share < 0.2, "{name}: {}", said.outside_soles_share);
    }
}
