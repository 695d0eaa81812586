//! Film strips: figures evenly spaced in time, one row per motion, as [NF03, Fig. 3] prints its results.
//!
//! In: clips of one character. Out: a [`Figure`]: solid bodies on a floor, left and right limbs in
//! different tints, times below. All rows share times, scale and viewer, so that figures above each
//! other can be compared. A motion that travels is followed; one that stays is not, so that planted
//! feet are seen to stay. Where the ground is tilted each figure stands on a plate as steep as it then is. A figure that is
//! farther from the ground than a jump goes is drawn on the floor line without a shadow, and how far it is stands under it.
//!
//! Source: Neff, Fiume. Aesthetic Edits for Character Animation, SCA 2003 (NF03).

use bodies::{Character, JointClass, Prop};
use motion::support::Vec2;
use motion::{Clip, ContactPlan, Floor, Joint, Kinematics, Quat, Shape, Transform, Vec3};

use crate::camera::{Camera, View, facing};
use crate::columns::stands;
use crate::face::{Face, Feature};
use crate::figure::{Anchor, Figure, Px};
use crate::panel::{Bar, bars_height, draw_bars, header};
use crate::solid::{BANDS, Facet, Solid, flat, grown, shadow, skin, solid};
use crate::style::{self, Color, INK, LABEL, MARGIN, WHITE};

/// One row of a film strip.
#[derive(Clone, Copy, Debug)]
pub struct StripRow<'a> {
    /// Stands over the row: `unedited`, `edited`, `kinematic`, `dynamic`.
    pub label: &'a str,
    /// What is shown; its skeleton is the character's.
    pub clip: &'a Clip,
    /// Normal of the ground in every frame, or one that holds throughout; empty is level.
    pub ups: &'a [Vec3],
    /// What stands when, by the clock of the clip: bars under the row. `None` draws none.
    pub plan: Option<&'a ContactPlan>,
}

impl<'a> StripRow<'a> {
    /// On level ground.
    pub fn new(label: &'a str, clip: &'a Clip) -> Self {
        Self { label, clip, ups: &[], plan: None }
    }

    /// On ground with these normals.
    pub fn on(self, ups: &'a [Vec3]) -> Self {
        Self { ups, ..self }
    }

    /// With bars for what stands when.
    pub fn standing(self, plan: &'a ContactPlan) -> Self {
        Self { plan: Some(plan), ..self }
    }

    /// Normal of the ground at a time.
    fn up(&self, t: f64) -> Vec3 {
        let frame = (t * self.clip.rate_hz).round().max(0.0) as usize;
        self.ups.get(frame).or(self.ups.last()).copied().unwrap_or(Vec3::y())
    }
}

/// How a film strip is drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct StripOptions {
    /// Figures per row, at least 1.
    pub count: usize,
    /// Width of the page, px.
    pub width: f64,
    /// Greatest height of a standing body, px.
    pub body_height: f64,
    /// Where the viewer stands around the body of the first row.
    pub view: View,
    /// First moment shown, s of the clips.
    pub from_s: f64,
    /// Last moment shown, s of the clips; `None` is the end of the longest.
    pub to_s: Option<f64>,
    /// Height of the floor, of tilted ground under the world's origin, m; `None` is the lowest point of all figures.
    pub ground_m: Option<f64>,
    /// Title; `None` names the rows.
    pub title: Option<String>,
    /// Boxes and ramps of the world: what of them is near each figure.
    pub props: Vec<Prop>,
    /// Red, green and blue per link; links beyond the end or with `None` are tinted by their side.
    pub colors: Vec<Option<[u8; 3]>>,
}

impl Default for StripOptions {
    fn default() -> Self {
        Self {
            count: 8,
            width: 1600.0,
            body_height: 330.0,
            view: View::default(),
            from_s: 0.0,
            to_s: None,
            ground_m: None,
            title: None,
            props: Vec::new(),
            colors: Vec::new(),
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
/// What figures stand on where the ground is tilted.
const PLATE_COLOR: Color = Color(228, 231, 235);
/// Half the side of the plate, m.
const PLATE: f64 = 0.3;
/// Travel of the root, m, over which the viewer follows.
const FOLLOW: f64 = 0.6;
/// An eye is drawn where the cosine of the angle between its look and the viewer is more than this: nearer to the edge of the
/// head it would stick out.
const EDGE: f64 = 0.12;
const PROP: Color = Color(196, 190, 180);
/// What of a prop is farther than this from the figure along one of its edges is not drawn, m.
const PROP_NEAR: f64 = 0.8;
/// Height over the ground, or depth below it, m, beyond which a figure is not drawn where it is.
const AWAY: f64 = 2.5;

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
    let bars: Vec<Vec<Bar>> = rows.iter().map(|row| bars(row, character)).collect();
    let most = bars.iter().map(Vec::len).max().unwrap_or(0);
    let layout = Layout { bars: bars_height(most), ..Layout::new(&scene, options, top) };
    figure = Figure::new(options.width, layout.page_height(rows.len()));
    header(&mut figure, &title, note, &[]);
    for (r, row) in rows.iter().enumerate() {
        layout.floor(&mut figure, r);
        let (_, top) = layout.row(r);
        figure.text(row.label, [MARGIN + 14.0, top + LABEL + 9.0], LABEL + 2.0, INK, Anchor::Start);
        if let [first, .., last] = scene.times[..] {
            let [from, to] = [0, options.count - 1].map(|i| layout.slot_middle(i));
            let at = [from, layout.row(r).0 + layout.under];
            draw_bars(&mut figure, &bars[r], at, to - from, |t| (t - first) / (last - first));
        }
        for (i, frame) in scene.rows[r].iter().enumerate() {
            layout.shadows(&mut figure, r, i, frame);
        }
        for (i, frame) in scene.rows[r].iter().enumerate() {
            layout.body(&mut figure, r, i, frame);
            let at = [layout.slot_middle(i), layout.row(r).0 + layout.under + layout.bars + LABEL + 6.0];
            let time = format!("{:.2} s{}", scene.times[i], frame.away.map_or(String::new(), away));
            figure.text(time, at, LABEL, style::SOFT, Anchor::Middle);
        }
    }
    figure
}

/// What stands when in a row, in the colours of the links.
fn bars(row: &StripRow, character: &Character) -> Vec<Bar> {
    let Some(plan) = row.plan else { return Vec::new() };
    let skeleton = &character.skeleton;
    let tints = tints(character);
    let color = |name: &str| {
        let limb = skeleton.limb(name).map(|limb| limb.end);
        let link = limb.or(skeleton.site(name).map(|site| site.link)).or(skeleton.link(name));
        link.map_or(MIDDLE, |link| tints[link])
    };
    let stands = stands(character, plan, 0.0);
    stands.into_iter().map(|(name, bar)| Bar { color: color(&name), ..bar }).collect()
}

/// One figure: groups of solids back to front and shadows, m, about the figure's own origin on the floor.
pub(crate) struct Frame {
    /// Corners of the plate that the figure stands on; none on level ground.
    plate: Vec<Vec2>,
    groups: Vec<Group>,
    shadows: Vec<Vec<Vec2>>,
    /// Height over the ground, m, if that is too far to be drawn.
    away: Option<f64>,
}

impl Frame {
    /// Draws what of a prop is near a figure at `about`, over all groups that lie behind it and under those that stand on it or before it.
    fn insert(&mut self, prop: &Prop, about: &Vec3, camera: &Camera) {
        let local = prop.place.inverse_transform_point(&(*about).into()).coords;
        let lo = (local - Vec3::repeat(PROP_NEAR)).sup(&-prop.half);
        let hi = (local + Vec3::repeat(PROP_NEAR)).inf(&prop.half);
        if lo.iter().zip(&hi).any(|(lo, hi)| lo >= hi) {
            return;
        }
        let (center, half) = (0.5 * (lo + hi), 0.5 * (hi - lo));
        let shape = Shape::Box { center, half, rotation: Quat::identity() };
        let drawn = solid(&shape, &prop.place, camera, PROP);
        let seen = |p: Vec3| camera.project(&prop.place.transform_point(&p.into()).coords);
        let middle = seen(center);
        let before = |g: &Group| {
            let points = g.solids.iter().flat_map(|s| s.outline.iter().map(|p| Vec3::new(p.x, p.y, s.near)));
            let (sum, count) = points.fold((Vec3::zeros(), 0.0), |(s, n), p| (s + p, n + 1.0));
            let away = sum / count - middle;
            // it lies beyond a face that is seen: along each axis the side that looks at the viewer
            (0..3).any(|axis| {
                let mut edge = Vec3::zeros();
                edge[axis] = half[axis];
                let edge = seen(center + edge) - middle;
                let toward = if edge.z < 0.0 { -edge } else { edge };
                away.dot(&toward) > toward.norm_squared()
            })
        };
        let at = self.groups.iter().position(before).unwrap_or(self.groups.len());
        let near = drawn.near;
        self.groups.insert(at, Group { solids: vec![drawn], tint: PROP, near, rim: CONTOUR });
    }
}

/// What is said of a figure that is this far over the ground, m.
fn away(height: f64) -> String {
    let (far, word) = (height.abs(), if height > 0.0 { "higher" } else { "lower" });
    match far {
        1e7.. => format!(", {:.0e} km {word}", far / 1e3),
        1e4.. => format!(", {:.0} km {word}", far / 1e3),
        1e2.. => format!(", {far:.0} m {word}"),
        _ => format!(", {far:.1} m {word}"),
    }
}

/// Solids with one contour around all of them: the trunk, the head, a limb.
struct Group {
    solids: Vec<Solid>,
    tint: Color,
    near: f64,
    /// Width of the dark line around it, px.
    rim: f64,
}

pub(crate) struct Scene {
    pub(crate) times: Vec<f64>,
    pub(crate) rows: Vec<Vec<Frame>>,
    /// Left, right, lowest and highest point of all figures and shadows, m.
    pub(crate) extent: [f64; 4],
}

impl Scene {
    fn new(rows: &[StripRow], character: &Character, options: &StripOptions) -> Self {
        let count = options.count.max(1);
        let end = rows.iter().map(|r| r.clip.duration_s()).fold(0.0, f64::max);
        let from = if options.from_s.is_finite() { options.from_s.clamp(0.0, end) } else { 0.0 };
        let to = options.to_s.filter(|t| t.is_finite()).map_or(end, |t| t.clamp(from, end));
        let step = (to - from) / (count - 1).max(1) as f64;
        let times: Vec<f64> = (0..count).map(|i| from + step * i as f64).collect();
        let clips: Vec<&Clip> = rows.iter().map(|r| r.clip).collect();
        let forward = clips.first().map_or(0.0, |c| facing(&c.skeleton, c.pose(0)));
        let camera = Camera::around(forward, options.view);
        let poses: Vec<Vec<Kinematics>> =
            clips.iter().map(|c| times.iter().map(|&t| posed(c, t)).collect()).collect();

        let all = || poses.iter().flatten();
        let ground = options.ground_m.unwrap_or_else(|| {
            let (low, first) = (lowest(all(), character), lowest(all().take(1), character));
            // a body that falls without end is measured from where it began
            if first - low > AWAY { first } else { low }
        });
        let start = poses.first().and_then(|r| r.first()).map_or(Vec3::zeros(), |k| k.origin(0));
        let level = |p: Vec3| Vec3::new(p.x, ground, p.z);
        let travels = all().any(|k| (level(k.origin(0)) - level(start)).norm() > FOLLOW);
        let frame = |row: &StripRow, t: f64, k: &Kinematics| {
            let origin = level(if travels { k.origin(0) } else { start });
            let floor = Floor { up: row.up(t), ..drawn_floor(ground) };
            let mut frame = painted(k, character, &camera, &floor, options);
            for prop in &options.props {
                frame.insert(prop, &k.origin(0), &camera);
            }
            let height = lowest(std::iter::once(k), character) - floor.under(&origin).y;
            if height.abs() > AWAY {
                frame.away = Some(height);
                frame.shadows.clear();
                frame.shift(&camera.project(&(origin + Vec3::y() * height)));
                return frame;
            }
            if floor.up != Vec3::y() {
                frame.plate = plate(&floor, &origin, &camera);
            }
            frame.shift(&camera.project(&origin));
            frame
        };
        let rows: Vec<Vec<Frame>> = rows
            .iter()
            .zip(&poses)
            .map(|(row, poses)| times.iter().zip(poses).map(|(&t, k)| frame(row, t, k)).collect())
            .collect();

        let mut scene = Self { times, rows, extent: [0.0; 4] };
        scene.measure();
        scene
    }

    /// Sets the extent.
    pub(crate) fn measure(&mut self) {
        let mut extent = [0.0f64; 4];
        for frame in self.rows.iter().flatten() {
            let solids = frame.groups.iter().flat_map(|g| &g.solids);
            let outlines = solids.map(|s| &s.outline).chain(&frame.shadows).chain([&frame.plate]);
            for p in outlines.flatten() {
                extent = [extent[0].min(p.x), extent[1].max(p.x), extent[2].min(p.y), extent[3].max(p.y)];
            }
        }
        self.extent = extent;
    }
}

/// One figure in the colours of the character, or else tinted by side.
pub(crate) fn painted(
    k: &Kinematics,
    character: &Character,
    camera: &Camera,
    floor: &Floor,
    options: &StripOptions,
) -> Frame {
    let mut tints = tints(character);
    for (tint, color) in tints.iter_mut().zip(&options.colors) {
        if let Some([red, green, blue]) = *color {
            *tint = Color(red, green, blue);
        }
    }
    let colored = options.colors.iter().any(Option::is_some);
    draw(k, character, camera, floor, &tints, &groups(character, &tints, colored))
}

/// A level floor to draw on at `height_m`; its friction is not drawn.
pub(crate) fn drawn_floor(height_m: f64) -> Floor {
    Floor::level(height_m, 0.0)
}

/// A square of a floor about a point above it, pictured.
fn plate(floor: &Floor, about: &Vec3, camera: &Camera) -> Vec<Vec2> {
    let corner =
        |x: f64, z: f64| flat(&camera.project(&floor.under(&(about + Vec3::new(x, 0.0, z) * PLATE))));
    vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)]
}

pub(crate) fn posed(clip: &Clip, t: f64) -> Kinematics {
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

/// A group per link: links of one tint that hang together are one, but a head is its own, so that it
/// stands out before the chest it bows over. A character in its own colours has no sides to tell limbs by:
/// `limbs` parts them by what their joints are.
fn groups(character: &Character, tints: &[Color], limbs: bool) -> Vec<usize> {
    let links = character.skeleton.links();
    let neck = |link: usize| character.classes[link] == JointClass::Neck;
    let mut group = vec![0; links.len()];
    let mut count = 1;
    for (i, link) in links.iter().enumerate().skip(1) {
        let parent = link.parent.unwrap_or(0);
        let head = neck(i) && neck(parent);
        let limb = limbs
            && (matches!(character.classes[i], JointClass::Shoulder | JointClass::Hip)
                || neck(i) && !neck(parent));
        if tints[i] == tints[parent] && !limb && (!head || group[parent] != 0) {
            group[i] = group[parent];
        } else {
            group[i] = count;
            count += 1;
        }
    }
    group
}

fn draw(
    k: &Kinematics,
    character: &Character,
    camera: &Camera,
    floor: &Floor,
    tints: &[Color],
    group_of: &[usize],
) -> Frame {
    let count = group_of.iter().max().map_or(0, |m| m + 1);
    let mut groups: Vec<Group> =
        (0..count).map(|_| Group { solids: Vec::new(), tint: MIDDLE, near: 0.0, rim: CONTOUR }).collect();
    let mut shadows = Vec::new();
    let links = character.skeleton.links();
    let spine = |link: usize| matches!(character.classes[link], JointClass::Root | JointClass::Spine);
    // last solid of each link of the trunk, and where it is
    let mut ends: Vec<Option<Solid>> = vec![None; links.len()];
    for (link, body) in character.bodies.iter().enumerate() {
        let group = &mut groups[group_of[link]];
        group.tint = tints[link];
        let mut before = links[link].parent.filter(|_| spine(link)).and_then(|p| ends[p].clone());
        for shape in &body.shapes {
            let s = solid(shape, &k.world[link], camera, tints[link]);
            // along the spine the hull over each two neighbouring solids is drawn too, so that the trunk is one smooth surface
            if let Some(over) = before.as_ref().filter(|_| spine(link)).and_then(|b| skin(b, &s)) {
                group.solids.push(over);
            }
            before = Some(s.clone());
            group.solids.push(s);
            shadows.push(shadow(shape, &k.world[link], camera, floor));
        }
        ends[link] = before.filter(|_| spine(link));
    }
    for g in groups.iter_mut().filter(|g| !g.solids.is_empty()) {
        g.near = g.solids.iter().map(|s| s.near).sum::<f64>() / g.solids.len() as f64;
        g.solids.sort_by(|a, b| a.near.total_cmp(&b.near));
    }
    draw_welded_groups_over(k, character, camera, group_of, &mut groups);
    if let Some(face) = Face::of(character) {
        draw_face(&face, &k.world[face.link], camera, &groups[group_of[face.link]])
            .into_iter()
            .for_each(|g| groups.push(g));
    }
    groups.retain(|g| !g.solids.is_empty());
    groups.sort_by(|a, b| a.near.total_cmp(&b.near));
    // groups farther from the viewer are mixed with up to 18 % white
    let far = groups.first().map_or(0.0, |g| g.near);
    let near = groups.last().map_or(0.0, |g| g.near);
    for g in &mut groups {
        let haze = 0.18 * (near - g.near) / (near - far).max(0.3);
        let facets = g.solids.iter_mut().flat_map(|s| &mut s.facets);
        facets.for_each(|f| f.color = f.color.mix(WHITE, haze));
    }
    Frame { plate: Vec::new(), groups, shadows, away: None }
}

/// Draws what is welded to a link (a belly, eyes, a bulb) right over its group, or right under it if it is on the
/// far side of that link: where the middles of the groups are does not say which.
fn draw_welded_groups_over(
    k: &Kinematics,
    character: &Character,
    camera: &Camera,
    group_of: &[usize],
    groups: &mut [Group],
) {
    let near = |link: usize| {
        let points =
            character.bodies[link].shapes.iter().flat_map(|s| crate::solid::hull_points(s, &k.world[link]));
        let (sum, count) = points.fold((0.0, 0.0), |(s, n), p| (s + camera.project(&p).z, n + 1.0));
        if count > 0.0 { sum / count } else { camera.project(&k.origin(link)).z }
    };
    for (i, link) in character.skeleton.links().iter().enumerate() {
        let Some(parent) = link.parent.filter(|&p| link.joint == Joint::Fixed && group_of[p] != group_of[i])
        else {
            continue;
        };
        let side = if near(i) >= near(parent) { 1e-6 } else { -1e-6 };
        groups[group_of[i]].near = groups[group_of[parent]].near + side * (1.0 + i as f64);
    }
}

/// The parts of a face that are seen, right over the group of its head; a nose that points away, right under it.
fn draw_face(face: &Face, world_from_head: &Transform, camera: &Camera, head: &Group) -> Vec<Group> {
    let toward = |f: &Feature| camera.near().dot(&(world_from_head.rotation * f.faces));
    let mut drawn = Vec::new();
    for (i, feature) in face.features.iter().enumerate() {
        let toward = toward(feature);
        let is_nose = i + 1 == face.features.len();
        if !is_nose && toward < EDGE {
            continue;
        }
        let (tint, rim) = (feature.color(head.tint), if is_nose { NOSE_RIM } else { EYE_RIM });
        let side = if toward > 0.0 { 1e-7 } else { -1e-7 };
        let near = head.near + side * (1.0 + i as f64);
        let solids = vec![solid(&feature.shape, world_from_head, camera, tint)];
        drawn.push(Group { solids, tint, near, rim });
    }
    drawn
}

impl Frame {
    pub(crate) fn shift(&mut self, origin: &Vec3) {
        let origin = Vec2::new(origin.x, origin.y);
        self.map_points(|p| *p -= origin);
    }

    pub(crate) fn scale(&mut self, by: f64) {
        self.map_points(|p| *p *= by);
    }

    /// Both figures, `other` in front.
    pub(crate) fn join(&mut self, other: Self) {
        self.groups.extend(other.groups);
        self.shadows.extend(other.shadows);
    }

    fn map_points(&mut self, change: impl Fn(&mut Vec2)) {
        for s in self.groups.iter_mut().flat_map(|g| &mut g.solids) {
            let points = s.outline.iter_mut().chain(s.facets.iter_mut().flat_map(|f| &mut f.points));
            points.for_each(&change);
        }
        self.shadows.iter_mut().flatten().chain(&mut self.plate).for_each(change);
    }
}

/// Metres to the page.
pub(crate) struct Layout {
    scale: f64,
    slot: f64,
    /// What lies left of a slot's middle when its figure is centred, m.
    center: f64,
    /// px above and below the floor's origin line.
    over: f64,
    under: f64,
    top: f64,
    width: f64,
    /// Height of the bars under a row, px.
    bars: f64,
}

/// Between rows, and above a row's highest figure, px.
const ROW_GAP: f64 = 16.0;
const HEADROOM: f64 = 34.0;
const TIMES: f64 = LABEL + 20.0;
/// Width of the dark line around a body, px, and around the parts of a face, which are small.
const CONTOUR: f64 = 1.6;
const NOSE_RIM: f64 = 0.9;
const EYE_RIM: f64 = 0.5;

impl Layout {
    pub(crate) fn new(scene: &Scene, options: &StripOptions, top: f64) -> Self {
        let [left, right, low, high] = scene.extent;
        let width = options.width - 2.0 * MARGIN;
        let slot = (width - 24.0) / options.count.max(1) as f64;
        let wide = (right - left).max(1e-3);
        // the contour adds 2 px on both sides
        let scale = ((slot - 14.0) / wide).min(options.body_height / (high - low).max(1e-3));
        Self {
            scale,
            slot,
            center: 0.5 * (left + right),
            over: high * scale + HEADROOM,
            under: -low * scale + 10.0,
            top: top + 4.0,
            width,
            bars: 0.0,
        }
    }

    fn row_height(&self) -> f64 {
        self.over + self.under + self.bars + TIMES
    }

    pub(crate) fn page_height(&self, rows: usize) -> f64 {
        self.top + rows as f64 * (self.row_height() + ROW_GAP) - ROW_GAP + MARGIN
    }

    /// Page height of a row's floor origin, and of the row's top.
    pub(crate) fn row(&self, row: usize) -> (f64, f64) {
        let top = self.top + row as f64 * (self.row_height() + ROW_GAP);
        (top + self.over, top)
    }

    /// Height of the strip of floor under the origin, px.
    pub(crate) fn below(&self) -> f64 {
        self.under
    }

    pub(crate) fn slot_middle(&self, i: usize) -> f64 {
        MARGIN + 12.0 + (i as f64 + 0.5) * self.slot
    }

    fn page(&self, row: usize, slot: usize, points: &[Vec2]) -> Vec<Px> {
        let (x, y) = (self.slot_middle(slot), self.row(row).0);
        points.iter().map(|p| [x + (p.x - self.center) * self.scale, y - p.y * self.scale]).collect()
    }

    pub(crate) fn floor(&self, figure: &mut Figure, row: usize) {
        let (floor, top) = self.row(row);
        let horizon = floor - (self.under * 0.9).max(12.0);
        let bottom = floor + self.under;
        figure.rectangle([MARGIN, top], [self.width, horizon - top], Color(250, 251, 252));
        figure.rectangle([MARGIN, horizon], [self.width, bottom - horizon], FLOOR);
        figure.line(vec![[MARGIN, horizon], [MARGIN + self.width, horizon]], SHADE, style::THIN);
    }

    pub(crate) fn shadows(&self, figure: &mut Figure, row: usize, slot: usize, frame: &Frame) {
        let plate = self.page(row, slot, &frame.plate);
        if !plate.is_empty() {
            figure.fill(plate.clone(), PLATE_COLOR);
        }
        for s in &frame.shadows {
            figure.fill(self.page(row, slot, s), SHADE);
        }
        if let Some(&corner) = plate.first() {
            figure.line([plate, vec![corner]].concat(), style::SOFT, style::THIN);
        }
    }

    /// Group by group, back to front: first the contour of all solids, then their fills band by band,
    /// so that neither contours nor dark edges show inside a group.
    pub(crate) fn body(&self, figure: &mut Figure, row: usize, slot: usize, frame: &Frame) {
        for group in &frame.groups {
            let contour = group.tint.mix(INK, 0.72);
            for s in &group.solids {
                let rim = grown(&s.outline, group.rim / self.scale);
                figure.fill(self.page(row, slot, &rim), contour);
            }
            let facet = |figure: &mut Figure, f: &Facet| {
                figure.fill(self.page(row, slot, &f.points), f.color);
            };
            for s in group.solids.iter().filter(|s| !s.round) {
                s.facets.iter().for_each(|f| facet(figure, f));
            }
            for band in 0..BANDS {
                for s in group.solids.iter().filter(|s| s.round) {
                    facet(figure, &s.facets[band]);
                }
            }
        }
    }
}
