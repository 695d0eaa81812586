use controllers::*;
use dynamics::*;
use motion::script::*;
use motion::*;
use std::sync::Arc;
fn main() {
    let (c, rep) = dynamics::anthropometry::human::human();
    println!("{rep}");
    let c = Arc::new(c);
    let s = c.skeleton.clone();
    let d = |x: f64| x.to_radians();
    let ball = |x: f64, y: f64, z: f64| EulerOrder::YZX.to_quat(&Vec3::new(d(y), d(z), d(x)));
    let deep: f64 = std::env::args().nth(1).and_then(|x| x.parse().ok()).unwrap_or(60.0);
    let tension: f64 = std::env::args().nth(2).and_then(|x| x.parse().ok()).unwrap_or(1.0);
    let rate: f64 = std::env::args().nth(3).and_then(|x| x.parse().ok()).unwrap_or(240.0);
    let rot = |n: &str, x: f64, y: f64, z: f64| PoseValue::rotation(n, ball(x, y, z));
    let script = Script {
        properties: Properties::default(),
        actions: vec![Action {
            name: "bow".into(),
            start_s: 0.5,
            properties: Properties {
                duration_s: Some(1.0),
                hold_s: Some(0.3),
                curve: Some(Curve::EaseInOut),
                ..Default::default()
            },
            cycles: vec![Cycle {
                repetitions: 1,
                properties: Properties::default(),
                poses: vec![
                    Pose {
                        properties: Properties::default(),
                        values: vec![
                            rot("pelvis", deep * 0.5, 0., 0.),
                            rot("abdomen", deep * 0.25, 0., 0.),
                            rot("chest", deep * 0.25, 0., 0.),
                            rot("neck", 15., 0., 0.),
                            rot("shoulder_r", 0., 60., 70.),
                            rot("shoulder_l", 0., 20., -80.),
                        ],
                    },
                    Pose {
                        properties: Properties::default(),
                        values: vec![
                            rot("pelvis", 0., -10., 0.),
                            rot("abdomen", -5., -10., 0.),
                            rot("chest", -5., -15., 0.),
                            rot("neck", -10., -15., 0.),
                            rot("shoulder_r", 0., 40., -50.),
                            rot("shoulder_l", 0., 0., -78.),
                            PoseValue::scalar("elbow_r", d(15.)),
                        ],
                    },
                ],
            }],
        }],
        inserts: vec![],
    };
    let mut tracks = script.build(&s, &c.rest).unwrap();
    tracks.duration_s += 2.5;
    let model = Model::new(&c, Vec3::y() * -9.81);
    let mut state = State::new(&model);
    state.update(&model, &c.rest, &vec![0.0; model.nv()]);
    let target = motion::support::ground(&state.com(&model));
    let plants: Vec<Plant> = c.legs().map(|l| Plant::here(&s, &c.rest, l)).collect();
    let mut clip = tracks.sample(rate);
    for f in 0..clip.frames() {
        let q = clip.pose_mut(f);
        s.clamp_to_limits(q);
        controllers::posture::settle(&model, &mut state, q, &plants, target).unwrap();
    }
    let goal = Goal::new(&clip, rate);
    let setup = Setup {
        character: c.clone(),
        gravity: Vec3::y() * -9.81,
        goal,
        tracks: Some(tracks),
        tension,
        plants,
        balance: BalanceSettings::default(),
        blend: GainBlend::RestAngle,
    };
    let pass = sim::Pass {
        setup,
        substeps: Some(2),
        root: RootMode::Free,
        ground: Some(sim::Ground { height_m: 0.0, friction: 0.8 }),
        pushes: vec![],
    };
    let out = pass.run(&mut |_| {}).unwrap();
    let t = &out.trace;
    println!(
        "fell {:?} diverged {:?} added {:?} wall {:.3} for {:.2}",
        out.fell_s,
        out.diverged,
        out.added_damping,
        t.wall_s,
        t.rows() as f64 / rate
    );
    for s in out.sagging.iter().take(10) {
        println!("sag {} {:.2} {:.1} < {:.1}", c.skeleton.links()[s.link].name, s.time_s, s.tension, s.least);
    }
    let sums = t.contact_sums();
    let chest = s.link("chest").unwrap();
    let mut worst: f64 = 0.0;
    let mut sq = 0.0;
    for r in 0..t.rows() {
        if r > 0 {
            let dp = (0..3)
                .map(|k| (t.momentum[6 * r + k] - t.momentum[6 * (r - 1) + k]) * rate)
                .collect::<Vec<_>>();
            let res = Vec3::new(dp[0], dp[1], dp[2]) - t.gravity * model.mass - sums[r];
            worst = worst.max(res.norm());
            sq += res.norm_squared();
        }
        if r % (rate as usize / 8) == 0 {
            let k = Kinematics::new(&s, t.pose(r));
            let kg = Kinematics::new(&s, t.target_pose(r));
            let up = (k.world[chest].rotation * Vec3::y()).angle(&Vec3::y()).to_degrees();
            let upg = (kg.world[chest].rotation * Vec3::y()).angle(&Vec3::y()).to_degrees();
            let com = t.com_at(r);
            println!(
                "t {:.2} trunk {:5.1} ({:5.1}) com {:6.3} {:6.3} ref {:6.3} cop {:?} Fy {:.0} F {:.0}",
                r as f64 / rate,
                up,
                upg,
                com.x,
                com.z,
                target.y,
                t.cop(r).map(|c| (format!("{:.3}", c.x), format!("{:.3}", c.z))),
                sums[r].y,
                sums[r].xz().norm()
            );
        }
    }
    let bw = model.mass * 9.81;
    println!("residual rms {:.4}% peak {:.3}%", (sq / t.rows() as f64).sqrt() / bw * 100., worst / bw * 100.);
    let n = t.rows();
    let last = (rate * 0.8) as usize;
    let mean: f64 = sums[n - last..].iter().map(|f| f.y).sum::<f64>() / last as f64;
    println!("mean vertical end {:.3}%", mean / bw * 100.);
}
