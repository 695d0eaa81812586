//! Contact phases: found on the human, carried over to the character, or given by hand.
//!
//! A human point is in contact while it is low and slow: it touches below both thresholds, and leaves above
//! [`LEAVE`] times either. Heights are above the point's own floor, speeds by central differences of positions; both
//! thresholds are those of a figure of standard size and scale with the performer's legs. Gaps and phases
//! shorter than [`ContactOptions::shortest_s`] are closed and dropped, in this order.
//!
//! *Own floor.* Soles of a captured skeleton are guessed from its bones, and none of its points need reach the ground: of
//! eight points of one walk the lowest slow heights were 6 to 58 mm. The floor of a point is the lower
//! [`REACHED`] quantile of its heights while it is slow, where that is below [`HIGHEST_FLOOR_M`]; else it is the ground,
//! which the point does not touch.
//!
//! A character's point
//! takes the phases of its counterparts, any or all of them, and the same again; of those the character could only
//! keep by flipping a foot, the short ones are dropped ([`without_flipped_feet`]).

use motion::names::hint;
use motion::{Clip, Vec3};

use super::places::{point_paths, site_paths};
use crate::options::ContactOptions;
use crate::phase::{Path, Phase, PhaseFrames};
use crate::{ContactPoint, Follow, Performer, Puppet, RetargetError};

/// A phase no longer than this is dropped where its link is too steep for it, s.
const SHORT_S: f64 = 0.3;
/// Sine of the angle between a link's resting points from which on it is too steep.
const STEEP: f64 = 0.25;

/// A contact ends above this multiple of the thresholds that began it.
pub const LEAVE: f64 = 1.3;

/// Share of a point's slow heights below its own floor.
pub const REACHED: f64 = 0.1;
/// Own floors are no higher than this above the ground, m, for a performer of standard size.
pub const HIGHEST_FLOOR_M: f64 = 0.06;

/// Paths of the performer's contact points; `human` on ground at height 0.
fn human_paths(performer: &Performer, human: &Clip) -> Vec<Path> {
    site_paths(&performer.character, &performer.character.contacts, human)
}

/// Own floor of each of the performer's contact points, m; `human` on ground at height 0. See the module header.
pub fn own_floors(performer: &Performer, human: &Clip, options: &ContactOptions) -> Vec<f64> {
    let of_path = |p: &Path| own_floor(p, &speeds(p, human.rate_hz), performer, options);
    human_paths(performer, human).iter().map(of_path).collect()
}

/// Contact of each of the performer's contact points in every frame; `human` on ground at height 0.
pub fn human_contacts(performer: &Performer, human: &Clip, options: &ContactOptions) -> Vec<Vec<bool>> {
    let size = performer.features.unit_m;
    let (height, speed) = (options.height_m * size, options.speed_m_s * size);
    let shortest = (options.shortest_s * human.rate_hz).round() as usize;
    let of_path = |p: &Path| {
        let speeds = speeds(p, human.rate_hz);
        let floor = own_floor(p, &speeds, performer, options);
        let mut down = false;
        let touches = |(p, v): (&Vec3, &f64)| {
            let times = if down { LEAVE } else { 1.0 };
            down = p.y - floor < times * height && *v < times * speed;
            down
        };
        let mut on: Vec<bool> = p.iter().zip(&speeds).map(touches).collect();
        close_gaps(&mut on, shortest);
        on
    };
    human_paths(performer, human).iter().map(of_path).collect()
}

/// Height at which a point stands, of those it has while it is slow, m; see the module header.
fn own_floor(path: &Path, speeds: &[f64], performer: &Performer, options: &ContactOptions) -> f64 {
    let size = performer.features.unit_m;
    let slow = path.iter().zip(speeds).filter(|(_, v)| **v < options.speed_m_s * size);
    let mut heights: Vec<f64> = slow.map(|(p, _)| p.y).collect();
    heights.sort_by(f64::total_cmp);
    let at = heights.get((heights.len() as f64 * REACHED) as usize);
    at.copied().filter(|y| (0.0..HIGHEST_FLOOR_M * size).contains(y)).unwrap_or(0.0)
}

/// Speeds of a sampled path, m/s.
fn speeds(p: &[Vec3], rate_hz: f64) -> Vec<f64> {
    let at = |i: usize| {
        let (a, b) = (i.saturating_sub(1), (i + 1).min(p.len() - 1));
        if a == b { 0.0 } else { (p[b] - p[a]).norm() * rate_hz / (b - a) as f64 }
    };
    (0..p.len()).map(at).collect()
}

/// Closes short gaps between phases, then drops short phases; at the ends of the clip both may be short.
fn close_gaps(on: &mut [bool], shortest: usize) {
    for value in [false, true] {
        let mut i = 0;
        while i < on.len() {
            let run = on[i..].iter().take_while(|&&x| x == on[i]).count();
            let inside = i > 0 && i + run < on.len();
            let of_value = on[i] == value;
            if of_value && run < shortest && (inside || value) {
                on[i..i + run].fill(!value);
            }
            i += run;
        }
    }
}

/// Performer's contacts that a counterpart names: the site itself, or all whose name it begins, up to an
/// underscore, or all of a limb.
fn counterparts(performer: &Performer, name: &str) -> Vec<usize> {
    let c = &performer.character;
    let site = |i: usize| c.skeleton.sites()[c.contacts[i]].name.as_str();
    let matches = |s: &str| s == name || s.strip_prefix(name).is_some_and(|rest| rest.starts_with('_'));
    let named: Vec<usize> = (0..c.contacts.len()).filter(|&i| matches(site(i))).collect();
    let Some(limb) = c.skeleton.limbs().iter().find(|l| l.name == name).filter(|_| named.is_empty()) else {
        return named;
    };
    let link = |i: usize| c.skeleton.sites()[c.contacts[i]].link;
    (0..c.contacts.len()).filter(|&i| c.skeleton.ancestors(link(i)).any(|l| l == limb.upper)).collect()
}

/// For each counterpart of a contact point, the performer's contacts it stands for.
///
/// # Errors
/// A counterpart that the performer does not have.
pub fn groups(
    performer: &Performer,
    puppet: &Puppet,
    point: &ContactPoint,
) -> Result<Vec<Vec<usize>>, RetargetError> {
    let find = |human: &String| {
        let found = counterparts(performer, human);
        if !found.is_empty() {
            return Ok(found);
        }
        let c = &performer.character;
        let known = c.contacts.iter().map(|&s| c.skeleton.sites()[s].name.as_str());
        let known = known.chain(c.skeleton.limbs().iter().map(|l| l.name.as_str()));
        let site = puppet.character.skeleton.sites()[point.site].name.clone();
        Err(RetargetError::Counterpart { site, hint: hint(human, known), human: human.clone() })
    };
    point.human.iter().map(find).collect()
}

/// Whether a point whose counterparts are these is in contact, when the human ones are as `down` says.
///
/// A name that stands for several sites is in contact when any of them is.
pub fn in_contact(follow: Follow, groups: &[Vec<usize>], down: impl Fn(usize) -> bool) -> bool {
    let touches = |group: &Vec<usize>| group.iter().any(|&c| down(c));
    match follow {
        Follow::Any => groups.iter().any(touches),
        Follow::All => groups.iter().all(touches),
    }
}

/// The character's phases, from the human's contacts.
///
/// # Errors
/// A counterpart that the performer does not have.
pub fn find(
    performer: &Performer,
    human: &Clip,
    puppet: &Puppet,
    options: &ContactOptions,
) -> Result<Vec<Phase>, RetargetError> {
    if let Some(given) = &options.phases {
        return Ok(given.clone());
    }
    let contacts = human_contacts(performer, human, options);
    let shortest = (options.shortest_s * human.rate_hz).round() as usize;
    let mut out = vec![Vec::new(); puppet.contacts.len()];
    for (spans, point) in out.iter_mut().zip(&puppet.contacts) {
        let groups = groups(performer, puppet, point)?;
        let mut on: Vec<bool> =
            (0..human.frames()).map(|i| in_contact(point.follow, &groups, |c| contacts[c][i])).collect();
        close_gaps(&mut on, shortest);
        let mut i = 0;
        while i < on.len() {
            let run = on[i..].iter().take_while(|&&x| x == on[i]).count();
            if on[i] {
                spans.push(PhaseFrames { first: i, last: i + run - 1 });
            }
            i += run;
        }
    }
    Ok(phases_of_frames(puppet, &out, human.rate_hz))
}

/// Drops short phases that would flip a foot: of a heel that touches for a tenth of a second where the character's foot points
/// down (the lower point of the link is the one to land), or that has let go again before the toes touch.
///
/// * `clip`: the character's, in the world
///
/// # Errors
/// As [`frames_of_phases`].
pub fn without_flipped_feet(
    puppet: &Puppet,
    clip: &Clip,
    found: &[Phase],
) -> Result<Vec<Phase>, RetargetError> {
    let spans = frames_of_phases(puppet, found, clip)?;
    let paths = point_paths(puppet, clip);
    let sites = puppet.character.skeleton.sites();
    let site = |c: usize| &sites[puppet.contacts[c].site];
    let mean = |c: usize, s: &PhaseFrames| {
        paths[c][s.first..=s.last].iter().map(|p| p.y).sum::<f64>() / (s.last - s.first + 1) as f64
    };
    let tilted = |c: usize, s: &PhaseFrames| {
        let beside = |o: &usize| *o != c && site(*o).link == site(c).link && !spans[*o].is_empty();
        let others: Vec<usize> = (0..paths.len()).filter(beside).collect();
        let slope = |o: &usize| (mean(c, s) - mean(*o, s)) / (site(c).at - site(*o).at).norm().max(1e-6);
        let overlaps = |o: &usize| spans[*o].iter().any(|t| t.first <= s.last && s.first <= t.last);
        let alone = !others.is_empty() && !others.iter().any(overlaps);
        (s.last - s.first) as f64 <= SHORT_S * clip.rate_hz
            && (alone || others.iter().map(slope).any(|x| x > STEEP))
    };
    let kept =
        |(c, spans): (usize, &Vec<PhaseFrames>)| spans.iter().filter(|s| !tilted(c, s)).copied().collect();
    let kept: Vec<Vec<PhaseFrames>> = spans.iter().enumerate().map(kept).collect();
    Ok(phases_of_frames(puppet, &kept, clip.rate_hz))
}

/// Frames of a clip, per contact point of the puppet, as phases.
pub fn phases_of_frames(puppet: &Puppet, spans: &[Vec<PhaseFrames>], rate_hz: f64) -> Vec<Phase> {
    let sites = puppet.character.skeleton.sites();
    let at = |frame: usize| frame as f64 / rate_hz;
    let of_point = |(spans, c): (&Vec<PhaseFrames>, &ContactPoint)| -> Vec<Phase> {
        let phase = |s: &PhaseFrames| Phase {
            point: sites[c.site].name.clone(),
            from_s: at(s.first),
            to_s: at(s.last),
        };
        spans.iter().map(phase).collect()
    };
    spans.iter().zip(&puppet.contacts).flat_map(of_point).collect()
}

/// Phases as frames of a clip, per contact point of the puppet, in order.
///
/// # Errors
/// As [`super::adjust`].
pub fn frames_of_phases(
    puppet: &Puppet,
    phases: &[Phase],
    clip: &Clip,
) -> Result<Vec<Vec<PhaseFrames>>, RetargetError> {
    let sites = puppet.character.skeleton.sites();
    let names: Vec<&str> = puppet.contacts.iter().map(|c| sites[c.site].name.as_str()).collect();
    let mut out = vec![Vec::new(); names.len()];
    for p in phases {
        let fault = |reason: &'static str| RetargetError::Phase {
            point: p.point.clone(),
            from_s: p.from_s,
            to_s: p.to_s,
            reason,
        };
        let Some(point) = names.iter().position(|n| *n == p.point) else {
            return Err(fault("the character has no contact point of this name"));
        };
        if !p.from_s.is_finite() || !p.to_s.is_finite() || p.from_s > p.to_s {
            return Err(fault("it ends before it begins"));
        }
        // half a frame of grace: written times are rounded
        if p.from_s < -0.5 / clip.rate_hz || p.to_s > clip.duration_s() + 0.5 / clip.rate_hz {
            return Err(fault("it lies outside the clip"));
        }
        let frame = |t: f64| ((t * clip.rate_hz).round().max(0.0) as usize).min(clip.frames() - 1);
        out[point].push(PhaseFrames { first: frame(p.from_s), last: frame(p.to_s) });
    }
    for (point, spans) in out.iter_mut().enumerate() {
        spans.sort_by_key(|s| s.first);
        if let Some(w) = spans.windows(2).find(|w| w[1].first <= w[0].last) {
            let at = |frame: usize| frame as f64 / clip.rate_hz;
            return Err(RetargetError::Phase {
                point: names[point].into(),
                from_s: at(w[1].first),
                to_s: at(w[1].last),
                reason: "it overlaps the one before",
            });
        }
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::close_gaps;

    #[test]
    fn short_gaps_close_and_short_phases_go() {
        let read = |s: &str| -> Vec<bool> { s.chars().map(|c| c == '#').collect() };
        for (given, want) in [
            ("..####.####..", "..#########.."),
            ("..#....####..", ".......####.."),
            (".####", ".####"),
            ("#....####", ".....####"),
            ("####.", "####."),
        ] {
            let mut on = read(given);
            close_gaps(&mut on, 3);
            assert_eq!(on, read(want), "{given}");
        }
    }
}
