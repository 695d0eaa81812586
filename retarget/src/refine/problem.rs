//! The least-squares problem of a stretch of a clip: cost, banded normal equations, steps.
//!
//! Unknowns in the order of time: basis function i of the stretch, degree of freedom d at `i·D + d`. What functions of
//! other stretches have moved already stays ([`windows`](super::windows)).

use std::ops::Range;

use dynamics::Penalty;
use motion::{Clip, Derivatives, Kinematics, Vec3};

use super::band::Band;
use super::basis::{Active, Basis, Stencils};
use super::local::FrameQuadratic;
use super::physics::{Forces, GroundSlope, Physics, Slopes};
use super::solids::{Penetration, Solids};
use super::{CONE_SHARE, INDEPENDENT_S, LEAST_DEVIATION_M, REFERENCE_HZ, REFERENCE_KG, SLIP_M};
use crate::Puppet;
use crate::options::{CONE, RefineDofs, RefineOptions, WorldOptions};
use motion::ik::JointAxes;
use motion::limits::{tangent_correction, tangent_correction_slopes};

/// Cost of a joint's way beyond its limits, 1/rad².
const LIMIT: f64 = 1e4;
/// Cost of a penetration, 1/m²: half at 1 mm.
const TOUCH: f64 = 1e6;
/// Weight of what is not vertical where only the root's height moves, as a share of a newton's.
const BESIDE: f64 = 0.6;
/// Least stiffness of the ground under a point in the metric of steps, as a share of the ground's own.
const LEAST_STIFFNESS: f64 = 0.05;

/// What a problem is stated with.
#[derive(Clone, Copy)]
pub(super) struct Setting<'a> {
    pub puppet: &'a Puppet,
    pub anchors: &'a [Vec<Option<[f64; 2]>>],
    pub variance: &'a [f64],
    /// Weight of the root's squared way up or down in every frame, 1/m².
    pub aloft: &'a [f64],
    pub world: &'a WorldOptions,
    pub options: &'a RefineOptions,
    pub solids: Option<&'a Solids>,
    pub length_m: f64,
    pub penalty: Penalty,
}

/// A stretch of a clip, and the functions that move it.
#[derive(Clone, Debug)]
pub(super) struct Stretch {
    /// Frames whose cost counts.
    pub counted: Range<usize>,
    /// Frames looked at: two more on either side where there are any, for the differences.
    pub frames: Range<usize>,
    /// The functions.
    pub functions: Range<usize>,
}

/// The problem of one stretch. See the module header.
pub(super) struct Problem<'a> {
    setting: Setting<'a>,
    stretch: Stretch,
    /// The stretch's frames before any displacement.
    base: Clip,
    /// The degrees of freedom that may move, and those that the stretch moves.
    all: &'a [usize],
    dofs: Vec<usize>,
    /// Index among the moved of each degree of freedom.
    moved: Vec<Option<usize>>,
    /// Weight of a newton of mismatch, per component of the residual; `None` without forces.
    force: Option<[f64; 6]>,
    physics: Physics,
    /// What acts in each frame.
    active: Vec<Active>,
    /// Displacement by functions of other stretches, `frames × all`.
    settled: Vec<f64>,
    /// Weights to begin with.
    begin: Vec<f64>,
    /// Feature points of the clip that is refined, per frame.
    reference: Vec<Vec3>,
    /// Heights of its root, m.
    heights: Vec<f64>,
    /// A frame's share of one at [`REFERENCE_HZ`].
    frame_share: f64,
    k: Kinematics,
    axes: JointAxes,
}

impl<'a> Problem<'a> {
    /// * `w`: of all functions and degrees of freedom; those that the stretch moves are where it begins
    pub fn new(
        setting: Setting<'a>,
        whole: &Clip,
        stretch: Stretch,
        (basis, w): (&Basis, &[f64]),
        (all, dofs): (&'a [usize], Vec<usize>),
        forces: bool,
    ) -> Self {
        let puppet = setting.puppet;
        let s = &puppet.character.skeleton;
        let (nq, d, rate) = (s.nq(), all.len(), whole.rate_hz);
        let mut moved = vec![None; s.nv()];
        dofs.iter().enumerate().for_each(|(i, &d)| moved[d] = Some(i));
        let frame_share = REFERENCE_HZ / rate;
        let unit = (setting.options.k1 * frame_share).sqrt() * REFERENCE_KG / puppet.character.mass();
        let alone = setting.options.dofs == RefineDofs::RootHeight;
        let beside = if alone { BESIDE * unit } else { unit };
        let around = beside / setting.length_m;
        let weights = [beside, unit, beside, around, around, around];
        let Range { start, end } = stretch.frames;
        let base = Clip::new(s.clone(), rate, whole.data()[start * nq..end * nq].to_vec());
        let stencils = Stencils::new(base.frames(), rate);
        let mut active = vec![Active::default(); base.frames()];
        let mut settled = vec![0.0; base.frames() * d];
        let (every, mut others) = (0..basis.len(), Active::default());
        let mut k = Kinematics::new(s, base.pose(0));
        let (mut reference, mut heights) = (Vec::new(), Vec::new());
        for i in 0..base.frames() {
            basis.sampled(&stencils, i, start as f64 / rate, &stretch.functions, &mut active[i]);
            basis.at((start + i) as f64 / rate, &every, &mut others);
            for (l, phi) in others.phi.iter().enumerate() {
                let function = others.first + l;
                let inside = stretch.functions.contains(&function);
                for j in (0..d).filter(|&j| !inside || moved[all[j]].is_none()) {
                    settled[i * d + j] += phi[0] * w[function * d + j];
                }
            }
            k.update(s, base.pose(i));
            reference.extend(puppet.features.points.iter().map(|p| k.point(p.link, &p.at)));
            heights.push(k.origin(0).y);
        }
        let columns: Vec<usize> = (0..d).filter(|&j| moved[all[j]].is_some()).collect();
        let begin =
            stretch.functions.clone().flat_map(|f| columns.iter().map(move |c| w[f * d + *c])).collect();
        Self {
            begin,
            physics: Physics::new(puppet, setting.penalty, Vec3::y() * -setting.world.gravity_m_s2),
            force: forces.then_some(weights),
            axes: JointAxes::new(s),
            base,
            setting,
            stretch,
            all,
            dofs,
            moved,
            active,
            settled,
            reference,
            heights,
            frame_share,
            k,
        }
    }

    /// The stretch moved by the functions that it solves for and those settled.
    pub(super) fn displaced(&self, w: &[f64]) -> Clip {
        let mut out = self.base.clone();
        let (skeleton, d) = (self.base.skeleton.clone(), self.dofs.len());
        let first = self.stretch.functions.start;
        let mut v = vec![0.0; skeleton.nv()];
        for (i, active) in self.active.iter().enumerate() {
            for (&dof, settled) in self.all.iter().zip(&self.settled[i * self.all.len()..]) {
                v[dof] = *settled;
            }
            for (j, &dof) in self.dofs.iter().enumerate() {
                let at = |l: usize| w[(active.first + l - first) * d + j];
                v[dof] += active.phi.iter().enumerate().map(|(l, phi)| phi[0] * at(l)).sum::<f64>();
            }
            skeleton.integrate(out.pose_mut(i), &v, 1.0);
        }
        out
    }

    /// Functions, degrees of freedom of each, frames at [`REFERENCE_HZ`] whose cost counts.
    pub(super) fn shape(&self) -> (usize, usize, f64) {
        (self.stretch.functions.len(), self.dofs.len(), self.frame_share * self.stretch.counted.len() as f64)
    }

    /// Weights to begin with.
    pub(super) fn begin(&self) -> Vec<f64> {
        self.begin.clone()
    }

    /// Whether forces count.
    pub(super) fn has_forces(&self) -> bool {
        self.force.is_some()
    }

    /// Frames whose cost counts, in the stretch and in the whole clip.
    fn counted(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        let from = self.stretch.frames.start;
        self.stretch.counted.clone().map(move |frame| (frame - from, frame))
    }

    /// By how much a force leaves the cone that is aimed at, N, its slope by the force, and whether anything touches.
    fn beyond_cone(&self, f: &Forces, frame: usize) -> Option<(f64, Vec3)> {
        if !self.setting.anchors[frame].iter().any(Option::is_some) {
            return None;
        }
        let (mu, across) = (CONE_SHARE * self.setting.world.friction, f.required.x.hypot(f.required.z));
        let beyond = across - mu * f.required.y;
        let out = if across > 1e-9 { 1.0 / across } else { 0.0 };
        (beyond > 0.0).then(|| (beyond, Vec3::new(f.required.x * out, -mu, f.required.z * out)))
    }

    /// Weight of a newton beyond the cone.
    fn cone_weight(&self, weights: &[f64; 6]) -> f64 {
        let alone = if self.setting.options.dofs == RefineDofs::RootHeight { 1.0 } else { CONE };
        weights[1] * self.setting.options.cone.unwrap_or(alone).sqrt()
    }

    /// Weight of a point's squared way in a frame: k₂ dt/(τ n σ²).
    fn prior_weight(&self, frame: usize) -> f64 {
        let n = self.setting.puppet.features.points.len() as f64;
        let variance = self.setting.variance[frame].max(LEAST_DEVIATION_M * LEAST_DEVIATION_M);
        self.setting.options.k2 / (variance * n * INDEPENDENT_S * self.base.rate_hz)
    }

    /// What a clip that is displaced by `w` costs.
    pub(super) fn cost(&mut self, clip: &Clip, w: &[f64]) -> f64 {
        let d = Derivatives::central(clip);
        let nv = clip.skeleton.nv();
        let mut sum = 0.5 * w.iter().map(|x| x * x).sum::<f64>();
        let points = self.setting.puppet.features.points.len();
        let mut touches: Vec<Penetration> = Vec::new();
        for (i, frame) in self.counted() {
            let (q, at) = (clip.pose(i), i * nv..(i + 1) * nv);
            if let Some(weights) = self.force {
                let f = self.physics.forces(q, &d.v[at.clone()], &d.vd[at], &self.setting.anchors[frame]);
                sum += 0.5 * (0..6).map(|c| (weights[c] * f.residual[c]).powi(2)).sum::<f64>();
                if let Some((beyond, _)) = self.beyond_cone(&f, frame) {
                    sum += 0.5 * (self.cone_weight(&weights) * beyond).powi(2);
                }
            }
            self.k.update(&clip.skeleton, q);
            let away: f64 = self
                .setting
                .puppet
                .features
                .points
                .iter()
                .zip(&self.reference[i * points..])
                .map(|(p, r)| (self.k.point(p.link, &p.at) - r).norm_squared())
                .sum();
            sum += 0.5 * self.prior_weight(frame) * away;
            let slips = self.slips(frame).map(|(_, _, slip)| slip.norm_squared()).sum::<f64>();
            sum += 0.5 * slips / self.slip_m().powi(2);
            let risen = self.k.origin(0).y - self.heights[i];
            sum += 0.5 * self.frame_share * self.setting.aloft[frame] * risen * risen;
            let links = 0..clip.skeleton.links().len();
            let beyond: f64 = links
                .filter_map(|l| tangent_correction(&clip.skeleton, q, l))
                .map(|e| e.norm_squared())
                .sum();
            sum += 0.5 * self.frame_share * LIMIT * beyond;
            if let Some(solids) = self.setting.solids {
                touches.clear();
                solids.penetrations(&self.k, &mut touches);
                sum += 0.5
                    * self.frame_share
                    * TOUCH
                    * touches.iter().map(|t| t.depth_m * t.depth_m).sum::<f64>();
            }
        }
        sum
    }

    /// Slip that costs one half in a frame, m. Without forces it is a tenth: the pass against collisions must not move the feet.
    fn slip_m(&self) -> f64 {
        let whole = if self.force.is_some() { SLIP_M } else { 0.1 * SLIP_M };
        whole / self.frame_share.sqrt()
    }

    /// Points in a phase in this frame: link, position, horizontal way from the anchor.
    fn slips(&self, frame: usize) -> impl Iterator<Item = (usize, Vec3, Vec3)> + '_ {
        let puppet = self.setting.puppet;
        let sites = puppet.character.skeleton.sites();
        puppet.contacts.iter().zip(&self.setting.anchors[frame]).filter_map(|(c, anchor)| {
            let a = (*anchor)?;
            let site = &sites[c.site];
            let p = self.k.point(site.link, &site.at);
            Some((site.link, p, Vec3::new(p.x - a[0], 0.0, p.z - a[1])))
        })
    }

    /// Normal matrix and gradient at a clip that is displaced by `w`; the metric of steps, where there are forces: with
    /// J of the contact points, `Σ_frames Σ_points (unit · stiffness)² JᵀJ`.
    pub(super) fn linearise(
        &mut self,
        (clip, w): (&Clip, &[f64]),
        ground: GroundSlope,
        normal: &mut Band,
        metric: &mut Band,
        gradient: &mut [f64],
    ) {
        let derivatives = Derivatives::central(clip);
        let (nv, d) = (clip.skeleton.nv(), self.dofs.len());
        normal.fill(0.0);
        metric.fill(0.0);
        for i in 0..normal.len() {
            *normal.at(i, i) = 1.0;
        }
        gradient.copy_from_slice(w);
        let mut slopes = Slopes::new(nv);
        let (mut local, mut stiff, mut none) =
            (FrameQuadratic::new(d), FrameQuadratic::new(d), vec![0.0; gradient.len()]);
        let down = self.base.skeleton.links()[0].parent_from_zero.rotation.inverse();
        for (i, frame) in self.counted() {
            let (q, at) = (clip.pose(i), i * nv..(i + 1) * nv);
            let (v, vd) = (&derivatives.v[at.clone()], &derivatives.vd[at]);
            local.clear();
            if let Some(weights) = self.force {
                let anchors = &self.setting.anchors[frame];
                let f = self.physics.forces(q, v, vd, anchors);
                self.physics.slopes(v, vd, anchors, (&f, ground), &mut slopes);
                for c in 0..6 {
                    for (order, by) in slopes.by.iter().enumerate() {
                        for (j, &dof) in self.dofs.iter().enumerate() {
                            local.row[order * d + j] = weights[c] * by[(c, dof)];
                        }
                    }
                    local.add_row(weights[c] * f.residual[c], 3 * d);
                }
                if let Some((beyond, by_force)) = self.beyond_cone(&f, frame) {
                    let (weight, by_force) = (self.cone_weight(&weights), down * by_force);
                    for (order, by) in slopes.by.iter().enumerate() {
                        for (j, &dof) in self.dofs.iter().enumerate() {
                            let slope: f64 = (0..3).map(|c| by_force[c] * by[(6 + c, dof)]).sum();
                            local.row[order * d + j] = weight * slope;
                        }
                    }
                    local.add_row(weight * beyond, 3 * d);
                }
            }
            self.geometry((i, frame), clip, q, &mut local);
            let active = &self.active[i];
            let first = active.first - self.stretch.functions.start;
            local.add_to(active, first, normal, gradient, self.force.is_some());
            if let Some(weights) = self.force {
                stiff.clear();
                self.stiffness(weights[1], &mut stiff);
                stiff.add_to(active, first, metric, &mut none, false);
            }
        }
    }

    /// Metric of one frame: how far the forces of the ground change with the contact points.
    fn stiffness(&self, unit: f64, local: &mut FrameQuadratic) {
        let puppet = self.setting.puppet;
        let sites = puppet.character.skeleton.sites();
        let least = LEAST_STIFFNESS * self.setting.penalty.k_p;
        for (c, stiffness) in puppet.contacts.iter().zip(self.physics.stiffness()) {
            let site = &sites[c.site];
            let p = self.k.point(site.link, &site.at);
            let weight = (unit * stiffness.max(least)).powi(2);
            self.point(site.link, &p, &Vec3::zeros(), weight, local);
        }
    }

    /// Terms that depend on the pose only.
    fn geometry(&mut self, (i, frame): (usize, usize), clip: &Clip, q: &[f64], local: &mut FrameQuadratic) {
        let puppet = self.setting.puppet;
        self.k.update(&clip.skeleton, q);
        self.axes.update(&clip.skeleton, &self.k);
        let points = &puppet.features.points;
        let weight = self.prior_weight(frame);
        for (p, r) in points.iter().zip(&self.reference[i * points.len()..]) {
            let at = self.k.point(p.link, &p.at);
            self.point(p.link, &at, &(at - r), weight, local);
        }
        let slips: Vec<_> = self.slips(frame).collect();
        for (link, at, slip) in slips {
            for (axis, error) in [(Vec3::x(), slip.x), (Vec3::z(), slip.z)] {
                self.along(link, &at, &axis, error, 1.0 / self.slip_m(), local);
            }
        }
        let aloft = self.frame_share * self.setting.aloft[frame];
        if aloft > 0.0 {
            let root = self.k.origin(0);
            self.along(0, &root, &Vec3::y(), root.y - self.heights[i], aloft.sqrt(), local);
        }
        self.limits(q, local, |local, r| local.add_row(r, local.d));
        if let Some(solids) = self.setting.solids {
            let (mut touches, touch) = (Vec::new(), (self.frame_share * TOUCH).sqrt());
            solids.penetrations(&self.k, &mut touches);
            for t in &touches {
                local.clear_row();
                let mut put = |link: usize, at: &Vec3, sign: f64| {
                    for &dof in &self.axes.chain[link] {
                        if let Some(j) = self.moved[dof] {
                            local.row[j] -= sign * touch * self.axes.all[dof].column(at).dot(&t.out);
                        }
                    }
                };
                put(t.first.0, &t.first.1, 1.0);
                if let Some((link, at)) = t.second {
                    put(link, &at, -1.0);
                }
                local.add_row(touch * t.depth_m, self.dofs.len());
            }
        }
    }

    /// Joints of a pose beyond their limits: each is put into `local.row`, its residual handed on.
    fn limits(&self, q: &[f64], local: &mut FrameQuadratic, mut put: impl FnMut(&mut FrameQuadratic, f64)) {
        let (skeleton, limit) = (&self.base.skeleton, (self.frame_share * LIMIT).sqrt());
        for l in 0..skeleton.links().len() {
            let Some(e) = tangent_correction(skeleton, q, l) else { continue };
            local.clear_row();
            for (a, slope) in tangent_correction_slopes(skeleton, q, l).into_iter().enumerate() {
                if let Some(j) = self.moved[skeleton.v_at(l) + a] {
                    local.row[j] = limit * slope;
                }
            }
            put(local, limit * e.norm());
        }
    }

    /// Adds limits that a step ran beyond to the normal equations it was made of, as if they had been met already; returns
    /// what they add to the cost before the step, 0 if there are none.
    ///
    /// A limit with residual `r` and slope J after a step Δ had `r − JΔ` before it: if that is not positive, the limit was not
    /// among the equations of the step. (Penetrations added in the same way gained nothing: the direction out of a ball is
    /// another one after every step.)
    pub(super) fn add_foreseen_limits(
        &self,
        moved: &Clip,
        step: &[f64],
        normal: &mut Band,
        gradient: &mut [f64],
    ) -> f64 {
        let d = self.dofs.len();
        let (mut local, mut way, mut cost) = (FrameQuadratic::new(d), vec![0.0; d], 0.0);
        for (i, _) in self.counted() {
            let active = &self.active[i];
            let first = active.first - self.stretch.functions.start;
            for (j, x) in way.iter_mut().enumerate() {
                let terms = active.phi.iter().enumerate();
                *x = terms.map(|(l, phi)| phi[0] * step[(first + l) * d + j]).sum();
            }
            local.clear();
            let mut found = false;
            self.limits(moved.pose(i), &mut local, |local, r| {
                let before = r - local.row.iter().zip(&way).map(|(j, x)| j * x).sum::<f64>();
                if before <= 0.0 {
                    local.add_row(before, d);
                    cost += 0.5 * before * before;
                    found = true;
                }
            });
            if found {
                local.add_to(active, first, normal, gradient, false);
            }
        }
        cost
    }

    /// ½ weight |error|² of a point.
    fn point(&self, link: usize, at: &Vec3, error: &Vec3, weight: f64, local: &mut FrameQuadratic) {
        let d = local.d;
        local.chain.clear();
        for &dof in &self.axes.chain[link] {
            if let Some(j) = self.moved[dof] {
                local.chain.push((j, self.axes.all[dof].column(at)));
            }
        }
        for a in 0..local.chain.len() {
            let (i, c) = local.chain[a];
            local.gradient[i] += weight * c.dot(error);
            for &(j, other) in &local.chain[..=a] {
                local.q[i * 3 * d + j] += weight * c.dot(&other);
            }
        }
    }

    /// ½ (scale · error)² of a point's coordinate along a direction.
    fn along(&self, link: usize, at: &Vec3, axis: &Vec3, error: f64, scale: f64, local: &mut FrameQuadratic) {
        local.clear_row();
        for &dof in &self.axes.chain[link] {
            if let Some(j) = self.moved[dof] {
                local.row[j] = scale * self.axes.all[dof].column(at).dot(axis);
            }
        }
        local.add_row(scale * error, self.dofs.len());
    }
}
