//! Folders to work in, files to break, the command to run.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::atomic::{AtomicUsize, Ordering};

use takes::results::folder::manifest::{MANIFEST, Manifest};
use takes::results::folder::{Folder, Plan};

/// An empty folder, removed when dropped.
pub struct Place(PathBuf);

impl Place {
    /// A new one.
    pub fn new() -> Self {
        static COUNT: AtomicUsize = AtomicUsize::new(0);
        let name = format!("cli-{}-{}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
        let dir = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
        std::fs::create_dir_all(&dir).unwrap();
        Self(dir)
    }

    /// A path in it.
    pub fn at(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    /// Writes a file in it.
    pub fn write(&self, name: &str, text: &str) -> PathBuf {
        let path = self.at(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, text).unwrap();
        path
    }

    /// The bow, shortened to half a second, with one text replaced by another that must be there; its
    /// character is the standard one.
    pub fn scene(&self, from: &str, to: &str) -> PathBuf {
        self.scene_of(&human(), from, to)
    }

    /// As [`Place::scene`], of a character with one text replaced.
    pub fn scene_with_character(&self, from: &str, to: &str) -> PathBuf {
        self.scene_of(&replaced(&human(), from, to), "", "")
    }

    fn scene_of(&self, character: &str, from: &str, to: &str) -> PathBuf {
        self.write("characters/human.ron", character);
        self.write("scene.ron", &replaced(BOW, from, to))
    }

    /// A clip of a standing human, 30 frames; one text replaced.
    pub fn clip(&self, from: &str, to: &str) -> PathBuf {
        let scene = self.scene("", "");
        let clip = self.at("clip.bvh");
        let args = ["convert", scene.to_str().unwrap(), clip.to_str().unwrap(), "--rate", "30", "--force"];
        let made = self.run(&args);
        assert_eq!(made.code, 0, "{}", made.stderr);
        let text = std::fs::read_to_string(&clip).unwrap();
        self.write("clip.bvh", &replaced(&text, from, to))
    }

    /// Runs the command in this folder.
    pub fn run(&self, args: &[&str]) -> Done {
        let mut command = Command::new(env!("CARGO_BIN_EXE_contrapposto"));
        Done::of(&command.args(args).current_dir(&self.0).output().unwrap())
    }

    /// [`Place::run`] with variables of the environment.
    pub fn run_with(&self, args: &[&str], variables: &[(&str, &str)]) -> Done {
        let mut command = Command::new(env!("CARGO_BIN_EXE_contrapposto"));
        command.args(args).current_dir(&self.0).envs(variables.iter().copied());
        Done::of(&command.output().unwrap())
    }

    /// Renders into `out` below this folder.
    pub fn render(&self, input: &Path, options: &[&str]) -> Done {
        let mut args = vec!["render", input.to_str().unwrap(), "--no-plots", "--out", "out"];
        args.extend(options);
        self.run(&args)
    }

    /// Runs into `out`, in which earlier output lies: expects a refusal with these words, and the folder as it was.
    #[track_caller]
    pub fn refused(&self, args: &[&str], words: &[&str]) {
        self.earlier_run("out", &["kinematic.bvh", "report.json"]);
        self.write("out/notes.txt", "mine");
        let before = self.files("out");
        let done = self.run(&[args, &["--no-plots", "--out", "out"]].concat());
        assert_eq!(done.code, 2, "{words:?}: {}", done.stderr);
        assert_eq!(done.stdout, "", "{words:?}");
        assert_eq!(done.stderr.matches("error:").count(), 1, "{}", done.stderr);
        for word in words {
            assert!(done.stderr.contains(word), "`{word}` is not in\n{}", done.stderr);
        }
        assert!(!done.stderr.contains("panicked"), "{}", done.stderr);
        assert!(self.files("out") == before, "{words:?}: the output folder changed");
    }

    /// The report that a run wrote into a folder.
    pub fn report(&self, folder: &str) -> serde_json::Value {
        serde_json::from_slice(&std::fs::read(self.at(folder).join("report.json")).unwrap()).unwrap()
    }

    /// Files as a run leaves them, with a manifest.
    pub fn earlier_run(&self, folder: &str, names: &[&str]) {
        let plan = Plan { command: "render", planned: names, ..Plan::default() };
        let mut made = Folder::begin(&self.at(folder), &plan).unwrap();
        names.iter().for_each(|name| made.write(name, b"earlier").unwrap());
        made.commit().unwrap();
    }

    /// Names of the files in the folder of a run, without its manifest, which lists what the run wrote: all of that is there as
    /// it was written.
    pub fn names(&self, folder: &str) -> Vec<String> {
        let dir = self.at(folder);
        let (manifest, _) =
            Manifest::read(&dir).unwrap().unwrap_or_else(|| panic!("no manifest in {folder}"));
        for (name, stamp) in &manifest.files {
            assert!(stamp.is_of(&dir.join(name)).unwrap(), "{folder}/{name} is not as it was written");
        }
        self.files(folder).into_iter().map(|(name, _)| name).filter(|name| name != MANIFEST).collect()
    }

    /// Paths of all files in a folder, relative to it, and their bytes, sorted.
    pub fn files(&self, folder: &str) -> Vec<(String, Vec<u8>)> {
        fn walk(dir: &Path, at: &str, found: &mut Vec<(String, Vec<u8>)>) {
            for entry in std::fs::read_dir(dir).unwrap() {
                let entry = entry.unwrap();
                let name = format!("{at}{}", entry.file_name().to_str().unwrap());
                if entry.path().is_dir() {
                    walk(&entry.path(), &format!("{name}/"), found);
                } else {
                    found.push((name, std::fs::read(entry.path()).unwrap()));
                }
            }
        }
        let mut found = Vec::new();
        walk(&self.at(folder), "", &mut found);
        found.sort();
        found
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// What came of a command.
pub struct Done {
    /// Exit code.
    pub code: i32,
    /// Standard output.
    pub stdout: String,
    /// Standard error.
    pub stderr: String,
}

impl Done {
    /// From the process.
    pub fn of(output: &Output) -> Self {
        let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap();
        let code = output.status.code().expect("ended by a signal");
        Self { code, stdout: text(&output.stdout), stderr: text(&output.stderr) }
    }
}

/// The standard figure.
pub fn human() -> String {
    std::fs::read_to_string(support::scene("characters/human.ron")).unwrap()
}

/// A text with one part, which must be there, replaced.
pub fn replaced(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "`{from}` is not in the text");
    text.replacen(from, to, 1)
}

const BOW: &str = r#"Scene(
    character: "characters/human.ron",
    rate_hz: 60,
    script: [
        Action(name: "bow", curve: EaseInOut, cycles: [Cycle(poses: [
            Pose(duration_s: 0.3, hold_s: 0.1, set_deg: {
                "chest": (12, 0, 0),
                "elbow_r": 20,
            }),
        ])]),
    ],
    edits: [
        Succession(on: "bow", offset_s: 0.05),
        Amplitude(on: "bow", parts: ["elbow_r"], factor: 1.2),
        Amplitude(on: "bow", parts: ["elbow_r"], factor: 1.1),
    ],
    root: Free,
    settle_s: 0.2,
)
"#;
