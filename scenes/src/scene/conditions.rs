//! The conditions of a scene, checked: world, root, physics, balance.
//!
//! In: the words of [`crate::schema`]. Out: [`ConditionsSpec`] in SI units, or an error at the very value. Pushes, tilts and carried
//! masses are in [`super::disturbances`], gazes and programs in [`super::reactive`].

use bodies::soles::{Pad, Pads, Toes};
use controllers::BalanceSettings;
use dynamics::conditions::RootMode;
use motion::{Floor, Vec3};

use super::Check;
use crate::SceneError;
use crate::conditions::{ConditionsSpec, Physics, SoleKind, ToesKind};
use crate::overrides::{RATES, SUBSTEPS, TENSIONS, set_fidelity};
use crate::props::props;
use crate::schema::{
    AssistRon, BalanceRon, GroundRon, PadRon, PhysicsRon, PlaneRon, RootRon, SceneRon, SolesRon, ToesRon,
};

impl Check<'_> {
    /// All conditions but those that a patch changes.
    pub(crate) fn conditions(&self, ron: &SceneRon, physics: Physics) -> Result<ConditionsSpec, SceneError> {
        let engine = match &ron.engine {
            None => None,
            Some(name) if name.trim().is_empty() => {
                return Err(self.source.error("engine", "the name of the engine is empty"));
            }
            Some(name) => Some(name.clone()),
        };
        Ok(ConditionsSpec {
            height_given: matches!(ron.world.ground.0, GroundRon::Plane(PlaneRon { height_m: Some(_), .. })),
            tilts: self.tilts(&ron.world.ground.0, physics.root)?,
            props: props(self.source, "world.props", &ron.world.props)?,
            self_collision: ron.world.self_collision,
            pushes: self.pushes(&ron.pushes)?,
            carried: self.carried(&ron.carried)?,
            gazes: self.gazes(&ron.reactive)?,
            programs: self.programs(&ron.reactive)?,
            engine,
            physics,
        })
    }

    pub(crate) fn physics(&self, ron: &SceneRon) -> Result<Physics, SceneError> {
        let p = &ron.physics;
        let rate = |x| self.within("physics.rate_hz", x, *RATES.start(), *RATES.end(), "Hz");
        let rate_hz = p.rate_hz.map(rate).transpose()?;
        if p.substeps.is_some_and(|n| !SUBSTEPS.contains(&n)) {
            let found = p.substeps.unwrap_or(0);
            return Err(self.source.error("physics.substeps", format!("{found} substeps; allowed: 1 to 64")));
        }
        let tension =
            self.within("physics.tension", p.tension, *TENSIONS.start(), *TENSIONS.end(), "(1 = natural)")?;
        let root = match ron.root.0 {
            RootRon::Free => RootMode::Free,
            RootRon::Pinned => RootMode::Pinned,
            RootRon::Assisted(AssistRon { force_n, moment_nm }) => RootMode::Assisted {
                force_n: self.within("root.force_n", force_n, 0.0, 1e6, "N")?,
                moment_nm: self.within("root.moment_nm", moment_nm, 0.0, 1e6, "N·m")?,
            },
            RootRon::Fidelity(_) => RootMode::Free, // set below, with what it needs to know
        };
        let mut physics = Physics {
            rate_hz,
            substeps: p.substeps,
            tension,
            blend: p.blend.0,
            root,
            gravity: self.vec3("world.gravity_m_s2", ron.world.gravity_m_s2)?,
            ground: self.ground(&ron.world.ground.0)?,
            balance: self.balance(&ron.balance)?,
            past_fall: false,
            soles: self.soles(p)?,
            toes: self.toes(p)?,
        };
        if let RootRon::Fidelity(f) = ron.root.0 {
            set_fidelity(&mut physics, self.within("root", f, 0.0, 1.0, "")?, self.character);
        }
        Ok(physics)
    }

    fn soles(&self, ron: &PhysicsRon) -> Result<Option<SoleKind>, SceneError> {
        let Some(soles) = ron.soles else { return Ok(None) };
        let pad = |name: &str, ron: PadRon, usual: Pad| -> Result<Pad, SceneError> {
            let within = |field: &str, x: Option<f64>, usual: f64, lo: f64, hi: f64, unit: &str| {
                self.within(&format!("physics.soles.{name}.{field}"), x.unwrap_or(usual), lo, hi, unit)
            };
            let u = usual;
            Ok(Pad {
                stiffness_n_m: within("stiffness_n_m", ron.stiffness_n_m, u.stiffness_n_m, 1e2, 1e7, "N/m")?,
                damping_n_s_m: within(
                    "damping_n_s_m",
                    ron.damping_n_s_m,
                    u.damping_n_s_m,
                    1.0,
                    1e5,
                    "N·s/m",
                )?,
                travel_m: within("travel_m", ron.travel_m, u.travel_m, 1e-4, 0.1, "m")?,
                compact_n_m: within("compact_n_m", ron.compact_n_m, u.compact_n_m, 1e2, 1e7, "N/m")?,
            })
        };
        let usual = Pads::default();
        Ok(Some(match soles.0 {
            SolesRon::Rigid => SoleKind::Rigid,
            SolesRon::Pads(ron) => SoleKind::Pads(Pads {
                heel: pad("heel", ron.heel, usual.heel)?,
                ball: pad("ball", ron.ball, usual.ball)?,
            }),
        }))
    }

    fn toes(&self, ron: &PhysicsRon) -> Result<Option<ToesKind>, SceneError> {
        let Some(toes) = ron.toes else { return Ok(None) };
        let ToesRon::Bend(ron) = toes.0 else { return Ok(Some(ToesKind::Welded)) };
        let usual = Toes::default();
        let stiffness = ron.stiffness_nm_rad.unwrap_or(usual.stiffness_nm_rad);
        let damping = ron.damping_nm_s_rad.unwrap_or(usual.damping_nm_s_rad);
        Ok(Some(ToesKind::Bend(Toes {
            stiffness_nm_rad: self.within("physics.toes.stiffness_nm_rad", stiffness, 0.1, 1e4, "N·m/rad")?,
            damping_nm_s_rad: self.within(
                "physics.toes.damping_nm_s_rad",
                damping,
                1e-3,
                1e3,
                "N·m·s/rad",
            )?,
        })))
    }

    fn ground(&self, ron: &GroundRon) -> Result<Option<Floor>, SceneError> {
        let GroundRon::Plane(PlaneRon { friction, height_m, tilt_deg, towards_deg, .. }) = *ron else {
            return Ok(None);
        };
        let friction = self.within("world.ground.friction", friction, 0.0, 2.0, "")?;
        let height_m = self.within("world.ground.height_m", height_m.unwrap_or(0.0), -1e3, 1e3, "m")?;
        let tilt = self.within("world.ground.tilt_deg", tilt_deg, 0.0, 30.0, "°")?;
        let towards = self.within("world.ground.towards_deg", towards_deg, -360.0, 360.0, "°")?;
        let level = Floor::level(height_m, friction);
        Ok(Some(if tilt > 0.0 { level.tilted(tilt.to_radians(), towards.to_radians()) } else { level }))
    }

    fn vec3(&self, at: &str, v: (f64, f64, f64)) -> Result<Vec3, SceneError> {
        let v = Vec3::new(v.0, v.1, v.2);
        if v.iter().all(|x| x.is_finite()) {
            return Ok(v);
        }
        Err(self.source.error(at, "a number that is not finite; allowed: finite numbers"))
    }

    fn balance(&self, ron: &BalanceRon) -> Result<BalanceSettings, SceneError> {
        let mut balance = ron.without.iter().fold(BalanceSettings::default(), |all, off| all.without(off.0));
        balance.arms = ron.arms;
        if let Some(x) = ron.ankle_stiffness {
            balance.ankle_stiffness = Some(self.within("balance.ankle_stiffness", x, 0.05, 20.0, "m g h")?);
        }
        Ok(balance)
    }
}
