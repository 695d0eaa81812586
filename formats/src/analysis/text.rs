//! CSV and MOT. Numbers have nine significant digits: more than a motion is known to.

use std::fmt::Write;

use motion::{EulerOrder, Joint, Skeleton};

use dynamics::Analysis;

/// A table of numbers with named columns.
struct Table {
    names: Vec<String>,
    rows: Vec<Vec<f64>>,
}

impl Table {
    fn new(a: &Analysis) -> Self {
        let rows = (0..a.frames()).map(|k| vec![k as f64 / a.rate_hz()]).collect();
        Self { names: Vec::new(), rows }
    }

    /// Columns of `values`, a flat table of as many columns as names.
    fn add<S: Into<String>>(&mut self, names: impl IntoIterator<Item = S>, values: &[f64]) {
        let before = self.names.len();
        self.names.extend(names.into_iter().map(Into::into));
        let n = self.names.len() - before;
        for (row, values) in self.rows.iter_mut().zip(values.chunks_exact(n)) {
            row.extend(values);
        }
    }

    fn write(&self, out: &mut String, time: &str, separator: char) {
        *out += time;
        for name in &self.names {
            out.push(separator);
            *out += name;
        }
        out.push('\n');
        for row in &self.rows {
            for (i, x) in row.iter().enumerate() {
                if i > 0 {
                    out.push(separator);
                }
                number(out, *x);
            }
            out.push('\n');
        }
    }

    fn mot(&self, title: &str) -> String {
        let mut out = format!(
            "{title}\nversion=1\nnRows={}\nnColumns={}\ninDegrees=no\nendheader\n",
            self.rows.len(),
            self.names.len() + 1
        );
        self.write(&mut out, "time", '\t');
        out
    }
}

/// Nine significant digits; NaN where there is no number.
fn number(out: &mut String, x: f64) {
    // writing to a String cannot fail
    let _ = if !x.is_finite() {
        write!(
            out,
            "{}",
            if x.is_nan() {
                "nan"
            } else if x > 0.0 {
                "inf"
            } else {
                "-inf"
            }
        )
    } else if x == 0.0 {
        write!(out, "0")
    } else if (1e-4..1e9).contains(&x.abs()) {
        let digits = (8 - x.abs().log10().floor() as i32).clamp(0, 12) as usize;
        write!(out, "{x:.digits$}")
    } else {
        write!(out, "{x:.8e}")
    };
}

fn axes(name: &str, unit: &str) -> [String; 3] {
    ["x", "y", "z"].map(|axis| format!("{name}_{axis}_{unit}"))
}

fn flags(of: &[bool]) -> Vec<f64> {
    of.iter().map(|b| f64::from(u8::from(*b))).collect()
}

/// Names and values of the joint coordinates in text: m, and degrees; balls and free roots as Euler
/// angles, first turned first about moved axes in the order Y, Z, X.
fn coordinates(skeleton: &Skeleton, q: &[f64], names: Option<&mut Vec<String>>) -> Vec<f64> {
    let mut out = Vec::new();
    let mut said = Vec::new();
    for (i, link) in skeleton.links().iter().enumerate() {
        let at = skeleton.q_at(i);
        let mut say = |part: &str| said.push(format!("{}{part}", link.name));
        match link.joint {
            Joint::Free | Joint::Spherical => {
                if link.joint == Joint::Free {
                    ["_tx_m", "_ty_m", "_tz_m"].iter().for_each(|p| say(p));
                    out.extend(&q[at..at + 3]);
                }
                ["_ry_deg", "_rz_deg", "_rx_deg"].iter().for_each(|p| say(p));
                let angles = EulerOrder::YZX.from_quat(&skeleton.rotation(q, i));
                out.extend(angles.iter().map(|x| x.to_degrees()));
            }
            Joint::Revolute(_) => {
                say("_deg");
                out.push(q[at].to_degrees());
            }
            Joint::Prismatic(_) => {
                say("_m");
                out.push(q[at]);
            }
            Joint::Fixed => {}
        }
    }
    if let Some(names) = names {
        *names = said;
    }
    out
}

/// Units of the joint forces, one per degree of freedom.
fn force_units(a: &Analysis) -> Vec<&'static str> {
    let links = a.clip.skeleton.links().iter();
    links
        .flat_map(|l| match l.joint {
            Joint::Free => vec!["N", "N", "N", "Nm", "Nm", "Nm"],
            Joint::Spherical => vec!["Nm"; 3],
            Joint::Revolute(_) => vec!["Nm"],
            Joint::Prismatic(_) => vec!["N"],
            Joint::Fixed => Vec::new(),
        })
        .collect()
}

fn force_names(a: &Analysis) -> impl Iterator<Item = (String, &'static str)> {
    // separators of the formats must not be in a name
    let clean = |n: String| n.replace(|c: char| c.is_whitespace() || c == ',' || c == '"', "_");
    a.dof_names().into_iter().map(move |n| clean(n).replace('.', "_")).zip(force_units(a))
}

/// Everything, one row per frame, comma-separated, with a header line; flags are 0 or 1.
pub fn csv(a: &Analysis) -> String {
    let mut t = Table::new(a);
    t.add(axes("com", "m"), &a.com);
    t.add(axes("com_velocity", "m_s"), &a.com_velocity);
    t.add(axes("angular_momentum", "Nms"), &a.angular_momentum);
    t.add(axes("required_force", "N"), &a.required_force);
    t.add(axes("required_moment_com", "Nm"), &a.required_moment_com);
    t.add(axes("ground_force", "N"), &a.ground_force);
    t.add(axes("ground_moment_com", "Nm"), &a.ground_moment_com);
    let residual = axes("residual_force", "N").into_iter().chain(axes("residual_moment", "Nm"));
    t.add(residual, &a.residual);
    t.add(axes("required_cop", "m"), &a.cop);
    t.add(["flight"], &flags(&a.flight));
    let mut broken = [vec![false; a.frames()], vec![false; a.frames()]];
    for (flags, v) in broken.iter_mut().zip([&a.friction_violations, &a.support_violations]) {
        v.frames.iter().for_each(|f| flags[*f] = true);
    }
    t.add(["outside_friction_cone"], &flags(&broken[0]));
    t.add(["outside_support"], &flags(&broken[1]));
    for f in &a.feet {
        t.add([format!("{}_contact", f.name)], &flags(&f.contact));
        t.add([format!("{}_height_m", f.name)], &f.height);
        t.add(axes(&format!("{}_force", f.name), "N"), &f.force);
        t.add(axes(&format!("{}_cop", f.name), "m"), &f.cop);
        t.add([format!("{}_free_moment_Nm", f.name)], &f.free_moment);
    }
    let mut names = Vec::new();
    coordinates(&a.clip.skeleton, a.clip.pose(0), Some(&mut names));
    let q: Vec<f64> =
        (0..a.frames()).flat_map(|k| coordinates(&a.clip.skeleton, a.clip.pose(k), None)).collect();
    t.add(names.iter().map(|n| n.replace([',', '"', '\n'], "_")), &q);
    t.add(force_names(a).map(|(name, unit)| format!("{name}_{unit}")), &a.tau);
    let mut out = String::new();
    t.write(&mut out, "time_s", ',');
    out
}

/// Joint forces as OpenSim's inverse dynamics writes them: `NAME_moment` (N·m), `NAME_force` (N).
pub fn torques_mot(a: &Analysis) -> String {
    let mut t = Table::new(a);
    let kind = |unit: &str| if unit == "N" { "force" } else { "moment" };
    t.add(force_names(a).map(|(name, unit)| format!("{name}_{}", kind(unit))), &a.tau);
    t.mot("Inverse Dynamics Generalized Forces")
}

/// Ground reactions: per foot force (N), point (m) and free moment (N·m), named as OpenSim's external
/// loads; points of unloaded feet are zero, as OpenSim wants them.
pub fn ground_forces_mot(a: &Analysis) -> String {
    let mut t = Table::new(a);
    for f in &a.feet {
        let name = |what: &str| ["x", "y", "z"].map(|x| format!("{}_ground_{what}{x}", f.name));
        t.add(name("force_v"), &f.force);
        let points: Vec<f64> = f.cop.iter().map(|x| if x.is_nan() { 0.0 } else { *x }).collect();
        t.add(name("force_p"), &points);
        let moments: Vec<f64> = f.free_moment.iter().flat_map(|m| [0.0, *m, 0.0]).collect();
        t.add(name("torque_"), &moments);
    }
    t.mot("Ground reactions")
}

#[cfg(test)]
mod tests {
    use super::number;

    #[test]
    fn nine_digits_and_no_more() {
        let text = |x: f64| {
            let mut out = String::new();
            number(&mut out, x);
            out
        };
        assert_eq!(text(735.749_999_999_9), "735.750000");
        assert_eq!(text(-0.001_234_567_891_2), "-0.00123456789");
        assert_eq!(text(0.0), "0");
        assert_eq!(text(1.5e-7), "1.50000000e-7");
        assert_eq!((text(f64::NAN), text(f64::NEG_INFINITY)), ("nan".into(), "-inf".into()));
        // nine digits mean a relative error of at most 5e-9
        for x in [std::f64::consts::PI, 1e8 / 3.0, 2e-4 / 3.0, -9.999_999_999] {
            assert!((text(x).parse::<f64>().unwrap() / x - 1.0).abs() <= 5e-9, "{x}");
        }
    }
}
