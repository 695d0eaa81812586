//! Residual force and moment over time, graded against the guideline OpenSim gives its users.
//!
//! In: a residual wrench per row (N, and N·m about the root's origin). Out: a page with two panels, their
//! bands (good, acceptable, poor: [`dynamics::analysis::grade`]) behind the curves, the verdict in the
//! title. The guideline is for peaks and RMS of the magnitudes; its bands are drawn for the peaks.

use dynamics::analysis::grade::{FORCE_PEAK_N, MOMENT_PEAK_NM};
use dynamics::analysis::{Grade, Residual};

use crate::angles::{COLORS, label_time};
use crate::columns::{WIDTH, empty_page, short, vectors};
use crate::figure::Figure;
use crate::panel::{Band, Clock, Key, Panel, Series, page};
use crate::style::{Color, INK};

/// Pale, in one order of lightness, so that no colour has to be told from another.
const GOOD: Color = Color(226, 240, 246);
const ACCEPTABLE: Color = Color(252, 240, 214);
const POOR: Color = Color(244, 226, 226);

/// Residual of a motion, `rows × 6`: force (N) and moment (N·m); `what` says whose residual it is.
pub fn graded_residual(wrench: &[f64], clock: Clock, weight_n: f64, what: &str, note: &str) -> Figure {
    let finite: Vec<f64> =
        wrench.chunks_exact(6).filter(|w| w.iter().all(|x| x.is_finite())).flatten().copied().collect();
    if finite.is_empty() {
        return empty_page("Residual", note, "no row with finite numbers");
    }
    let r = Residual::of(&finite);
    let verdict = match r.grade() {
        Grade::Good => "good",
        Grade::Acceptable => "acceptable",
        Grade::Poor => "poor",
    };
    let title = format!("Residual: {verdict} · peak {} N, {} N·m", short(r.force_peak), short(r.moment_peak));
    let share = |f: f64| {
        let percent = 100.0 * f / weight_n;
        if percent.is_finite() { format!(" ({} % of body weight)", short(percent)) } else { String::new() }
    };
    let panels = [
        panel(
            format!(
                "force · {} by its peak of {} N{}, RMS {} N",
                r.force_grade(),
                short(r.force_peak),
                share(r.force_peak),
                short(r.force_rms)
            ),
            "N",
            vectors(wrench, 6, 0),
            clock,
            FORCE_PEAK_N,
        ),
        panel(
            format!(
                "moment about the root's origin · {} by its peak of {} N·m, RMS {} N·m",
                r.moment_grade(),
                short(r.moment_peak),
                short(r.moment_rms)
            ),
            "N·m",
            vectors(wrench, 6, 3),
            clock,
            MOMENT_PEAK_NM,
        ),
    ];
    let mut panels = panels.to_vec();
    label_time(&mut panels, 1);
    let bounds = |what: &str, i: usize| format!("{what} {} N, {} N·m", FORCE_PEAK_N[i], MOMENT_PEAK_NM[i]);
    let keys = [
        Key::line("x, to the left", COLORS[0]),
        Key::line("y, up", COLORS[1]),
        Key::line("z, forward", COLORS[2]),
        Key::line("magnitude", INK),
        Key::area(&bounds("good: up to", 0), GOOD),
        Key::area(&bounds("acceptable: up to", 1), ACCEPTABLE),
        Key::area("poor: beyond", POOR),
    ];
    let said: Vec<&str> =
        [note, what, "bands: OpenSim's guideline for peaks"].into_iter().filter(|s| !s.is_empty()).collect();
    page(&title, &said.join(" · "), &keys, &panels, 1, WIDTH, 220.0)
}

fn panel(title: String, unit: &str, of: Vec<motion::Vec3>, clock: Clock, [good, limit]: [f64; 2]) -> Panel {
    let component = |k: usize| Series::over_time(clock, of.iter().map(|v| v[k]), COLORS[k]).wide(1.2);
    let mut series: Vec<Series> = (0..3).map(component).collect();
    series.push(Series::over_time(clock, of.iter().map(|v| v.norm()), INK));
    let band = |from, to, color| Band { from, to, color };
    let bands = vec![
        band(-good, good, GOOD),
        band(good, limit, ACCEPTABLE),
        band(limit, f64::INFINITY, POOR),
        band(-limit, -good, ACCEPTABLE),
        band(f64::NEG_INFINITY, -limit, POOR),
    ];
    Panel { title, y_label: unit.into(), series, bands, least_span: 1.4 * limit, ..Panel::default() }
}
