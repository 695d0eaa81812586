//! What becomes of every word of a format: read, listed as left out, or refused.
//!
//! In: elements, and tables of the words a format has. Out: items left out, or an error for a word that is not
//! in the table. So nothing is skipped in silence. What is listed is not looked into: it may hold anything, but for text
//! inside what makes forces, where it may be a comment that was not closed.

use super::model_file::{Effect, LeftOut, ModelFault, ModelFileError};
use super::xml::{Attribute, Element};
use motion::names;

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
        Some((_, Fate::Taken)) => {
            text(child, left_out)?;
            Ok(true)
        }
        Some((_, Fate::Listed(effect, reason))) => {
            if *effect == Effect::Physics {
                no_text_inside(child)?;
            }
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

/// Refuses text in an element that is read; a `>` too many is listed.
pub fn text(element: &Element, left_out: &mut Vec<LeftOut>) -> Result<(), ModelFileError> {
    let Some(text) = &element.text else { return Ok(()) };
    if !text.stray {
        let fault = ModelFault::Text { element: element.name.clone(), found: text.found.clone() };
        return Err(ModelFileError::Model { fault, place: text.place.clone() });
    }
    left_out.push(LeftOut {
        what: format!("`{}` inside <{}>", text.found, element.name),
        reason: "a bracket too many",
        effect: Effect::Look,
        missing: None,
        place: text.place.clone(),
    });
    Ok(())
}

/// Refuses text in an element and in all it holds.
fn no_text_inside(element: &Element) -> Result<(), ModelFileError> {
    text(element, &mut Vec::new())?;
    element.children.iter().try_for_each(no_text_inside)
}

/// Refuses unknown attributes and a name that cannot be written, and lists attributes that are not read, one item per reason.
pub fn attributes(
    element: &Element,
    words: &'static [Word],
    title: &str,
    left_out: &mut Vec<LeftOut>,
) -> Result<(), ModelFileError> {
    if let Some(name) = element.attribute("name").filter(|name| !name.value.is_empty())
        && let Err(problem) = names::check(&name.value)
    {
        return Err(ModelFileError::Model { fault: ModelFault::Name { problem }, place: name.place.clone() });
    }
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
