//! Commits that are cut off, and files that appear while one is under way.

use super::*;

const OLD_RUN: [&str; 4] = ["common", "old/only", "plots/a.svg", "report.json"];
const NEW_RUN: [&str; 6] = ["common", "made/c", "new", "new2", "plots/b.svg", "report.json"];

struct Scene {
    _home: tempfile::TempDir,
    target: PathBuf,
    staging: Staging,
    new: BTreeMap<String, Stamp>,
}

fn write_all<'a>(dir: &Path, names: impl Iterator<Item = &'a str>, text: &str) {
    for name in names {
        let path = dir.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, format!("{text} {name}")).unwrap();
    }
}

/// A target with an old run and a staging folder with a new one, inside the target or beside it.
fn scene(inside: bool) -> Scene {
    // in memory where that is possible: commits synchronise with the disk
    let home = tempfile::tempdir_in("/dev/shm").or_else(|_| tempfile::tempdir()).unwrap();
    let target = fs::canonicalize(home.path()).unwrap().join("target");
    write_all(&target, OLD_RUN.into_iter(), "old");
    let manifest = manifest_of("old", &staged(&target).unwrap());
    fs::write(target.join(MANIFEST), manifest.to_json()).unwrap();
    let staging = Staging::create(if inside { &target } else { home.path() }).unwrap();
    write_all(&staging.files(), NEW_RUN.into_iter(), "new");
    let new = staged(&staging.files()).unwrap();
    Scene { _home: home, target, staging, new }
}

impl Scene {
    fn commit<'a>(&'a self, reads: &'a ReadFiles) -> Commit<'a> {
        let (staging, target, shown) = (&self.staging, &self.target, Path::new("target"));
        Commit { staging, target, shown, reads, command: "new", keeps: false, mine: None }
    }

    /// Files of the target and what is in them, without those of a staging folder.
    fn content(&self) -> BTreeMap<String, String> {
        let mut found = BTreeMap::new();
        let mut folders = vec![self.target.clone()];
        while let Some(folder) = folders.pop() {
            for path in fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()) {
                let name = path.strip_prefix(&self.target).unwrap().to_string_lossy().into_owned();
                match (name.starts_with(".contrapposto-"), path.is_dir()) {
                    (true, _) => {}
                    (false, true) => {
                        found.insert(format!("{name}/"), String::new());
                        folders.push(path);
                    }
                    (false, false) => drop(found.insert(name, fs::read_to_string(path).unwrap())),
                }
            }
        }
        found
    }
}

/// The commit is cut off after every single move; afterwards everything is as before, or as after the whole.
#[test]
fn a_commit_cut_off_at_any_move_is_undone() {
    for inside in [true, false] {
        let whole = scene(inside);
        whole.commit(&ReadFiles::default()).run(&whole.new).unwrap();
        let after = whole.content();
        assert!(after.contains_key("new2") && !after.contains_key("old/") && !after.contains_key("old/only"));
        let mut cuts = 0;
        for cut in 0.. {
            let scene = scene(inside);
            let before = scene.content();
            let reads = ReadFiles::default();
            let commit = scene.commit(&reads);
            let old = Manifest::read(&scene.target).unwrap().unwrap().0;
            let Planned { journal, manifest, seen } = commit.plan(&scene.new, Some(old)).unwrap();
            commit.announce(&manifest.to_json(), &journal).unwrap();
            let n = journal.moves.len();
            if cut <= n {
                commit.set_aside(&journal.moves[n - cut..], &seen).unwrap();
            } else if cut <= 2 * n {
                commit.set_aside(&journal.moves, &seen).unwrap();
                journal.folders.iter().for_each(|f| fs::create_dir(scene.target.join(f)).unwrap());
                commit.give_names(&journal.moves[..cut - n]).unwrap();
            } else {
                commit.moves(&journal, &seen).unwrap();
            }
            let Scene { _home, target, staging, new } = scene;
            staging.keep();
            drop(staging); // as a killed process: the folder is there, nobody holds it
            assert!(recover(&target).unwrap() && !recover(&target).unwrap());
            let scene = Scene { staging: Staging::create(&target).unwrap(), _home, target, new };
            let expected = if cut <= 2 * n { &before } else { &after };
            assert_eq!(scene.content(), *expected, "cut {cut} of {n} moves");
            cuts += 1;
            if cut > 2 * n {
                break;
            }
        }
        assert_eq!(cuts, 2 * 8 + 2); // 8 names in both runs
    }
}

/// What somebody puts into the folder between check and move stays, and the commit is undone.
#[test]
fn what_appears_meanwhile_is_not_replaced() {
    for (name, why) in [("new", Foreign::NotListed), ("common", Foreign::Changed)] {
        let scene = scene(true);
        let reads = ReadFiles::default();
        let commit = scene.commit(&reads);
        let old = Manifest::read(&scene.target).unwrap().unwrap().0;
        let Planned { journal, manifest, seen } = commit.plan(&scene.new, Some(old)).unwrap();
        commit.announce(&manifest.to_json(), &journal).unwrap();
        fs::write(scene.target.join(name), "a person's").unwrap();
        let before = scene.content();
        let e = commit.moves(&journal, &seen).unwrap_err();
        assert!(
            matches!(&e, FolderError::Foreign { path, why: w } if path.ends_with(name) && *w == why),
            "{e}"
        );
        undo(scene.staging.dir(), &scene.target, &journal).unwrap();
        assert_eq!(scene.content(), before);
    }
}
