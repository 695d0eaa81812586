//! Traces read back from `.npz`: the same to the bit, and no file so broken that reading it crashes.

use std::collections::BTreeMap;
use std::io::{Cursor, Read, Write};
use std::sync::Arc;

use bodies::Carried;
use bodies::Prop;
use bodies::anthropometry::human::human;
use dynamics::{Against, ContactSample, Disturbed, Handed, RootMode, Trace};
use formats::TraceFileError;
use formats::trace_npz;
use motion::{Contact, ContactPlan, Joint, Quat, Range, Shape, Transform, Vec3};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

/// Tilted ground, a push, and a crate for three rows.
fn disturbed(rows: usize) -> Disturbed {
    let what = Carried::solid_box(7, 5.0, Vec3::new(0.1, -0.2, 0.3), Vec3::new(0.3, 0.2, 0.1));
    let numbers = |n: usize| (0..n * rows).map(|i| (i as f64).cos()).collect();
    Disturbed {
        ground_up: (0..rows).map(|i| Vec3::new(0.1 * (i as f64).sin(), 1.0, 0.0).normalize()).collect(),
        wrench: numbers(6),
        carried: vec![Handed { what, from_row: 1, to_row: 4 }],
        carried_com: numbers(3),
        root_correction: numbers(7),
        props: vec![
            Prop::upright("step", Vec3::new(0.1, 0.2, 0.3), Vec3::new(0.4, 0.5, 0.6), 0.7, 0.8),
            Prop::ramp("Rampe", Vec3::x(), (2.0, 1.0, 0.1), (0.3, -0.4), 0.5),
        ],
    }
}

/// A trace of the standard human whose numbers are all different, with every kind of shape and limit.
fn sample(rows: usize) -> Trace {
    let mut character = human().0;
    character.name = "Ōtzi".into();
    let rotation = motion::rotation::exp(&Vec3::new(0.1, -0.4, 0.2));
    let (center, half) = (Vec3::new(0.01, 0.02, 0.03), Vec3::new(0.1, 0.2, 0.3));
    character.bodies[1].shapes.push(Shape::Box { center, half, rotation });
    character.bodies[2].shapes.push(Shape::Sphere { center, radius: 0.07 });
    let skeleton = character.skeleton.clone();
    let (nq, nv, links) = (skeleton.nq(), skeleton.nv(), skeleton.links().len());
    let mut count = 0.0;
    let mut numbers = |n: usize| -> Vec<f64> {
        (0..n)
            .map(|_| {
                count += 1.0;
                f64::sin(count) * 3.0
            })
            .collect()
    };
    let mut trace = Trace {
        rate_hz: 240.0,
        substeps: 3,
        root: RootMode::Assisted { force_n: 73.5, moment_nm: 50.0 },
        ground_m: Some(-0.125),
        gravity: Vec3::new(0.1, -9.81, 0.0),
        q: numbers(rows * nq),
        v: numbers(rows * nv),
        target: numbers(rows * nq),
        torque: numbers(rows * nv),
        stop_torque: numbers(rows * nv),
        k_lo: numbers(rows * nv),
        k_hi: numbers(rows * nv),
        kd: numbers(rows * nv),
        contacts: Vec::new(),
        root_wrench: numbers(rows * 6),
        com: numbers(rows * 3),
        momentum: numbers(rows * 6),
        link_com: numbers(rows * 3 * links),
        disturbed: disturbed(rows),
        energy: numbers(rows * 2),
        plan: ContactPlan::new(vec![
            Contact { point: "leg_l".into(), from_s: 0.0, to_s: 0.5, world_from_point: None },
            Contact {
                point: "leg_r".into(),
                from_s: 0.25,
                to_s: 0.75,
                world_from_point: Some(Transform::from_parts(
                    Vec3::new(0.1, -0.02, 0.3).into(),
                    Quat::from_euler_angles(0.1, 0.7, -0.2),
                )),
            },
        ])
        .unwrap(),
        colors: vec![None, Some([0, 128, 255])].into_iter().cycle().take(links).collect(),
        wall_s: 0.0,
        character: Arc::new(character),
    };
    for row in 1..rows {
        for link in [2, 5] {
            let n = numbers(7);
            let (point, force) = (Vec3::new(n[0], n[1], n[2]), Vec3::new(n[3], n[4], n[5]));
            let against = [Against::Link(5), Against::Prop(1), Against::Ground][row % 3];
            trace.contacts.push(ContactSample { row, link, against, point, force, depth: n[6] });
        }
    }
    trace
}

fn bytes(trace: &Trace) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    trace_npz::write(trace, &mut out).unwrap();
    out.into_inner()
}

fn read(bytes: &[u8]) -> Result<Trace, TraceFileError> {
    trace_npz::read(Cursor::new(bytes))
}

/// Everything a trace has, body included, but the wall time.
#[test]
fn what_is_read_is_what_was_written() {
    for root in [RootMode::Free, RootMode::Pinned, sample(1).root] {
        let mut trace = sample(5);
        trace.root = root;
        assert_eq!(read(&bytes(&trace)).unwrap(), trace);
    }
    let mut bare = sample(1);
    bare.ground_m = None;
    bare.link_com.clear();
    bare.disturbed = Disturbed::default();
    bare.wall_s = 3.0;
    let back = read(&bytes(&bare)).unwrap();
    assert_eq!(back.wall_s, 0.0);
    bare.wall_s = 0.0;
    assert_eq!(back, bare);
    assert_eq!(bytes(&back), bytes(&bare));
}

/// Limits of hinges, slides, balls, and of none; the human has no slide and no unlimited joint.
#[test]
fn limits_and_joints_of_every_kind() {
    let mut trace = sample(1);
    let character = Arc::make_mut(&mut trace.character);
    let mut links = character.skeleton.links().to_vec();
    let last = links.len() - 1;
    links[last].joint = Joint::Prismatic(Vec3::z());
    links[last].limits = Some(motion::Limits::Axis(Range::new(-0.1, 0.2)));
    links[last].end = Some(Vec3::new(0.0, 0.1, 0.0));
    links[last - 1].limits = None;
    let skeleton = motion::Skeleton::new(links).unwrap();
    let (nq, nv) = (skeleton.nq(), skeleton.nv());
    character.rest = skeleton.zero_pose();
    character.contacts.clear();
    character.skeleton = Arc::new(skeleton);
    for (data, n) in
        [(&mut trace.q, nq), (&mut trace.target, nq), (&mut trace.v, nv), (&mut trace.torque, nv)]
    {
        data.resize(n, 0.5);
    }
    for data in [&mut trace.stop_torque, &mut trace.k_lo, &mut trace.k_hi, &mut trace.kd] {
        data.resize(nv, 0.25);
    }
    assert_eq!(read(&bytes(&trace)).unwrap(), trace);
}

/// A run that diverged has NaN in its last rows; its trace can still be looked at.
#[test]
fn rows_may_hold_nan() {
    let mut trace = sample(4);
    let n = trace.q.len();
    trace.q[n - 3] = f64::NAN;
    trace.momentum[7] = f64::INFINITY;
    let back = read(&bytes(&trace)).unwrap();
    assert!(back.q[n - 3].is_nan() && back.momentum[7] == f64::INFINITY);
}

/// The arrays of a file, changed by `change` and zipped again.
fn changed(change: impl FnOnce(&mut BTreeMap<String, Vec<u8>>)) -> Vec<u8> {
    let mut archive = ZipArchive::new(Cursor::new(bytes(&sample(3)))).unwrap();
    let mut arrays = BTreeMap::new();
    for i in 0..archive.len() {
        let mut entry = archive.by_index(i).unwrap();
        let mut data = Vec::new();
        entry.read_to_end(&mut data).unwrap();
        arrays.insert(entry.name().unwrap().into_owned(), data);
    }
    change(&mut arrays);
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, data) in &arrays {
        let stored = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
        zip.start_file(name.as_str(), stored).unwrap();
        zip.write_all(data).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

#[track_caller]
fn refused(file: &[u8], words: &[&str]) {
    let text = match read(file) {
        Ok(_) => panic!("accepted; expected {words:?}"),
        Err(e) => e.to_string(),
    };
    for word in words {
        assert!(text.contains(word), "`{word}` is not in: {text}");
    }
}

/// An array of `f8` numbers in one dimension.
fn npy(descr: &str, shape: &str, body: &[u8]) -> Vec<u8> {
    let header = format!("{{'descr': {descr}, 'fortran_order': False, 'shape': {shape}, }}\n");
    let mut out = b"\x93NUMPY\x01\x00".to_vec();
    out.extend((header.len() as u16).to_le_bytes());
    out.extend(header.as_bytes());
    out.extend(body);
    out
}

/// What was found, what is allowed, in which array.
#[test]
fn bad_files_are_told_apart() {
    refused(b"", &["zip of .npy arrays"]);
    refused(b"HIERARCHY\nROOT Hips\n", &["zip of .npy arrays"]);
    refused(&changed(|a| drop(a.remove("torque.npy"))), &["`torque` is missing", "contrapposto render"]);
    refused(&changed(|a| a.clear()), &["`link_name` is missing"]);
    let set = |name: &str, data: Vec<u8>| {
        let name = format!("{name}.npy");
        changed(move |a| drop(a.insert(name, data)))
    };
    let f8 = |x: f64| x.to_le_bytes().to_vec();
    refused(&set("rate_hz", npy("'<f8'", "()", &f8(-1.0))), &["`rate_hz`", "-1 Hz", "1e6 Hz"]);
    refused(&set("rate_hz", npy("'<f8'", "(1,)", &f8(60.0))), &["`rate_hz`", "[1]", "allowed: []"]);
    refused(&set("com", npy("'<f8'", "(1, 1)", &f8(1.0))), &["`com` has shape [1, 1]", "[3, 3]"]);
    refused(&set("com", npy("'<f8'", "(3, 3)", &f8(1.0))), &["`com`", "needs 72 bytes", "there are 8"]);
    refused(&set("com", npy("'<c16'", "(3, 3)", &[])), &["`com`", "<c16", "<f8"]);
    refused(&set("com", npy("[('a', '<f8')]", "(3, 3)", &[])), &["`com`", "records"]);
    refused(&set("com", npy("'<f8'", "(4611686018427387904, 4)", &[])), &["`com`", "more bytes"]);
    refused(&set("com", npy("'<f8'", "(x,)", &[])), &["`com`", "length `x`"]);
    refused(&set("com", b"PK".to_vec()), &["`com`", "not a .npy"]);
    refused(&set("com", b"\x93NUMPY\x01\x00\xff".to_vec()), &["`com`", "ends inside its header"]);
    refused(&set("contact_row", npy("'<i8'", "(1,)", &7i64.to_le_bytes())), &["contact_row", "less than 3"]);
    refused(&set("link_parent", npy("'<f8'", "(1,)", &f8(0.0))), &["link_parent", "shape [1]"]);
    refused(&set("character_name", npy("'<U1'", "()", &[0xff; 4])), &["character_name", "invalid code"]);
    refused(&set("character_name", npy("'<U99999999999999999999'", "()", &[])), &["character_name", "type"]);
    refused(&set("root_mode", npy("'<U1'", "()", &65u32.to_le_bytes())), &["`A`", "free, assisted, pinned"]);
    refused(&set("joint_class", npy("'<i8'", "()", &[0; 8])), &["joint_class", "shape []"]);
}

/// What numpy writes when it saves the arrays again has another header, and means the same.
#[test]
fn headers_of_other_writers() {
    let expected = sample(3);
    for header in [
        "{'shape': (), 'fortran_order': False, 'descr': '<f8'}",
        "{'descr': '<f8', 'fortran_order': True, 'shape': (), }      ",
    ] {
        let file = changed(|a| {
            let mut data = b"\x93NUMPY\x02\x00".to_vec();
            data.extend((header.len() as u32).to_le_bytes());
            data.extend(header.as_bytes());
            data.extend(240f64.to_le_bytes());
            a.insert("rate_hz.npy".into(), data);
        });
        assert_eq!(read(&file).unwrap(), expected);
    }
}

/// Flipped, cut and overwritten bytes: an error, or a trace that holds what its types promise.
#[test]
fn damage_never_crashes() {
    let whole = bytes(&sample(2));
    let mut seed = 1u64;
    let mut random = |n: usize| {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (seed >> 33) as usize % n
    };
    let (mut read_well, mut refused) = (0, 0);
    for round in 0..3000 {
        let mut file = whole.clone();
        match round % 3 {
            0 => file.truncate(random(file.len())),
            1 => (0..1 + random(4)).for_each(|_| {
                let at = random(file.len());
                file[at] ^= 1 << random(8);
            }),
            _ => {
                // the directory of the zip, where sizes and places are
                let at = file.len() - 1 - random(file.len() / 8);
                file[at] = random(256) as u8;
            }
        }
        match read(&file) {
            Ok(trace) => {
                assert_eq!(trace.rows() * trace.character.skeleton.nq(), trace.q.len());
                read_well += 1;
            }
            Err(e) => {
                assert!(e.to_string().len() < 600, "{e}");
                refused += 1;
            }
        }
    }
    // bytes that nothing depends on exist: dates, attributes
    assert!(refused > 2000 && read_well > 0, "{refused} refused, {read_well} read");
}

/// Damage that the checksums do not see, because the arrays are zipped anew.
#[test]
fn damaged_arrays_never_crash() {
    let mut seed = 7u64;
    let (mut whole, mut refused) = (0, 0);
    for _ in 0..400 {
        let mut random = |n: usize| {
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (seed >> 33) as usize % n
        };
        let file = changed(|arrays| {
            let names: Vec<String> = arrays.keys().cloned().collect();
            for _ in 0..3 {
                let data = arrays.get_mut(&names[random(names.len())]).unwrap();
                if !data.is_empty() {
                    let at = random(data.len());
                    data[at] = random(256) as u8;
                }
            }
        });
        if read(&file).is_ok() { whole += 1 } else { refused += 1 }
    }
    // a changed number is a number, a changed header is refused
    assert!(whole > 20 && refused > 20, "{whole} read, {refused} refused");
}
