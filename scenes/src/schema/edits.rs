//! Words of edits: what is changed, where, by how much.

use std::collections::BTreeMap;
use std::fmt;

use edits::by_example::Contacts;
use edits::style::Timing;
use edits::{Argument, Direction, Reference};
use serde::Deserialize;
use serde::de::{self, Deserializer, MapAccess, SeqAccess, Visitor};

use super::word::Named;

/// A parameter of an edit: a number, `[one, for, each, pose]`, `(over_time_s: [(t, x), …])` or
/// `(over_repetition: [(n, x), …])`.
#[derive(Clone, Debug, PartialEq)]
pub enum ParameterRon {
    /// One value.
    Constant(f64),
    /// One value for each pose selected.
    PerPose(Vec<f64>),
    /// Knots over time, s.
    OverTime(Vec<(f64, f64)>),
    /// Knots over repetitions, counted from 0.
    OverRepetition(Vec<(f64, f64)>),
}

impl<'de> Deserialize<'de> for ParameterRon {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        struct Read;
        impl<'de> Visitor<'de> for Read {
            type Value = ParameterRon;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number, [a, list, over, poses], (over_time_s: [(t, x), …]) or (over_repetition: [(n, x), …])")
            }
            fn visit_f64<E: de::Error>(self, x: f64) -> Result<Self::Value, E> {
                Ok(ParameterRon::Constant(x))
            }
            fn visit_i64<E: de::Error>(self, x: i64) -> Result<Self::Value, E> {
                Ok(ParameterRon::Constant(x as f64))
            }
            fn visit_u64<E: de::Error>(self, x: u64) -> Result<Self::Value, E> {
                Ok(ParameterRon::Constant(x as f64))
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Self::Value, A::Error> {
                let mut values = Vec::new();
                while let Some(x) = seq.next_element()? {
                    values.push(x);
                }
                Ok(ParameterRon::PerPose(values))
            }
            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
                const KNOWN: &[&str] = &["over_time_s", "over_repetition"];
                let key: Option<String> = map.next_key()?;
                let found = match key.as_deref() {
                    Some("over_time_s") => ParameterRon::OverTime(map.next_value()?),
                    Some("over_repetition") => ParameterRon::OverRepetition(map.next_value()?),
                    Some(other) => return Err(de::Error::unknown_field(other, KNOWN)),
                    None => return Err(de::Error::invalid_length(0, &self)),
                };
                match map.next_key::<String>()? {
                    None => Ok(found),
                    Some(other) => Err(de::Error::unknown_field(&other, &[])),
                }
            }
        }
        d.deserialize_any(Read)
    }
}

/// How close elements are fitted to a motion that an edit of elements is to change.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename = "fit")]
pub struct FitRon {
    /// Rotations, degrees.
    pub deg: Option<f64>,
    /// Lengths, mm.
    pub mm: Option<f64>,
}

/// An edit. `on`: labels as text, several by commas; empty is the whole motion. `repetition`: only
/// this repetition of the cycle or pose named. `parts`: body parts, joints; empty is the whole body. `span_s`: from when to
/// when, of clip edits. `fit`: how close elements are fitted to what is no script.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename = "edit")]
#[expect(missing_docs, reason = "fields of every variant as described above; parameters in `edits`")]
pub enum EditRon {
    Succession {
        #[serde(default)]
        on: String,
        repetition: Option<usize>,
        #[serde(default)]
        parts: Vec<String>,
        span_s: Option<(f64, f64)>,
        fit: Option<FitRon>,
        offset_s: ParameterRon,
        #[serde(default)]
        direction: Named<Direction>,
    },
    Amplitude {
        #[serde(default)]
        on: String,
        repetition: Option<usize>,
        #[serde(default)]
        parts: Vec<String>,
        span_s: Option<(f64, f64)>,
        fit: Option<FitRon>,
        factor: ParameterRon,
        #[serde(default)]
        reference: Named<Reference>,
    },
    ExtentShoulder {
        #[serde(default)]
        on: String,
        repetition: Option<usize>,
        #[serde(default)]
        parts: Vec<String>,
        span_s: Option<(f64, f64)>,
        fit: Option<FitRon>,
        extent: ParameterRon,
    },
    ExtentReach {
        #[serde(default)]
        on: String,
        repetition: Option<usize>,
        #[serde(default)]
        parts: Vec<String>,
        span_s: Option<(f64, f64)>,
        fit: Option<FitRon>,
        factor: ParameterRon,
    },
    Tension {
        #[serde(default)]
        on: String,
        repetition: Option<usize>,
        #[serde(default)]
        parts: Vec<String>,
        span_s: Option<(f64, f64)>,
        factor: Option<ParameterRon>,
        absolute: Option<ParameterRon>,
    },
    Warp {
        #[serde(default)]
        on: String,
        repetition: Option<usize>,
        #[serde(default)]
        parts: Vec<String>,
        span_s: Option<(f64, f64)>,
        times_s: Vec<(f64, f64)>,
    },
    ByExample {
        #[serde(default)]
        on: String,
        repetition: Option<usize>,
        #[serde(default)]
        parts: Vec<String>,
        span_s: Option<(f64, f64)>,
        model: String,
        amount: Option<f64>,
        contacts: Option<Named<Contacts>>,
    },
    Style {
        #[serde(default)]
        on: String,
        repetition: Option<usize>,
        #[serde(default)]
        parts: Vec<String>,
        span_s: Option<(f64, f64)>,
        components: String,
        amount: ParameterRon,
        #[serde(default)]
        only: Vec<usize>,
        from: Option<String>,
        align: Option<String>,
        #[serde(default)]
        timing: Named<Timing>,
        #[serde(default)]
        names: BTreeMap<String, String>,
    },
    PoseDelta {
        #[serde(default)]
        on: String,
        repetition: Option<usize>,
        #[serde(default)]
        parts: Vec<String>,
        span_s: Option<(f64, f64)>,
        at_s: f64,
        #[serde(default)]
        drag: BTreeMap<String, (f64, f64, f64)>,
        #[serde(default)]
        pin: Vec<String>,
        #[serde(default)]
        weight: BTreeMap<String, f64>,
        #[serde(default)]
        group: Vec<Vec<String>>,
        #[serde(default)]
        limits: bool,
        #[serde(default = "blend_s")]
        blend_s: f64,
        block_s: Option<(f64, f64)>,
    },
    Pin {
        point: String,
        #[serde(default)]
        point_m: (f64, f64, f64),
        at: PinAtRon,
        from_s: f64,
        to_s: f64,
        #[serde(default = "pin_blend_s")]
        blend_s: f64,
    },
    Program {
        #[serde(default)]
        on: String,
        repetition: Option<usize>,
        #[serde(default)]
        parts: Vec<String>,
        span_s: Option<(f64, f64)>,
        file: String,
        #[serde(default)]
        params: BTreeMap<String, ArgumentRon>,
    },
    TimeDelta {
        #[serde(default)]
        on: String,
        repetition: Option<usize>,
        #[serde(default)]
        parts: Vec<String>,
        span_s: Option<(f64, f64)>,
        at_s: f64,
        to_s: f64,
        #[serde(default = "blend_s")]
        blend_s: f64,
    },
}

/// Where a pin holds: in the world (m), on a point of a link (its frame, m), or where it was before the edits.
#[derive(Debug, Deserialize)]
#[expect(missing_docs, reason = "as described above")]
pub enum PinAtRon {
    World(f64, f64, f64),
    Link(String, (f64, f64, f64)),
    Asked,
}

fn pin_blend_s() -> f64 {
    edits::pin::BLEND_S
}

/// A value that a scene gives to a program: a number, `true`, a text, `[numbers]` or `[texts]`.
#[derive(Clone, Debug, PartialEq)]
pub struct ArgumentRon(pub Argument);

impl<'de> Deserialize<'de> for ArgumentRon {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        struct Read;
        impl<'de> Visitor<'de> for Read {
            type Value = ArgumentRon;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number, true or false, a text, or a list of numbers or of texts")
            }
            fn visit_bool<E: de::Error>(self, x: bool) -> Result<Self::Value, E> {
                Ok(ArgumentRon(Argument::Flag(x)))
            }
            fn visit_f64<E: de::Error>(self, x: f64) -> Result<Self::Value, E> {
                Ok(ArgumentRon(Argument::Number(x)))
            }
            fn visit_i64<E: de::Error>(self, x: i64) -> Result<Self::Value, E> {
                Ok(ArgumentRon(Argument::Number(x as f64)))
            }
            fn visit_u64<E: de::Error>(self, x: u64) -> Result<Self::Value, E> {
                Ok(ArgumentRon(Argument::Number(x as f64)))
            }
            fn visit_str<E: de::Error>(self, text: &str) -> Result<Self::Value, E> {
                Ok(ArgumentRon(Argument::Text(text.into())))
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Self::Value, A::Error> {
                let (mut numbers, mut texts) = (Vec::new(), Vec::new());
                while let Some(ArgumentRon(item)) = seq.next_element()? {
                    match item {
                        Argument::Number(x) => numbers.push(x),
                        Argument::Text(text) => texts.push(text),
                        other => {
                            return Err(de::Error::custom(format!(
                                "{other} in a list; allowed: lists of numbers or of texts"
                            )));
                        }
                    }
                }
                match (numbers.is_empty(), texts.is_empty()) {
                    (_, true) => Ok(ArgumentRon(Argument::List(numbers))),
                    (true, false) => Ok(ArgumentRon(Argument::Texts(texts))),
                    (false, false) => Err(de::Error::custom("numbers and texts in one list")),
                }
            }
        }
        d.deserialize_any(Read)
    }
}

fn blend_s() -> f64 {
    edits::pose_delta::BLEND_S
}
