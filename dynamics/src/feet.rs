//! What the feet of a run did on its ground.
//!
//! In: a [`Trace`]. Out: [`FeetMetrics`], measured along the ground as it was in each row: tilted or turning ground counts as
//! level. A foot that bears load counts as down however fast it slides; one that does not, as in a clip: see
//! [`motion::metrics`].

use motion::metrics::{FeetMeter, FeetMetrics};
use motion::{Kinematics, Site, Vec3};

use crate::{Model, Trace};

/// Feet of the motion performed.
pub fn performed(trace: &Trace) -> FeetMetrics {
    let c = &trace.character;
    let model = Model::new(c, trace.gravity);
    let body = |link: usize| model.body_of[link].0;
    let mut loaded = vec![false; model.bodies.len()];
    measure(trace, |row, k, meter, sites| {
        k.update(&c.skeleton, trace.pose(row));
        loaded.fill(false);
        for contact in trace.contacts_in(row) {
            loaded[body(contact.link)] |= contact.against.is_world() && contact.force.norm_squared() > 0.0;
        }
        meter
            .add(sites.iter().map(|s| (trace.on_ground(row, &k.point(s.link, &s.at)), loaded[body(s.link)])));
    })
}

/// Feet of the motion asked for, over the ground of row 0, for which it was made.
pub fn asked(trace: &Trace) -> FeetMetrics {
    measure(trace, |row, k, meter, sites| {
        k.update(&trace.character.skeleton, trace.target_pose(row));
        meter.add(sites.iter().map(|s| (trace.on_ground(0, &k.point(s.link, &s.at)), false)));
    })
}

/// Hands every row to `add`, with the contact points of the body.
fn measure(
    trace: &Trace,
    mut add: impl FnMut(usize, &mut Kinematics, &mut FeetMeter, &[&Site]),
) -> FeetMetrics {
    let c = &trace.character;
    let sites: Vec<&Site> = c.contacts.iter().map(|&i| &c.skeleton.sites()[i]).collect();
    let mut meter = FeetMeter::new(sites.len(), trace.rate_hz);
    let mut k = Kinematics::new(&c.skeleton, &c.skeleton.zero_pose());
    for row in 0..trace.rows() {
        add(row, &mut k, &mut meter, &sites);
    }
    meter.finish()
}

/// Height of the lowest of some points over the ground of a row, m.
pub(crate) fn lowest(trace: &Trace, row: usize, points: impl IntoIterator<Item = Vec3>) -> f64 {
    points.into_iter().map(|p| trace.height(row, &p)).fold(f64::INFINITY, f64::min)
}
