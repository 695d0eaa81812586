//! Which figures a motion on a character gets.

use plots::panel::Clock;
use plots::{
    Confidence, Criteria, Figure, LatentPath, PosePair, StageColumn, Table, confidence_strip,
    dimension_criteria, force_match, momentum_match, stage_strip,
};
use retarget::{PipelineStage, Retargeted};
use takes::results::figures::{Draw, strip_view};
use takes::retargeting::Session;

use super::StudiedReport;
use super::compare::{self, Latent, ModelRow};
use super::study::{Dropped, Study};

/// Moments in the film strip.
const MOMENTS: usize = 7;
/// Dimensions whose latent paths a study draws.
const DIMENSIONS: [usize; 3] = [2, 15, 30];

/// Draws a figure with a note under its title.
type DrawNoted<'a> = Box<dyn Fn(&str) -> Result<Figure, String> + 'a>;

/// The figures of a run, in order: names, and how to draw each. Nothing is drawn yet.
pub fn figures<'a>(session: &'a Session, report: &'a StudiedReport, done: &'a Retargeted) -> Vec<Draw<'a>> {
    let note = format!(
        "{} on the {}: {}, {} key poses",
        report.run.performance, report.run.character, report.run.model, report.run.key_poses
    );
    let clock = Clock { rate_hz: done.clip.rate_hz, start_s: 0.0 };
    let mut all: Vec<Draw<'a>> = Vec::new();
    let mut add = |stem: &'static str, draw: DrawNoted<'a>| {
        let note = note.clone();
        all.push((stem, Box::new(move || draw(&note))));
    };
    add("strip_stages", Box::new(|note| Ok(strip(session, done, note))));
    add("confidence", Box::new(move |note| Ok(confidence(session, report, done, clock, note))));
    if let Some(m) = &done.momentum {
        let spin = [&m.human_spin[..], &m.character_spin];
        add(
            "momentum",
            Box::new(move |note| Ok(momentum_match(clock, [&m.human, &m.character], spin, note))),
        );
    }
    if let Some(r) = &done.refinement {
        let before = [&r.required_before[..], &r.contact_before];
        let after = [&r.required_after[..], &r.contact_after];
        let weight_n = r.weight_n;
        add("ground_force", Box::new(move |note| Ok(force_match(clock, before, after, weight_n, note))));
    }
    if !report.models.is_empty() {
        add("models", Box::new(|note| Ok(models(report, note))));
    }
    if let Some(study) = &report.study {
        add("dimensions", Box::new(|note| Ok(dimensions(study, note))));
        if let Some(dropped) = &study.dropped {
            add("strip_dropped", Box::new(|note| Ok(strip_dropped(session, done, dropped, note))));
        }
    }
    if report.run.model == "gplvm" {
        add("latent", Box::new(|note| Ok(latent(session, report, done, note))));
    }
    all
}

/// The path of the motion through the latent space it was mapped by; of a study, through those of several dimensions.
fn latent(session: &Session, report: &StudiedReport, done: &Retargeted, note: &str) -> Figure {
    let paths: Vec<Latent> = match &report.study {
        Some(study) => study.paths.iter().filter(|p| DIMENSIONS.contains(&p.dimensions)).cloned().collect(),
        None => compare::latent_path(done).into_iter().collect(),
    };
    let plane = |x: &Vec<f64>| [x[0], x.get(1).copied().unwrap_or(0.0)];
    let own = |i: usize| session.key_poses.moments[i].0 == session.performance.name;
    let panels: Vec<LatentPath> = (paths.iter())
        .map(|p| LatentPath {
            dimensions: p.dimensions,
            frames: p.frames.iter().map(plane).collect(),
            own_keys: p.keys.iter().enumerate().filter(|(i, _)| own(*i)).map(|(_, x)| plane(x)).collect(),
            other_keys: p.keys.iter().enumerate().filter(|(i, _)| !own(*i)).map(|(_, x)| plane(x)).collect(),
            jerk: p.jerk,
            jumps: p.jumps,
        })
        .collect();
    plots::latent_paths(&panels, note)
}

/// The two criteria for the latent dimension.
fn dimensions(study: &Study, note: &str) -> Figure {
    let rows: Vec<Criteria> = (study.dimensions.iter())
        .map(|d| Criteria {
            dimensions: d.dimensions,
            learned_deg: d.learned_deg,
            left_out_deg: d.left_out_deg,
            jerk_s3: d.jerk_s3,
            search_learned_deg: d.search_learned_deg,
            search_jerk_s3: d.search_jerk_s3,
        })
        .collect();
    dimension_criteria(&rows, note)
}

/// The motion mapped with all key poses and without its own.
fn strip_dropped(session: &Session, done: &Retargeted, dropped: &Dropped, note: &str) -> Figure {
    let puppet = &session.actor.puppet.character;
    let colors = &session.actor.file.colors;
    let [full, without] = &dropped.clips;
    let columns = [
        StageColumn {
            label: "human",
            clip: &done.human,
            character: &session.performance.performer.character,
            colors: &[],
        },
        StageColumn { label: "all key poses", clip: full, character: puppet, colors },
        StageColumn { label: "without its own", clip: without, character: puppet, colors },
    ];
    stage_strip(&columns, &moments(session, done), strip_view(&session.performance.strip), note)
}

/// A number of a model, if it has it.
type Number = fn(&ModelRow) -> Option<f64>;

/// The five models side by side.
fn models(report: &StudiedReport, note: &str) -> Figure {
    let columns: [(&str, Number); 5] = [
        ("at its key poses (°)", |m| Some(m.learned_deg)),
        ("pose left out (°)", |m| Some(m.left_out_deg)),
        ("performance left out (°)", |m| Some(m.performance_left_out_deg)),
        ("jerk over the human's", |m| Some(m.jerk_ratio)),
        ("force mismatch left (%)", |m| m.mismatch_left_percent),
    ];
    let cell = |x: Option<f64>| x.map_or_else(|| "–".into(), |x| format!("{x:.2}"));
    let best = |of: Number| {
        let all = report.models.iter().enumerate().filter_map(|(i, m)| Some((i, of(m)?)));
        all.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(i, _)| i)
    };
    let table = Table {
        title: "Five models".into(),
        columns: columns.iter().map(|(name, _)| (*name).into()).collect(),
        rows: (report.models.iter())
            .map(|m| (m.model.into(), columns.iter().map(|(_, of)| cell(of(m))).collect()))
            .collect(),
        best: columns.iter().map(|(_, of)| best(*of)).collect(),
    };
    plots::table(&table, note)
}

/// All key poses beside the human poses they stand for.
pub fn key_poses(session: &Session) -> Figure {
    let pairs = &session.key_poses.key_poses.pairs;
    let labels: Vec<String> =
        session.key_poses.moments.iter().map(|(of, at_s)| format!("{of} {at_s:.2} s")).collect();
    let pairs: Vec<PosePair> = (pairs.iter().zip(&labels))
        .map(|(p, label)| PosePair {
            label,
            human: (&p.performer.character, &p.human),
            character: &p.character,
        })
        .collect();
    let file = &session.actor.file;
    let note =
        format!("{}: {} pairs of {}", file.character.name, pairs.len(), session.key_poses.path.display());
    plots::pose_sheet(&pairs, &file.character, &file.colors, plots::View::default(), &note)
}

/// Moments of this motion that have a key pose, s.
fn keys_at_s(session: &Session) -> Vec<f64> {
    let own = session.key_poses.moments.iter().filter(|(of, _)| *of == session.performance.name);
    own.map(|(_, at_s)| *at_s).collect()
}

fn confidence(
    session: &Session,
    report: &StudiedReport,
    done: &Retargeted,
    clock: Clock,
    note: &str,
) -> Figure {
    let m = &done.mapping;
    let of = Confidence {
        confidence: &m.confidence,
        extrapolates: &m.extrapolates,
        jumps: &m.jumps,
        keys_at_s: &keys_at_s(session),
        suggested_at_s: &report.run.suggested.iter().map(|s| s.at_s).collect::<Vec<_>>(),
    };
    confidence_strip(clock, &of, note)
}

fn strip(session: &Session, done: &Retargeted, note: &str) -> Figure {
    let puppet = &session.actor.puppet.character;
    let mut columns = vec![StageColumn {
        label: "human",
        clip: &done.human,
        character: &session.performance.performer.character,
        colors: &[],
    }];
    for (stage, clip) in &done.stages {
        let label = match stage {
            PipelineStage::Map => "mapped",
            PipelineStage::Global => "moved by momentum",
            PipelineStage::Contact => "on the ground",
            PipelineStage::Refine => "forces matched",
        };
        columns.push(StageColumn { label, clip, character: puppet, colors: &session.actor.file.colors });
    }
    stage_strip(&columns, &moments(session, done), strip_view(&session.performance.strip), note)
}

/// Moments of a film strip (s), inside the motion: its very ends are rest.
fn moments(session: &Session, done: &Retargeted) -> Vec<f64> {
    let strip = &session.performance.strip;
    let (from, to) = (strip.from_s, strip.to_s.unwrap_or(done.clip.duration_s()));
    (0..MOMENTS).map(|i| from + (to - from) * (i as f64 + 0.6) / (MOMENTS as f64 + 0.2)).collect()
}
