//! What the files of a crate import from one another.
//!
//! In: the `src` folder of a crate. Out: its modules, each with the modules that it names in `use` declarations and in paths
//! (`crate::…`, `super::…`, `self::…`, `child::…`). A name that a module only hands on (`pub use`) counts as an import from the file
//! that defines it. What is compiled for tests alone does not count.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// The path of a module below its crate: `results::report` is `["results", "report"]`.
pub type ModulePath = Vec<String>;

/// A path as it is written: `super::report::Report`.
type Written = Vec<String>;

/// One file.
#[derive(Debug, Default)]
struct Source {
    /// Tokens: names, and punctuation one character each but for `::`.
    tokens: Vec<String>,
    /// Names that `use` declarations bind, and the paths they stand for; `*` for all of a module.
    uses: Vec<(String, Written)>,
    /// Paths in the code.
    paths: Vec<Written>,
}

/// The modules of a crate and what each imports.
pub fn imports(src: &Path) -> BTreeMap<ModulePath, BTreeSet<ModulePath>> {
    let mut files = BTreeMap::new();
    read_folder(src, &mut Vec::new(), &mut files);
    let tested: BTreeSet<ModulePath> =
        files.iter_mut().flat_map(|(module, source)| for_tests(module, source)).collect();
    files.retain(|module, _| !(1..=module.len()).any(|n| tested.contains(&module[..n])));
    let modules: BTreeSet<ModulePath> = files.keys().cloned().collect();
    for (module, source) in &mut files {
        let children = modules.iter().filter(|m| m.len() == module.len() + 1 && m.starts_with(module));
        let children: Vec<&str> = children.map(|m| m[module.len()].as_str()).collect();
        read_paths(source, &children);
    }
    let found = files.iter().map(|(module, source)| {
        let all = source.uses.iter().map(|(_, path)| path).chain(&source.paths);
        let mut to: BTreeSet<ModulePath> =
            all.flat_map(|path| definers(&files, module, path, &mut BTreeSet::new())).collect();
        to.remove(module);
        (module.clone(), to)
    });
    found.collect()
}

fn read_folder(folder: &Path, at: &mut ModulePath, files: &mut BTreeMap<ModulePath, Source>) {
    for entry in std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display())) {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
        if path.is_dir() {
            at.push(name);
            read_folder(&path, at, files);
            at.pop();
        } else if path.extension().is_some_and(|e| e == "rs") {
            let mut module = at.clone();
            if !["mod", "lib", "main"].contains(&name.as_str()) {
                module.push(name);
            }
            let tokens = tokens(&std::fs::read_to_string(&path).unwrap());
            files.insert(module, Source { tokens, ..Source::default() });
        }
    }
}

/// Names and punctuation of a text, without comments, text and numbers.
fn tokens(text: &str) -> Vec<String> {
    let (c, mut i) = (text.chars().collect::<Vec<char>>(), 0);
    let at = |i: usize| c.get(i).copied().unwrap_or('\0');
    let mut tokens: Vec<String> = Vec::new();
    while i < c.len() {
        match c[i] {
            '/' if at(i + 1) == '/' => {
                while i < c.len() && c[i] != '\n' {
                    i += 1;
                }
            }
            '/' if at(i + 1) == '*' => {
                let mut depth = 0;
                loop {
                    match (at(i), at(i + 1)) {
                        ('/', '*') => (depth, i) = (depth + 1, i + 2),
                        ('*', '/') => (depth, i) = (depth - 1, i + 2),
                        _ => i += 1,
                    }
                    if depth == 0 || i >= c.len() {
                        break;
                    }
                }
            }
            '"' => i = after_text(&c, i),
            'r' if at(i + 1) == '"' || (at(i + 1) == '#' && (at(i + 2) == '#' || at(i + 2) == '"')) => {
                i = after_raw_text(&c, i + 1);
            }
            // a character, or the name of a lifetime
            '\'' if at(i + 1) == '\\' => {
                i = (i + 3..c.len()).find(|&k| c[k] == '\'').map_or(c.len(), |k| k + 1)
            }
            '\'' if at(i + 2) == '\'' => i += 3,
            x if x.is_alphanumeric() || x == '_' => {
                let end = (i..c.len()).find(|&k| !(c[k].is_alphanumeric() || c[k] == '_')).unwrap_or(c.len());
                tokens.push(c[i..end].iter().collect());
                i = end;
            }
            ':' if at(i + 1) == ':' => {
                tokens.push("::".into());
                i += 2;
            }
            x => {
                if !x.is_whitespace() {
                    tokens.push(x.into());
                }
                i += 1;
            }
        }
    }
    tokens
}

/// Where a text in quotation marks that begins at `i` is over.
fn after_text(c: &[char], i: usize) -> usize {
    let mut k = i + 1;
    while k < c.len() && c[k] != '"' {
        k += if c[k] == '\\' { 2 } else { 1 };
    }
    k + 1
}

/// Where a raw text, whose first `#` or quotation mark is at `i`, is over.
fn after_raw_text(c: &[char], i: usize) -> usize {
    let hashes = c[i..].iter().take_while(|x| **x == '#').count();
    let ends =
        |k: &usize| c[*k] == '"' && c[k + 1..].iter().take(hashes).filter(|x| **x == '#').count() == hashes;
    (i + hashes + 1..c.len()).find(ends).map_or(c.len(), |k| k + 1 + hashes)
}

/// Removes what is compiled for tests alone; gives the modules of such files.
fn for_tests(module: &ModulePath, source: &mut Source) -> Vec<ModulePath> {
    let (mut kept, mut files) = (Vec::new(), Vec::new());
    let t = &source.tokens;
    let mut i = 0;
    while i < t.len() {
        let end = after_attribute(t, i);
        let attribute = &t[i..end];
        let has = |word: &str| attribute.iter().any(|x| x == word);
        if !(has("cfg") && has("test") && !has("not")) {
            kept.extend_from_slice(if end > i { attribute } else { &t[i..=i] });
            i = end.max(i + 1);
            continue;
        }
        let mut item = end;
        while after_attribute(t, item) > item {
            item = after_attribute(t, item);
        }
        let body = (item..t.len()).find(|&k| t[k] == ";" || t[k] == "{").unwrap_or(t.len());
        if t.get(body).is_some_and(|x| x == ";") && t[item..body].iter().any(|x| x == "mod") {
            files.push([module.as_slice(), &[t[body - 1].clone()]].concat());
        }
        i = after_group(t, body);
    }
    source.tokens = kept;
    files
}

/// Where the attribute that begins at `i` is over; `i` if there is none.
fn after_attribute(t: &[String], i: usize) -> usize {
    let opens = t.get(i).is_some_and(|x| x == "#") && t.get(i + 1).is_some_and(|x| x == "[");
    if opens { after_group(t, i + 1) } else { i }
}

/// Behind the bracket that closes the one at `i`; behind `i` if it is none.
fn after_group(t: &[String], i: usize) -> usize {
    let mut depth = 0;
    for (k, token) in t.iter().enumerate().skip(i) {
        match token.as_str() {
            "{" | "[" | "(" => depth += 1,
            "}" | "]" | ")" => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return k + 1;
        }
    }
    t.len()
}

/// Reads the `use` declarations and the paths of a file.
fn read_paths(source: &mut Source, children: &[&str]) {
    let t = std::mem::take(&mut source.tokens);
    let mut inner: Vec<usize> = Vec::new(); // ends of modules written inside the file
    let mut i = 0;
    while i < t.len() {
        inner.retain(|end| i < *end);
        let next = |k: usize| t.get(i + k).map_or("", String::as_str);
        // inside a module that is written in the file `super` is the file
        let levels = inner.len();
        if t[i] == "mod" && next(2) == "{" {
            inner.push(after_group(&t, i + 2));
        } else if t[i] == "use" {
            let end = (i..t.len()).find(|&k| t[k] == ";").unwrap_or(t.len());
            let mut found = Vec::new();
            use_tree(&t[i + 1..end], &[], &mut found);
            source.uses.extend(found.into_iter().map(|(name, path)| (name, raised(path, levels))));
            i = end;
        } else if next(1) == "::"
            && (i == 0 || t[i - 1] != "::")
            && (["crate", "super", "self"].contains(&t[i].as_str()) || children.contains(&t[i].as_str()))
        {
            let mut path = vec![t[i].clone()];
            while next(1 + 2 * (path.len() - 1)) == "::" {
                path.push(next(2 * path.len()).to_owned());
            }
            source.paths.push(raised(path, levels));
        }
        i += 1;
    }
    source.tokens = t;
}

/// A path without its first `levels` times `super`.
fn raised(path: Written, levels: usize) -> Written {
    let supers = path.iter().take(levels).take_while(|x| *x == "super").count();
    if supers == 0 { path } else { [&["self".to_owned()], &path[supers..]].concat() }
}

/// The names that a tree of `use` binds.
fn use_tree(t: &[String], before: &[String], found: &mut Vec<(String, Written)>) {
    let mut path = before.to_vec();
    let mut i = 0;
    while i < t.len() {
        match t[i].as_str() {
            "::" => {}
            "{" => {
                let (mut from, mut k) = (i + 1, i + 1);
                let end = after_group(t, i) - 1;
                while k <= end {
                    if k == end || t[k] == "," {
                        if from < k {
                            use_tree(&t[from..k], &path, found);
                        }
                        from = k + 1;
                    }
                    k = if t[k] == "{" { after_group(t, k) } else { k + 1 };
                }
                return;
            }
            "self" if !path.is_empty() => {}
            "as" => {
                found.push((t[i + 1].clone(), path));
                return;
            }
            name => path.push(name.to_owned()),
        }
        i += 1;
    }
    if let Some(name) = path.last().cloned() {
        found.push((name, path));
    }
}

/// The modules in which a path that `module` writes is defined; none if that is another crate.
fn definers(
    files: &BTreeMap<ModulePath, Source>,
    module: &ModulePath,
    path: &Written,
    seen: &mut BTreeSet<(ModulePath, Written)>,
) -> Vec<ModulePath> {
    if !seen.insert((module.clone(), path.clone())) {
        return Vec::new();
    }
    let child = |at: &ModulePath, name: &String| {
        let child = [at.as_slice(), std::slice::from_ref(name)].concat();
        files.contains_key(&child).then_some(child)
    };
    let (mut at, mut i) = (module.clone(), 0);
    match path[0].as_str() {
        "crate" => (at, i) = (Vec::new(), 1),
        "self" => i = 1,
        "super" => {}
        // a child or a name in scope, else another crate
        first if child(module, &path[0]).is_none() && !binds(files, module, first) => return Vec::new(),
        _ => {}
    }
    while path.get(i).is_some_and(|x| x == "super") {
        at.pop();
        i += 1;
    }
    while let Some(next) = path.get(i).and_then(|name| child(&at, name)) {
        at = next;
        i += 1;
    }
    let Some(name) = path.get(i).filter(|name| *name != "*") else { return vec![at] };
    let Some(source) = files.get(&at) else { return Vec::new() };
    // defined here, or handed on from elsewhere
    let by_name = source.uses.iter().filter(|(bound, _)| bound == name).map(|(_, path)| path);
    let handed: Vec<&Written> = by_name.collect();
    if at == *module && handed.contains(&path) {
        return Vec::new();
    }
    if !handed.is_empty() {
        return handed.into_iter().flat_map(|path| definers(files, &at, path, seen)).collect();
    }
    let globs = source.uses.iter().filter(|(bound, _)| bound == "*").map(|(_, path)| path);
    let globs: Vec<ModulePath> = globs.flat_map(|path| definers(files, &at, path, seen)).collect();
    let defines = |m: &ModulePath| files.get(m).is_some_and(|s| defines(s, name));
    match globs.into_iter().find(|m| defines(m)) {
        Some(module) if !defines(&at) => vec![module],
        _ => vec![at],
    }
}

fn binds(files: &BTreeMap<ModulePath, Source>, module: &ModulePath, name: &str) -> bool {
    files[module].uses.iter().any(|(bound, path)| bound == name && path[0] != name)
}

fn defines(source: &Source, name: &str) -> bool {
    const KINDS: [&str; 9] = ["struct", "enum", "trait", "type", "fn", "const", "static", "mod", "union"];
    source.tokens.windows(2).any(|w| KINDS.contains(&w[0].as_str()) && w[1] == name)
}
