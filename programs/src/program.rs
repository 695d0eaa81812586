//! A program: a text of the user, read and checked, with the parameters that a scene gives it.
//!
//! In: the text, the name of its file, arguments by name. Out: a [`Program`], or an error at the place in the text or at the
//! argument. A program is functions and nothing else; which of them there are says what it is:
//!
//! | function | called |
//! |---|---|
//! | `fn elements(script, params)` | once, as an edit of the elements of a script |
//! | `fn clip(clip, params)` | once, as an edit of a sampled motion |
//! | `fn react(body, params)` | every control step, as a reactive property; `this` is its memory |
//! | `fn memory()` | once before the first step: what `this` is then, a map |
//! | `fn params()` | once: a map of the parameters there are, with what they are if a scene does not say |

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use edits::Argument;
use motion::names::hint;
use rhai::debugger::{DebuggerCommand, DebuggerEvent};
use rhai::{AST, CallFnOptions, Dynamic, Engine, EvalAltResult, Map, Position, Scope, Stmt, Variant};

use crate::ProgramError;
use crate::engine::engine;
use crate::error::words;
use crate::limits::START_STEPS;

/// What a program may be asked to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Entry {
    /// To edit the elements of a script.
    Elements,
    /// To edit a clip.
    Clip,
    /// To react every step.
    React,
}

/// The name of programs in scenes and in the log.
pub(crate) const NAME: &str = "program";

impl Entry {
    /// Name of its function, and of the function's arguments.
    pub fn function(self) -> (&'static str, &'static [&'static str]) {
        match self {
            Self::Elements => ("elements", &["script", "params"]),
            Self::Clip => ("clip", &["clip", "params"]),
            Self::React => ("react", &["body", "params"]),
        }
    }
}

/// Functions that are called from outside, with their arguments.
const CALLED: [(&str, &[&str]); 5] = [
    ("elements", &["script", "params"]),
    ("clip", &["clip", "params"]),
    ("react", &["body", "params"]),
    ("memory", &[]),
    ("params", &[]),
];

/// A program with its parameters. See the module header.
#[derive(Clone, Debug)]
pub struct Program {
    file: PathBuf,
    text: String,
    ast: AST,
    params: Map,
    memory: Map,
}

impl Program {
    /// Reads a program and gives it its arguments.
    ///
    /// # Errors
    /// [`ProgramError::File`]: syntax, unknown variables, functions with other arguments than they are called with, code outside
    /// functions. [`ProgramError::Parameter`]: arguments that the program does not take, or of another kind.
    pub fn read(
        file: &Path,
        text: &str,
        arguments: &BTreeMap<String, Argument>,
    ) -> Result<Self, ProgramError> {
        let engine = engine(START_STEPS);
        let ast = engine.compile(text).map_err(|e| {
            let text = e.err_type().to_string();
            at(file, e.position(), text)
        })?;
        let mut program = Self {
            file: file.into(),
            text: text.into(),
            ast: ast.clone_functions_only(),
            params: Map::new(),
            memory: Map::new(),
        };
        program.check_outside(&ast)?;
        for (name, arguments) in CALLED {
            program.check_arguments(name, arguments)?;
        }
        program.params = program.plain_map(&engine, "params")?;
        program.memory = program.plain_map(&engine, "memory")?;
        for (name, given) in arguments {
            program.set(name, given)?;
        }
        Ok(program)
    }

    /// Its file.
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// Its text.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Its parameters, each with its value as text.
    pub fn parameters(&self) -> Vec<(String, String)> {
        self.params.iter().map(|(name, value)| (name.to_string(), value.to_string())).collect()
    }

    /// Whether it does this.
    pub fn does(&self, entry: Entry) -> bool {
        self.has(entry.function().0)
    }

    /// What it has to do to be asked for this.
    ///
    /// # Errors
    /// [`ProgramError::File`] if its function is not there.
    pub fn must(&self, entry: Entry) -> Result<(), ProgramError> {
        if self.does(entry) {
            return Ok(());
        }
        let (name, arguments) = entry.function();
        let has: Vec<&str> = self.ast.iter_functions().map(|f| f.name).collect();
        let has = if has.is_empty() { "none".into() } else { has.join(", ") };
        Err(self.at_line(
            1,
            1,
            format!("here the program needs `fn {name}({})`; its functions: {has}", arguments.join(", ")),
        ))
    }

    /// The memory before the first step.
    pub(crate) fn memory(&self) -> Map {
        self.memory.clone()
    }

    /// Calls the function of an entry with its first argument and the parameters.
    ///
    /// The language forgets where a program was when it is stopped. Then it is run once more, with what `again` gives and the
    /// memory as it was, watched statement by statement: what is the same ends at the same place.
    pub(crate) fn call<T: Variant + Clone>(
        &self,
        engine: &Engine,
        entry: Entry,
        this: Option<&mut Dynamic>,
        first: T,
        again: impl FnOnce() -> T,
    ) -> Result<(), ProgramError> {
        let before = this.as_deref().cloned();
        let Err(e) = self.run(engine, entry, this, first) else { return Ok(()) };
        let (message, mut place) = words(&e);
        if e.is_system_exception() {
            let last = Arc::new(Mutex::new(Position::NONE));
            let watched = watching(engine.max_operations(), last.clone());
            let mut memory = before.unwrap_or(Dynamic::UNIT);
            // it ends as before, which is known
            let _ = self.run(&watched, entry, Some(&mut memory), again());
            place = *last.lock().unwrap_or_else(PoisonError::into_inner);
        }
        Err(if place.is_none() {
            self.at_function(entry.function().0, message)
        } else {
            at(&self.file, place, message)
        })
    }

    fn run<T: Variant + Clone>(
        &self,
        engine: &Engine,
        entry: Entry,
        this: Option<&mut Dynamic>,
        first: T,
    ) -> Result<(), Box<EvalAltResult>> {
        let mut options = CallFnOptions::new().eval_ast(false);
        options.this_ptr = this;
        let arguments = (first, Dynamic::from_map(self.params.clone()));
        let name = entry.function().0;
        engine
            .call_fn_with_options::<Dynamic>(options, &mut Scope::new(), &self.ast, name, arguments)
            .map(drop)
    }

    /// What went wrong in a function, at its place in the file.
    fn fault(&self, e: &EvalAltResult, function: &str) -> ProgramError {
        let (message, place) = words(e);
        if place.is_none() { self.at_function(function, message) } else { at(&self.file, place, message) }
    }

    /// A fault of a function as a whole.
    pub(crate) fn at_function(&self, name: &str, message: impl Into<String>) -> ProgramError {
        let (line, column) = self.find_function(name);
        self.at_line(line, column, message.into())
    }

    fn at_line(&self, line: usize, column: usize, message: String) -> ProgramError {
        ProgramError::File { file: self.file.clone(), line, column, message }
    }

    fn has(&self, name: &str) -> bool {
        self.ast.iter_functions().any(|f| f.name == name)
    }

    /// Line and column of the first line that begins a function of this name.
    fn find_function(&self, name: &str) -> (usize, usize) {
        for (i, line) in self.text.lines().enumerate() {
            let Some(at) = line.find("fn ") else { continue };
            let rest = line[at + 3..].trim_start().strip_prefix(name);
            if rest.is_some_and(|r| !r.starts_with(|c: char| c.is_alphanumeric() || c == '_')) {
                return (i + 1, line[..at].chars().count() + 1);
            }
        }
        (1, 1)
    }

    /// Refuses what is outside functions: they would not see it.
    fn check_outside(&self, whole: &AST) -> Result<(), ProgramError> {
        match whole.statements().iter().find(|s| !matches!(s, Stmt::Noop(_))) {
            None => Ok(()),
            Some(outside) => Err(at(
                &self.file,
                outside.position(),
                "this is outside functions, where no function sees it; allowed: functions, and parameters in `fn params()`".into(),
            )),
        }
    }

    fn check_arguments(&self, name: &str, arguments: &[&str]) -> Result<(), ProgramError> {
        let wrong = self.ast.iter_functions().find(|f| f.name == name && f.params.len() != arguments.len());
        match wrong {
            None => Ok(()),
            Some(f) => Err(self.at_function(
                name,
                format!(
                    "`{name}` takes {} argument(s); allowed: `fn {name}({})`",
                    f.params.len(),
                    arguments.join(", ")
                ),
            )),
        }
    }

    /// The map that a function without arguments gives; empty if it is not there.
    fn plain_map(&self, engine: &Engine, name: &str) -> Result<Map, ProgramError> {
        if !self.has(name) {
            return Ok(Map::new());
        }
        let options = CallFnOptions::new().eval_ast(false);
        let given = engine
            .call_fn_with_options::<Dynamic>(options, &mut Scope::new(), &self.ast, name, ())
            .map_err(|e| self.fault(&e, name))?;
        let kind = given.type_name();
        let Some(map) = given.try_cast::<Map>() else {
            return Err(self.at_function(name, format!("`{name}` gives {kind}; allowed: a map, #{{ … }}")));
        };
        match map.iter().find(|(_, value)| !is_plain(value)) {
            None => Ok(map),
            Some((key, value)) => Err(self.at_function(
                name,
                format!(
                    "`{key}` is {}; allowed: numbers, texts, true or false, lists and maps of them",
                    value.type_name()
                ),
            )),
        }
    }

    fn set(&mut self, name: &str, given: &Argument) -> Result<(), ProgramError> {
        let fault = |message: String| Err(ProgramError::Parameter { name: name.into(), message });
        let Some(old) = self.params.get(name) else {
            let known: Vec<String> = self.params.keys().map(ToString::to_string).collect();
            let file = self.file.display();
            let near = hint(name, known.iter().map(String::as_str));
            let list = if known.is_empty() {
                "it takes none".into()
            } else {
                format!("it takes {}", known.join(", "))
            };
            return fault(format!("{file} has no parameter `{name}`{near}; {list}"));
        };
        let expected = |kind: &str| fault(format!("`{name}` takes {kind}; found {given}"));
        let new = match given {
            Argument::Number(x) if old.is_float() && x.is_finite() => Dynamic::from_float(*x),
            Argument::Number(x) if old.is_int() && x.fract() == 0.0 && x.abs() < 9.0e15 => {
                Dynamic::from_int(*x as i64)
            }
            Argument::Flag(b) if old.is_bool() => Dynamic::from_bool(*b),
            Argument::Text(text) if old.is_string() => text.clone().into(),
            Argument::List(items) if old.is_array() && items.iter().all(|x| x.is_finite()) => {
                Dynamic::from_array(items.iter().copied().map(Dynamic::from_float).collect())
            }
            Argument::Texts(items) if old.is_array() => {
                Dynamic::from_array(items.iter().map(|text| text.clone().into()).collect())
            }
            _ if old.is_float() => return expected("a finite number"),
            _ if old.is_int() => return expected("a whole number"),
            _ if old.is_bool() => return expected("true or false"),
            _ if old.is_string() => return expected("a text"),
            _ if old.is_array() => return expected("a list of finite numbers or of texts"),
            _ => return expected("nothing that a scene can say"),
        };
        self.params.insert(name.into(), new);
        Ok(())
    }
}

/// An engine that keeps the place of the last statement or expression.
#[expect(
    deprecated,
    reason = "it is not: its author marks what may change in a later release, and ours is fixed"
)]
fn watching(steps: u64, last: Arc<Mutex<Position>>) -> Engine {
    let mut watched = engine(steps);
    watched.register_debugger(
        |_, debugger| debugger,
        move |_, event, _, _, place| {
            if !place.is_none() && matches!(event, DebuggerEvent::Start | DebuggerEvent::Step) {
                *last.lock().unwrap_or_else(PoisonError::into_inner) = place;
            }
            Ok(DebuggerCommand::StepInto)
        },
    );
    watched
}

/// An error at a place.
fn at(file: &Path, place: Position, message: String) -> ProgramError {
    let (line, column) = (place.line().unwrap_or(1), place.position().unwrap_or(1));
    ProgramError::File { file: file.into(), line, column, message }
}

/// Whether a value is made of numbers, texts and truths: copied when it is cloned, and its own.
pub(crate) fn is_plain(value: &Dynamic) -> bool {
    if let Ok(list) = value.as_array_ref() {
        return list.iter().all(is_plain);
    }
    if let Ok(map) = value.as_map_ref() {
        return map.values().all(is_plain);
    }
    value.is_unit()
        || value.is_bool()
        || value.is_int()
        || value.is_float()
        || value.is_string()
        || value.is_char()
}
