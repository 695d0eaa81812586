//! Film strip of a motion on its way to another body: a column for every stage, a row for every moment, as
//! \[YAH10, Fig. 7\] shows its results.
//!
//! In: clips, each of its own character. Out: a [`Figure`]. The first column sets the viewer; a character of another
//! size is drawn as tall as that of the last column. The viewer follows every figure over the ground: height and pose
//! are compared, not place.
//!
//! \[YAH10\] Yamane, Ariki, Hodgins. Animating Non-Humanoid Characters with Human Motion Data, SCA 2010.

use bodies::Character;
use motion::{Clip, Kinematics, Vec3};

use crate::camera::{Camera, View, facing};
use crate::figure::{Anchor, Figure};
use crate::panel::header;
use crate::solid::hull_points;
use crate::strip::{Layout, Scene, StripOptions, drawn_floor, painted, posed};
use crate::style::{self, INK, LABEL, MARGIN};

/// One column.
#[derive(Clone, Copy, Debug)]
pub struct StageColumn<'a> {
    /// Stands over it: `human`, `mapped`, `moved`, …
    pub label: &'a str,
    /// What is shown.
    pub clip: &'a Clip,
    /// Whose it is.
    pub character: &'a Character,
    /// Red, green and blue per link; see [`StripOptions::colors`].
    pub colors: &'a [Option<[u8; 3]>],
}

/// Figures of each column at `times` (s), one row a moment.
///
/// `view` is where the viewer stands around the first column's body, as in [`StripOptions`].
pub fn stage_strip(columns: &[StageColumn], times: &[f64], view: View, note: &str) -> Figure {
    let title = "From the performer to the character";
    let columns: Vec<&StageColumn> = columns.iter().filter(|c| c.clip.frames() > 0).collect();
    let (Some(first), Some(last)) = (columns.first(), columns.last()) else {
        return crate::columns::empty_page(title, note, "no frames");
    };
    let camera = Camera::around(facing(&first.clip.skeleton, first.clip.pose(0)), view);
    let tall = height(last.character);
    let mut scene = Scene { times: times.to_vec(), rows: Vec::new(), extent: [0.0; 4] };
    for &t in times {
        let row = columns.iter().map(|c| {
            let (k, options) =
                (posed(c.clip, t), StripOptions { colors: c.colors.to_vec(), ..Default::default() });
            let at = k.origin(0);
            let mut frame = painted(&k, c.character, &camera, &drawn_floor(0.0), &options);
            frame.shift(&camera.project(&Vec3::new(at.x, 0.0, at.z)));
            frame.scale(tall / height(c.character));
            frame
        });
        scene.rows.push(row.collect());
    }
    scene.measure();
    let options = StripOptions {
        count: columns.len(),
        width: 300.0 * columns.len() as f64,
        body_height: 190.0,
        ..StripOptions::default()
    };
    let top = header(&mut Figure::new(options.width, 100.0), title, note, &[]) + LABEL + 14.0;
    let layout = Layout::new(&scene, &options, top);
    let mut figure = Figure::new(options.width, layout.page_height(times.len()));
    header(&mut figure, title, note, &[]);
    for (i, column) in columns.iter().enumerate() {
        figure.text(column.label, [layout.slot_middle(i), top - 4.0], LABEL + 2.0, INK, Anchor::Middle);
    }
    for (r, frames) in scene.rows.iter().enumerate() {
        layout.floor(&mut figure, r);
        let (_, top) = layout.row(r);
        let time = format!("{:.2} s", scene.times[r]);
        figure.text(time, [MARGIN + 14.0, top + LABEL + 9.0], LABEL, style::SOFT, Anchor::Start);
        for (i, frame) in frames.iter().enumerate() {
            layout.shadows(&mut figure, r, i, frame);
        }
        for (i, frame) in frames.iter().enumerate() {
            layout.body(&mut figure, r, i, frame);
        }
    }
    figure
}

/// A pair of poses on a [`pose_sheet`].
#[derive(Clone, Copy, Debug)]
pub struct PosePair<'a> {
    /// Stands under it.
    pub label: &'a str,
    /// Whose pose is on the left, and the pose.
    pub human: (&'a Character, &'a [f64]),
    /// The pose on the right.
    pub character: &'a [f64],
}

/// All key poses of a character, each beside the human pose it stands for, seen from the front with the heading
/// taken out; as many pairs in a row as there is room for.
pub fn pose_sheet(
    pairs: &[PosePair],
    character: &Character,
    colors: &[Option<[u8; 3]>],
    view: View,
    note: &str,
) -> Figure {
    const COLUMNS: usize = 7;
    let title = "Key poses";
    let tall = height(character);
    let one = |body: &Character, q: &[f64], colors: &[Option<[u8; 3]>]| {
        let k = Kinematics::new(&body.skeleton, q);
        let camera = Camera::around(facing(&body.skeleton, q), view);
        let options = StripOptions { colors: colors.to_vec(), ..Default::default() };
        let mut frame = painted(&k, body, &camera, &drawn_floor(0.0), &options);
        let at = k.origin(0);
        frame.shift(&camera.project(&Vec3::new(at.x, 0.0, at.z)));
        frame.scale(tall / height(body));
        frame
    };
    let pair = |p: &PosePair| {
        let mut left = one(p.human.0, p.human.1, &[]);
        let mut right = one(character, p.character, colors);
        left.shift(&Vec3::new(0.42 * tall, 0.0, 0.0));
        right.shift(&Vec3::new(-0.42 * tall, 0.0, 0.0));
        left.join(right);
        left
    };
    let rows = pairs.chunks(COLUMNS).map(|row| row.iter().map(pair).collect()).collect();
    let mut scene = Scene { times: Vec::new(), rows, extent: [0.0; 4] };
    scene.measure();
    let options = StripOptions { count: COLUMNS, width: 1900.0, body_height: 170.0, ..Default::default() };
    let top = header(&mut Figure::new(options.width, 100.0), title, note, &[]);
    let layout = Layout::new(&scene, &options, top);
    let mut figure = Figure::new(options.width, layout.page_height(scene.rows.len().max(1)));
    header(&mut figure, title, note, &[]);
    for (r, frames) in scene.rows.iter().enumerate() {
        layout.floor(&mut figure, r);
        for (i, frame) in frames.iter().enumerate() {
            layout.shadows(&mut figure, r, i, frame);
        }
        for (i, frame) in frames.iter().enumerate() {
            layout.body(&mut figure, r, i, frame);
            let at = [layout.slot_middle(i), layout.row(r).0 + layout.below() + LABEL + 6.0];
            let label = pairs[r * COLUMNS + i].label;
            figure.text(label, at, LABEL, style::SOFT, Anchor::Middle);
        }
    }
    figure
}

/// Height of a body at rest, m.
fn height(character: &Character) -> f64 {
    let k = Kinematics::new(&character.skeleton, &character.rest);
    let mut ends = [f64::INFINITY, f64::NEG_INFINITY];
    for (body, world) in character.bodies.iter().zip(&k.world) {
        for p in body.shapes.iter().flat_map(|s| hull_points(s, world)) {
            ends = [ends[0].min(p.y), ends[1].max(p.y)];
        }
    }
    if ends[1] > ends[0] { ends[1] - ends[0] } else { 1.0 }
}
