//! How a run is judged: the rules of the table of [`super`].
//!
//! In: the rows of a [`Trace`] that were performed. Out: its [`Ending`], and the [`Reason`]s that broke their limits.

use motion::metrics;
use motion::{Joint, Kinematics, Sole, Vec3};

use super::{
    AIRBORNE_S, Airborne, Ending, FAR_M, Flight, HARD_BW, HARD_S, Reason, SLID_M, STOP_S, UNEXPLAINED,
    UNEXPLAINED_N, UNEXPLAINED_S, What,
};
use crate::conditions::LEAST_GRAVITY;
use crate::fall::{self, Fall};
use crate::feet::{self, lowest};
use crate::spans::{Span, beyond};
use crate::{Against, Model, RootMode, RootName, Trace};

/// Rows that were performed before a fall, that of the fall included.
pub fn performed_rows(trace: &Trace, fall: &Fall) -> usize {
    ((fall.time_s * trace.rate_hz).round() as usize + 1).clamp(1, trace.rows().max(1))
}

/// How a run ended that neither fell nor failed.
pub(super) fn ending(t: &Trace, model: &Model) -> Ending {
    if !matches!(model.bodies[0].joint, Joint::Free) {
        return Ending::Mounted;
    }
    if t.root == RootMode::Pinned {
        return Ending::Held(RootName::Pinned);
    }
    let last = t.rows().saturating_sub(1);
    let touches = |c: &&crate::ContactSample| c.against.is_world() && c.force.norm_squared() > 0.0;
    let touched = t.contacts.iter().rev().find(touches).map_or(0, |c| c.row);
    let airborne = (last - touched) as f64 / t.rate_hz;
    if airborne > AIRBORNE_S || (touched == 0 && last > 0) {
        let why = match t.ground_m {
            None => Airborne::NoGround,
            Some(_) if -t.gravity.y < LEAST_GRAVITY => Airborne::NoWeight,
            Some(_) => Airborne::Above(clearance(t, last)),
        };
        return Ending::InFlight(Flight { from_s: touched as f64 / t.rate_hz, why });
    }
    if t.root != RootMode::Free {
        return Ending::Held(t.root.name());
    }
    if t.character.leg_soles().is_empty() {
        let links = t.character.skeleton.links();
        let on = t.contacts.iter().filter(|c| c.row == touched && touches(c));
        let name = |c: &crate::ContactSample| match c.against {
            Against::Prop(_) => format!("{} on {}", links[c.link].name, t.against(c)),
            Against::Ground | Against::Link(_) => links[c.link].name.clone(),
        };
        let mut names: Vec<String> = on.map(name).collect();
        names.sort_unstable();
        names.dedup();
        return Ending::Rests(names);
    }
    Ending::Stands
}

/// Height of the lowest point of the body over the ground, m.
fn clearance(t: &Trace, row: usize) -> f64 {
    let c = &t.character;
    let k = Kinematics::new(&c.skeleton, t.pose(row));
    let lowest_solid = c.extent(t.pose(row), &t.ground_up(row)).map(|[low, _]| low);
    let origin = t.height(row, &Vec3::zeros());
    let sites = c.contacts.iter().map(|&i| &c.skeleton.sites()[i]);
    let sites = sites.map(|s| t.height(row, &k.point(s.link, &s.at)));
    lowest_solid.into_iter().map(|low| low + origin).chain(sites).fold(f64::INFINITY, f64::min)
}

pub(super) fn reasons(t: &Trace, model: &Model, in_flight: bool) -> Vec<Reason> {
    let mut all: Vec<Reason> = Vec::new();
    all.extend(unexplained(t));
    if t.ground_m.is_some() && !in_flight {
        all.extend(feet_slid(t));
        if t.root != RootMode::Pinned {
            all.extend(left_ground(t));
        }
        all.extend(landed_hard(t));
    }
    all.extend(at_stops(t, model));
    if t.root != RootMode::Pinned && !in_flight {
        all.extend(far_from_asked(t));
    }
    all
}

fn unexplained(t: &Trace) -> Option<Reason> {
    if t.root != RootMode::Free {
        return None; // the wrench of a holder is no error
    }
    let residual: Vec<Vec3> = t.residual().chunks_exact(6).map(|w| Vec3::new(w[0], w[1], w[2])).collect();
    let width = ((UNEXPLAINED_S * t.rate_hz).round() as usize).clamp(1, residual.len().max(1));
    let means = residual.windows(width).map(|w| w.iter().sum::<Vec3>().norm() / width as f64);
    let (row, value) = largest(means)?;
    let ground = t.contact_sums().iter().map(|f| f.norm()).fold(0.0, f64::max);
    let weight = t.character.mass() * t.gravity.norm();
    let limit = (UNEXPLAINED * ground.max(weight)).max(UNEXPLAINED_N);
    let at_s = Some(row as f64 / t.rate_hz);
    (value > limit).then_some(Reason { what: What::Unexplained, value, limit, at_s })
}

fn feet_slid(t: &Trace) -> Option<Reason> {
    let (performed, asked) = (feet::performed(t), feet::asked(t));
    let limit = asked.slip_mm_max + 1e3 * SLID_M;
    let c = &t.character;
    let site = c.contacts.get(performed.slip_point).map(|&i| &c.skeleton.sites()[i])?;
    let part = c.skeleton.links()[site.link].name.clone();
    let at_s = Some(performed.slip_frame as f64 / t.rate_hz);
    let value = performed.slip_mm_max;
    (value > limit).then_some(Reason { what: What::FeetSlid(part), value, limit, at_s })
}

/// Soles that the motion asked for has on the ground (and that stand by its plan of contacts, if it has one), higher than asked; and no load on
/// any foot.
fn left_ground(t: &Trace) -> Vec<Reason> {
    let c = &t.character;
    let soles: Vec<(String, Sole)> =
        c.leg_soles().into_iter().map(|(limb, sole)| (limb.name.clone(), sole)).collect();
    if soles.is_empty() {
        return Vec::new();
    }
    let rows = t.rows();
    let (mut now, mut asked) =
        (Kinematics::new(&c.skeleton, t.pose(0)), Kinematics::new(&c.skeleton, t.pose(0)));
    let mut lifted = vec![vec![0.0; rows]; soles.len()];
    let mut airborne = vec![0.0; rows];
    let sums = t.contact_sums();
    let stands_by_plan: Vec<Vec<bool>> =
        soles.iter().map(|(name, _)| t.plan.stands(name, t.rate_hz, rows)).collect();
    for row in 0..rows {
        now.update(&c.skeleton, t.pose(row));
        asked.update(&c.skeleton, t.target_pose(row));
        let mut stands = false;
        for (s, (_, sole)) in soles.iter().enumerate() {
            let wanted = lowest(t, 0, sole.points(&asked));
            if wanted < fall::LIFTED_M && (t.plan.is_empty() || stands_by_plan[s][row]) {
                stands = true;
                lifted[s][row] = lowest(t, row, sole.points(&now)) - wanted.max(0.0);
            }
        }
        // row 0 has no forces yet
        airborne[row] = f64::from(u8::from(stands && row > 0 && sums[row].norm_squared() == 0.0));
    }
    let long = (AIRBORNE_S * t.rate_hz).round().max(1.0) as usize;
    let mut out = Vec::new();
    if let Some((start, _, rows)) = worst_span(&airborne, 0.5, long) {
        let (value, at_s) = (rows as f64 / t.rate_hz, Some(start as f64 / t.rate_hz));
        out.push(Reason { what: What::LeftGround, value, limit: AIRBORNE_S, at_s });
    }
    let spans = lifted.iter().map(|heights| worst_span(heights, fall::LIFTED_M, long));
    let worst = spans.enumerate().filter_map(|(s, span)| Some((s, span?)));
    if let Some((s, (start, height, _))) = worst.max_by(|a, b| a.1.1.total_cmp(&b.1.1)) {
        out.push(Reason {
            what: What::FootLifted(soles[s].0.clone()),
            value: 1e3 * height,
            limit: 1e3 * fall::LIFTED_M,
            at_s: Some(start as f64 / t.rate_hz),
        });
    }
    out
}

/// The span of at least `long` rows beyond `limit` in which the value is largest, longest of equals: first row, value, rows.
fn worst_span(values: &[f64], limit: f64, long: usize) -> Option<(usize, f64, usize)> {
    let mut best: Option<(usize, f64, usize)> = None;
    for Span { rows, largest } in beyond(values, limit, long) {
        if best.is_none_or(|(_, value, count)| (largest, rows.len()) > (value, count)) {
            best = Some((rows.start, largest, rows.len()));
        }
    }
    best
}

fn landed_hard(t: &Trace) -> Option<Reason> {
    let weight = t.character.mass() * t.gravity.norm();
    if weight <= 0.0 {
        return None;
    }
    let sums = t.contact_sums();
    let width = (HARD_S * t.rate_hz).round() as usize;
    let normals: Vec<f64> = sums.iter().enumerate().map(|(row, f)| f.dot(&t.ground_up(row))).collect();
    let width = width.clamp(1, normals.len().max(1));
    let means = normals.windows(width).map(|w| w.iter().sum::<f64>() / width as f64);
    let (row, force) = largest(means)?;
    let value = force / weight;
    let at_s = Some(row as f64 / t.rate_hz);
    (value > HARD_BW).then_some(Reason { what: What::LandedHard, value, limit: HARD_BW, at_s })
}

fn at_stops(t: &Trace, model: &Model) -> Option<Reason> {
    let nv = model.nv();
    let mut worst: Vec<(usize, usize, f64, usize)> = Vec::new(); // rows, first row, torque, link
    for b in &model.bodies {
        let (mut rows, mut first, mut torque) = (0, None, 0.0_f64);
        for row in 0..t.rows() {
            let at = row * nv + b.v_at;
            let x = t.stop_torque[at..at + b.joint.nv().min(3)].iter().map(|x| x * x).sum::<f64>().sqrt();
            if x > fall::STOP_NM {
                rows += 1;
                first = first.or(Some(row));
                torque = torque.max(x);
            }
        }
        if rows as f64 / t.rate_hz > STOP_S {
            worst.push((rows, first.unwrap_or(0), torque, b.link));
        }
    }
    worst.sort_by_key(|w| std::cmp::Reverse(w.0));
    let &(rows, first, torque_nm, link) = worst.first()?;
    let joint = t.character.skeleton.links()[link].name.clone();
    Some(Reason {
        what: What::AtStop { joint, others: worst.len() - 1, torque_nm },
        value: rows as f64 / t.rate_hz,
        limit: STOP_S,
        at_s: Some(first as f64 / t.rate_hz),
    })
}

fn far_from_asked(t: &Trace) -> Option<Reason> {
    let (value, limit) = (metrics::position_rms_mm(&t.clip(), &t.target_clip()), 1e3 * FAR_M);
    (value > limit).then_some(Reason { what: What::FarFromAsked, value, limit, at_s: None })
}

/// The largest of finite numbers and where it is; `None` of none.
fn largest(all: impl Iterator<Item = f64>) -> Option<(usize, f64)> {
    all.enumerate().filter(|x| x.1.is_finite()).max_by(|a, b| a.1.total_cmp(&b.1))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The largest excursion wins, not the longest; short ones do not count; nothing gives nothing.
    #[test]
    fn spans_are_judged_by_their_largest_value() {
        let x = [0.0, 2.0, 2.0, 2.0, 0.0, 9.0, 0.0, 3.0, 1.5, 0.0];
        assert_eq!(worst_span(&x, 1.0, 2), Some((7, 3.0, 2)));
        assert_eq!(worst_span(&x, 1.0, 1), Some((5, 9.0, 1)));
        assert_eq!(worst_span(&x, 1.0, 4), None);
        assert_eq!(worst_span(&[], 1.0, 1), None);
        assert_eq!(worst_span(&[0.0; 4], 0.0, 1), None);
        assert_eq!((largest([].into_iter()), largest([f64::NAN].into_iter())), (None, None));
    }
}
