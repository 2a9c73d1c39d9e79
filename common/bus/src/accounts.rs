//! Names of users and groups of this machine, from its files; accounts that come from elsewhere are shown by their number.

use std::collections::BTreeMap;
use std::fs;

/// Names of the users of this machine, by their numbers: the first where several have one number.
pub fn names_of_users() -> BTreeMap<u32, String> {
    names_in(&fs::read_to_string("/etc/passwd").unwrap_or_default())
}

/// A user, for people.
pub(crate) fn user_text(uid: u32) -> String {
    match name_of("/etc/passwd", uid) {
        Some(name) => format!("user {name} (uid {uid})"),
        None => format!("uid {uid}"),
    }
}

/// A group, for people.
pub(crate) fn group_text(gid: u32) -> String {
    name_of("/etc/group", gid).unwrap_or_else(|| gid.to_string())
}

/// The number of a group that is given by name or number; `None` if there is no such group.
pub(crate) fn gid_of(group: &str) -> Option<u32> {
    group.parse().ok().or_else(|| gid_in(&fs::read_to_string("/etc/group").ok()?, group))
}

fn name_of(file: &str, number: u32) -> Option<String> {
    name_in(&fs::read_to_string(file).ok()?, number)
}

/// Name, password, number of each line.
fn entries(text: &str) -> impl Iterator<Item = (&str, u32)> {
    text.lines().filter_map(|line| {
        let mut fields = line.split(':');
        let (name, _, number) = (fields.next()?, fields.next()?, fields.next()?);
        Some((name, number.parse().ok()?))
    })
}

fn names_in(text: &str) -> BTreeMap<u32, String> {
    let mut names = BTreeMap::new();
    for (name, number) in entries(text) {
        names.entry(number).or_insert_with(|| name.to_owned());
    }
    names
}

fn name_in(text: &str, number: u32) -> Option<String> {
    entries(text).find(|entry| entry.1 == number).map(|entry| entry.0.to_owned())
}

fn gid_in(text: &str, name: &str) -> Option<u32> {
    entries(text).find(|entry| entry.0 == name).map(|entry| entry.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_has_its_first_name_wherever_it_is_looked_up() {
        let text = "root:x:0:0:root:/root:/bin/sh\ntoor:x:0:0::/root:/bin/sh\nalice:x:1000:1000::/home/alice:/bin/sh\n";
        let names = names_in(text);
        assert_eq!(names, BTreeMap::from([(0, "root".to_owned()), (1000, "alice".to_owned())]));
        assert!(names.iter().all(|(number, name)| name_in(text, *number).as_ref() == Some(name)));
        assert_eq!(names_of_users().get(&0).map(String::as_str), Some("root"));
    }

    #[test]
    fn names_and_numbers_are_found_among_lines_of_any_kind() {
        let text = "root:x:0:\n\n# nothing\nnoise\nbad:x:many:\ngroundplan:x:998:robot,operator\n";
        assert_eq!((name_in(text, 998).as_deref(), gid_in(text, "groundplan")), (Some("groundplan"), Some(998)));
        assert_eq!((name_in(text, 7), gid_in(text, "bad"), gid_in(text, "ground")), (None, None, None));
        assert_eq!((gid_of("4711"), user_text(0).as_str()), (Some(4711), "user root (uid 0)"));
    }
}
