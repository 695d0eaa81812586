//! The library on the command line: names in any folder, the list, the starter project.

use std::process::Command;

use support::root;

use crate::place::{Done, Place, human};

/// Runs the command in a folder of a place.
fn run_in(place: &Place, folder: &str, args: &[&str]) -> Done {
    let mut command = Command::new(env!("CARGO_BIN_EXE_contrapposto"));
    Done::of(&command.args(args).current_dir(place.at(folder)).output().unwrap())
}

/// A performed scene is the same to the byte from inside the program and from its file; only the clock differs.
#[test]
fn a_name_renders_as_its_file() {
    let place = Place::new();
    let scene = root().join("scenes/bow.ron");
    let run = |input: &str, out: &str| {
        let done = place.run(&["render", input, "--no-plots", "--out", out]);
        assert_eq!(done.code, 0, "{}", done.stderr);
        let mut report = place.report(out);
        report["dynamic"]["realtime_factor"].take().as_f64().unwrap();
        let mut files = place.files(out);
        files.retain(|(name, _)| name != "report.json" && name != ".contrapposto.json");
        assert!(files.iter().any(|(name, _)| name == "trace.npz"));
        (files, report)
    };
    assert!(run("bow", "name") == run(scene.to_str().unwrap(), "file"));
    assert!(
        place.run(&["render", "bow", "--kinematic", "--no-plots"]).stdout.contains("out/bow/kinematic.bvh")
    );
}

/// Each command takes the names of what it reads.
#[test]
fn every_command_takes_names() {
    let place = Place::new();
    for (args, word) in [
        (vec!["inspect", "human"], "human: 19 links"),
        (vec!["inspect", "fear"], "fear: "),
        (vec!["convert", "bow", "bow.glb"], "read library:scenes/bow.ron"),
        (vec!["convert", "human", "human.xml"], "read library:characters/human.ron"),
        (vec!["analyze", "reach", "--no-plots", "--format", "csv"], "out/reach-analysis"),
        (vec!["plot", "reach", "--what", "com"], "out/reach/plots/"),
        (vec!["render", "lamp-fear", "--kinematic", "--no-plots"], "out/lamp-fear/"),
        (
            vec![
                "retarget",
                "fear",
                "--to",
                "lamp",
                "--keyposes",
                "lamp",
                "--stop-after",
                "map",
                "--no-plots",
            ],
            "out/fear-lamp/",
        ),
        (vec!["push", "stand", "--directions", "1", "--tolerance", "50", "--no-plots"], "out/stand-push/"),
    ] {
        let done = place.run(&args);
        assert_eq!(done.code, 0, "{args:?}: {}", done.stderr);
        assert!(done.stdout.contains(word), "{args:?}: {}", done.stdout);
    }
}

#[test]
fn unknown_names_are_met_with_the_nearest() {
    let place = Place::new();
    let clip = place.clip("", "");
    let clip = clip.to_str().unwrap();
    for (args, words) in [
        (
            vec!["render", "bwo"],
            "error: `bwo`: no such file, and no scene of the library; did you mean `bow`? `contrapposto library` lists them\n",
        ),
        (vec!["render", clip, "--body", "humn"], "no character of the library; did you mean `human`?"),
        (vec!["render", "human"], "no scene of the library; `human` is a character there"),
        (vec!["retarget", "fear", "--to", "pengiun"], "did you mean `penguin`?"),
        (
            vec!["retarget", "fear", "--to", "lamp", "--keyposes", "lmp"],
            "no file of key poses of the library; did you mean `lamp`?",
        ),
        (vec!["push", "stnd"], "did you mean `stand`?"),
        (vec!["tune", "stnd"], "did you mean `stand`?"),
        (vec!["crosscheck", "humn"], "no scene or character of the library; did you mean `human`?"),
        (vec!["inspect", "library:scenes/bwo.ron"], "did you mean `library:scenes/bow.ron`?"),
        (vec!["analyze", "bwo"], "did you mean `bow`?"),
        (vec!["plot", "bwo"], "did you mean `bow`?"),
        (vec!["convert", "bwo", "bow.glb"], "did you mean `bow`?"),
        // a path is no name, but the library is pointed at
        (vec!["render", "scenes/bow.ron"], "help: the library has it: `bow`"),
        (vec!["library", "bwo"], "did you mean `bow`?"),
        (vec!["library", "lamp"], "`library:characters/lamp.ron` (character), `library:keyposes/lamp.ron`"),
    ] {
        let done = place.run(&args);
        assert_eq!((done.code, done.stdout.as_str()), (2, ""), "{args:?}: {}", done.stderr);
        assert!(done.stderr.contains(words), "{args:?}: {}", done.stderr);
    }
    assert!(!place.at("out").exists());
}

/// A file that exists is meant before a file of the library; a folder only where the folder of a run may be meant.
#[test]
fn a_file_on_disk_wins() {
    let place = Place::new();
    let clip = place.clip("", "");
    place.write("human", &human().replacen("Character(", "Charakter(", 1));
    let done = place.run(&["render", clip.to_str().unwrap(), "--body", "human"]);
    assert_eq!(done.code, 2);
    assert!(done.stderr.contains("--> human:"), "{}", done.stderr);
    std::fs::create_dir(place.at("bow")).unwrap();
    let done = place.run(&["analyze", "bow"]);
    assert!(done.code == 2 && done.stderr.contains("no trace.npz in this folder"), "{}", done.stderr);
    let done = place.run(&["inspect", "bow"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
}

#[test]
fn the_library_is_listed_and_printed() {
    let place = Place::new();
    let list = place.run(&["library"]);
    assert_eq!(list.code, 0, "{}", list.stderr);
    let json: serde_json::Value = serde_json::from_str(&place.run(&["library", "--json"]).stdout).unwrap();
    let all = json.as_array().unwrap();
    assert!(all.len() >= 28);
    for entry in all {
        let text = |key: &str| entry[key].as_str().unwrap();
        let line = list.stdout.lines().find(|l| l.trim_start().starts_with(&format!("{} ", text("name"))));
        assert!(line.is_some(), "{} is not listed", text("name"));
        assert!(list.stdout.contains(text("about")), "{}", text("about"));
        let printed = place.run(&["library", text("location")]);
        let file = text("location").trim_start_matches("library:").trim_start_matches("scenes/");
        assert_eq!(printed.stdout, std::fs::read_to_string(root().join("scenes").join(file)).unwrap());
    }
    assert_eq!(place.run(&["library", "human"]).stdout, human());
}

/// The project runs as its README says, and its two edits edit.
#[test]
fn a_starter_project_runs() {
    let place = Place::new();
    let made = place.run(&["new", "first/steps"]);
    assert_eq!(made.code, 0, "{}", made.stderr);
    assert!(
        made.stdout.ends_with("next: cd first/steps && contrapposto render hello.ron\n"),
        "{}",
        made.stdout
    );
    let names: Vec<String> = place.files("first/steps").into_iter().map(|(name, _)| name).collect();
    assert_eq!(names, ["README.md", "hello.ron", "human.ron"]);
    let readme = std::fs::read_to_string(place.at("first/steps/README.md")).unwrap();
    let commands: Vec<&str> = readme.lines().filter_map(|l| l.strip_prefix("    contrapposto ")).collect();
    assert_eq!(commands.len(), 2);
    assert!(readme.lines().count() <= 10);
    for command in commands {
        let mut args: Vec<&str> = command.split(' ').collect();
        args.push("--no-plots");
        let done = run_in(&place, "first/steps", &args);
        assert_eq!(done.code, 0, "{command}: {}", done.stderr);
        assert!(done.stdout.contains("the body stands"), "{command}: {}", done.stdout);
    }
    let clip =
        |out: &str| std::fs::read(place.at("first/steps/out").join(out).join("kinematic.bvh")).unwrap();
    assert!(clip("hello") != clip("unedited"));
    let inspected = run_in(&place, "first/steps", &["inspect", "hello.ron"]).stdout;
    assert!(inspected.contains("edits, in order: 0 succession, 1 amplitude"), "{inspected}");
}

#[test]
fn new_replaces_nothing() {
    let place = Place::new();
    place.write("mine/README.md", "mine");
    place.write("file", "mine");
    for (dir, word) in [("mine", "mine/README.md exists already"), ("file", "cannot make the folder file")] {
        let done = place.run(&["new", dir]);
        assert_eq!((done.code, done.stdout.as_str()), (2, ""), "{}", done.stderr);
        assert!(done.stderr.contains(word), "{}", done.stderr);
    }
    assert_eq!(place.files("mine"), [("README.md".to_owned(), b"mine".to_vec())]);
    assert_eq!(place.run(&["new", "made"]).code, 0);
    let before = place.files("made");
    assert_eq!(place.run(&["new", "made"]).code, 2);
    assert_eq!(place.files("made"), before);
}
