//! How an edit is learned and applied.

use learn::ExampleMethod;
use motion::names::Word;
use serde::{Deserialize, Serialize};

use super::features::{Orientation, PATH_WEIGHT, Recognised};
use super::solve::Weights;
use super::{Contacts, ExampleError, Outputs};

/// [`ExampleOptions::root_weight`] if nothing else is said: 94 % of a root lowered by 5 cm are kept.
pub const ROOT_WEIGHT: f64 = 1000.0;

/// How an edit is learned and applied.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ExampleOptions {
    /// What predicts.
    pub estimator: ExampleMethod,
    /// What is learned of a target: its difference to the source, or itself as in the paper ([`super::poses`]).
    #[serde(with = "word")]
    pub outputs: Outputs,
    /// What is removed of the root's orientation in features.
    #[serde(with = "word")]
    pub orientation: Orientation,
    /// How much the root's way over half a second counts in features; 0 as in the paper ([`Recognised`]).
    pub path_weight: f64,
    /// Weights of the blend.
    pub weights: Weights,
    /// Most examples a second of a clip, Hz: frames between them say the same.
    pub examples_hz: f64,
    /// Counts every example a second time with left and right exchanged, where the body has both.
    pub mirror: bool,
    /// Takes differences back where frames are new ([`super::model::gates`]).
    pub gate: bool,
    /// Whether what stands keeps standing.
    #[serde(with = "word")]
    pub contacts: Contacts,
    /// Where contacts are kept, how much more the root's part of the edit weighs than that of the joints, where legs reach the ground
    /// from it: at 1, as in the blend, raising the root costs less than bending two legs, and an edit of the root alone is taken back ([`super::contacts`]).
    pub root_weight: f64,
}

impl Default for ExampleOptions {
    fn default() -> Self {
        Self {
            estimator: ExampleMethod::default(),
            outputs: Outputs::default(),
            orientation: Orientation::default(),
            path_weight: PATH_WEIGHT,
            weights: Weights::default(),
            examples_hz: 30.0,
            mirror: true,
            gate: true,
            contacts: Contacts::default(),
            root_weight: ROOT_WEIGHT,
        }
    }
}

impl ExampleOptions {
    /// What features are made of.
    pub fn recognised(&self) -> Recognised {
        Recognised { orientation: self.orientation, path_weight: self.path_weight }
    }

    /// All numbers are in their ranges.
    ///
    /// # Errors
    /// One that is not.
    pub(super) fn check(&self) -> Result<(), ExampleError> {
        let w = &self.weights;
        let fault = |what, value, allowed| Err(ExampleError::Setting { what, value, allowed });
        if !(self.examples_hz.is_finite() && self.examples_hz > 0.0) {
            return fault("`examples_hz`", self.examples_hz, "above 0");
        }
        for (what, value) in [
            ("weight `configuration`", w.configuration),
            ("weight `source`", w.source),
            ("weight `acceleration`", w.acceleration),
            ("weight `source_acceleration`", w.source_acceleration),
        ] {
            if !(value.is_finite() && value >= 0.0) {
                return fault(what, value, "0 or more");
            }
        }
        if !(self.path_weight.is_finite() && self.path_weight >= 0.0) {
            return fault("`path_weight`", self.path_weight, "0 or more");
        }
        if !(self.root_weight.is_finite() && self.root_weight > 0.0) {
            return fault("`root_weight`", self.root_weight, "above 0");
        }
        if w.configuration + w.source <= 0.0 {
            return fault(
                "the sum of the weights `configuration` and `source`",
                0.0,
                "above 0: something must say where joints are",
            );
        }
        Ok(())
    }
}

mod word {
    use super::Word;
    use serde::{Deserialize, Deserializer, Serializer, de::Error};

    pub fn serialize<W: Word, S: Serializer>(w: &W, s: S) -> Result<S::Ok, S::Error> {
        s.serialize_str(w.word())
    }

    pub fn deserialize<'de, W: Word, D: Deserializer<'de>>(d: D) -> Result<W, D::Error> {
        W::find(&String::deserialize(d)?).map_err(D::Error::custom)
    }
}
