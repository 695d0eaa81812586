//! A character as MJCF, for MuJoCo and the tools around it.
//!
//! In: a [`Character`], gravity, the ground, the set points of its antagonists. Out: MJCF text and the order
//! of its joints. Reading MJCF is the business of [`crate::model`].
//!
//! - Lengths in metres, angles in radians, **Y up** as everywhere here: the file sets its own gravity and
//!   turns its ground plane (a default plane is normal to z).
//! - Inertias are explicit; geoms carry no mass. Fixed links stay bodies of their own (MuJoCo welds them).
//! - Several joints between two bodies (a chain of links without mass) become joints of one body, each at
//!   its own position. Only hinges and slides can be chained so.
//! - The pose that is asked for is the file's own: the root stands there and hinges and slides have it as their `ref`. Joint
//!   values stay what they are. MJCF has no `ref` of a ball: the pose with that of the balls is the key frame `rest`, and where the root
//!   is free, it stands so high without it that nothing is inside the ground.
//! - Limits of hinges and slides are `range`s. Those of balls are swing and twist; MJCF knows one angle for a
//!   ball, so they are left out.
//! - Antagonists of hinges and slides are native: per axis two `general` actuators whose force is
//!   ctrl × (θ_L − θ) and ctrl × (θ_H − θ), and a third with force −ctrl × θ̇: the controls are k_L, k_H, k_d.
//!   MuJoCo's actuators of balls follow another law, K (φ* − φ) on rotation-vector components, so balls get
//!   none.
//! - Props are boxes of the world. Links that touch each other are contact pairs; nothing else of the body meets itself.
//! - A cone is a mesh of its two rims (MuJoCo takes the hull); a cylinder where its radii are equal.
//! - A pose `q` has the file's joint numbers up to their order; velocities of balls and of a free root's
//!   rotation are along the moving body in MuJoCo: see [`crate::mujoco_layout`].

use std::fmt::Write;

use motion::floor::FRICTION;
use motion::rotation::exp;
use motion::skeleton::{quat_at, vec_at};
use motion::{Floor, Joint, Limits, Quat, Shape, Site, Transform, Vec3};
use nalgebra::{Matrix3, Unit};

use crate::mujoco_layout::{JointThere, Layout};
use crate::xml::MAX_DEPTH;
use bodies::{Body, Character, Prop};

/// What an MJCF file holds besides the body.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MjcfOptions {
    /// Gravity, world, m/s².
    pub gravity: Vec3,
    /// Ground plane, if any; the body's geoms collide with it and with nothing else, and its friction is theirs too. A floor
    /// that turns is the top of a slab on a ball joint, named `ground` as its geom is, the last body in the file, too heavy
    /// to be moved by what stands on it.
    pub ground: Option<Floor>,
    /// Boxes and ramps: geoms of the world named `prop_` and their number. Their friction and that of the ground count
    /// for what touches them.
    pub props: Vec<Prop>,
    /// Whether links touch each other: contact pairs of the geoms that may ([`Character::self_pairs`]).
    pub self_collision: bool,
    /// Set points (θ_L, θ_H) of hinges (rad) and slides (m), per link; links without get no actuators.
    pub antagonists: Vec<(usize, [f64; 2])>,
    /// Pose in which the file has the body (`nq`); the zero pose if `None`.
    pub pose: Option<Vec<f64>>,
    /// Names of joints that differ from those of their links.
    pub joint_names: Vec<(usize, String)>,
}

/// An MJCF file.
#[derive(Clone, Debug, PartialEq)]
pub struct Mjcf {
    /// The text.
    pub text: String,
    /// Links whose joints the file has, in the file's (and MuJoCo's) order.
    pub joints: Vec<usize>,
}

/// Why a character has no MJCF.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MjcfError {
    /// A ball or free joint on a link without mass.
    #[error(
        "`{0}` has no mass and a ball or free joint; MJCF chains only hinges and slides between two bodies"
    )]
    Chain(String),
    /// A link without mass whose joint moves several links or none.
    #[error("`{link}` has no mass and carries {children} links; it must carry exactly one")]
    Branch {
        /// The link.
        link: String,
        /// Links hung on it.
        children: usize,
    },
    /// A tree that readers of XML do not follow.
    #[error("`{0}` hangs on more than {MAX_DEPTH} bodies; deeper files are not read")]
    Deep(String),
    /// A free joint that is not the root's.
    #[error("`{0}` has a free joint below the root; MJCF allows free joints at the top only")]
    Free(String),
    /// A world, and no body in it.
    #[error("`{0}` is one link without mass or shapes that never moves; an MJCF of it would hold no body")]
    Still(String),
}

/// Writes `character` as MJCF. See the module header.
///
/// # Errors
/// [`MjcfError`]: a tree that MJCF has no words for.
///
/// # Examples
/// ```
/// use formats::mjcf::{MjcfOptions, write};
/// let (human, _) = bodies::anthropometry::human::human();
/// let file = write(&human, &MjcfOptions { gravity: -motion::Vec3::y() * 9.81, ..Default::default() }).unwrap();
/// assert!(file.text.contains("<freejoint name=\"pelvis\"/>"));
/// ```
pub fn write(character: &Character, options: &MjcfOptions) -> Result<Mjcf, MjcfError> {
    let skeleton = &character.skeleton;
    let links = skeleton.links();
    if let [only] = links
        && only.joint == Joint::Fixed
        && character.bodies[0] == nothing()
    {
        return Err(MjcfError::Still(only.name.clone()));
    }
    let mut children = vec![Vec::new(); links.len()];
    let mut sites = vec![Vec::new(); links.len()];
    for (i, link) in links.iter().enumerate() {
        if let Some(parent) = link.parent {
            children[parent].push(i);
        }
    }
    for site in skeleton.sites() {
        sites[site.link].push(site);
    }
    let motions = (0..links.len()).map(|i| motion(character, options.pose.as_deref(), i)).collect();
    let lift = lift(character, options);
    let mut names: Vec<&str> = links.iter().map(|l| l.name.as_str()).collect();
    for (link, name) in &options.joint_names {
        names[*link] = name;
    }
    let (text, joints) = (String::new(), Vec::new());
    let mut writer = Writer { character, options, children, sites, motions, lift, names, text, joints };
    writer.document()?;
    Ok(Mjcf { text: writer.text, joints: writer.joints })
}

/// Links of one MJCF body: those without mass that chain its joints, then the one that carries it.
struct Chain {
    links: Vec<usize>,
    /// Frame of each link in the frame of the last, in the file's pose.
    last_from: Vec<Transform>,
}

/// Motion of a joint in the file's pose; of a ball there is none.
fn motion(character: &Character, pose: Option<&[f64]>, link: usize) -> Transform {
    let (Some(q), skeleton) = (pose, &character.skeleton) else { return Transform::identity() };
    let at = skeleton.q_at(link);
    match skeleton.links()[link].joint {
        Joint::Free => Transform::from_parts(vec_at(q, at).into(), quat_at(q, at + 3)),
        Joint::Revolute(axis) => Transform::from_parts(Vec3::zeros().into(), exp(&(axis * q[at]))),
        Joint::Prismatic(axis) => Transform::from_parts((axis * q[at]).into(), Quat::identity()),
        Joint::Spherical | Joint::Fixed => Transform::identity(),
    }
}

/// How far the body is lifted so that nothing of it is inside the ground while its balls are in their zero pose.
fn lift(character: &Character, options: &MjcfOptions) -> Vec3 {
    let (Some(pose), Some(ground)) = (&options.pose, &options.ground) else { return Vec3::zeros() };
    let mut q = pose.clone();
    for (i, link) in character.skeleton.links().iter().enumerate() {
        if link.joint == Joint::Spherical {
            character.skeleton.set_rotation(&mut q, i, &Quat::identity());
        }
    }
    let depth = character.extent(&q, &ground.up).map_or(0.0, |[low, _]| ground.pivot().dot(&ground.up) - low);
    if depth > 1e-9 && q != *pose { ground.up * depth } else { Vec3::zeros() }
}

struct Writer<'a> {
    character: &'a Character,
    options: &'a MjcfOptions,
    /// Links on each link.
    children: Vec<Vec<usize>>,
    /// Sites of each link.
    sites: Vec<Vec<&'a Site>>,
    /// Motion of each link's joint in the file's pose.
    motions: Vec<Transform>,
    /// Added to the position of a free root.
    lift: Vec3,
    /// Name of each link's joint.
    names: Vec<&'a str>,
    text: String,
    joints: Vec<usize>,
}

impl Writer<'_> {
    fn line(&mut self, depth: usize, text: &str) {
        let _ = writeln!(self.text, "{:1$}{text}", "", 2 * depth);
    }

    fn document(&mut self) -> Result<(), MjcfError> {
        let name = escape(&self.character.name);
        self.line(0, &format!("<mujoco model=\"{name}\">"));
        self.line(1, "<!-- metres, radians, Y up -->");
        // `balanceinertia`, `boundmass` and `boundinertia` stay off: the inertias are checked to be physical
        self.line(1, "<compiler angle=\"radian\" autolimits=\"true\" inertiafromgeom=\"false\"/>");
        let gravity = numbers(self.options.gravity.as_slice());
        self.line(1, &format!("<option gravity=\"{gravity}\" cone=\"elliptic\"/>"));
        self.line(1, "<default>");
        let friction = if self.alone() { self.options.ground.map_or(1.0, |g| g.friction) } else { FRICTION };
        // body geoms (bit 1) meet the ground (bit 0) and not each other
        let f = number(friction);
        self.line(
            2,
            &format!("<geom contype=\"2\" conaffinity=\"1\" condim=\"3\" friction=\"{f} 0 0\" mass=\"0\"/>"),
        );
        self.line(1, "</default>");
        self.meshes();
        self.line(1, "<worldbody>");
        if let Some(ground) = self.options.ground {
            let at = numbers(&[0.0, ground.height_m, 0.0]);
            let turn = if ground.up == Vec3::y() {
                "0.70710678118654757 -0.70710678118654757 0 0".to_owned()
            } else {
                // the plane's normal is its z axis
                let r = motion::rotation::between(&Vec3::z(), &ground.up);
                numbers(&[r.w, r.i, r.j, r.k])
            };
            if !ground.turns {
                let own = self.own_friction(ground.friction);
                self.line(
                    2,
                    &format!(
                        "<geom name=\"ground\" type=\"plane\" size=\"20 20 1\" pos=\"{at}\" quat=\"{turn}\" contype=\"1\" conaffinity=\"2\"{own} rgba=\"0.8 0.8 0.8 1\"/>"
                    ),
                );
            }
        }
        for (i, prop) in self.options.props.iter().enumerate() {
            let (size, own) = (numbers(prop.half.as_slice()), self.own_friction(prop.friction));
            let place = placement(&prop.place);
            self.line(
                2,
                &format!(
                    "<geom name=\"prop_{i}\" type=\"box\" size=\"{size}\"{place} contype=\"1\" conaffinity=\"2\"{own} rgba=\"0.7 0.65 0.6 1\"/>"
                ),
            );
        }
        self.body(0, 2, &Transform::identity(), true)?;
        if let Some(ground) = self.options.ground.filter(|g| g.turns) {
            self.slab(&ground);
        }
        self.line(1, "</worldbody>");
        self.pairs();
        self.actuators();
        self.key();
        self.line(0, "</mujoco>");
        Ok(())
    }

    /// Whether the ground is all that the body may touch.
    fn alone(&self) -> bool {
        self.options.props.is_empty() && !self.options.self_collision
    }

    /// Attributes of a geom of the world whose friction counts for what touches it, where the body has one of its own.
    fn own_friction(&self, friction: f64) -> String {
        if self.alone() {
            return String::new();
        }
        format!(" friction=\"{} 0 0\" priority=\"1\"", number(friction))
    }

    /// Links that touch each other.
    fn pairs(&mut self) {
        if !self.options.self_collision {
            return;
        }
        let (character, f) = (self.character, number(FRICTION));
        let all = character.capsules();
        let geom =
            |c: usize| format!("{}_{}", escape(&character.skeleton.links()[all[c].link].name), all[c].shape);
        self.line(1, "<contact>");
        for [i, j] in character.self_pairs() {
            let (one, other) = (geom(i), geom(j));
            self.line(
                2,
                &format!("<pair geom1=\"{one}\" geom2=\"{other}\" condim=\"3\" friction=\"{f} {f} 0 0 0\"/>"),
            );
        }
        self.line(1, "</contact>");
    }

    /// Ground that can turn, level in its zero pose.
    fn slab(&mut self, ground: &Floor) {
        let at = numbers(&[0.0, ground.height_m, 0.0]);
        self.line(2, &format!("<body name=\"ground\" pos=\"{at}\">"));
        self.line(3, "<joint name=\"ground\" type=\"ball\" armature=\"1e9\"/>");
        self.line(3, "<inertial pos=\"0 0 0\" mass=\"1\" diaginertia=\"1 1 1\"/>");
        let own = self.own_friction(ground.friction);
        self.line(
            3,
            &format!(
                "<geom name=\"ground\" type=\"box\" size=\"5 0.5 5\" pos=\"0 -0.5 0\" contype=\"1\" conaffinity=\"2\"{own} rgba=\"0.8 0.8 0.8 1\"/>"
            ),
        );
        self.line(2, "</body>");
    }

    /// Cones that are no cylinders, under the names of their geoms.
    fn meshes(&mut self) {
        let character = self.character;
        let mut lines = Vec::new();
        for (body, link) in character.bodies.iter().zip(character.skeleton.links()) {
            for (k, shape) in body.shapes.iter().enumerate() {
                if matches!(shape, Shape::Cone { radius_a, radius_b, .. } if radius_a != radius_b) {
                    let corners: Vec<f64> = shape.rims().iter().flat_map(|p| [p.x, p.y, p.z]).collect();
                    let name = escape(&link.name);
                    lines.push(format!("<mesh name=\"{name}_{k}\" vertex=\"{}\"/>", numbers(&corners)));
                }
            }
        }
        if !lines.is_empty() {
            self.line(1, "<asset>");
            lines.iter().for_each(|l| self.line(2, l));
            self.line(1, "</asset>");
        }
    }

    fn chain(&self, first: usize) -> Result<Chain, MjcfError> {
        let links = self.character.skeleton.links();
        let mut chain = vec![first];
        loop {
            let at = chain[chain.len() - 1];
            let massless = self.character.bodies[at].mass == 0.0;
            if !massless || links[at].joint.nv() == 0 {
                break;
            }
            let name = || links[at].name.clone();
            if !matches!(links[at].joint, Joint::Revolute(_) | Joint::Prismatic(_)) {
                return Err(MjcfError::Chain(name()));
            }
            match self.children[at][..] {
                [child] => chain.push(child),
                ref all => return Err(MjcfError::Branch { link: name(), children: all.len() }),
            }
        }
        let mut last_from = vec![Transform::identity(); chain.len()];
        for k in (0..chain.len() - 1).rev() {
            let next = chain[k + 1];
            last_from[k] = last_from[k + 1] * (links[next].parent_from_zero * self.motions[next]).inverse();
        }
        Ok(Chain { links: chain, last_from })
    }

    fn body(&mut self, first: usize, depth: usize, base: &Transform, top: bool) -> Result<(), MjcfError> {
        let character = self.character;
        let links = character.skeleton.links();
        let chain = self.chain(first)?;
        let last = chain.links[chain.links.len() - 1];
        if depth + 1 > MAX_DEPTH {
            return Err(MjcfError::Deep(links[last].name.clone()));
        }
        // a body of the file sits where its last link is in the file's pose
        let mut place =
            base * links[first].parent_from_zero * self.motions[first] * chain.last_from[0].inverse();
        if links[first].joint == Joint::Free {
            place.translation.vector += self.lift;
        }
        // a welded root without mass is the world body, which MJCF cannot place or turn: its children are placed and turned instead
        let world = first == 0 && links[0].joint == Joint::Fixed && character.bodies[0] == nothing();
        let inner = if world {
            depth
        } else {
            let name = escape(&links[last].name);
            self.line(depth, &format!("<body name=\"{name}\"{}>", placement(&place)));
            for (link, last_from) in chain.links.iter().zip(&chain.last_from) {
                self.joint(*link, last_from, depth + 1, top && chain.links.len() == 1)?;
            }
            self.inertial(&character.bodies[last], depth + 1);
            for (k, shape) in character.bodies[last].shapes.iter().enumerate() {
                self.geom(&format!("{name}_{k}"), shape, depth + 1);
            }
            for site in std::mem::take(&mut self.sites[last]) {
                let (name, at) = (escape(&site.name), numbers(site.at.as_slice()));
                self.line(depth + 1, &format!("<site name=\"{name}\" pos=\"{at}\" size=\"0.005\"/>"));
            }
            depth + 1
        };
        for i in std::mem::take(&mut self.children[last]) {
            let base = if world { place } else { Transform::identity() };
            self.body(i, inner, &base, world)?;
        }
        if inner > depth {
            self.line(depth, "</body>");
        }
        Ok(())
    }

    fn joint(
        &mut self,
        link: usize,
        last_from: &Transform,
        depth: usize,
        top: bool,
    ) -> Result<(), MjcfError> {
        let l = &self.character.skeleton.links()[link];
        let name = escape(self.names[link]);
        let at = numbers(last_from.translation.vector.as_slice());
        let axis = |a: &Vec3| numbers((last_from.rotation * a).as_slice());
        let range = match &l.limits {
            Some(Limits::Axis(r)) => format!(" range=\"{}\"", numbers(&[r.lo, r.hi])),
            _ => String::new(),
        };
        let value = self.options.pose.as_ref().map_or(0.0, |q| match l.joint {
            Joint::Revolute(_) | Joint::Prismatic(_) => q[self.character.skeleton.q_at(link)],
            _ => 0.0,
        });
        let reference = if value == 0.0 { String::new() } else { format!(" ref=\"{}\"", number(value)) };
        let rest = format!("{range}{reference}");
        let text = match &l.joint {
            Joint::Fixed => return Ok(()),
            Joint::Free if !top => return Err(MjcfError::Free(l.name.clone())),
            Joint::Free => format!("<freejoint name=\"{name}\"/>"),
            Joint::Spherical => format!("<joint name=\"{name}\" type=\"ball\"/>"),
            Joint::Revolute(a) => {
                format!("<joint name=\"{name}\" type=\"hinge\" pos=\"{at}\" axis=\"{}\"{rest}/>", axis(a))
            }
            Joint::Prismatic(a) => {
                format!("<joint name=\"{name}\" type=\"slide\" pos=\"{at}\" axis=\"{}\"{rest}/>", axis(a))
            }
        };
        self.joints.push(link);
        self.line(depth, &text);
        Ok(())
    }

    fn inertial(&mut self, body: &Body, depth: usize) {
        if body.mass == 0.0 {
            return;
        }
        let i = &body.inertia;
        let full = numbers(&[i[(0, 0)], i[(1, 1)], i[(2, 2)], i[(0, 1)], i[(0, 2)], i[(1, 2)]]);
        let (mass, com) = (number(body.mass), numbers(body.com.as_slice()));
        self.line(depth, &format!("<inertial mass=\"{mass}\" pos=\"{com}\" fullinertia=\"{full}\"/>"));
    }

    fn geom(&mut self, name: &str, shape: &Shape, depth: usize) {
        let text = match shape {
            Shape::Capsule { a, b, radius } if a != b => {
                let ends = numbers(&[a.x, a.y, a.z, b.x, b.y, b.z]);
                format!("type=\"capsule\" fromto=\"{ends}\" size=\"{}\"", number(*radius))
            }
            Shape::Capsule { a: center, radius, .. } | Shape::Sphere { center, radius } => {
                let at = numbers(center.as_slice());
                format!("type=\"sphere\" pos=\"{at}\" size=\"{}\"", number(*radius))
            }
            Shape::Box { center, half, rotation } => {
                let place = Transform::from_parts((*center).into(), *rotation);
                format!("type=\"box\" size=\"{}\"{}", numbers(half.as_slice()), placement(&place))
            }
            Shape::Cone { a, b, radius_a, radius_b } if radius_a == radius_b => {
                let ends = numbers(&[a.x, a.y, a.z, b.x, b.y, b.z]);
                format!("type=\"cylinder\" fromto=\"{ends}\" size=\"{}\"", number(*radius_a))
            }
            Shape::Cone { .. } => format!("type=\"mesh\" mesh=\"{name}\""),
        };
        self.line(depth, &format!("<geom name=\"{name}\" {text}/>"));
    }

    /// The pose as the key frame `rest`.
    fn key(&mut self) {
        let (Some(pose), skeleton) = (&self.options.pose, &self.character.skeleton) else { return };
        let (mut nq, mut nv, mut places) = (0, 0, Vec::new());
        for &link in &self.joints {
            places.push(JointThere { link, q: nq, v: nv });
            let kind = &skeleton.links()[link].joint;
            (nq, nv) = (nq + kind.nq(), nv + kind.nv());
        }
        let mut there = vec![0.0; nq];
        Layout::new(skeleton, &places, nq, nv).pose(pose, &mut there);
        if let Some(ground) = self.options.ground.filter(|g| g.turns) {
            let r = ground.turn();
            there.extend([r.w, r.i, r.j, r.k]);
        }
        if !there.is_empty() {
            self.line(1, "<keyframe>");
            self.line(2, &format!("<key name=\"rest\" qpos=\"{}\"/>", numbers(&there)));
            self.line(1, "</keyframe>");
        }
    }

    fn actuators(&mut self) {
        if self.options.antagonists.is_empty() {
            return;
        }
        self.line(1, "<actuator>");
        for (link, [lo, hi]) in self.options.antagonists.clone() {
            let joint = escape(self.names[link]);
            // force = ctrl × (gainprm · (1, length, velocity)), no bias
            let gains = [
                ("lo", numbers(&[lo, -1.0, 0.0])),
                ("hi", numbers(&[hi, -1.0, 0.0])),
                ("damp", numbers(&[0.0, 0.0, -1.0])),
            ];
            for (what, gain) in gains {
                self.line(
                    2,
                    &format!(
                        "<general name=\"{joint}_{what}\" joint=\"{joint}\" gaintype=\"affine\" gainprm=\"{gain}\" biastype=\"none\"/>"
                    ),
                );
            }
        }
        self.line(1, "</actuator>");
    }
}

fn nothing() -> Body {
    Body { mass: 0.0, com: Vec3::zeros(), inertia: Matrix3::zeros(), shapes: Vec::new() }
}

fn placement(t: &Transform) -> String {
    let mut text = String::new();
    if t.translation.vector != Vec3::zeros() {
        let _ = write!(text, " pos=\"{}\"", numbers(t.translation.vector.as_slice()));
    }
    let r = Unit::new_normalize(*t.rotation.quaternion());
    if r.imag() != Vec3::zeros() {
        let _ = write!(text, " quat=\"{}\"", numbers(&[r.w, r.i, r.j, r.k]));
    }
    text
}

/// The shortest text that reads back as the same number.
fn number(x: f64) -> String {
    format!("{x:?}")
}

fn numbers(x: &[f64]) -> String {
    x.iter().map(|x| number(*x)).collect::<Vec<_>>().join(" ")
}

fn escape(name: &str) -> String {
    let mut out = String::with_capacity(name.len());
    for c in name.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            c => out.push(c),
        }
    }
    out
}
