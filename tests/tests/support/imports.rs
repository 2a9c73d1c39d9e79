//! Imports between the modules of a crate, read from its source without compiling it.
//!
//! An import is a path of production code, in a `use` or elsewhere, that begins with `crate`, `self`, `super`, a child module
//! or an imported module. What a module re-exports counts for the module that owns it, and a module may re-export its
//! children. Items behind `#[cfg(test)]` are left out.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Segments of a path; that of a module in its crate is empty for the crate itself.
pub(crate) type Segments = Vec<String>;

/// Modules, with the modules that each imports from and the names that it takes from there.
pub(crate) type Imports = BTreeMap<Segments, BTreeMap<Segments, BTreeSet<String>>>;

/// The text of every module of a crate, from its folder `src`. `main.rs` is the crate itself where there is no `lib.rs`.
pub(crate) fn modules(src: &Path) -> BTreeMap<Segments, String> {
    let mut found = BTreeMap::new();
    let mut folders = vec![src.to_owned()];
    let has_lib = src.join("lib.rs").exists();
    while let Some(folder) = folders.pop() {
        for path in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let relative = path.strip_prefix(src).unwrap().with_extension("");
                let mut module: Segments = relative.iter().map(|part| part.to_string_lossy().into_owned()).collect();
                let is_root = module == ["lib"] || module == ["main"] && !has_lib;
                if is_root || module.last().is_some_and(|name| name == "mod") {
                    module.pop();
                }
                found.insert(module, std::fs::read_to_string(&path).unwrap());
            }
        }
    }
    found
}

/// The imports between modules with these texts.
pub(crate) fn imports(modules: &BTreeMap<Segments, String>) -> Imports {
    let sources: BTreeMap<&Segments, Source> = modules.iter().map(|(m, text)| (m, Source::of(text))).collect();
    let resolve = |module: &Segments, path: &[String]| resolved(modules, module, path);
    let owner = |path: Segments| owner(&sources, &resolve, path);
    let mut imports = Imports::new();
    for (&module, source) in &sources {
        let mut add = |path: Segments| {
            let (from, name) = owner(path);
            if from != *module {
                let names = imports.entry(module.clone()).or_default().entry(from).or_default();
                names.insert(if name.is_empty() { "(module)".to_owned() } else { name.join("::") });
            }
        };
        for import in &source.uses {
            let path = resolve(module, &import.path);
            if let Some(path) = path.filter(|path| !(import.is_public && path.starts_with(module))) {
                add(path);
            }
        }
        for path in &source.paths {
            let imported = source.uses.iter().filter(|u| u.name == path[0]).find_map(|u| resolve(module, &u.path));
            let imported = imported.filter(|module| modules.contains_key(module));
            let imported = imported.map(|module| [&module, &path[1..]].concat());
            if let Some(path) = resolve(module, path).or(imported) {
                add(path);
            }
        }
    }
    imports
}

/// The imports of modules that import each other, directly or through others; each as a phrase.
pub(crate) fn circles(imports: &Imports) -> Vec<String> {
    let reach = |from: &Segments| {
        let mut reached: BTreeSet<&Segments> = BTreeSet::new();
        let mut next: Vec<&Segments> = imports.get(from).into_iter().flat_map(BTreeMap::keys).collect();
        while let Some(module) = next.pop() {
            if reached.insert(module) {
                next.extend(imports.get(module).into_iter().flat_map(BTreeMap::keys));
            }
        }
        reached
    };
    let name = |module: &Segments| if module.is_empty() { "lib".to_owned() } else { module.join("::") };
    let mut found = Vec::new();
    for (from, all) in imports {
        for (to, names) in all.iter().filter(|(to, _)| reach(to).contains(from)) {
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            found.push(format!("{} names {} of {}", name(from), names.join(", "), name(to)));
        }
    }
    found
}

/// What a file names outside of its tests: every path of its imports, and every other path.
pub(crate) fn named_paths(text: &str) -> impl Iterator<Item = Segments> {
    let Source { uses, paths } = Source::of(text);
    uses.into_iter().map(|import| import.path).chain(paths)
}

/// The words of all names in a text, each name split into its words in lower case; no comments and texts.
pub(crate) fn names(text: &str) -> impl Iterator<Item = Vec<String>> {
    tokens(text).into_iter().filter(|token| is_word(token)).map(words)
}

/// The words of a name like `mission_plan` or `MissionPlan`.
fn words(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut last_is_upper = true;
    for c in name.chars() {
        if c == '_' || c.is_uppercase() && !last_is_upper {
            words.push(String::new());
        }
        last_is_upper = c.is_uppercase();
        words.last_mut().expect("there is a word").extend(c.to_lowercase().filter(|c| *c != '_'));
    }
    words
}

/// A name that a `use` brings in.
struct Import {
    path: Segments,
    name: String,
    is_public: bool,
}

/// Imports of a file, and its other paths.
struct Source {
    uses: Vec<Import>,
    paths: Vec<Segments>,
}

impl Source {
    fn of(text: &str) -> Self {
        let tokens = without_tests(&tokens(text));
        let (mut uses, mut paths) = (Vec::new(), Vec::new());
        let mut at = 0;
        while at < tokens.len() {
            let rest = &tokens[at..];
            if rest[0] == "use" && rest.get(1) != Some(&"<") {
                let end = rest.iter().position(|t| *t == ";").unwrap_or(rest.len());
                let first = uses.len();
                expand(&rest[1..end], &[], &mut uses);
                uses[first..].iter_mut().for_each(|import| import.is_public = is_public(&tokens[..at]));
                at += end;
            } else if is_word(rest[0]) && !at.checked_sub(1).is_some_and(|before| ["::", "."].contains(&tokens[before]))
            {
                let mut path = vec![rest[0].to_owned()];
                while let [_, "::", word, ..] = &tokens[at..]
                    && is_word(word)
                {
                    path.push((*word).to_owned());
                    at += 2;
                }
                paths.extend(Some(path).filter(|path| path.len() > 1));
            }
            at += 1;
        }
        Self { uses, paths }
    }
}

/// True if the item behind these tokens is `pub`, in any scope.
fn is_public(before: &[&str]) -> bool {
    match before {
        [.., "pub"] => true,
        [.., ")"] => before.iter().rposition(|t| *t == "(").is_some_and(|open| before[..open].ends_with(&["pub"])),
        _ => false,
    }
}

/// The paths of a tree of imports, `a::{b, c as d}`.
fn expand(tree: &[&str], prefix: &[String], uses: &mut Vec<Import>) {
    let mut depth = 0;
    let is_comma = |token: &&str| {
        depth += i32::from(*token == "{") - i32::from(*token == "}");
        *token == "," && depth == 0
    };
    for branch in tree.split(is_comma).filter(|branch| !branch.is_empty()) {
        let words = |tokens: &[&str]| tokens.iter().filter(|t| **t != "::").map(|t| (*t).to_owned()).collect();
        let (path, alias) = match branch.iter().position(|t| ["{", "as"].contains(t)) {
            Some(at) if branch[at] == "{" => {
                let prefix = [prefix.to_vec(), words(&branch[..at])].concat();
                expand(&branch[at + 1..branch.len() - 1], &prefix, uses);
                continue;
            }
            Some(at) => (words(&branch[..at]), branch.last()),
            // A path from the root of all crates is none of this one.
            None if branch[0] == "::" => (vec![String::new()], None),
            None => (words(branch), None),
        };
        let mut path: Segments = [prefix.to_vec(), path].concat();
        if path.len() > 1 && path.last().is_some_and(|last| last == "self") {
            path.pop();
        }
        let name = alias.map_or_else(|| path[path.len() - 1].clone(), |alias| (*alias).to_owned());
        uses.push(Import { path, name, is_public: false });
    }
}

/// The path in the crate of what a module names; `None` for another crate's.
fn resolved(modules: &BTreeMap<Segments, String>, module: &Segments, path: &[String]) -> Option<Segments> {
    let n_up = path.iter().take_while(|segment| *segment == "super").count();
    match path[0].as_str() {
        "crate" => Some(path[1..].to_vec()),
        "self" => Some([module, &path[1..]].concat()),
        "super" => Some([&module[..module.len().saturating_sub(n_up)], &path[n_up..]].concat()),
        child => {
            modules.contains_key(&[module.clone(), vec![child.to_owned()]].concat()).then(|| [module, path].concat())
        }
    }
}

/// The module that owns what lies at a path, and its path inside of it.
fn owner(
    sources: &BTreeMap<&Segments, Source>,
    resolve: &impl Fn(&Segments, &[String]) -> Option<Segments>,
    mut path: Segments,
) -> (Segments, Segments) {
    // As many re-exports of re-exports are a circle themselves.
    for _ in 0..10 {
        let at = (0..=path.len()).rev().find(|&at| sources.contains_key(&path[..at].to_vec())).unwrap_or(0);
        let (module, name) = (path[..at].to_vec(), path[at..].to_vec());
        let exported = name.first().and_then(|first| {
            let uses = sources.get(&module)?.uses.iter();
            uses.filter(|u| u.is_public && u.name == *first).find_map(|u| resolve(&module, &u.path))
        });
        let Some(exported) = exported else { return (module, name) };
        path = [exported, name[1..].to_vec()].concat();
    }
    (Vec::new(), path)
}

/// The tokens without the items behind `#[cfg(test)]`.
fn without_tests<'t>(tokens: &[&'t str]) -> Vec<&'t str> {
    let mut kept = Vec::new();
    let mut at = 0;
    while at < tokens.len() {
        if !tokens[at..].starts_with(&["#", "[", "cfg", "(", "test", ")", "]"]) {
            kept.push(tokens[at]);
            at += 1;
            continue;
        }
        while tokens.get(at) == Some(&"#") {
            at += end_of(&tokens[at..], &["]"]);
        }
        at += end_of(&tokens[at..], &[";", "}"]);
        at += usize::from(tokens.get(at) == Some(&";"));
    }
    kept
}

/// Number of tokens up to the first of `ends` outside of brackets, that one included.
fn end_of(tokens: &[&str], ends: &[&str]) -> usize {
    let mut depth = 0;
    let is_end = |token: &&str| {
        depth += i32::from(["(", "[", "{"].contains(token)) - i32::from([")", "]", "}"].contains(token));
        depth == 0 && ends.contains(token)
    };
    tokens.iter().position(is_end).map_or(tokens.len(), |at| at + 1)
}

fn is_word(token: &str) -> bool {
    token.starts_with(|c: char| c.is_alphabetic() || c == '_')
}

/// Words, `::` and single characters of a text; no comments, strings, characters and lifetimes.
fn tokens(text: &str) -> Vec<&str> {
    let mut found = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let n_word = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
        let skipped = string_length(rest).or_else(|| comment_length(rest)).or_else(|| quote_length(rest));
        let length = match skipped {
            Some(length) => length,
            None if n_word > 0 => n_word,
            None if rest.starts_with("::") => 2,
            None => first.len_utf8(),
        };
        if skipped.is_none() && !first.is_whitespace() {
            found.push(&rest[..length]);
        }
        rest = &rest[length..];
    }
    found
}

/// Length of the string that a text begins with, raw ones included.
fn string_length(text: &str) -> Option<usize> {
    let open = text.bytes().take(10).position(|byte| byte == b'"')?;
    let kind = text[..open].trim_end_matches('#');
    let n_hashes = open - kind.len();
    let end = match kind {
        "r" | "br" => format!("\"{}", "#".repeat(n_hashes)),
        "" | "b" | "c" if n_hashes == 0 => {
            let mut escaped = false;
            let closes = |c: char| {
                let closes = c == '"' && !escaped;
                escaped = c == '\\' && !escaped;
                closes
            };
            return Some(text[open + 1..].find(closes).map_or(text.len(), |at| open + at + 2));
        }
        _ => return None,
    };
    Some(text[open + 1..].find(&end).map_or(text.len(), |at| open + 1 + at + end.len()))
}

fn comment_length(text: &str) -> Option<usize> {
    let end = if text.starts_with("//") { "\n" } else { "*/" };
    let is_comment = text.starts_with("//") || text.starts_with("/*");
    is_comment.then(|| text.find(end).map_or(text.len(), |at| at + end.len()))
}

/// Length of the character or the lifetime that a text begins with.
fn quote_length(text: &str) -> Option<usize> {
    let inside = text.strip_prefix('\'')?;
    let first = inside.chars().next()?;
    if first == '\\' {
        return Some(inside[2..].find('\'').map_or(text.len(), |at| at + 4));
    }
    let is_character = inside[first.len_utf8()..].starts_with('\'');
    Some(if is_character { first.len_utf8() + 2 } else { 1 })
}
