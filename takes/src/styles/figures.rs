//! Figures of style components: all of them as motions (SCF06 Fig. 2), their activations, amounts side by side (Fig. 7).

use edits::style::StyleSet;
use edits::style::figure::Match;
use motion::Clip;
use plots::figure::Figure;
use plots::strip::{StripOptions, StripRow, film_strip_with};
use plots::style_components::{ActivationPanel, activations};

use crate::Take;

/// Seconds of each clip on a contact sheet.
const SHOWN_S: f64 = 3.0;
/// Figures of a row of a contact sheet.
const COUNT: usize = 12;

/// A clip of the set's bones on the body of the take that they are of.
fn on_body(take: &Take, set: &StyleSet, postures: &edits::style::figure::Postures) -> Clip {
    let skeleton = &take.asked.clip.skeleton;
    let mut clip =
        Clip::new(skeleton.clone(), postures.rate_hz, take.body.character.rest.repeat(postures.frames()));
    // in place, seen from the side
    for f in 0..clip.frames() {
        let q = clip.pose_mut(f);
        let height = skeleton.position(q, 0).y;
        skeleton.set_position(q, 0, &(motion::Vec3::y() * height));
    }
    if let Ok(matched) = Match::of(&set.figure, skeleton, &std::collections::BTreeMap::new()) {
        postures.write(&mut clip, &matched, 0.0);
    }
    clip
}

/// Frames of a joined clip that are shown: the middle seconds of each of the two.
fn shown(set: &StyleSet) -> Vec<usize> {
    let most = (SHOWN_S * set.rate_hz) as usize;
    let part = |first: usize, frames: usize| {
        let count = frames.min(most);
        let from = first + (frames - count) / 2;
        from..from + count
    };
    part(0, set.frames[0]).chain(part(set.frames[0], set.frames[1])).collect()
}

/// Height of a figure of a contact sheet, pixels.
pub const BODY_HEIGHT: f64 = 190.0;

/// All components as motions, each with its words: the joined clip, all components together, then one row for each. The
/// left half is the first clip, the right half the second. `take`: a take of the first clip; `body_height`: of a figure, in pixels
/// ([`BODY_HEIGHT`] on its own page).
pub fn contact_sheet(take: &Take, set: &StyleSet, title: &str, body_height: f64) -> Figure {
    let frames = shown(set);
    let cut = |u: nalgebra::DMatrix<f64>| u.select_rows(&frames);
    let mut rows: Vec<(String, Clip)> = vec![(
        format!(
            "all {} components together ({:.1} % of the variance)",
            set.components(),
            100.0 * set.explained
        ),
        on_body(take, set, &set.postures(&cut(set.activations.clone()))),
    )];
    for c in 0..set.components() {
        let label = format!("{}: {}", c + 1, set.words(c));
        rows.push((label, on_body(take, set, &set.postures(&cut(set.alone(c))))));
    }
    let strip: Vec<StripRow> = rows.iter().map(|(label, clip)| StripRow::new(label, clip)).collect();
    let options = StripOptions {
        count: COUNT,
        body_height,
        title: Some(title.into()),
        ground_m: Some(0.0),
        ..StripOptions::default()
    };
    let note = format!(
        "each row is one component alone, the others at their mean, over the middle {SHOWN_S:.0} s of {} (left half) and of {} (right half), in place",
        set.names[0], set.names[1]
    );
    film_strip_with(&strip, &take.body.character, &note, &options)
}

/// Activations over time, one panel for each component, the clips one after the other.
pub fn activation_plot(set: &StyleSet) -> Figure {
    let panels: Vec<ActivationPanel> = (0..set.components())
        .map(|c| ActivationPanel {
            title: format!("{}: {}", c + 1, set.words(c)),
            curves: set.groups[c]
                .iter()
                .map(|i| [0, 1].map(|clip| set.of_clip(clip).column(*i).iter().copied().collect()))
                .collect(),
        })
        .collect();
    activations(&panels, [&set.names[0], &set.names[1]], set.rate_hz)
}

/// Takes one above the other, each with its label: amounts of a style (SCF06 Fig. 7), or styles of one clip.
pub fn side_by_side(rows: &[(String, &Take)], title: &str, note: &str, count: usize) -> Option<Figure> {
    let first = rows.first()?.1;
    let strip: Vec<StripRow> =
        rows.iter().map(|(label, take)| StripRow::new(label, &take.asked.clip)).collect();
    let options = StripOptions {
        count,
        body_height: 230.0,
        title: Some(title.into()),
        ground_m: super::floor_m(first),
        colors: first.body.colors.clone(),
        ..StripOptions::default()
    };
    Some(film_strip_with(&strip, &first.body.character, note, &options))
}
