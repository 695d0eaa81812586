//! A pose as a person asks for it: joints dragged and pinned by name.
//!
//! In: a [`PoseRequest`], a skeleton and a pose. Out: a [`PoseAnswer`]: the pose that [`motion::ik::pose`] gives, what is
//! different, and what could not be met. The words are those of scenes and of the command line.
//!
//! A name is that of a joint (a link: where it hangs on its parent) or of a site (a point of a link). Places: m, world, Y up.

use std::sync::Arc;

use motion::ik::pose::{Handle, Hold, PoseError, Poser, Rules};
use motion::{Kinematics, Skeleton, Vec3};

use crate::EditError;

/// Most that a dragged point goes from one Newton solution to the next, m.
const STRIDE_M: f64 = 0.01;

/// What is asked. See the module header.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PoseRequest {
    /// Joints or sites, and where they are dragged to, m.
    pub drag: Vec<(String, [f64; 3])>,
    /// Joints or sites that stay exactly where they are.
    pub pin: Vec<String>,
    /// How firmly a joint goes where it is dragged, or stays where it was; 1 if not named.
    pub weight: Vec<(String, f64)>,
    /// Joints that move as one rigid piece, for each piece.
    pub group: Vec<Vec<String>>,
    /// Whether joints keep their limits.
    pub limits: bool,
}

/// How far one handle is from where it should be.
#[derive(Clone, Debug, PartialEq)]
pub struct Met {
    /// As named.
    pub name: String,
    /// Whether it was pinned.
    pub pinned: bool,
    /// Where it was, world, m.
    pub from: Vec3,
    /// Where it should be, world, m.
    pub to: Vec3,
    /// Distance left, m.
    pub miss_m: f64,
}

/// What comes of a request.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseAnswer {
    /// The pose (`nq`).
    pub pose: Vec<f64>,
    /// From the pose given to this one, as [`Skeleton::difference`] has it (`nv`); zeros, all of them, where nothing moved.
    pub delta: Vec<f64>,
    /// The handles: what was dragged, then what was pinned, in the order named.
    pub met: Vec<Met>,
    /// The largest change of a distance between a joint and its parent, m, slides left out.
    pub bone_residue_m: f64,
    /// Whether the body came to rest; if not, more calls would move it a little further.
    pub still: bool,
}

impl PoseAnswer {
    /// The largest miss of a pin, m; 0 without pins.
    pub fn pin_residue_m(&self) -> f64 {
        self.met.iter().filter(|m| m.pinned).fold(0.0, |worst, m| worst.max(m.miss_m))
    }
}

impl PoseRequest {
    /// The pose that is asked for, from the pose `q` (`nq`).
    ///
    /// # Errors
    /// Unknown names, numbers that are not finite, weights below 0, pieces of one joint, one point at two places, nothing dragged.
    pub fn solve(
        &self,
        edit: &'static str,
        skeleton: &Arc<Skeleton>,
        q: &[f64],
    ) -> Result<PoseAnswer, EditError> {
        let s = skeleton;
        let fault = |source| EditError::Pose { edit, source };
        if self.drag.is_empty() {
            return Err(EditError::NothingDragged { edit });
        }
        if self.limits && s.links().iter().all(|l| l.limits.is_none()) {
            return Err(EditError::NoLimits { edit });
        }
        let k = Kinematics::new(s, q);
        let mut weights = vec![1.0; s.links().len()];
        let mut of_drag = vec![1.0; self.drag.len()];
        for (name, weight) in &self.weight {
            if !(*weight >= 0.0 && weight.is_finite()) {
                let (link, weight) = (name.clone(), *weight);
                return Err(fault(PoseError::Weight { link, weight, allowed: "finite, 0 or more" }));
            }
            match self.drag.iter().position(|(dragged, _)| dragged == name) {
                Some(i) => of_drag[i] = *weight,
                None => weights[joint(s, name)?] = *weight,
            }
        }
        let (mut handles, mut met) = (Vec::new(), Vec::new());
        let mut add = |name: &String, to: Option<Vec3>, hold: Hold| -> Result<(), EditError> {
            let (link, at) = point(s, name)?;
            let from = k.point(link, &at);
            let place = to.unwrap_or(from);
            handles.push(Handle { link, at, place, hold });
            met.push(Met { name: name.clone(), pinned: hold == Hold::Pinned, from, to: place, miss_m: 0.0 });
            Ok(())
        };
        for ((name, to), weight) in self.drag.iter().zip(of_drag) {
            add(name, Some(Vec3::from(*to)), Hold::Dragged(weight))?;
        }
        for name in &self.pin {
            add(name, None, Hold::Pinned)?;
        }
        let named = |group: &Vec<String>| group.iter().map(|name| joint(s, name)).collect();
        let groups = self.group.iter().map(named).collect::<Result<Vec<Vec<usize>>, _>>()?;
        let mut poser = Poser::new(s);
        let rules = Rules { weights: &weights, groups: &groups, limits: self.limits };
        poser.begin(q, rules).map_err(fault)?;
        let mut pose = q.to_vec();
        let posed = poser.walk(&handles, STRIDE_M, &mut pose).map_err(fault)?;
        for (met, miss) in met.iter_mut().zip(poser.misses()) {
            met.miss_m = *miss;
        }
        let mut delta = vec![0.0; s.nv()];
        if pose != q {
            s.difference(q, &pose, 1.0, &mut delta);
        }
        let after = Kinematics::new(s, &pose);
        let mut bone_residue_m = 0.0_f64;
        for (i, link) in s.links().iter().enumerate() {
            let Some(p) = link.parent.filter(|_| !matches!(link.joint, motion::Joint::Prismatic(_))) else {
                continue;
            };
            let length = |k: &Kinematics| (k.origin(i) - k.origin(p)).norm();
            bone_residue_m = bone_residue_m.max((length(&after) - length(&k)).abs());
        }
        Ok(PoseAnswer { pose, delta, met, bone_residue_m, still: posed.still })
    }
}

/// The link of a joint.
fn joint(s: &Skeleton, name: &str) -> Result<usize, EditError> {
    s.link(name).ok_or_else(|| EditError::unknown("joint", name, s.links().iter().map(|l| l.name.as_str())))
}

/// The link and place of a joint or site.
pub(crate) fn point(s: &Skeleton, name: &str) -> Result<(usize, Vec3), EditError> {
    if let Some(link) = s.link(name) {
        return Ok((link, Vec3::zeros()));
    }
    if let Some(site) = s.site(name) {
        return Ok((site.link, site.at));
    }
    let links = s.links().iter().map(|l| l.name.as_str());
    let sites = s.sites().iter().map(|site| site.name.as_str());
    let what = if s.sites().is_empty() { "joint" } else { "joint or site" };
    Err(EditError::unknown(what, name, links.chain(sites)))
}
