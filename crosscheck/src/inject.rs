//! Faults put in on purpose: does the cross-check see them?
//!
//! In: a word such as `mass:chest*1.01`. Out: a character that is wrong in one number. A check that cannot
//! fail says nothing; this is how anybody can see it fail.

use std::str::FromStr;
use std::sync::Arc;

use bodies::Character;
use motion::names::nearest;
use motion::{Joint, Skeleton, Vec3};

/// One wrong number.
#[derive(Clone, Debug, PartialEq)]
pub enum Injection {
    /// `mass:LINK*FACTOR`: mass and inertia of a link times a factor.
    Mass {
        /// The link.
        link: String,
        /// The factor.
        factor: f64,
    },
    /// `com:LINK+X,Y,Z`: centre of mass of a link moved by metres in its frame.
    Com {
        /// The link.
        link: String,
        /// By how much, m.
        by: [f64; 3],
    },
    /// `axis:LINK=X,Y,Z`: axis of a hinge or slide turned to this direction of its zero frame.
    Axis {
        /// The link.
        link: String,
        /// The direction.
        to: [f64; 3],
    },
}

/// A text that is no [`Injection`].
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("`{0}` is no fault; allowed: mass:LINK*FACTOR, com:LINK+X,Y,Z (m), axis:LINK=X,Y,Z")]
pub struct InjectionSyntax(String);

/// An injection that does not fit the body.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum InjectionError {
    /// No such link.
    #[error("unknown link `{name}`{hint}")]
    Unknown {
        /// The name found.
        name: String,
        /// `; did you mean …?`.
        hint: String,
    },
    /// A joint without an axis.
    #[error("the joint of `{0}` has no axis to turn: it is no hinge and no slide")]
    NoAxis(String),
}

impl FromStr for Injection {
    type Err = InjectionSyntax;

    fn from_str(text: &str) -> Result<Self, InjectionSyntax> {
        let wrong = || InjectionSyntax(text.into());
        let (what, rest) = text.split_once(':').ok_or_else(wrong)?;
        let three = |s: &str| -> Option<[f64; 3]> {
            let all: Vec<f64> = s.split(',').map(|x| x.trim().parse().ok()).collect::<Option<_>>()?;
            all.try_into().ok().filter(|v: &[f64; 3]| v.iter().all(|x| x.is_finite()))
        };
        let found = match what {
            "mass" => rest.rsplit_once('*').and_then(|(link, factor)| {
                let factor = factor.parse().ok().filter(|f: &f64| *f > 0.0 && f.is_finite())?;
                Some(Self::Mass { link: link.into(), factor })
            }),
            "com" => rest
                .rsplit_once('+')
                .and_then(|(link, by)| Some(Self::Com { link: link.into(), by: three(by)? })),
            "axis" => rest.rsplit_once('=').and_then(|(link, to)| {
                let to = three(to).filter(|t| Vec3::from(*t).norm() > 1e-6)?;
                Some(Self::Axis { link: link.into(), to })
            }),
            _ => None,
        };
        found.ok_or_else(wrong)
    }
}

impl Injection {
    /// The character with the fault in it.
    ///
    /// # Errors
    /// [`InjectionError`].
    pub fn apply(&self, character: &Character) -> Result<Character, InjectionError> {
        let (Self::Mass { link, .. } | Self::Com { link, .. } | Self::Axis { link, .. }) = self;
        let skeleton = &character.skeleton;
        let index = skeleton.link(link).ok_or_else(|| {
            let names = skeleton.links().iter().map(|l| l.name.as_str());
            let hint = nearest(link, names).map(|n| format!("; did you mean `{n}`?")).unwrap_or_default();
            InjectionError::Unknown { name: link.clone(), hint }
        })?;
        let mut out = character.clone();
        match self {
            Self::Mass { factor, .. } => {
                out.bodies[index].mass *= factor;
                out.bodies[index].inertia *= *factor;
            }
            Self::Com { by, .. } => out.bodies[index].com += Vec3::from(*by),
            Self::Axis { to, .. } => {
                let mut links = skeleton.links().to_vec();
                let axis = Vec3::from(*to).normalize();
                links[index].joint = match links[index].joint {
                    Joint::Revolute(_) => Joint::Revolute(axis),
                    Joint::Prismatic(_) => Joint::Prismatic(axis),
                    _ => return Err(InjectionError::NoAxis(link.clone())),
                };
                let turned = Skeleton::new(links)
                    .and_then(|s| s.with_sites(skeleton.sites().to_vec()))
                    .and_then(|s| s.with_limbs(skeleton.limbs().to_vec()))
                    .and_then(|s| s.with_parts(skeleton.parts().clone()));
                out.skeleton = Arc::new(turned.expect("only an axis has changed"));
            }
        }
        Ok(out)
    }
}
