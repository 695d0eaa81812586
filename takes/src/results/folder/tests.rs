//! What the folder promises, in one process; processes that are killed are in `tests/folder.rs`.

use super::*;

/// A home for targets.
struct Home(tempfile::TempDir);

impl Home {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn put(&self, name: &str, text: &str) -> PathBuf {
        let path = self.path(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, text).unwrap();
        path
    }

    /// Names of everything in it, folders with `/`.
    fn listing(&self) -> Vec<String> {
        let mut found = Vec::new();
        let mut folders = vec![self.0.path().to_owned()];
        while let Some(folder) = folders.pop() {
            for path in fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()) {
                let name = path.strip_prefix(self.0.path()).unwrap().display().to_string();
                let is_dir = fs::symlink_metadata(&path).unwrap().is_dir();
                found.push(if is_dir { format!("{name}/") } else { name });
                folders.extend(is_dir.then_some(path));
            }
        }
        found.sort();
        found
    }

    /// A run that writes these files.
    fn run(&self, names: &[&str], reads: &[PathBuf]) -> Result<(), FolderError> {
        let mut folder =
            Folder::begin(&self.path("out"), &Plan { command: "render", reads, ..Plan::default() })?;
        for name in names {
            folder.write(name, format!("run of {} files: {name}", names.len()).as_bytes())?;
        }
        folder.commit()
    }

    fn check(&self, planned: &[&str], reads: &[PathBuf]) -> Result<(), FolderError> {
        Folder::check(&self.path("out"), &Plan { command: "render", planned, reads, ..Plan::default() })
    }
}

#[track_caller]
fn assert_foreign(done: Result<(), FolderError>, name: &str, why: Foreign) {
    let e = done.unwrap_err();
    assert!(e.is_input() && e.to_string().contains("--out"), "{e}");
    assert!(matches!(&e, FolderError::Foreign { path, why: w } if path.ends_with(name) && *w == why), "{e}");
}

#[track_caller]
fn assert_read(done: Result<(), FolderError>, name: &str) {
    let e = done.unwrap_err();
    assert!(e.is_input() && matches!(&e, FolderError::Input { path, .. } if path.ends_with(name)), "{e}");
}

#[test]
fn a_folder_appears_whole_with_a_manifest_and_nothing_else() {
    let home = Home::new();
    let mut folder =
        Folder::begin(&home.path("a/out"), &Plan { command: "render", ..Plan::default() }).unwrap();
    let path = folder.add("trace_npz", "trace.npz").unwrap();
    fs::write(path, "trace").unwrap();
    let path = folder.add("motion_svg", "plots/motion.svg").unwrap();
    fs::write(path, "figure").unwrap();
    let mut span = folder.inside("span_1").unwrap();
    span.add("report_json", "report.json").unwrap();
    span.write("report.json", b"{}").unwrap();
    assert_eq!(span.files(), BTreeMap::from([("report_json".into(), "report.json".into())]));
    let files = [
        ("motion_svg", "plots/motion.svg"),
        ("span_1_report_json", "span_1/report.json"),
        ("trace_npz", "trace.npz"),
    ];
    assert_eq!(folder.files(), files.map(|(k, n)| (k.into(), n.into())).into());
    assert!(!home.path("a/out").exists());
    folder.commit().unwrap();
    drop(folder);
    let names = [
        "a/",
        "a/out/",
        "a/out/.contrapposto.json",
        "a/out/plots/",
        "a/out/plots/motion.svg",
        "a/out/span_1/",
        "a/out/span_1/report.json",
        "a/out/trace.npz",
    ];
    assert_eq!(home.listing(), names);
    let (manifest, _) = Manifest::read(&home.path("a/out")).unwrap().unwrap();
    assert_eq!((manifest.command.as_str(), manifest.files.len()), ("render", 3));
    assert_eq!(manifest.files["trace.npz"], Stamp::of(b"trace"));
}

/// Two runs of the same command leave the same bytes, the manifest included.
#[test]
fn the_same_run_leaves_the_same_manifest() {
    let (a, b) = (Home::new(), Home::new());
    for home in [&a, &b, &b] {
        home.run(&["x", "plots/y"], &[]).unwrap();
    }
    let manifest = |home: &Home| fs::read(home.path("out").join(MANIFEST)).unwrap();
    assert_eq!(manifest(&a), manifest(&b));
}

#[test]
fn a_foreign_file_is_kept_and_named() {
    let home = Home::new();
    home.put("out/trace.npz", "a person's");
    home.put("out/notes.txt", "a person's");
    assert_foreign(home.check(&["a", "trace.npz"], &[]), "out/trace.npz", Foreign::NotListed);
    assert_foreign(home.run(&["a", "trace.npz"], &[]), "out/trace.npz", Foreign::NotListed);
    assert_eq!(home.listing(), ["out/", "out/notes.txt", "out/trace.npz"]);
    home.check(&["a"], &[]).unwrap();
    home.run(&["a"], &[]).unwrap();
    assert_eq!(home.listing(), ["out/", "out/.contrapposto.json", "out/a", "out/notes.txt", "out/trace.npz"]);
    assert_eq!(fs::read_to_string(home.path("out/trace.npz")).unwrap(), "a person's");
}

#[test]
fn a_file_of_ours_that_was_edited_is_kept_and_named() {
    let home = Home::new();
    home.run(&["a", "contacts.ron"], &[]).unwrap();
    let text = fs::read_to_string(home.path("out/contacts.ron")).unwrap();
    let edited = text.replace("run", "ran"); // the same length
    home.put("out/contacts.ron", &edited);
    assert_foreign(home.check(&["contacts.ron"], &[]), "out/contacts.ron", Foreign::Changed);
    assert_foreign(home.run(&["contacts.ron"], &[]), "out/contacts.ron", Foreign::Changed);
    assert!(home.path("out/a").exists(), "the failed run has removed earlier output");
    // a run without that name: `a` is ours and goes, the edited file stays and is the user's from now on
    home.run(&["b"], &[]).unwrap();
    assert_eq!(home.listing(), ["out/", "out/.contrapposto.json", "out/b", "out/contacts.ron"]);
    assert_eq!(fs::read_to_string(home.path("out/contacts.ron")).unwrap(), edited);
    home.put("out/contacts.ron", &text);
    assert_foreign(home.run(&["contacts.ron"], &[]), "out/contacts.ron", Foreign::NotListed);
}

#[test]
fn earlier_output_goes_with_its_folders_but_only_ours() {
    let home = Home::new();
    home.put("out/mine/x", "a person's");
    fs::create_dir_all(home.path("out/empty")).unwrap();
    home.run(&["a", "empty/b", "mine/y", "plots/c", "span_1/plots/d", "span_2/e"], &[]).unwrap();
    home.put("out/span_2/notes.txt", "a person's");
    home.run(&["report.json"], &[]).unwrap();
    let names = [
        "out/",
        "out/.contrapposto.json",
        "out/empty/", // a person made it
        "out/mine/",
        "out/mine/x",
        "out/report.json",
        "out/span_2/",
        "out/span_2/notes.txt",
    ];
    assert_eq!(home.listing(), names);
}

#[test]
fn a_command_that_adds_keeps_what_is_there() {
    let home = Home::new();
    home.run(&["trace.npz", "plots/a.svg"], &[]).unwrap();
    let plan = Plan { command: "plot", earlier: Earlier::Keep, ..Plan::default() };
    let mut folder = Folder::begin(&home.path("out"), &plan).unwrap();
    folder.write("plots/a.svg", b"new").unwrap();
    folder.write("plots/b.svg", b"new").unwrap();
    folder.commit().unwrap();
    let (manifest, _) = Manifest::read(&home.path("out")).unwrap().unwrap();
    assert_eq!(manifest.files.keys().collect::<Vec<_>>(), ["plots/a.svg", "plots/b.svg", "trace.npz"]);
    assert_eq!(manifest.command, "render");
    home.run(&["x"], &[]).unwrap();
    drop(folder);
    assert_eq!(home.listing(), ["out/", "out/.contrapposto.json", "out/x"]);
}

#[test]
fn an_input_is_never_replaced_nor_removed() {
    let home = Home::new();
    home.run(&["dynamic.bvh", "kinematic.bvh"], &[]).unwrap();
    let file = home.path("out/dynamic.bvh");
    let mut names = vec![file.clone(), home.path("out/./dynamic.bvh"), home.path("out/../out/dynamic.bvh")];
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(&file, home.path("link.bvh")).unwrap();
        std::os::unix::fs::symlink(home.path("out"), home.path("folder")).unwrap();
        fs::hard_link(&file, home.path("hard.bvh")).unwrap();
        names.extend([home.path("link.bvh"), home.path("folder/dynamic.bvh"), home.path("hard.bvh")]);
    }
    let before = home.listing();
    for read in &names {
        let reads = std::slice::from_ref(read);
        assert_read(home.check(&["dynamic.bvh"], reads), "out/dynamic.bvh");
        assert_read(home.run(&["a", "dynamic.bvh"], reads), "out/dynamic.bvh");
        assert_read(write_file(&file, b"", Overwrite::Allow, reads), "out/dynamic.bvh");
        assert_eq!(home.listing(), before);
    }
    // not written by this run, so it would be removed if it were no input
    home.run(&["a"], &names).unwrap();
    assert!(file.exists() && !home.path("out/kinematic.bvh").exists());
    home.run(&["b"], &[]).unwrap();
    assert!(!file.exists(), "still ours");
}

#[cfg(unix)]
#[test]
fn links_in_the_folder_are_not_followed() {
    use std::os::unix::fs::symlink;
    let home = Home::new();
    home.run(&["a", "plots/b"], &[]).unwrap();
    home.put("elsewhere/b", "run of 2 files: plots/b");
    fs::remove_dir_all(home.path("out/plots")).unwrap();
    symlink(home.path("elsewhere"), home.path("out/plots")).unwrap();
    fs::remove_file(home.path("out/a")).unwrap();
    symlink(home.path("nothing"), home.path("out/a")).unwrap();
    assert_foreign(home.check(&["a"], &[]), "out/a", Foreign::Link);
    assert_foreign(home.run(&["plots/b"], &[]), "out/plots", Foreign::Link);
    home.run(&["c"], &[]).unwrap(); // removes what the manifest lists, but not through the link
    assert!(home.path("elsewhere/b").exists() && fs::symlink_metadata(home.path("out/a")).is_ok());
    fs::create_dir(home.path("out/d")).unwrap();
    assert_foreign(home.check(&["d"], &[]), "out/d", Foreign::Folder);
    assert_foreign(home.check(&["c/d"], &[]), "out/c", Foreign::File);
    // a target that is itself a link is the folder it leads to
    symlink(home.path("elsewhere"), home.path("link")).unwrap();
    let mut folder = Folder::begin(&home.path("link"), &Plan::default()).unwrap();
    folder.write("x", b"").unwrap();
    folder.commit().unwrap();
    assert!(
        home.path("elsewhere/x").exists() && fs::symlink_metadata(home.path("link")).unwrap().is_symlink()
    );
}

#[test]
fn a_second_commit_adds_and_replaces_only_its_own() {
    for existed in [false, true] {
        let home = Home::new();
        if existed {
            home.run(&["old", "report.json"], &[]).unwrap();
        }
        let mut folder = Folder::begin(&home.path("out"), &Plan::default()).unwrap();
        folder.write("trace.npz", b"1").unwrap();
        folder.write("report.json", b"1").unwrap();
        folder.commit().unwrap();
        assert_eq!(fs::read(home.path("out/report.json")).unwrap(), b"1");
        assert!(home.path("out/trace.npz").exists() && !home.path("out/old").exists());
        folder.write("plots/a.svg", b"2").unwrap();
        folder.write("report.json", b"2").unwrap();
        folder.commit().unwrap();
        folder.commit().unwrap(); // nothing new
        assert_eq!(fs::read(home.path("out/report.json")).unwrap(), b"2");
        // a failed figure: what was committed stays
        folder.write("plots/b.svg", b"half").unwrap();
        drop(folder);
        let names = [
            "out/",
            "out/.contrapposto.json",
            "out/plots/",
            "out/plots/a.svg",
            "out/report.json",
            "out/trace.npz",
        ];
        assert_eq!(home.listing(), names);
    }
}

#[test]
fn a_run_does_not_add_to_the_output_of_another() {
    let home = Home::new();
    let mut first = Folder::begin(&home.path("out"), &Plan::default()).unwrap();
    let mut second = Folder::begin(&home.path("out"), &Plan::default()).unwrap();
    first.write("a", b"1").unwrap();
    first.commit().unwrap();
    second.write("b", b"2").unwrap();
    second.commit().unwrap();
    first.write("plots/a.svg", b"1").unwrap();
    let e = first.commit().unwrap_err();
    assert!(matches!(e, FolderError::Overtaken { .. }) && !e.is_input(), "{e}");
    drop((first, second));
    assert_eq!(home.listing(), ["out/", "out/.contrapposto.json", "out/b"]);
}

#[test]
fn names_that_leave_the_folder_and_files_without_content_are_refused() {
    let home = Home::new();
    let mut folder = Folder::begin(&home.path("out"), &Plan::default()).unwrap();
    for name in ["../a", "/a", "a/../../b", ""] {
        assert!(matches!(folder.add("a", name), Err(FolderError::Name { .. })), "{name}");
        assert!(matches!(folder.write(name, b""), Err(FolderError::Name { .. })), "{name}");
        assert!(matches!(folder.inside(name), Err(FolderError::Name { .. })), "{name}");
        assert!(matches!(home.check(&[name], &[]), Err(FolderError::Name { .. })), "{name}");
    }
    folder.add("a", "a").unwrap();
    assert!(matches!(folder.add("b", "a"), Err(FolderError::Twice { .. })));
    assert!(matches!(folder.commit(), Err(FolderError::NotWritten { .. })));
    drop(folder);
    assert!(home.listing().is_empty());
}

#[test]
fn a_check_leaves_nothing_and_folders_on_the_way_go() {
    let home = Home::new();
    Folder::check(&home.path("a/b/out"), &Plan::default()).unwrap();
    assert!(home.listing().is_empty());
    home.put("file", "");
    let e = Folder::check(&home.path("file"), &Plan::default()).unwrap_err();
    assert!(matches!(e, FolderError::NotAFolder { .. }) && e.is_input(), "{e}");
    let e = Folder::check(&home.path("file/out"), &Plan::default()).unwrap_err();
    assert!(matches!(e, FolderError::Io { .. }) && !e.is_input(), "{e}");
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("nowhere", home.path("link")).unwrap();
        let e = Folder::check(&home.path("link"), &Plan::default()).unwrap_err();
        assert!(e.to_string().contains("a symbolic link to nothing"), "{e}");
        fs::remove_file(home.path("link")).unwrap();
    }
    assert_eq!(home.listing(), ["file"]);
}

/// `/proc` can be written to by nobody, root included; a folder without permission, by nobody but root.
#[cfg(target_os = "linux")]
#[test]
fn a_folder_that_cannot_be_written_to_is_named() {
    use std::os::unix::fs::PermissionsExt;
    let home = Home::new();
    let closed = home.path("closed");
    fs::create_dir(&closed).unwrap();
    fs::set_permissions(&closed, fs::Permissions::from_mode(0o555)).unwrap();
    let is_root = fs::write(closed.join("probe"), "").is_ok();
    let mut dirs = vec![PathBuf::from("/proc"), PathBuf::from("/proc/out")];
    match is_root {
        true => eprintln!("skipped for root: a folder without write permission"),
        false => dirs.extend([closed.clone(), closed.join("out")]),
    }
    for dir in dirs {
        let e = Folder::check(&dir, &Plan::default()).unwrap_err();
        assert!(matches!(&e, FolderError::Io { path, .. } if *path == dir) && !e.is_input(), "{e}");
    }
}

#[test]
fn a_damaged_manifest_is_named() {
    let home = Home::new();
    home.run(&["a"], &[]).unwrap();
    home.put("out/.contrapposto.json", "{");
    let e = home.check(&["a"], &[]).unwrap_err();
    assert!(matches!(e, FolderError::Manifest { .. }) && e.is_input(), "{e}");
}

#[test]
fn a_single_file_is_written_whole_and_replaces_only_what_may_be() {
    let home = Home::new();
    let path = home.path("a.mot");
    write_file(&path, b"1", Overwrite::Refuse, &[]).unwrap();
    let e = write_file(&path, b"2", Overwrite::Refuse, &[]).unwrap_err();
    assert!(
        matches!(e, FolderError::Exists { .. }) && e.is_input() && e.to_string().contains("--force"),
        "{e}"
    );
    assert_eq!(fs::read(&path).unwrap(), b"1");
    write_file(&path, b"2", Overwrite::Allow, &[]).unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"2");
    let e = write_file(&home.path("no/a.mot"), b"", Overwrite::Allow, &[]).unwrap_err();
    assert!(matches!(e, FolderError::Io { .. }) && !e.is_input(), "{e}");
    let e = write_file(home.0.path(), b"", Overwrite::Allow, &[]).unwrap_err();
    assert!(matches!(e, FolderError::NotAFile { why: Foreign::Folder, .. }), "{e}");
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(&path, home.path("link")).unwrap();
        for overwrite in [Overwrite::Refuse, Overwrite::Allow] {
            let e = write_file(&home.path("link"), b"", overwrite, &[]).unwrap_err();
            assert!(matches!(e, FolderError::NotAFile { why: Foreign::Link, .. }) && e.is_input(), "{e}");
            let e = write_file(Path::new("/dev/null"), b"", overwrite, &[]).unwrap_err();
            assert!(matches!(e, FolderError::NotAFile { why: Foreign::Special, .. }), "{e}");
        }
        fs::remove_file(home.path("link")).unwrap();
    }
    assert_eq!(home.listing(), ["a.mot"]);
}
