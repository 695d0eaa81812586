//! Contact forces: what the ground did to each point of the body during the last step.
//!
//! In: a [`World`] after [`Engine::step`](crate::Engine::step). Out: one force per active contact point, mean over the step,
//! world frame, N. Friction is read from the engine's two tangent impulses, whose basis is not stored
//! and is recovered from the world-frame copy of the last substep's.

use dynamics::ContactSample;
use motion::Vec3;
use rapier3d::prelude as rp;

use crate::world::{World, from_glam};

impl World {
    /// Appends the contacts of the last step to `out`, labelled with the trace row `row`.
    pub(crate) fn read_contacts(&self, row: usize, out: &mut Vec<ContactSample>) {
        let inv_dt = self.settings.rate_hz;
        let first = out.len();
        for pair in self.physics.contact_pairs() {
            let owner = |c: rp::ColliderHandle| {
                self.physics.colliders.get(c).and_then(|c| c.parent().map(|h| (h, *c.position())))
            };
            let (body, place, on_first) = match (owner(pair.collider1), owner(pair.collider2)) {
                (Some((h, at)), None) => (h, at, true),
                (None, Some((h, at))) => (h, at, false),
                _ => continue,
            };
            let Some(index) = self.handles.iter().position(|h| *h == body) else { continue };
            for manifold in pair.manifolds() {
                let normal = -from_glam(manifold.data.normal);
                for point in &manifold.points {
                    let c = &point.data;
                    if c.impulse == 0.0 && c.tangent_impulse.norm() == 0.0 {
                        continue;
                    }
                    let mut force = normal * c.impulse;
                    let (x, y) = (c.warmstart_tangent_impulse[0], c.warmstart_tangent_impulse[1]);
                    let squared = x * x + y * y;
                    if squared > 0.0 {
                        let world = from_glam(c.warmstart_tangent_world);
                        let t1 = (world * x - normal.cross(&world) * y) / squared;
                        let t2 = normal.cross(&t1);
                        force += t1 * c.tangent_impulse[0] + t2 * c.tangent_impulse[1];
                    }
                    let local = if on_first { point.local_p1 } else { point.local_p2 };
                    let sign = if on_first { 1.0 } else { -1.0 };
                    out.push(ContactSample {
                        row,
                        link: self.model.bodies[index].link,
                        point: from_glam(place * local),
                        force: force * (sign * inv_dt),
                        depth: -point.dist,
                    });
                }
            }
        }
        // the engine's order of pairs depends on its history; ours must not
        out[first..].sort_by(|a, b| {
            let key = |c: &ContactSample| (c.link, c.point.x, c.point.z);
            let (ka, kb) = (key(a), key(b));
            ka.0.cmp(&kb.0).then(ka.1.total_cmp(&kb.1)).then(ka.2.total_cmp(&kb.2))
        });
    }

    /// Sum of the contact forces of the last step, N.
    pub fn contact_sum(&self) -> Vec3 {
        let mut all = Vec::new();
        self.read_contacts(0, &mut all);
        all.iter().map(|c| c.force).sum()
    }
}
