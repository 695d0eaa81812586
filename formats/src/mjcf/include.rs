//! `<include file="…"/>`: replaced by the children of the named file's root.
//!
//! In: the main file. Out: one tree, every element with the place in its own file. A name is
//! looked for beside the main file, then beside the file it stands in; a file can be included once, and
//! not in a circle.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use crate::limits::{ELEMENTS, INCLUDES};
use crate::model_file::{ModelFault, ModelFileError};
use crate::vocabulary;
use crate::xml::{self, Element, MAX_DEPTH};

/// The main file with all includes expanded.
pub fn read(path: &Path, mut root: Element) -> Result<Element, ModelFileError> {
    let id = identity(path);
    let mut files = Files {
        main: path.to_path_buf(),
        stack: vec![(path.to_path_buf(), id.clone())],
        seen: HashSet::from([id]),
        elements: 0,
    };
    root.children = files.expanded(std::mem::take(&mut root.children), 0)?;
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

/// Files while they are included.
struct Files {
    main: PathBuf,
    /// Files that are open, as named and as they are, the main file first.
    stack: Vec<(PathBuf, PathBuf)>,
    seen: HashSet<PathBuf>,
    /// Elements so far.
    elements: usize,
}

impl Files {
    fn expanded(&mut self, children: Vec<Element>, depth: usize) -> Result<Vec<Element>, ModelFileError> {
        let mut out = Vec::with_capacity(children.len());
        self.expand(children, depth, &mut out)?;
        Ok(out)
    }

    /// Appends elements, those of included files in the place of their `<include>`.
    fn expand(
        &mut self,
        children: Vec<Element>,
        depth: usize,
        out: &mut Vec<Element>,
    ) -> Result<(), ModelFileError> {
        for mut child in children {
            let at = |fault| Err(ModelFileError::Model { fault, place: child.place.clone() });
            if depth > MAX_DEPTH {
                return at(ModelFault::TooDeep { limit: MAX_DEPTH });
            }
            self.elements += 1;
            if self.elements > ELEMENTS {
                return at(ModelFault::TooMany {
                    what: "elements in the file and all it includes",
                    limit: ELEMENTS,
                });
            }
            if child.name == "include" {
                let root = self.included(&child)?;
                self.expand(root.children, depth, out)?;
                self.stack.pop();
            } else {
                child.children = self.expanded(std::mem::take(&mut child.children), depth + 1)?;
                out.push(child);
            }
        }
        Ok(())
    }

    /// The root of the file that an `<include>` names, which is now the last of the stack.
    fn included(&mut self, include: &Element) -> Result<Element, ModelFileError> {
        let fault = |fault| ModelFileError::Model { fault, place: include.place.clone() };
        if let Some(other) = include.attributes.iter().find(|a| a.name != "file") {
            let (attribute, element) = (other.name.clone(), "include".to_owned());
            let fault = ModelFault::UnknownAttribute { attribute, element, allowed: vec!["file"] };
            return Err(ModelFileError::Model { fault, place: other.place.clone() });
        }
        let Some(name) = include.value("file") else {
            return Err(fault(ModelFault::Missing { element: "include".into(), needed: "`file`" }));
        };
        let Some(path) = find(&self.main, &include.place.file, Path::new(name)) else {
            let path = self.main.parent().unwrap_or(Path::new("")).join(name);
            return Err(fault(ModelFault::IncludeMissing { path }));
        };
        let id = identity(&path);
        if !self.seen.insert(id.clone()) {
            let Some(at) = self.stack.iter().position(|(_, open)| *open == id) else {
                return Err(fault(ModelFault::IncludeTwice { path }));
            };
            let chain = self.stack[at..].iter().map(|(named, _)| named).chain([&path]);
            let chain = chain.map(|p| p.display().to_string()).collect();
            return Err(fault(ModelFault::IncludeLoop { chain }));
        }
        if self.seen.len() > INCLUDES {
            return Err(fault(ModelFault::TooMany { what: "included files", limit: INCLUDES }));
        }
        let root = xml::read(&path)?;
        vocabulary::text(&root, &mut Vec::new())?;
        self.stack.push((path, id));
        Ok(root)
    }
}
