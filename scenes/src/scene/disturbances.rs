//! Disturbances of a scene, checked: ground that tilts, pushes and carried masses.
//!
//! In: what the file says. Out: the same in SI units with links found, or an error at the very value. The ground itself is read
//! with the world, in [`super`].

use bodies::{Carried, Character};
use dynamics::Carrying;
use dynamics::{Push, RootMode};
use motion::{Joint, Tilt, Vec3};

use super::Check;
use crate::conditions::Timed;
use crate::schema::{CarriedRon, GroundRon, ImpulseRon, PlaneRon, PushRon};
use crate::{SceneError, Source};

/// A push as a text of its own: what `--push` of the command line takes.
///
/// # Errors
/// As in a scene, at the place in the text.
pub fn push_of(source: &Source, character: &Character) -> Result<Timed<Push>, SceneError> {
    let ron: PushRon = source.parse()?;
    Check { source, character }.push("", &ron)
}

impl Check<'_> {
    /// Turns of the ground.
    pub(crate) fn tilts(&self, ground: &GroundRon, root: RootMode) -> Result<Vec<Timed<Tilt>>, SceneError> {
        let GroundRon::Plane(PlaneRon { tilts, .. }) = ground else { return Ok(Vec::new()) };
        let mut free_s = 0.0;
        let one = |(i, t): (usize, &_)| {
            let crate::schema::TiltRon { start_s, duration_s, tilt_deg, towards_deg, curve, clock } = *t;
            let at = format!("world.ground.tilts[{i}]");
            if root == RootMode::Pinned {
                let message = "the ground tilts under a pinned root; allowed: with root Free or Assisted";
                return Err(self.source.error(&at, message));
            }
            let start_s = self.within(&format!("{at}.start_s"), start_s, 0.0, 86_400.0, "s")?;
            if start_s < free_s {
                let message = format!(
                    "begins at {start_s} s; allowed: from {free_s} s on, when the turn before it ends"
                );
                return Err(self.source.error(&format!("{at}.start_s"), message));
            }
            let duration_s = self.within(&format!("{at}.duration_s"), duration_s, 0.05, 3600.0, "s")?;
            free_s = start_s + duration_s;
            let tilt = self.within(&format!("{at}.tilt_deg"), tilt_deg, 0.0, 30.0, "°")?;
            let towards = self.within(&format!("{at}.towards_deg"), towards_deg, -360.0, 360.0, "°")?;
            let curve = self.curve(&format!("{at}.curve"), curve.0)?;
            let value =
                Tilt { start_s, duration_s, tilt: tilt.to_radians(), towards: towards.to_radians(), curve };
            Ok(Timed { value, clock: clock.0 })
        };
        tilts.iter().enumerate().map(one).collect()
    }

    /// Pushes.
    pub(crate) fn pushes(&self, ron: &[PushRon]) -> Result<Vec<Timed<Push>>, SceneError> {
        ron.iter().enumerate().map(|(i, p)| self.push(&format!("pushes[{i}]"), p)).collect()
    }

    /// A push; the fields of a text of its own are `at` the empty place.
    fn push(&self, at: &str, p: &PushRon) -> Result<Timed<Push>, SceneError> {
        let place = |field: &str| if at.is_empty() { field.to_owned() } else { format!("{at}.{field}") };
        let link = self.link(&place("link"), &p.link, " in a push")?;
        let duration_s = self.within(&place("duration_s"), p.duration_s, 1e-3, 3600.0, "s")?;
        let value = Push {
            link,
            at: self.near(&place("at_m"), p.at_m)?,
            force: self.impulse(&place, p)? / duration_s,
            start_s: self.within(&place("start_s"), p.start_s, 0.0, 86_400.0, "s")?,
            duration_s,
        };
        Ok(Timed { value, clock: p.clock.0 })
    }

    pub(crate) fn link(&self, at: &str, name: &str, within: &str) -> Result<usize, SceneError> {
        let skeleton = &self.character.skeleton;
        skeleton.link(name).ok_or_else(|| {
            let known = skeleton.links().iter().map(|l| l.name.as_str());
            self.source.unknown(at, "link", name, within, known)
        })
    }

    /// A point beside a link.
    fn near(&self, at: &str, v: (f64, f64, f64)) -> Result<Vec3, SceneError> {
        for x in [v.0, v.1, v.2] {
            self.within(at, x, -10.0, 10.0, "m")?;
        }
        Ok(Vec3::new(v.0, v.1, v.2))
    }

    /// The impulse of a push, world, N·s.
    fn impulse(&self, place: &impl Fn(&str) -> String, p: &PushRon) -> Result<Vec3, SceneError> {
        let field = place("impulse_ns");
        match (p.impulse_ns, p.towards_deg) {
            (ImpulseRon::Vector(v), None) => {
                for x in v {
                    self.within(&field, x, -1e7, 1e7, "N·s")?;
                }
                Ok(Vec3::from(v))
            }
            (ImpulseRon::Size(x), Some(deg)) => {
                let x = self.within(&field, x, 0.0, 1e7, "N·s")?;
                let deg = self.within(&place("towards_deg"), deg, -360.0, 360.0, "°")?;
                Ok(crate::angle::direction(deg) * x)
            }
            (ImpulseRon::Size(x), None) => {
                let message = format!(
                    "impulse_ns is {x} N·s without a direction; allowed: with towards_deg beside it, or (x, y, z)"
                );
                Err(self.source.error(&field, message))
            }
            (ImpulseRon::Vector(_), Some(_)) => {
                let message = "impulse_ns has a direction of its own; allowed: one number beside towards_deg";
                Err(self.source.error(&place("towards_deg"), message))
            }
        }
    }

    /// Masses carried.
    pub(crate) fn carried(&self, ron: &[CarriedRon]) -> Result<Vec<Timed<Carrying>>, SceneError> {
        let one = |(i, c): (usize, &CarriedRon)| {
            let at = format!("carried[{i}]");
            let link = self.link(&format!("{at}.link"), &c.link, " in a Carried")?;
            let welded = matches!(self.character.skeleton.links()[link].joint, Joint::Fixed);
            if self.character.bodies[link].mass == 0.0 && !welded {
                let message = format!("`{}` has no mass of its own and cannot carry any", c.link);
                return Err(self.source.error(&format!("{at}.link"), message));
            }
            let mass = self.within(&format!("{at}.mass_kg"), c.mass_kg, 1e-3, 1e3, "kg")?;
            let size = [c.size_m.0, c.size_m.1, c.size_m.2];
            for x in size {
                self.within(&format!("{at}.size_m"), x, 0.0, 10.0, "m")?;
            }
            let from_s = self.within(&format!("{at}.from_s"), c.from_s, 0.0, 86_400.0, "s")?;
            let to_s = match c.to_s {
                Some(to_s) if to_s > from_s => to_s,
                Some(to_s) => {
                    let message = format!("to_s is {to_s} s; allowed: later than from_s, {from_s} s");
                    return Err(self.source.error(&format!("{at}.to_s"), message));
                }
                None => f64::INFINITY,
            };
            let centre = self.near(&format!("{at}.at_m"), c.at_m)?;
            let what = Carried::solid_box(link, mass, centre, Vec3::from(size));
            let value = Carrying { what, from_s, to_s, known: c.known };
            Ok(Timed { value, clock: c.clock.0 })
        };
        ron.iter().enumerate().map(one).collect()
    }
}
