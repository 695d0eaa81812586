//! Ground forces by several witnesses, residuals and spans of traces, and analyses in other forms.

use std::sync::Arc;

use bodies::Character;
use bodies::anthropometry::human::human;
use dynamics::analysis::trace_of;
use dynamics::{
    Analysis, AnalysisOptions, FloorChoice, GroundForces, Model, RootMode, State, Trace, analyze,
};
use formats::analysis::{csv, ground_forces_mot, torques_mot, write_npz};
use motion::smooth::Smoothing;
use motion::{Clip, Kinematics, Vec3};

const RATE: f64 = 120.0;

/// The human as it stands at rest, its lowest contact point on y = 0, moved by `path` (m) over time.
fn moved(seconds: f64, path: impl Fn(f64) -> Vec3) -> (Arc<Character>, Clip) {
    let character = Arc::new(human().0);
    let skeleton = &character.skeleton;
    let k = Kinematics::new(skeleton, &character.rest);
    let soles = character.contacts.iter().map(|&c| &skeleton.sites()[c]);
    let low = soles.map(|s| k.point(s.link, &s.at).y).fold(f64::INFINITY, f64::min);
    let frames = (seconds * RATE) as usize + 1;
    let mut q = Vec::new();
    for frame in 0..frames {
        let mut pose = character.rest.clone();
        let at = skeleton.position(&pose, 0) - Vec3::y() * low + path(frame as f64 / RATE);
        skeleton.set_position(&mut pose, 0, &at);
        q.extend(pose);
    }
    let clip = Clip::new(skeleton.clone(), RATE, q);
    (character, clip)
}

fn analysis(character: &Character, clip: &Clip) -> Analysis {
    let options = AnalysisOptions {
        smoothing: Smoothing::Off,
        ground: FloorChoice::At(0.0),
        ..AnalysisOptions::default()
    };
    analyze(character, clip, &options).unwrap()
}

/// Standing, all witnesses say body weight, and the feet add up to the total.
#[test]
fn standing_is_body_weight() {
    let (character, clip) = moved(0.5, |_| Vec3::zeros());
    let a = analysis(&character, &clip);
    let required = GroundForces::required(&a);
    let (given, by) = GroundForces::given(&character, &a, 0.0015).unwrap().unwrap();
    for (name, told) in [("required", &required), ("given", &given)] {
        for (row, total) in told.total.iter().enumerate() {
            let error = total.y - a.weight(); // N; 4.5e-13 seen of the penalty model, 3.4e-13 required
            assert!(error.abs() < 1e-8 && total.x.hypot(total.z) < 1e-6, "{name} {row}: {total:?}");
            let feet: Vec3 = told.feet.iter().map(|f| f.force[row]).sum();
            assert!((feet - total).norm() < 1e-6, "{name} {row}: {feet:?} of {total:?}");
        }
    }
    // soles that lie flat rest exactly δ deep
    assert!((by.lowered_m - 0.0015).abs() < 1e-12, "{} m", by.lowered_m);
}

/// Bobbing with ±1 mm, penalty contact agrees with its own spring: m g ± n k_P z, less f_0's share.
#[test]
fn penalty_follows_the_height() {
    let (character, clip) = moved(2.0, |t| Vec3::y() * (5e-4 * (std::f64::consts::TAU * t).sin()));
    let a = analysis(&character, &clip);
    let (given, by) = GroundForces::given(&character, &a, 0.0015).unwrap().unwrap();
    let n = character.contacts.len() as f64;
    let (least, most) =
        (by.penalty.normal(-by.lowered_m + 5e-4, 0.0), by.penalty.normal(-by.lowered_m - 5e-4, 0.0));
    let mean: f64 = given.total.iter().map(|f| f.y).sum::<f64>() / given.total.len() as f64;
    assert!((mean - a.required_force.chunks(3).map(|f| f[1]).sum::<f64>() / a.frames() as f64).abs() < 1e-6);
    let peak = given.total.iter().map(|f| f.y).fold(0.0, f64::max);
    let low = given.total.iter().map(|f| f.y).fold(f64::INFINITY, f64::min);
    // 0.07 and −0.12 % seen: the damper, and turning points between frames
    assert!((peak / (n * most) - 1.0).abs() < 0.01, "{peak} of {}", n * most);
    assert!((low / (n * least) - 1.0).abs() < 0.01, "{low} of {}", n * least);
}

/// In flight nothing is required but gravity's absence, and nothing is given.
#[test]
fn nothing_is_given_in_the_air() {
    let (character, clip) = moved(1.0, |t| Vec3::y() * (0.2 + 5.0 * t - 0.5 * 9.81 * t * t));
    let a = analysis(&character, &clip);
    let required = GroundForces::required(&a);
    let worst = required.total.iter().map(|f| f.norm()).fold(0.0, f64::max);
    assert!(worst < 1e-6, "{worst} N"); // 3.1e-9 seen
    assert!(required.feet.iter().all(|f| f.force.iter().all(|x| x.norm() < 1e-6)));
}

/// The difference of two courses does not depend on their rates or where they start.
#[test]
fn differences_are_taken_at_common_times() {
    let course = |rate_hz: f64, start_s: f64, rows: usize, offset: f64| {
        let at = |row: usize| start_s + row as f64 / rate_hz;
        let total = (0..rows).map(|row| Vec3::new(offset, 100.0 * at(row) + offset, -offset)).collect();
        GroundForces { rate_hz, start_s, total, feet: Vec::new() }
    };
    let a = course(100.0, 0.0, 101, 0.0);
    for b in [course(100.0, 0.0, 101, 3.0), course(37.0, 0.2, 20, 3.0), course(240.0, -1.0, 1000, 3.0)] {
        let [up, across] = GroundForces::rms_difference([&a, &b], &a.total, &b.total).unwrap();
        assert!((up - 3.0).abs() < 1e-9 && (across - 18f64.sqrt()).abs() < 1e-9, "{up} {across}");
    }
    let later = course(100.0, 5.0, 10, 0.0);
    assert_eq!(GroundForces::rms_difference([&a, &later], &a.total, &later.total), None);
    let cut = a.between(0.25, 0.5);
    assert_eq!((cut.total.len(), cut.start_s), (26, 0.25));
    assert_eq!(cut.total[0], a.total[25]);
}

fn recorded() -> Trace {
    let (character, clip) = moved(0.5, |t| Vec3::y() * (0.01 * (9.0 * t).sin()));
    trace_of(&character, &clip, &analysis(&character, &clip))
}

/// A trace of an analysis balances: momentum changes by gravity, contacts and the residual.
#[test]
fn an_analysis_as_a_trace_balances() {
    let t = recorded();
    let mass = t.character.mass();
    let (model, sums) = (Model::new(&t.character, t.gravity), t.contact_sums());
    let mut state = State::new(&model);
    for row in 2..t.rows() - 2 {
        let p = |row: usize| Vec3::from_column_slice(&t.momentum[6 * row..6 * row + 3]);
        // forces act at the time of their row here: central differences of momentum
        let rate = (p(row - 2) - p(row - 1) * 8.0 + p(row + 1) * 8.0 - p(row + 2)) * (t.rate_hz / 12.0);
        let residual = Vec3::from_column_slice(&t.root_wrench[6 * row..6 * row + 3]);
        let left = rate - t.gravity * mass - sums[row] - residual;
        assert!(left.norm() < 1e-3 * mass * 9.81, "{row}: {left:?}"); // 0.63 N of 736 seen, the error of the difference
        state.update(&model, t.pose(row), &t.v[row * model.nv()..(row + 1) * model.nv()]);
        let (kinetic, potential) = state.energy(&model);
        assert_eq!(t.energy[2 * row..2 * row + 2], [kinetic, potential]);
    }
    assert_eq!(t.root, RootMode::Pinned);
    assert!(t.torque.chunks(model.nv()).all(|row| row[..6].iter().all(|x| *x == 0.0)));
}

/// A cut keeps rows and contacts together; the residual of a held root is what held it.
#[test]
fn cuts_and_residuals() {
    let t = recorded();
    let cut = t.cut(10..30);
    assert_eq!((cut.rows(), cut.pose(0), cut.com_at(5)), (20, t.pose(10), t.com_at(15)));
    let sums = t.contact_sums();
    assert_eq!(cut.contact_sums(), sums[10..30]);
    assert_eq!(t.residual(), t.root_wrench);
    // free, the same forces leave nothing unexplained but the order of the difference
    let mut free = t.clone();
    free.root = RootMode::Free;
    free.root_wrench.fill(0.0);
    let unexplained = free.residual();
    assert_eq!(unexplained[..6], [0.0; 6]);
    assert_eq!(unexplained.len(), 6 * free.rows());
}

/// Every column has a name, every row all columns, and numbers survive.
#[test]
fn tables_are_whole() {
    let (character, clip) = moved(0.25, |t| Vec3::y() * (0.01 * (9.0 * t).sin()));
    let a = analysis(&character, &clip);
    let text = csv(&a);
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let unique: std::collections::BTreeSet<&&str> = names.iter().collect();
    assert_eq!(unique.len(), names.len());
    let column = |name: &str| names.iter().position(|n| *n == name).unwrap_or_else(|| panic!("no {name}"));
    let rows: Vec<Vec<f64>> = lines.map(|l| l.split(',').map(|x| x.parse().unwrap()).collect()).collect();
    assert_eq!(rows.len(), a.frames());
    for (k, row) in rows.iter().enumerate() {
        assert_eq!(row.len(), names.len());
        let close = |name: &str, x: f64| {
            let error = (row[column(name)] - x).abs();
            assert!(error <= 1e-8 * x.abs().max(1e-3), "{name}, frame {k}: {} for {x}", row[column(name)]);
        };
        close("time_s", k as f64 / RATE);
        close("com_y_m", a.com[3 * k + 1]);
        close("required_force_y_N", a.required_force[3 * k + 1]);
        close(
            "knee_l_Nm",
            a.tau[k * character.skeleton.nv()
                + character.skeleton.v_at(character.skeleton.link("knee_l").unwrap())],
        );
        close("leg_l_force_y_N", a.feet[0].force[3 * k + 1]);
    }
    for mot in [torques_mot(&a), ground_forces_mot(&a)] {
        let header: Vec<&str> = mot.lines().take(6).collect();
        assert_eq!((header[1], header[4], header[5]), ("version=1", "inDegrees=no", "endheader"));
        let number = |line: &str| line.split('=').nth(1).unwrap().parse::<usize>().unwrap();
        assert_eq!(number(header[2]), a.frames());
        let body: Vec<&str> = mot.lines().skip(6).collect();
        assert_eq!(body.len(), a.frames() + 1);
        assert!(body.iter().all(|l| l.split('\t').count() == number(header[3])));
        assert!(body[0].starts_with("time\t"));
    }
}

/// The arrays of an analysis, read by another library.
#[test]
fn npz_holds_the_analysis() {
    let (character, clip) = moved(0.25, |_| Vec3::zeros());
    let a = analysis(&character, &clip);
    let mut out = std::io::Cursor::new(Vec::new());
    write_npz(&a, &mut out).unwrap();
    let mut zip = zip::ZipArchive::new(out).unwrap();
    let names: Vec<String> =
        zip.file_names().map(|n| n.unwrap().trim_end_matches(".npy").to_owned()).collect();
    let mut numbers = |name: &str| {
        let array = npyz::NpyFile::new(zip.by_name(&format!("{name}.npy")).unwrap()).unwrap();
        (array.shape().to_vec(), array.into_vec::<f64>().unwrap())
    };
    let (n, nv) = (a.frames() as u64, character.skeleton.nv() as u64);
    assert_eq!(numbers("tau"), (vec![n, nv], a.tau.clone()));
    assert_eq!(numbers("residual"), (vec![n, 6], a.residual.clone()));
    assert_eq!(numbers("foot_force").0, [2, 3 * n]);
    let units = npyz::NpyFile::new(zip.by_name("units.npy").unwrap()).unwrap();
    for name in units.into_vec::<String>().unwrap().iter().step_by(2) {
        assert!(names.contains(name), "{name} has a unit but no array");
    }
}
