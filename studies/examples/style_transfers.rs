//! The transfers of SCF06 on the nearest clips, as the table of `docs/STYLE_COMPONENTS.md`, with a film strip of each.
//!
//! `cargo run --release -p studies --example style_transfers -- CLIPS [DIR]`: CLIPS is the folder that holds `bvh` and
//! `cgspeed`; film strips go to DIR, if there is one.

use std::path::Path;
use std::time::Instant;

use motion::Clip;
use studies::style::pairs::PAIRS;
use studies::style::{HEADING, measure};
use takes::styles::Find;
use takes::styles::figures::side_by_side;
use takes::styles::style::Representation;
use takes::{Ask, open};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let clips = args.next().ok_or("the folder of clips is missing")?;
    let strips = args.next();
    let only = args.next();
    let find = Find {
        count: None,
        variance: 0.95,
        representation: Representation::Positions,
        merge: Vec::new(),
        names: Default::default(),
    };
    let mut notes = String::new();
    print!("{HEADING}");
    for pair in PAIRS.iter().filter(|p| only.as_ref().is_none_or(|o| p.name == o)) {
        let base = open(Path::new(&clips).join(pair.base), &Ask::default())?;
        let donor = open(Path::new(&clips).join(pair.donor), &Ask::default())?;
        let began = Instant::now();
        let outcome = measure(&base, &donor, pair.measures, &find, pair.components)?;
        let took = began.elapsed().as_secs_f64();
        print!("{}", outcome.row(&base.name, &donor.name));
        notes += &format!("\n{} ({took:.1} s)\n{}", pair.name, outcome.log);
        for m in outcome.moved.iter().filter(|m| !m.comes()) {
            notes += &format!("  {} at amounts 0 to 1: {:.1?}\n", m.measure.word(), m.values);
        }
        for c in 0..outcome.set.components() {
            notes += &format!("  {}: {}\n", c + 1, outcome.set.words(c));
        }
        for note in &outcome.set.notes {
            notes += &format!("  note: {note}\n");
        }
        if let Some(dir) = &strips {
            // a film strip lasts as long as its longest row: the donor is cut to the base
            let mut donor = donor.clone();
            let (clip, nq) = (&donor.asked.clip, donor.asked.clip.skeleton.nq());
            let most = (base.asked.clip.duration_s() * clip.rate_hz).round() as usize + 1;
            let count = clip.frames().min(most);
            let first = (clip.frames() - count) / 2;
            let data = clip.data()[first * nq..(first + count) * nq].to_vec();
            donor.asked.clip = Clip::new(clip.skeleton.clone(), clip.rate_hz, data);
            let rows = [
                (format!("base: {}", base.name), &base),
                (format!("{} at amount 1", pair.name), &outcome.take),
                (format!("donor: {}", donor.name), &donor),
            ];
            let same = donor.body.character.skeleton.nq() == base.body.character.skeleton.nq();
            let rows = if same { &rows[..] } else { &rows[..2] };
            if let Some(figure) = side_by_side(rows, pair.name, "one time for all rows", 9) {
                std::fs::create_dir_all(dir)?;
                figure.save(Path::new(dir), &pair.name.replace([' ', ','], "_"))?;
            }
        }
    }
    println!("{notes}");
    Ok(())
}
