//! What is decomposed: postures as numbers, and numbers as postures.
//!
//! | representation | channels | linear combinations |
//! |---|---|---|
//! | [`Representation::Positions`] | place of every bone and end over the floor, m, seen from the heading | bones change length, then are fitted |
//! | [`Representation::Tangent`] | rotation vector of every joint from its mean over both clips, rad; height of the root, m | proper rotations |
//! | [`Representation::Euler`] | Z, Y, X angles of every joint, rad; height of the root | twist and flip: to show why not (SCF06 §3.1) |
//!
//! *Bone lengths* are restored by fitting rotations to positions (an angle-preserving fit): the turn `G` of a bone
//! maximises `Σ w_i (G a_i)·b_i` over its children and ends, `a_i` where the zero pose has them and `b_i` where the
//! positions do, and over its three axes, which ride along with small weight so that twist about a bone is known:
//! they are not decomposed, only carried by what was found ([`Channels::carried`]).

use motion::rotation::{exp, log};
use motion::{EulerOrder, Quat, Vec3};
use nalgebra::{DMatrix, Matrix3, Quaternion};

use super::figure::{Figure, Postures};
use motion::names::Word;

/// How postures become numbers. See the module header.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Representation {
    /// Places of bones and ends.
    #[default]
    Positions,
    /// Rotation vectors at the mean.
    Tangent,
    /// Euler angles.
    Euler,
}

impl Word for Representation {
    const KIND: &'static str = "representation";
    const WORDS: &'static [(Self, &'static str, &'static str)] = &[
        (Self::Positions, "positions", "Places of bones and their ends, lengths restored afterwards"),
        (Self::Tangent, "tangent", "Rotation vectors of the joints at their mean"),
        (Self::Euler, "euler", "Euler angles: only to show why not"),
    ];
}

/// Weight of the three axes of a bone beside its children, m.
const AXIS_M: f64 = 0.05;
/// A fit that turns by less is done, rad: what is left is as its square.
const STILL: f64 = 1e-5;
/// Most steps of a fit.
const STEPS: usize = 30;

/// A representation with what it needs of the clips it was made for.
#[derive(Clone, Debug, PartialEq)]
pub struct Coding {
    /// Which.
    pub representation: Representation,
    /// Mean rotation of every joint: where [`Representation::Tangent`] is flat.
    pub center: Vec<Quat>,
}

/// Numbers of postures, a frame in each row.
#[derive(Clone, Debug, PartialEq)]
pub struct Channels {
    /// What is decomposed.
    pub own: DMatrix<f64>,
    /// What rides along.
    pub carried: DMatrix<f64>,
}

/// Rotation of a joint from its bone's turn and its parent's.
fn local(figure: &Figure, turns: &[Quat], bone: usize) -> Quat {
    match figure.bones[bone].parent {
        Some(p) => turns[p].inverse() * turns[bone],
        None => turns[bone],
    }
}

impl Coding {
    /// The coding of a figure for these postures.
    pub fn of(representation: Representation, figure: &Figure, all: &[&Postures]) -> Self {
        let frames = || all.iter().flat_map(|p| &p.turns);
        let count = frames().count().max(1) as f64;
        let center = (0..figure.bones.len())
            .map(|bone| {
                let mut mean = frames().next().map_or(Quat::identity(), |t| local(figure, t, bone));
                for _ in 0..STEPS {
                    let sum: Vec3 = frames().map(|t| log(&(local(figure, t, bone) * mean.inverse()))).sum();
                    mean = exp(&(sum / count)) * mean;
                    if sum.norm() / count < 1e-12 {
                        break;
                    }
                }
                mean
            })
            .collect();
        Coding { representation, center }
    }

    /// Channels of [`Channels::own`] and [`Channels::carried`].
    pub fn widths(&self, figure: &Figure) -> (usize, usize) {
        let bones = figure.bones.len();
        match self.representation {
            Representation::Positions => {
                (3 * (bones + figure.bones.iter().filter(|b| b.end.is_some()).count()), 9 * bones)
            }
            Representation::Tangent | Representation::Euler => (3 * bones + 1, 0),
        }
    }

    /// Postures as numbers.
    pub fn encode(&self, figure: &Figure, postures: &Postures) -> Channels {
        let (own_width, carried_width) = self.widths(figure);
        let frames = postures.frames();
        let mut own = DMatrix::zeros(frames, own_width);
        let mut carried = DMatrix::zeros(frames, carried_width);
        for (f, turns) in postures.turns.iter().enumerate() {
            let mut at = 0;
            let mut put = |v: Vec3| {
                for k in 0..3 {
                    own[(f, at + k)] = v[k];
                }
                at += 3;
            };
            match self.representation {
                Representation::Positions => {
                    let up = Vec3::y() * postures.height[f];
                    let places = figure.places(turns);
                    places.iter().for_each(|p| put(p + up));
                    for (i, bone) in figure.bones.iter().enumerate() {
                        if let Some(end) = bone.end {
                            put(places[i] + turns[i] * end + up);
                        }
                    }
                    for (i, turn) in turns.iter().enumerate() {
                        let m = turn.to_rotation_matrix();
                        for (k, x) in m.matrix().iter().enumerate() {
                            carried[(f, 9 * i + k)] = *x;
                        }
                    }
                }
                Representation::Tangent => {
                    for bone in 0..figure.bones.len() {
                        put(log(&(local(figure, turns, bone) * self.center[bone].inverse())));
                    }
                    own[(f, own_width - 1)] = postures.height[f];
                }
                Representation::Euler => {
                    for bone in 0..figure.bones.len() {
                        let mut angles = EulerOrder::ZYX.from_quat(&local(figure, turns, bone));
                        if f > 0 {
                            // the branch of the frame before, so that angles do not jump by whole turns
                            for k in 0..3 {
                                let before = own[(f - 1, 3 * bone + k)];
                                let turn = std::f64::consts::TAU;
                                angles[k] += turn * ((before - angles[k]) / turn).round();
                            }
                        }
                        for k in 0..3 {
                            own[(f, 3 * bone + k)] = angles[k];
                        }
                    }
                    own[(f, own_width - 1)] = postures.height[f];
                }
            }
        }
        Channels { own, carried }
    }

    /// Numbers as the postures nearest to them; bones have the figure's lengths. `turns`: of the postures that were changed, frame by
    /// frame, replaced: a fit starts from them, turned as the two frames before let expect.
    pub fn decode(&self, figure: &Figure, channels: &Channels, turns: &mut [Vec<Quat>], height: &mut [f64]) {
        let bones = figure.bones.len();
        let last = channels.own.ncols() - 1;
        let children: Vec<Vec<usize>> =
            (0..bones).map(|b| (0..bones).filter(|c| figure.bones[*c].parent == Some(b)).collect()).collect();
        // how far the last two frames were turned
        let mut turned = vec![[Quat::identity(); 2]; bones];
        for f in 0..channels.own.nrows() {
            let at = |i: usize| {
                let row = |k: usize| channels.own[(f, 3 * i + k)];
                Vec3::new(row(0), row(1), row(2))
            };
            match self.representation {
                Representation::Positions => {
                    let mut ends = bones;
                    for bone in 0..bones {
                        let carried = |k: usize| channels.carried[(f, 9 * bone + k)] * (AXIS_M * AXIS_M);
                        let mut columns =
                            [0, 3, 6].map(|c| Vec3::new(carried(c), carried(c + 1), carried(c + 2)));
                        let here = at(bone);
                        let mut add = |place: usize, offset: &Vec3| {
                            let there = at(place) - here;
                            for c in 0..3 {
                                columns[c] += there * offset[c];
                            }
                        };
                        children[bone].iter().for_each(|c| add(*c, &figure.bones[*c].offset));
                        if let Some(end) = &figure.bones[bone].end {
                            add(ends, end);
                            ends += 1;
                        }
                        let m = Matrix3::from_columns(&columns);
                        let was = turns[f][bone];
                        let [before, last] = turned[bone];
                        turns[f][bone] = nearest(&m, last * before.inverse() * last * was);
                        let now = turns[f][bone] * was.inverse();
                        turned[bone] = [if f == 0 { now } else { last }, now];
                    }
                    height[f] = at(0).y;
                }
                Representation::Tangent | Representation::Euler => {
                    for bone in 0..bones {
                        let joint = match self.representation {
                            Representation::Euler => EulerOrder::ZYX.to_quat(&at(bone)),
                            _ => exp(&at(bone)) * self.center[bone],
                        };
                        turns[f][bone] = match figure.bones[bone].parent {
                            Some(p) => turns[f][p] * joint,
                            None => joint,
                        };
                    }
                    height[f] = channels.own[(f, last)];
                }
            }
        }
    }
}

/// The rotation that maximises trace(Gᵀ M), by Newton steps from a guess: with P = M Gᵀ and its symmetric part S,
/// `(tr S − S) ω = Σ g_i × m_i`, `G ← (1, ω/2)/|·| G`, a quaternion that turns by ω up to |ω|³/12. Where that does not lead to the maximum, by
/// singular values.
fn nearest(m: &Matrix3<f64>, guess: Quat) -> Quat {
    let mut g = guess;
    for _ in 0..STEPS {
        let p = m * g.to_rotation_matrix().matrix().transpose();
        // Σ g_i × m_i is the axial vector of P
        let turn = Vec3::new(p[(2, 1)] - p[(1, 2)], p[(0, 2)] - p[(2, 0)], p[(1, 0)] - p[(0, 1)]);
        let a = Matrix3::from_diagonal_element(p.trace()) - (p + p.transpose()) * 0.5;
        // a maximum: positive definite
        let minor = a[(0, 0)] * a[(1, 1)] - a[(0, 1)] * a[(1, 0)];
        let is_maximum = a[(0, 0)] > 0.0 && minor > 0.0 && a.determinant() > 0.0;
        let Some(inverse) = a.try_inverse().filter(|_| is_maximum) else { break };
        let step = inverse * turn;
        let length = step.norm();
        let half = step * (0.5 / length.max(1.0));
        g = Quat::new_normalize(Quaternion::from_parts(1.0, half)) * g;
        if length < STILL {
            return Quat::new_normalize(g.into_inner());
        }
    }
    // singular values of what is no number are looked for without end
    if !m.iter().all(|x| x.is_finite()) {
        return guess;
    }
    let svd = m.svd(true, true);
    let (Some(u), Some(vt)) = (svd.u, svd.v_t) else { return guess };
    let mut flip = Matrix3::identity();
    flip[(2, 2)] = (u * vt).determinant().signum();
    Quat::from_matrix(&(u * flip * vt))
}
