//! Contact forces: what the ground did to each point of the body during the last step.
//!
//! In: a [`Rapier`] after [`Engine::step`](crate::Engine::step). Out: one force per active contact point, mean over the step,
//! world frame, N.
//!
//! A manifold keeps the points that lay near each other at the last collision test, and with each the impulses of the
//! last step in which the solver saw it. Only its solver contacts took part in this step: the impulses of the others
//! are old. Friction is along the basis that the solver makes of the normal.

use dynamics::Against;
use motion::Vec3;
use rapier3d::prelude as rp;
use rapier3d::utils::OrthonormalBasis;

use super::{Rapier, from_glam};
use crate::ContactForce;

impl Rapier {
    /// Appends the contacts of the last step to `out`.
    pub(super) fn read_contacts(&self, out: &mut Vec<ContactForce>) {
        let inv_dt = self.settings.rate_hz;
        let first = out.len();
        for pair in self.physics.contact_pairs() {
            let owner = |c: rp::ColliderHandle| {
                let collider = self.physics.colliders.get(c)?;
                let body = self.handles.iter().position(|h| Some(*h) == collider.parent())?;
                Some((body, *collider.position()))
            };
            let link = |body: usize| self.model.bodies[body].link;
            // what is touched, where, and the other link if there is one
            let (body, place, on_first, other) = match (owner(pair.collider1), owner(pair.collider2)) {
                (Some((body, at)), None) => (body, at, true, None),
                (None, Some((body, at))) => (body, at, false, None),
                (Some((body, at)), Some((other, _))) => (body, at, true, Some(other)),
                (None, None) => continue,
            };
            let fixed = if on_first { pair.collider2 } else { pair.collider1 };
            let against = match (other, self.props.iter().position(|p| *p == fixed)) {
                (Some(other), _) => Against::Link(link(other)),
                (None, Some(prop)) => Against::Prop(prop),
                (None, None) => Against::Ground,
            };
            for manifold in pair.manifolds() {
                let normal = -manifold.data.normal;
                let tangent = normal.orthonormal_vector();
                let basis = [normal, tangent, normal.cross(tangent)].map(from_glam);
                for contact in &manifold.data.solver_contacts {
                    let point = &manifold.points[contact.contact_indices()[0] as usize];
                    let c = &point.data;
                    let impulse = [c.impulse, c.tangent_impulse[0], c.tangent_impulse[1]];
                    if impulse == [0.0; 3] {
                        continue;
                    }
                    let force: Vec3 = basis.iter().zip(impulse).map(|(b, x)| b * x).sum();
                    let local = if on_first { point.local_p1 } else { point.local_p2 };
                    let sign = if on_first { 1.0 } else { -1.0 };
                    let contact = ContactForce {
                        link: link(body),
                        against,
                        point: from_glam(place * local),
                        force: force * (sign * inv_dt),
                        depth: -point.dist,
                    };
                    out.push(contact);
                    if let Some(other) = other {
                        let (force, against) = (-contact.force, Against::Link(contact.link));
                        out.push(ContactForce { link: link(other), against, force, ..contact });
                    }
                }
            }
        }
        // rapier's order of pairs depends on the run's history; sorted, the order depends on the state alone
        out[first..].sort_by(|a, b| {
            let key = |c: &ContactForce| (c.link, c.point.x, c.point.z);
            let (ka, kb) = (key(a), key(b));
            ka.0.cmp(&kb.0).then(ka.1.total_cmp(&kb.1)).then(ka.2.total_cmp(&kb.2))
        });
    }

    /// Sum of the contact forces of the last step, N.
    pub fn contact_sum(&self) -> Vec3 {
        let mut all = Vec::new();
        self.read_contacts(&mut all);
        all.iter().filter(|c| c.against.is_world()).map(|c| c.force).sum()
    }
}
