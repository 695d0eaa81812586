//! Files that are too large are refused at once, and work grows with the input, not with its square.

use std::path::Path;

use formats::limits::{ATTRIBUTES, BODIES, ELEMENTS, INCLUDES};
use formats::model::{ImportOptions, open};

const OPTIONS: ImportOptions = ImportOptions { dynamics_only: true };

fn read(folder: &Path, name: &str, text: &str) -> Result<usize, String> {
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    open(&path, &OPTIONS).map(|m| m.joints.len()).map_err(|e| e.to_string())
}

fn said(folder: &Path, name: &str, text: &str) -> String {
    let message = read(folder, name, text).unwrap_err();
    message.lines().next().unwrap().to_owned()
}

fn world(inside: &str) -> String {
    format!("<mujoco><worldbody>{inside}</worldbody></mujoco>")
}

/// `n` hinges in chains of at most 300, each of another axis.
fn hinges(n: usize) -> String {
    let mut text = String::new();
    let mut left = n;
    while left > 0 {
        let length = left.min(300);
        for k in 0..length {
            text += &format!(
                "<body pos=\"0.1 0 0\"><joint axis=\"{} 1 0\"/><geom size=\"0.05\" pos=\"0 0.1 {}\"/>",
                k % 7,
                k % 3
            );
        }
        text += &"</body>".repeat(length);
        left -= length;
    }
    world(&text)
}

/// A robot that is one chain of `n` hinges.
fn chain(n: usize) -> String {
    let mut text = "<robot name=\"r\"><link name=\"l0\"/>\n".to_owned();
    for k in 1..=n {
        text += &format!(
            "<link name=\"l{k}\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\"/></inertial></link><joint name=\"j{k}\" type=\"continuous\"><parent link=\"l{}\"/><child link=\"l{k}\"/><axis xyz=\"{} 1 0\"/></joint>\n",
            k - 1,
            k % 5
        );
    }
    text + "</robot>"
}

/// `n` classes, `n` sites and `n` geoms of them in one body, all in one line.
fn wide(n: usize) -> String {
    let classes: String =
        (0..n).map(|k| format!("<default class=\"c{k}\"><geom size=\"0.1\"/></default>")).collect();
    let parts: String =
        (0..n).map(|k| format!("<site name=\"s{k}\"/><geom name=\"g{k}\" class=\"c{k}\"/>")).collect();
    format!("<mujoco><default>{classes}</default>{}", &world(&format!("<body><joint/>{parts}</body>"))[8..])
}

/// A chain of `n` files with some elements each.
fn includes(folder: &Path, n: usize) {
    for k in 0..n {
        let next = if k + 1 < n { format!("<include file=\"i{}.xml\"/>", k + 1) } else { String::new() };
        let body = format!("<body pos=\"{k} 0 0\"><joint/><geom size=\"0.1\"/></body>").repeat(5);
        let text = world(&body).replace("</mujoco>", &format!("{next}</mujoco>"));
        std::fs::write(folder.join(format!("i{k}.xml")), text).unwrap();
    }
}

#[test]
fn too_much_is_refused_with_the_limit() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let bodies = "<body><joint/><geom size=\"1\"/></body>".repeat(BODIES / 2);
    assert_eq!(said(at, "m.xml", &world(&bodies)), format!("more than {BODIES} bodies and joints"));
    assert_eq!(said(at, "r.urdf", &chain(BODIES / 2)), format!("more than {BODIES} bodies and joints"));
    let elements = world(&"<light/>".repeat(ELEMENTS));
    assert_eq!(said(at, "m.xml", &elements), format!("more than {ELEMENTS} elements"));
    let attributes: String = (0..=ATTRIBUTES).map(|k| format!("a{k}=\"\" ")).collect();
    assert_eq!(
        said(at, "m.xml", &world(&format!("<body {attributes}/>"))),
        format!("more than {ATTRIBUTES} attributes of an element")
    );
    includes(at, INCLUDES + 1);
    let message = open(&at.join("i0.xml"), &OPTIONS).unwrap_err().to_string();
    assert!(message.starts_with(&format!("more than {INCLUDES} included files")), "{message}");
    includes(at, INCLUDES - 1);
    assert_eq!(open(&at.join("i0.xml"), &OPTIONS).map(|m| m.joints.len()).unwrap(), 5 * (INCLUDES - 1));
}

/// A body whose inertia is larger than any number of a file could not be written: it is refused where it is read, and one below
/// the limit comes back. Found by fuzzing.
#[test]
fn bodies_that_no_file_can_hold_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let puck = |size: f64| {
        let joint = "<joint type=\"slide\" axis=\"1 0 0\" armature=\"0.5\"/>";
        world(&format!("<body name=\"puck\">{joint}<geom type=\"sphere\" size=\"{size}\"/></body>"))
    };
    // 0.4 m r² three times, of 1000 kg/m³: 8.4e12 kg·m² at 70 m, 5.3e11 at 40 m
    let message = said(at, "m.xml", &puck(70.0));
    assert!(message.starts_with("mass or inertia of body `puck` is 8.4"), "{message}");
    assert!(message.ends_with("it must be at most 1e12"), "{message}");
    std::fs::write(at.join("m.xml"), puck(40.0)).unwrap();
    let body = open(&at.join("m.xml"), &OPTIONS).unwrap().character;
    let written = formats::mjcf::write(&body, &Default::default()).unwrap();
    std::fs::write(at.join("again.xml"), written.text).unwrap();
    let again = open(&at.join("again.xml"), &OPTIONS).unwrap().character;
    assert_eq!(again.bodies.len(), body.bodies.len());
}

/// Endless devices and pipes have no end to wait for.
#[cfg(unix)]
#[test]
fn devices_and_pipes_are_refused_under_any_name() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["m.xml", "r.urdf"] {
        let path = folder.path().join(name);
        std::os::unix::fs::symlink("/dev/zero", &path).unwrap();
        let message = open(&path, &OPTIONS).unwrap_err().to_string();
        assert!(message.ends_with("it is a device, pipe or socket, not a regular file"), "{message}");
    }
    let clip = folder.path().join("c.bvh");
    std::os::unix::fs::symlink("/dev/zero", &clip).unwrap();
    let message = formats::open_clip(&clip, &Default::default()).unwrap_err().to_string();
    assert!(message.ends_with("it is a device, pipe or socket, not a regular file"), "{message}");
}

/// Processor time of this thread, s: what other processes do does not count.
fn processor_s() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap();
    text.split(' ').next().unwrap().parse::<f64>().unwrap() * 1e-9
}

/// The least of three, each of so many runs that the steps in which the system counts are small against it.
fn cost(mut work: impl FnMut()) -> f64 {
    let mut once = || {
        let start = processor_s();
        (0..8).for_each(|_| work());
        processor_s() - start
    };
    (0..3).map(|_| once()).fold(f64::INFINITY, f64::min)
}

/// One input eight times as large takes about the work of eight small ones, and some more where it leaves the caches; with the
/// square of the input it would take eight times as much.
#[cfg(target_os = "linux")]
#[test]
fn slow_work_grows_with_the_input() {
    let folder = tempfile::tempdir().unwrap();
    let check = |what: &str, work: &dyn Fn(usize), n: usize| {
        let small = cost(|| (0..8).for_each(|_| work(n)));
        let large = cost(|| work(8 * n));
        let ratio = large / small;
        println!("{what}: {small:.4} s, {large:.4} s, ratio {ratio:.2}");
        assert!(small > 0.02, "{what}: {small} s is too little to be measured");
        assert!(ratio < 3.0, "{what}: one for eight took {ratio:.1} times the work ({small} s, {large} s)");
    };
    type Make = fn(usize) -> String;
    let files: [(&str, &str, Make, usize); 3] = [
        ("hinges", "m.xml", hinges, 600),
        ("a chain", "r.urdf", chain, 600),
        ("one line", "m.xml", wide, 2000),
    ];
    for (what, name, make, n) in files {
        let texts = [n, 8 * n].map(|n| (n, make(n)));
        let work = |n: usize| {
            let (_, text) = texts.iter().find(|(m, _)| *m == n).unwrap();
            read(folder.path(), name, text).unwrap();
        };
        check(what, &work, n);
    }
    includes(folder.path(), 800);
    let start = |n: usize| {
        let path = folder.path().join(format!("i{}.xml", 800 - n));
        assert_eq!(open(&path, &OPTIONS).map(|m| m.joints.len()).unwrap(), 5 * n);
    };
    check("includes", &start, 100);
}
