//! Names of output files: relative, with `/`, inside the folder.

use super::error::FolderError;

/// How names of our own bookkeeping begin.
pub(super) const RESERVED: &str = ".contrapposto";
/// The file that is moved into place last: where it is new, everything is.
pub(super) const REPORT: &str = "report.json";

/// Refuses a name that does not stay in the folder, or that is not the same on every system.
pub(super) fn check(name: &str) -> Result<(), FolderError> {
    let refuse = |why| Err(FolderError::Name { name: name.chars().take(200).collect(), why });
    if name.is_empty() {
        return refuse("it is empty");
    }
    if name.chars().any(|c| c == '\0' || c == '\\' || c == ':') {
        return refuse("it has a NUL, a backslash or a colon");
    }
    if name.starts_with('/') {
        return refuse("it is absolute");
    }
    for part in name.split('/') {
        if part == ".." {
            return refuse("`..` leaves the folder");
        }
        if part.is_empty() || part == "." {
            return refuse("a part of it is empty or `.`");
        }
        let reserved = part.get(..RESERVED.len()).is_some_and(|s| s.eq_ignore_ascii_case(RESERVED));
        if reserved {
            return refuse(
                "names that begin with `.contrapposto` are kept for the manifest and temporary files",
            );
        }
    }
    Ok(())
}

/// Folders that a file is in, outermost first.
pub(super) fn folders(name: &str) -> impl Iterator<Item = &str> {
    name.match_indices('/').map(|(at, _)| &name[..at])
}

/// Order of moving into place: reports last, the folder's own after those of its parts.
pub(super) fn order(name: &str) -> (bool, bool, &str) {
    let is_report = name.rsplit('/').next() == Some(REPORT);
    (is_report, is_report && !name.contains('/'), name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stay_in_the_folder() {
        for good in ["a", "plots/motion.svg", "span_1/plots/a b.svg", "..a", "ü.bvh"] {
            check(good).unwrap();
        }
        let bad = ["", "..", "../a", "a/../b", "/a", "a//b", "a/", "./a", "a\\b", "C:a", "a\0b"];
        for name in
            bad.into_iter().chain([".contrapposto.json", ".Contrapposto-1-2.tmp", "a/.contrapposto.lock"])
        {
            let e = check(name).unwrap_err();
            assert!(matches!(e, FolderError::Name { .. }) && e.is_input(), "{name}");
        }
    }

    #[test]
    fn the_report_comes_last() {
        let mut names = ["report.json", "a", "span_1/report.json", "z/a"];
        names.sort_by_key(|n| order(n));
        assert_eq!(names, ["a", "z/a", "span_1/report.json", "report.json"]);
        assert_eq!(folders("a/b/c").collect::<Vec<_>>(), ["a", "a/b"]);
    }
}
