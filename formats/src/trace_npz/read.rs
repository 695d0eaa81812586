//! A trace from `.npz`: see the table of [`super`].
//!
//! Every array is checked against the shape the others imply before a [`Trace`] is made of them; the
//! character passes the checks every character passes. Recorded numbers may be NaN or infinite (a run
//! that diverged has such rows); those of the body may not.

use std::io::{Read, Seek};
use std::path::Path;
use std::sync::Arc;

use motion::file::read_within;
use motion::names::Word;
use motion::{
    Contact, ContactPlan, Limb, Limits, Link, Quat, Site, Skeleton, SkeletonError, Transform, Vec3,
};
use nalgebra::{Matrix3, Quaternion, Translation3};
use thiserror::Error;
use zip::ZipArchive;
use zip::result::ZipError;

use super::body;
use super::npy::{Fault, Npy};
use crate::limits::TRACE_BYTES;
use bodies::{Body, Carried, Character, CharacterError, Prop};
use dynamics::{Against, ContactSample, Disturbed, Handed, RootMode, RootName, Trace};

/// Why a file is no trace.
#[derive(Debug, Error)]
pub enum TraceFileError {
    /// The file system said no.
    #[error("cannot read it: {0}")]
    Io(#[from] std::io::Error),
    /// Not a zip, or a broken one.
    #[error("not an .npz (a zip of .npy arrays) that can be read: {0}")]
    Zip(String),
    /// An array that is not there.
    #[error("array `{array}` is missing; allowed: a trace.npz of `contrapposto render`, of this version")]
    Missing {
        /// Its name.
        array: &'static str,
    },
    /// An array whose bytes make no sense.
    #[error("array `{array}`: {fault}")]
    Array {
        /// Its name.
        array: &'static str,
        /// What was found, and what is allowed.
        fault: String,
    },
    /// An array of another shape than the others need.
    #[error("array `{array}` has shape {found:?}; allowed: {allowed:?}")]
    Shape {
        /// Its name.
        array: &'static str,
        /// Shape found.
        found: Vec<usize>,
        /// Shape needed.
        allowed: Vec<usize>,
    },
    /// A value that cannot be.
    #[error("array `{array}`, entry {index}: {found}; allowed: {allowed}")]
    Value {
        /// Its name.
        array: &'static str,
        /// Index along its first axis.
        index: usize,
        /// What was found.
        found: String,
        /// What is allowed.
        allowed: String,
    },
    /// A skeleton that cannot be.
    #[error("the skeleton in it: {0}")]
    Skeleton(#[from] SkeletonError),
    /// A body that cannot be.
    #[error("the body in it: {0}")]
    Character(#[from] CharacterError),
}

/// Control rates a trace may have, Hz.
const RATES: std::ops::RangeInclusive<f64> = 1e-3..=1e6;

/// Reads a trace written by [`write`](super::write()); equal to it but for `wall_s`, which is zero.
///
/// # Errors
/// [`TraceFileError`]: what was found, what is allowed, where.
pub fn read<R: Read + Seek>(input: R) -> Result<Trace, TraceFileError> {
    arrays(&mut Arrays::new(input)?)
}

/// [`read`] of a file.
///
/// # Errors
/// As [`read`], and of the file system.
pub fn open(path: &Path) -> Result<Trace, TraceFileError> {
    // the whole file at once: arrays are read one after another, each in one piece
    read(std::io::Cursor::new(read_within(path, TRACE_BYTES)?))
}

fn arrays<R: Read + Seek>(npz: &mut Arrays<R>) -> Result<Trace, TraceFileError> {
    let character = Arc::new(character(npz)?);
    let skeleton = &character.skeleton;
    let (nq, nv, links) = (skeleton.nq(), skeleton.nv(), skeleton.links().len());
    let rate_hz = npz.reals("rate_hz", &[])?[0];
    if !RATES.contains(&rate_hz) {
        return Err(value("rate_hz", 0, format!("{rate_hz} Hz"), "0.001 to 1e6 Hz"));
    }
    let substeps = npz.integers("substeps", &[])?[0];
    let substeps = usize::try_from(substeps).ok().filter(|s| (1..=1_000_000).contains(s));
    let substeps = substeps.ok_or_else(|| value("substeps", 0, "no such count".into(), "1 to 1000000"))?;
    let gravity = npz.vectors("gravity", &[3])?[0];
    if !gravity.iter().all(|x| x.is_finite()) {
        return Err(value("gravity", 0, format!("{:?}", gravity.as_slice()), "finite numbers"));
    }
    let ground = npz.reals("ground_m", &[])?[0];

    let (shape, q) = npz.array("q")?;
    let rows = shape.first().copied().unwrap_or(0);
    check_shape("q", &shape, &[rows, nq])?;
    let q = q.into_reals().map_err(fault("q"))?;
    if rows == 0 {
        return Err(value("q", 0, "no rows".into(), "at least one row"));
    }
    let mut table = |name, columns| npz.reals(name, &[rows, columns]);
    let mut trace = Trace {
        rate_hz,
        substeps,
        root: RootMode::Free,
        ground_m: ground.is_finite().then_some(ground),
        gravity,
        q,
        target: table("target", nq)?,
        v: table("v", nv)?,
        torque: table("torque", nv)?,
        stop_torque: table("stop_torque", nv)?,
        k_lo: table("k_lo", nv)?,
        k_hi: table("k_hi", nv)?,
        kd: table("kd", nv)?,
        root_wrench: table("root_wrench", 6)?,
        momentum: table("momentum", 6)?,
        com: table("com", 3)?,
        energy: table("energy", 2)?,
        link_com: Vec::new(),
        disturbed: dynamics::Disturbed::default(),
        contacts: Vec::new(),
        plan: motion::ContactPlan::default(),
        colors: Vec::new(),
        wall_s: 0.0,
        character: character.clone(),
    };
    if npz.has("link_com") {
        trace.link_com = npz.reals("link_com", &[rows, 3 * links])?;
    }
    if npz.has("link_color") {
        trace.colors = colors(&npz.integers("link_color", &[links, 3])?)?;
    }
    trace.plan = plan(npz)?;
    trace.root = root(npz)?;
    trace.disturbed = disturbed(npz, rows, links)?;
    trace.contacts = contacts(npz, (rows, links, trace.disturbed.props.len()))?;
    Ok(trace)
}

/// Colours of links, three numbers each: −1 of a link that has none.
fn colors(numbers: &[i64]) -> Result<Vec<Option<[u8; 3]>>, TraceFileError> {
    let color = |(link, rgb): (usize, &[i64])| {
        if rgb.iter().all(|&x| x == -1) {
            return Ok(None);
        }
        let part = |x: i64| {
            u8::try_from(x)
                .map_err(|_| value("link_color", link, x.to_string(), "0 to 255, or -1 thrice for none"))
        };
        Ok(Some([part(rgb[0])?, part(rgb[1])?, part(rgb[2])?]))
    };
    numbers.chunks_exact(3).enumerate().map(color).collect()
}

fn plan<R: Read + Seek>(npz: &mut Arrays<R>) -> Result<ContactPlan, TraceFileError> {
    if !npz.has("plan_span") {
        return Ok(ContactPlan::default());
    }
    let (shape, span) = npz.array("plan_span")?;
    let n = shape.first().copied().unwrap_or(0);
    check_shape("plan_span", &shape, &[n, 2])?;
    let span = span.into_reals().map_err(fault("plan_span"))?;
    let points = npz.texts("plan_point", &[n])?;
    let places = npz.reals("plan_place", &[n, 7])?;
    let mut contacts = Vec::with_capacity(n);
    for (i, point) in points.iter().enumerate() {
        let p = &places[7 * i..7 * i + 7];
        let turn = Quaternion::new(p[3], p[4], p[5], p[6]);
        let unknown = p.iter().all(|x| x.is_nan());
        if !unknown && ((turn.norm() - 1.0).abs() > 1e-9 || !p.iter().all(|x| x.is_finite())) {
            let allowed = "a position and a quaternion of length 1, or NaN seven times";
            return Err(value("plan_place", i, format!("{p:?}"), allowed));
        }
        let place = || Transform::from_parts(Vec3::new(p[0], p[1], p[2]).into(), Quat::new_unchecked(turn));
        contacts.push(Contact {
            point: point.clone(),
            from_s: span[2 * i],
            to_s: span[2 * i + 1],
            world_from_point: (!unknown).then(place),
        });
    }
    ContactPlan::new(contacts).map_err(|e| value("plan_span", 0, e.to_string(), "contacts that are a plan"))
}

fn root<R: Read + Seek>(npz: &mut Arrays<R>) -> Result<RootMode, TraceFileError> {
    let limit = npz.reals("root_limit", &[2])?;
    let found = &npz.texts("root_mode", &[])?[0];
    match RootName::find(found) {
        Ok(RootName::Free) => Ok(RootMode::Free),
        Ok(RootName::Pinned) => Ok(RootMode::Pinned),
        Ok(RootName::Assisted) if limit.iter().all(|x| *x >= 0.0) => {
            Ok(RootMode::Assisted { force_n: limit[0], moment_nm: limit[1] })
        }
        Ok(RootName::Assisted) => {
            Err(value("root_limit", 0, format!("{limit:?}"), "two numbers, zero or more"))
        }
        Ok(RootName::Fidelity) | Err(_) => {
            Err(value("root_mode", 0, quoted(found), "free, assisted, pinned"))
        }
    }
}

fn disturbed<R: Read + Seek>(
    npz: &mut Arrays<R>,
    rows: usize,
    links: usize,
) -> Result<Disturbed, TraceFileError> {
    let mut out = Disturbed::default();
    if npz.has("ground_up") {
        let once = npz.array("ground_up")?.0.len() == 1;
        let shape: &[usize] = if once { &[3] } else { &[rows, 3] };
        out.ground_up = npz.vectors("ground_up", shape)?;
        for (row, up) in out.ground_up.iter().enumerate() {
            let length = up.norm();
            if (length - 1.0).abs() > 1e-9 || up.y <= 0.0 || !length.is_finite() {
                let found = format!("{:?}", up.as_slice());
                return Err(value("ground_up", row, found, "a direction of length 1 that points up"));
            }
        }
    }
    if npz.has("disturbed_wrench") {
        out.wrench = npz.reals("disturbed_wrench", &[rows, 6])?;
    }
    if npz.has("root_correction") {
        out.root_correction = npz.reals("root_correction", &[rows, 7])?;
    }
    if npz.has("prop_name") {
        out.props = props(npz)?;
    }
    if !npz.has("carried_link") {
        return Ok(out);
    }
    let (shape, link) = npz.array("carried_link")?;
    let n = shape.first().copied().unwrap_or(0);
    check_shape("carried_link", &shape, &[n])?;
    let link = indices("carried_link", &link.into_integers().map_err(fault("carried_link"))?, links)?;
    let mass = npz.reals("carried_mass", &[n])?;
    let at = npz.vectors("carried_at", &[n, 3])?;
    let inertia = npz.reals("carried_inertia", &[n, 9])?;
    let span = npz.integers("carried_rows", &[n, 2])?;
    for i in 0..n {
        let mut numbers = at[i].iter().chain(&inertia[9 * i..9 * i + 9]).chain(&mass[i..=i]);
        if mass[i] <= 0.0 || !numbers.all(|x| x.is_finite()) {
            let found = format!("{} kg at {:?}", mass[i], at[i].as_slice());
            return Err(value("carried_mass", i, found, "a mass over 0, finite numbers"));
        }
        let row = |x: i64| {
            let all = "rows from 0 on, the first before the last".into();
            usize::try_from(x).map_err(|_| TraceFileError::Value {
                array: "carried_rows",
                index: i,
                found: x.to_string(),
                allowed: all,
            })
        };
        out.carried.push(Handed {
            what: Carried {
                link: link[i],
                mass: mass[i],
                at: at[i],
                inertia: Matrix3::from_column_slice(&inertia[9 * i..9 * i + 9]),
            },
            from_row: row(span[2 * i])?,
            to_row: row(span[2 * i + 1])?,
        });
    }
    out.carried_com = npz.reals("carried_com", &[rows, 3 * n])?;
    Ok(out)
}

fn props<R: Read + Seek>(npz: &mut Arrays<R>) -> Result<Vec<Prop>, TraceFileError> {
    let names = npz.list("prop_name")?;
    let n = names.len();
    let half = npz.vectors("prop_half", &[n, 3])?;
    let place = npz.reals("prop_place", &[n, 7])?;
    let friction = npz.reals("prop_friction", &[n])?;
    let one = |(i, name): (usize, String)| {
        if !half[i].iter().all(|x| x.is_finite() && *x > 0.0) {
            return Err(value("prop_half", i, format!("{:?}", half[i].as_slice()), "positive numbers"));
        }
        if !(friction[i] >= 0.0 && friction[i].is_finite()) {
            return Err(value("prop_friction", i, friction[i].to_string(), "zero or more"));
        }
        let p = &place[7 * i..7 * i + 7];
        let turn = Quaternion::new(p[3], p[4], p[5], p[6]);
        if !p.iter().all(|x| x.is_finite()) || (turn.norm() - 1.0).abs() > 1e-9 {
            return Err(value("prop_place", i, format!("{p:?}"), "finite numbers, a quaternion of length 1"));
        }
        let at = Vec3::new(p[0], p[1], p[2]);
        let place = Transform::from_parts(at.into(), Quat::new_unchecked(turn));
        Ok(Prop { name, half: half[i], place, friction: friction[i] })
    };
    names.into_iter().enumerate().map(one).collect()
}

fn contacts<R: Read + Seek>(
    npz: &mut Arrays<R>,
    (rows, links, props): (usize, usize, usize),
) -> Result<Vec<ContactSample>, TraceFileError> {
    let (shape, row) = npz.array("contact_row")?;
    let n = shape.first().copied().unwrap_or(0);
    check_shape("contact_row", &shape, &[n])?;
    let row = row.into_integers().map_err(fault("contact_row"))?;
    let row = indices("contact_row", &row, rows)?;
    if let Some(i) = (1..n).find(|&i| row[i] < row[i - 1]) {
        return Err(value("contact_row", i, format!("{} after {}", row[i], row[i - 1]), "ascending rows"));
    }
    let link = npz.integers("contact_link", &[n])?;
    let link = indices("contact_link", &link, links)?;
    let point = npz.vectors("contact_point", &[n, 3])?;
    let force = npz.vectors("contact_force", &[n, 3])?;
    let depth = npz.reals("contact_depth", &[n])?;
    let codes = if npz.has("contact_against") { npz.integers("contact_against", &[n])? } else { vec![-1; n] };
    let against = |(i, code): (usize, &i64)| match usize::try_from(*code) {
        Ok(other) if other < links => Ok(Against::Link(other)),
        Err(_) if *code == -1 => Ok(Against::Ground),
        Err(_) if code.checked_add(2).and_then(i64::checked_neg).is_some_and(|p| (p as usize) < props) => {
            Ok(Against::Prop((-2 - code) as usize))
        }
        _ => Err(value("contact_against", i, code.to_string(), "-1, a link, -2 - the number of a prop")),
    };
    let against = codes.iter().enumerate().map(against).collect::<Result<Vec<_>, _>>()?;
    let sample = |i: usize| ContactSample {
        row: row[i],
        link: link[i],
        against: against[i],
        point: point[i],
        force: force[i],
        depth: depth[i],
    };
    Ok((0..n).map(sample).collect())
}

fn character<R: Read + Seek>(npz: &mut Arrays<R>) -> Result<Character, TraceFileError> {
    let skeleton = skeleton(npz)?;
    let n = skeleton.links().len();
    let mass = npz.reals("link_mass", &[n])?;
    let com = npz.vectors("link_com_local", &[n, 3])?;
    let inertia = npz.reals("link_inertia", &[n, 9])?;
    if let Some(i) = (0..n).find(|&i| !com[i].iter().chain(&inertia[9 * i..9 * i + 9]).all(|x| x.is_finite()))
    {
        let found = format!("{:?} m, {:?} kg·m²", com[i].as_slice(), &inertia[9 * i..9 * i + 9]);
        return Err(value("link_inertia", i, found, "finite centres of mass and inertias"));
    }
    let mut bodies: Vec<Body> = (0..n)
        .map(|i| Body {
            mass: mass[i],
            com: com[i],
            inertia: Matrix3::from_column_slice(&inertia[9 * i..9 * i + 9]),
            shapes: Vec::new(),
        })
        .collect();
    let kind = npz.list("shape_type")?;
    let link = npz.integers("shape_link", &[kind.len()])?;
    let link = indices("shape_link", &link, n)?;
    let size = npz.reals("shape_size", &[kind.len(), body::SHAPE])?;
    for (i, numbers) in size.chunks_exact(body::SHAPE).enumerate() {
        one_of("shape_type", i, &kind[i], body::SHAPES)?;
        let shape = body::shape_in(&kind[i], numbers).ok_or_else(|| {
            value("shape_size", i, format!("{numbers:?}"), "finite numbers, lengths over 0, unit quaternions")
        })?;
        bodies[link[i]].shapes.push(shape);
    }
    let class = npz.texts("joint_class", &[n])?;
    let named = |(i, name): (usize, &String)| named("joint_class", i, name, body::CLASSES);
    let classes = class.iter().enumerate().map(named).collect::<Result<_, _>>()?;
    let (shape, contact) = npz.array("contact_site")?;
    check_shape("contact_site", &shape, &[shape.first().copied().unwrap_or(0)])?;
    let contact = contact.into_integers().map_err(fault("contact_site"))?;
    let contacts = indices("contact_site", &contact, skeleton.sites().len())?;
    let rest = npz.reals("rest", &[skeleton.nq()])?;
    if let Some(i) = rest.iter().position(|x| !x.is_finite()) {
        return Err(value("rest", i, rest[i].to_string(), "finite numbers"));
    }
    let name = npz.texts("character_name", &[])?.remove(0);
    Ok(Character { name, skeleton: Arc::new(skeleton), bodies, classes, contacts, rest }.check()?)
}

fn skeleton<R: Read + Seek>(npz: &mut Arrays<R>) -> Result<Skeleton, TraceFileError> {
    let names = npz.list("link_name")?;
    let n = names.len();
    let kind = npz.texts("joint_type", &[n])?;
    let parent = npz.integers("link_parent", &[n])?;
    let axis = npz.vectors("joint_axis", &[n, 3])?;
    let offset = npz.reals("link_offset", &[n, 7])?;
    let axes = npz.reals("limit_axes", &[n, 9])?;
    let ranges = npz.reals("limit_range", &[n, 6])?;
    let end = npz.vectors("link_end", &[n, 3])?;
    let mut links = Vec::with_capacity(n);
    for (i, name) in names.into_iter().enumerate() {
        one_of("joint_type", i, &kind[i], body::JOINTS)?;
        let parent = match parent[i] {
            -1 => None,
            p => Some(indices("link_parent", &[p], n)?[0]),
        };
        let o = &offset[7 * i..7 * i + 7];
        let rotation = body::quaternion(&o[3..]).ok_or_else(|| {
            value("link_offset", i, format!("{:?}", &o[3..]), "a quaternion w x y z of length 1")
        })?;
        let limits = body::limits_in(&axes[9 * i..9 * i + 9], &ranges[6 * i..6 * i + 6]);
        if let Some(Limits::Ball(ball)) = &limits
            && !body::orthonormal(ball)
        {
            let found = format!("{:?}", &axes[9 * i..9 * i + 9]);
            return Err(value("limit_axes", i, found, "three orthonormal axes"));
        }
        links.push(Link {
            name,
            parent,
            parent_from_zero: Transform::from_parts(Translation3::new(o[0], o[1], o[2]), rotation),
            joint: body::joint(&kind[i], axis[i]),
            limits,
            end: (!end[i].x.is_nan()).then_some(end[i]),
        });
    }
    let skeleton = Skeleton::new(links)?;
    let names = npz.list("site_name")?;
    let link = npz.integers("site_link", &[names.len()])?;
    let link = indices("site_link", &link, n)?;
    let at = npz.vectors("site_at", &[names.len(), 3])?;
    if let Some(i) = at.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
        return Err(value("site_at", i, format!("{:?}", at[i].as_slice()), "finite numbers"));
    }
    let site = |(i, name)| Site { name, link: link[i], at: at[i] };
    let sites = names.into_iter().enumerate().map(site).collect();
    let names = npz.list("limb_name")?;
    let kind = npz.texts("limb_kind", &[names.len()])?;
    let of = npz.integers("limb_links", &[names.len(), 3])?;
    let of = indices("limb_links", &of, n)?;
    let mut limbs = Vec::with_capacity(names.len());
    for (i, name) in names.into_iter().enumerate() {
        let kind = named("limb_kind", i, &kind[i], body::LIMBS)?;
        limbs.push(Limb { name, kind, upper: of[3 * i], lower: of[3 * i + 1], end: of[3 * i + 2] });
    }
    let names = npz.list("part_name")?;
    let member = npz.integers("part_links", &[names.len(), n])?;
    let links = |i: usize| (0..n).filter(|l| member[i * n + l] != 0).collect();
    let parts = names.into_iter().enumerate().map(|(i, name)| (name, links(i))).collect();
    Ok(skeleton.with_limbs(limbs)?.with_sites(sites)?.with_parts(parts)?)
}

/// The arrays of a file, one by one.
pub(crate) struct Arrays<R: Read + Seek>(ZipArchive<R>);

impl<R: Read + Seek> Arrays<R> {
    pub(crate) fn new(input: R) -> Result<Self, TraceFileError> {
        Ok(Arrays(ZipArchive::new(input).map_err(zip_fault)?))
    }

    /// A file that is no array; `None` where there is none of this name.
    pub(crate) fn file(&mut self, name: &str) -> Option<Vec<u8>> {
        let mut bytes = Vec::new();
        self.0.by_name(name).ok()?.read_to_end(&mut bytes).ok()?;
        Some(bytes)
    }

    pub(crate) fn has(&self, name: &str) -> bool {
        let file = format!("{name}.npy");
        self.0.file_names().any(|f| f.is_ok_and(|f| f == file))
    }

    pub(crate) fn array(&mut self, name: &'static str) -> Result<(Vec<usize>, Npy), TraceFileError> {
        let mut entry = match self.0.by_name(&format!("{name}.npy")) {
            Ok(entry) => entry,
            Err(ZipError::FileNotFound) => return Err(TraceFileError::Missing { array: name }),
            Err(ZipError::UnsupportedArchive(why)) => {
                let why = format!("{why}; allowed: stored, not compressed (numpy.savez)");
                return Err(TraceFileError::Array { array: name, fault: why });
            }
            Err(e) => return Err(zip_fault(e)),
        };
        let mut bytes = Vec::new();
        // reading to the end also compares the entry's checksum; a wrong one is an error here
        entry.read_to_end(&mut bytes).map_err(|e| fault(name)(e.to_string()))?;
        let array = Npy::parse(&bytes).map_err(fault(name))?;
        Ok((array.shape.clone(), array))
    }

    pub(crate) fn shaped(&mut self, name: &'static str, allowed: &[usize]) -> Result<Npy, TraceFileError> {
        let (found, array) = self.array(name)?;
        check_shape(name, &found, allowed)?;
        Ok(array)
    }

    pub(crate) fn reals(&mut self, name: &'static str, shape: &[usize]) -> Result<Vec<f64>, TraceFileError> {
        self.shaped(name, shape)?.into_reals().map_err(fault(name))
    }

    pub(crate) fn vectors(
        &mut self,
        name: &'static str,
        shape: &[usize],
    ) -> Result<Vec<Vec3>, TraceFileError> {
        Ok(self.reals(name, shape)?.chunks_exact(3).map(Vec3::from_column_slice).collect())
    }

    pub(crate) fn integers(
        &mut self,
        name: &'static str,
        shape: &[usize],
    ) -> Result<Vec<i64>, TraceFileError> {
        self.shaped(name, shape)?.into_integers().map_err(fault(name))
    }

    pub(crate) fn texts(
        &mut self,
        name: &'static str,
        shape: &[usize],
    ) -> Result<Vec<String>, TraceFileError> {
        self.shaped(name, shape)?.into_texts().map_err(fault(name))
    }

    /// Texts of any number.
    pub(crate) fn list(&mut self, name: &'static str) -> Result<Vec<String>, TraceFileError> {
        let (found, array) = self.array(name)?;
        check_shape(name, &found, &[found.first().copied().unwrap_or(0)])?;
        array.into_texts().map_err(fault(name))
    }
}

fn zip_fault(e: ZipError) -> TraceFileError {
    match e {
        ZipError::Io(e) if e.kind() != std::io::ErrorKind::UnexpectedEof => TraceFileError::Io(e),
        other => TraceFileError::Zip(other.to_string()),
    }
}

fn fault(array: &'static str) -> impl Fn(Fault) -> TraceFileError {
    move |fault| TraceFileError::Array { array, fault }
}

fn value(array: &'static str, index: usize, found: String, allowed: &str) -> TraceFileError {
    TraceFileError::Value { array, index, found, allowed: allowed.to_owned() }
}

fn check_shape(array: &'static str, found: &[usize], allowed: &[usize]) -> Result<(), TraceFileError> {
    if found == allowed {
        return Ok(());
    }
    Err(TraceFileError::Shape { array, found: found.to_vec(), allowed: allowed.to_vec() })
}

/// Indices below `count`.
fn indices(array: &'static str, found: &[i64], count: usize) -> Result<Vec<usize>, TraceFileError> {
    let check = |(i, &x): (usize, &i64)| {
        let index = usize::try_from(x).ok().filter(|x| *x < count);
        index.ok_or_else(|| value(array, i, x.to_string(), &format!("0 or more, less than {count}")))
    };
    found.iter().enumerate().map(check).collect()
}

fn one_of(array: &'static str, index: usize, found: &str, allowed: &[&str]) -> Result<(), TraceFileError> {
    if allowed.contains(&found) {
        return Ok(());
    }
    Err(value(array, index, quoted(found), &allowed.join(", ")))
}

fn named<T: Copy>(
    array: &'static str,
    index: usize,
    found: &str,
    table: &[(&str, T)],
) -> Result<T, TraceFileError> {
    match table.iter().find(|(name, _)| *name == found) {
        Some((_, value)) => Ok(*value),
        None => {
            let names: Vec<&str> = table.iter().map(|t| t.0).collect();
            Err(value(array, index, quoted(found), &names.join(", ")))
        }
    }
}

fn quoted(text: &str) -> String {
    format!("`{}`", text.chars().take(40).collect::<String>())
}
