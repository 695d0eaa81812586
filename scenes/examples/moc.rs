use dynamics::{Model, State};
use controllers::support::{Foot, polygon};
use motion::support::ground;
fn main() {
    let path = std::env::args().nth(1).unwrap();
    let every: usize = std::env::args().nth(2).map_or(12, |s| s.parse().unwrap());
    let stage = scenes::open(path.as_ref(), None, &Default::default()).unwrap();
    let c = &stage.character;
    let model = Model::new(c, stage.physics.gravity);
    let feet = Foot::of(c, &model);
    let mut state = State::new(&model);
    let d = motion::Derivatives::new(&stage.kinematic, 1.0/15.0);
    let nv = model.nv();
    let g = stage.physics.ground.unwrap().height_m;
    println!("ground {g:.4} plants {}", stage.plants.len());
    for f in &feet { println!("{} corners {:?}", f.limb.name, f.corners.iter().map(|c| (c.0, (c.1*1e3).map(|x| x.round()))).collect::<Vec<_>>()); }
    for fr in (0..stage.kinematic.frames()).step_by(every) {
        let q = stage.kinematic.pose(fr);
        state.update(&model, q, &d.v[fr*nv..(fr+1)*nv]);
        let com = state.com(&model);
        let m = state.momentum(&model);
        let sup = polygon(&feet, &model, &state);
        print!("{:6.2} com {:7.3} {:6.3} {:7.3} v {:5.2} margin {:6.1}", fr as f64/stage.kinematic.rate_hz, com.x, com.y, com.z, m.linear.norm()/model.mass, 1e3*sup.margin(&ground(&com)));
        for f in &feet {
            let cs = f.corners_in_world(&model, &state);
            let lo = cs.iter().map(|p| p.y).fold(f64::INFINITY, f64::min) - g;
            let hi = cs.iter().map(|p| p.y).fold(-f64::INFINITY, f64::max) - g;
            let o = f.center(&model, &state);
            let near = { let s = motion::Support::of(cs.iter()); s.margin(&ground(&com)) };
            print!(" | {:6.1}..{:5.1} at {:7.3} {:7.3} u {:5.3} m {:6.1}", lo*1e3, hi*1e3, o.x, o.z, f.speed(&model,&state), near*1e3);
        }
        println!();
    }
}
