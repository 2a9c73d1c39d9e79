//! Text of USD: prims with their attributes, names that it allows, numbers and lists.

use crate::meshes::number;
use std::collections::BTreeSet;

/// Text of a layer, an attribute or the head of a prim on a line.
pub(crate) struct Usda {
    pub(crate) out: String,
    depth: usize,
}

impl Usda {
    /// A layer whose default prim has this name: metres, Z up, kilograms.
    pub(crate) fn new(default_prim: &str) -> Self {
        let out = format!(
            "#usda 1.0\n(\n    defaultPrim = \"{default_prim}\"\n    kilogramsPerUnit = 1\n    metersPerUnit = 1\n    upAxis = \"Z\"\n)\n"
        );
        Self { out, depth: 0 }
    }

    pub(crate) fn line(&mut self, text: &str) {
        self.out.extend(std::iter::repeat_n("    ", self.depth));
        self.out.push_str(text);
        self.out.push('\n');
    }

    /// Begins a prim: `def Mesh`, its name, and what is in the brackets behind it, if anything is.
    pub(crate) fn open(&mut self, kind: &str, name: &str, metadata: &str) {
        let metadata = if metadata.is_empty() { String::new() } else { format!(" ({metadata})") };
        self.line(&format!("{kind} \"{name}\"{metadata}"));
        self.line("{");
        self.depth += 1;
    }

    /// Ends the innermost prim.
    pub(crate) fn close(&mut self) {
        self.depth -= 1;
        self.line("}");
    }

    /// A shift and a turn of the prim.
    pub(crate) fn pose(&mut self, shift_m: [f64; 3], yaw_rad: f64) {
        self.line(&format!("double3 xformOp:translate = {}", tuple(shift_m)));
        self.line(&format!("double xformOp:rotateZ = {}", number(yaw_rad.to_degrees())));
        self.line("uniform token[] xformOpOrder = [\"xformOp:translate\", \"xformOp:rotateZ\"]");
    }
}

/// Numbers in brackets.
pub(crate) fn tuple<const N: usize>(values: [f64; N]) -> String {
    format!("({})", values.map(number).join(", "))
}

/// A text with what USD reserves escaped.
pub(crate) fn quoted(text: &str) -> String {
    let plain = text.replace(char::is_control, " ").replace('\\', "\\\\").replace('"', "\\\"");
    format!("\"{plain}\"")
}

/// Names of the prims in one prim.
#[derive(Default)]
pub(crate) struct Names(BTreeSet<String>);

impl Names {
    /// The name with `_` for what no identifier has, and with a number behind it where that made two names one.
    pub(crate) fn take(&mut self, name: &str) -> String {
        let mut own = name.replace(|c: char| !c.is_ascii_alphanumeric(), "_");
        if own.starts_with(|c: char| c.is_ascii_digit()) {
            own.insert(0, '_');
        }
        let numbered = (2..).map(|k: usize| format!("{own}_{k}"));
        let free = std::iter::once(own.clone()).chain(numbered).find(|name| !self.0.contains(name));
        let free = free.expect("there are more numbers than names");
        self.0.insert(free.clone());
        free
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_identifiers_and_unique() {
        let mut names = Names::default();
        let of = ["wall_1$a", "wall_1_a", "00_wall", "wall_1_a_2", "Tür"].map(|name| names.take(name));
        assert_eq!(of, ["wall_1_a", "wall_1_a_2", "_00_wall", "wall_1_a_2_2", "T_r"]);
    }

    #[test]
    fn texts_stay_on_their_line() {
        assert_eq!(quoted("a \"b\"\n\\"), "\"a \\\"b\\\" \\\\\"");
    }
}
