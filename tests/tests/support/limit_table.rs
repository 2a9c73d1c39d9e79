//! Reads `docs/limits.md`, and the constants that its rows name.

use std::path::Path;

/// A row of the page.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Limit {
    /// Path of the file, from the root.
    pub(crate) file: String,
    pub(crate) constant: String,
    pub(crate) value: u64,
}

/// Rows of the page; those that are none are a panic.
pub(crate) fn limits_of(page: &str) -> Vec<Limit> {
    let rows = page.lines().filter(|line| line.starts_with("| ") && !line.starts_with("| of | at most |"));
    rows.map(|row| read_row(row).unwrap_or_else(|| panic!("no row of a limit: {row}"))).collect()
}

fn read_row(row: &str) -> Option<Limit> {
    let [_, _, value, link, _] = row.split('|').map(str::trim).collect::<Vec<_>>().try_into().ok()?;
    let (constant, rest) = link.strip_prefix("[`")?.split_once("`](../")?;
    let file = rest.strip_suffix(')')?;
    Some(Limit { file: file.to_owned(), constant: constant.to_owned(), value: shown_value(value)? })
}

/// The value as people read it: `1,000`, `4 GiB`.
fn shown_value(text: &str) -> Option<u64> {
    let (number, unit) = text.split_once(' ').unwrap_or((text, "bytes"));
    let shift = ["bytes", "KiB", "MiB", "GiB"].iter().position(|known| *known == unit)? * 10;
    Some(number.replace(',', "").parse::<u64>().ok()? << shift)
}

/// Limits in bytes that a file declares, by their names: `MAX_..BYTES..`, `..BYTES.._MAX`.
pub(crate) fn limits_in_bytes(source: &str) -> impl Iterator<Item = &str> {
    let names = source.lines().filter_map(|line| line.split_once("const ")?.1.split_once(':').map(|(name, _)| name));
    names.filter(|name| (name.starts_with("MAX_") || name.ends_with("_MAX")) && name.contains("BYTES"))
}

/// The value of a constant as the source declares it: numbers, shifts, differences, the largest of a type.
pub(crate) fn declared_value(source: &str, constant: &str) -> Option<u64> {
    let declaration = source.split_once(&format!("const {constant}:"))?.1;
    let value = declaration.split_once('=')?.1.split_once(';')?.0.trim();
    let number = |text: &str| match text.trim().strip_suffix("::MAX as usize") {
        Some("u16") => Some(u64::from(u16::MAX)),
        _ => text.trim().replace('_', "").parse::<u64>().ok(),
    };
    if let Some((base, shift)) = value.split_once("<<") {
        return Some(number(base)? << number(shift)?);
    }
    match value.split_once(" - ") {
        Some((from, less)) => number(from)?.checked_sub(number(less)?),
        None => number(value),
    }
}

/// The source of a file without its tests.
pub(crate) fn product_source(path: &Path) -> String {
    let text = std::fs::read_to_string(path).unwrap_or_else(|why| panic!("{}: {why}", path.display()));
    text.split("#[cfg(test)]").next().unwrap_or_default().to_owned()
}
