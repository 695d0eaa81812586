//! Reading: names to indices, degrees to radians, and the place of every fault.

use std::collections::{BTreeMap, HashSet};
use std::path::Path;
use std::sync::Arc;

use bodies::Character;
use motion::{Joint, Limb, Site, Skeleton, Transform, Vec3, names};
use retarget::{ContactPoint, Follow, Sway};

use super::schema::{CharacterRon, FollowRon, V3};
use crate::angle::{Angle, quat_from_deg};
use crate::error::{SceneError, Source};

/// More links than any character has; a longer list is a mistake and would only cost time.
const MOST_LINKS: usize = 2000;

/// Reads a character.
///
/// # Errors
/// Anything wrong with the file, at its place.
pub fn read(path: &Path) -> Result<Character, SceneError> {
    parse(&Source::read(path)?)
}

/// Reads a character with what its file says beyond the body.
///
/// # Errors
/// As [`read`].
pub fn read_file(path: &Path) -> Result<CharacterFile, SceneError> {
    parse_file(&Source::read(path)?)
}

/// Builds a character from a source.
///
/// # Errors
/// As [`read`].
pub fn parse(source: &Source) -> Result<Character, SceneError> {
    Ok(parse_file(source)?.character)
}

/// Builds a character from a source, with what its file says beyond the body.
///
/// # Errors
/// As [`read`].
pub fn parse_file(source: &Source) -> Result<CharacterFile, SceneError> {
    Reader { source, ron: source.parse()? }.file()
}

/// A character, how it is painted, and what it has of a human.
#[derive(Clone, Debug, PartialEq)]
pub struct CharacterFile {
    /// The body.
    pub character: Character,
    /// Red, green and blue of each link; `None` is left to the figures.
    pub colors: Vec<Option<[u8; 3]>>,
    /// The contact points whose counterparts on a human the file names.
    pub follows: Vec<ContactPoint>,
    /// Parts that can follow by dynamics.
    pub sways: Vec<Sway>,
}

pub(super) fn vec3(v: V3) -> Vec3 {
    Vec3::new(v.0, v.1, v.2)
}

/// A character file being read.
pub(super) struct Reader<'a> {
    pub(super) source: &'a Source,
    pub(super) ron: CharacterRon,
}

impl Reader<'_> {
    /// Refuses names that some file we write could not hold.
    fn names(&self) -> Result<(), SceneError> {
        let ron = &self.ron;
        let links = ron.links.iter().enumerate().map(|(i, l)| (format!("links[{i}].name"), &l.name));
        let sites = ron.sites.iter().enumerate().map(|(i, s)| (format!("sites[{i}].name"), &s.name));
        let limbs = ron.limbs.iter().enumerate().map(|(i, l)| (format!("limbs[{i}].name"), &l.name));
        let parts = ron.parts.keys().map(|part| (format!("parts{{\"{part}\"}}"), part));
        let mut all = std::iter::once(("name".to_owned(), &ron.name))
            .chain(links)
            .chain(sites)
            .chain(limbs)
            .chain(parts);
        all.try_for_each(|(at, name)| names::check(name).map_err(|e| self.source.error(&at, e)))
    }

    fn file(&self) -> Result<CharacterFile, SceneError> {
        self.names()?;
        let character = self.character()?;
        let skeleton = &character.skeleton;
        let mut colors = vec![None; skeleton.links().len()];
        for (i, link) in self.ron.links.iter().enumerate() {
            let color = link.color.as_deref().map(|c| self.color(i, c)).transpose()?;
            if let Some(at) = skeleton.link(&link.name) {
                colors[at] = color;
            }
        }
        let mut follows = Vec::new();
        for (name, follow) in &self.ron.follows {
            let at = format!("follows{{\"{name}\"}}");
            let known = || character.contacts.iter().map(|&c| skeleton.sites()[c].name.as_str());
            let Some(contact) = known().position(|n| n == name) else {
                return Err(self.source.unknown(&at, "contact point", name, " in follows", known()));
            };
            let (human, follow) = match follow {
                FollowRon::Any(human) => (human.clone(), Follow::Any),
                FollowRon::All(human) => (human.clone(), Follow::All),
            };
            if human.is_empty() {
                let e = format!("`{name}` follows no human contact point; it needs at least one");
                return Err(self.source.error(&at, e));
            }
            follows.push(ContactPoint { site: character.contacts[contact], human, follow });
        }
        let mut sways = Vec::new();
        for (part, sway) in &self.ron.sways {
            let at = format!("sways{{\"{part}\"}}");
            let Some(links) = skeleton.parts().get(part) else {
                let known = skeleton.parts().keys().map(String::as_str);
                return Err(self.source.unknown(&at, "part", part, " in sways", known));
            };
            for (name, value) in [("frequency_hz", sway.frequency_hz), ("damping_ratio", sway.damping_ratio)]
            {
                if !(value > 0.0 && value.is_finite()) {
                    let e = format!("{name} of `{part}` is {value}; allowed: positive numbers");
                    return Err(self.source.error(&format!("{at}.{name}"), e));
                }
            }
            let carries =
                |c: &&usize| skeleton.ancestors(skeleton.sites()[**c].link).any(|l| links.contains(&l));
            if let Some(&contact) = character.contacts.iter().find(carries) {
                let site = &skeleton.sites()[contact].name;
                let e = format!("`{part}` carries the contact point `{site}`; what stands cannot sway");
                return Err(self.source.error(&at, e));
            }
            sways.push(Sway {
                links: links.clone(),
                frequency_hz: sway.frequency_hz,
                damping_ratio: sway.damping_ratio,
            });
        }
        Ok(CharacterFile { character, colors, follows, sways })
    }

    /// `#rrggbb`.
    fn color(&self, link: usize, text: &str) -> Result<[u8; 3], SceneError> {
        let digits =
            text.strip_prefix('#').filter(|d| d.len() == 6 && d.bytes().all(|b| b.is_ascii_hexdigit()));
        let number = digits.and_then(|d| u32::from_str_radix(d, 16).ok());
        number.map(|n| [16, 8, 0].map(|shift| (n >> shift) as u8)).ok_or_else(|| {
            let e = format!("the colour \"{text}\" is not of the form \"#rrggbb\", such as \"#e8b04a\"");
            self.source.error(&format!("links[{link}].color"), e)
        })
    }

    fn character(&self) -> Result<Character, SceneError> {
        let s = self.source;
        let order = self.order()?;
        let index = |name: &str| order.iter().position(|&i| self.ron.links[i].name == name);
        let find = |at: String, name: &str, within: String| {
            let names = self.ron.links.iter().map(|l| l.name.as_str());
            index(name).ok_or_else(|| s.unknown(&at, "link", name, &within, names))
        };
        let mut links = Vec::new();
        let mut bodies = Vec::new();
        let mut classes = Vec::new();
        for &i in &order {
            let parent = self.ron.links[i].parent.as_deref().and_then(index);
            links.push(self.link(i, parent)?);
            bodies.push(self.body(i)?);
            classes.push(self.ron.links[i].class.0);
        }
        let mut sites = Vec::new();
        for (i, site) in self.ron.sites.iter().enumerate() {
            let link = find(format!("sites[{i}].link"), &site.link, format!(" in Site \"{}\"", site.name))?;
            if self.ron.sites[..i].iter().any(|o| o.name == site.name) {
                let at = format!("sites[{i}].name");
                return Err(
                    s.error(&at, format!("two sites are called `{}`; names must be unique", site.name))
                );
            }
            sites.push(Site {
                name: site.name.clone(),
                link,
                at: self.finite(&format!("sites[{i}].at_m"), site.at_m)?,
            });
        }
        let mut contacts = Vec::new();
        for (i, name) in self.ron.contacts.iter().enumerate() {
            let names = sites.iter().map(|x| x.name.as_str());
            let at = sites.iter().position(|x| x.name == *name);
            contacts.push(
                at.ok_or_else(|| s.unknown(&format!("contacts[{i}]"), "site", name, " in contacts", names))?,
            );
        }
        let mut limbs = Vec::new();
        for (i, l) in self.ron.limbs.iter().enumerate() {
            let link = |what: &str, name: &str| {
                find(format!("limbs[{i}].{what}"), name, format!(" in Limb \"{}\"", l.name))
            };
            limbs.push(Limb {
                name: l.name.clone(),
                kind: l.kind.0,
                upper: link("upper", &l.upper)?,
                lower: link("lower", &l.lower)?,
                end: link("end", &l.end)?,
            });
        }
        let mut parts = BTreeMap::new();
        for (part, names) in &self.ron.parts {
            let mut members = Vec::new();
            for (k, name) in names.iter().enumerate() {
                members.push(find(
                    format!("parts{{\"{part}\"}}[{k}]"),
                    name,
                    format!(" in part \"{part}\""),
                )?);
            }
            members.sort_unstable();
            parts.insert(part.clone(), members);
        }
        let whole = |e: &dyn std::error::Error| s.error("links", e.to_string());
        let skeleton = Skeleton::new(links)
            .and_then(|x| x.with_sites(sites))
            .and_then(|x| x.with_limbs(limbs))
            .and_then(|x| x.with_parts(parts))
            .map_err(|e| whole(&e))?;
        let rest = self.rest(&skeleton)?;
        let root = &skeleton.links()[0];
        if root.joint == Joint::Free && root.parent_from_zero != Transform::identity() {
            let e = format!(
                "`{}` is a free root: its zero frame is the world's, without offset or rotation",
                root.name
            );
            let help = "place it with root_m and joints_deg in `rest`";
            return Err(s.error(&format!("links[{}]", order[0]), e).with_help(help));
        }
        Character {
            name: self.ron.name.clone(),
            skeleton: Arc::new(skeleton),
            bodies,
            classes,
            contacts,
            rest,
        }
        .check()
        .map_err(|e| self.place(&e))
    }

    /// Indices of the written links, parents first; otherwise in the order written.
    fn order(&self) -> Result<Vec<usize>, SceneError> {
        let (s, links) = (self.source, &self.ron.links);
        if links.is_empty() {
            return Err(s.error("links", "a character needs at least one link"));
        }
        if links.len() > MOST_LINKS {
            let e = format!("{} links; a character has at most {MOST_LINKS}", links.len());
            return Err(s.error("links", e));
        }
        let mut roots = Vec::new();
        for (i, link) in links.iter().enumerate() {
            if let Some(first) = links[..i].iter().position(|l| l.name == link.name) {
                let e = format!("two links are called `{}`; names must be unique", link.name);
                let (line, _) = s.error(&format!("links[{first}].name"), "").place.unwrap_or_default();
                return Err(s
                    .error(&format!("links[{i}].name"), e)
                    .with_help(format!("the first is on line {line}")));
            }
            match &link.parent {
                None => roots.push(i),
                Some(p) if !links.iter().any(|l| l.name == *p) => {
                    let names = links.iter().map(|l| l.name.as_str()).filter(|n| *n != link.name);
                    let within = format!(" in Link \"{}\"", link.name);
                    return Err(s.unknown(&format!("links[{i}].parent"), "parent", p, &within, names));
                }
                Some(_) => {}
            }
        }
        if let [first, second, ..] = roots[..] {
            let e = format!(
                "`{}` has no parent, but `{}` is the root already; only one link may be without a parent",
                links[second].name, links[first].name
            );
            return Err(s.error(&format!("links[{second}]"), e));
        }
        let (mut order, mut done) = (Vec::new(), HashSet::new());
        while order.len() < links.len() {
            let ready = |i: &usize| {
                !done.contains(&links[*i].name) && links[*i].parent.as_ref().is_none_or(|p| done.contains(p))
            };
            match (0..links.len()).find(ready) {
                Some(i) => {
                    done.insert(links[i].name.clone());
                    order.push(i);
                }
                None => return Err(self.cycle(&done)),
            }
        }
        Ok(order)
    }

    /// Names a cycle among the links that could not be placed.
    fn cycle(&self, done: &HashSet<String>) -> SceneError {
        let links = &self.ron.links;
        let parent = |i: usize| {
            links[i].parent.as_ref().and_then(|p| links.iter().position(|l| l.name == *p)).unwrap_or(i)
        };
        let mut i = links.iter().position(|l| !done.contains(&l.name)).unwrap_or(0);
        for _ in 0..links.len() {
            i = parent(i); // after as many steps as there are links, `i` lies on the cycle
        }
        let (start, mut names) = (i, vec![format!("`{}`", links[i].name)]);
        loop {
            i = parent(i);
            names.push(format!("`{}`", links[i].name));
            if i == start {
                break;
            }
        }
        let e =
            format!("the parents form a circle: {}; one link must be without a parent", names.join(" → "));
        self.source.error(&format!("links[{start}].parent"), e)
    }

    pub(super) fn finite(&self, at: &str, v: V3) -> Result<Vec3, SceneError> {
        let v = vec3(v);
        match v.iter().position(|x| !x.is_finite()) {
            Some(k) => {
                Err(self.source.error(&format!("{at}[{k}]"), format!("{} is not a finite number", v[k])))
            }
            None => Ok(v),
        }
    }

    fn rest(&self, skeleton: &Skeleton) -> Result<Vec<f64>, SceneError> {
        let s = self.source;
        let mut q = skeleton.zero_pose();
        if skeleton.links()[0].joint == Joint::Free {
            skeleton.set_position(&mut q, 0, &self.finite("rest.root_m", self.ron.rest.root_m)?);
        }
        for (name, angle) in &self.ron.rest.joints_deg {
            let at = format!("rest.joints_deg{{\"{name}\"}}");
            let names = skeleton.links().iter().map(|l| l.name.as_str());
            let i = skeleton.link(name).ok_or_else(|| s.unknown(&at, "joint", name, " in rest", names))?;
            let numbers: &[f64] = match angle {
                Angle::One(x) => &[*x],
                Angle::Ball(xyz) => xyz,
            };
            if !numbers.iter().all(|x| x.is_finite()) {
                return Err(s.error(&at, format!("the rest value of `{name}` is not finite")));
            }
            match (angle, skeleton.links()[i].joint) {
                (Angle::One(x), Joint::Revolute(_)) => q[skeleton.q_at(i)] = x.to_radians(),
                (Angle::One(x), Joint::Prismatic(_)) => q[skeleton.q_at(i)] = *x,
                (Angle::Ball(xyz), Joint::Free | Joint::Spherical) => {
                    skeleton.set_rotation(&mut q, i, &quat_from_deg(*xyz));
                }
                (_, joint) => {
                    let wants = match joint {
                        Joint::Revolute(_) => "one angle in degrees",
                        Joint::Prismatic(_) => "one distance in metres",
                        Joint::Free | Joint::Spherical => "(x, y, z) in degrees",
                        Joint::Fixed => "nothing: it is welded",
                    };
                    return Err(s.error(
                        &at,
                        format!("the rest value of `{name}` does not fit its joint, which takes {wants}"),
                    ));
                }
            }
        }
        Ok(q)
    }

    /// Finds the place of a fault of the finished character.
    fn place(&self, e: &bodies::CharacterError) -> SceneError {
        use bodies::CharacterError as E;
        let (link, field) = match e {
            E::Mass { link, .. } => (link.as_str(), "mass_kg"),
            E::Inertia { link, .. } => (link.as_str(), "inertia_kg_m2"),
            _ => ("", ""),
        };
        let i = self.ron.links.iter().position(|l| l.name == link);
        let at = i.map_or("links".to_string(), |i| format!("links[{i}].{field}"));
        self.source.error(&at, e.to_string())
    }
}
