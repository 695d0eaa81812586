//! Bodies for real skeletons: the motion-capture clips and the BVH files in the wild of `../shared`.

use std::path::{Path, PathBuf};

use dynamics::anthropometry::{Anatomy, Role};
use dynamics::{BodyOptions, PoseMap, guess_body};
use motion::format::bvh::{ImportOptions, read_file};
use motion::{Clip, Kinematics};

fn shared(folder: &str) -> Vec<PathBuf> {
    let dir = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared").join(folder);
    let mut files: Vec<_> = std::fs::read_dir(&dir)
        .unwrap_or_else(|e| panic!("{}: {e}", dir.display()))
        .map(|f| f.unwrap().path())
        .filter(|p| p.extension().is_some_and(|e| e == "bvh"))
        .collect();
    files.sort();
    files
}

fn clip(path: &Path) -> Clip {
    read_file(path, &ImportOptions::default()).unwrap_or_else(|e| panic!("{}: {e}", path.display())).0
}

fn stem(path: &Path) -> String {
    path.file_stem().unwrap().to_string_lossy().into_owned()
}

#[test]
fn print_bodies() {
    for folder in ["mocap/bvh", "mocap/cgspeed", "bvh-zoo"] {
        for path in shared(folder) {
            let clip = clip(&path);
            match guess_body(&clip.skeleton, &BodyOptions::default()) {
                Ok((c, r)) => {
                    let foot = c.skeleton.limb("leg_l").unwrap().end;
                    let map = PoseMap::new(&clip.skeleton, &c.skeleton).unwrap();
                    let mut q = c.skeleton.zero_pose();
                    let mut low: Vec<f64> = (0..clip.frames())
                        .map(|f| {
                            map.to_character(clip.pose(f), &mut q);
                            let k = Kinematics::new(&c.skeleton, &q);
                            c.contacts
                                .iter()
                                .map(|&s| &c.skeleton.sites()[s])
                                .map(|s| k.point(s.link, &s.at).y)
                                .fold(9.0, f64::min)
                        })
                        .collect();
                    low.sort_by(f64::total_cmp);
                    println!(
                        "{:<36} stature {:.3} mass {:.1} com {:.3} sole {:?} low min {:.3} median {:.3}",
                        stem(&path),
                        r.stature,
                        r.mass,
                        r.com_height,
                        c.bodies[foot].shapes,
                        low[0],
                        low[low.len() / 2]
                    );
                    if stem(&path) == "16_16" {
                        println!("{r}");
                    }
                }
                Err(e) => println!("{:<36} {e}", stem(&path)),
            }
        }
    }
}

#[test]
fn print_clamped() {
    let mut span: std::collections::BTreeMap<String, Vec<[f64; 3]>> = Default::default();
    let mut worst: Vec<(f64, String)> = Vec::new();
    let mut total = std::collections::BTreeMap::new();
    for path in shared("mocap/bvh") {
        let clip = clip(&path);
        let (c, _) = guess_body(&clip.skeleton, &BodyOptions::default()).unwrap();
        let map = PoseMap::new(&clip.skeleton, &c.skeleton).unwrap();
        let roles = Anatomy::of(&clip.skeleton).unwrap().roles;
        let mut q = c.skeleton.zero_pose();
        for (i, link) in c.skeleton.links().iter().enumerate() {
            let Some(motion::Limits::Ball(b)) = link.limits else { continue };
            let mut n = [0usize; 3];
            let mut any = 0;
            let mut lo = [f64::MAX; 3];
            let mut hi = [f64::MIN; 3];
            for f in 0..clip.frames() {
                map.to_character(clip.pose(f), &mut q);
                let phi = b.coords(&c.skeleton.rotation(&q, i));
                if !path.ends_with("05_06.bvh") {
                    span.entry(format!("{:?} {}", roles[i], link.name)).or_default().push([
                        phi[0].to_degrees(),
                        phi[1].to_degrees(),
                        phi[2].to_degrees(),
                    ]);
                }
                let mut bad = false;
                for k in 0..3 {
                    lo[k] = lo[k].min(phi[k].to_degrees());
                    hi[k] = hi[k].max(phi[k].to_degrees());
                    if !b.ranges[k].contains(phi[k]) {
                        n[k] += 1;
                        bad = true;
                    }
                }
                any += usize::from(bad);
            }
            let t = total.entry(format!("{:?}", roles[i])).or_insert((0usize, 0usize));
            t.0 += any;
            t.1 += clip.frames();
            let fr = any as f64 / clip.frames() as f64;
            if fr > 0.0 {
                let r: Vec<_> = (0..3)
                    .map(|k| {
                        format!(
                            "[{:.0} {:.0}] seen [{:.0} {:.0}] {}",
                            b.ranges[k].lo.to_degrees(),
                            b.ranges[k].hi.to_degrees(),
                            lo[k],
                            hi[k],
                            n[k]
                        )
                    })
                    .collect();
                worst.push((fr, format!("{} {} {}", stem(&path), link.name, r.join(" | "))));
            }
        }
    }
    worst.sort_by(|a, b| b.0.total_cmp(&a.0));
    for (f, s) in worst.iter().take(70) {
        println!("{:5.1}% {s}", f * 100.0);
    }
    for (k, v) in &span {
        let mut t = k.clone();
        for a in 0..3 {
            let mut x: Vec<f64> = v.iter().map(|p| p[a]).collect();
            x.sort_by(f64::total_cmp);
            let n = x.len();
            t += &format!(
                " | {:.0} {:.0} {:.0} {:.0} {:.0}",
                x[0],
                x[n / 50],
                x[n / 2],
                x[n - n / 50],
                x[n - 1]
            );
        }
        println!("{t}");
    }
    println!("{total:?}");
}
#[test]
fn print_foot() {
    for n in ["16_16", "05_03", "49_07"] {
        let p = shared("mocap/bvh").into_iter().find(|p| stem(p) == n).unwrap();
        let clip = clip(&p);
        let s = &clip.skeleton;
        for f in (0..clip.frames()).step_by(20) {
            let k = Kinematics::new(s, clip.pose(f));
            let o = |n: &str| k.origin(s.link(n).unwrap());
            let shin = (o("LeftFoot") - o("LeftLeg")).normalize();
            let foot = (o("LeftToeBase") - o("LeftFoot")).normalize();
            print!("{:.0} ", shin.angle(&foot).to_degrees());
        }
        println!("{n}");
    }
}
