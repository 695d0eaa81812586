//! Processes that are interrupted and killed while they render: old results or new ones, never mixed, and nothing left behind.
#![cfg(unix)]

use std::collections::BTreeMap;
use std::hash::{BuildHasher, RandomState};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use takes::results::folder::Folder;
use takes::results::folder::manifest::MANIFEST;

use crate::place::Place;

/// Files of a folder by name, without what the clock says.
type Files = BTreeMap<String, Vec<u8>>;

fn files(place: &Place, folder: &str) -> Files {
    let clockless = |(name, bytes): (String, Vec<u8>)| {
        if !name.ends_with("report.json") && name != MANIFEST {
            return (name, bytes);
        }
        let text = String::from_utf8(bytes).unwrap();
        // the report names the wall time; the manifest has the report's digest
        let line =
            |l: &&str| !l.contains("realtime_factor") && !l.contains("fnv1a64") && !l.contains("bytes");
        (name, text.lines().filter(line).collect::<String>().into_bytes())
    };
    place.files(folder).into_iter().map(clockless).collect()
}

fn render(place: &Place, scene: &str, out: &str) -> Child {
    Command::new(env!("CARGO_BIN_EXE_contrapposto"))
        .args(["render", scene, "--out", out])
        .current_dir(place.at(""))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap()
}

fn send(child: &Child, signal: &str) {
    assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
}

/// The folder has all files of one of two runs, or those of one before its figures were drawn; which of them.
#[track_caller]
fn one_run(place: &Place, runs: &[&Files; 2]) -> usize {
    let found = files(place, "out");
    let same = |run: &Files, name: &String, bytes: &Vec<u8>| {
        // what is written before the figures does not name them
        name == MANIFEST || name.ends_with("report.json") || run.get(name) == Some(bytes)
    };
    let figures = |f: &Files| f.keys().filter(|n| n.starts_with("plots/")).count();
    let of = |run: &&Files| {
        let whole = found == **run;
        let data = figures(&found) == 0 && found.len() + figures(run) == run.len();
        whole || data && found.iter().all(|(name, bytes)| same(run, name, bytes))
    };
    runs.iter().position(of).unwrap_or_else(|| panic!("a mixture: {:?}", found.keys().collect::<Vec<_>>()))
}

/// 24 signals at random times during `render` over the results of another scene.
#[test]
fn slow_signals_during_render_leave_one_run_and_nothing_else() {
    let place = Place::new();
    let other = place.scene("rate_hz: 60", "rate_hz: 50");
    std::fs::rename(other, place.at("b.ron")).unwrap();
    place.scene("", "");
    std::fs::rename(place.at("scene.ron"), place.at("a.ron")).unwrap();
    let mut runs = Vec::new();
    let mut longest = Duration::ZERO;
    for scene in ["a.ron", "b.ron"] {
        let started = Instant::now();
        assert!(render(&place, scene, "out").wait().unwrap().success());
        longest = longest.max(started.elapsed());
        runs.push(files(&place, "out"));
    }
    assert_ne!(runs[0], runs[1]);
    let runs = [&runs[0], &runs[1]];
    let beside = || -> Vec<String> {
        let names = std::fs::read_dir(place.at("")).unwrap().map(|e| e.unwrap().file_name());
        names.map(|n| n.into_string().unwrap()).filter(|n| n.starts_with('.')).collect()
    };
    let (mut ended, mut seen) = (Vec::new(), [0, 0]);
    for round in 0..24 {
        let scene = ["a.ron", "b.ron"][round % 2];
        let mut child = render(&place, scene, "out");
        let random = RandomState::new().hash_one(Instant::now()) % 1000;
        std::thread::sleep(longest.mul_f64(random as f64 / 900.0));
        let signal = if round % 3 == 2 { "-KILL" } else { "-INT" };
        send(&child, signal);
        let sent = Instant::now();
        let status = child.wait().unwrap();
        if signal == "-INT" {
            assert!(matches!(status.code(), Some(0 | 130)), "{status}");
            ended.push(sent.elapsed());
            assert!(!Folder::recover(&place.at("out")).unwrap(), "an interrupted run needs no recovery");
            assert_eq!(beside(), Vec::<String>::new(), "round {round}");
        } else {
            Folder::recover(&place.at("out")).unwrap();
        }
        // what a killed process left is no output: hidden, and cleared by the next run
        let found: Vec<String> = place.files("out").into_iter().map(|(name, _)| name).collect();
        let left = found.iter().filter(|n| n.starts_with(".contrapposto-")).count();
        assert!(left == 0 || signal == "-KILL", "{found:?}");
        if left > 0 {
            let plan = takes::results::folder::Plan { command: "test", ..Default::default() };
            Folder::check(&place.at("out"), &plan).unwrap();
        }
        seen[one_run(&place, &runs)] += 1;
    }
    ended.sort();
    println!("ended after {:?} (median), {:?} (most); {seen:?}", ended[8], ended[15]);
    assert!(ended[8] < Duration::from_millis(500), "{ended:?}");
    assert!(seen[0] > 0 && seen[1] > 0, "no run was complete, or none was interrupted: {seen:?}");
    assert!(render(&place, "a.ron", "out").wait().unwrap().success());
    assert_eq!((files(&place, "out"), beside()), (runs[0].clone(), Vec::new()));
}

/// Making MuJoCo's Python environment, which takes minutes, leaves nothing in the cache; `venv` is played by a script.
#[test]
fn an_interrupted_environment_leaves_nothing_in_the_cache() {
    use std::os::unix::fs::PermissionsExt;
    let place = Place::new();
    let python =
        "#!/bin/sh\n[ \"$2\" = venv ] || exit 0\nmkdir -p \"$3/bin\"\ntouch \"$3/half\"\nexec sleep 5\n";
    let python = place.write("python", python);
    std::fs::set_permissions(&python, std::fs::Permissions::from_mode(0o755)).unwrap();
    place.write("cache/notes.txt", "mine");
    let mut child = Command::new(env!("CARGO_BIN_EXE_contrapposto"))
        .args(["crosscheck", support::scene("characters/human.ron").to_str().unwrap(), "--states-only"])
        .current_dir(place.at(""))
        .envs([("CONTRAPPOSTO_PYTHON", python.to_str().unwrap()), ("CONTRAPPOSTO_CACHE", "cache")])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let begun = Instant::now();
    let made = || place.files("cache").iter().any(|(name, _)| name.ends_with("half"));
    while !made() && begun.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(5));
    }
    assert!(made(), "no environment was begun");
    send(&child, "-INT");
    let sent = Instant::now();
    let status = child.wait().unwrap();
    assert_eq!(status.code(), Some(130), "{status}");
    assert!(sent.elapsed() < Duration::from_secs(2), "{:?}", sent.elapsed()); // 0.02 s seen on an idle machine
    let left: Vec<String> = place.files("cache").into_iter().map(|(name, _)| name).collect();
    assert_eq!(left, ["notes.txt"]);
}

/// An output folder that does not exist yet: after Ctrl-C there is none, and none of the folders made on the way to it.
#[test]
fn an_interrupted_first_run_leaves_no_folder() {
    let place = Place::new();
    let scene = place.scene("settle_s: 0.2", "settle_s: 200");
    let before = place.files("");
    let mut child = render(&place, scene.to_str().unwrap(), "deep/er/out");
    std::thread::sleep(Duration::from_millis(700));
    send(&child, "-INT");
    let status = child.wait().unwrap();
    assert_eq!(status.code(), Some(130), "{status}");
    assert!(place.files("") == before && !place.at("deep").exists());
}
