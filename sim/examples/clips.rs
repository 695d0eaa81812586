use controllers::*;
use dynamics::anthropometry::guess::*;
use dynamics::*;
use motion::*;
use std::sync::Arc;
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let tensions: Vec<f64> = args[1].split(',').map(|x| x.parse().unwrap()).collect();
    let verbose = args.len() > 3;
    let mut files: Vec<_> =
        std::fs::read_dir("../shared/mocap/bvh").unwrap().map(|e| e.unwrap().path()).collect();
    files.sort();
    let substeps: usize = args.get(2).and_then(|x| x.parse().ok()).unwrap_or(1);
    let work = |file: &std::path::Path| {
        let (clip, _) = motion::format::bvh::read_file(file, &Default::default()).unwrap();
        let (c, _) = guess_body(&clip.skeleton, &BodyOptions::default()).unwrap();
        let c = Arc::new(c);
        let map = PoseMap::new(&clip.skeleton, &c.skeleton).unwrap();
        let mut target = map.clip_to_character(&clip, &c.skeleton);
        let mut clamped = 0;
        for f in 0..target.frames() {
            if c.skeleton.clamp_to_limits(target.pose_mut(f)) {
                clamped += 1;
            }
        }
        let mut line = format!(
            "{:18} {:5} dof {} clamped {:3.0}%",
            file.file_name().unwrap().to_string_lossy(),
            clip.frames(),
            c.skeleton.nv(),
            100. * clamped as f64 / clip.frames() as f64
        );
        let mut rms = vec![];
        for &tension in &tensions {
            let goal = Goal::new(&target, 240.0);
            let setup = Setup {
                character: c.clone(),
                gravity: Vec3::y() * -9.81,
                goal,
                tracks: None,
                tension,
                plants: vec![],
                balance: BalanceSettings::default(),
                blend: GainBlend::RestAngle,
            };
            let pass = sim::Pass {
                setup,
                substeps: Some(substeps),
                root: RootMode::Pinned,
                ground: None,
                pushes: vec![],
            };
            let out = pass.run(&mut |_| {}).unwrap();
            let e = motion::metrics::joint_errors(&out.trace.clip(), &out.trace.target_clip());
            let e: Vec<_> = e.into_iter().filter(|e| c.classes[e.link] != JointClass::Wrist).collect();
            let r = motion::metrics::joint_rms_deg(&e);
            line += &format!("  T{tension}: {r:.2}{}", if out.diverged.is_some() { " DIVERGED" } else { "" });
            if verbose {
                let mut w: Vec<_> = e.iter().collect();
                w.sort_by(|a, b| b.rms_deg.total_cmp(&a.rms_deg));
                for x in w.iter().take(3) {
                    line += &format!(" {}:{:.1}", c.skeleton.links()[x.link].name, x.rms_deg);
                }
            }
            rms.push(r);
        }
        (line, rms)
    };
    let half: Vec<_> = std::thread::scope(|s| {
        let h: Vec<_> = (0..2)
            .map(|k| {
                let files = &files;
                let work = &work;
                s.spawn(move || {
                    files
                        .iter()
                        .skip(k)
                        .step_by(2)
                        .map(|f| {
                            let r = work(f);
                            eprintln!("{}", r.0);
                            r
                        })
                        .collect::<Vec<_>>()
                })
            })
            .collect();
        h.into_iter().flat_map(|h| h.join().unwrap()).collect()
    });
    for (i, t) in tensions.iter().enumerate() {
        let mut r: Vec<f64> = half.iter().map(|x| x.1[i]).collect();
        r.sort_by(f64::total_cmp);
        println!("T{t}: median {:.2} max {:?}", r[r.len() / 2], &r[r.len() - 4..]);
    }
    let grow = half.iter().filter(|x| x.1.windows(2).all(|w| w[1] > w[0])).count();
    println!("strictly growing {grow}/{}", half.len());
}
