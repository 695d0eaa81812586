//! `<default>` classes: attributes an element has when it does not write them.
//!
//! In: the `<default>` sections. Out: for every class the attributes of `geom`, `joint` and `site`, those of
//! its parents included. A class takes over what its parent has once all direct settings of the parent
//! are read, wherever they stand in it.

use std::collections::HashMap;

use crate::model_file::{ModelFault, ModelFileError};
use crate::place::Place;
use crate::vocabulary;
use crate::xml::{Attribute, Element};

/// Attributes that give an orientation; the last one written counts.
pub const ORIENTATIONS: [&str; 5] = ["quat", "axisangle", "xyaxes", "zaxis", "euler"];

/// Settings of one class.
#[derive(Clone, Debug, Default)]
pub struct Class {
    name: String,
    geom: Vec<Attribute>,
    joint: Vec<Attribute>,
    site: Vec<Attribute>,
}

/// All classes of a file; the first is the one without a name.
#[derive(Debug)]
pub struct Classes {
    all: Vec<Class>,
    /// Where each name is.
    by_name: HashMap<String, usize>,
}

impl Classes {
    /// The class `main`, still empty.
    pub fn new() -> Self {
        let main = Class { name: "main".into(), ..Default::default() };
        Self { all: vec![main], by_name: HashMap::from([("main".into(), 0)]) }
    }

    /// Adds a top-level `<default>` section; `check` is called for every setting with its class's name.
    pub fn add(
        &mut self,
        section: &Element,
        check: &mut impl FnMut(&Element, &str) -> Result<(), ModelFileError>,
    ) -> Result<(), ModelFileError> {
        if let Some(class) = section.attribute("class").filter(|c| c.value != "main") {
            let problem = "is at the top; the outermost class is `main`, put the class inside it";
            return Err(fault(ModelFault::Class { class: class.value.clone(), problem }, &class.place));
        }
        self.fill(0, section, check)
    }

    fn fill(
        &mut self,
        at: usize,
        section: &Element,
        check: &mut impl FnMut(&Element, &str) -> Result<(), ModelFileError>,
    ) -> Result<(), ModelFileError> {
        for setting in section.children.iter().filter(|c| c.name != "default") {
            check(setting, &self.all[at].name)?;
            let class = &mut self.all[at];
            match setting.name.as_str() {
                "geom" => overlay(&mut class.geom, &setting.attributes),
                "joint" => overlay(&mut class.joint, &setting.attributes),
                "site" => overlay(&mut class.site, &setting.attributes),
                _ => {}
            }
        }
        for nested in section.children_named("default") {
            vocabulary::text(nested, &mut Vec::new())?;
            if let Some(other) = nested.attributes.iter().find(|a| a.name != "class") {
                let (attribute, element) = (other.name.clone(), "default".to_owned());
                let fault_ = ModelFault::UnknownAttribute { attribute, element, allowed: vec!["class"] };
                return Err(fault(fault_, &other.place));
            }
            let Some(class) = nested.attribute("class").filter(|c| !c.value.is_empty()) else {
                let needed = "`class`, as it stands inside another <default>";
                return Err(fault(ModelFault::Missing { element: "default".into(), needed }, &nested.place));
            };
            if self.by_name.contains_key(&class.value) {
                let problem = "is defined twice";
                return Err(fault(ModelFault::Class { class: class.value.clone(), problem }, &class.place));
            }
            let mut child = self.all[at].clone();
            child.name.clone_from(&class.value);
            self.by_name.insert(class.value.clone(), self.all.len());
            self.all.push(child);
            self.fill(self.all.len() - 1, nested, check)?;
        }
        Ok(())
    }

    /// Index of the class an attribute names.
    pub fn find(&self, class: &Attribute) -> Result<usize, ModelFileError> {
        self.by_name.get(&class.value).copied().ok_or_else(|| {
            let known = self.all.iter().map(|c| c.name.clone()).collect();
            fault(ModelFault::UnknownClass { class: class.value.clone(), known }, &class.place)
        })
    }

    /// Attributes of an element, those of its class under its own.
    ///
    /// `inherited` is the class of the nearest body around it that has a `childclass`.
    pub fn resolve(&self, element: &Element, inherited: usize) -> Result<Vec<Attribute>, ModelFileError> {
        let class = match element.attribute("class") {
            Some(class) => self.find(class)?,
            None => inherited,
        };
        let mut all = match element.name.as_str() {
            "geom" => self.all[class].geom.clone(),
            "joint" => self.all[class].joint.clone(),
            "site" => self.all[class].site.clone(),
            _ => Vec::new(),
        };
        overlay(&mut all, &element.attributes);
        Ok(all)
    }
}

/// Writes `top` over `base`.
fn overlay(base: &mut Vec<Attribute>, top: &[Attribute]) {
    for attribute in top {
        if ORIENTATIONS.contains(&attribute.name.as_str()) {
            base.retain(|a| !ORIENTATIONS.contains(&a.name.as_str()));
        }
        let mut new = attribute.clone();
        if let Some(old) = base.iter().position(|a| a.name == attribute.name) {
            if new.name == "size" {
                // fewer sizes than the default has: the default's others stay
                let given = new.value.split_whitespace().count();
                for kept in base[old].value.split_whitespace().skip(given) {
                    new.value = new.value + " " + kept;
                }
            }
            base[old] = new;
        } else {
            base.push(new);
        }
    }
}

fn fault(fault: ModelFault, place: &Place) -> ModelFileError {
    ModelFileError::Model { fault, place: place.clone() }
}
