//! The figures of `plot` and `analyze`, and the numbers on them.
//!
//! A trace is drawn as it was recorded; a clip or a scene by its analysis. Only the ground forces required
//! and given need the analysis of a trace; a trace that cannot be analysed (too short, NaN) is drawn without
//! them, and the figure says why.

use dynamics::ground_forces::GroundForces;
use dynamics::{Analysis, RootMode, Trace, analysis::Residual};
use plots::panel::Clock;
use plots::{Excerpt, Figure, ForceSource, ForceSourceKind, StripOptions, StripRow, film_strip_with};
use serde_json::{Value, json};

use motion::names::Word;

use super::number;
use crate::{AnalysisInput, AnalysisInputError};

/// A figure of an analysis or a recorded run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum AnalysisFigure {
    /// Ground forces per foot and in total.
    Contact,
    /// Residual force and moment, graded.
    Residual,
    /// Linear and angular momentum.
    Momentum,
    /// Centre of mass and centre of pressure over the support.
    Com,
    /// Torques of the hardest joints.
    Torque,
    /// Gains and torques of the muscles.
    Gains,
    /// Joint angles asked for and performed.
    Angles,
    /// Energies and power.
    Energy,
    /// Film strip.
    Strip,
}

impl Word for AnalysisFigure {
    const KIND: &'static str = "figure";
    const WORDS: &'static [(Self, &'static str, &'static str)] = &[
        (
            Self::Contact,
            "contact",
            "Ground forces per foot and in total: required, given, measured, MuJoCo's",
        ),
        (Self::Residual, "residual", "Residual force and moment, graded"),
        (Self::Momentum, "momentum", "Linear and angular momentum"),
        (Self::Com, "com", "Centre of mass and centre of pressure over the support"),
        (Self::Torque, "torque", "Torques of the hardest joints"),
        (Self::Gains, "gains", "Gains and torques of the muscles (traces only)"),
        (Self::Angles, "angles", "Joint angles asked for and performed"),
        (Self::Energy, "energy", "Energies and power"),
        (Self::Strip, "strip", "Film strip"),
    ];
}

impl AnalysisFigure {
    /// Every figure, in order.
    pub fn all() -> impl Iterator<Item = Self> {
        Self::WORDS.iter().map(|w| w.0)
    }
}

/// Why a motion cannot be drawn.
#[derive(Debug, thiserror::Error)]
pub enum DrawingError {
    /// A clip or scene without an analysis: there is nothing else to draw.
    #[error("{0}")]
    NoAnalysis(String),
    /// Penalty contact or another run that do not fit.
    #[error(transparent)]
    Input(#[from] AnalysisInputError),
}

/// What is drawn, and how much of it.
pub struct Drawing<'a> {
    input: &'a AnalysisInput,
    analysis: Result<&'a Analysis, String>,
    trace: Trace,
    /// Seconds.
    span: [f64; 2],
    joints: Option<Vec<usize>>,
    feet: Option<Vec<usize>>,
    sources: Vec<ForceSource>,
    /// What the contact figure has to say besides.
    remarks: Vec<String>,
}

impl<'a> Drawing<'a> {
    /// Everything of a motion. `analysis` may fail for a trace.
    ///
    /// # Errors
    /// A clip or scene without an analysis; MuJoCo's trace of another body.
    pub fn new(
        input: &'a AnalysisInput,
        analysis: Result<&'a Analysis, String>,
        sink_m: f64,
        mujoco: Option<&std::path::Path>,
    ) -> Result<Self, DrawingError> {
        let trace = match (&analysis, input.recorded()) {
            (_, Some(trace)) => trace.clone(),
            (Ok(a), None) => input.trace(a),
            (Err(why), None) => return Err(DrawingError::NoAnalysis(why.clone())),
        };
        let span = [0.0, trace.clip().duration_s()];
        let (joints, feet) = (None, None);
        let (sources, remarks) = (Vec::new(), Vec::new());
        let mut drawing = Self { input, analysis, trace, span, joints, feet, sources, remarks };
        drawing.compare(sink_m, mujoco)?;
        Ok(drawing)
    }

    fn compare(&mut self, sink_m: f64, mujoco: Option<&std::path::Path>) -> Result<(), DrawingError> {
        let mut add = |kind, label: String, forces| self.sources.push(ForceSource { kind, label, forces });
        if let Some(trace) = self.input.recorded() {
            match trace.ground_m {
                Some(_) => {
                    let label = "measured: contacts of the run".to_owned();
                    add(ForceSourceKind::Measured, label, GroundForces::measured(trace));
                }
                None => self.remarks.push("the run had no ground: nothing was measured".into()),
            }
        }
        match &self.analysis {
            Ok(a) => {
                add(
                    ForceSourceKind::Required,
                    format!("required: inverse dynamics{}", smoothing(a)),
                    GroundForces::required(a),
                );
                match self.input.penalty(a, sink_m)? {
                    Some((forces, by)) => {
                        let label = format!(
                            "given: penalty contact, sink {} mm, motion {} {:.2} mm",
                            number(1e3 * sink_m),
                            if by.lowered_m < 0.0 { "raised" } else { "lowered" },
                            1e3 * by.lowered_m.abs()
                        );
                        add(ForceSourceKind::Given, label, forces);
                    }
                    None if a.ground_m.is_none() => self.remarks.push("no ground: none is given".into()),
                    None => self.remarks.push("penalty contact cannot bear the body within 100 mm".into()),
                }
            }
            Err(why) => self.remarks.push(format!("required and given forces are missing: {why}")),
        }
        let beside = self.input.mujoco_beside();
        if let Some(path) = mujoco.or(beside.as_deref()) {
            let forces = self.input.other_run(path)?;
            add(ForceSourceKind::Mujoco, "MuJoCo".into(), forces);
        }
        Ok(())
    }

    /// Length of the motion, s.
    pub fn duration_s(&self) -> f64 {
        self.trace.clip().duration_s()
    }

    /// Limits the drawing to a span of time.
    pub fn between(&mut self, from_s: f64, to_s: f64) {
        self.span = [from_s, to_s];
    }

    /// Limits figures of joints to some links.
    pub fn only_joints(&mut self, links: Vec<usize>) {
        self.joints = Some(links);
    }

    /// Limits the contact figure to some feet, by link.
    pub fn only_feet(&mut self, links: Vec<usize>) {
        self.feet = Some(links);
    }

    /// The feet of the contact figure: name of the leg, name of the link, link.
    pub fn feet(&self) -> Vec<(String, String, usize)> {
        let links = self.trace.character.skeleton.links();
        let feet = self.sources.first().map(|w| &w.forces.feet[..]).unwrap_or_default();
        feet.iter().map(|f| (f.name.clone(), links[f.link].name.clone(), f.link)).collect()
    }

    /// Names of the links with a joint that moves, and their indices.
    pub fn joints(&self) -> Vec<(String, usize)> {
        let skeleton = &self.trace.character.skeleton;
        let links = skeleton.links().iter().enumerate().skip(1);
        links.filter(|(_, l)| l.joint.nv() > 0).map(|(i, l)| (l.name.clone(), i)).collect()
    }

    /// Whether there is such a figure of this motion; else why not.
    pub fn has(&self, what: AnalysisFigure) -> Result<(), String> {
        match (what, self.input.recorded()) {
            (AnalysisFigure::Gains, None) => Err(format!(
                "gains are of traces: muscles performed nothing in this {}; `contrapposto render` makes a trace",
                self.input.source.name()
            )),
            _ => Ok(()),
        }
    }

    /// Draws one figure; also the numbers on it.
    pub fn draw(&self, what: AnalysisFigure) -> (Figure, Value) {
        let [from_s, to_s] = self.span;
        let whole = from_s <= 0.0 && to_s >= self.duration_s();
        let excerpt = match whole {
            true => Excerpt::whole(&self.trace),
            false => Excerpt::between(&self.trace, from_s, to_s),
        };
        let excerpt = match &self.joints {
            Some(links) => excerpt.of_joints(links.clone()),
            None => excerpt,
        };
        let excerpt = match self.input.recorded() {
            Some(_) => excerpt,
            None => excerpt.labelled("as given", "as analysed"),
        };
        let note = &self.note();
        match what {
            AnalysisFigure::Contact => self.contact(note),
            AnalysisFigure::Residual => self.residual(&excerpt, note),
            AnalysisFigure::Momentum => (plots::momenta(&excerpt, note), json!({})),
            AnalysisFigure::Com => (plots::center_of_mass(&excerpt, note), json!({})),
            AnalysisFigure::Torque => {
                let analysed = self.input.recorded().is_none();
                let noise = self.analysis.as_ref().ok().filter(|_| analysed).map(|a| &a.noise.tau[..]);
                (plots::joint_torques(&excerpt, noise.unwrap_or_default(), note), json!({}))
            }
            AnalysisFigure::Gains => (plots::gains_and_torques(&excerpt, note), json!({})),
            AnalysisFigure::Angles => (plots::joint_angles(&excerpt, note), json!({})),
            AnalysisFigure::Energy => (plots::energies(&excerpt, note), json!({})),
            AnalysisFigure::Strip => (self.strip(note), json!({})),
        }
    }

    fn contact(&self, note: &str) -> (Figure, Value) {
        let [from_s, to_s] = self.span;
        let cut = self.sources.iter().map(|w| {
            let mut forces = w.forces.between(from_s, to_s);
            if let Some(links) = &self.feet {
                forces.feet.retain(|f| links.contains(&f.link));
            }
            ForceSource { forces, ..w.clone() }
        });
        let sources: Vec<ForceSource> = cut.collect();
        let weight = self.trace.character.mass() * self.trace.gravity.norm();
        let notes: Vec<&str> = std::iter::once(note).chain(self.remarks.iter().map(String::as_str)).collect();
        let figure = plots::contact_overlay(&sources, weight, &notes.join(" · "));
        let Some(reference) = plots::overlay::reference(&sources) else {
            return (figure, json!({ "reference": null, "remarks": self.remarks }));
        };
        let mut rms = serde_json::Map::new();
        for w in sources.iter().filter(|w| w.kind != reference.kind) {
            let mut parts = serde_json::Map::new();
            let pair = |a: &[_], b: &[_]| {
                let rms = GroundForces::rms_difference([&reference.forces, &w.forces], a, b);
                rms.map_or(Value::Null, |[up, across]| json!({ "vertical": up, "horizontal": across }))
            };
            parts.insert("total".into(), pair(&reference.forces.total, &w.forces.total));
            for foot in &reference.forces.feet {
                if let Some(other) = w.forces.feet.iter().find(|f| f.link == foot.link) {
                    parts.insert(foot.name.clone(), pair(&foot.force, &other.force));
                }
            }
            rms.insert(w.kind.name().to_lowercase(), parts.into());
        }
        let numbers = json!({
            "reference": reference.kind.name().to_lowercase(),
            "weight_n": weight,
            "rms_difference_n": rms,
            "remarks": self.remarks,
        });
        (figure, numbers)
    }

    fn residual(&self, excerpt: &Excerpt, note: &str) -> (Figure, Value) {
        let wrench = excerpt.residual();
        // a free root's residual is a difference of rows: the first has none
        let first = usize::from(self.input.recorded().is_some() && excerpt.rows() > 1);
        let wrench = &wrench[6 * first..];
        let what = match (self.input.recorded(), excerpt.root) {
            (None, _) => "what neither joints nor an admissible ground explain",
            (_, RootMode::Free) => "root free: the error of the integrator",
            (_, RootMode::Assisted { .. }) => "root assisted: what the assist did",
            (_, RootMode::Pinned) => "root pinned: what the pin did",
        };
        let weight = excerpt.character.mass() * excerpt.gravity.norm();
        let clock = excerpt.clock();
        let clock = Clock { start_s: clock.at(first), ..clock };
        let figure = plots::graded_residual(wrench, clock, weight, what, note);
        let r = Residual::of(wrench);
        let numbers = json!({
            "grade": r.grade().to_string(),
            "force_grade": r.force_grade().to_string(),
            "moment_grade": r.moment_grade().to_string(),
            "force_peak_n": r.force_peak,
            "force_rms_n": r.force_rms,
            "force_peak_at_s": clock.at(r.force_frame),
            "moment_peak_nm": r.moment_peak,
            "moment_rms_nm": r.moment_rms,
            "moment_peak_at_s": clock.at(r.moment_frame),
        });
        (figure, numbers)
    }

    fn strip(&self, note: &str) -> Figure {
        let (performed, asked) = (self.trace.clip(), self.trace.target_clip());
        let ups = &self.trace.disturbed.ground_up;
        let mut rows = vec![StripRow::new("performed", &performed).on(ups)];
        match self.input.recorded() {
            Some(_) => rows.insert(0, StripRow::new("asked for", &asked).on(&ups[..ups.len().min(1)])),
            None => rows[0].label = "as analysed",
        }
        let [from_s, to_s] = self.span;
        let ground_m = self.trace.ground_m;
        let title = (rows.len() == 1).then(|| "Film strip".to_owned());
        let options = StripOptions {
            from_s,
            to_s: Some(to_s),
            ground_m,
            title,
            view: self.input.view,
            colors: self.input.colors.clone(),
            props: self.trace.disturbed.props.clone(),
            ..StripOptions::default()
        };
        film_strip_with(&rows, &self.trace.character, note, &options)
    }

    /// What stands under every title.
    fn note(&self) -> String {
        let t = &self.trace;
        let name = &self.input.name;
        match self.input.recorded() {
            Some(_) => {
                let root = t.root.name().word();
                format!("{name}: recorded, root {root}, {} Hz, {} substeps", number(t.rate_hz), t.substeps)
            }
            None => {
                let smoothed = match &self.analysis {
                    Ok(a) => smoothing(a),
                    Err(_) => String::new(),
                };
                format!("{name}: inverse dynamics, {} Hz{smoothed}", number(t.rate_hz))
            }
        }
    }
}

fn smoothing(a: &Analysis) -> String {
    match a.smoothing.cutoff_hz {
        hz if hz.is_finite() => format!(", smoothed at {hz:.1} Hz"),
        _ => String::new(),
    }
}
