//! Bodies written as MJCF: read back by us, compiled by MuJoCo, standing on their own floor.

use std::path::{Path, PathBuf};
use std::process::Command;

use formats::model::{ImportOptions, Imported};
use motion::Joint;
use takes::export::{BodyMjcf, mjcf};

fn written(path: &Path, folder: &Path) -> (BodyMjcf, PathBuf) {
    let made = mjcf(path, &Default::default(), true).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let file = folder.join("body.xml");
    std::fs::write(&file, &made.text).unwrap();
    (made, file)
}

fn read(path: &Path) -> Imported {
    formats::open_model(path, &ImportOptions { dynamics_only: true }).unwrap_or_else(|e| panic!("{e}"))
}

/// Bodies that stand on a floor of their own: that of the help, the others of the library, a scene, a clip, a model.
fn standing() -> Vec<PathBuf> {
    let mut all: Vec<PathBuf> = ["human", "lamp", "penguin", "squirrel"]
        .map(|name| support::scene(&format!("characters/{name}.ron")))
        .into_iter()
        .collect();
    all.extend(["bow.ron", "slope.ron"].map(support::scene));
    all.push(support::shared("cases/models/refroot.xml"));
    all
}

const STANDS: &str = r#"
import sys, json, mujoco
m = mujoco.MjModel.from_xml_path(sys.argv[1])
d = mujoco.MjData(m)
def lowest():
    mujoco.mj_forward(m, d)
    floor = m.geom("ground").id
    # a distance is not searched for beyond this
    gaps = [mujoco.mj_geomDistance(m, d, floor, g, 10.0, None) for g in range(m.ngeom) if g != floor]
    return min(gaps)
start = lowest()
mujoco.mj_resetDataKeyframe(m, d, m.key("rest").id)
rest = lowest()
joints = [m.joint(j).name for j in range(m.njnt)]
mujoco.mj_resetData(m, d)
m.opt.enableflags |= int(mujoco.mjtEnableBit.mjENBL_ENERGY)
mujoco.mj_forward(m, d)
before = most = sum(d.energy)
while d.time < 2.0:
    mujoco.mj_step(m, d)
    most = max(most, sum(d.energy))
weight = float(m.body_subtreemass[0]) * 9.81
bad = sum(int(w.number) for w in d.warning)
print(json.dumps({"start": start, "rest": rest, "joints": joints, "gain": (most - before) / weight, "bad": bad, "mass": float(m.body_subtreemass[0])}))
"#;

/// In its rest pose the lowest solid touches the floor; without the key frame nothing is inside it; and left to itself the body falls
/// limp without gaining energy: nothing explodes. (The human that once stood 0.93 m inside its floor diverged at 0.34 s.)
#[test]
fn slow_a_body_stands_on_its_own_floor_in_mujoco() {
    let python = crosscheck::environment::prepare(&mut |_| {}).unwrap();
    let folder = tempfile::tempdir().unwrap();
    for path in standing() {
        let (made, file) = written(&path, folder.path());
        let out = Command::new(&python).args(["-c", STANDS]).arg(&file).output().unwrap();
        assert!(out.status.success(), "{}: {}", path.display(), String::from_utf8_lossy(&out.stderr));
        let text = String::from_utf8_lossy(&out.stdout).into_owned();
        println!("{}: {}", path.display(), text.trim());
        let v: serde_json::Value = serde_json::from_str(&text).unwrap();
        let number = |name: &str| v[name].as_f64().unwrap();
        let rest = number("rest");
        let name = path.file_name().unwrap().to_string_lossy();
        // what stands, stands within a millimetre; the one that hangs in the air stays there
        let wanted = if name == "refroot.xml" { 0.8 } else { 0.0 };
        assert!((rest - wanted).abs() < 1e-3, "{name}: rest {rest}");
        assert!(number("start") > -1e-6, "{name}: {}", number("start"));
        // metres of the body's height; 0 seen
        assert!(number("bad") == 0.0 && number("gain") < 1e-3, "{name}: {text}");
        assert!((number("mass") - made.mass_kg).abs() < 1e-9, "{name}");
        assert_eq!(v["joints"].as_array().unwrap().len(), made.joints, "{name}");
    }
}

/// What is written is read back: the same joints, the same rest pose to rounding, the same floor.
#[test]
fn what_is_written_is_read_back_in_its_rest_pose() {
    let folder = tempfile::tempdir().unwrap();
    for path in standing() {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let (made, file) = written(&path, folder.path());
        let back = read(&file);
        assert_eq!(
            (back.joints.len(), back.ground.map(|g| g.height_m)),
            (made.joints, made.ground_m),
            "{name}"
        );
        assert!((back.character.mass() - made.mass_kg).abs() < 1e-12, "{name}");
        written(&file, folder.path());
        let second = read(&folder.path().join("body.xml"));
        let largest = back
            .character
            .rest
            .iter()
            .zip(&second.character.rest)
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max);
        assert!(largest < 1e-12, "{name}: {largest}");
    }
}

/// The root's place and turn, a hinge's `ref` and its name come out as they went in.
#[test]
fn the_rest_pose_of_a_model_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let case = support::shared("cases/models/refroot.xml");
    let (made, file) = written(&case, folder.path());
    assert!(made.text.contains("<joint name=\"sh\" type=\"hinge\""), "{}", made.text);
    assert_eq!(made.ground_m, Some(0.0));
    let (before, after) = (read(&case), read(&file));
    let names = |m: &Imported| m.joints.iter().map(|j| j.name.clone()).collect::<Vec<_>>();
    assert_eq!(names(&after)[1], "sh");
    let (a, b) = (&before.character, &after.character);
    assert!((a.rest[7] - 40_f64.to_radians()).abs() < 1e-15 && (a.rest[7] - b.rest[7]).abs() < 1e-15);
    // the file is Y up: the root stands at the same place of our world, turned alike
    let world =
        |m: &Imported| motion::Kinematics::new(&m.character.skeleton, &m.character.rest).world.clone();
    for (i, (x, y)) in world(&before).iter().zip(&world(&after)).enumerate() {
        let apart = (x.translation.vector - y.translation.vector).norm();
        assert!(apart < 1e-14 && x.rotation.angle_to(&y.rotation) < 1e-7, "link {i}: {x} {y}");
    }
    assert!(matches!(b.skeleton.links()[0].joint, Joint::Free));
}
