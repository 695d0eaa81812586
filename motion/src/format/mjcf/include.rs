//! `<include file="…"/>`: replaced by the children of the named file's root.
//!
//! In: the path of the main file. Out: one tree, every element with the place in its own file. A name is
//! relative to the folder of the file it stands in; a file can be included once, and not in a circle.

use std::path::{Path, PathBuf};

use crate::format::model_file::{ModelFault, ModelFileError};
use crate::format::xml::{self, Element};

/// The main file with all includes expanded.
pub fn read(path: &Path) -> Result<Element, ModelFileError> {
    let mut root = xml::read(path)?;
    if root.name != "mujoco" {
        let fault = ModelFault::Root { found: root.name, expected: "mujoco" };
        return Err(ModelFileError::Model { fault, place: root.place });
    }
    let mut seen = vec![identity(path)];
    let mut stack = vec![path.to_path_buf()];
    expand(&mut root, &mut stack, &mut seen)?;
    Ok(root)
}

fn identity(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_path_buf())
}

fn expand(
    element: &mut Element,
    stack: &mut Vec<PathBuf>,
    seen: &mut Vec<PathBuf>,
) -> Result<(), ModelFileError> {
    let mut children = Vec::with_capacity(element.children.len());
    for mut child in std::mem::take(&mut element.children) {
        if child.name != "include" {
            expand(&mut child, stack, seen)?;
            children.push(child);
            continue;
        }
        let fault = |fault| ModelFileError::Model { fault, place: child.place.clone() };
        if let Some(other) = child.attributes.iter().find(|a| a.name != "file") {
            let (attribute, element) = (other.name.clone(), "include".to_owned());
            let fault = ModelFault::UnknownAttribute { attribute, element, allowed: vec!["file"] };
            return Err(ModelFileError::Model { fault, place: other.place.clone() });
        }
        let Some(name) = child.value("file") else {
            return Err(fault(ModelFault::Missing { element: "include".into(), needed: "`file`" }));
        };
        let folder = stack.last().and_then(|p| p.parent()).unwrap_or(Path::new(""));
        let path = folder.join(name);
        if !path.is_file() {
            return Err(fault(ModelFault::IncludeMissing { path }));
        }
        let id = identity(&path);
        if let Some(at) = stack.iter().position(|p| identity(p) == id) {
            let chain = stack[at..].iter().chain([&path]).map(|p| p.display().to_string()).collect();
            return Err(fault(ModelFault::IncludeLoop { chain }));
        }
        if seen.contains(&id) {
            return Err(fault(ModelFault::IncludeTwice { path }));
        }
        seen.push(id);
        let mut root = xml::read(&path)?;
        stack.push(path);
        expand(&mut root, stack, seen)?;
        stack.pop();
        children.append(&mut root.children);
    }
    element.children = children;
    Ok(())
}
