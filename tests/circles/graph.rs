//! Circles in a graph of modules.

use std::collections::{BTreeMap, BTreeSet};

use super::source::ModulePath;

/// Sets of modules that import one another in a circle, but for circles through a module of whom all others in it are children,
/// grandchildren and so on.
pub fn circles(imports: &BTreeMap<ModulePath, BTreeSet<ModulePath>>) -> Vec<Vec<ModulePath>> {
    let mut found = Vec::new();
    circles_in(imports, &imports.keys().collect(), &mut found);
    found
}

fn circles_in<'a>(
    imports: &'a BTreeMap<ModulePath, BTreeSet<ModulePath>>,
    among: &BTreeSet<&'a ModulePath>,
    found: &mut Vec<Vec<ModulePath>>,
) {
    let reach: BTreeMap<&ModulePath, BTreeSet<&ModulePath>> =
        among.iter().map(|m| (*m, reached(imports, among, m))).collect();
    let mut left = among.clone();
    while let Some(&first) = left.iter().next() {
        let mut knot: BTreeSet<&ModulePath> =
            left.iter().copied().filter(|m| reach[first].contains(m) && reach[m].contains(first)).collect();
        left.remove(first);
        left.retain(|m| !knot.contains(m));
        if knot.len() < 2 {
            continue;
        }
        match knot.iter().copied().find(|parent| knot.iter().all(|m| m.starts_with(parent))) {
            Some(parent) => {
                knot.remove(parent);
                circles_in(imports, &knot, found);
            }
            None => found.push(knot.into_iter().cloned().collect()),
        }
    }
}

/// The modules that `from` imports, directly or through others of `among`.
fn reached<'a>(
    imports: &'a BTreeMap<ModulePath, BTreeSet<ModulePath>>,
    among: &BTreeSet<&'a ModulePath>,
    from: &ModulePath,
) -> BTreeSet<&'a ModulePath> {
    let mut reached = BTreeSet::new();
    let mut open = vec![from];
    while let Some(module) = open.pop() {
        for next in imports[module].iter().filter(|m| among.contains(m)) {
            if reached.insert(next) {
                open.push(next);
            }
        }
    }
    reached
}
