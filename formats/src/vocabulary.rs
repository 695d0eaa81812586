//! What becomes of every word of a format: read, listed as left out, or refused.
//!
//! In: elements, and tables of the words a format has. Out: items left out, or an error for a word that is not
//! in the table. So nothing is skipped in silence.

use super::model_file::{Effect, LeftOut, ModelFault, ModelFileError};
use super::xml::{Attribute, Element};

/// What becomes of an attribute.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Use {
    /// Read.
    Read,
    /// Listed: no force depends on it.
    Look(&'static str),
    /// Listed: forces depend on it.
    Physics(&'static str),
    /// Listed like `Physics` unless all its numbers are zero or it is `false`.
    Nonzero(&'static str),
    /// An error unless all its numbers are zero or it is `false`.
    Refused(&'static str),
}
/// An attribute and what becomes of it.
pub type Word = (&'static str, Use);

/// What becomes of an element that is not read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fate {
    /// Read elsewhere.
    Taken,
    /// Listed.
    Listed(Effect, &'static str),
    /// An error; says why.
    Never(&'static str),
}
/// An element and what becomes of it.
pub type Part = (&'static str, Fate);

/// Looks a child up; lists it or refuses it. Returns whether it is read elsewhere.
pub fn judge(
    child: &Element,
    parent: &str,
    parts: &'static [Part],
    left_out: &mut Vec<LeftOut>,
) -> Result<bool, ModelFileError> {
    let fault = |fault| Err(ModelFileError::Model { fault, place: child.place.clone() });
    match parts.iter().find(|(name, _)| *name == child.name) {
        Some((_, Fate::Taken)) => Ok(true),
        Some((_, Fate::Listed(effect, reason))) => {
            left_out.push(LeftOut {
                what: child.title(),
                reason,
                effect: *effect,
                missing: None,
                place: child.place.clone(),
            });
            Ok(false)
        }
        Some((_, Fate::Never(reason))) => {
            fault(ModelFault::Unsupported { what: format!("<{}>", child.name), reason })
        }
        None => fault(ModelFault::UnknownElement {
            element: child.name.clone(),
            parent: parent.to_owned(),
            allowed: parts.iter().map(|(name, _)| *name).collect(),
        }),
    }
}

/// Refuses unknown attributes and lists those that are not read, one item per reason.
pub fn attributes(
    element: &Element,
    words: &'static [Word],
    title: &str,
    left_out: &mut Vec<LeftOut>,
) -> Result<(), ModelFileError> {
    let mut groups: Vec<(Effect, &'static str, Vec<&Attribute>)> = Vec::new();
    for attribute in &element.attributes {
        let fault = |fault| Err(ModelFileError::Model { fault, place: attribute.place.clone() });
        let Some((_, usage)) = words.iter().find(|(name, _)| *name == attribute.name) else {
            return fault(ModelFault::UnknownAttribute {
                attribute: attribute.name.clone(),
                element: element.name.clone(),
                allowed: words.iter().map(|(name, _)| *name).collect(),
            });
        };
        let (effect, reason) = match *usage {
            Use::Read => continue,
            Use::Nonzero(_) | Use::Refused(_) if is_nothing(&attribute.value) => continue,
            Use::Look(reason) => (Effect::Look, reason),
            Use::Physics(reason) | Use::Nonzero(reason) => (Effect::Physics, reason),
            Use::Refused(reason) => {
                let what = format!("{}=\"{}\" of <{}>", attribute.name, attribute.value, element.name);
                return fault(ModelFault::Unsupported { what, reason });
            }
        };
        match groups.iter_mut().find(|(e, r, _)| *e == effect && *r == reason) {
            Some((_, _, list)) => list.push(attribute),
            None => groups.push((effect, reason, vec![attribute])),
        }
    }
    for (effect, reason, list) in groups {
        let names: Vec<&str> = list.iter().map(|a| a.name.as_str()).collect();
        left_out.push(LeftOut {
            what: format!("{title}: {}", names.join(", ")),
            reason,
            effect,
            missing: None,
            place: list[0].place.clone(),
        });
    }
    Ok(())
}

/// Zeros or `false`: what an attribute says when it asks for nothing.
fn is_nothing(value: &str) -> bool {
    value == "false" || value.split_whitespace().all(|w| w.parse::<f64>().is_ok_and(|x| x == 0.0))
}
