//! Speed of retargeting, one core: 7 minutes at 30 Hz on each character that ships, stage by stage; the refinement by the
//! length of the clip.
//!
//! `cargo bench -p studies --bench retargeting`. The paper's system needed 70 minutes for its 7 minutes of animation
//! \[YAH10, §6\]. Seconds are of processor time where the system tells it (Linux), of the clock elsewhere.

use std::time::Instant;

use formats::bvh::ImportOptions;
use motion::{Clip, Smoothing};
use retarget::contacts::{adjust_in_time, phases};
use retarget::mapping::map_clip;
use retarget::pipeline::smoothed;
use retarget::refine::refine;
use retarget::{Live, Options, RefineDofs, RefineOptions, global_transform, prepare, sway};
use takes::retargeting::Session;

const RATE_HZ: f64 = 30.0;
const SECONDS: f64 = 420.0;
const PERFORMANCES: [&str; 7] = ["anger", "dance", "disgust", "fear", "happiness", "sadness", "surprise"];

/// A stop watch of this thread.
struct Watch(Instant, Option<f64>);

impl Watch {
    fn processor_s() -> Option<f64> {
        let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
        Some(text.split_whitespace().next()?.parse::<f64>().ok()? * 1e-9)
    }

    fn start() -> Self {
        Self(Instant::now(), Self::processor_s())
    }

    fn seconds(&self) -> f64 {
        match (self.1, Self::processor_s()) {
            (Some(a), Some(b)) => b - a,
            _ => self.0.elapsed().as_secs_f64(),
        }
    }
}

fn session(performance: &str, character: &str) -> Session {
    let of = support::scene(&format!("performances/{performance}.ron"));
    let to = support::scene(&format!("characters/{character}.ron"));
    Session::open(&of, &to, None, &ImportOptions::default()).unwrap()
}

/// All performances one after the other, there and back again, for so long.
fn long(seconds: f64) -> Clip {
    let mut frames: Vec<Vec<f64>> = Vec::new();
    let mut skeleton = None;
    for name in PERFORMANCES {
        let s = session(name, "lamp");
        let ground = Some(s.performance.ground_m);
        let p = &s.performance;
        let clip = prepare(&p.clip, &p.performer, Some(RATE_HZ), Smoothing::Auto, ground).unwrap();
        frames.extend((0..clip.frames()).map(|i| clip.pose(i).to_vec()));
        skeleton.get_or_insert(clip.skeleton);
    }
    let n = frames.len();
    let back = |i: usize| {
        let k = i % (2 * n - 2);
        if k < n { k } else { 2 * n - 2 - k }
    };
    let q = (0..(seconds * RATE_HZ) as usize).flat_map(|i| frames[back(i)].clone()).collect();
    Clip::new(skeleton.unwrap(), RATE_HZ, q)
}

fn main() {
    let raw = long(SECONDS);
    let options = Options { smoothing: Smoothing::Auto, ..Options::default() };
    let mut whole = 0.0;
    println!(
        "{SECONDS} s at {RATE_HZ} Hz      prepare  learn    map global contact   sway refine |  total, s | mapping, frames/s"
    );
    for character in ["lamp", "penguin", "squirrel"] {
        let s = session("dance", character);
        let (performer, puppet) = (&s.performance.performer, &s.actor.puppet);
        let mut times = Vec::new();
        let mut lap = Watch::start();
        let mut stage = |times: &mut Vec<f64>| {
            times.push(lap.seconds());
            lap = Watch::start();
        };
        let human = prepare(&raw, performer, None, Smoothing::Auto, Some(0.0)).unwrap();
        stage(&mut times);
        let mapping = s.learn(&options).unwrap();
        stage(&mut times);
        let (mapped, report) = map_clip(&mapping, performer, &human, puppet).unwrap();
        let mapped = smoothed(mapped, options.mapped);
        stage(&mut times);
        let (moved, _) = global_transform(performer, &human, puppet, &mapped, &options.global);
        stage(&mut times);
        let found = phases::find(performer, &human, puppet, &options.contact).unwrap();
        let found = phases::without_flipped_feet(puppet, &moved, &found).unwrap();
        let (found, held, _) = adjust_in_time(puppet, &moved, &found, &options.contact).unwrap();
        stage(&mut times);
        let (swung, _) = sway(puppet, &held, options.world.gravity_m_s2);
        stage(&mut times);
        let mut refinement = options.refine.clone();
        refinement.accepted.extend(mapping.poses.iter().cloned());
        refine(puppet, &swung, &found, &report.variance, &options.world, &refinement).unwrap();
        stage(&mut times);
        let total: f64 = times.iter().sum();
        whole += total;
        let each: Vec<String> = times.iter().map(|t| format!("{t:6.2}")).collect();
        println!(
            "{character:20} {} | {total:8.2}  | {:.0}",
            each.join(" "),
            human.frames() as f64 / times[2]
        );

        // live: the slowest frame is the latency
        let mut live = Live::new(&mapping, performer, puppet, RATE_HZ, &options).unwrap();
        let mut worst = 0.0f64;
        let (watch, frames) = (Watch::start(), human.frames().min(3000));
        for i in 0..frames {
            // processor time is told in steps of milliseconds
            let frame = Instant::now();
            live.step(human.pose(i)).unwrap();
            worst = worst.max(frame.elapsed().as_secs_f64());
        }
        let mean = watch.seconds() / frames as f64;
        println!("    live: {:.2} ms a frame on average, {:.2} ms the slowest", 1e3 * mean, 1e3 * worst);
    }
    println!("all three: {whole:.1} s for {:.0} minutes of animation each", SECONDS / 60.0);

    println!("\nrefinement by length of the clip");
    for character in ["lamp", "squirrel"] {
        let s = session("dance", character);
        let (performer, puppet) = (&s.performance.performer, &s.actor.puppet);
        let mapping = s.learn(&options).unwrap();
        for dofs in [RefineDofs::RootHeight, RefineDofs::RootAndLegs] {
            for seconds in [10.0, 100.0, 1000.0] {
                let human = long(seconds);
                let (mapped, report) = map_clip(&mapping, performer, &human, puppet).unwrap();
                let mapped = smoothed(mapped, options.mapped);
                let (moved, _) = global_transform(performer, &human, puppet, &mapped, &options.global);
                let found = phases::find(performer, &human, puppet, &options.contact).unwrap();
                let found = phases::without_flipped_feet(puppet, &moved, &found).unwrap();
                let (found, held, _) = adjust_in_time(puppet, &moved, &found, &options.contact).unwrap();
                let mut refinement = RefineOptions { dofs: dofs.clone(), ..options.refine.clone() };
                refinement.accepted.extend(mapping.poses.iter().cloned());
                let watch = Watch::start();
                refine(puppet, &held, &found, &report.variance, &options.world, &refinement).unwrap();
                let took = watch.seconds();
                println!(
                    "{character:8} {dofs:?}, {seconds:6} s: {took:8.3} s, {:.1} ms a second",
                    1e3 * took / seconds
                );
            }
        }
    }
}
