//! Output folders under processes that are interrupted, killed, or write at the same time.
//!
//! The child processes are this program with the name of an ignored test (`child`); `FOLDER_CHILD` tells what to do.
#![cfg(unix)]

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::hash::{BuildHasher, RandomState};
use std::io::{BufRead, BufReader};
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use takes::results::folder::interrupt::{self, Temporary};
use takes::results::folder::manifest::{MANIFEST, Manifest};
use takes::results::folder::{Folder, FolderError, Overwrite, Plan, write_file};
use tempfile::TempDir;

const FILES: usize = 20;

/// Writes one generation in two commits; odd generations have an additional file.
fn generation(dir: &Path, text: &str, odd: bool) -> Result<(), FolderError> {
    let mut folder = Folder::begin(dir, &Plan { command: "child", ..Plan::default() })?;
    for k in 0..FILES - 1 {
        let folder_name = ["", "plots/", "span_1/plots/"][k % 3];
        folder.write(&format!("{folder_name}{k}"), text.as_bytes())?;
    }
    if odd {
        folder.write("odd/file", text.as_bytes())?;
    }
    folder.commit()?;
    folder.write("report.json", text.as_bytes())?;
    folder.commit()
}

#[test]
#[ignore = "a child process of the tests beside it, which set FOLDER_CHILD"]
fn child() {
    let Ok(task) = std::env::var("FOLDER_CHILD") else { return };
    let dir = PathBuf::from(std::env::var("FOLDER_DIR").unwrap());
    interrupt::install().unwrap();
    println!("\nready");
    let me = std::process::id();
    match task.as_str() {
        "generations" => {
            (0..u64::MAX).for_each(|g| generation(&dir, &format!("{me} {g}"), g % 2 == 1).unwrap())
        }
        "files" => loop {
            write_file(&dir.join("file"), &vec![b'x'; 1 << 20], Overwrite::Allow, &[]).unwrap();
        },
        "rounds" => (0..15).for_each(|g| match generation(&dir, &format!("{me} {g}"), g % 2 == 1) {
            Ok(()) | Err(FolderError::Overtaken { .. }) => {}
            Err(e) => panic!("{e}"),
        }),
        "hold" => {
            let mut folder = Folder::begin(&dir, &Plan::default()).unwrap();
            folder.write("half", b"").unwrap();
            println!("\nheld");
            std::thread::sleep(Duration::from_secs(600));
        }
        // a path below a file can never be removed: cleaning up does not come to an end
        "stuck" => {
            fs::write(dir.join("file"), "").unwrap();
            let _stuck = Temporary::new(dir.join("file/below"));
            println!("\nheld");
            std::thread::sleep(Duration::from_secs(600));
        }
        task => panic!("unknown task {task}"),
    }
}

struct Running(Child, BufReader<ChildStdout>);

impl Running {
    fn start(task: &str, dir: &Path) -> Self {
        let mut child = Command::new(std::env::current_exe().unwrap())
            .args(["--ignored", "--exact", "child", "--nocapture"])
            .env("FOLDER_CHILD", task)
            .env("FOLDER_DIR", dir)
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let lines = BufReader::new(child.stdout.take().unwrap());
        let mut running = Self(child, lines);
        running.wait_for("ready");
        running
    }

    fn wait_for(&mut self, word: &str) {
        let mut line = String::new();
        while line.trim() != word {
            line.clear();
            assert!(self.1.read_line(&mut line).unwrap() > 0, "the child ended before `{word}`");
        }
    }

    fn send(&self, signal: &str) {
        assert!(Command::new("kill").args([signal, &self.0.id().to_string()]).status().unwrap().success());
    }

    /// Its status, and how long it took to end.
    fn end(&mut self) -> (ExitStatus, Duration) {
        let started = Instant::now();
        (self.0.wait().unwrap(), started.elapsed())
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A folder in memory where there is one: on a disk nearly all time goes into synchronising, and few signals would hit a move.
fn home() -> TempDir {
    tempfile::tempdir_in("/dev/shm").or_else(|_| tempfile::tempdir()).unwrap()
}

fn random_pause(most_ms: u64) {
    let random = RandomState::new().hash_one(Instant::now());
    std::thread::sleep(Duration::from_micros(random % (most_ms * 1000)));
}

/// Contents of all files in a folder by name, hidden ones and empty folders (with `/`) too.
fn listing(dir: &Path) -> BTreeMap<String, String> {
    let mut found = BTreeMap::new();
    let mut folders = vec![dir.to_owned()];
    while let Some(folder) = folders.pop() {
        for path in fs::read_dir(&folder).unwrap().map(|e| e.unwrap().path()) {
            let name = path.strip_prefix(dir).unwrap().display().to_string();
            if !path.is_dir() {
                found.insert(name, fs::read_to_string(path).unwrap());
            } else if fs::read_dir(&path).unwrap().next().is_none() {
                found.insert(name + "/", String::new());
            } else {
                folders.push(path);
            }
        }
    }
    found
}

/// One generation in all files, as the manifest says, and nothing else; whether with the report.
#[track_caller]
fn assert_one_generation(home: &Path) -> bool {
    let mut files = listing(home);
    files.remove(&format!("out/{MANIFEST}")).unwrap();
    let (manifest, _) = Manifest::read(&home.join("out")).unwrap().unwrap();
    let names: Vec<String> = manifest.files.keys().map(|name| format!("out/{name}")).collect();
    assert_eq!(files.keys().collect::<Vec<_>>(), names.iter().collect::<Vec<_>>());
    let generations: BTreeSet<&String> = files.values().collect();
    assert_eq!(generations.len(), 1, "{generations:?}");
    let odd = files.contains_key("out/odd/file");
    let number: u64 = files["out/0"].rsplit(' ').next().unwrap().parse().unwrap();
    assert_eq!(odd, number % 2 == 1);
    let whole = files.contains_key("out/report.json");
    assert_eq!(files.len(), FILES - 1 + usize::from(odd) + usize::from(whole));
    whole
}

/// 50 interruptions at random times: exit code, nothing left, one generation, and no recovery needed.
#[test]
fn slow_interrupted_children_leave_one_generation_and_nothing_else() {
    let home = home();
    let dir = home.path().join("out");
    let mut times = Vec::new();
    let mut whole = 0;
    for round in 0..50 {
        if round % 5 == 0 && dir.exists() {
            fs::remove_dir_all(&dir).unwrap(); // some begin without a target
        }
        let mut child = Running::start("generations", &dir);
        random_pause(100);
        let (signal, code) = if round % 10 == 9 { ("-TERM", 143) } else { ("-INT", 130) };
        child.send(signal);
        let (status, time) = child.end();
        assert_eq!(status.code(), Some(code), "{status}");
        times.push(time);
        if dir.exists() {
            whole += usize::from(assert_one_generation(home.path()));
            assert!(!Folder::recover(&dir).unwrap());
        } else {
            assert!(listing(home.path()).is_empty(), "{:?}", listing(home.path()));
        }
    }
    times.sort();
    println!("50 interruptions: ended after {:?} (median), {:?} (most); {whole} whole", times[25], times[49]);
    // a busy machine may delay single ones
    assert!(times[25] < Duration::from_millis(500), "{times:?}");
}

/// 50 kills at random times: one generation after recovery; what is left is gone after the next run.
#[test]
fn slow_killed_children_leave_one_generation_after_recovery() {
    let home = home();
    let dir = home.path().join("out");
    let (mut left, mut recovered, mut whole) = (0, 0, 0);
    for round in 0..50 {
        if round % 10 == 0 && dir.exists() {
            fs::remove_dir_all(&dir).unwrap();
        }
        let mut child = Running::start("generations", &dir);
        random_pause(100);
        child.0.kill().unwrap();
        assert_eq!(child.end().0.signal(), Some(9));
        let is_temporary = |name: &String| name.contains(".contrapposto-");
        left += usize::from(listing(home.path()).keys().any(is_temporary));
        recovered += usize::from(Folder::recover(&dir).unwrap());
        Folder::check(&dir, &Plan::default()).unwrap();
        if dir.exists() {
            whole += usize::from(assert_one_generation(home.path()));
        } else {
            assert!(listing(home.path()).is_empty(), "{:?}", listing(home.path()));
        }
    }
    println!("50 kills: {left} left a temporary folder, {recovered} were in a commit; {whole} whole");
    assert!(left > 0, "no child was killed while it was writing");
}

#[test]
fn slow_interrupted_single_files_are_whole() {
    let home = home();
    for _ in 0..10 {
        let mut child = Running::start("files", home.path());
        random_pause(60);
        child.send("-INT");
        assert_eq!(child.end().0.code(), Some(130));
        let files = listing(home.path());
        assert!(files.iter().all(|(name, text)| name == "file" && text.len() == 1 << 20));
    }
}

/// Four processes write into one folder, which at first does not exist.
#[test]
fn slow_processes_that_write_at_once_do_not_mix() {
    for _ in 0..5 {
        let home = home();
        let dir = home.path().join("out");
        let mut children: Vec<Running> = (0..4).map(|_| Running::start("rounds", &dir)).collect();
        for child in &mut children {
            assert!(child.end().0.success());
        }
        assert_one_generation(home.path());
    }
}

/// A staging folder that is held stays and blocks nobody; of a killed process, it goes.
#[test]
fn a_held_staging_folder_stays_and_a_stale_one_goes() {
    for existed in [false, true] {
        let home = home();
        let dir = home.path().join("out");
        if existed {
            generation(&dir, "0 0", false).unwrap();
        }
        let mut child = Running::start("hold", &dir);
        child.wait_for("held");
        generation(&dir, "0 1", true).unwrap();
        let half = |name: &String| name.ends_with(".tmp/files/half");
        assert_eq!(listing(home.path()).keys().filter(|n| half(n)).count(), 1);
        child.0.kill().unwrap();
        child.end();
        assert_eq!(listing(home.path()).keys().filter(|n| half(n)).count(), 1);
        generation(&dir, "0 2", false).unwrap();
        assert!(assert_one_generation(home.path()));
    }
}

/// When cleaning up hangs, a second signal ends the process at once, and the time limit does so without one.
#[test]
fn a_second_signal_ends_at_once() {
    let home = home();
    let mut times = [Vec::new(), Vec::new()];
    for round in 0..6 {
        let mut child = Running::start("stuck", home.path());
        child.wait_for("held");
        let started = Instant::now();
        child.send("-INT");
        if round % 2 == 1 {
            std::thread::sleep(2 * interrupt::SAME);
            child.send("-INT");
        }
        assert_eq!(child.end().0.code(), Some(130));
        times[round % 2].push(started.elapsed());
    }
    println!("hanging: ended by the limit after {:?}, by a second signal after {:?}", times[0], times[1]);
    assert!(times[0].iter().min() >= Some(&interrupt::LIMIT));
    assert!(times[1].iter().min() < Some(&interrupt::LIMIT));
}
