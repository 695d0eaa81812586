//! Attributes of one element: numbers, words, directions.
//!
//! In: the attributes an element has, defaults included. Out: values, or an error that names attribute, element
//! and place.

use super::limits::NUMBER;
use super::model_file::{ModelFault, ModelFileError};
use super::place::Place;
use super::xml::{Attribute, Element};
use motion::Vec3;

/// Attributes of an element for reading.
pub struct Reader<'a> {
    /// Tag.
    pub element: &'a str,
    /// Tag and name, for messages.
    pub title: String,
    /// Where the element begins.
    pub place: &'a Place,
    /// What it has.
    pub attributes: &'a [Attribute],
}

impl<'a> Reader<'a> {
    /// Attributes an element writes itself.
    pub fn new(element: &'a Element) -> Self {
        Self::with(element, &element.attributes)
    }

    /// Attributes of an element, defaults included.
    pub fn with(element: &'a Element, attributes: &'a [Attribute]) -> Self {
        Self { element: &element.name, title: element.title(), place: &element.place, attributes }
    }

    /// The attribute of this name.
    pub fn get(&self, name: &str) -> Option<&'a Attribute> {
        self.attributes.iter().find(|a| a.name == name)
    }

    /// An error at an attribute, or at the element if it is not there.
    pub fn fault(&self, name: &str, fault: ModelFault) -> ModelFileError {
        let place = self.get(name).map_or(self.place, |a| &a.place).clone();
        ModelFileError::Model { fault, place }
    }

    /// `attribute` of the element, as messages call it.
    pub fn label(&self, name: &str) -> String {
        format!("`{name}` of {}", self.title)
    }

    /// All numbers of an attribute.
    pub fn numbers(&self, name: &str) -> Result<Option<Vec<f64>>, ModelFileError> {
        let Some(attribute) = self.get(name) else { return Ok(None) };
        let number = |word: &str| {
            let number = word.parse::<f64>().ok().filter(|x| x.is_finite()).ok_or_else(|| {
                let fault = ModelFault::BadNumber { found: word.into(), attribute: self.label(name) };
                self.fault(name, fault)
            })?;
            // a range without end may be written as a great number
            if number.abs() > NUMBER && !matches!(name, "range" | "lower" | "upper") {
                let (found, attribute) = (word.to_owned(), self.label(name));
                let allowed = "at most 1e12 in magnitude";
                return Err(self.fault(name, ModelFault::OutOfBounds { attribute, found, allowed }));
            }
            Ok(number)
        };
        attribute.value.split_whitespace().map(number).collect::<Result<_, _>>().map(Some)
    }

    /// Exactly `N` numbers.
    pub fn array<const N: usize>(&self, name: &str) -> Result<Option<[f64; N]>, ModelFileError> {
        let Some(numbers) = self.numbers(name)? else { return Ok(None) };
        numbers.as_slice().try_into().map(Some).map_err(|_| self.count(name, numbers.len(), N.to_string()))
    }

    /// An error for a wrong number of numbers.
    pub fn count(&self, name: &str, found: usize, needed: String) -> ModelFileError {
        self.fault(name, ModelFault::NumberCount { attribute: self.label(name), found, needed })
    }

    /// One number.
    pub fn number(&self, name: &str) -> Result<Option<f64>, ModelFileError> {
        Ok(self.array::<1>(name)?.map(|[x]| x))
    }

    /// Three numbers.
    pub fn vector(&self, name: &str) -> Result<Option<Vec3>, ModelFileError> {
        Ok(self.array::<3>(name)?.map(Vec3::from))
    }

    /// One word of several; the index in `allowed`.
    pub fn word(&self, name: &str, allowed: &[&'static str]) -> Result<Option<usize>, ModelFileError> {
        let Some(attribute) = self.get(name) else { return Ok(None) };
        let at = allowed.iter().position(|&w| w == attribute.value);
        at.map(Some).ok_or_else(|| {
            let (found, allowed) = (attribute.value.clone(), allowed.to_vec());
            self.fault(name, ModelFault::BadWord { attribute: self.label(name), found, allowed })
        })
    }

    /// `true` or `false`.
    pub fn flag(&self, name: &str) -> Result<Option<bool>, ModelFileError> {
        Ok(self.word(name, &["false", "true"])?.map(|i| i == 1))
    }

    /// An error for a value out of bounds, the text as written.
    pub fn bounds(&self, name: &str, allowed: &'static str) -> ModelFileError {
        let found = self.get(name).map_or_else(|| "missing".to_owned(), |a| a.value.clone());
        self.fault(name, ModelFault::OutOfBounds { attribute: self.label(name), found, allowed })
    }

    /// A direction: three numbers, not all zero, made unit length.
    pub fn direction(&self, name: &str) -> Result<Option<Vec3>, ModelFileError> {
        let Some(v) = self.vector(name)? else { return Ok(None) };
        let length = v.norm();
        if length < 1e-10 || !length.is_finite() {
            return Err(self.bounds(name, "a direction, not all zeros"));
        }
        Ok(Some(v / length))
    }
}
