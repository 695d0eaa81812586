//! The parameters that may be tuned, in one table: name, unit, range, and what turning one does.
//!
//! In: a [`Tunable`]. Out: the same with one number changed, by name. A search walks through the ranges; a
//! value given by hand may lie anywhere in them. Ranges of strategies are chosen so that every combination
//! is a legal setting: no two parameters need each other.
//!
//! Defaults are those of [`Tunable::default`]. Names and units are those people read: angles in degrees. Switches of
//! [`BalanceSettings`] (`bool`, `Option`) are no parameters; a test holds that every number of it is in the table.

use crate::BalanceSettings;

/// Numbers a search may change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tunable {
    /// Factor on every tension, 1 = natural.
    pub tension: f64,
    /// Parameters of the balance property.
    pub balance: BalanceSettings,
}

impl Default for Tunable {
    fn default() -> Self {
        Self { tension: 1.0, balance: BalanceSettings::default() }
    }
}

/// How a parameter is divided by a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Spacing {
    /// Equal differences.
    Linear,
    /// Equal ratios; the range is above 0.
    Ratio,
}

/// One line of the table.
#[derive(Clone, Copy)]
pub struct Parameter {
    /// Name, as in files and on command lines.
    pub name: &'static str,
    /// Unit; empty for a pure number.
    pub unit: &'static str,
    /// Least value.
    pub lo: f64,
    /// Largest value.
    pub hi: f64,
    /// How it is divided.
    pub spacing: Spacing,
    /// What it is, and what a higher or lower value does.
    pub meaning: &'static str,
    get: fn(&Tunable) -> f64,
    set: fn(&mut Tunable, f64),
}

impl Parameter {
    /// Its value.
    pub fn get(&self, of: &Tunable) -> f64 {
        (self.get)(of)
    }

    /// Changes it; the caller has checked the range.
    pub fn set(&self, of: &mut Tunable, value: f64) {
        (self.set)(of, value);
    }

    /// Its value where nothing else was asked for.
    pub fn default(&self) -> f64 {
        self.get(&Tunable::default())
    }

    /// Whether a value is in the range.
    pub fn allows(&self, value: f64) -> bool {
        value >= self.lo && value <= self.hi
    }

    /// The value at `u` of the range, 0 to 1.
    pub fn at(&self, u: f64) -> f64 {
        let x = match self.spacing {
            Spacing::Linear => self.lo + (self.hi - self.lo) * u,
            Spacing::Ratio => self.lo * (self.hi / self.lo).powf(u),
        };
        x.clamp(self.lo, self.hi)
    }

    /// Where in the range a value lies, 0 to 1.
    pub fn part(&self, value: f64) -> f64 {
        let u = match self.spacing {
            Spacing::Linear => (value - self.lo) / (self.hi - self.lo),
            Spacing::Ratio => (value / self.lo).ln() / (self.hi / self.lo).ln(),
        };
        u.clamp(0.0, 1.0)
    }
}

macro_rules! balance {
    ($field:ident, $unit:literal, $lo:literal to $hi:literal, $meaning:literal) => {
        Parameter {
            name: stringify!($field),
            unit: $unit,
            lo: $lo,
            hi: $hi,
            spacing: Spacing::Linear,
            meaning: $meaning,
            get: |t| t.balance.$field,
            set: |t, x| t.balance.$field = x,
        }
    };
}

/// The table.
pub const PARAMETERS: &[Parameter] = &[
    Parameter {
        name: "tension",
        unit: "",
        lo: 0.5,
        hi: 4.0,
        spacing: Spacing::Ratio,
        meaning: "factor on every muscle's stiffness; higher is stiffer and holds poses closer, lower is looser",
        get: |t| t.tension,
        set: |t, x| t.tension = x,
    },
    balance!(
        shift,
        "m/m",
        0.0 to 1.2,
        "pelvis shift per error of the centre of mass; higher pulls back harder, too high sways"
    ),
    balance!(shift_damping, "m/m", 0.0 to 1.0, "pelvis shift per velocity over ω₀; higher damps sway"),
    balance!(
        shift_rate,
        "1/s",
        0.0 to 2.0,
        "rate at which a lasting error is removed; higher removes it sooner, too high sways"
    ),
    balance!(
        shift_limit_m,
        "m",
        0.02 to 0.15,
        "largest pelvis shift; higher answers larger errors, too high bends the legs to their ends"
    ),
    balance!(
        pressure,
        "m/m",
        0.0 to 1.0,
        "shift of the centre of pressure per error; higher pushes the body back harder"
    ),
    balance!(
        pressure_damping,
        "m/m",
        0.0 to 1.6,
        "shift of the centre of pressure per velocity over ω₀; 1 follows the capture point, higher brakes"
    ),
    balance!(
        margin_m,
        "m",
        0.002 to 0.03,
        "the centre of pressure stays this far inside the soles; lower uses more of them and may tip a foot"
    ),
    balance!(
        wake_from_m_s,
        "m/s",
        0.2 to 0.45,
        "speed of the capture point at which the answer to pushes wakes; lower answers to what the motion stirs up"
    ),
    balance!(
        wake_full_m_s,
        "m/s",
        0.46 to 1.0,
        "speed at which it acts whole; lower is more abrupt, higher answers hard pushes only"
    ),
    balance!(
        wake_rest_m,
        "m",
        0.002 to 0.03,
        "error below which it sleeps again; higher leaves the rest of the way to the springs"
    ),
    balance!(
        catch_gain,
        "m/m",
        0.2 to 4.0,
        "how far beyond the capture point the pressure is wanted under a push; higher returns sooner, too high rocks"
    ),
    balance!(
        catch_ahead_s,
        "s",
        0.0 to 0.12,
        "how far ahead the capture point is foreseen; higher answers sooner, too high leans for nothing"
    ),
    balance!(
        catch_margin_m,
        "m",
        0.002 to 0.02,
        "margin inside the soles under a push; lower uses more of them, too low turns a foot about its corner"
    ),
    balance!(
        hip_reserve_m,
        "m",
        0.0 to 0.06,
        "how far inside the support's edge a capture point is that the trunk leans for; higher leans sooner"
    ),
    balance!(
        hip_gain,
        "m/m",
        0.5 to 15.0,
        "moment of a lean over the weight, per way of the capture point beyond that; higher leans harder"
    ),
    balance!(
        hip_share,
        "",
        0.05 to 1.0,
        "part of the pressure's room that brings the trunk back; the rest brings the body back"
    ),
    balance!(
        hip_moment_nm,
        "N·m",
        50.0 to 300.0,
        "largest moment of a lean fore and aft; higher catches harder pushes, too high tips the feet"
    ),
    balance!(
        hip_side_moment_nm,
        "N·m",
        50.0 to 300.0,
        "largest moment of a lean to the side; higher catches harder pushes, too high tips the feet"
    ),
    Parameter {
        name: "hip_stroke_deg",
        unit: "°",
        lo: 15.0,
        hi: 60.0,
        spacing: Spacing::Linear,
        meaning: "largest lean of the chest; higher catches harder pushes, and looks it",
        get: |t| t.balance.hip_stroke_rad.to_degrees(),
        set: |t, x| t.balance.hip_stroke_rad = x.to_radians(),
    },
    balance!(
        hip_brake,
        "",
        0.1 to 1.0,
        "part of the moment with which a lean begins to be stopped; lower brakes sooner and softer"
    ),
    balance!(
        hip_return_rad_s,
        "rad/s",
        0.5 to 5.0,
        "natural frequency of the way back from a lean; higher returns sooner and asks more of the ground"
    ),
    balance!(
        hip_lag_s,
        "s",
        0.005 to 0.1,
        "time constant of a lean's moment; lower is more sudden"
    ),
];

/// The parameter of a name.
pub fn parameter(name: &str) -> Option<&'static Parameter> {
    PARAMETERS.iter().find(|p| p.name == name)
}

impl std::fmt::Debug for Parameter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Parameter")
            .field("name", &self.name)
            .field("lo", &self.lo)
            .field("hi", &self.hi)
            .finish_non_exhaustive()
    }
}

impl PartialEq for Parameter {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every number of the settings is in the table, angles in degrees, and nothing else but tension.
    #[test]
    fn the_table_covers_the_settings() {
        let shown = format!("{:?}", BalanceSettings::default());
        let inside = shown.split_once('{').unwrap().1.trim_end_matches('}');
        let mut numbers = 0;
        // a list of numbers is one field: its parameters begin with its name
        for field in inside.replace("[", "").replace("]", "").split(", ").filter(|f| f.contains(": ")) {
            let (name, value) = field.trim().split_once(": ").unwrap();
            let name = name.strip_suffix("_rad").map_or(name.to_owned(), |n| format!("{n}_deg"));
            let known = PARAMETERS.iter().filter(|p| p.name.starts_with(&name)).count();
            if let "true" | "false" | "None" = value.trim() {
                assert!(parameter(&name).is_none(), "{name} is a switch");
            } else {
                assert!(known > 0, "{name} is not in the table");
                numbers += 1;
            }
        }
        assert!(numbers < PARAMETERS.len(), "tension is in the table too");
    }

    /// A parameter changes its own number, all of its range and no other.
    #[test]
    fn each_sets_its_own() {
        for p in PARAMETERS {
            assert!(p.allows(p.default()), "{}", p.name);
            assert!(p.spacing == Spacing::Linear || p.lo > 0.0, "{}", p.name);
            for u in [0.0, 0.3, 1.0] {
                let mut t = Tunable::default();
                p.set(&mut t, p.at(u));
                // degrees to radians and back round: 1e-16 of it seen
                assert!(
                    (p.get(&t) / p.at(u).max(1e-9) - p.at(u) / p.at(u).max(1e-9)).abs() < 1e-14,
                    "{}",
                    p.name
                );
                assert!((p.part(p.at(u)) - u).abs() < 1e-12, "{}", p.name); // 2e-16 seen
                for other in PARAMETERS.iter().filter(|o| o.name != p.name) {
                    assert_eq!(other.get(&t), other.default(), "{} changed {}", p.name, other.name);
                }
            }
            assert_eq!((p.at(0.0), p.at(1.0)), (p.lo, p.hi), "{}", p.name);
        }
    }

    /// Every corner of the ranges keeps the order of the two speeds between which the answer to pushes fades in.
    #[test]
    fn ranges_need_no_order() {
        let (from, full) = (parameter("wake_from_m_s").unwrap(), parameter("wake_full_m_s").unwrap());
        assert!(from.hi < full.lo);
    }
}
