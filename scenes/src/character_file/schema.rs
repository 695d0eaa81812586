//! What a character file may say, as serde sees it.

use std::collections::BTreeMap;

use bodies::JointClass;
use motion::LimbKind;
use serde::Deserialize;

use crate::angle::Angle;
use crate::schema::Named;

pub(super) type V3 = (f64, f64, f64);

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename = "Character")]
pub(super) struct CharacterRon {
    pub(super) name: String,
    pub(super) links: Vec<LinkRon>,
    #[serde(default)]
    pub(super) sites: Vec<SiteRon>,
    #[serde(default)]
    pub(super) contacts: Vec<String>,
    #[serde(default)]
    pub(super) follows: BTreeMap<String, FollowRon>,
    #[serde(default)]
    pub(super) sways: BTreeMap<String, SwayRon>,
    #[serde(default)]
    pub(super) limbs: Vec<LimbRon>,
    #[serde(default)]
    pub(super) parts: BTreeMap<String, Vec<String>>,
    #[serde(default)]
    pub(super) rest: RestRon,
}

/// A part that follows by dynamics.
#[derive(Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields, rename = "Sway")]
pub(super) struct SwayRon {
    pub(super) frequency_hz: f64,
    pub(super) damping_ratio: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename = "Link")]
pub(super) struct LinkRon {
    pub(super) name: String,
    pub(super) parent: Option<String>,
    #[serde(default)]
    pub(super) offset_m: V3,
    #[serde(default)]
    pub(super) rotation_deg: V3,
    pub(super) joint: JointRon,
    pub(super) limits_deg: Option<LimitsRon>,
    pub(super) limits_m: Option<(f64, f64)>,
    pub(super) class: Named<JointClass>,
    pub(super) density_kg_m3: Option<f64>,
    pub(super) mass_kg: Option<f64>,
    pub(super) com_m: Option<V3>,
    pub(super) inertia_kg_m2: Option<(f64, f64, f64, f64, f64, f64)>,
    pub(super) color: Option<String>,
    #[serde(default)]
    pub(super) shapes: Vec<ShapeRon>,
    pub(super) end_m: Option<V3>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename = "joint")]
pub(super) enum JointRon {
    Free,
    Ball,
    Hinge(f64, f64, f64),
    Slide(f64, f64, f64),
    Fixed,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename = "limits")]
pub(super) enum LimitsRon {
    Hinge(f64, f64),
    Ball { axes: (V3, V3, V3), swing_1: (f64, f64), swing_2: (f64, f64), twist: (f64, f64) },
}

#[derive(Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields, rename = "shape")]
pub(super) enum ShapeRon {
    Capsule {
        a_m: V3,
        b_m: V3,
        radius_m: f64,
    },
    Box {
        center_m: V3,
        half_m: V3,
        #[serde(default)]
        rotation_deg: V3,
    },
    Sphere {
        center_m: V3,
        radius_m: f64,
    },
    Cone {
        a_m: V3,
        b_m: V3,
        radius_a_m: f64,
        radius_b_m: f64,
    },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename = "Site")]
pub(super) struct SiteRon {
    pub(super) name: String,
    pub(super) link: String,
    pub(super) at_m: V3,
}

/// Human contact points whose contact a point takes over.
#[derive(Deserialize)]
#[serde(rename = "follow")]
pub(super) enum FollowRon {
    /// While at least one of them touches the ground.
    Any(Vec<String>),
    /// Only while all of them do.
    All(Vec<String>),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename = "Limb")]
pub(super) struct LimbRon {
    pub(super) name: String,
    pub(super) kind: Named<LimbKind>,
    pub(super) upper: String,
    pub(super) lower: String,
    pub(super) end: String,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields, rename = "Rest")]
pub(super) struct RestRon {
    #[serde(default)]
    pub(super) root_m: V3,
    #[serde(default)]
    pub(super) joints_deg: BTreeMap<String, Angle>,
}
