//! Tuning: the cost tells good from bad, threads do not matter, sweeps may be cut and merged, patches apply.

use std::path::{Path, PathBuf};

use controllers::{Tunable, parameter};
use scenes::TuneSpec;
use scenes::tune_spec::FixedPush;
use scenes::{Patch, Source, scene};
use sim::EngineEntry;
use studies::tune::journal::Head;
use studies::tune::{self, Cost, Grid, Sample, Search, Shard, SolverKind, sweep};
use takes::open::of_scene;
use takes::{Ask, Take, TakeError};

fn stand_with(section: &str) -> Result<Take, TakeError> {
    let text = format!(
        r#"Scene(character: "characters/human.ron", rate_hz: 60, root: Free, settle_s: 1.0,
{section}
)"#
    );
    let path = support::root().join("scenes/in-a-test.ron");
    of_scene(scene::parse(Source::new(path, text), "stand".into())?, &Ask::default())
}

/// A cost of a fifth of a second.
fn quick(parameters: &[&str], pushes: &[(f64, f64)]) -> TuneSpec {
    TuneSpec {
        parameters: parameters.iter().map(|n| parameter(n).unwrap()).collect(),
        pushes: pushes.iter().map(|&(deg, of_limit)| FixedPush { deg, of_limit }).collect(),
        after_s: 0.8,
        push_at_s: 0.2,
        rate_hz: Some(120.0),
        substeps: Some(1),
        ..TuneSpec::default()
    }
}

fn fall(pushes: &[(f64, f64)], t: &Tunable) -> f64 {
    let cost =
        Cost::new(&stand_with("").unwrap(), &quick(&["tension"], pushes), &EngineEntry::default()).unwrap();
    cost.evaluate(t).terms[0]
}

/// Harder pushes cost more, also where all of them are lost: a search sees which way is up. Mirrored pushes on a
/// symmetric body cost the same.
#[test]
fn the_cost_grows_with_the_push() {
    let t = Tunable::default();
    let costs: Vec<f64> = [0.1, 2.0, 4.0, 10.0].iter().map(|x| fall(&[(0.0, *x)], &t)).collect();
    assert!(costs.is_sorted() && costs[0] < 0.5 && costs[1] > 1.0 && costs[3] > costs[1] + 0.01, "{costs:?}");
    let (left, right) = (fall(&[(90.0, 0.3)], &t), fall(&[(270.0, 0.3)], &t));
    assert!((left - right).abs() < 0.02, "{left} {right}"); // 3e-3 seen
}

/// A body that does not shift its weight between its feet takes pushes to the side worse than one that does
/// (at 90° 56 % of the limit against 116 %).
#[test]
fn the_cost_tells_good_from_bad() {
    let good = Tunable::default();
    let mut bad = good;
    bad.balance.weight_shift = false;
    let pushes = [(90.0, 0.75), (45.0, 0.75)];
    // long enough to fall: 0.8 s after a push both are still on their way
    let spec = TuneSpec { after_s: 2.5, ..quick(&["tension"], &pushes) };
    let cost = Cost::new(&stand_with("").unwrap(), &spec, &EngineEntry::default()).unwrap();
    let (a, b) = (cost.evaluate(&good).terms[0], cost.evaluate(&bad).terms[0]);
    assert!(b > a + 0.1, "{a} {b}");
}

#[test]
fn slow_threads_do_not_matter() {
    let take = stand_with("").unwrap();
    let spec = quick(&["tension", "pressure"], &[(0.0, 0.9), (90.0, 0.9)]);
    let how = Search { solver: SolverKind::CmaEs, seed: 3, evaluations: 8, start: None, step: 0.3 };
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let cost = Cost::new(&take, &spec, &EngineEntry::default()).unwrap();
            tune::search(&cost, 2, &how, Vec::new(), &mut |_| Ok(())).unwrap()
        })
    };
    let one = on(1);
    assert!(one.len() >= 8 && tune::best(&one).is_some());
    assert_eq!(one, on(2));
}

fn folder(name: &str) -> PathBuf {
    let dir = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}-{}", std::process::id()));
    std::fs::create_dir_all(&dir).unwrap();
    dir
}

/// Three jobs, one of them killed in the middle of a line and run again, merge to the whole sweep.
#[test]
fn shards_merge_to_the_whole() {
    let dir = folder("sweep");
    let take = stand_with("").unwrap();
    let spec = quick(&["tension"], &[(0.0, 0.9)]);
    let cost = Cost::new(&take, &spec, &EngineEntry::default()).unwrap();
    let axes = ["pressure=0..0.8:3", "tension=1..2:2"].map(|a| a.parse().unwrap());
    let grid = Grid::new(axes.to_vec()).unwrap();
    let identity = grid.identity("stand", &tune::digest(&take, &spec));
    let run = |shard: &str, file: &Path| {
        sweep::run(&cost, &grid, shard.parse().unwrap(), &identity, file, &mut |_| {}).unwrap()
    };
    let whole = dir.join("whole.csv");
    assert_eq!(run("1/1", &whole), 6);
    let parts: Vec<PathBuf> = (1..=3).map(|i| dir.join(format!("{i}.csv"))).collect();
    for (i, part) in parts.iter().enumerate() {
        assert_eq!(run(&format!("{}/3", i + 1), part), 2);
    }
    let text = std::fs::read_to_string(&parts[1]).unwrap();
    std::fs::write(&parts[1], &text[..text.len() - 9]).unwrap();
    assert_eq!(run("2/3", &parts[1]), 1);
    assert_eq!(run("2/3", &parts[1]), 0);

    let (table, merged) = sweep::merge(&parts).unwrap();
    let expected = sweep::read(&whole, Some(&identity)).unwrap();
    assert_eq!(table.head, expected.head);
    assert_eq!(merged.into_iter().collect::<Vec<_>>(), expected.samples);
    // the last axis runs fastest
    assert_eq!(expected.samples[1].1.values, [0.0, 2.0]);

    // another sweep's table, and one that contradicts
    let other = Grid::new(vec!["pressure=0..0.8:2".parse().unwrap()]).unwrap();
    let theirs = other.identity("stand", &tune::digest(&take, &spec));
    let e = sweep::run(&cost, &other, Shard::WHOLE, &theirs, &whole, &mut |_| {}).unwrap_err();
    assert!(e.to_string().contains("is of another sweep"), "{e}");
    let dear = Sample { cost: 7.5, ..expected.samples[0].1.clone() };
    std::fs::write(&parts[2], expected.head.table([(0, &dear)])).unwrap();
    let e = sweep::merge(&parts).unwrap_err().to_string();
    assert!(e.contains("sample 0 has two costs"), "{e}");

    // a cost that somebody wrote, a sample beyond the grid, a table of something else
    let text = std::fs::read_to_string(&whole).unwrap();
    let beyond = expected.head.table([(6, &dear)]);
    for (text, words) in [
        (text.replacen(&expected.samples[0].1.cost.to_string(), "7.5", 1), "line 3 was changed"),
        (beyond, "sample 6 of a sweep of 6 samples"),
        (text.replacen("contrapposto sweep", "contrapposto tune", 1), "line 3 was changed"),
        (Head::new("contrapposto tune of stand", &grid.parameters()).table([]), "no table of a sweep"),
    ] {
        std::fs::write(&parts[2], text).unwrap();
        let e = sweep::merge(&parts[2..]).unwrap_err();
        assert!(e.is_input() && e.to_string().contains(words), "{e}");
    }
    // nobody's file is removed for its name
    std::fs::write(&parts[2], "mine").unwrap();
    assert!(sweep::forget(&parts[2]).is_err() && parts[2].exists());
    sweep::forget(&whole).unwrap();
    assert!(!whole.exists());
    std::fs::remove_dir_all(dir).unwrap();
}

/// What is on disk names its input: another scene, cost, seed or solver is another run.
#[test]
fn another_run_has_another_name() {
    let take = stand_with("").unwrap();
    let spec = quick(&["tension"], &[(0.0, 0.9)]);
    let how = Search { solver: SolverKind::CmaEs, seed: 3, evaluations: 8, start: None, step: 0.3 };
    let name = tune::identity(&take, &spec, &how);
    assert_eq!(name, tune::identity(&take, &spec, &Search { evaluations: 99, ..how.clone() }));
    let mut tense = take.clone();
    tense.conditions.physics.tension = 2.0;
    let harder = TuneSpec { after_s: 0.9, ..spec.clone() };
    let others = [
        tune::identity(&take, &spec, &Search { seed: 4, ..how.clone() }),
        tune::identity(&take, &spec, &Search { solver: SolverKind::NelderMead, ..how.clone() }),
        tune::identity(&take, &spec, &Search { start: Some(vec![0.5]), ..how.clone() }),
        tune::identity(&tense, &spec, &how),
        tune::identity(&take, &harder, &how),
    ];
    assert!(others.iter().all(|o| *o != name), "{others:?}");
}

/// A scene's patch, and one given beside it, which comes later.
#[test]
fn patches_apply() {
    let dir = folder("patch");
    let name = dir.join("p.ron");
    std::fs::write(&name, r#"Patch(set: {"catch_gain": (was: 1.5, is: 2.0), "tension": (is: 1.5)})"#)
        .unwrap();
    let mut take = stand_with(&format!("patch: {:?},", name.to_str().unwrap())).unwrap();
    let t = take.tunable();
    assert_eq!((t.balance.catch_gain, t.tension), (2.0, 1.5));
    assert_eq!(take.pass().setup.balance.catch_gain, 2.0);
    assert_eq!(take.pass().setup.tension, 1.5);
    let later = Patch::parse(&Source::new("q.ron", r#"Patch(set: {"catch_gain": (is: 1.0)})"#)).unwrap();
    later.apply(&mut take.conditions.physics);
    assert_eq!((take.tunable().balance.catch_gain, take.tunable().tension), (1.0, 1.5));
    std::fs::remove_dir_all(dir).unwrap();
}

/// What a scene says about tuning is read, and refused at its line.
#[test]
fn sections_are_checked() {
    let good = r#"tune: (parameters: ["shift", "tension"], weights: (effort: 2), pushes: [(deg: 90, of_limit: 0.5)]),"#;
    let spec = stand_with(good).unwrap().tune;
    assert_eq!(spec.parameters.iter().map(|p| p.name).collect::<Vec<_>>(), ["shift", "tension"]);
    assert_eq!((spec.weights[0], spec.weights[2]), (1.0, 2.0));
    assert_eq!(spec.pushes, [FixedPush { deg: 90.0, of_limit: 0.5 }]);
    let nine = ["(deg: 0, of_limit: 1)"; 9].join(", ");
    for (section, words) in [
        (
            r#"tune: (parameters: ["shft"]),"#.to_owned(),
            "unknown parameter `shft` in tune; did you mean `shift`?",
        ),
        ("tune: (parameters: []),".to_owned(), "at least one"),
        (format!("tune: (pushes: [{nine}]),"), "9 pushes; allowed: up to 8"),
        ("tune: (pushes: [(deg: 0, of_limit: -1)]),".to_owned(), "of_limit is -1; allowed: 0.01 to 10"),
        ("tune: (weights: (fall: -1)),".to_owned(), "fall is -1; allowed: 0 to 1000"),
        ("tune: (after_s: 0),".to_owned(), "after_s is 0 s; allowed: 0.1 to 60 s"),
        ("tune: (aftr_s: 1),".to_owned(), "aftr_s"),
        (r#"patch: "none.ron","#.to_owned(), "does not exist"),
    ] {
        let e = stand_with(&section).expect_err(&section).to_string();
        assert!(e.contains(words) && e.contains("in-a-test.ron:2:"), "{section}: {e}");
    }
    let held = stand_with("planted: [],").unwrap();
    let e = Cost::new(&held, &quick(&["tension"], &[(0.0, 1.0)]), &EngineEntry::default())
        .err()
        .unwrap()
        .to_string();
    assert!(e.contains("planted feet"), "{e}");
    let nothing = TuneSpec { pushes: vec![], ..quick(&["tension"], &[]) };
    let e = Cost::new(&stand_with("").unwrap(), &nothing, &EngineEntry::default()).err().unwrap().to_string();
    assert!(e.contains("nothing to cost"), "{e}");
}

/// A search tells its parts and how far each is: fractions that never fall within a part, the last is all of it.
#[test]
fn slow_a_search_tells_how_far_it_is() {
    let take = stand_with("").unwrap();
    let spec = quick(&["tension", "pressure"], &[(0.0, 0.9)]);
    let search = Search { solver: SolverKind::CmaEs, seed: 3, evaluations: 12, start: None, step: 0.3 };
    let session = tune::Session { spec, search, slices: 2, directions: 0, figures: true, fresh: true };
    let folder = tempfile::tempdir().unwrap();
    let mut told: Vec<(String, Vec<f64>)> = Vec::new();
    let progress = takes::Progress::new(|event| match event {
        takes::Event::Part(name) => told.push((name.to_owned(), Vec::new())),
        takes::Event::Fraction(x) => told.last_mut().expect("a part").1.push(x),
        takes::Event::Note(_) => {}
    });
    let (report, _) = session
        .run(
            &take,
            &sim::core::engine(),
            Some(&EngineEntry::default()),
            folder.path(),
            &mut |_| {},
            &progress,
        )
        .unwrap();
    drop(progress);
    let parts: Vec<&str> = told.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(parts[..2], ["searching", "slicing"], "{told:?}");
    // two engines, two costs: of a body that both keep on its feet they are near each other
    let second = report.confirmed.unwrap();
    assert_eq!((report.engine.as_str(), second.engine.as_str()), ("core", "rapier"));
    let (here, there) = (&report.before, &second.before);
    assert_eq!(here.survived, there.survived);
    assert!(here != there && (here.cost - there.cost).abs() < 0.05 * there.cost, "{here:?} {there:?}");
    for (name, fractions) in &told[..2] {
        assert!(fractions.len() >= 2, "{name}: {fractions:?}");
        assert!(fractions.is_sorted() && fractions.last() == Some(&1.0), "{name}: {fractions:?}");
    }
}
