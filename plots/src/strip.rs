//! Film strips: figures evenly spaced in time, one row per motion, as [NF03] prints its results.
//!
//! In: clips of one character. Out: a [`Figure`]: solid bodies on a floor, left and right limbs in
//! different tints, times below. All rows share times, scale and viewer, so that figures above each
//! other can be compared. A motion that travels is followed; one that stays is not, so that planted
//! feet are seen to stay.
//!
//! [NF03] Neff, Fiume. Aesthetic Edits for Character Animation, SCA 2003, Fig. 3.

use dynamics::Character;
use motion::support::Vec2;
use motion::{Clip, Kinematics, Vec3};

use crate::camera::{Camera, facing};
use crate::figure::{Anchor, Figure, Px};
use crate::panel::header;
use crate::solid::{Solid, grown, shadow, solid};
use crate::style::{self, Color, INK, LABEL, MARGIN, WHITE};

/// One row of a film strip.
#[derive(Clone, Copy, Debug)]
pub struct StripRow<'a> {
    /// Stands over the row: `unedited`, `edited`, `kinematic`, `dynamic`.
    pub label: &'a str,
    /// What is shown; its skeleton is the character's.
    pub clip: &'a Clip,
}

/// How a film strip is drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct StripOptions {
    /// Figures per row, at least 1.
    pub count: usize,
    /// First moment shown, s.
    pub from_s: f64,
    /// Last moment shown, s; `None` is the end of the longest row.
    pub to_s: Option<f64>,
    /// Width of the page, px.
    pub width: f64,
    /// Greatest height of a standing body, px.
    pub body_height: f64,
    /// Who looks; `None` chooses the view in which the motion shows best.
    pub camera: Option<Camera>,
    /// Height of the floor, m; `None` is the lowest point of all figures.
    pub ground_m: Option<f64>,
    /// Title; `None` names the rows.
    pub title: Option<String>,
}

impl Default for StripOptions {
    fn default() -> Self {
        Self {
            count: 8,
            from_s: 0.0,
            to_s: None,
            width: 1600.0,
            body_height: 330.0,
            camera: None,
            ground_m: None,
            title: None,
        }
    }
}

/// Trunk, neck, head, and whatever has no side.
const MIDDLE: Color = Color(126, 138, 154);
/// Limbs on the left.
const LEFT: Color = Color(86, 146, 186);
/// Limbs on the right.
const RIGHT: Color = Color(214, 142, 92);
const FLOOR: Color = Color(240, 242, 244);
const SHADE: Color = Color(214, 219, 225);
/// Travel of the root, m, over which the viewer follows.
const FOLLOW: f64 = 0.6;

/// Figures of each row, `count` of them, evenly spaced in time. See [`film_strip_with`].
pub fn film_strip(rows: &[StripRow], character: &Character, count: usize, note: &str) -> Figure {
    film_strip_with(rows, character, note, &StripOptions { count, ..StripOptions::default() })
}

/// Film strip with options. Rows of no frames are left out; a shorter clip holds its last pose.
pub fn film_strip_with(
    rows: &[StripRow],
    character: &Character,
    note: &str,
    options: &StripOptions,
) -> Figure {
    let rows: Vec<StripRow> = rows.iter().filter(|r| r.clip.frames() > 0).copied().collect();
    let labels: Vec<&str> = rows.iter().map(|r| r.label).collect();
    let title = options.title.clone().unwrap_or_else(|| labels.join(" above "));
    let scene = Scene::new(&rows, character, options);
    let mut figure = Figure::new(options.width, 100.0);
    let top = header(&mut figure, &title, note, &[]);
    let layout = Layout::new(&scene, options, top);
    figure = Figure::new(options.width, layout.page_height(rows.len()));
    header(&mut figure, &title, note, &[]);
    for (r, row) in rows.iter().enumerate() {
        layout.floor(&mut figure, r);
        let (_, top) = layout.row(r);
        figure.text(row.label, [MARGIN + 14.0, top + LABEL + 9.0], LABEL + 2.0, INK, Anchor::Start);
        for (i, frame) in scene.rows[r].iter().enumerate() {
            layout.shadows(&mut figure, r, i, frame);
        }
        for (i, frame) in scene.rows[r].iter().enumerate() {
            layout.body(&mut figure, r, i, frame);
            let at = [layout.slot_middle(i), layout.row(r).0 + layout.under + LABEL + 6.0];
            let time = format!("{:.2} s", scene.times[i]);
            figure.text(time, at, LABEL, style::SOFT, Anchor::Middle);
        }
    }
    figure
}

/// One figure: solids back to front and shadows, m, about the figure's own origin on the floor.
struct Frame {
    solids: Vec<(Solid, Color)>,
    shadows: Vec<Vec<Vec2>>,
}

struct Scene {
    times: Vec<f64>,
    rows: Vec<Vec<Frame>>,
    /// Left, right, lowest and highest point of all figures and shadows, m.
    extent: [f64; 4],
}

impl Scene {
    fn new(rows: &[StripRow], character: &Character, options: &StripOptions) -> Self {
        let count = options.count.max(1);
        let end = rows.iter().map(|r| r.clip.duration_s()).fold(0.0, f64::max);
        let to = options.to_s.unwrap_or(end).min(end);
        let from = options.from_s.clamp(0.0, to);
        let step = (to - from) / (count - 1).max(1) as f64;
        let times: Vec<f64> = (0..count).map(|i| from + step * i as f64).collect();
        let clips: Vec<&Clip> = rows.iter().map(|r| r.clip).collect();
        let forward = clips.first().map_or(0.0, |c| facing(&c.skeleton, c.pose(0)));
        let camera = options.camera.unwrap_or_else(|| Camera::watching(&clips, forward));
        let poses: Vec<Vec<Kinematics>> =
            clips.iter().map(|c| times.iter().map(|&t| posed(c, t)).collect()).collect();

        let all = || poses.iter().flatten();
        let ground = options.ground_m.unwrap_or_else(|| lowest(all(), character));
        let start = poses.first().and_then(|r| r.first()).map_or(Vec3::zeros(), |k| k.origin(0));
        let level = |p: Vec3| Vec3::new(p.x, ground, p.z);
        let travels = all().any(|k| (level(k.origin(0)) - level(start)).norm() > FOLLOW);
        let tints = tints(character);
        let frame = |k: &Kinematics| {
            let origin = level(if travels { k.origin(0) } else { start });
            draw(k, character, &camera, ground, &tints, &camera.see(&origin))
        };
        let rows: Vec<Vec<Frame>> = poses.iter().map(|r| r.iter().map(frame).collect()).collect();

        let mut extent = [0.0f64; 4];
        for frame in rows.iter().flatten() {
            let outlines = frame.solids.iter().map(|s| &s.0.outline).chain(&frame.shadows);
            for p in outlines.flatten() {
                extent = [extent[0].min(p.x), extent[1].max(p.x), extent[2].min(p.y), extent[3].max(p.y)];
            }
        }
        Self { times, rows, extent }
    }
}

fn posed(clip: &Clip, t: f64) -> Kinematics {
    let mut q = vec![0.0; clip.skeleton.nq()];
    clip.sample(t, &mut q);
    Kinematics::new(&clip.skeleton, &q)
}

fn lowest<'a>(poses: impl Iterator<Item = &'a Kinematics>, character: &Character) -> f64 {
    let mut low = f64::INFINITY;
    for k in poses {
        for (body, world) in character.bodies.iter().zip(&k.world) {
            for p in body.shapes.iter().flat_map(|s| crate::solid::hull_points(s, world)) {
                low = low.min(p.y);
            }
        }
    }
    if low.is_finite() { low } else { 0.0 }
}

/// A tint per link, by the side of its mass in the zero pose.
fn tints(character: &Character) -> Vec<Color> {
    let skeleton = &character.skeleton;
    let zero = Kinematics::new(skeleton, &skeleton.zero_pose());
    let root = zero.origin(0).x;
    (character.bodies.iter().enumerate())
        .map(|(i, body)| match zero.point(i, &body.com).x - root {
            x if x > 0.03 => LEFT,
            x if x < -0.03 => RIGHT,
            _ => MIDDLE,
        })
        .collect()
}

fn draw(
    k: &Kinematics,
    character: &Character,
    camera: &Camera,
    ground: f64,
    tints: &[Color],
    origin: &Vec3,
) -> Frame {
    let origin = Vec2::new(origin.x, origin.y);
    let mut solids = Vec::new();
    let mut shadows = Vec::new();
    for (link, body) in character.bodies.iter().enumerate() {
        for shape in &body.shapes {
            solids.push((solid(shape, &k.world[link], camera, tints[link]), tints[link]));
            shadows.push(shadow(shape, &k.world[link], camera, ground));
        }
    }
    solids.sort_by(|a, b| a.0.near.total_cmp(&b.0.near));
    for (i, (s, _)) in solids.iter_mut().enumerate() {
        let points = s.outline.iter_mut().chain(s.facets.iter_mut().flat_map(|f| &mut f.points));
        points.for_each(|p| *p -= origin);
        let _ = i;
    }
    shadows.iter_mut().flatten().for_each(|p| *p -= origin);
    // what is far is a little paler
    let (far, near) = solids
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(f, n), s| (f.min(s.0.near), n.max(s.0.near)));
    for (s, _) in &mut solids {
        let haze = 0.22 * (near - s.near) / (near - far).max(0.3);
        s.facets.iter_mut().for_each(|f| f.color = f.color.mix(WHITE, haze));
    }
    Frame { solids, shadows }
}

/// Metres to the page.
struct Layout {
    scale: f64,
    slot: f64,
    /// What lies left of a slot's middle when its figure is centred, m.
    center: f64,
    /// px above and below the floor's origin line.
    over: f64,
    under: f64,
    top: f64,
    width: f64,
}

/// Between rows, and above a row's highest figure, px.
const ROW_GAP: f64 = 16.0;
const HEADROOM: f64 = 34.0;
const TIMES: f64 = LABEL + 20.0;

impl Layout {
    fn new(scene: &Scene, options: &StripOptions, top: f64) -> Self {
        let [left, right, low, high] = scene.extent;
        let width = options.width - 2.0 * MARGIN;
        let slot = (width - 24.0) / options.count.max(1) as f64;
        let wide = (right - left).max(1e-3);
        // the outline adds 2 px on both sides
        let scale = ((slot - 14.0) / wide).min(options.body_height / (high - low).max(1e-3)).max(1.0);
        Self {
            scale,
            slot,
            center: 0.5 * (left + right),
            over: high * scale + HEADROOM,
            under: -low * scale + 10.0,
            top: top + 4.0,
            width,
        }
    }

    fn row_height(&self) -> f64 {
        self.over + self.under + TIMES
    }

    fn page_height(&self, rows: usize) -> f64 {
        self.top + rows as f64 * (self.row_height() + ROW_GAP) - ROW_GAP + MARGIN
    }

    /// Page height of a row's floor origin, and of the row's top.
    fn row(&self, row: usize) -> (f64, f64) {
        let top = self.top + row as f64 * (self.row_height() + ROW_GAP);
        (top + self.over, top)
    }

    fn slot_middle(&self, i: usize) -> f64 {
        MARGIN + 12.0 + (i as f64 + 0.5) * self.slot
    }

    fn page(&self, row: usize, slot: usize, points: &[Vec2]) -> Vec<Px> {
        let (x, y) = (self.slot_middle(slot), self.row(row).0);
        points.iter().map(|p| [x + (p.x - self.center) * self.scale, y - p.y * self.scale]).collect()
    }

    fn floor(&self, figure: &mut Figure, row: usize) {
        let (floor, top) = self.row(row);
        let horizon = floor - (self.under * 0.9).max(12.0);
        let bottom = floor + self.under;
        figure.rectangle([MARGIN, top], [self.width, horizon - top], Color(250, 251, 252));
        figure.rectangle([MARGIN, horizon], [self.width, bottom - horizon], FLOOR);
        figure.line(vec![[MARGIN, horizon], [MARGIN + self.width, horizon]], SHADE, style::THIN);
    }

    fn shadows(&self, figure: &mut Figure, row: usize, slot: usize, frame: &Frame) {
        for s in &frame.shadows {
            figure.fill(self.page(row, slot, s), SHADE);
        }
    }

    fn body(&self, figure: &mut Figure, row: usize, slot: usize, frame: &Frame) {
        let rim = |px: f64, s: &Solid| self.page(row, slot, &grown(&s.outline, px / self.scale));
        for (s, tint) in &frame.solids {
            figure.fill(rim(1.8, s), tint.mix(INK, 0.72));
        }
        for (s, tint) in &frame.solids {
            figure.fill(rim(0.6, s), tint.mix(INK, 0.38));
            for facet in &s.facets {
                figure.fill(self.page(row, slot, &facet.points), facet.color);
            }
        }
    }
}
