//! Proposes linking rules from the values that elements and tasks share; nothing is applied.
//!
//! Every value of elements and spaces (GlobalId, name, class, storey, room, zone, group, classification, each property) is compared with
//! every value of tasks (code, work breakdown, name, id, each field). An equality is proposed if
//!
//! 1. tasks and elements share at least three texts, and those are half of what the elements, or the tasks that are work, have there,
//! 2. that is no chance: the shared texts count for 20 bits more than it takes to tell all compared pairs apart (`evidence.rs`). Values
//!    of elements that are nothing but values of tasks (95 in 100), ten and more, and those of 80 in 100 tasks that are work, count for
//!    40 bits, unless tasks are numbered from 1,
//! 3. it tells tasks apart: an element has at most ten of them, and an eighth at most of all that are linked.
//!
//! Where no equality links half of the work, two that fail the third condition are tried together: a zone and a trade. What is counted of
//! a proposal are the links that [`link`] makes by it.

mod counts;
mod evidence;

use crate::effect::{Effect, EffectWords};
use crate::link_rules::{EffectChoice, ElementSelector, LinkRule, LinkRules, TaskSelector, ToldBy};
use crate::linking::link;
use crate::links::{Links, Target};
use crate::schedule_file::ScheduleFile;
use crate::selector::Selector;
use crate::task_values::{PlannedTask, TaskValue, all_tasks, is_work, task_ids};
use counts::{Compared, Counts, Pair, TaskTexts, count, task_texts};
use evidence::Forms;
use messages::Site;
use std::collections::BTreeSet;

/// Shared texts of a proposal.
const MIN_SHARED: usize = 3;
/// Equalities whose links are made.
const MAX_TRIED: usize = 24;
/// Equalities that are tried in pairs.
const MAX_PAIRED: usize = 6;
/// Bits beyond those of the number of compared pairs.
const MARGIN_BITS: f64 = 20.0;
/// Bits of values that are nothing but those of nearly all tasks.
const COVER_BITS: f64 = 40.0;
const MAX_TASKS_OF_TARGET: f64 = 10.0;
const MAX_EXAMPLES: usize = 3;
/// Equalities that are told and not proposed.
const MAX_NOT_PROPOSED: usize = 12;

/// Rules that fit a schedule and a model.
#[derive(Debug, Clone, Default)]
pub struct Proposals {
    /// Best first; each names elements that none before it does.
    pub proposals: Vec<Proposal>,
    /// What looked alike, and why it is not proposed.
    pub not_proposed: Vec<NotProposed>,
    /// How many pairs of values were compared.
    pub n_compared: usize,
    /// Bits that shared texts need to be no chance.
    pub needed_bits: f64,
    /// Links of all proposals as rules in their order.
    pub n_links: usize,
    /// Tasks that are work.
    pub n_work: usize,
    /// Names of all tasks, as in the `tasks` archive.
    pub task_ids: Vec<String>,
}

/// A rule that links by equal values.
#[derive(Debug, Clone)]
pub struct Proposal {
    /// The rule.
    pub rule: LinkRule,
    /// It as `[[link]]`, to be pasted into the rules of a schedule.
    pub toml: String,
    /// What is equal, for people.
    pub what: String,
    /// Links of this rule alone.
    pub n_links: usize,
    /// Tasks in them, and those of them that are work.
    pub n_tasks: [usize; 2],
    /// Elements and spaces in them.
    pub n_targets: usize,
    /// Those of them that no better proposal names.
    pub n_new_targets: usize,
    /// Elements and spaces with the value (of the first, if two values are compared), and those of them that name a task.
    pub n_with_value: [usize; 2],
    /// Those that differ from a task's value in spaces, signs, leading zeros or what follows a sign.
    pub n_near: usize,
    /// Texts that both have.
    pub n_shared: usize,
    /// How unlikely it is by chance.
    pub bits: f64,
    /// Texts with the number of their tasks and elements.
    pub examples: Vec<ProposalExample>,
    /// Tasks that are work and stay without elements, by index over all files.
    pub unlinked_work: Vec<usize>,
    /// Linked tasks whose names have words of another effect than the rule's.
    pub n_other_effects: usize,
}

/// A text that tasks and elements share.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ProposalExample {
    /// The text, folded.
    pub text: String,
    /// Tasks with it.
    pub n_tasks: usize,
    /// Elements and spaces with it.
    pub n_targets: usize,
}

/// An equality that is not proposed.
#[derive(Debug, Clone)]
pub struct NotProposed {
    /// What is equal, for people.
    pub what: String,
    /// Elements and spaces that name a task by it.
    pub n_targets: usize,
    /// Texts that both have.
    pub n_shared: usize,
    /// Why.
    pub why: WhyNot,
}

/// Why an equality is not proposed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum WhyNot {
    /// It may be by chance: it counts for so many bits.
    Coincidence(f64),
    /// It does not tell tasks apart: an element has so many on average.
    Ambiguous(f64),
    /// A better proposal names all its elements.
    Covered,
    /// Values are alike, and not equal: so many elements and spaces.
    Near(usize),
}

/// What is known of the tasks.
struct Work<'a> {
    site: &'a Site<'a>,
    plans: &'a [ScheduleFile],
    words: &'a EffectWords,
    tasks: &'a [PlannedTask<'a>],
    is_work: &'a [bool],
    texts: &'a [TaskTexts],
    /// Of each of them.
    forms: &'a [Forms],
    counts: &'a Counts,
}

/// Proposes rules for a schedule and a site.
pub fn propose(site: &Site<'_>, plans: &[ScheduleFile], words: &EffectWords) -> Proposals {
    let tasks = all_tasks(plans);
    let is_work = is_work(&tasks, plans);
    let texts = task_texts(&tasks);
    let counts = count(site, &texts);
    let forms: Vec<Forms> = texts.iter().map(|of| forms_of(of, &is_work)).collect();
    let work =
        Work { site, plans, words, tasks: &tasks, is_work: &is_work, texts: &texts, forms: &forms, counts: &counts };
    let n_with = counts.compared.iter().filter(|(_, n)| *n > 0).count();
    let n_compared = n_with * texts.len();
    let needed_bits = MARGIN_BITS + (n_compared.max(1) as f64).log2();
    let mut found = Proposals {
        n_compared,
        needed_bits,
        n_work: is_work.iter().filter(|is_work| **is_work).count(),
        task_ids: task_ids(plans),
        ..Proposals::default()
    };
    let mut ambiguous = Vec::new();
    let mut proposals: Vec<Proposal> = Vec::new();
    for (pair, bits) in work.candidates(&mut found.not_proposed, needed_bits) {
        let proposal = work.proposal(&[pair], bits);
        match tasks_of_target(&proposal) {
            _ if proposal.n_links == 0 => {}
            _ if tells_apart(&proposal) => proposals.push(proposal),
            mean => {
                found.not_proposed.push(proposal.not(WhyNot::Ambiguous(mean)));
                ambiguous.push((pair, bits));
            }
        }
    }
    if proposals.iter().all(|proposal| proposal.n_tasks[1] * 2 < found.n_work) {
        ambiguous.truncate(MAX_PAIRED);
        for (k, (a, bits_a)) in ambiguous.iter().enumerate() {
            for (b, bits_b) in ambiguous[k + 1..].iter().filter(|(b, _)| work.may_be_joined(*a, *b)) {
                let proposal = work.proposal(&[*a, *b], bits_a + bits_b);
                if tells_apart(&proposal) && proposal.n_tasks[1] * 2 >= found.n_work && bits_a + bits_b >= needed_bits {
                    proposals.push(proposal);
                }
            }
        }
    }
    rank(&work, proposals, &mut found);
    found
}

fn forms_of(of: &TaskTexts, is_work: &[bool]) -> Forms {
    Forms::of(of.tasks.iter().map(|(text, tasks)| (text.as_str(), tasks.iter().any(|task| is_work[*task]))))
}

/// Puts the proposals in order, and leaves out those that name nothing that a better one does not.
fn rank(work: &Work<'_>, mut proposals: Vec<Proposal>, found: &mut Proposals) {
    let score = |p: &Proposal| p.n_tasks[1] as f64 * p.n_targets as f64 / tasks_of_target(p).max(1.0);
    // The sort is stable: codes before names and fields.
    proposals.sort_by(|a, b| score(b).total_cmp(&score(a)));
    let mut taken: BTreeSet<Target> = BTreeSet::new();
    for mut proposal in proposals {
        let targets: BTreeSet<Target> = work.links(&proposal.rule).links.iter().map(|link| link.target).collect();
        proposal.n_new_targets = targets.difference(&taken).count();
        if proposal.n_new_targets == 0 {
            found.not_proposed.push(proposal.not(WhyNot::Covered));
        } else {
            taken.extend(targets);
            found.proposals.push(proposal);
        }
    }
    found.not_proposed.sort_by_key(|not| std::cmp::Reverse(not.n_targets));
    found.not_proposed.truncate(MAX_NOT_PROPOSED);
    let rules = found.proposals.iter().map(|proposal| proposal.rule.clone()).collect();
    let rules = LinkRules { rules, words: work.words.clone() };
    found.n_links = link(work.site, work.plans, &rules, &[]).map_or(0, |links| links.links.len());
}

fn tasks_of_target(proposal: &Proposal) -> f64 {
    proposal.n_links as f64 / proposal.n_targets.max(1) as f64
}

fn tells_apart(proposal: &Proposal) -> bool {
    let mean = tasks_of_target(proposal);
    0.0 < mean && mean <= MAX_TASKS_OF_TARGET && mean * 8.0 <= (proposal.n_tasks[0] as f64).max(8.0)
}

impl Proposal {
    fn not(&self, why: WhyNot) -> NotProposed {
        NotProposed { what: self.what.clone(), n_targets: self.n_targets, n_shared: self.n_shared, why }
    }
}

impl Work<'_> {
    /// Pairs of values that share enough, and not by chance, with their bits; most elements first.
    fn candidates(&self, not_proposed: &mut Vec<NotProposed>, needed_bits: f64) -> Vec<((usize, usize), f64)> {
        let mut found = Vec::new();
        for (key, pair) in &self.counts.pairs {
            let (n_with, of) = (self.counts.compared[key.0].1, &self.texts[key.1]);
            let share = |n: usize| n * 2 >= n_with;
            let work_with = self.work_of(of.tasks.values().flatten());
            let work_hit = self.work_of(self.shared(pair).filter_map(|text| of.tasks.get(text)).flatten());
            let is_half = share(pair.n_hit) || work_hit * 2 >= work_with.max(1);
            if pair.shared.len() < MIN_SHARED || !is_half {
                if pair.n_hit < pair.n_near
                    && share(pair.n_near)
                    && pair.n_near >= MIN_SHARED
                    && !self.forms[key.1].is_numbering()
                {
                    not_proposed.push(self.not(*key, pair, WhyNot::Near(pair.n_near)));
                }
                continue;
            }
            let bits = self.bits(key.1, pair, n_with, [work_hit, work_with]);
            // Texts that alone may be by chance can tell in pairs.
            if bits >= needed_bits / 2.0 {
                found.push((*key, bits));
            }
            if bits < needed_bits {
                not_proposed.push(self.not(*key, pair, WhyNot::Coincidence(bits)));
            }
        }
        found.sort_by_key(|(key, _)| (std::cmp::Reverse(self.counts.pairs[key].n_hit), key.1, key.0));
        found.truncate(MAX_TRIED);
        found
    }

    /// True for two different equalities that one rule can have: it compares one property.
    fn may_be_joined(&self, a: (usize, usize), b: (usize, usize)) -> bool {
        let is_property = |k: usize| matches!(self.counts.compared[k].0, Compared::Property(_));
        a.0 != b.0 && a.1 != b.1 && !(is_property(a.0) && is_property(b.0))
    }

    fn shared<'p>(&'p self, pair: &'p Pair) -> impl Iterator<Item = &'p str> {
        pair.shared.keys().map(|id| self.counts.texts[*id].as_str())
    }

    fn work_of<'k>(&self, tasks: impl Iterator<Item = &'k usize>) -> usize {
        tasks.filter(|task| self.is_work[**task]).collect::<BTreeSet<_>>().len()
    }

    fn bits(&self, value: usize, pair: &Pair, n_with: usize, [work_hit, work_with]: [usize; 2]) -> f64 {
        let (of, forms) = (&self.texts[value], &self.forms[value]);
        let is_work = |text: &str| of.tasks.get(text).into_iter().flatten().any(|task| self.is_work[*task]);
        let bits = forms.bits(self.shared(pair).map(|text| (text, is_work(text))));
        let covers = pair.shared.len() >= 10 && pair.n_hit * 100 >= n_with * 95 && work_hit * 10 >= work_with * 8;
        if covers && !forms.is_numbering() { bits + COVER_BITS } else { bits }
    }

    fn not(&self, key: (usize, usize), pair: &Pair, why: WhyNot) -> NotProposed {
        NotProposed { what: self.what(&[key]), n_targets: pair.n_hit, n_shared: pair.shared.len(), why }
    }

    fn what(&self, keys: &[(usize, usize)]) -> String {
        let one = |key: &(usize, usize)| {
            let element = match &self.counts.compared[key.0].0 {
                Compared::Property(name) => format!("property {name:?}"),
                Compared::Key(name) => (*name).replace('_', " "),
            };
            let task = match self.texts[key.1].written.strip_prefix("field:") {
                Some(field) => format!("field {field:?}"),
                None => self.texts[key.1].written.clone(),
            };
            format!("{element} of elements is {task} of tasks")
        };
        keys.iter().map(one).collect::<Vec<_>>().join(", and ")
    }

    fn links(&self, rule: &LinkRule) -> Links {
        let rules = LinkRules { rules: vec![rule.clone()], words: self.words.clone() };
        // Of more links than a site may have none is proposed.
        link(self.site, self.plans, &rules, &[]).unwrap_or_default()
    }

    /// The rule that such values are equal, with what it links.
    fn proposal(&self, keys: &[(usize, usize)], bits: f64) -> Proposal {
        let what = self.what(keys);
        let values = keys
            .iter()
            .map(|(a, b)| (self.counts.compared[*a].0.value(), Selector::Equals(self.texts[*b].value.clone())));
        let mut rule = LinkRule {
            name: what.clone(),
            task: TaskSelector::default(),
            elements: ElementSelector { values: values.collect(), region_m: None },
            effect: EffectChoice::Fixed(Effect::Builds),
        };
        // Rules read a property before other keys.
        rule.elements
            .values
            .sort_by_key(|(value, _)| !matches!(value, crate::target_values::TargetValue::Property { .. }));
        let links = self.links(&rule).links;
        let tasks: BTreeSet<usize> = links.iter().map(|link| link.task).collect();
        let targets: BTreeSet<Target> = links.iter().map(|link| link.target).collect();
        let told = self.told_effect(&tasks);
        let mut toml = format!("[[link]]\nname = {}\nelements = {{ ", quoted(&what));
        toml += &keys.iter().map(|key| self.toml_of(*key)).collect::<Vec<_>>().join(", ");
        toml += " }\n";
        if let Some(field) = &told {
            rule.effect = EffectChoice::Told(ToldBy(self.texts[*field].value.clone()));
            toml += &format!("effect = {}\n", quoted(&format!("={}", self.texts[*field].written)));
        }
        let other = |task: &&usize| {
            let effect = self.words.effect_of(&self.tasks[**task].task.name);
            told.is_none() && effect.is_some_and(|effect| effect != Effect::Builds)
        };
        let pair = &self.counts.pairs[&keys[0]];
        let of = &self.texts[keys[0].1];
        let example = |(id, n_targets): (&usize, &usize)| {
            let text = &self.counts.texts[*id];
            ProposalExample {
                text: text.clone(),
                n_tasks: of.tasks.get(text).map_or(0, Vec::len),
                n_targets: *n_targets,
            }
        };
        Proposal {
            n_links: links.len(),
            n_tasks: [tasks.len(), tasks.iter().filter(|task| self.is_work[**task]).count()],
            n_targets: targets.len(),
            n_new_targets: 0,
            n_with_value: [self.counts.compared[keys[0].0].1, pair.n_hit],
            n_near: pair.n_near,
            n_shared: pair.shared.len(),
            bits,
            examples: pair.shared.iter().take(MAX_EXAMPLES).map(example).collect(),
            unlinked_work: (0..self.tasks.len()).filter(|k| self.is_work[*k] && !tasks.contains(k)).collect(),
            n_other_effects: tasks.iter().filter(other).count(),
            rule,
            toml,
            what,
        }
    }

    /// The field whose words tell the effect of nearly all tasks, if one is other than building.
    fn told_effect(&self, tasks: &BTreeSet<usize>) -> Option<usize> {
        let effects = |value: &TaskValue| -> Vec<Effect> {
            let told =
                |task: &usize| value.of(self.tasks[*task].task).iter().find_map(|text| self.words.effect_of(text));
            tasks.iter().filter_map(told).collect()
        };
        let tells = |of: &TaskTexts| {
            let told = if of.written.starts_with("field:") { effects(&of.value) } else { Vec::new() };
            told.len() * 100 >= tasks.len() * 95 && told.iter().any(|effect| *effect != Effect::Builds)
        };
        self.texts.iter().position(tells)
    }

    /// Keys of a rule that such values are equal.
    fn toml_of(&self, (element, task): (usize, usize)) -> String {
        let value = quoted(&format!("={}", self.texts[task].written));
        match &self.counts.compared[element].0 {
            Compared::Key(key) => format!("{key} = {value}"),
            Compared::Property(name) if name.contains('.') => {
                format!("property = {}, value = {value}", quoted(&format!("*.{name}")))
            }
            Compared::Property(name) => format!("property = {}, value = {value}", quoted(name)),
        }
    }
}

/// A text as TOML writes it.
fn quoted(text: &str) -> String {
    let mut out = "\"".to_owned();
    for c in text.chars() {
        match c {
            '"' | '\\' => out.extend(['\\', c]),
            c if c.is_control() => out += &format!("\\u{:04X}", u32::from(c)),
            c => out.push(c),
        }
    }
    out + "\""
}
