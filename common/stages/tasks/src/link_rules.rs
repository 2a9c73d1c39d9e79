//! Linking rules of a site from TOML; `config/schedule.toml` documents every key.

use crate::effect::{Effect, EffectWords};
use crate::folded::fold;
use crate::selector::{Pattern, Selector};
use crate::target_values::TargetValue;
use crate::task_values::TaskValue;
use serde::Deserialize;

/// Most rules of a site.
const MAX_RULES: usize = 1000;

/// Rules by which tasks of schedule files find what they work on.
#[derive(Debug, Clone, PartialEq)]
pub struct LinkRules {
    /// In order of rank.
    pub rules: Vec<LinkRule>,
    /// Words that tell effects.
    pub words: EffectWords,
}

/// Which tasks work on which elements and spaces, and what they do there.
#[derive(Debug, Clone, PartialEq)]
pub struct LinkRule {
    /// Its name in reports.
    pub name: String,
    /// The tasks.
    pub task: TaskSelector,
    /// The elements and spaces.
    pub elements: ElementSelector,
    /// The effect.
    pub effect: EffectChoice,
}

/// Tasks that fit all that is given.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TaskSelector {
    pub(crate) file: Option<Pattern>,
    pub(crate) values: Vec<(TaskValue, Pattern)>,
}

/// Elements and spaces that fit all that is given.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ElementSelector {
    pub(crate) values: Vec<(TargetValue, Selector)>,
    /// Corners of a polygon in `map` in metres, in which the middle of the element lies.
    pub(crate) region_m: Option<Vec<[f64; 2]>>,
}

/// How the effect of a rule's links is found.
#[derive(Debug, Clone, PartialEq)]
pub enum EffectChoice {
    /// It is the same for all tasks.
    Fixed(Effect),
    /// Words in a value of the task tell it.
    Told(ToldBy),
}

/// The value of a task whose words tell its effect.
#[derive(Debug, Clone, PartialEq)]
pub struct ToldBy(pub(crate) TaskValue);

/// A rule that cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("link[{rule}]: {why}")]
pub struct LinkRulesError {
    /// From 0.
    pub rule: usize,
    /// What is wrong.
    pub why: String,
}

/// The keys of the linking rules in the rules file.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LinkRulesToml {
    /// `[[link]]`; without any the rules are those of [`LinkRules::default`].
    pub link: Option<Vec<LinkToml>>,
    /// `[link_words]`.
    #[serde(default)]
    pub link_words: EffectWords,
}

/// A `[[link]]`; its keys are those of [`LinkRule`].
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LinkToml {
    name: Option<String>,
    #[serde(default)]
    task: TaskToml,
    elements: ElementsToml,
    #[serde(default = "builds")]
    effect: String,
}

#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct TaskToml {
    file: Option<String>,
    id: Option<String>,
    code: Option<String>,
    wbs: Option<String>,
    name: Option<String>,
    field: Option<String>,
    value: Option<String>,
}

#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct ElementsToml {
    global_id: Option<String>,
    class: Option<String>,
    storey: Option<String>,
    zone: Option<String>,
    group: Option<String>,
    space: Option<String>,
    classification: Option<String>,
    name: Option<String>,
    property: Option<String>,
    value: Option<String>,
    box_m: Option<[f64; 4]>,
    polygon_m: Option<Vec<[f64; 2]>>,
}

fn builds() -> String {
    Effect::Builds.name().to_owned()
}

impl Default for LinkRules {
    /// The usual ways: a GlobalId in a field of the task, then a property that holds the number of the activity, which in MS Project is a
    /// custom field, since its ids are numbers of rows.
    fn default() -> Self {
        let rule = |name: &str, value: TargetValue, task: TaskValue| LinkRule {
            name: name.to_owned(),
            task: TaskSelector::default(),
            elements: ElementSelector { values: vec![(value, Selector::Equals(task))], region_m: None },
            effect: EffectChoice::Fixed(Effect::Builds),
        };
        let field = |name: &str| TaskValue::Field(fold(name));
        let by_property = |name: &str| rule(name, TargetValue::property(name), TaskValue::Code);
        let number = "4D_Number";
        let rules = vec![
            rule("GlobalId", TargetValue::GlobalId, field("GlobalId")),
            rule("4D_Number as a field", TargetValue::property(number), field(number)),
            by_property(number),
            by_property("Activity?ID"),
            by_property("Task?ID"),
        ];
        Self { rules, words: EffectWords::default() }
    }
}

impl LinkRules {
    /// Rules from the keys of a file.
    ///
    /// # Errors
    /// A rule that selects nothing or everything, or whose values do not exist.
    pub fn of(file: LinkRulesToml) -> Result<Self, LinkRulesError> {
        let Some(links) = file.link else { return Ok(Self { words: file.link_words, ..Self::default() }) };
        if links.len() > MAX_RULES {
            return Err(LinkRulesError { rule: MAX_RULES, why: format!("more than {MAX_RULES} rules") });
        }
        let rule = |(k, toml): (usize, LinkToml)| rule_of(k, toml).map_err(|why| LinkRulesError { rule: k, why });
        let rules = links.into_iter().enumerate().map(rule).collect::<Result<_, _>>()?;
        Ok(Self { rules, words: file.link_words })
    }
}

fn rule_of(k: usize, toml: LinkToml) -> Result<LinkRule, String> {
    let effect = match toml.effect.strip_prefix('=') {
        Some(value) => EffectChoice::Told(ToldBy(TaskValue::parse(value)?)),
        None => EffectChoice::Fixed(Effect::named(&toml.effect).ok_or_else(|| {
            let names = Effect::ALL.map(Effect::name).join(", ");
            format!("effect {:?} is none of {names}, nor a value of the task such as \"=field:Type\"", toml.effect)
        })?),
    };
    Ok(LinkRule {
        name: toml.name.unwrap_or_else(|| format!("link[{k}]")),
        task: task_selector(toml.task)?,
        elements: element_selector(toml.elements)?,
        effect,
    })
}

fn task_selector(toml: TaskToml) -> Result<TaskSelector, String> {
    let field = match (toml.field, toml.value) {
        (Some(field), Some(value)) => Some((TaskValue::parse(&format!("field:{field}"))?, value)),
        (None, None) => None,
        _ => return Err("task: field and value belong together".to_owned()),
    };
    let named = [
        (TaskValue::Id, toml.id),
        (TaskValue::Code, toml.code),
        (TaskValue::Wbs, toml.wbs),
        (TaskValue::Name, toml.name),
    ];
    let named = named.into_iter().filter_map(|(value, text)| Some((value, text?)));
    let values: Vec<(TaskValue, String)> = named.chain(field).collect();
    if values.iter().map(|(_, text)| text).chain(&toml.file).any(|text| text.trim().is_empty()) {
        return Err("task: a pattern is empty; write * for anything".to_owned());
    }
    let values = values.into_iter().map(|(value, text)| (value, Pattern::new(&text))).collect();
    Ok(TaskSelector { file: toml.file.as_deref().map(Pattern::new), values })
}

fn element_selector(toml: ElementsToml) -> Result<ElementSelector, String> {
    let property = match (&toml.property, toml.value) {
        (Some(property), Some(value)) => Some((TargetValue::property(property), "value", value)),
        (None, None) => None,
        (Some(property), None) => {
            return Err(format!("elements: the value of property {property:?} is missing, such as \"=code\""));
        }
        (None, Some(_)) => return Err("elements: value belongs to a property".to_owned()),
    };
    let named = [
        (TargetValue::GlobalId, "global_id", toml.global_id),
        (TargetValue::Class, "class", toml.class),
        (TargetValue::Storey, "storey", toml.storey),
        (TargetValue::Zone, "zone", toml.zone),
        (TargetValue::Group, "group", toml.group),
        (TargetValue::Space, "space", toml.space),
        (TargetValue::Classification, "classification", toml.classification),
        (TargetValue::Name, "name", toml.name),
    ];
    let named = named.into_iter().filter_map(|(value, key, text)| Some((value, key, text?)));
    let values = property.into_iter().chain(named).map(|(value, key, text)| {
        Ok((value, Selector::parse(&text).map_err(|why| format!("elements: {key}: {why}"))?))
    });
    let values = values.collect::<Result<Vec<_>, String>>()?;
    let region_m = region(toml.box_m, toml.polygon_m)?;
    if values.is_empty() && region_m.is_none() {
        return Err("elements: says nothing; every task would work on everything".to_owned());
    }
    Ok(ElementSelector { values, region_m })
}

fn region(box_m: Option<[f64; 4]>, polygon_m: Option<Vec<[f64; 2]>>) -> Result<Option<Vec<[f64; 2]>>, String> {
    let corners = match (box_m, polygon_m) {
        (None, None) => return Ok(None),
        (Some([x0, y0, x1, y1]), None) if x0 < x1 && y0 < y1 => vec![[x0, y0], [x1, y0], [x1, y1], [x0, y1]],
        (Some(_), None) => return Err("elements: box_m is [x0, y0, x1, y1] with x0 < x1 and y0 < y1".to_owned()),
        (None, Some(polygon_m)) if polygon_m.len() >= 3 => polygon_m,
        (None, Some(_)) => return Err("elements: polygon_m has at least three corners".to_owned()),
        (Some(_), Some(_)) => return Err("elements: give box_m or polygon_m".to_owned()),
    };
    let is_finite = corners.iter().flatten().all(|x| x.is_finite());
    if is_finite { Ok(Some(corners)) } else { Err("elements: a corner is no place".to_owned()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rules(text: &str) -> Result<LinkRules, String> {
        let file: LinkRulesToml = toml::from_str(text).map_err(|e| e.to_string())?;
        LinkRules::of(file).map_err(|e| e.to_string())
    }

    #[test]
    fn one_rule_links_a_property_with_the_activity() {
        let rules = rules("[[link]]\nelements = { property = \"4D_Number\", value = \"=code\" }").unwrap();
        let rule = &rules.rules[0];
        assert_eq!((rule.name.as_str(), &rule.effect), ("link[0]", &EffectChoice::Fixed(Effect::Builds)));
        assert_eq!(rule.elements.values, [(TargetValue::property("4D_Number"), Selector::Equals(TaskValue::Code))]);
        assert_eq!(rule.task, TaskSelector::default());
    }

    #[test]
    fn without_rules_those_of_the_usual_properties_count() {
        assert_eq!(rules("").unwrap(), LinkRules::default());
        assert!(rules("link = []").unwrap().rules.is_empty());
    }

    #[test]
    fn rules_that_mean_nothing_are_refused_with_their_number() {
        for (text, word) in [
            ("elements = {}", "says nothing"),
            ("elements = { property = \"X\" }", "value of property \"X\""),
            ("elements = { value = \"=code\" }", "belongs to a property"),
            ("elements = { name = \"=cod\" }", "=cod is no value"),
            ("elements = { name = \" \" }", "is empty"),
            ("elements = { name = \"*\" }\neffect = \"build\"", "none of builds, removes"),
            ("elements = { name = \"*\" }\ntask = { field = \"Zone\" }", "belong together"),
            ("elements = { box_m = [1, 1, 0, 2] }", "x0 < x1"),
            ("elements = { polygon_m = [[0, 0], [1, 1]] }", "three corners"),
            ("elements = { colour = \"red\" }", "colour"),
        ] {
            let error = rules(&format!("[[link]]\n{text}")).unwrap_err();
            assert!(error.contains(word), "{text}: {error}");
        }
    }
}
