//! An analysis as numpy arrays: SI units and radians, names and units inside.
//!
//! Layout (`n` frames, `f` feet): `rate_hz`, `mass`, `friction`, `ground_m` (NaN without ground), `cutoff_hz`
//! (infinite without smoothing) scalars; `gravity` 3; `q` n × nq; `v`, `vd`, `tau` n × nv; `required_force`, `required_moment_com`,
//! `ground_force`, `ground_moment_com`, `com`, `com_velocity`, `angular_momentum`, `cop` n × 3;
//! `residual`, `root_wrench` n × 6; `flight` n; `foot_name` f; `foot_contact`, `foot_height`,
//! `foot_share`, `foot_free_moment` f × n; `foot_force`, `foot_cop` f × 3n; `tau_noise`, `dof_name`
//! nv; `friction_violations`, `support_violations`: indices of frames; `units` u × 2.

use std::io::{self, Seek, Write};

use crate::trace_npz::Arrays;
use dynamics::Analysis;

const UNITS: &[(&str, &str)] = &[
    ("rate_hz", "Hz"),
    ("mass", "kg"),
    ("friction", "1"),
    ("ground_m", "m"),
    ("gravity", "m/s^2"),
    ("q", "m, rad, quaternion w x y z"),
    ("v", "m/s, rad/s"),
    ("vd", "m/s^2, rad/s^2"),
    ("tau", "N, N·m; of a free root the residual along its zero frame's axes"),
    ("required_force", "N"),
    ("required_moment_com", "N·m about the centre of mass"),
    ("ground_force", "N"),
    ("ground_moment_com", "N·m about the centre of mass"),
    ("residual", "N (3), N·m about the root's origin (3)"),
    ("root_wrench", "N (3), N·m about the root's origin (3)"),
    ("com", "m"),
    ("com_velocity", "m/s"),
    ("angular_momentum", "N·m·s about the centre of mass"),
    ("cop", "m"),
    ("foot_height", "m"),
    ("foot_share", "1"),
    ("foot_force", "N"),
    ("foot_cop", "m"),
    ("foot_free_moment", "N·m"),
    ("tau_noise", "N, N·m, standard deviation"),
    ("cutoff_hz", "Hz"),
];

/// Writes the analysis as `.npz`; see the module header.
///
/// # Errors
/// Those of the writer.
pub fn write_npz<W: Write + Seek>(a: &Analysis, out: W) -> io::Result<()> {
    let (nq, nv, frames) = (a.clip.skeleton.nq(), a.clip.skeleton.nv(), a.frames());
    let mut npz = Arrays::new(out);
    npz.numbers("rate_hz", &[], &[a.rate_hz()])?;
    npz.numbers("mass", &[], &[a.mass])?;
    npz.numbers("friction", &[], &[a.friction])?;
    npz.numbers("ground_m", &[], &[a.ground_m.unwrap_or(f64::NAN)])?;
    npz.numbers("gravity", &[3], a.gravity.as_slice())?;
    npz.table("q", nq, a.clip.data())?;
    npz.table("v", nv, &a.v)?;
    npz.table("vd", nv, &a.vd)?;
    npz.table("tau", nv, &a.tau)?;
    for (name, data) in [
        ("required_force", &a.required_force),
        ("required_moment_com", &a.required_moment_com),
        ("ground_force", &a.ground_force),
        ("ground_moment_com", &a.ground_moment_com),
        ("com", &a.com),
        ("com_velocity", &a.com_velocity),
        ("angular_momentum", &a.angular_momentum),
        ("cop", &a.cop),
    ] {
        npz.table(name, 3, data)?;
    }
    npz.table("residual", 6, &a.residual)?;
    npz.table("root_wrench", 6, &a.root_wrench)?;
    npz.indices("flight", a.flight.iter().map(|f| usize::from(*f)))?;
    let names: Vec<&str> = a.feet.iter().map(|f| f.name.as_str()).collect();
    npz.text("foot_name", &[names.len() as u64], &names)?;
    let n = names.len() as u64;
    let contact: Vec<i64> = a.feet.iter().flat_map(|f| f.contact.iter().map(|c| i64::from(*c))).collect();
    npz.numbers("foot_contact", &[n, frames as u64], &contact)?;
    let all = |of: fn(&dynamics::analysis::FootForces) -> &[f64]| -> Vec<f64> {
        a.feet.iter().flat_map(|f| of(f).iter().copied()).collect()
    };
    npz.table("foot_height", frames, &all(|f| &f.height))?;
    npz.table("foot_share", frames, &all(|f| &f.share))?;
    npz.table("foot_free_moment", frames, &all(|f| &f.free_moment))?;
    npz.table("foot_force", 3 * frames, &all(|f| &f.force))?;
    npz.table("foot_cop", 3 * frames, &all(|f| &f.cop))?;
    npz.numbers("tau_noise", &[nv as u64], &a.noise.tau)?;
    npz.numbers("cutoff_hz", &[], &[a.smoothing.cutoff_hz])?;
    let names = a.dof_names();
    npz.text("dof_name", &[nv as u64], &names.iter().map(String::as_str).collect::<Vec<_>>())?;
    npz.indices("friction_violations", a.friction_violations.frames.iter().copied())?;
    npz.indices("support_violations", a.support_violations.frames.iter().copied())?;
    let units: Vec<&str> = UNITS.iter().flat_map(|u| [u.0, u.1]).collect();
    npz.text("units", &[UNITS.len() as u64, 2], &units)?;
    npz.finish()
}
