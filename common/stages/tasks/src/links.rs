//! Links of tasks with elements and spaces.

use crate::effect::Effect;
use messages::Site;

/// What a task works on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Target {
    /// An element of the site, by index.
    Element(u32),
    /// A space of the site, by index.
    Space(u32),
}

/// What made a link.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum LinkOrigin {
    /// A row of the table of links, by its line.
    Table(u64),
    /// A rule, by its index.
    Rule(usize),
}

/// A task works on an element or a space.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Link {
    /// Index of the task, over all files.
    pub task: usize,
    /// What it works on.
    pub target: Target,
    /// What it does there.
    pub effect: Effect,
    /// What says so.
    pub origin: LinkOrigin,
}

/// Links of all tasks, and what could not be linked.
#[derive(Debug, Clone, Default)]
pub struct Links {
    /// By task, then by target.
    pub links: Vec<Link>,
    /// Rows of the table that name no task or no target of the site: their lines, and why.
    pub unmatched_rows: Vec<(u64, String)>,
    /// Tasks whose effect no word tells, with the rule: they work in the spaces of their elements only.
    pub untold_effects: Vec<(usize, usize)>,
}

/// Elements, then spaces.
pub(crate) fn targets(site: &Site<'_>) -> impl Iterator<Item = Target> {
    let elements = (0..site.elements.len() as u32).map(Target::Element);
    elements.chain((0..site.spaces.len() as u32).map(Target::Space))
}
