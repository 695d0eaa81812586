//! The numbers of an analysis, as its `report.json` gives them.
//!
//! In: an [`AnalysisInput`] and its [`Analysis`]. Out: an [`AnalysisReport`] that serialises to JSON. Every unit is
//! in its field's name. The schema is documented in `docs/ANALYSIS.md`: fields are only ever added.

use std::collections::BTreeMap;

use dynamics::Analysis;
use dynamics::analysis::{Grade, Violations};
use motion::metrics;
use motion::skeleton::vec_at;
use motion::{Joint, Vec3};
use serde::Serialize;

use crate::analysis::{AnalysisInput, AnalysisSource};
use crate::results::feet::FeetReport;
use crate::results::subject_report::{CharacterReport, ClipReport};

/// All numbers of an analysis.
#[derive(Clone, Debug, Serialize)]
pub struct AnalysisReport {
    /// Name of the motion.
    pub name: String,
    /// `clip`, `scene` or `trace`.
    pub source: &'static str,
    /// Frames.
    pub frames: usize,
    /// Frames per second.
    pub rate_hz: f64,
    /// Time of the last frame, s.
    pub duration_s: f64,
    /// How the clip was read; absent for others.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clip: Option<ClipReport>,
    /// The body.
    pub character: CharacterReport,
    /// `good`, `acceptable` or `poor`: the worse of the residual's grades.
    pub plausible: String,
    /// What was smoothed away.
    pub smoothing: SmoothingReport,
    /// What is left out at the ends.
    pub ends: EndsReport,
    /// What neither joints nor ground explain.
    pub residual: ResidualReport,
    /// What the motion needs from outside.
    pub required: RequiredReport,
    /// The ground.
    pub ground: GroundReport,
    /// Frames whose required force leaves the friction cone.
    pub friction: FrictionReport,
    /// Frames whose required centre of pressure leaves the support.
    pub support: SupportReport,
    /// Frames without contact.
    pub flight: FlightReport,
    /// Every joint, hardest worked first.
    pub joints: Vec<JointLoadReport>,
    /// RMS jerk of the links' origins, m/s³, after smoothing.
    pub jerk_rms_m_s3: f64,
    /// That over the same before smoothing.
    pub jerk_ratio: Option<f64>,
    /// Files written, by what they hold; paths relative to the report.
    pub files: BTreeMap<String, String>,
}

/// What the smoother did.
#[derive(Clone, Debug, Serialize)]
pub struct SmoothingReport {
    /// Whether anything was smoothed.
    pub smoothed: bool,
    /// Frequency at which half of the amplitude passes, Hz; null where nothing was smoothed.
    pub cutoff_hz: Option<f64>,
    /// RMS angle by which joints were moved, degrees.
    pub joint_rms_deg: f64,
    /// RMS distance by which links were moved, mm.
    pub position_rms_mm: f64,
    /// Standard deviation of the hinge or ball torque that noise alone makes, N·m: median joint.
    pub torque_noise_nm_median: f64,
    /// The same of the noisiest joint, N·m.
    pub torque_noise_nm_max: f64,
    /// The noisiest joint.
    pub torque_noise_joint: String,
    /// Standard deviation of each axis of the required force, N.
    pub force_noise_n: f64,
    /// Standard deviation of the required moment about the root's origin, noisiest axis, N·m.
    pub moment_noise_nm: f64,
}

/// The ends of a smoothed clip, which are left out of peaks, grades and violations.
#[derive(Clone, Debug, Serialize)]
pub struct EndsReport {
    /// Time left out at each end, s; 0 where nothing was smoothed or the clip is too short.
    pub left_out_s: f64,
    /// Whether the clip is too short for a grade to mean anything.
    pub too_short: bool,
    /// RMS error of the required force in the first and last frame, N; null where it cannot be measured.
    pub first_frame_error_n: Option<f64>,
    /// The same where grading begins, N.
    pub inside_error_n: Option<f64>,
}

/// The residual.
#[derive(Clone, Debug, Serialize)]
pub struct ResidualReport {
    /// Worst of the four grades.
    pub grade: String,
    /// Grade of the peak force.
    pub force_grade: String,
    /// Grade of the peak moment.
    pub moment_grade: String,
    /// Largest force, N.
    pub force_peak_n: f64,
    /// When, s.
    pub force_peak_at_s: f64,
    /// RMS force, N.
    pub force_rms_n: f64,
    /// Largest force over body weight, %.
    pub force_peak_percent_bw: Option<f64>,
    /// RMS force over body weight, %.
    pub force_rms_percent_bw: Option<f64>,
    /// Largest moment about the root's origin, N·m.
    pub moment_peak_nm: f64,
    /// When, s.
    pub moment_peak_at_s: f64,
    /// RMS moment, N·m.
    pub moment_rms_nm: f64,
}

/// The force from outside that the motion needs.
#[derive(Clone, Debug, Serialize)]
pub struct RequiredReport {
    /// Mean vertical force, N.
    pub vertical_mean_n: f64,
    /// Largest vertical force, N.
    pub vertical_peak_n: f64,
    /// When, s.
    pub vertical_peak_at_s: f64,
    /// Mean vertical force over body weight, %.
    pub vertical_mean_percent_bw: Option<f64>,
    /// Largest vertical force over body weight, %.
    pub vertical_peak_percent_bw: Option<f64>,
    /// Least vertical force over body weight, %: negative where the ground would have to pull.
    pub vertical_least_percent_bw: Option<f64>,
    /// Largest horizontal force over body weight, %.
    pub horizontal_peak_percent_bw: Option<f64>,
}

/// The ground and the feet on it.
#[derive(Clone, Debug, Serialize)]
pub struct GroundReport {
    /// Height, m; null without ground.
    pub height_m: Option<f64>,
    /// Foot numbers; null without ground or contact points.
    pub feet: Option<FeetReport>,
}

/// A run of frames.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FrameSpan {
    /// First frame.
    pub from_frame: usize,
    /// Last frame.
    pub to_frame: usize,
    /// Time of the first frame, s.
    pub from_s: f64,
    /// Time of the last frame, s.
    pub to_s: f64,
}

/// Friction.
#[derive(Clone, Debug, Serialize)]
pub struct FrictionReport {
    /// Coefficient.
    pub coefficient: f64,
    /// Frames in violation.
    pub frames: usize,
    /// Share of all frames, 0 to 1.
    pub share: f64,
    /// Largest ratio of the horizontal force to what friction can hold; null where the ground would have
    /// to pull.
    pub worst: Option<f64>,
    /// When, s; null without violations.
    pub worst_at_s: Option<f64>,
    /// Where.
    pub spans: Vec<FrameSpan>,
}

/// Support.
#[derive(Clone, Debug, Serialize)]
pub struct SupportReport {
    /// Frames in violation.
    pub frames: usize,
    /// Share of all frames, 0 to 1.
    pub share: f64,
    /// Largest distance outside, mm.
    pub worst_mm: f64,
    /// When, s; null without violations.
    pub worst_at_s: Option<f64>,
    /// Where.
    pub spans: Vec<FrameSpan>,
}

/// Flight.
#[derive(Clone, Debug, Serialize)]
pub struct FlightReport {
    /// Frames without contact.
    pub frames: usize,
    /// Share of all frames, 0 to 1.
    pub share: f64,
    /// RMS of the force that would have to hold the body up in the air, over body weight, %; null without
    /// flight.
    pub held_up_percent_bw: Option<f64>,
    /// Where.
    pub spans: Vec<FrameSpan>,
}

/// The load of one joint.
#[derive(Clone, Debug, Serialize)]
pub struct JointLoadReport {
    /// Its link.
    pub joint: String,
    /// `torque` (N·m) or `force` (N, of slides).
    pub kind: &'static str,
    /// Largest, N·m; of a ball the length of the vector.
    pub peak_nm: f64,
    /// When, s.
    pub peak_at_s: f64,
    /// Largest over the body's mass, N·m/kg.
    pub peak_nm_kg: f64,
    /// RMS, N·m.
    pub rms_nm: f64,
    /// Standard deviation of what is noise only, N·m.
    pub noise_nm: f64,
}

impl AnalysisReport {
    /// The numbers of an analysis; no files yet.
    pub fn new(input: &AnalysisInput, a: &Analysis) -> Self {
        let c = &input.character;
        let at = |frame: usize| frame as f64 / a.rate_hz();
        let share = |n: usize| n as f64 / a.frames().max(1) as f64;
        let percent = |f: f64| Some(100.0 * f / a.weight()).filter(|p| p.is_finite());
        let r = &a.graded;
        let worst = |v: &Violations| (!v.frames.is_empty()).then(|| at(v.worst_frame));
        let (before, after) = (metrics::jerk_rms(&input.given), metrics::jerk_rms(&a.clip));
        Self {
            name: input.name.clone(),
            source: input.source.name(),
            frames: a.frames(),
            rate_hz: a.rate_hz(),
            duration_s: a.clip.duration_s(),
            clip: match &input.source {
                AnalysisSource::Clip(source) => ClipReport::new(source),
                _ => None,
            },
            character: CharacterReport {
                name: c.name.clone(),
                links: c.skeleton.links().len(),
                dof: c.skeleton.nv(),
                mass_kg: c.mass(),
            },
            plausible: r.grade().to_string(),
            smoothing: smoothing(input, a),
            ends: EndsReport {
                left_out_s: a.ends.graded.start as f64 / a.rate_hz(),
                too_short: a.ends.too_short,
                first_frame_error_n: a.ends.first_n,
                inside_error_n: a.ends.inside_n,
            },
            residual: ResidualReport {
                grade: r.grade().to_string(),
                force_grade: r.force_grade().to_string(),
                moment_grade: r.moment_grade().to_string(),
                force_peak_n: r.force_peak,
                force_peak_at_s: at(r.force_frame),
                force_rms_n: r.force_rms,
                force_peak_percent_bw: percent(r.force_peak),
                force_rms_percent_bw: percent(r.force_rms),
                moment_peak_nm: r.moment_peak,
                moment_peak_at_s: at(r.moment_frame),
                moment_rms_nm: r.moment_rms,
            },
            required: required(a, &percent),
            ground: ground(input, a),
            friction: FrictionReport {
                coefficient: a.friction,
                frames: a.friction_violations.frames.len(),
                share: share(a.friction_violations.frames.len()),
                worst: Some(a.friction_violations.worst).filter(|w| w.is_finite()),
                worst_at_s: worst(&a.friction_violations),
                spans: spans(&a.friction_violations.frames, a.rate_hz()),
            },
            support: SupportReport {
                frames: a.support_violations.frames.len(),
                share: share(a.support_violations.frames.len()),
                worst_mm: 1e3 * a.support_violations.worst,
                worst_at_s: worst(&a.support_violations),
                spans: spans(&a.support_violations.frames, a.rate_hz()),
            },
            flight: flight(a, &percent),
            joints: joints(input, a),
            jerk_rms_m_s3: after,
            jerk_ratio: (before > 0.0).then(|| after / before),
            files: BTreeMap::new(),
        }
    }

    /// Text of `report.json`.
    pub fn to_json(&self) -> String {
        // numbers and strings: nothing can fail
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }

    /// In words: is this motion physically plausible, and what is not.
    pub fn verdict(&self) -> String {
        let mut faults = Vec::new();
        let residual = &self.residual;
        if residual.force_grade != "good" {
            let (peak, at) = (residual.force_peak_n, residual.force_peak_at_s);
            let noise = noise(peak, self.smoothing.force_noise_n);
            faults.push(format!("unexplained force up to {peak:.0} N at {at:.2} s{noise}"));
        }
        if residual.moment_grade != "good" {
            let (peak, at) = (residual.moment_peak_nm, residual.moment_peak_at_s);
            let noise = noise(peak, self.smoothing.moment_noise_nm);
            faults.push(format!("unexplained moment up to {peak:.0} N·m at {at:.2} s{noise}"));
        }
        if self.friction.frames > 0 {
            faults.push(format!(
                "feet would slide in {:.0} % of the frames",
                at_least_one(self.friction.share)
            ));
        }
        if self.support.frames > 0 {
            let (worst, share) = (self.support.worst_mm, at_least_one(self.support.share));
            faults.push(format!("centre of pressure up to {worst:.0} mm outside the soles in {share:.0} %"));
        }
        let verdict = match (self.is_good(), self.plausible.as_str()) {
            _ if self.ends.too_short => "TOO SHORT to say whether it is plausible",
            (true, _) => "physically plausible",
            (_, "acceptable") => "nearly plausible",
            _ => "NOT PHYSICALLY PLAUSIBLE as it is",
        };
        match faults.is_empty() {
            true => verdict.to_owned(),
            false => {
                let but = if self.is_good() { ", but " } else { ": " };
                format!("{verdict}{but}{}", faults.join("; "))
            }
        }
    }

    /// Whether the grade is good.
    pub fn is_good(&self) -> bool {
        self.plausible == Grade::Good.to_string()
    }
}

/// Says so where a peak may be noise only: within three standard deviations.
fn noise(peak: f64, deviation: f64) -> &'static str {
    if peak <= 3.0 * deviation { " (no larger than noise may be)" } else { "" }
}

/// A share as percent that does not round to nothing.
fn at_least_one(share: f64) -> f64 {
    (100.0 * share).max(1.0)
}

/// Runs of consecutive frames.
pub fn spans(frames: &[usize], rate_hz: f64) -> Vec<FrameSpan> {
    let run = |run: &[usize]| {
        let (from_frame, to_frame) = (run[0], run[run.len() - 1]);
        let at = |frame: usize| frame as f64 / rate_hz;
        FrameSpan { from_frame, to_frame, from_s: at(from_frame), to_s: at(to_frame) }
    };
    frames.chunk_by(|a, b| *b == a + 1).map(run).collect()
}

fn smoothing(input: &AnalysisInput, a: &Analysis) -> SmoothingReport {
    let cutoff_hz = Some(a.smoothing.cutoff_hz).filter(|hz| hz.is_finite());
    let mut noise: Vec<(f64, &str)> = (moving(a).into_iter())
        .map(|link| (size_of(&a.noise.tau, a, link), a.clip.skeleton.links()[link].name.as_str()))
        .collect();
    noise.sort_by(|x, y| x.0.total_cmp(&y.0));
    let largest = noise.last().copied().unwrap_or_default();
    SmoothingReport {
        smoothed: cutoff_hz.is_some(),
        cutoff_hz,
        joint_rms_deg: metrics::joint_rms_deg(&metrics::joint_errors(&input.given, &a.clip)),
        position_rms_mm: metrics::position_rms_mm(&input.given, &a.clip),
        torque_noise_nm_median: noise.get(noise.len() / 2).map_or(0.0, |n| n.0),
        torque_noise_nm_max: largest.0,
        torque_noise_joint: largest.1.to_owned(),
        force_noise_n: a.noise.force,
        moment_noise_nm: a.noise.moment.into_iter().fold(0.0, f64::max),
    }
}

fn required(a: &Analysis, percent: &dyn Fn(f64) -> Option<f64>) -> RequiredReport {
    let graded = a.ends.graded.clone();
    let first = graded.start;
    let forces: Vec<Vec3> = graded.map(|k| vec_at(&a.required_force, 3 * k)).collect();
    let mean = forces.iter().map(|f| f.y).sum::<f64>() / forces.len().max(1) as f64;
    let by_height = |x: &(usize, &Vec3), y: &(usize, &Vec3)| x.1.y.total_cmp(&y.1.y);
    let (frame, peak) = forces.iter().enumerate().max_by(by_height).map_or((0, 0.0), |(k, f)| (k, f.y));
    let least = forces.iter().map(|f| f.y).fold(f64::INFINITY, f64::min);
    RequiredReport {
        vertical_mean_n: mean,
        vertical_peak_n: peak,
        vertical_peak_at_s: (first + frame) as f64 / a.rate_hz(),
        vertical_mean_percent_bw: percent(mean),
        vertical_peak_percent_bw: percent(peak),
        vertical_least_percent_bw: percent(least),
        horizontal_peak_percent_bw: percent(forces.iter().map(|f| f.x.hypot(f.z)).fold(0.0, f64::max)),
    }
}

fn ground(input: &AnalysisInput, a: &Analysis) -> GroundReport {
    let c = &input.character;
    let sites: Vec<_> = c.contacts.iter().map(|&i| &c.skeleton.sites()[i]).collect();
    let height = a.ground_m.filter(|_| !sites.is_empty());
    GroundReport { height_m: a.ground_m, feet: height.map(|h| metrics::feet(&a.clip, &sites, h).into()) }
}

fn flight(a: &Analysis, percent: &dyn Fn(f64) -> Option<f64>) -> FlightReport {
    let frames: Vec<usize> = (0..a.frames()).filter(|&k| a.flight[k]).collect();
    let squares: f64 = frames.iter().map(|&k| vec_at(&a.residual, 6 * k).norm_squared()).sum();
    let held = (squares / frames.len().max(1) as f64).sqrt();
    FlightReport {
        frames: frames.len(),
        share: frames.len() as f64 / a.frames().max(1) as f64,
        held_up_percent_bw: percent(held).filter(|_| !frames.is_empty()),
        spans: spans(&frames, a.rate_hz()),
    }
}

/// Links below the root with a joint that moves.
fn moving(a: &Analysis) -> Vec<usize> {
    let links = a.clip.skeleton.links().iter().enumerate();
    links.filter(|(_, l)| !matches!(l.joint, Joint::Free | Joint::Fixed)).map(|(i, _)| i).collect()
}

/// Length of a joint's part of a row.
fn size_of(row: &[f64], a: &Analysis, link: usize) -> f64 {
    let skeleton = &a.clip.skeleton;
    let at = skeleton.v_at(link);
    row[at..at + skeleton.links()[link].joint.nv()].iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn joints(input: &AnalysisInput, a: &Analysis) -> Vec<JointLoadReport> {
    let nv = a.clip.skeleton.nv();
    let mass = input.character.mass();
    let report = |link: usize| {
        let rows = &a.tau[nv * a.ends.graded.start..nv * a.ends.graded.end];
        let sizes: Vec<f64> = rows.chunks_exact(nv).map(|row| size_of(row, a, link)).collect();
        let by_size = |x: &(usize, &f64), y: &(usize, &f64)| x.1.total_cmp(y.1);
        let (frame, peak) = sizes.iter().enumerate().max_by(by_size).map_or((0, 0.0), |(k, x)| (k, *x));
        let l = &a.clip.skeleton.links()[link];
        JointLoadReport {
            joint: l.name.clone(),
            kind: if matches!(l.joint, Joint::Prismatic(_)) { "force" } else { "torque" },
            peak_nm: peak,
            peak_at_s: (a.ends.graded.start + frame) as f64 / a.rate_hz(),
            peak_nm_kg: peak / mass,
            rms_nm: (sizes.iter().map(|x| x * x).sum::<f64>() / sizes.len().max(1) as f64).sqrt(),
            noise_nm: size_of(&a.noise.tau, a, link),
        }
    };
    let mut joints: Vec<JointLoadReport> = moving(a).into_iter().map(report).collect();
    // stable: equal ones stay in the order of the skeleton
    joints.sort_by(|x, y| y.peak_nm.total_cmp(&x.peak_nm));
    joints
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spans_are_runs() {
        let span = |from: usize, to: usize| FrameSpan {
            from_frame: from,
            to_frame: to,
            from_s: from as f64 / 10.0,
            to_s: to as f64 / 10.0,
        };
        assert_eq!(spans(&[0, 1, 2, 5, 7, 8], 10.0), [span(0, 2), span(5, 5), span(7, 8)]);
        assert_eq!(spans(&[], 10.0), []);
    }
}
