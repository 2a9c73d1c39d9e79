//! Task effects on elements, and occupation of spaces by tasks.

use crate::rules::InputEffect;
use crate::tasks::{TaskDates, TaskKind, kind_of};
use messages::{DateSource, LinkKind, NONE, Site, link_flags};

/// A task or date constructs or removes an element from `start_s` until `finish_s`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Effect {
    pub(crate) start_s: i64,
    pub(crate) finish_s: i64,
    /// True if the element is removed, false if it is constructed.
    pub(crate) removes: bool,
    /// The task, or `NONE`.
    pub(crate) task: u32,
    pub(crate) source: DateSource,
}

/// A task occupies a space.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Occupation {
    pub(crate) start_s: i64,
    pub(crate) finish_s: i64,
    pub(crate) task: u32,
}

/// Effects by element, occupations by space; both sorted.
pub(crate) struct TaskEffects {
    pub(crate) elements: Vec<Vec<Effect>>,
    pub(crate) spaces: Vec<Vec<Occupation>>,
}

/// A link seen from its target.
#[derive(Clone, Copy)]
struct Link {
    task: u32,
    is_input: bool,
    from_above: bool,
    /// What the link says of its effect; `None`: the type of the task says it.
    effect: Option<LinkEffect>,
}

/// An effect that a link has, whatever the type of its task is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum LinkEffect {
    Builds,
    Removes,
    WorksIn,
    Uses,
}

/// Effects of all tasks that have dates, and the spaces that they occupy.
///
/// An element's own links win over those of its whole, these over those of the space or storey that holds it, these
/// over those of the building; the first that gives a date counts.
pub(crate) fn task_effects(site: &Site<'_>, dates: &[Option<TaskDates>], inputs: InputEffect) -> TaskEffects {
    let links = Links::of(site);
    let adjacent = AdjacentSpaces::of(site);
    let kinds: Vec<TaskKind> = (0..site.schedule.tasks.len()).map(|k| kind_of(site, k)).collect();
    let effects = |links: &[Link], from_above: bool| -> Vec<Effect> {
        let of_rank = links.iter().filter(|l| l.from_above == from_above);
        let of_link = |l: &Link| {
            let dates = dates[l.task as usize];
            dates.map(|dates| effects_of(l, dates, kinds[l.task as usize], inputs)).into_iter().flatten().flatten()
        };
        let mut effects: Vec<Effect> = of_rank.flat_map(of_link).collect();
        effects.sort_unstable();
        effects.dedup();
        effects
    };
    let elements = (0..site.elements.len()).map(|k| {
        let own = wholes(site, k).map(|w| effects(&links.elements[w], false)).find(|e| !e.is_empty());
        own.unwrap_or_else(|| {
            let inherited_links = links.inherited_links(site, k);
            let held = effects(&inherited_links, false);
            if held.is_empty() { effects(&inherited_links, true) } else { held }
        })
    });
    TaskEffects { elements: elements.collect(), spaces: occupations(site, dates, &links, &adjacent) }
}

/// What a link does with an element: one effect, none, or two, where the task only uses the element.
fn effects_of(link: &Link, dates: TaskDates, kind: TaskKind, inputs: InputEffect) -> [Option<Effect>; 2] {
    let TaskDates { start_s, finish_s, source } = dates;
    let effect =
        |[start_s, finish_s]: [i64; 2], removes| Some(Effect { start_s, finish_s, removes, task: link.task, source });
    match link.effect {
        Some(LinkEffect::Builds) => [effect([start_s, finish_s], false), None],
        Some(LinkEffect::Removes) => [effect([start_s, finish_s], true), None],
        Some(LinkEffect::WorksIn) => [None; 2],
        Some(LinkEffect::Uses) => [effect([start_s, start_s], false), effect([finish_s, finish_s], true)],
        None => [removes(kind, link.is_input, inputs).and_then(|removes| effect([start_s, finish_s], removes)), None],
    }
}

/// True if a task removes what it is linked to, false if it constructs it; `None` if it does neither.
fn removes(kind: TaskKind, is_input: bool, inputs: InputEffect) -> Option<bool> {
    match kind {
        TaskKind::Construct => Some(is_input && inputs == InputEffect::Consume),
        TaskKind::Remove => Some(true),
        TaskKind::Carry => Some(is_input),
        TaskKind::Other => None,
    }
}

fn occupations(
    site: &Site<'_>,
    dates: &[Option<TaskDates>],
    links: &Links,
    adjacent: &AdjacentSpaces,
) -> Vec<Vec<Occupation>> {
    let mut spaces: Vec<Vec<Occupation>> = vec![Vec::new(); site.spaces.len()];
    let mut occupy = |space: usize, link: &Link| {
        if let Some(d) = dates[link.task as usize].filter(|d| d.start_s < d.finish_s) {
            spaces[space].push(Occupation { start_s: d.start_s, finish_s: d.finish_s, task: link.task });
        }
    };
    for (k, space) in site.spaces.iter().enumerate() {
        links.spaces[k].iter().for_each(|l| occupy(k, l));
        if space.storey != NONE {
            links.storeys[space.storey as usize].iter().for_each(|l| occupy(k, l));
        }
    }
    for k in 0..site.elements.len() {
        let adjacent_spaces = &adjacent.spaces[k];
        if adjacent_spaces.is_empty() {
            continue;
        }
        let is_linked = wholes(site, k).any(|w| !links.elements[w].is_empty());
        let inherited_links = if is_linked { Vec::new() } else { links.inherited_links(site, k) };
        for link in links.elements[k].iter().chain(&inherited_links) {
            adjacent_spaces.iter().for_each(|s| occupy(*s as usize, link));
        }
    }
    for list in &mut spaces {
        list.sort_unstable();
        list.dedup();
    }
    spaces
}

/// Effects by the bits of links.
const LINK_EFFECTS: [(u32, LinkEffect); 4] = [
    (link_flags::BUILDS, LinkEffect::Builds),
    (link_flags::REMOVES, LinkEffect::Removes),
    (link_flags::WORKS_IN, LinkEffect::WorksIn),
    (link_flags::USES, LinkEffect::Uses),
];

/// Links by target.
struct Links {
    elements: Vec<Vec<Link>>,
    spaces: Vec<Vec<Link>>,
    storeys: Vec<Vec<Link>>,
}

impl Links {
    fn of(site: &Site<'_>) -> Self {
        let mut links = Self {
            elements: vec![Vec::new(); site.elements.len()],
            spaces: vec![Vec::new(); site.spaces.len()],
            storeys: vec![Vec::new(); site.storeys.len()],
        };
        for record in site.schedule.task_links {
            let targets = match record.kind.get() {
                LinkKind::Space => &mut links.spaces,
                LinkKind::Storey => &mut links.storeys,
                LinkKind::Element => &mut links.elements,
            };
            let is = |flag: u32| record.flags & flag != 0;
            let from_above = is(link_flags::FROM_ABOVE);
            let effect = LINK_EFFECTS.iter().find(|(flag, _)| is(*flag)).map(|(_, effect)| effect);
            targets[record.target as usize].push(Link {
                task: record.task,
                is_input: is(link_flags::INPUT),
                from_above,
                effect: effect.copied(),
            });
        }
        links
    }

    /// Links of the space and the storey that hold an element, and its own that come from above.
    fn inherited_links(&self, site: &Site<'_>, element: usize) -> Vec<Link> {
        let space = wholes(site, element).map(|w| site.elements[w].space).find(|s| *s != NONE);
        let storey = site.elements[element].storey;
        let of_space = space.map(|s| self.spaces[s as usize].as_slice()).unwrap_or_default();
        let of_storey = if storey == NONE { &[] } else { self.storeys[storey as usize].as_slice() };
        let own = self.elements[element].iter().filter(|l| l.from_above);
        of_space.iter().chain(of_storey).chain(own).copied().collect()
    }
}

/// Spaces that an element or a part of it is in, bounds or touches.
struct AdjacentSpaces {
    spaces: Vec<Vec<u32>>,
}

impl AdjacentSpaces {
    fn of(site: &Site<'_>) -> Self {
        let mut spaces: Vec<Vec<u32>> = vec![Vec::new(); site.elements.len()];
        let contained = site.elements.iter().zip(0..).filter(|(e, _)| e.space != NONE).map(|(e, k)| (e.space, k));
        let beside = site.boundaries.iter().chain(site.contacts).map(|b| (b.space, b.element));
        for (space, element) in beside.chain(contained) {
            wholes(site, element as usize).for_each(|w| spaces[w].push(space));
        }
        for list in &mut spaces {
            list.sort_unstable();
            list.dedup();
        }
        Self { spaces }
    }
}

/// An element, what it is a part of, and so on.
pub(crate) fn wholes<'s>(site: &'s Site<'_>, element: usize) -> impl Iterator<Item = usize> + 's {
    // Wholes that are parts of themselves end after a round.
    let next = |k: &usize| Some(site.elements[*k].whole).filter(|w| *w != NONE).map(|w| w as usize);
    std::iter::successors(Some(element), next).take(64)
}
