//! `trace.npz` read back, and judged by `tests/momentum_balance.py`, which shares no code with it.

use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use bodies::{Body, Character, JointClass};
use dynamics::{ContactSample, RootMode, Trace};
use formats::trace_npz;
use motion::{Joint, Link, Shape, Skeleton, Vec3};
use nalgebra::Matrix3;
use npyz::NpyFile;
use zip::ZipArchive;

const GRAVITY: Vec3 = Vec3::new(0.0, -9.81, 0.0);

fn character() -> Arc<Character> {
    let links = vec![
        Link::new("trunk", None, Vec3::zeros(), Joint::Free),
        Link::new("arm", Some(0), Vec3::new(0.0, 0.4, 0.0), Joint::Revolute(Vec3::x())),
        Link::new("tête", Some(0), Vec3::new(0.0, 0.5, 0.0), Joint::Spherical),
    ];
    let skeleton = Arc::new(Skeleton::new(links).unwrap());
    let body = |mass: f64| Body {
        mass,
        com: Vec3::new(0.0, 0.1, 0.05),
        inertia: Matrix3::identity() * 0.1,
        shapes: vec![Shape::Sphere { center: Vec3::zeros(), radius: 0.1 }],
    };
    let rest = skeleton.zero_pose();
    Arc::new(Character {
        name: "dummy".into(),
        skeleton,
        bodies: vec![body(7.0), body(2.0), body(1.0)],
        classes: vec![JointClass::Root, JointClass::Shoulder, JointClass::Neck],
        contacts: Vec::new(),
        rest,
    })
}

/// A thrown body that two forces act on, integrated exactly as an engine of `substeps` semi-implicit
/// steps would: gravity, a varying force at a contact, a constant root wrench.
fn projectile(rows: usize, substeps: usize) -> Trace {
    let character = character();
    let (mass, rate_hz) = (10.0, 200.0);
    let (nq, nv) = (character.skeleton.nq(), character.skeleton.nv());
    let h = 1.0 / rate_hz / substeps as f64;
    let root_force = Vec3::new(3.0, 5.0, -2.0);
    let (mut x, mut velocity) = (Vec3::new(0.3, 1.0, -0.2), Vec3::new(0.5, 3.0, 1.0));
    let mut t = Trace {
        character: character.clone(),
        rate_hz,
        substeps,
        root: RootMode::Assisted { force_n: 10.0, moment_nm: 1.0 },
        ground_m: None,
        gravity: GRAVITY,
        q: Vec::new(),
        v: Vec::new(),
        target: Vec::new(),
        torque: vec![0.25; rows * nv],
        stop_torque: vec![0.0; rows * nv],
        k_lo: vec![1.0; rows * nv],
        k_hi: vec![2.0; rows * nv],
        kd: vec![0.5; rows * nv],
        contacts: Vec::new(),
        root_wrench: Vec::new(),
        com: Vec::new(),
        momentum: Vec::new(),
        link_com: Vec::new(),
        disturbed: dynamics::Disturbed::default(),
        energy: vec![0.0; rows * 2],
        plan: motion::ContactPlan::default(),
        colors: Vec::new(),
        wall_s: 12.3,
    };
    for row in 0..rows {
        let s = row as f64;
        let contact = Vec3::new((s * 0.9).sin() * 20.0, 60.0 + (s * 0.31).cos() * 30.0, s * 0.1);
        if row > 0 {
            let force = GRAVITY * mass + contact + root_force;
            for _ in 0..substeps {
                velocity += force / mass * h;
                x += velocity * h;
            }
            t.contacts.push(ContactSample {
                row,
                link: 1,
                against: Default::default(),
                point: x,
                force: contact,
                depth: 0.001,
            });
        }
        let mut q = character.skeleton.zero_pose();
        q[..3].copy_from_slice(x.as_slice());
        let mut v = vec![0.0; nv];
        v[..3].copy_from_slice(velocity.as_slice());
        t.target.extend_from_slice(&q);
        t.q.extend_from_slice(&q);
        t.v.extend_from_slice(&v);
        let wrench = if row > 0 { root_force } else { Vec3::zeros() };
        t.root_wrench.extend([wrench.x, wrench.y, wrench.z, 0.0, 0.0, 0.0]);
        let p = velocity * mass;
        t.com.extend_from_slice(x.as_slice());
        t.momentum.extend([p.x, p.y, p.z, 0.0, 0.0, 0.0]);
        // links about the common centre: 7·a + 2·b + 1·c = 0
        for offset in [Vec3::new(0.1, 0.0, 0.0), Vec3::new(-0.35, 0.3, 0.0), Vec3::new(0.0, -0.6, 0.0)] {
            t.link_com.extend_from_slice((x + offset).as_slice());
        }
    }
    assert_eq!(t.q.len(), rows * nq);
    t
}

fn bytes(trace: &Trace) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    trace_npz::write(trace, &mut out).unwrap();
    out.into_inner()
}

/// What is read back is what was written, to the bit, with names, shapes and text.
#[test]
fn npz_read_back_is_the_trace() {
    let trace = projectile(50, 2);
    let mut npz = ZipArchive::new(Cursor::new(bytes(&trace))).unwrap();
    let mut numbers = |name: &str| {
        let array = NpyFile::new(npz.by_name(&format!("{name}.npy")).unwrap()).unwrap();
        let shape = array.shape().to_vec();
        (shape, array.into_vec::<f64>().unwrap())
    };
    for (name, columns, data) in [
        ("q", 12, &trace.q),
        ("target", 12, &trace.target),
        ("v", 10, &trace.v),
        ("torque", 10, &trace.torque),
        ("k_lo", 10, &trace.k_lo),
        ("k_hi", 10, &trace.k_hi),
        ("kd", 10, &trace.kd),
        ("root_wrench", 6, &trace.root_wrench),
        ("com", 3, &trace.com),
        ("momentum", 6, &trace.momentum),
        ("link_com", 9, &trace.link_com),
        ("energy", 2, &trace.energy),
    ] {
        assert_eq!(numbers(name), (vec![50, columns], data.clone()), "{name}");
    }
    assert_eq!(numbers("rate_hz"), (vec![], vec![200.0]));
    assert!(numbers("ground_m").1[0].is_nan());
    assert_eq!(numbers("root_limit"), (vec![2], vec![10.0, 1.0]));
    assert_eq!(numbers("link_mass"), (vec![3], vec![7.0, 2.0, 1.0]));
    let forces: Vec<f64> = trace.contacts.iter().flat_map(|c| <[f64; 3]>::from(c.force)).collect();
    assert_eq!(numbers("contact_force"), (vec![49, 3], forces));

    let mut text = |name: &str| {
        NpyFile::new(npz.by_name(&format!("{name}.npy")).unwrap()).unwrap().into_vec::<String>().unwrap()
    };
    assert_eq!(text("link_name"), ["trunk", "arm", "tête"]);
    assert_eq!(text("joint_type"), ["free", "revolute", "spherical"]);
    assert_eq!(text("root_mode"), ["assisted"]);
    assert_eq!(
        text("dof_name"),
        [
            "trunk.tx", "trunk.ty", "trunk.tz", "trunk.rx", "trunk.ry", "trunk.rz", "arm", "tête.rx",
            "tête.ry", "tête.rz"
        ]
    );
    let units = text("units");
    let torque = units.iter().position(|u| u == "torque").unwrap();
    assert_eq!(units[torque + 1], "N·m");
    let rows = NpyFile::new(npz.by_name("contact_row.npy").unwrap()).unwrap().into_vec::<i64>().unwrap();
    assert_eq!(rows, (1..50).collect::<Vec<i64>>());
}

/// Every array with a unit exists, and every array of measured numbers has a unit.
#[test]
fn units_name_arrays() {
    let plain = projectile(5, 1);
    let mut disturbed = plain.clone();
    let what = bodies::Carried::solid_box(0, 1.0, Vec3::zeros(), Vec3::repeat(0.1));
    disturbed.disturbed = dynamics::Disturbed {
        ground_up: vec![Vec3::new(0.6, 0.8, 0.0)],
        wrench: vec![0.0; 30],
        carried: vec![dynamics::Handed { what, from_row: 0, to_row: 5 }],
        carried_com: vec![0.0; 15],
        root_correction: vec![0.0; 35],
        props: vec![bodies::Prop::upright("step", Vec3::x(), Vec3::new(1.0, 2.0, 3.0), 0.1, 0.8)],
    };
    let stands = motion::Contact { point: "arm".into(), from_s: 0.0, to_s: 0.1, world_from_point: None };
    disturbed.plan = motion::ContactPlan::new(vec![stands]).unwrap();
    [plain, disturbed].iter().for_each(units_name_arrays_of);
}

fn units_name_arrays_of(trace: &Trace) {
    let mut npz = ZipArchive::new(Cursor::new(bytes(trace))).unwrap();
    let names: Vec<String> =
        npz.file_names().map(|n| n.unwrap().trim_end_matches(".npy").to_owned()).collect();
    let units = NpyFile::new(npz.by_name("units.npy").unwrap()).unwrap().into_vec::<String>().unwrap();
    let listed: Vec<&String> = units.iter().step_by(2).collect();
    for name in &listed {
        assert!(names.contains(name), "{name} has a unit but no array");
    }
    let unitless = [
        "root_mode",
        "units",
        "contact_row",
        "contact_link",
        "contact_against",
        "plan_point",
        "prop_name",
        "carried_link",
        "carried_rows",
        "link_name",
        "joint_type",
        "link_parent",
        "joint_axis",
        "joint_q_at",
        "joint_v_at",
        "dof_name",
        "character_name",
        "joint_class",
        "limit_axes",
        "shape_link",
        "shape_type",
        "site_name",
        "site_link",
        "contact_site",
        "limb_name",
        "limb_kind",
        "limb_links",
        "part_name",
        "part_links",
    ];
    for name in names.iter().filter(|n| !unitless.contains(&n.as_str())) {
        assert!(listed.contains(&name), "{name} has no unit");
    }
}

/// Neither the time of writing nor the wall time of the run reaches the file.
#[test]
fn same_trace_same_bytes() {
    let a = projectile(20, 1);
    let mut b = a.clone();
    b.wall_s = 99.0;
    assert!(bytes(&a) == bytes(&b));
    b.torque[7] += 1e-15;
    assert!(bytes(&a) != bytes(&b));
}

/// A failed write leaves the earlier file whole and no temporary file behind.
#[test]
fn saving_replaces_at_once() {
    let directory = Path::new(env!("CARGO_TARGET_TMPDIR")).join("saving");
    std::fs::create_dir_all(&directory).unwrap();
    let path = directory.join("trace.npz");
    let trace = projectile(5, 1);
    trace_npz::save(&trace, &path).unwrap();
    assert_eq!(std::fs::read(&path).unwrap(), bytes(&trace));
    assert_eq!(std::fs::read_dir(&directory).unwrap().count(), 1);
    assert!(trace_npz::save(&trace, &directory.join("missing").join("trace.npz")).is_err());
}

/// What `tests/momentum_balance.py` says of a trace; `None` without Python.
fn balance(trace: &Trace, name: &str, arguments: &[&str]) -> Option<(i32, String)> {
    let mut python = support::python(name, &[])?;
    let path: PathBuf = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    trace_npz::save(trace, &path).unwrap();
    let script = support::root().join("tests/momentum_balance.py");
    let run = python.arg(script).arg(&path).args(arguments).output().unwrap();
    let text = String::from_utf8_lossy(&run.stdout).into_owned() + &String::from_utf8_lossy(&run.stderr);
    Some((run.status.code().unwrap(), text))
}

const STRICT: [&str; 6] = ["--max-rms", "1e-8", "--max-recorded-rms", "1e-10", "--max-mean", "1e-10"];

/// The script finds nothing where nothing is missing: RMS residual 2e-10 % of weight seen by positions,
/// 1e-12 % recorded, all of it rounding.
#[test]
fn balanced_trace_passes() {
    for substeps in [1, 2, 5] {
        let trace = projectile(300, substeps);
        let Some((code, text)) = balance(&trace, &format!("balanced{substeps}.npz"), &STRICT) else { return };
        assert_eq!(code, 0, "{text}");
    }
}

/// Negative controls: a hidden force, a wrong mass, a forged momentum and a lost contact must fail.
#[test]
fn unbalanced_trace_fails() {
    let good = projectile(300, 2);
    let mut hidden = good.clone();
    hidden.root_wrench.iter_mut().for_each(|x| *x = 0.0);
    let mut lost = good.clone();
    lost.contacts.remove(150);
    let mut heavy = good.clone();
    Arc::make_mut(&mut heavy.character).bodies[0].mass = 7.5;
    let mut forged = good.clone();
    forged.momentum[6 * 100] += 0.01;
    for (name, trace) in [("hidden", hidden), ("lost", lost), ("heavy", heavy), ("forged", forged)] {
        let Some((code, text)) = balance(&trace, &format!("{name}.npz"), &STRICT) else { return };
        assert_eq!(code, 1, "{name}: {text}");
        assert!(text.contains("FAILED"), "{name}: {text}");
    }
}

/// A still end under exactly body weight is 100 %; the JSON is an object with the same numbers.
#[test]
fn still_end_is_weighed() {
    let mut trace = projectile(100, 1);
    for c in &mut trace.contacts {
        c.force = -GRAVITY * 10.0;
    }
    let arguments = ["--still", "0.2", "--max-weight-error", "0.5", "--json"];
    let Some((code, text)) = balance(&trace, "still.npz", &arguments) else { return };
    assert_eq!(code, 0, "{text}");
    let (_, tail) = text.split_once("\"vertical_mean_percent\": ").unwrap();
    let percent: f64 = tail.split(['\n', ',']).next().unwrap().trim().parse().unwrap();
    assert!((percent - 100.0).abs() < 1e-9, "{percent}"); // 7e-14 seen
    trace.contacts.iter_mut().for_each(|c| c.force.y *= 0.99);
    let (code, text) = balance(&trace, "light.npz", &arguments).unwrap();
    assert_eq!(code, 1, "{text}");
}

/// A file that is no trace is said so, with exit code 2.
#[test]
fn nonsense_is_refused() {
    let mut trace = projectile(10, 1);
    trace.link_com.clear();
    let Some((code, text)) = balance(&trace, "nolinks.npz", &[]) else { return };
    assert_eq!(code, 2, "{text}");
    assert!(text.contains("link_com"), "{text}");
}
