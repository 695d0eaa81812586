//! Laws of the analysis of clips: the books close, the ground stays admissible, noise floors are honest.

use bodies::Character;
use bodies::anthropometry::human::human;
use dynamics::{Analysis, AnalysisError, AnalysisOptions, FloorChoice, analyze};
use motion::rotation::{Vec3, exp};
use motion::skeleton::vec_at;
use motion::smooth::Smoothing;
use motion::{Clip, Joint, Support};

const RATE: f64 = 120.0;

/// Uniform numbers in (−1, 1) from a seed (SplitMix64).
struct Random(u64);

impl Random {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() * 0.5
    }
}

/// The human sways by `size` rad in every joint, the root moved by `root` (m), all shaken by `noise`.
fn swaying(
    c: &Character,
    frames: usize,
    size: f64,
    root: impl Fn(f64) -> Vec3,
    mut noise: impl FnMut() -> f64,
) -> Clip {
    let s = &c.skeleton;
    let mut q = Vec::new();
    for k in 0..frames {
        let t = k as f64 / RATE;
        let mut pose = c.rest.clone();
        for (i, link) in s.links().iter().enumerate() {
            let mut wave = |a: usize| {
                let p = (7 * i + 3 * a) as f64;
                size * (t * (3.0 + p.sin()) + p).sin() + noise()
            };
            match link.joint {
                Joint::Free | Joint::Spherical => {
                    let r = exp(&Vec3::new(wave(0), wave(1), wave(2))) * s.rotation(&pose, i);
                    s.set_rotation(&mut pose, i, &r);
                }
                Joint::Revolute(_) | Joint::Prismatic(_) => pose[s.q_at(i)] += wave(0),
                Joint::Fixed => {}
            }
        }
        let at = s.position(&pose, 0) + root(t) + Vec3::from_fn(|_, _| noise());
        s.set_position(&mut pose, 0, &at);
        q.extend(pose);
    }
    Clip::new(s.clone(), RATE, q)
}

fn off() -> AnalysisOptions {
    AnalysisOptions { smoothing: Smoothing::Off, ..AnalysisOptions::default() }
}

fn still(_: f64) -> Vec3 {
    Vec3::zeros()
}

fn max(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |m: f64, v| m.max(v.abs()))
}

/// Who stands still needs its weight from the ground, under its centre of mass, and nothing else.
#[test]
fn standing_needs_its_weight() {
    let (c, _) = human();
    let a = analyze(&c, &swaying(&c, 20, 0.0, still, || 0.0), &off()).unwrap();
    for k in 0..20 {
        let force = vec_at(&a.required_force, 3 * k);
        assert!((force - Vec3::y() * a.weight()).norm() < 1e-9); // 0 seen
        let (cop, com) = (vec_at(&a.cop, 3 * k), vec_at(&a.com, 3 * k));
        assert!((cop.x - com.x).abs() < 1e-9 && (cop.z - com.z).abs() < 1e-9);
        let shares: f64 = a.feet.iter().map(|f| f.share[k]).sum();
        assert!((shares - 1.0).abs() < 1e-12);
    }
    assert!(max(&a.residual) < 1e-9, "{}", max(&a.residual)); // 5e-15 seen
    assert!(a.flight.iter().all(|f| !f));
    assert!(a.support_violations.frames.is_empty() && a.friction_violations.frames.is_empty());
    assert_eq!(a.graded.grade(), dynamics::Grade::Good);
}

/// Required = given + residual, given = Σ feet, and the root's torques are the residual: by force and by
/// moment, frame by frame, in a motion that breaks every rule.
#[test]
fn the_books_close() {
    let (c, _) = human();
    let root = |t: f64| Vec3::new(0.3 * (5.0 * t).sin(), 0.05 * (9.0 * t).sin(), 0.2 * (4.0 * t).cos());
    let clip = swaying(&c, 240, 0.2, root, || 0.0);
    let a = analyze(&c, &clip, &AnalysisOptions { friction: 0.3, ..off() }).unwrap();
    assert!(!a.friction_violations.frames.is_empty() && !a.support_violations.frames.is_empty());
    let nv = c.skeleton.nv();
    for k in 0..a.frames() {
        let at = |t: &[f64]| vec_at(t, 3 * k);
        let (com, root) = (at(&a.com), c.skeleton.position(a.clip.pose(k), 0));
        let (mut force, mut moment) = (Vec3::zeros(), Vec3::zeros());
        for f in a.feet.iter().filter(|f| f.share[k] > 0.0) {
            force += f.force_at(k);
            moment += (at(&f.cop) - com).cross(&f.force_at(k)) + Vec3::y() * f.free_moment[k];
        }
        assert!((force - at(&a.ground_force)).norm() < 1e-10); // 2e-13 seen
        assert!((moment - at(&a.ground_moment_com)).norm() < 1e-10);
        let residual = at(&a.required_force) - force;
        let about_root = at(&a.required_moment_com) - moment + (com - root).cross(&residual);
        assert!((vec_at(&a.residual, 6 * k) - residual).norm() < 1e-10);
        assert!((vec_at(&a.residual, 6 * k + 3) - about_root).norm() < 1e-10);
        for i in 0..6 {
            assert!((a.tau[k * nv + i] - a.residual[6 * k + i]).abs() < 1e-10, "{k} {i}"); // 6e-13 seen
        }
    }
}

/// Two roads to one number: the required wrench from accelerations, and from differences of momentum.
#[test]
fn the_required_wrench_is_the_rate_of_momentum() {
    let (c, _) = human();
    let root = |t: f64| Vec3::new(0.1 * (3.0 * t).sin(), 0.05 * (5.0 * t).sin(), 0.5 * t);
    let a = analyze(&c, &swaying(&c, 240, 0.2, root, || 0.0), &off()).unwrap();
    for k in 4..236 {
        let rate = |t: &[f64]| {
            let d = |n: usize| vec_at(t, 3 * (k + n)) - vec_at(t, 3 * (k - n));
            (d(1) * 8.0 - d(2)) * (RATE / 12.0)
        };
        let force = rate(&a.com_velocity) * a.mass - a.gravity * a.mass;
        let error = (force - vec_at(&a.required_force, 3 * k)).norm();
        assert!(error < 2e-4, "{k}: {error} N"); // 2e-5 seen, of 700
        let error = (rate(&a.angular_momentum) - vec_at(&a.required_moment_com, 3 * k)).norm();
        assert!(error < 1e-4, "{k}: {error} N·m"); // 6e-6 seen
        let error = (rate(&a.com) - vec_at(&a.com_velocity, 3 * k)).norm();
        assert!(error < 2e-7, "{k}: {error} m/s"); // 2e-8 seen
    }
}

/// Whatever is asked for, the ground pushes, inside the friction cone and inside the soles.
#[test]
fn the_ground_stays_admissible() {
    let (c, _) = human();
    let root = |t: f64| Vec3::new(0.2 * (6.0 * t).sin(), 0.1 * (11.0 * t).sin(), 0.2 * (4.0 * t).cos());
    let mu = 0.25;
    let a = analyze(&c, &swaying(&c, 360, 0.15, root, || 0.0), &AnalysisOptions { friction: mu, ..off() })
        .unwrap();
    let (mut pulled, mut slid, mut left) = (0, 0, 0);
    for k in 0..a.frames() {
        let given = vec_at(&a.ground_force, 3 * k);
        let required = vec_at(&a.required_force, 3 * k);
        assert!(given.y >= 0.0 && given.xz().norm() <= mu * given.y * (1.0 + 1e-12));
        pulled += usize::from(required.y < 0.0);
        slid += usize::from(a.friction_violations.frames.contains(&k));
        left += usize::from(a.support_violations.frames.contains(&k));
        for f in a.feet.iter().filter(|f| f.share[k] > 0.0) {
            assert!(f.contact[k]);
            let corners: Vec<Vec3> = {
                let kin = motion::Kinematics::new(&c.skeleton, a.clip.pose(k));
                let sites = c.contacts.iter().map(|&i| &c.skeleton.sites()[i]);
                sites.filter(|s| s.link == f.link).map(|s| kin.point(s.link, &s.at)).collect()
            };
            let margin = Support::of(corners.iter()).margin(&vec_at(&f.cop, 3 * k).xz());
            assert!(margin > -1e-12, "{k}: {margin}"); // 1e-16 seen
            let moment = f.free_moment[k].abs();
            assert!(moment <= mu * f.force_at(k).y * 0.5, "{k}: {moment}"); // no lever beyond half a metre
        }
    }
    assert!(pulled > 5 && slid > 5 && left > 5, "{pulled} {slid} {left}: the motion must ask for too much");
}

/// In free fall nothing is needed and nothing given.
#[test]
fn free_fall_needs_nothing() {
    let (c, _) = human();
    let clip = swaying(&c, 60, 0.0, |t| Vec3::new(t, 3.0 + 2.0 * t - 4.905 * t * t, 0.0), || 0.0);
    let options = AnalysisOptions { ground: FloorChoice::At(0.0), ..AnalysisOptions::default() };
    let a = analyze(&c, &clip, &options).unwrap(); // smoothed, too: a parabola stays
    assert!(max(&a.required_force) < 1e-4 && max(&a.residual) < 1e-4, "{}", max(&a.required_force));
    assert!(a.flight.iter().all(|f| *f) && a.cop.iter().all(|x| x.is_nan()));
    assert!(max(&a.tau) < 1e-4);
}

/// Without ground the whole required wrench is residual, and the root's torques say so.
#[test]
fn without_ground_everything_is_residual() {
    let (c, _) = human();
    let clip = swaying(&c, 30, 0.1, still, || 0.0);
    let a = analyze(&c, &clip, &AnalysisOptions { ground: FloorChoice::None, ..off() }).unwrap();
    assert_eq!(a.residual, a.root_wrench);
    assert_eq!(a.ground_m, None);
    assert!(a.flight.iter().all(|f| *f) && max(&a.ground_force) == 0.0);
}

/// Noise of known size: what it makes of torques and of the root's force is what the floor says.
#[test]
fn the_noise_floor_is_what_noise_does() {
    let (c, _) = human();
    let options = AnalysisOptions {
        smoothing: Smoothing::CutoffHz(8.0),
        ground: FloorChoice::None,
        soft_tissue: 0.0,
        ..AnalysisOptions::default()
    };
    let clean = analyze(&c, &swaying(&c, 360, 0.1, still, || 0.0), &options).unwrap();
    let mut random = Random(5);
    let noisy = analyze(&c, &swaying(&c, 360, 0.1, still, || 5e-4 * random.normal()), &options).unwrap();
    let nv = c.skeleton.nv();
    let rms = |a: &[f64], b: &[f64], columns: usize, i: usize| {
        let d = |k: usize| a[k * columns + i] - b[k * columns + i];
        // the free ends are noisier than the middle
        let inner = 30..330;
        (inner.clone().map(|k| d(k).powi(2)).sum::<f64>() / inner.len() as f64).sqrt()
    };
    for i in 0..nv {
        let ratio = noisy.noise.tau[i] / rms(&noisy.tau, &clean.tau, nv, i);
        assert!((0.6..1.6).contains(&ratio), "dof {i}: floor {} ratio {ratio}", noisy.noise.tau[i]); // 0.93 to 1.43 seen
    }
    for i in 0..3 {
        let ratio = noisy.noise.force / rms(&noisy.required_force, &clean.required_force, 3, i);
        assert!((0.6..1.6).contains(&ratio), "axis {i}: {ratio}"); // 1.01 to 1.12 seen
    }
    // a tenth of the noise, a tenth of the floor
    let mut random = Random(5);
    let quiet = analyze(&c, &swaying(&c, 360, 0.1, still, || 5e-5 * random.normal()), &options).unwrap();
    let ratio = noisy.noise.tau[10] / quiet.noise.tau[10];
    assert!((8.0..12.0).contains(&ratio), "{ratio}");
}

/// Noise of two joints that compensate each other: the floor of what lies below them knows that they do.
#[test]
fn the_noise_floor_knows_what_cancels() {
    let (c, _) = human();
    let options = AnalysisOptions {
        smoothing: Smoothing::CutoffHz(8.0),
        ground: FloorChoice::None,
        soft_tissue: 0.0,
        ..AnalysisOptions::default()
    };
    let s = &c.skeleton;
    // a ball that hangs on a ball
    let ball = |i: usize| s.links()[i].joint == Joint::Spherical;
    let upper = (1..s.links().len()).find(|&i| ball(i) && s.links()[i].parent.is_some_and(ball)).unwrap();
    let lower = s.links()[upper].parent.unwrap();
    let shaken = |sign: f64| {
        let mut random = Random(21);
        let mut clip = swaying(&c, 360, 0.0, still, || 0.0);
        for k in 0..360 {
            let turn = Vec3::x() * (1e-3 * random.normal());
            for (link, turn) in [(lower, turn), (upper, turn * sign)] {
                let r = exp(&turn) * s.rotation(clip.pose(k), link);
                s.set_rotation(clip.pose_mut(k), link, &r);
            }
        }
        clip
    };
    let clean = analyze(&c, &swaying(&c, 360, 0.0, still, || 0.0), &options).unwrap();
    let nv = s.nv();
    let mut floors = Vec::new();
    for sign in [-1.0, 1.0] {
        let a = analyze(&c, &shaken(sign), &options).unwrap();
        let i = s.v_at(lower);
        let error = (30..330).map(|k| (a.tau[k * nv + i] - clean.tau[k * nv + i]).powi(2)).sum::<f64>();
        let ratio = a.noise.tau[i] / (error / 300.0).sqrt();
        assert!((0.6..1.6).contains(&ratio), "sign {sign}: {ratio}");
        floors.push(a.noise.tau[i]);
    }
    // two standard deviations alone would give the same floor both times
    assert!(floors[1] > 1.5 * floors[0], "{floors:?}");
}

/// The same clip twice: the same numbers to the bit.
#[test]
fn analysis_is_deterministic() {
    let (c, _) = human();
    let mut random = Random(9);
    let clip = swaying(&c, 200, 0.1, still, || 1e-3 * random.normal());
    let bits = |a: &Analysis| -> Vec<u64> {
        [&a.tau, &a.residual, &a.cop, &a.feet[0].cop]
            .iter()
            .flat_map(|t| t.iter().map(|x| x.to_bits()))
            .collect()
    };
    let run = || analyze(&c, &clip, &AnalysisOptions::default()).unwrap();
    let (a, b) = (
        run(),
        std::thread::spawn({
            let (c, clip) = (c.clone(), clip.clone());
            move || analyze(&c, &clip, &AnalysisOptions::default()).unwrap()
        })
        .join()
        .unwrap(),
    );
    assert_eq!(bits(&a), bits(&b));
}

/// Every bad input has its own words.
#[test]
fn bad_input_is_refused_by_name() {
    let (c, _) = human();
    let clip = swaying(&c, 30, 0.1, still, || 0.0);
    let with = |f: &dyn Fn(&mut AnalysisOptions)| {
        let mut options = AnalysisOptions::default();
        f(&mut options);
        analyze(&c, &clip, &options).unwrap_err().to_string()
    };
    assert_eq!(with(&|o| o.friction = -0.1), "friction is -0.1; it must be zero or more");
    assert_eq!(
        with(&|o| o.smoothing = Smoothing::CutoffHz(0.0)),
        "the cut-off frequency is 0; it must be positive"
    );
    assert_eq!(
        with(&|o| o.ground = FloorChoice::At(f64::NAN)),
        "the height of the ground is NaN; it must be a finite number"
    );
    assert_eq!(with(&|o| o.contact.speed_m_s = 0.0), "the speed of contact is 0; it must be positive");
    assert_eq!(
        with(&|o| o.soft_tissue = f64::INFINITY),
        "the soft tissue's noise is inf; it must be zero or more"
    );
    let mut broken = clip.clone();
    broken.pose_mut(17)[3] = f64::NAN;
    let error = analyze(&c, &broken, &AnalysisOptions::default()).unwrap_err();
    assert_eq!(error, AnalysisError::NotFinite { frame: 17 });
    let short = Clip::new(c.skeleton.clone(), RATE, clip.data()[..2 * c.skeleton.nq()].to_vec());
    let error = analyze(&c, &short, &AnalysisOptions::default()).unwrap_err();
    assert_eq!(error.to_string(), "the clip has 2 frames; an acceleration needs at least 3");
}
