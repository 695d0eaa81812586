use dynamics::{Model, RootMode, JointClass};
use controllers::{Goal, feed};
use motion::metrics;
fn main() {
    let mut args = std::env::args().skip(1);
    let path = args.next().unwrap();
    let only: Option<usize> = args.next().map(|s| s.parse().unwrap());
    let mut stage = scenes::open(path.as_ref(), None, &Default::default()).unwrap();
    stage.physics.root = RootMode::Free;
    let st = stage.stance.clone().unwrap();
    let rate = stage.kinematic.rate_hz;
    println!("{path}: ground {:.4}", st.ground_m);
    for (i, sp) in st.spans.iter().enumerate() {
        print!("{i:2} {:6.2}..{:6.2} {} {:?}", sp.frames.start as f64/rate, (sp.frames.end-1) as f64/rate, if sp.stands {"STANDS"} else {"steps"}, sp.stepping);
        if !sp.stands || only.is_some_and(|o| o != i) { println!(); continue; }
        let s = stage.stand(sp, st.ground_m).unwrap();
        let model = Model::new(&s.character, s.physics.gravity);
        let goal = Goal::new(&s.kinematic, s.physics.rate_hz);
        let feeds = feed::feeds(&model, &goal, st.ground_m);
        let feet = controllers::support::Foot::of(&s.character, &model);
        let mut state = dynamics::State::new(&model);
        let mut m: Vec<f64> = Vec::new(); let mut lead: f64 = 0.0; let mut cm=f64::INFINITY;
        for row in 0..goal.rows() { state.update(&model, goal.pose(row), goal.velocity(row));
            let sup = controllers::support::polygon(&feet, &model, &state);
            let c = motion::support::ground(&state.com(&model));
            cm = cm.min(sup.margin(&c));
            if let Some(f) = feeds[row] { m.push(sup.margin(&(c+f.lead))); lead = lead.max(f.lead.norm()); } else { m.push(-1.0); } }
        m.sort_by(f64::total_cmp);
        print!(" goal cop margin min {:.0} 5% {:.0} lead max {:.0} com {:.0} mm;", 1e3*m[0], 1e3*m[m.len()/20], 1e3*lead, 1e3*cm);
        let drop: f64 = (0..s.kinematic.frames()).map(|f| { let a=s.character.skeleton.position(s.kinematic.pose(f),0).y - s.character.skeleton.position(s.unedited.pose(f),0).y; a}).fold(f64::INFINITY,f64::min);
        print!(" root down {:.0} mm;", drop*1e3);
        let o = s.perform(&mut |_| {}).unwrap();
        let t = &o.trace;
        let e = metrics::joint_errors(&t.clip(), &t.target_clip());
        let legs: Vec<usize> = s.character.legs().flat_map(|l| [l.upper,l.lower,l.end]).collect();
        let up = metrics::joint_rms_deg(e.iter().filter(|e| !legs.contains(&e.link) && s.character.classes[e.link]!=JointClass::Wrist));
        let lo = metrics::joint_rms_deg(e.iter().filter(|e| legs.contains(&e.link)));
        if only.is_some() {
            for row in (0..t.rows()).step_by(24) {
                state.update(&model, goal.pose(row), goal.velocity(row));
                let c = motion::support::ground(&state.com(&model));
                let cp = c + feeds[row].map_or(motion::support::Vec2::zeros(), |f| f.lead);
                let mar = controllers::support::polygon(&feet, &model, &state).margin(&cp);
                let gv = feeds[row].map_or(motion::support::Vec2::zeros(), |f| f.rate);
                let gr = s.character.skeleton.rotation(goal.pose(row),0);
                let fwd = gr * motion::Vec3::z();
                state.update(&model, t.pose(row), &t.v[row*model.nv()..(row+1)*model.nv()]);
                let a = motion::support::ground(&state.com(&model));
                let av = motion::support::ground(&(state.momentum(&model).linear/model.mass));
                let cop = t.cop(row).map(|p| motion::support::ground(&p)).unwrap_or(a);
                let h: Vec<String> = feet.iter().map(|f| { let cs=f.corners_in_world(&model,&state); let lo=cs.iter().map(|p|p.y).fold(f64::INFINITY,f64::min); let hi=cs.iter().map(|p|p.y).fold(-f64::INFINITY,f64::max); let cs2=cs.clone(); let c3=f.center(&model,&state); let own={ let (mut s,mut a)=(0.0,motion::Vec3::zeros()); for c in t.contacts.iter().filter(|c| c.row==row && model.body_of[c.link].0==f.body) { s+=c.force.y; a+=c.point*c.force.y;} if s>1.0 {a/s} else {c3} }; let mm = motion::Support::of(cs2.iter()).margin(&motion::support::ground(&own)); let hd = f.corners_in_world(&model,&state); let load: f64 = t.contacts.iter().filter(|c| c.row==row && model.body_of[c.link].0==f.body).map(|c| c.force.y).sum(); format!("{:.0}..{:.0} {:.0}N own ({:.0} {:.0}) m {:.0} head ({:.2} {:.2})", 1e3*(lo-st.ground_m), 1e3*(hi-st.ground_m), load, 1e3*(own-c3).x, 1e3*(own-c3).z, 1e3*mm, (hd[2]-hd[0]).normalize().x, (hd[2]-hd[0]).normalize().z)}).collect();
                if row % 72 == 0 { let nv=model.nv(); let mut v: Vec<(f64,String)> = model.bodies.iter().filter(|b| b.joint.nv()>0 && b.joint.nv()<4).flat_map(|b| (0..b.joint.nv()).map(move |k| (b.v_at+k, b.link,k))).map(|(i,l,k)| (t.stop_torque[row*nv+i], format!("{}[{k}]", s.character.skeleton.links()[l].name))).collect(); v.sort_by(|a,b| b.0.abs().total_cmp(&a.0.abs())); println!("   stops {}", v.iter().take(5).map(|(x,n)| format!("{n} {x:.1}")).collect::<Vec<_>>().join(", ")); let e = s.character.legs().flat_map(|l| [l.upper,l.lower,l.end]).map(|l| { let mut d=vec![0.0; nv]; s.character.skeleton.difference(t.pose(row), goal.pose(row), 1.0, &mut d); let at=s.character.skeleton.v_at(l); format!("{} {:.1} {:.1} {:.1}", s.character.skeleton.links()[l].name, d[at].to_degrees(), d[at+1].to_degrees(), d[at+2].to_degrees())}).collect::<Vec<_>>(); println!("   err {}", e.join(", ")); }
                println!("{:5.2} e ({:5.0} {:5.0}) mm ev ({:5.2} {:5.2}) goal cop-com ({:4.0} {:4.0}) mar {:4.0} act cop-com ({:4.0} {:4.0}) | {} | fwd {:.1} {:.1}", row as f64/t.rate_hz, 1e3*(a-c).x,1e3*(a-c).y, (av-gv).x, (av-gv).y, 1e3*(cp-c).x, 1e3*(cp-c).y, 1e3*mar, 1e3*(cop-a).x, 1e3*(cop-a).y, h.join(" | "), fwd.x, fwd.z);
            }
        }
        let last = t.rows()-1;
        let r = scenes::Report::new(&s, Some(&o)).dynamic.unwrap();
        println!(" fell {:?} upper {up:.2} legs {lo:.2} deg pos {:.0} mm residual {:.3} % slip {:.1} margin {:?} last com err {:.0} mm", o.fell_s, r.position_rms_mm, r.root.residual_force_rms_percent_bw, r.feet.slip_mm_max, r.support_margin_mm_min.map(|x| x.round()), 1e3*{ let mut a=t.com_at(last); let mut st2=dynamics::State::new(&model); st2.update(&model, t.target_pose(last), &vec![0.0;model.nv()]); a-=st2.com(&model); a.norm()});
    }
}
