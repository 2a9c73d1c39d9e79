//! Links between tasks and products: IfcRelAssignsToProduct, IfcRelAssignsToProcess.

use rustc_hash::{FxHashMap, FxHashSet};

use super::context::{Context, tell};
use super::model::{LinkTarget, TaskLink};
use crate::Storey;
use crate::kernel::File;
use crate::products::Products;
use crate::relations::Relations;
use diagnostics::{DiagnosticCode, Report, Severity};

/// Links that a schedule may have: tasks at whole buildings multiply.
const LINKS_MAX: usize = 4_000_000;

/// Links in both directions: task -> product (IfcRelAssignsToProduct) and product -> task (IfcRelAssignsToProcess).
pub(super) fn links(
    context: &Context<'_, '_>,
    relations: &Relations,
    products: &Products<'_, '_>,
    storeys: &[Storey],
    report: &mut Report,
) -> Vec<TaskLink> {
    let mut targets = Targets::new(context.file, relations, products, storeys);
    let mut links: Vec<TaskLink> = Vec::new();
    for (task, product, is_input) in pairs(context, report) {
        let found = targets.of(product);
        if found.is_empty() {
            report_target(context, task, product, report);
        }
        if links.len() + found.len() > LINKS_MAX {
            let message = format!("there are more than {LINKS_MAX} links; those of this and later tasks are left out");
            tell(report, Severity::Error, DiagnosticCode::TaskLinksTooMany, &context.task_ids[task], message);
            break;
        }
        links.extend(found.iter().map(|&(target, from_above)| TaskLink { task, target, is_input, from_above }));
    }
    links
}

/// Task, product, and whether it goes in.
fn pairs(context: &Context<'_, '_>, report: &mut Report) -> Vec<(usize, u32, bool)> {
    let file = context.file;
    let task = |id: &u32| context.task_idx.get(id).copied();
    let mut pairs = Vec::new();
    for relation in file.records("IfcRelAssignsToProduct", report) {
        let tasks: Vec<usize> = relation.at(4).references().iter().filter_map(task).collect();
        match (relation.at(6).reference(), tasks.first()) {
            (Some(product), _) => pairs.extend(tasks.into_iter().map(|t| (t, product, false))),
            (None, Some(first)) => {
                let message = format!("#{} says that it works on nothing", file.written_id(relation.id));
                tell(report, Severity::Error, DiagnosticCode::TaskLinkDangling, &context.task_ids[*first], message);
            }
            (None, None) => {}
        }
    }
    for relation in file.records("IfcRelAssignsToProcess", report) {
        let Some(process) = relation.at(6).reference().as_ref().and_then(task) else { continue };
        // Resources, controls, people and other tasks go into tasks, too; only products matter here.
        let inputs = relation.at(4).references().into_iter().filter(|id| !is_beside_products(file, *id));
        pairs.extend(inputs.map(|id| (process, id, true)));
    }
    pairs
}

fn is_beside_products(file: &File<'_>, id: u32) -> bool {
    let beside = ["IfcResource", "IfcControl", "IfcActor", "IfcProcess"];
    file.record(id)
        .is_some_and(|record| file.schema.lineage(record.keyword).iter().any(|entity| beside.contains(entity)))
}

fn report_target(context: &Context<'_, '_>, task: usize, product: u32, report: &mut Report) {
    let file = context.file;
    let id = &context.task_ids[task];
    match file.record(product) {
        None => {
            let message = format!("the task works on #{}, which does not exist", file.written_id(product));
            tell(report, Severity::Error, DiagnosticCode::TaskLinkDangling, id, message);
        }
        Some(record) => {
            let kind = file.schema.lineage(record.keyword).first().copied().unwrap_or("an unknown entity");
            let message =
                format!("the task works on #{} ({kind}), which has no state of its own", file.written_id(product));
            tell(report, Severity::Warning, DiagnosticCode::TaskLinkWithoutState, id, message);
        }
    }
}

/// Finds what a link means.
struct Targets<'c> {
    file: &'c File<'c>,
    products: &'c Products<'c, 'c>,
    /// By the ids that the file has.
    storeys: FxHashMap<u64, usize>,
    /// Parts by whole and elements by container: for buildings and sites.
    below: FxHashMap<u32, Vec<u32>>,
    inside: FxHashMap<u32, Vec<u32>>,
    /// Results found so far.
    known: FxHashMap<u32, Vec<(LinkTarget, bool)>>,
}

impl<'c> Targets<'c> {
    fn new(file: &'c File<'c>, relations: &'c Relations, products: &'c Products<'c, 'c>, storeys: &[Storey]) -> Self {
        let by_one = |pairs: &FxHashMap<u32, u32>| {
            let mut sorted: Vec<(u32, u32)> = pairs.iter().map(|(&member, &one)| (one, member)).collect();
            sorted.sort_unstable();
            let mut lists: FxHashMap<u32, Vec<u32>> = FxHashMap::default();
            for (one, member) in sorted {
                lists.entry(one).or_default().push(member);
            }
            lists
        };
        Self {
            file,
            products,
            storeys: storeys.iter().enumerate().map(|(k, s)| (s.id.step_id, k)).collect(),
            below: by_one(&relations.whole),
            inside: by_one(&relations.container),
            known: FxHashMap::default(),
        }
    }

    /// Targets of a product, each with whether it is only below the product.
    fn of(&mut self, product: u32) -> &[(LinkTarget, bool)] {
        if !self.known.contains_key(&product) {
            let found = match self.own(product) {
                // A storey stands for the storeys that it is made of, too.
                Some(LinkTarget::Storey(k)) => {
                    let below = self.all_below(product).into_iter().filter(|t| matches!(t, LinkTarget::Storey(_)));
                    std::iter::once(LinkTarget::Storey(k)).chain(below).map(|t| (t, false)).collect()
                }
                Some(target) => vec![(target, false)],
                None => self.all_below(product).into_iter().map(|target| (target, true)).collect(),
            };
            self.known.insert(product, found);
        }
        &self.known[&product]
    }

    fn own(&self, product: u32) -> Option<LinkTarget> {
        let element = self.products.element_idx.get(&product).map(|k| LinkTarget::Element(*k));
        let space = || self.products.space_idx.get(&product).map(|k| LinkTarget::Space(*k));
        let storey = || self.storeys.get(&self.file.written_id(product)).map(|k| LinkTarget::Storey(*k));
        element.or_else(space).or_else(storey)
    }

    /// Storeys below a building, site or storey, and what the former hold themselves: what a storey holds follows the storey.
    fn all_below(&self, product: u32) -> Vec<LinkTarget> {
        let (mut found, mut seen, mut waiting) = (Vec::new(), FxHashSet::default(), vec![product]);
        while let Some(at) = waiting.pop() {
            if !seen.insert(at) {
                continue;
            }
            let is_storey = self.storeys.contains_key(&self.file.written_id(at));
            let held = self.inside.get(&at).into_iter().flatten().filter(|_| !is_storey);
            found.extend(held.filter_map(|id| self.products.element_idx.get(id)).map(|k| LinkTarget::Element(*k)));
            for &part in self.below.get(&at).into_iter().flatten() {
                match self.own(part) {
                    Some(storey @ LinkTarget::Storey(_)) => {
                        found.push(storey);
                        waiting.push(part);
                    }
                    Some(target) if !is_storey => found.push(target),
                    Some(_) => {}
                    None => waiting.push(part),
                }
            }
        }
        found.sort_unstable();
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{BASICS, file, read};

    fn check(records: &str) -> (Vec<(LinkTarget, bool, bool)>, Vec<&'static str>) {
        let (model, diagnostics) = read(&file(&format!(
            "{BASICS}#1=IFCTASK('a',$,'A',$,$,$,$,$,$,.F.,$,$,$);#2=IFCWALL('w',$,$,$,$,#103,#121,$,$);
             #3=IFCSPACE('s',$,$,$,$,#103,#121,$,.ELEMENT.,.SPACE.,$);#4=IFCBUILDINGSTOREY('g',$,$,$,$,#103,$,$,.ELEMENT.,0.);
             #5=IFCBUILDING('b',$,$,$,$,$,$,$,.ELEMENT.,$,$,$);#6=IFCRELAGGREGATES('r',$,$,$,#5,(#4));
             #7=IFCRELCONTAINEDINSPATIALSTRUCTURE('c',$,$,$,(#2),#5);#8=IFCCONSTRUCTIONEQUIPMENTRESOURCE('e',$,$,$,$,$,$,$,$,$,$);
             #9=IFCGRID('grid',$,$,$,$,#103,$,$,$,$,$);#10=IFCGROUP('group',$,$,$,$);{records}"
        )))
        .unwrap();
        let links = model.schedule.links.iter().map(|l| (l.target, l.is_input, l.from_above)).collect();
        (links, diagnostics.iter().map(|d| d.code.name()).filter(|c| c.starts_with("task")).collect())
    }

    #[test]
    fn tasks_work_on_elements_spaces_and_storeys_in_both_directions() {
        let (links, codes) = check(
            "#20=IFCRELASSIGNSTOPRODUCT('p',$,$,$,(#1),$,#2);#21=IFCRELASSIGNSTOPROCESS('q',$,$,$,(#3,#4,#8),$,#1,$);",
        );
        let expected = [
            (LinkTarget::Element(0), false, false),
            (LinkTarget::Space(0), true, false),
            (LinkTarget::Storey(0), true, false),
        ];
        assert_eq!((links.as_slice(), codes), (&expected[..], vec![]), "a resource is no product");
    }

    #[test]
    fn a_building_stands_for_its_storeys_and_what_it_holds_itself() {
        let (links, _) = check("#20=IFCRELASSIGNSTOPRODUCT('p',$,$,$,(#1),$,#5);");
        assert_eq!(links, [(LinkTarget::Element(0), false, true), (LinkTarget::Storey(0), false, true)]);
    }

    #[test]
    fn a_storey_stands_for_the_storeys_that_it_is_made_of() {
        let (links, _) = check(
            "#30=IFCBUILDINGSTOREY('h',$,$,$,$,#103,$,$,.PARTIAL.,0.);#31=IFCRELAGGREGATES('q',$,$,$,#4,(#30));
             #20=IFCRELASSIGNSTOPRODUCT('p',$,$,$,(#1),$,#4);",
        );
        assert_eq!(links, [(LinkTarget::Storey(0), false, false), (LinkTarget::Storey(1), false, false)]);
    }

    #[test]
    fn links_to_nothing_and_to_what_has_no_state_are_named() {
        let (links, codes) =
            check("#20=IFCRELASSIGNSTOPRODUCT('p',$,$,$,(#1),$,#99);#21=IFCRELASSIGNSTOPRODUCT('q',$,$,$,(#1),$,#9);");
        assert_eq!((links, codes), (vec![], vec!["task_link_dangling", "task_link_without_state"]));
    }
}
