//! The words of MJCF, and what becomes of each.
//!
//! A word that is not here is an error. Source: `mj_printSchema` of MuJoCo 4.0.0.

use crate::model_file::Effect;
use crate::vocabulary::{
    Fate::{self, Listed, Never, Taken},
    Part,
    Use::{self, Look, Nonzero, Physics, Read, Refused},
    Word,
};

const CONTACT: Use = Physics("contact parameters");
const LIMIT: Use = Physics("stiffness of limits");
const ACTUATOR: Use = Physics("actuator forces");
const PASSIVE: Use = Nonzero("passive forces");
const DRAWN: Use = Look("look");
const SETTINGS: Use = Look("settings of MuJoCo");
const FLUID: Use = Nonzero("forces of a fluid");

pub const MUJOCO: &[Word] = &[("model", Read)];
pub const DEFAULT: &[Word] = &[("class", Read)];
pub const COMPILER: &[Word] = &[
    ("angle", Read),
    ("autolimits", Read),
    ("eulerseq", Read),
    ("coordinate", Read),
    ("inertiafromgeom", Read),
    ("inertiagrouprange", Read),
    ("meshdir", Read),
    ("assetdir", Read),
    ("strippath", Read),
    ("fusestatic", Read),
    ("discardvisual", Read),
    ("alignfree", Refused("it moves the frames of free bodies; set it to false")),
    ("balanceinertia", Refused("inertias are taken as they are; write physical ones")),
    ("boundinertia", Refused("inertias are taken as they are; write the bounded ones")),
    ("boundmass", Refused("masses are taken as they are; write the bounded ones")),
    ("passthrough", Refused("it hands the file to another reader")),
    ("settotalmass", Read),
    ("texturedir", DRAWN),
    ("conflict", SETTINGS),
    ("convexhull", SETTINGS),
    ("exactmeshinertia", SETTINGS),
    ("fitaabb", SETTINGS),
    ("savecanonical", SETTINGS),
    ("savecompiled", SETTINGS),
    ("saveinertial", SETTINGS),
    ("usethread", SETTINGS),
];
pub const OPTION: &[Word] = &[
    ("gravity", Read),
    ("density", FLUID),
    ("viscosity", FLUID),
    ("wind", FLUID),
    ("magnetic", SETTINGS),
    ("o_friction", CONTACT),
    ("o_margin", CONTACT),
    ("o_solimp", CONTACT),
    ("o_solref", CONTACT),
    ("impratio", CONTACT),
    ("cone", CONTACT),
    ("actuatorgroupdisable", ACTUATOR),
    ("apirate", SETTINGS),
    ("ccd_iterations", SETTINGS),
    ("ccd_tolerance", SETTINGS),
    ("collision", SETTINGS),
    ("integrator", SETTINGS),
    ("iterations", SETTINGS),
    ("jacobian", SETTINGS),
    ("ls_iterations", SETTINGS),
    ("ls_tolerance", SETTINGS),
    ("mpr_iterations", SETTINGS),
    ("mpr_tolerance", SETTINGS),
    ("noslip_iterations", SETTINGS),
    ("noslip_tolerance", SETTINGS),
    ("sdf_initpoints", SETTINGS),
    ("sdf_iterations", SETTINGS),
    ("sleep_tolerance", SETTINGS),
    ("solver", SETTINGS),
    ("timestep", SETTINGS),
    ("tolerance", SETTINGS),
];
pub const FLAG: &[Word] = &[
    ("gravity", Read),
    ("actuation", Physics("switch of MuJoCo")),
    ("clampctrl", Physics("switch of MuJoCo")),
    ("constraint", Physics("switch of MuJoCo")),
    ("contact", Physics("switch of MuJoCo")),
    ("damper", Physics("switch of MuJoCo")),
    ("equality", Physics("switch of MuJoCo")),
    ("filterparent", Physics("switch of MuJoCo")),
    ("frictionloss", Physics("switch of MuJoCo")),
    ("limit", Physics("switch of MuJoCo")),
    ("override", Physics("switch of MuJoCo")),
    ("passive", Physics("switch of MuJoCo")),
    ("refsafe", Physics("switch of MuJoCo")),
    ("spring", Physics("switch of MuJoCo")),
    ("speculative", Physics("switch of MuJoCo")),
    ("autoreset", SETTINGS),
    ("diagexact", SETTINGS),
    ("energy", SETTINGS),
    ("eulerdamp", SETTINGS),
    ("fwdinv", SETTINGS),
    ("invdiscrete", SETTINGS),
    ("ipc", SETTINGS),
    ("island", SETTINGS),
    ("midphase", SETTINGS),
    ("multiccd", SETTINGS),
    ("nativeccd", SETTINGS),
    ("sensor", SETTINGS),
    ("sleep", SETTINGS),
    ("warmstart", SETTINGS),
];
pub const BODY: &[Word] = &[
    ("name", Read),
    ("childclass", Read),
    ("pos", Read),
    ("quat", Read),
    ("axisangle", Read),
    ("xyaxes", Read),
    ("zaxis", Read),
    ("euler", Read),
    ("fuse", SETTINGS),
    ("simple", SETTINGS),
    ("sleep", SETTINGS),
    ("user", SETTINGS),
    ("gravcomp", PASSIVE),
    ("mocap", Nonzero("moved from outside")),
];
pub const FRAME: &[Word] = &[
    ("name", Read),
    ("childclass", Read),
    ("pos", Read),
    ("quat", Read),
    ("axisangle", Read),
    ("xyaxes", Read),
    ("zaxis", Read),
    ("euler", Read),
];
pub const INERTIAL: &[Word] = &[
    ("pos", Read),
    ("mass", Read),
    ("diaginertia", Read),
    ("fullinertia", Read),
    ("quat", Read),
    ("axisangle", Read),
    ("xyaxes", Read),
    ("zaxis", Read),
    ("euler", Read),
];
pub const JOINT: &[Word] = &[
    ("name", Read),
    ("class", Read),
    ("type", Read),
    ("pos", Read),
    ("axis", Read),
    ("range", Read),
    ("limited", Read),
    ("ref", Read),
    ("group", DRAWN),
    ("user", SETTINGS),
    ("armature", Nonzero("rotor inertia")),
    ("damping", PASSIVE),
    ("frictionloss", PASSIVE),
    ("stiffness", PASSIVE),
    ("springdamper", PASSIVE),
    ("springref", PASSIVE),
    ("springyield", PASSIVE),
    ("margin", LIMIT),
    ("solimplimit", LIMIT),
    ("solreflimit", LIMIT),
    ("solimpfriction", LIMIT),
    ("solreffriction", LIMIT),
    ("actuatorfrclimited", ACTUATOR),
    ("actuatorfrcrange", ACTUATOR),
    ("actuatorgravcomp", ACTUATOR),
];
pub const FREEJOINT: &[Word] = &[
    ("name", Read),
    ("group", DRAWN),
    ("align", Refused("it moves the frame of the body; set it to false")),
];
pub const GEOM: &[Word] = &[
    ("name", Read),
    ("class", Read),
    ("type", Read),
    ("size", Read),
    ("pos", Read),
    ("quat", Read),
    ("axisangle", Read),
    ("xyaxes", Read),
    ("zaxis", Read),
    ("euler", Read),
    ("fromto", Read),
    ("mass", Read),
    ("density", Read),
    ("group", Read),
    ("contype", Read),
    ("conaffinity", Read),
    ("mesh", Read),
    ("hfield", Read),
    ("shellinertia", Refused("inertia is that of the solid; give the body <inertial>")),
    ("castshadow", DRAWN),
    ("material", DRAWN),
    ("rgba", DRAWN),
    ("user", SETTINGS),
    ("fitscale", SETTINGS),
    ("fluidcoef", FLUID),
    ("fluidshape", Physics("forces of a fluid")),
    ("adhesion", CONTACT),
    ("condim", CONTACT),
    ("friction", CONTACT),
    ("gap", CONTACT),
    ("margin", CONTACT),
    ("priority", CONTACT),
    ("solimp", CONTACT),
    ("solmix", CONTACT),
    ("solref", CONTACT),
    ("surfacevel", CONTACT),
];
/// Of the key frame `rest`.
pub const KEY: &[Word] = &[
    ("name", Read),
    ("qpos", Read),
    ("time", Look("state to start from")),
    ("qvel", Look("state to start from")),
    ("act", Look("state to start from")),
    ("ctrl", Look("state to start from")),
    ("mpos", Look("state to start from")),
    ("mquat", Look("state to start from")),
];
pub const SITE: &[Word] = &[
    ("name", Read),
    ("class", Read),
    ("pos", Read),
    ("fromto", Read),
    ("quat", DRAWN),
    ("axisangle", DRAWN),
    ("xyaxes", DRAWN),
    ("zaxis", DRAWN),
    ("euler", DRAWN),
    ("group", DRAWN),
    ("material", DRAWN),
    ("mesh", DRAWN),
    ("rgba", DRAWN),
    ("size", DRAWN),
    ("type", DRAWN),
    ("user", SETTINGS),
];

const LISTED_LOOK: Fate = Listed(Effect::Look, "look");
const LISTED_SETTINGS: Fate = Listed(Effect::Look, "settings of MuJoCo");
const LISTED_ACTUATOR: Fate = Listed(Effect::Physics, "actuator");
const LISTED_SENSORS: Fate = Listed(Effect::Look, "sensors: they measure and exert no force");
const LISTED_EQUALITY: Fate = Listed(Effect::Physics, "equality constraint");
const LISTED_TENDON: Fate = Listed(Effect::Physics, "tendon");
const LISTED_CONTACT: Fate = Listed(Effect::Physics, "contact rule");
const WRITE_OUT: Fate = Never(
    "it makes bodies while MuJoCo compiles; let MuJoCo save the compiled model (`compile model.xml out.xml`)",
);
const SOFT: Fate = Never("soft bodies are not read");
const PLUGIN: Fate = Never("plugins are not read");

/// Children of `<mujoco>`.
pub const SECTIONS: &[Part] = &[
    ("compiler", Taken),
    ("option", Taken),
    ("default", Taken),
    ("asset", Taken),
    ("worldbody", Taken),
    ("size", LISTED_SETTINGS),
    ("statistic", LISTED_SETTINGS),
    ("visual", LISTED_LOOK),
    ("custom", LISTED_SETTINGS),
    ("contact", Taken),
    ("tendon", Taken),
    ("equality", Taken),
    ("actuator", Taken),
    ("sensor", LISTED_SENSORS),
    ("keyframe", Taken),
    ("deformable", Taken),
    ("extension", Taken),
];

/// Children of a section of which nothing is read.
pub fn section_parts(section: &str) -> &'static [Part] {
    match section {
        "contact" => CONTACTS,
        "tendon" => TENDONS,
        "equality" => EQUALITIES,
        "actuator" => ACTUATORS,
        "keyframe" => &[("key", Taken)],
        "deformable" => &[("flex", SOFT), ("skin", LISTED_LOOK)],
        "extension" => &[("plugin", PLUGIN)],
        "asset" => ASSETS,
        _ => &[],
    }
}

const ASSETS: &[Part] = &[
    ("mesh", Taken),
    ("hfield", Listed(Effect::Look, "scenery")),
    ("skin", LISTED_LOOK),
    ("texture", LISTED_LOOK),
    ("material", LISTED_LOOK),
    ("model", WRITE_OUT),
];
const CONTACTS: &[Part] = &[("pair", LISTED_CONTACT), ("exclude", LISTED_CONTACT)];
const TENDONS: &[Part] = &[("spatial", LISTED_TENDON), ("fixed", LISTED_TENDON)];
const EQUALITIES: &[Part] = &[
    ("connect", LISTED_EQUALITY),
    ("weld", LISTED_EQUALITY),
    ("joint", LISTED_EQUALITY),
    ("tendon", LISTED_EQUALITY),
    ("flex", LISTED_EQUALITY),
    ("flexvert", LISTED_EQUALITY),
    ("flexstrain", LISTED_EQUALITY),
    ("distance", LISTED_EQUALITY),
];
const ACTUATORS: &[Part] = &[
    ("general", LISTED_ACTUATOR),
    ("motor", LISTED_ACTUATOR),
    ("position", LISTED_ACTUATOR),
    ("velocity", LISTED_ACTUATOR),
    ("intvelocity", LISTED_ACTUATOR),
    ("orientation", LISTED_ACTUATOR),
    ("pid", LISTED_ACTUATOR),
    ("damper", LISTED_ACTUATOR),
    ("cylinder", LISTED_ACTUATOR),
    ("muscle", LISTED_ACTUATOR),
    ("adhesion", LISTED_ACTUATOR),
    ("dcmotor", LISTED_ACTUATOR),
    ("plugin", PLUGIN),
];

/// Settings inside `<default>`.
pub const SETTINGS_IN_DEFAULT: &[Part] = &[
    ("default", Taken),
    ("geom", Taken),
    ("joint", Taken),
    ("site", Taken),
    ("mesh", LISTED_LOOK),
    ("texture", LISTED_LOOK),
    ("material", LISTED_LOOK),
    ("camera", LISTED_LOOK),
    ("light", LISTED_LOOK),
    ("pair", LISTED_CONTACT),
    ("equality", LISTED_EQUALITY),
    ("tendon", LISTED_TENDON),
    ("general", LISTED_ACTUATOR),
    ("motor", LISTED_ACTUATOR),
    ("position", LISTED_ACTUATOR),
    ("velocity", LISTED_ACTUATOR),
    ("intvelocity", LISTED_ACTUATOR),
    ("orientation", LISTED_ACTUATOR),
    ("pid", LISTED_ACTUATOR),
    ("damper", LISTED_ACTUATOR),
    ("cylinder", LISTED_ACTUATOR),
    ("muscle", LISTED_ACTUATOR),
    ("adhesion", LISTED_ACTUATOR),
    ("dcmotor", LISTED_ACTUATOR),
];

/// Children of `<body>` and `<worldbody>`.
pub const IN_BODY: &[Part] = &[
    ("body", Taken),
    ("inertial", Taken),
    ("joint", Taken),
    ("freejoint", Taken),
    ("geom", Taken),
    ("site", Taken),
    ("camera", LISTED_LOOK),
    ("light", LISTED_LOOK),
    ("plugin", PLUGIN),
    ("frame", Taken),
    ("replicate", WRITE_OUT),
    ("attach", WRITE_OUT),
    ("composite", WRITE_OUT),
    ("flexcomp", WRITE_OUT),
];

/// Children of `<frame>`.
pub const IN_FRAME: &[Part] = &[
    ("body", Taken),
    ("frame", Taken),
    ("joint", Taken),
    ("freejoint", Taken),
    ("geom", Taken),
    ("site", Taken),
    ("camera", LISTED_LOOK),
    ("light", LISTED_LOOK),
    ("plugin", PLUGIN),
    ("replicate", WRITE_OUT),
    ("attach", WRITE_OUT),
    ("composite", WRITE_OUT),
    ("flexcomp", WRITE_OUT),
];
