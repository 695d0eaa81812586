//! `<include file="…"/>`: replaced by the children of the named file's root.
//!
//! In: the path of the main file. Out: one tree, every element with the place in its own file. A name is
//! looked for beside the main file, then beside the file it stands in; a file can be included once, and
//! not in a circle.

use std::path::{Path, PathBuf};

use crate::model_file::{ModelFault, ModelFileError};
use crate::xml::{self, Element, MAX_DEPTH};

/// The main file with all includes expanded.
pub fn read(path: &Path) -> Result<Element, ModelFileError> {
    let mut root = xml::read(path)?;
    if root.name != "mujoco" {
        let fault = ModelFault::Root { found: root.name, expected: "mujoco" };
        return Err(ModelFileError::Model { fault, place: root.place });
    }
    let mut seen = vec![identity(path)];
    let mut stack = vec![path.to_path_buf()];
    expand(&mut root, 0, &mut stack, &mut seen)?;
    Ok(root)
}

/// The file `name` beside the main file, or else beside the file `inside` that names it: MuJoCo's order.
pub fn find(main: &Path, inside: &Path, name: &Path) -> Option<PathBuf> {
    let beside = |file: &Path| file.parent().unwrap_or(Path::new("")).join(name);
    [beside(main), beside(inside)].into_iter().find(|path| path.is_file())
}

fn identity(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_path_buf())
}

fn expand(
    element: &mut Element,
    depth: usize,
    stack: &mut Vec<PathBuf>,
    seen: &mut Vec<PathBuf>,
) -> Result<(), ModelFileError> {
    if depth > MAX_DEPTH {
        let fault = ModelFault::TooDeep { limit: MAX_DEPTH };
        return Err(ModelFileError::Model { fault, place: element.place.clone() });
    }
    let mut children = Vec::with_capacity(element.children.len());
    for mut child in std::mem::take(&mut element.children) {
        if child.name != "include" {
            expand(&mut child, depth + 1, stack, seen)?;
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
        let Some(path) = find(&stack[0], &child.place.file, Path::new(name)) else {
            let path = stack[0].parent().unwrap_or(Path::new("")).join(name);
            return Err(fault(ModelFault::IncludeMissing { path }));
        };
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
        expand(&mut root, depth, stack, seen)?;
        stack.pop();
        children.append(&mut root.children);
    }
    element.children = children;
    Ok(())
}
