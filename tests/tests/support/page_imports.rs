//! Imports between the JavaScript modules of the page, read from their text.
//!
//! An import is a path in quotes that begins with `./`, behind `from`, `import` or `import(`: one at the head of a module, a
//! re-export, or one that is made while the page runs. Lines of comments are left out.

use super::imports::Imports;
use std::collections::BTreeMap;
use std::path::Path;

/// The text of every module of a folder, by its file name.
pub(crate) fn page_modules(src: &Path) -> BTreeMap<String, String> {
    let paths = std::fs::read_dir(src).unwrap().map(|entry| entry.unwrap().path());
    let scripts = paths.filter(|path| path.extension().is_some_and(|extension| extension == "js"));
    let name = |path: &Path| path.file_name().unwrap().to_string_lossy().into_owned();
    scripts.map(|path| (name(&path), std::fs::read_to_string(&path).unwrap())).collect()
}

/// The imports between modules with these texts.
///
/// # Panics
/// If a module imports one that there is not.
pub(crate) fn page_imports(modules: &BTreeMap<String, String>) -> Imports {
    let mut imports = Imports::new();
    for (module, text) in modules {
        for (from, names) in imports_of(text) {
            assert!(modules.contains_key(&from), "{module} imports {from}, which there is not");
            let of_module = imports.entry(vec![module.clone()]).or_default().entry(vec![from]).or_default();
            of_module.extend(names);
        }
    }
    imports
}

/// The files that a module imports, with the names that it takes from each.
fn imports_of(text: &str) -> Vec<(String, Vec<String>)> {
    let is_comment = |line: &str| ["//", "*", "/*"].iter().any(|begin| line.trim_start().starts_with(begin));
    let code: String = text.lines().filter(|line| !is_comment(line)).flat_map(|line| [line, "\n"]).collect();
    let mut found = Vec::new();
    for quote in ['"', '\''] {
        for (at, open) in code.match_indices(&format!("{quote}./")) {
            let (before, behind) = (code[..at].trim_end(), &code[at + open.len()..]);
            let Some((file, _)) = behind.split_once(quote) else { continue };
            if let Some(names) = before.strip_suffix("from") {
                found.push((file.to_owned(), names_of(names)));
            } else if before.trim_end_matches(['(', ' ']).ends_with("import") {
                found.push((file.to_owned(), vec!["(module)".to_owned()]));
            }
        }
    }
    found
}

/// The names that the last `import` or `export` of a text lists.
fn names_of(text: &str) -> Vec<String> {
    let begin = ["import", "export"].iter().filter_map(|word| text.rfind(word)).max().unwrap_or(0) + "import".len();
    let names = text[begin..].split([',', '{', '}']).map(str::trim).filter(|name| !name.is_empty());
    names.map(|name| name.split(" as ").next().unwrap_or(name).to_owned()).collect()
}
