//! Patches: parameters of tension and balance in a file beside a scene.
//!
//! In: RON. Out: a [`Patch`], applied to the numbers of the dynamic pass. A patch is what `contrapposto tune` writes; people
//! write it too. A scene takes one by `patch: "FILE"`, a command by `--patch FILE`, which comes after the scene's.
//!
//! ```ron
//! Patch(
//!     set: {
//!         "weight": (was: 1.5, is: 1.73),
//!     },
//! )
//! ```

use std::collections::BTreeMap;
use std::path::Path;

use controllers::{PARAMETERS, Parameter, Tunable, parameter};
use serde::Deserialize;

use crate::conditions::Physics;
use crate::{SceneError, Source};

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename = "Patch")]
struct PatchRon {
    set: BTreeMap<String, ChangeRon>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename = "change")]
struct ChangeRon {
    #[serde(default)]
    was: Option<f64>,
    is: f64,
}

/// A change of one parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Change {
    /// The parameter.
    pub parameter: &'static Parameter,
    /// What it was when the patch was made, for people; not checked.
    pub was: Option<f64>,
    /// What it is to be.
    pub is: f64,
}

/// Changes of parameters, each at most once.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Patch {
    /// In the order of the table.
    pub changes: Vec<Change>,
}

impl Patch {
    /// Reads a patch.
    ///
    /// # Errors
    /// Syntax, unknown parameters, values out of range: at their place.
    pub fn read(path: &Path) -> Result<Self, SceneError> {
        Self::parse(&Source::read(path)?)
    }

    /// Builds a patch from a text.
    ///
    /// # Errors
    /// As [`Patch::read`].
    pub fn parse(source: &Source) -> Result<Self, SceneError> {
        let ron: PatchRon = source.parse()?;
        for (name, change) in &ron.set {
            let at = format!("set{{\"{name}\"}}");
            let Some(p) = parameter(name) else {
                let known = PARAMETERS.iter().map(|p| p.name);
                return Err(source.unknown(&at, "parameter", name, " in a patch", known));
            };
            if !p.allows(change.is) {
                let unit = if p.unit.is_empty() { String::new() } else { format!(" {}", p.unit) };
                let message = format!("`{name}` is {}{unit}; allowed: {} to {}{unit}", change.is, p.lo, p.hi);
                return Err(source.error(&format!("{at}.is"), message));
            }
        }
        let changes = PARAMETERS.iter().filter_map(|parameter| {
            let c = ron.set.get(parameter.name)?;
            Some(Change { parameter, was: c.was, is: c.is })
        });
        Ok(Self { changes: changes.collect() })
    }

    /// Changes the numbers of a dynamic pass.
    pub fn apply(&self, physics: &mut Physics) {
        let mut t = Tunable { tension: physics.tension, balance: physics.balance };
        for c in &self.changes {
            c.parameter.set(&mut t, c.is);
        }
        (physics.tension, physics.balance) = (t.tension, t.balance);
    }

    /// As RON, `comment` above it.
    pub fn to_ron(&self, comment: &str) -> String {
        let mut text: String = comment.lines().map(|l| format!("// {l}\n")).collect();
        text += "Patch(\n    set: {\n";
        for c in &self.changes {
            let was = c.was.map_or(String::new(), |x| format!("was: {x:?}, "));
            let unit = if c.parameter.unit.is_empty() { "1" } else { c.parameter.unit };
            let name = c.parameter.name;
            text +=
                &format!("        \"{name}\": ({was}is: {:?}), // {unit}: {}\n", c.is, c.parameter.meaning);
        }
        text + "    },\n)\n"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fault(text: &str) -> String {
        Patch::parse(&Source::new("p.ron", text)).unwrap_err().to_string()
    }

    #[test]
    fn a_patch_comes_back() {
        let change = |(i, parameter): (usize, &'static Parameter)| Change {
            parameter,
            was: (i % 2 == 0).then(|| parameter.default()),
            is: parameter.at((i as f64 * 0.37).fract()),
        };
        let patch = Patch { changes: PARAMETERS.iter().enumerate().map(change).collect() };
        let text = patch.to_ron("made by a test\nof two lines");
        assert_eq!(Patch::parse(&Source::new("p.ron", text.as_str())).unwrap(), patch, "{text}");
    }

    #[test]
    fn bad_patches_are_refused_at_their_place() {
        let e = fault("Patch(\n  set: {\n    \"cacth_gain\": (is: 1.0),\n  },\n)");
        assert!(e.contains("unknown parameter `cacth_gain` in a patch; did you mean `catch_gain`?"), "{e}");
        assert!(e.contains("p.ron:3:5"), "{e}");
        let e = fault("Patch(set: {\"catch_gain\": (is: 99)})");
        assert!(e.contains("`catch_gain` is 99 m/m; allowed: 0.2 to 4 m/m") && e.contains("p.ron:1:"), "{e}");
        assert!(fault("Patch(set: {\"catch_gain\": (is: 1, so: 2)})").contains("so"));
    }
}
