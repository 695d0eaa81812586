//! Words in reports: what a scene says holds the root, and how it moves, is what `report.json` and `inspect` write.

use std::path::Path;

use bodies::JointClass;
use formats::bvh::ImportOptions;
use motion::CurveName;
use motion::names::Word;
use scenes::overrides::RootName;
use takes::inspect::{Inspection, inspect};
use takes::{Ask, Engines, Input, Progress, Report, Take, open};

fn take(text: &str) -> Take {
    let ron = format!("Scene(character: \"characters/human.ron\", rate_hz: 30, settle_s: 0.1, {text})");
    let base = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes");
    open(Input::Text { ron, base }, &Ask::default()).unwrap_or_else(|e| panic!("{text}: {e}"))
}

#[test]
fn a_report_names_the_root_as_scenes_do() {
    for (root, data) in
        [(RootName::Free, ""), (RootName::Assisted, "(force_n: 10, moment_nm: 5)"), (RootName::Pinned, "")]
    {
        let take = take(&format!("root: {}{data}, physics: (rate_hz: 240)", root.identifier()));
        let performed = take.perform(&Engines::default(), &Progress::silent()).unwrap();
        let report = Report::new(&performed);
        assert_eq!(report.dynamic.unwrap().root.mode, root.word());
    }
}

#[test]
fn an_inspection_names_curves_classes_and_roots_as_scenes_do() {
    let folder = tempfile::tempdir().unwrap();
    let human =
        std::path::absolute(Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/characters/human.ron"))
            .unwrap();
    let file = folder.path().join("a.ron");
    for &(curve, ..) in CurveName::WORDS {
        let written =
            curve.identifier() + if curve == CurveName::Bezier { "(0.1, 0.0, 0.9, 1.0)" } else { "" };
        let ron = format!(
            "Scene(character: {human:?}, root: Free, properties: (curve: {written}), script: [Action(name: \"nod\", \
             cycles: [Cycle(poses: [Pose(duration_s: 0.3, set_deg: {{\"elbow_r\": 20}})])])])"
        );
        std::fs::write(&file, ron).unwrap();
        let (found, _) = inspect(&file, &ImportOptions::default()).unwrap_or_else(|e| panic!("{e}"));
        let Inspection::Scene(found) = found else { panic!("{found:?}") };
        assert_eq!(found.root, RootName::Free.word());
        assert!(found.elements.iter().any(|e| e.curve == written), "{written}: {:?}", found.elements);
        for link in found.body.links {
            let class = link.class.as_deref().map(JointClass::find);
            assert!(matches!(class, None | Some(Ok(_))), "{}: {:?}", link.name, link.class);
        }
    }
}
