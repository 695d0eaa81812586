//! A trace to `.npz`: see the table of [`super`].

use std::io::{self, BufWriter, Seek, Write};
use std::path::Path;

use motion::names::Word;
use motion::{Contact, ContactPlan, Joint, Skeleton, Vec3};
use npyz::{AutoSerialize, DType, WriteOptions, WriterBuilder};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use super::body::{self, joint_type};
use bodies::Character;
use dynamics::{Against, Disturbed, RootMode, Trace};

/// Array and unit, in the order of the table written.
const UNITS: &[(&str, &str)] = &[
    ("rate_hz", "Hz"),
    ("substeps", "1"),
    ("ground_m", "m"),
    ("gravity", "m/s^2"),
    ("root_limit", "N, N·m"),
    ("q", "m, rad, quaternion w x y z"),
    ("target", "m, rad, quaternion w x y z"),
    ("v", "m/s, rad/s"),
    ("torque", "N·m"),
    ("stop_torque", "N·m"),
    ("k_lo", "N·m/rad"),
    ("k_hi", "N·m/rad"),
    ("kd", "N·m·s/rad"),
    ("root_wrench", "N (3), N·m about the root's origin (3)"),
    ("momentum", "N·s (3), N·m·s about the centre of mass (3)"),
    ("com", "m"),
    ("energy", "J"),
    ("link_com", "m"),
    ("ground_up", "1"),
    ("disturbed_wrench", "N (3), N·m about the root's origin (3)"),
    ("root_correction", "N·s (3), N·m·s about the root's origin (3), J"),
    ("carried_mass", "kg"),
    ("carried_at", "m"),
    ("carried_inertia", "kg·m^2"),
    ("carried_com", "m"),
    ("prop_half", "m"),
    ("prop_place", "m, quaternion w x y z"),
    ("prop_friction", "1"),
    ("contact_point", "m"),
    ("contact_force", "N"),
    ("contact_depth", "m"),
    ("plan_span", "s"),
    ("plan_place", "m, quaternion w x y z"),
    ("link_mass", "kg"),
    ("link_com_local", "m"),
    ("link_inertia", "kg·m^2"),
    ("link_offset", "m, quaternion w x y z"),
    ("limit_range", "rad (hinge, ball), m (slide)"),
    ("link_end", "m"),
    ("rest", "m, rad, quaternion w x y z"),
    ("shape_size", "m, quaternion w x y z"),
    ("site_at", "m"),
];

/// Writes the trace as `.npz`. See [`crate::trace_npz`] for the arrays.
///
/// # Errors
/// Those of the writer.
pub fn write<W: Write + Seek>(trace: &Trace, out: W) -> io::Result<()> {
    let skeleton = &*trace.character.skeleton;
    let links = skeleton.links();
    let (nq, nv, count) = (skeleton.nq(), skeleton.nv(), links.len());
    let mut npz = Arrays::new(out);

    npz.numbers("rate_hz", &[], &[trace.rate_hz])?;
    npz.numbers("substeps", &[], &[trace.substeps as i64])?;
    npz.numbers("ground_m", &[], &[trace.ground_m.unwrap_or(f64::NAN)])?;
    npz.numbers("gravity", &[3], trace.gravity.as_slice())?;
    let limit = match trace.root {
        RootMode::Free => [0.0; 2],
        RootMode::Assisted { force_n, moment_nm } => [force_n, moment_nm],
        RootMode::Pinned => [f64::INFINITY; 2],
    };
    npz.text("root_mode", &[], &[trace.root.name().word()])?;
    npz.numbers("root_limit", &[2], &limit)?;

    npz.table("q", nq, &trace.q)?;
    npz.table("target", nq, &trace.target)?;
    npz.table("v", nv, &trace.v)?;
    npz.table("torque", nv, &trace.torque)?;
    npz.table("stop_torque", nv, &trace.stop_torque)?;
    npz.table("k_lo", nv, &trace.k_lo)?;
    npz.table("k_hi", nv, &trace.k_hi)?;
    npz.table("kd", nv, &trace.kd)?;
    npz.table("root_wrench", 6, &trace.root_wrench)?;
    npz.table("momentum", 6, &trace.momentum)?;
    npz.table("com", 3, &trace.com)?;
    npz.table("energy", 2, &trace.energy)?;
    if !trace.link_com.is_empty() {
        npz.table("link_com", 3 * count, &trace.link_com)?;
    }

    write_disturbed(&mut npz, &trace.disturbed)?;

    let c = &trace.contacts;
    let flat = |f: fn(&dynamics::ContactSample) -> Vec3| -> Vec<f64> {
        c.iter().flat_map(|s| <[f64; 3]>::from(f(s))).collect()
    };
    let n = c.len() as u64;
    npz.numbers("contact_row", &[n], &c.iter().map(|s| s.row as i64).collect::<Vec<_>>())?;
    npz.numbers("contact_link", &[n], &c.iter().map(|s| s.link as i64).collect::<Vec<_>>())?;
    npz.table("contact_point", 3, &flat(|s| s.point))?;
    npz.table("contact_force", 3, &flat(|s| s.force))?;
    npz.numbers("contact_depth", &[n], &c.iter().map(|s| s.depth).collect::<Vec<_>>())?;
    if c.iter().any(|s| s.against != Against::Ground) {
        let against = |s: &dynamics::ContactSample| match s.against {
            Against::Ground => -1,
            Against::Prop(i) => -2 - i as i64,
            Against::Link(i) => i as i64,
        };
        npz.numbers("contact_against", &[n], &c.iter().map(against).collect::<Vec<_>>())?;
    }

    write_plan(&mut npz, &trace.plan)?;

    let n = count as u64;
    let bodies = &trace.character.bodies;
    npz.text("link_name", &[n], &links.iter().map(|l| l.name.as_str()).collect::<Vec<_>>())?;
    npz.text("joint_type", &[n], &links.iter().map(|l| joint_type(&l.joint)).collect::<Vec<_>>())?;
    let parents: Vec<i64> = links.iter().map(|l| l.parent.map_or(-1, |p| p as i64)).collect();
    npz.numbers("link_parent", &[n], &parents)?;
    npz.numbers("link_mass", &[n], &bodies.iter().map(|b| b.mass).collect::<Vec<_>>())?;
    let coms: Vec<f64> = bodies.iter().flat_map(|b| <[f64; 3]>::from(b.com)).collect();
    npz.table("link_com_local", 3, &coms)?;
    let inertias: Vec<f64> = bodies.iter().flat_map(|b| b.inertia.iter().copied()).collect();
    npz.table("link_inertia", 9, &inertias)?;
    let offsets: Vec<f64> = links
        .iter()
        .flat_map(|l| {
            let (p, r) = (l.parent_from_zero.translation.vector, l.parent_from_zero.rotation);
            [p.x, p.y, p.z, r.w, r.i, r.j, r.k]
        })
        .collect();
    npz.table("link_offset", 7, &offsets)?;
    let axes: Vec<f64> = links
        .iter()
        .flat_map(|l| match l.joint {
            Joint::Revolute(a) | Joint::Prismatic(a) => <[f64; 3]>::from(a),
            _ => [0.0; 3],
        })
        .collect();
    npz.table("joint_axis", 3, &axes)?;
    let at = |f: fn(&Skeleton, usize) -> usize| -> Vec<i64> {
        (0..count).map(|i| f(skeleton, i) as i64).collect()
    };
    npz.numbers("joint_q_at", &[n], &at(Skeleton::q_at))?;
    npz.numbers("joint_v_at", &[n], &at(Skeleton::v_at))?;
    let names = skeleton.dof_names();
    npz.text("dof_name", &[nv as u64], &names.iter().map(String::as_str).collect::<Vec<_>>())?;
    let d = &trace.disturbed;
    let written = |name: &str| match name {
        "ground_up" => tilted(d),
        "disturbed_wrench" => !d.wrench.is_empty(),
        "root_correction" => !d.root_correction.is_empty(),
        "plan_span" | "plan_place" => !trace.plan.is_empty(),
        "prop_half" | "prop_place" | "prop_friction" => !d.props.is_empty(),
        _ => !name.starts_with("carried_") || !d.carried.is_empty(),
    };
    let units: Vec<&str> = UNITS.iter().filter(|u| written(u.0)).flat_map(|u| [u.0, u.1]).collect();
    if trace.colors.iter().any(Option::is_some) {
        let rgb = |c: &Option<[u8; 3]>| c.map_or([-1; 3], |c| c.map(i64::from));
        let colors: Vec<i64> = trace.colors.iter().flat_map(rgb).collect();
        npz.numbers("link_color", &[trace.colors.len() as u64, 3], &colors)?;
    }
    write_body(&mut npz, &trace.character)?;
    npz.text("units", &[units.len() as u64 / 2, 2], &units)?;
    npz.finish()
}

/// Writes the trace to a file, under a temporary name first: a failure leaves an earlier file whole.
///
/// # Errors
/// Those of the file system.
pub fn save(trace: &Trace, path: &Path) -> io::Result<()> {
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(".tmp");
    let temporary = path.with_file_name(name);
    let written = std::fs::File::create(&temporary).and_then(|f| write(trace, BufWriter::new(f)));
    let done = written.and_then(|()| std::fs::rename(&temporary, path));
    if done.is_err() {
        let _ = std::fs::remove_file(&temporary);
    }
    done
}

fn tilted(d: &Disturbed) -> bool {
    d.ground_up.iter().any(|up| *up != Vec3::y())
}

/// Only what there is: an undisturbed run has none of these arrays.
fn write_disturbed<W: Write + Seek>(npz: &mut Arrays<W>, d: &Disturbed) -> io::Result<()> {
    if tilted(d) {
        let up: Vec<f64> = d.ground_up.iter().flat_map(|u| [u.x, u.y, u.z]).collect();
        match d.ground_up.len() {
            1 => npz.numbers("ground_up", &[3], &up)?,
            _ => npz.table("ground_up", 3, &up)?,
        }
    }
    if !d.wrench.is_empty() {
        npz.table("disturbed_wrench", 6, &d.wrench)?;
    }
    if !d.root_correction.is_empty() {
        npz.table("root_correction", 7, &d.root_correction)?;
    }
    if !d.props.is_empty() {
        let n = d.props.len() as u64;
        npz.text("prop_name", &[n], &d.props.iter().map(|p| p.name.as_str()).collect::<Vec<_>>())?;
        npz.table(
            "prop_half",
            3,
            &d.props.iter().flat_map(|p| <[f64; 3]>::from(p.half)).collect::<Vec<_>>(),
        )?;
        let place = |p: &bodies::Prop| {
            let (at, r) = (p.place.translation.vector, p.place.rotation);
            [at.x, at.y, at.z, r.w, r.i, r.j, r.k]
        };
        npz.table("prop_place", 7, &d.props.iter().flat_map(place).collect::<Vec<_>>())?;
        npz.numbers("prop_friction", &[n], &d.props.iter().map(|p| p.friction).collect::<Vec<_>>())?;
    }
    if d.carried.is_empty() {
        return Ok(());
    }
    let c = &d.carried;
    let n = c.len() as u64;
    npz.indices("carried_link", c.iter().map(|c| c.what.link))?;
    npz.numbers("carried_mass", &[n], &c.iter().map(|c| c.what.mass).collect::<Vec<_>>())?;
    npz.table("carried_at", 3, &c.iter().flat_map(|c| <[f64; 3]>::from(c.what.at)).collect::<Vec<_>>())?;
    let inertias: Vec<f64> = c.iter().flat_map(|c| c.what.inertia.iter().copied()).collect();
    npz.table("carried_inertia", 9, &inertias)?;
    let row = |r: usize| i64::try_from(r).unwrap_or(i64::MAX);
    let spans: Vec<i64> = c.iter().flat_map(|c| [row(c.from_row), row(c.to_row)]).collect();
    npz.numbers("carried_rows", &[n, 2], &spans)?;
    npz.table("carried_com", 3 * c.len(), &d.carried_com)
}

/// What was to stand when, where there is anything.
fn write_plan<W: Write + Seek>(npz: &mut Arrays<W>, plan: &ContactPlan) -> io::Result<()> {
    if plan.is_empty() {
        return Ok(());
    }
    let all = plan.contacts();
    let points: Vec<&str> = all.iter().map(|c| c.point.as_str()).collect();
    npz.text("plan_point", &[all.len() as u64], &points)?;
    npz.table("plan_span", 2, &all.iter().flat_map(|c| [c.from_s, c.to_s]).collect::<Vec<_>>())?;
    let place = |c: &Contact| {
        c.world_from_point.map_or([f64::NAN; 7], |w| {
            let (p, r) = (w.translation.vector, w.rotation);
            [p.x, p.y, p.z, r.w, r.i, r.j, r.k]
        })
    };
    npz.table("plan_place", 7, &all.iter().flat_map(place).collect::<Vec<_>>())
}

/// What of the body is not in the arrays of the links already.
fn write_body<W: Write + Seek>(npz: &mut Arrays<W>, character: &Character) -> io::Result<()> {
    let skeleton = &*character.skeleton;
    let links = skeleton.links();
    let name = |table: &[(&'static str, bodies::JointClass)], class| {
        table.iter().find(|(_, c)| *c == class).map_or("other", |(name, _)| *name)
    };
    npz.text("character_name", &[], &[character.name.as_str()])?;
    let classes: Vec<&str> = character.classes.iter().map(|&c| name(body::CLASSES, c)).collect();
    npz.text("joint_class", &[classes.len() as u64], &classes)?;
    let (mut axes, mut ranges) = (Vec::new(), Vec::new());
    for link in links {
        let (a, r) = body::limits_out(link);
        axes.extend(a);
        ranges.extend(r);
    }
    npz.table("limit_axes", 9, &axes)?;
    npz.table("limit_range", 6, &ranges)?;
    let ends: Vec<f64> = links.iter().flat_map(|l| l.end.map_or([f64::NAN; 3], <[f64; 3]>::from)).collect();
    npz.table("link_end", 3, &ends)?;
    npz.numbers("rest", &[character.rest.len() as u64], &character.rest)?;

    let shapes = body::shapes_out(character);
    npz.indices("shape_link", shapes.iter().map(|s| s.0))?;
    npz.text("shape_type", &[shapes.len() as u64], &shapes.iter().map(|s| s.1).collect::<Vec<_>>())?;
    npz.table("shape_size", body::SHAPE, &shapes.iter().flat_map(|s| s.2).collect::<Vec<_>>())?;

    let sites = skeleton.sites();
    npz.text("site_name", &[sites.len() as u64], &sites.iter().map(|s| s.name.as_str()).collect::<Vec<_>>())?;
    npz.indices("site_link", sites.iter().map(|s| s.link))?;
    npz.table("site_at", 3, &sites.iter().flat_map(|s| <[f64; 3]>::from(s.at)).collect::<Vec<_>>())?;
    npz.indices("contact_site", character.contacts.iter().copied())?;

    let limbs = skeleton.limbs();
    let n = limbs.len() as u64;
    npz.text("limb_name", &[n], &limbs.iter().map(|l| l.name.as_str()).collect::<Vec<_>>())?;
    let kind = |k| body::LIMBS.iter().find(|(_, kind)| *kind == k).map_or("", |(name, _)| *name);
    npz.text("limb_kind", &[n], &limbs.iter().map(|l| kind(l.kind)).collect::<Vec<_>>())?;
    let of: Vec<i64> = limbs.iter().flat_map(|l| [l.upper as i64, l.lower as i64, l.end as i64]).collect();
    npz.numbers("limb_links", &[n, 3], &of)?;

    let parts = skeleton.parts();
    let n = parts.len() as u64;
    npz.text("part_name", &[n], &parts.keys().map(String::as_str).collect::<Vec<_>>())?;
    let member: Vec<i64> = (parts.values())
        .flat_map(|part| (0..links.len()).map(move |l| i64::from(part.contains(&l))))
        .collect();
    npz.numbers("part_links", &[n, links.len() as u64], &member)
}

/// Arrays on their way into a zip.
pub(crate) struct Arrays<W: Write + Seek>(ZipWriter<W>);

impl<W: Write + Seek> Arrays<W> {
    pub(crate) fn new(out: W) -> Self {
        Self(ZipWriter::new(out))
    }

    pub(crate) fn finish(self) -> io::Result<()> {
        self.0.finish()?.flush()
    }

    pub(crate) fn numbers<T: AutoSerialize>(
        &mut self,
        name: &str,
        shape: &[u64],
        data: &[T],
    ) -> io::Result<()> {
        let mut bytes = Vec::new();
        let mut array = WriteOptions::new().default_dtype().shape(shape).writer(&mut bytes).begin_nd()?;
        array.extend(data)?;
        array.finish()?;
        self.entry(name, &bytes)
    }

    fn entry(&mut self, name: &str, npy: &[u8]) -> io::Result<()> {
        self.file(&format!("{name}.npy"), npy)
    }

    /// A file that is no array.
    pub(crate) fn file(&mut self, name: &str, bytes: &[u8]) -> io::Result<()> {
        self.0.start_file(name, options())?;
        self.0.write_all(bytes)
    }

    pub(crate) fn indices(&mut self, name: &str, data: impl Iterator<Item = usize>) -> io::Result<()> {
        let data: Vec<i64> = data.map(|i| i as i64).collect();
        self.numbers(name, &[data.len() as u64], &data)
    }

    pub(crate) fn table(&mut self, name: &str, columns: usize, data: &[f64]) -> io::Result<()> {
        let rows = data.len() / columns.max(1);
        self.numbers(name, &[rows as u64, columns as u64], data)
    }

    pub(crate) fn text(&mut self, name: &str, shape: &[u64], data: &[&str]) -> io::Result<()> {
        let width = data.iter().map(|s| s.chars().count()).max().unwrap_or(0).max(1);
        let dtype = format!("<U{width}").parse().map_err(io::Error::other)?;
        let mut bytes = Vec::new();
        let options = WriteOptions::<str>::new().dtype(DType::Plain(dtype)).shape(shape);
        let mut array = options.writer(&mut bytes).begin_nd()?;
        data.iter().try_for_each(|s| array.push(s))?;
        array.finish()?;
        self.entry(name, &bytes)
    }
}

/// Stored: deflating 6 MB of noise-like mantissas costs more time than it saves space.
fn options() -> SimpleFileOptions {
    SimpleFileOptions::default()
        .compression_method(CompressionMethod::Stored)
        .last_modified_time(DateTime::default())
        .unix_permissions(0o644)
}
