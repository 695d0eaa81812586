use std::cell::RefCell; use std::rc::Rc; use std::path::Path;
use crosscheck::{bridge::Bridge, world::{Integration, MujocoWorld}};
use motion::metrics::{joint_errors, joint_rms_deg};
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let path = Path::new(&args[1]);
    let refrate: f64 = args[2].parse().unwrap();
    let bridge = Rc::new(RefCell::new(Bridge::start(Path::new("/tmp/mjvenv/bin/python")).unwrap()));
    let stage = |rate: f64| { let o = scenes::overrides::Overrides { root: Some("pinned".parse().unwrap()), rate_hz: Some(rate), ..Default::default() };
        scenes::open_with(path, None, &Default::default(), &o).unwrap() };
    let t = std::time::Instant::now();
    let s = stage(refrate);
    let i = Integration::reference(args[3].parse().unwrap());
    let mut p = s.pass(); p.ground = None; let mut run = p.start_in(|c, w, q, v| MujocoWorld::new(bridge.clone(), &i, c, w, q, v)).unwrap();
    while run.step().unwrap() {}
    let out = run.finish();
    println!("reference {:?} rows {} diverged {:?}", t.elapsed(), out.trace.rows(), out.diverged);
    let reference = out.trace.clip().resample(120.0);
    for rate in [120.0, 240.0, 480.0, 960.0] {
        let s = stage(rate);
        let mut p = s.pass(); p.substeps = Some(2); p.ground = None;
        let o = p.run(&mut |_| {}).unwrap();
        let c = o.trace.clip().resample(120.0);
        if rate == 480.0 { for e in joint_errors(&c, &reference) { if e.rms_deg > 0.01 { println!("  {} {:.4} peak {:.4}", c.skeleton.links()[e.link].name, e.rms_deg, e.peak_deg); } }
          for row in [1usize, 10, 50, 100] { let (a,b)=(c.pose(row), reference.pose(row)); println!("{row}: root {:?} {:?}", &a[..7], &b[..7]); } }
        println!("{rate}: {:.4}°", joint_rms_deg(&joint_errors(&c, &reference)));
    }
}
