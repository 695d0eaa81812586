//! The least-squares problem of the refinement: cost, banded normal equations, steps.
//!
//! Unknowns `w` in the order of time: basis function i, degree of freedom d at `i·D + d`. In one frame the cost is a
//! quadratic in `x = (δ, δ̇, δ̈)` of the moved degrees of freedom, with matrix Q (3D × 3D) and gradient g; the
//! 17 functions that act there carry it to the unknowns: `A_{il} += Σ_ab φᵃ_i φᵇ_l Q_ab`.

use dynamics::Penalty;
use motion::{Clip, Derivatives, Kinematics, Vec3};
use nalgebra::{DMatrix, DVector};

use super::band::Band;
use super::basis::{Active, Basis};
use super::physics::{Physics, Slopes};
use super::solids::{Solids, Touch};
use super::{GRAVITY, INDEPENDENT_S, LEAST_DEVIATION_M, REFERENCE_KG, SLIP_M};
use crate::axes::Axes;
use crate::limits::way_back;
use crate::options::RefineOptions;
use crate::{Puppet, RetargetError};

/// Cost of a joint's way beyond its limits, 1/rad².
const LIMIT: f64 = 1e4;
/// Cost of a penetration, 1/m²: half at 1 mm.
const TOUCH: f64 = 1e6;
/// A step that lowers the cost by less than this share is the last.
const ENOUGH: f64 = 1e-3;

/// What a problem is stated with.
#[derive(Clone, Copy)]
pub(super) struct Setting<'a> {
    pub puppet: &'a Puppet,
    pub anchors: &'a [Vec<Option<[f64; 2]>>],
    pub variance: &'a [f64],
    pub options: &'a RefineOptions,
    pub solids: Option<&'a Solids>,
    pub length_m: f64,
    pub penalty: Penalty,
}

/// The problem of one clip. See the module header.
pub(super) struct Problem<'a> {
    setting: Setting<'a>,
    base: Clip,
    dofs: Vec<usize>,
    /// Index among the moved of each degree of freedom.
    moved: Vec<Option<usize>>,
    /// Weight of a newton of mismatch, and per component of the residual.
    force: Option<[f64; 6]>,
    physics: Physics,
    basis: Basis,
    /// Feature points of the clip that is refined, per frame.
    reference: Vec<Vec3>,
    k: Kinematics,
    axes: Axes,
}

impl<'a> Problem<'a> {
    pub fn new(setting: Setting<'a>, base: &Clip, dofs: Vec<usize>, forces: bool) -> Self {
        let puppet = setting.puppet;
        let s = &puppet.character.skeleton;
        let mut moved = vec![None; s.nv()];
        dofs.iter().enumerate().for_each(|(i, &d)| moved[d] = Some(i));
        let unit = setting.options.k1.sqrt() * REFERENCE_KG / puppet.character.mass();
        let weights = std::array::from_fn(|i| if i < 3 { unit } else { unit / setting.length_m });
        let mut k = Kinematics::new(s, base.pose(0));
        let mut reference = Vec::new();
        for i in 0..base.frames() {
            k.update(s, base.pose(i));
            reference.extend(puppet.features.points.iter().map(|p| k.point(p.link, &p.at)));
        }
        Self {
            physics: Physics::new(puppet, setting.penalty, Vec3::y() * -GRAVITY),
            basis: Basis::new(base.duration_s(), setting.options.spacing_s),
            force: forces.then_some(weights),
            axes: Axes::new(s),
            base: base.clone(),
            setting,
            dofs,
            moved,
            reference,
            k,
        }
    }

    /// Moves `out` to the least cost; returns the steps taken.
    pub fn solve(&mut self, out: &mut Clip) -> Result<usize, RetargetError> {
        let n = self.basis.len() * self.dofs.len();
        let width = (2 * super::basis::REACH + 1) * self.dofs.len() - 1;
        let (mut normal, mut factor) = (Band::zeros(n, width), Band::zeros(0, 0));
        let (mut w, mut gradient) = (vec![0.0; n], vec![0.0; n]);
        let mut clip = self.displaced(&w);
        let mut cost = self.cost(&clip, &w);
        let (mut damping, mut steps) = (1e-6, 0);
        'outer: while steps < self.setting.options.iterations {
            self.linearise(&clip, &w, &mut normal, &mut gradient);
            loop {
                let mut step: Vec<f64> = gradient.iter().map(|g| -g).collect();
                // overlapping functions are nearly dependent: rounding may need more damping
                if let Err(row) = normal.solve(damping, &mut factor, &mut step) {
                    damping *= 10.0;
                    if damping > 1e6 {
                        return Err(RetargetError::Singular { row });
                    }
                    continue;
                }
                let tried: Vec<f64> = w.iter().zip(&step).map(|(a, b)| a + b).collect();
                let moved = self.displaced(&tried);
                let lower = self.cost(&moved, &tried);
                if lower < cost {
                    let last = cost - lower < ENOUGH * cost;
                    (w, clip, cost) = (tried, moved, lower);
                    damping = (damping * 0.1).max(1e-9);
                    steps += 1;
                    if last {
                        break 'outer;
                    }
                    break;
                }
                damping *= 10.0;
                if damping > 1e6 {
                    break 'outer;
                }
            }
        }
        *out = clip;
        Ok(steps)
    }

    fn displaced(&self, w: &[f64]) -> Clip {
        let mut out = self.base.clone();
        let (mut active, d) = (Active::default(), self.dofs.len());
        let mut v = vec![0.0; self.base.skeleton.nv()];
        for i in 0..out.frames() {
            self.basis.at(i as f64 / out.rate_hz, &mut active);
            for (j, &dof) in self.dofs.iter().enumerate() {
                let terms = active.phi.iter().enumerate();
                v[dof] = terms.map(|(a, phi)| phi[0] * w[(active.first + a) * d + j]).sum();
            }
            out.skeleton.clone().integrate(out.pose_mut(i), &v, 1.0);
        }
        out
    }

    /// Weight of a point's squared way in a frame: k₂ dt/(τ n σ²).
    fn stay(&self, frame: usize) -> f64 {
        let n = self.setting.puppet.features.points.len() as f64;
        let variance = self.setting.variance[frame].max(LEAST_DEVIATION_M * LEAST_DEVIATION_M);
        self.setting.options.k2 / (variance * n * INDEPENDENT_S * self.base.rate_hz)
    }

    fn cost(&mut self, clip: &Clip, w: &[f64]) -> f64 {
        let d = Derivatives::central(clip);
        let nv = clip.skeleton.nv();
        let mut sum = 0.5 * w.iter().map(|x| x * x).sum::<f64>();
        let points = self.setting.puppet.features.points.len();
        let mut touches: Vec<Touch> = Vec::new();
        for i in 0..clip.frames() {
            let (q, at) = (clip.pose(i), i * nv..(i + 1) * nv);
            if let Some(weights) = self.force {
                let f = self.physics.forces(q, &d.v[at.clone()], &d.vd[at], &self.setting.anchors[i]);
                sum += 0.5 * (0..6).map(|c| (weights[c] * f.residual[c]).powi(2)).sum::<f64>();
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
            sum += 0.5 * self.stay(i) * away;
            let slips = self.slips(i).map(|(_, _, slip)| slip.norm_squared()).sum::<f64>();
            sum += 0.5 * slips / (SLIP_M * SLIP_M);
            let links = 0..clip.skeleton.links().len();
            let beyond: f64 =
                links.filter_map(|l| way_back(&clip.skeleton, q, l)).map(|e| e.norm_squared()).sum();
            sum += 0.5 * LIMIT * beyond;
            if let Some(solids) = self.setting.solids {
                touches.clear();
                solids.touches(&self.k, &mut touches);
                sum += 0.5 * TOUCH * touches.iter().map(|t| t.depth_m * t.depth_m).sum::<f64>();
            }
        }
        sum
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

    /// Normal matrix and gradient at a clip that is displaced by `w`.
    fn linearise(&mut self, clip: &Clip, w: &[f64], normal: &mut Band, gradient: &mut [f64]) {
        let derivatives = Derivatives::central(clip);
        let (nv, d) = (clip.skeleton.nv(), self.dofs.len());
        normal.fill(0.0);
        for i in 0..normal.len() {
            *normal.at(i, i) = 1.0;
        }
        gradient.copy_from_slice(w);
        let mut slopes = Slopes::new(nv);
        let mut local = Local::new(d);
        let mut active = Active::default();
        for i in 0..clip.frames() {
            let (q, at) = (clip.pose(i), i * nv..(i + 1) * nv);
            let (v, vd) = (&derivatives.v[at.clone()], &derivatives.vd[at]);
            local.clear();
            if let Some(weights) = self.force {
                let f = self.physics.forces(q, v, vd, &self.setting.anchors[i]);
                self.physics.slopes(v, vd, &self.setting.anchors[i], &mut slopes);
                for c in 0..6 {
                    for (order, by) in slopes.by.iter().enumerate() {
                        for (j, &dof) in self.dofs.iter().enumerate() {
                            local.row[order * d + j] = weights[c] * by[(c, dof)];
                        }
                    }
                    local.add_row(weights[c] * f.residual[c], 3 * d);
                }
            }
            self.geometry(i, clip, q, &mut local);
            self.basis.at(i as f64 / clip.rate_hz, &mut active);
            local.carry(&active, normal, gradient, self.force.is_some());
        }
    }

    /// Terms that depend on the pose only.
    fn geometry(&mut self, frame: usize, clip: &Clip, q: &[f64], local: &mut Local) {
        let puppet = self.setting.puppet;
        self.k.update(&clip.skeleton, q);
        self.axes.update(&clip.skeleton, &self.k);
        let points = &puppet.features.points;
        let weight = self.stay(frame);
        for (p, r) in points.iter().zip(&self.reference[frame * points.len()..]) {
            let at = self.k.point(p.link, &p.at);
            self.point(p.link, &at, &(at - r), weight, local);
        }
        let slips: Vec<_> = self.slips(frame).collect();
        for (link, at, slip) in slips {
            for (axis, error) in [(Vec3::x(), slip.x), (Vec3::z(), slip.z)] {
                self.along(link, &at, &axis, error, 1.0 / SLIP_M, local);
            }
        }
        for (l, link) in clip.skeleton.links().iter().enumerate() {
            let Some(e) = way_back(&clip.skeleton, q, l) else { continue };
            let direction = e.normalize();
            local.clear_row();
            for a in 0..link.joint.nv() {
                if let Some(j) = self.moved[clip.skeleton.v_at(l) + a] {
                    local.row[j] = -LIMIT.sqrt() * direction[a];
                }
            }
            local.add_row(LIMIT.sqrt() * e.norm(), self.dofs.len());
        }
        if let Some(solids) = self.setting.solids {
            let mut touches = Vec::new();
            solids.touches(&self.k, &mut touches);
            for t in &touches {
                local.clear_row();
                let mut put = |link: usize, at: &Vec3, sign: f64| {
                    for &dof in &self.axes.chain[link] {
                        if let Some(j) = self.moved[dof] {
                            local.row[j] -= sign * TOUCH.sqrt() * self.axes.all[dof].column(at).dot(&t.out);
                        }
                    }
                };
                put(t.first.0, &t.first.1, 1.0);
                if let Some((link, at)) = t.second {
                    put(link, &at, -1.0);
                }
                local.add_row(TOUCH.sqrt() * t.depth_m, self.dofs.len());
            }
        }
    }

    /// ½ weight |error|² of a point.
    fn point(&self, link: usize, at: &Vec3, error: &Vec3, weight: f64, local: &mut Local) {
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
    fn along(&self, link: usize, at: &Vec3, axis: &Vec3, error: f64, scale: f64, local: &mut Local) {
        local.clear_row();
        for &dof in &self.axes.chain[link] {
            if let Some(j) = self.moved[dof] {
                local.row[j] = scale * self.axes.all[dof].column(at).dot(axis);
            }
        }
        local.add_row(scale * error, self.dofs.len());
    }
}

/// The quadratic of one frame in `x = (δ, δ̇, δ̈)`.
struct Local {
    d: usize,
    /// Q, lower triangle, row-major, `3d × 3d`.
    q: Vec<f64>,
    gradient: Vec<f64>,
    /// One residual's slope.
    row: Vec<f64>,
    chain: Vec<(usize, Vec3)>,
}

impl Local {
    fn new(d: usize) -> Self {
        Self {
            d,
            q: vec![0.0; 9 * d * d],
            gradient: vec![0.0; 3 * d],
            row: vec![0.0; 3 * d],
            chain: Vec::new(),
        }
    }

    fn clear(&mut self) {
        self.q.fill(0.0);
        self.gradient.fill(0.0);
    }

    fn clear_row(&mut self) {
        self.row.fill(0.0);
    }

    /// Adds ½ r², of which `row[..count]` is the slope.
    fn add_row(&mut self, r: f64, count: usize) {
        let n = 3 * self.d;
        for i in 0..count {
            let x = self.row[i];
            if x == 0.0 {
                continue;
            }
            self.gradient[i] += x * r;
            let to = &mut self.q[i * n..i * n + i + 1];
            to.iter_mut().zip(&self.row).for_each(|(q, y)| *q += x * y);
        }
    }

    /// Adds the frame to the normal equations of the weights.
    fn carry(&mut self, active: &Active, normal: &mut Band, gradient: &mut [f64], rates: bool) {
        let (d, n) = (self.d, 3 * self.d);
        let orders = if rates { 3 } else { 1 };
        let q = DMatrix::from_fn(n, n, |i, j| if j <= i { self.q[i * n + j] } else { self.q[j * n + i] });
        let g = DVector::from_column_slice(&self.gradient);
        let mut half = vec![0.0; n * d];
        for (l, phi) in active.phi.iter().enumerate() {
            let at = (active.first + l) * d;
            for j in 0..d {
                gradient[at + j] += (0..orders).map(|a| phi[a] * g[a * d + j]).sum::<f64>();
            }
            // Q of this function: n × d, by rows
            for i in 0..orders * d {
                for j in 0..d {
                    half[i * d + j] = (0..orders).map(|b| phi[b] * q[(i, b * d + j)]).sum();
                }
            }
            for (i, other) in active.phi.iter().enumerate().skip(l) {
                for a in 0..d {
                    let to = (active.first + i) * d + a;
                    let count = if i == l { a + 1 } else { d };
                    let row = normal.row_mut(to, at, count);
                    for order in 0..orders {
                        let x = other[order];
                        let from = &half[(order * d + a) * d..(order * d + a) * d + count];
                        row.iter_mut().zip(from).for_each(|(r, h)| *r += x * h);
                    }
                }
            }
        }
    }
}
