//! lab
use scenes::push::*;
use sim::World;
fn main() {
    let mut a: Vec<String> = std::env::args().skip(1).collect();
    let mut stage = scenes::open_with(
        std::path::Path::new("scenes/stand.ron"),
        None,
        &Default::default(),
        &Default::default(),
    )
    .unwrap();
    let (mut n, mut tol) = (8usize, 0.04);
    let mut one = None;
    let mut table: Vec<String> = Vec::new();
    let mut quiet = false;
    let mut after = 3.5;
    let mut degs: Vec<f64> = Vec::new();
    let b = &mut stage.physics.balance;
    a.retain(|x| {
        let Some((k, v)) = x.split_once('=') else { return true };
        if k == "dirs" {
            n = v.parse().unwrap();
            return false;
        }
        if k == "table" {
            table = v.split(',').map(String::from).collect();
            return false;
        }
        if k == "quiet" {
            quiet = true;
        }
        if k == "degs" {
            degs = v.split(',').map(|x| x.parse().unwrap()).collect();
            return false;
        }
        if k == "one" {
            let (d, j) = v.split_once(',').unwrap();
            one = Some((d.parse::<f64>().unwrap(), j.parse::<f64>().unwrap()));
            return false;
        }
        let f = || v.parse::<f64>().unwrap();
        match k {
            "quiet" => (),
            "mgh" => b.ankle_stiffness = Some(f()),
            "tol" => tol = f(),
            "rate" => stage.physics.rate_hz = f(),
            "tension" => stage.physics.tension = f(),
            "shift" => b.shift = f(),
            "shift_damping" => b.shift_damping = f(),
            "shift_rate" => b.shift_rate = f(),
            "shift_limit" => b.shift_limit_m = f(),
            "pressure" => b.pressure = f(),
            "pressure_damping" => b.pressure_damping = f(),
            "margin" => b.margin_m = f(),
            "weight" => b.weight = f(),
            "wd" => b.weight_damping = f(),
            "wy" => b.weight_yield = f(),
            "least" => b.least_share = f(),
            "ws" => b.weight_shift = f() > 0.0,
            "ankle" => b.ankle = f() > 0.0,
            "hip" => b.hip = f() > 0.0,
            "hg" => b.hip_gain = f(),
            "ht" => b.hip_moment_nm = f(),
            "hs" => b.hip_stroke_rad = f(),
            "hr" => b.hip_return_rad_s = f(),
            "hp" => b.hip_pelvis = f(),
            "hss" => b.hip_side_moment_nm = f(),
            "hb" => b.hip_brake = f(),
            "hd" => b.hip_lag_s = f(),
            "after" => after = f(),

            _ => panic!("{k}"),
        }
        false
    });
    if !table.is_empty() {
        use rayon::prelude::*;
        let mut jobs = Vec::new();
        for name in &table {
            for rate in [120.0, 240.0, 480.0] {
                for tension in [0.5, 1.0, 2.0, 4.0] {
                    jobs.push((name.clone(), rate, tension));
                }
            }
        }
        if let Ok(x) = std::env::var("RT") {
            let (r, t) = x.split_once(',').unwrap();
            let (r, t): (f64, f64) = (r.parse().unwrap(), t.parse().unwrap());
            jobs.retain(|j| j.1 == r && j.2 == t);
        }
        let bal = stage.physics.balance;
        let out: Vec<String> = jobs
            .par_iter()
            .with_max_len(1)
            .map(|(name, rate, tension)| {
                let mut st = scenes::open_with(
                    std::path::Path::new(&format!("scenes/{name}.ron")),
                    None,
                    &Default::default(),
                    &Default::default(),
                )
                .unwrap();
                st.physics.balance = bal;
                st.physics.rate_hz = *rate;
                st.physics.tension = *tension;
                let o = st.perform(&mut |_| ()).unwrap();
                let t = &o.trace;
                let s = &t.character.skeleton;
                let ch = s.link("chest").unwrap();
                let mut k = motion::Kinematics::new(s, t.pose(0));
                let (mut pitch, mut slip) = (0.0f64, 0.0f64);
                let foot = |k: &motion::Kinematics| {
                    ["ankle_l", "ankle_r"].map(|n| k.point(s.link(n).unwrap(), &motion::Vec3::zeros()))
                };
                let home = foot(&k);
                for r in 0..t.rows() {
                    k.update(s, t.pose(r));
                    let y = k.world[ch].rotation * motion::Vec3::y();
                    pitch = pitch.max(y.z.atan2(y.y).to_degrees());
                    let f = foot(&k);
                    for i in 0..2 {
                        slip = slip.max((f[i] - home[i]).norm());
                    }
                }
                format!(
                    "{name} {rate} T{tension}: fell {:?} div {} pitch {pitch:.1} foot {:.1} mm raised",
                    o.fell_s,
                    o.diverged.is_some(),
                    slip * 1e3
                )
            })
            .collect();
        println!("{}", out.join("\n"));
        return;
    }
    if quiet {
        let clip = &stage.kinematic;
        let mut q = clip.data().to_vec();
        let last = clip.pose(clip.frames() - 1).to_vec();
        while q.len() < (60.5 * clip.rate_hz) as usize * last.len() {
            q.extend_from_slice(&last);
        }
        stage.kinematic = motion::Clip::new(clip.skeleton.clone(), clip.rate_hz, q);
        if let Some(t) = &mut stage.tracks {
            t.duration_s = 60.5;
        }
        let link = stage.character.skeleton.link("pelvis").unwrap();
        for (at, f) in [(20.0, motion::Vec3::z()), (40.0, motion::Vec3::x())] {
            stage.pushes.push(sim::Push {
                link,
                at: motion::Vec3::new(0.0, 0.06, 0.0),
                force: f * 10.0,
                start_s: at,
                duration_s: 0.1,
            });
        }
        let t = stage.perform(&mut |_| ()).unwrap().trace;
        let s = &t.character.skeleton;
        let r = |x: f64| ((x * t.rate_hz) as usize).min(t.rows() - 1);
        let sway = |a: f64, b: f64| {
            let n = (r(a)..r(b)).len() as f64;
            let m = (r(a)..r(b)).map(|i| t.com_at(i)).sum::<motion::Vec3>() / n;
            ((r(a)..r(b)).map(|i| (t.com_at(i) - m).norm_squared()).sum::<f64>() / n).sqrt() * 1e3
        };
        let foot = |row: usize| {
            let k = motion::Kinematics::new(s, t.pose(row));
            ["ankle_l", "ankle_r"].map(|n| k.point(s.link(n).unwrap(), &motion::Vec3::zeros()))
        };
        let creep = (0..2).map(|i| (foot(r(60.0))[i] - foot(r(1.0))[i]).norm()).fold(0.0, f64::max);
        println!(
            "rows {} com drift {:.2} mm (2..60), (2..19) {:.2}; sway 25-40 {:.3} 45-60 {:.3} 10-20 {:.3} mm; creep {:.3} mm",
            t.rows(),
            (t.com_at(r(60.0)) - t.com_at(r(2.0))).norm() * 1e3,
            (t.com_at(r(19.0)) - t.com_at(r(2.0))).norm() * 1e3,
            sway(25.0, 40.0),
            sway(45.0, 60.0),
            sway(10.0, 20.0),
            creep * 1e3
        );
        return;
    }
    let set = PushSettings { directions: n, tolerance: tol, after_s: after, ..Default::default() };
    let test = match PushTest::new(&stage, set, World::new) {
        Ok(t) => t,
        Err(e) => {
            println!("ERR {e}");
            return;
        }
    };
    if let Some((deg, times)) = one {
        let j = times * test.limit_ns(deg);
        println!("verdict {:?} limit {:.2}", test.push(deg, j).unwrap(), test.limit_ns(deg));
        let out = test.pass(deg, j).run(&mut |_| ()).unwrap();
        let t = out.trace;
        let s = &t.character.skeleton;
        let mut k = motion::Kinematics::new(s, t.pose(0));
        let r0 = t.rate_hz as usize;
        let foot = |k: &motion::Kinematics| {
            ["ankle_l", "ankle_r"].map(|n| k.point(s.link(n).unwrap(), &motion::Vec3::zeros()))
        };
        k.update(s, t.pose(r0));
        let home = foot(&k);
        let com0 = t.com_at(r0);
        let step: usize = a.first().map_or(8, |x| x.parse().unwrap());
        println!("t  com(x,z) xi(x,z) cop(x,z) Fz_l Fz_r pelvis(tilt z,x) chest(tilt z,x) feet mm");
        for r in (r0..t.rows().min(r0 + (4.0 * t.rate_hz) as usize)).step_by(step) {
            k.update(s, t.pose(r));
            let c = t.com_at(r) - com0;
            let m = motion::skeleton::vec_at(&t.momentum, 6 * r) / 75.0;
            let w = (9.81f64 / com0.y).sqrt();
            let (mut f, mut mo) = (0.0, motion::Vec3::zeros());
            let mut each = [0.0; 2];
            for x in t.contacts.iter().filter(|x| x.row == r) {
                f += x.force.y;
                mo += x.point * x.force.y;
                each[usize::from(x.point.x < 0.0)] += x.force.y;
            }
            let p = mo / f - com0;
            let up = |n: &str| {
                let l = s.link(n).unwrap();
                let y = k.world[l].rotation * motion::Vec3::y();
                (y.z.asin().to_degrees(), y.x.asin().to_degrees())
            };
            let (pe, ch) = (up("pelvis"), up("chest"));
            let fe = foot(&k);
            let d: Vec<f64> = (0..2).map(|i| (fe[i] - home[i]).norm() * 1e3).collect();
            println!(
                "{:.3} c {:6.1} {:6.1} y {:6.1} xi {:6.1} {:6.1} p {:6.1} {:6.1} F {:4.0} {:4.0} pel {:5.1} {:5.1} che {:5.1} {:5.1} feet {:4.1} {:4.1}",
                r as f64 / t.rate_hz - 1.0,
                c.x * 1e3,
                c.z * 1e3,
                c.y * 1e3,
                (c.x + m.x / w) * 1e3,
                (c.z + m.z / w) * 1e3,
                p.x * 1e3,
                p.z * 1e3,
                each[0],
                each[1],
                pe.0,
                pe.1,
                ch.0,
                ch.1,
                d[0],
                d[1]
            );
        }
        return;
    }
    if !degs.is_empty() {
        use rayon::prelude::*;
        let r: Vec<String> = degs
            .par_iter()
            .with_max_len(1)
            .map(|d| {
                let f = test.search(*d, &|_| ()).unwrap();
                format!("{d:.0}:{:.0}{}", 100.0 * f.ratio, &f.lost[..2])
            })
            .collect();
        println!("{}", r.join(" "));
        return;
    }
    let m = test.map(&|_| ()).unwrap();
    let row: Vec<String> =
        m.directions.iter().map(|d| format!("{:.0}:{:.0}{}", d.deg, 100.0 * d.ratio, &d.lost[..2])).collect();
    let ge = m.directions.iter().filter(|d| d.ratio >= 1.1).count();
    println!(
        "mean {:.1} min {:.1} ge110 {} sym {:.1} | {}",
        100.0 * m.mean_ratio,
        100.0 * m.min_ratio,
        ge,
        m.symmetry_error_percent.unwrap_or(0.0),
        row.join(" ")
    );
}
