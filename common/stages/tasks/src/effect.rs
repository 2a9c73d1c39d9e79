//! Effects of a task on a linked element, and the words by which they are told.

use crate::folded::fold;
use crate::selector::Pattern;
use messages::link_flags;
use serde::Deserialize;

/// What a task does with an element that it is linked to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Effect {
    /// It builds it.
    Builds,
    /// It removes it.
    Removes,
    /// It works in its spaces, and leaves it as it is.
    WorksIn,
    /// It uses it temporarily: the element stands from the start of the task until its finish.
    Uses,
}

impl Effect {
    /// All effects.
    pub const ALL: [Self; 4] = [Self::Builds, Self::Removes, Self::WorksIn, Self::Uses];

    /// Its name in rules and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Builds => "builds",
            Self::Removes => "removes",
            Self::WorksIn => "works_in",
            Self::Uses => "uses",
        }
    }

    /// The effect of this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|effect| effect.name() == name)
    }

    /// Its bit in links.
    pub(crate) fn flag(self) -> u32 {
        match self {
            Self::Builds => link_flags::BUILDS,
            Self::Removes => link_flags::REMOVES,
            Self::WorksIn => link_flags::WORKS_IN,
            Self::Uses => link_flags::USES,
        }
    }
}

/// Words by which a text of a task tells its effect: patterns with `*` and `?`, in any case. The first effect with a word that
/// fits counts, in the order of the fields.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct EffectWords {
    /// Words of removal.
    pub removes: Vec<String>,
    /// Words of temporary use.
    pub uses: Vec<String>,
    /// Words of work that changes no element.
    pub works_in: Vec<String>,
    /// Words of construction.
    pub builds: Vec<String>,
}

impl Default for EffectWords {
    fn default() -> Self {
        let words = |words: &[&str]| words.iter().map(|word| (*word).to_owned()).collect();
        Self {
            removes: words(&["*demol*", "*dismantl*", "*remov*", "*strip out*", "*abbruch*", "*abriss*", "*rückbau*"]),
            uses: words(&["*temporar*", "*temporär*", "*provisor*"]),
            works_in: words(&["*maint*", "*inspect*", "*clean*", "*commission*", "*test*", "*reinig*", "*prüf*"]),
            builds: words(&["*construct*", "*build*", "*install*", "*erect*", "*new*", "*neu*", "*bau*", "*mont*"]),
        }
    }
}

impl EffectWords {
    /// The effect that a text tells; `None` if no word fits.
    pub(crate) fn effect_of(&self, text: &str) -> Option<Effect> {
        let text = fold(text);
        let lists = [(&self.removes, Effect::Removes), (&self.uses, Effect::Uses), (&self.works_in, Effect::WorksIn)];
        let lists = lists.into_iter().chain([(&self.builds, Effect::Builds)]);
        let mut told = lists.filter(|(words, _)| words.iter().any(|word| Pattern::new(word).fits(&text)));
        told.next().map(|(_, effect)| effect)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_in_any_case_tell_the_effect() {
        let words = EffectWords::default();
        for (text, effect) in [
            ("Construction", Some(Effect::Builds)),
            ("Demolition of old walls", Some(Effect::Removes)),
            ("TEMPORARY", Some(Effect::Uses)),
            ("Rückbau Bestand", Some(Effect::Removes)),
            ("Inspection", Some(Effect::WorksIn)),
            ("Trockenbau", Some(Effect::Builds)),
            ("", None),
            ("x", None),
        ] {
            assert_eq!(words.effect_of(text), effect, "{text}");
        }
    }

    #[test]
    fn names_and_effects_are_the_same_thing() {
        assert!(Effect::ALL.into_iter().all(|effect| Effect::named(effect.name()) == Some(effect)));
        assert_eq!(Effect::named("build"), None);
    }
}
