#![allow(missing_docs)]
use motion::format::bvh::ImportOptions;
use motion::{Kinematics, Vec3};
use retarget::contacts::{paths, phases, point_paths};
use scenes::retarget::{self, Options, Stage};
use scenes::retargeting::Session;
use std::path::{Path, PathBuf};

const CLIPS: [&str; 3] = ["16_21", "14_24", "05_03"];
fn path(name: &str) -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    if name.contains('_') {
        here.join(format!("../../shared/mocap/bvh/{name}.bvh"))
    } else {
        here.join(format!("performances/{name}.ron"))
    }
}
fn j(p: &[Vec3], i: usize) -> f64 {
    // third difference starting at i
    if i + 3 >= p.len() {
        return 0.0;
    }
    1e3 * (p[i + 3] - (p[i + 2] - p[i + 1]) * 3.0 - p[i]).norm()
}
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let asked: Vec<String> = std::env::args().skip(1).collect();
    let of = |at: usize, all: &[&str]| match asked.get(at) {
        Some(x) if x != "all" => x.split(',').map(str::to_owned).collect(),
        _ => all.iter().map(|&x| x.to_owned()).collect::<Vec<String>>(),
    };
    let every = [
        "anger",
        "dance",
        "disgust",
        "fear",
        "happiness",
        "sadness",
        "surprise",
        CLIPS[0],
        CLIPS[1],
        CLIPS[2],
    ];
    for character in of(0, &["lamp", "penguin", "squirrel"]) {
        for perf in of(1, &every) {
            let to = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("characters/{character}.ron"));
            let session = Session::open(&path(&perf), &to, None, &ImportOptions::default())?;
            let options = Options { rate_hz: Some(30.0), stop_after: Stage::Contact, ..Options::default() };
            let mapping = session.learn(&options)?;
            let done = session.run(&mapping, &options)?;
            let c = done.contact.unwrap();
            println!(
                "== {character} {perf} slip {:.2} depth {:.2} jerk {:.2}",
                1e3 * c.slip_m,
                1e3 * c.penetration_m,
                c.jerk_ratio
            );
            let puppet = &session.actor.puppet;
            let global = &done.stages.iter().find(|s| s.0 == Stage::Global).unwrap().1;
            let spans = phases::spans(puppet, &done.phases, global)?;
            let before = point_paths(puppet, global);
            let goals = paths::held_paths(puppet, &before, &spans, 30.0);
            let after = point_paths(puppet, &done.clip);
            // human points
            let performer = &session.performance.performer;
            let hc = &performer.character;
            let mut k = Kinematics::new(&hc.skeleton, &hc.skeleton.zero_pose());
            let mut human: Vec<Vec<Vec3>> = vec![vec![]; hc.contacts.len()];
            for i in 0..done.human.frames() {
                k.update(&hc.skeleton, done.human.pose(i));
                for (p, &s) in human.iter_mut().zip(&hc.contacts) {
                    let s = &hc.skeleton.sites()[s];
                    p.push(k.point(s.link, &s.at));
                }
            }
            let size = done.momentum.as_ref().unwrap().size_ratio;
            let far = before
                .iter()
                .zip(&goals)
                .flat_map(|(b, g)| b.iter().zip(g))
                .map(|(b, g)| (b - g).xz().norm())
                .fold(0.0f64, f64::max);
            println!("   far {:.0}", 1e3 * far);
            println!("   size {:.3} {:.3} {:.3}", size.x, size.y, size.z);
            let sites = puppet.character.skeleton.sites();
            let mut rows = vec![];
            let mut dump = std::fs::File::create(format!("/tmp/contact/{character}_{perf}.csv"))?;
            use std::io::Write;
            for (p, cp) in puppet.contacts.iter().enumerate() {
                let name = &sites[cp.site].name;
                let g: Vec<usize> = phases::groups(performer, puppet, cp)?.concat();
                for i in 0..before[p].len() {
                    let on = spans[p].iter().any(|s| s.first <= i && i <= s.last) as u8;
                    let h = human[g[0]][i];
                    let (b, go, a) = (before[p][i], goals[p][i], after[p][i]);
                    writeln!(
                        dump,
                        "{name},{},{i},{on},{},{},{},{},{},{},{},{},{},{},{},{}",
                        sites[cp.site].link, b.x, b.y, b.z, go.x, go.y, go.z, a.x, a.y, a.z, h.x, h.y, h.z
                    )?;
                }
                for (n, s) in spans[p].iter().enumerate() {
                    for (w, end) in [("on ", s.first), ("off", s.last)] {
                        let from = end.saturating_sub(3);
                        let to = (end + 3).min(before[p].len() - 1);
                        let r = from..(to.saturating_sub(2));
                        let pk = |q: &[Vec3]| {
                            r.clone()
                                .map(|i| (j(q, i), i))
                                .fold((0.0, 0), |a, b| if b.0 > a.0 { b } else { a })
                        };
                        let (b, go, a) = (pk(&before[p]), pk(&goals[p]), pk(&after[p]));
                        let h = g.iter().map(|&g| pk(&human[g]).0).fold(0.0, f64::max);
                        let next = spans[p].get(n + 1).map_or(0, |t| t.first as i64 - s.last as i64);
                        let prev = if n > 0 { s.first as i64 - spans[p][n - 1].last as i64 } else { 0 };
                        let gap = if w == "on " { prev } else { next };
                        let other = if w == "on " {
                            n.checked_sub(1)
                        } else {
                            Some(n + 1).filter(|&m| m < spans[p].len())
                        };
                        let way = other
                            .map_or(0.0, |m| 1e3 * (goals[p][spans[p][m].first] - goals[p][s.first]).norm());
                        let hway = other.map_or(0.0, |m| {
                            let mm = (spans[p][m].first + spans[p][m].last) / 2;
                            1e3 * (human[g[0]][mm] - human[g[0]][(s.first + s.last) / 2]).norm()
                        });
                        rows.push((a.0, format!("{name:10} {w} {end:4} len {:3} gap {gap:3} way {way:6.1} hway {hway:6.1} lift {:5.1} | src {:6.2} hum {:6.2} goal {:6.2}@{:2} res {:6.2}@{:2}",
                            s.last - s.first + 1, 1e3 * before[p][end].y, b.0, h * size.z, go.0, go.1 as i64 - end as i64, a.0, a.1 as i64 - end as i64)));
                    }
                }
            }
            rows.sort_by(|a, b| b.0.total_cmp(&a.0));
            for r in rows.iter().take(8) {
                println!("   {}", r.1);
            }
        }
    }
    Ok(())
}
