//! Probabilities of states at a date, as JSON and for people.

use crate::named::date_text;
use diagnostics::counted;
use frames::written_date::DAY_S;
use messages::Site;
use schedule::{Period, Probabilities, SafeDay, Uncertainty};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write;

/// The window of the safest days: four weeks.
const N_DAYS: u32 = 28;

/// Safest days that are given of each space.
const N_SAFEST: usize = 5;

/// Uncertain elements in the text; all are in the JSON document.
const MAX_ELEMENTS: usize = 12;

/// Probabilities of the states of all elements and spaces.
#[derive(Debug, Serialize)]
pub struct StateProbabilities<'s> {
    /// How often the schedule was simulated.
    runs: u32,
    /// Seed of the drawn durations.
    seed: u32,
    elements: BTreeMap<&'s str, Element>,
    spaces: BTreeMap<&'s str, Space>,
}

/// Probabilities of an element from 0 to 1: over a period that it stands throughout, and that it is there at any instant.
#[derive(Debug, Clone, Copy, Serialize)]
struct Element {
    stands: f64,
    there: f64,
}

#[derive(Debug, Serialize)]
struct Space {
    /// Probability that it is open, over a period throughout.
    open: f64,
    /// The days of the four weeks from the date on that are safest, best first, of equals the earlier; none on which it is
    /// closed in every run.
    safest_days: Vec<Day>,
}

#[derive(Debug, Serialize)]
struct Day {
    day: String,
    /// Probability that the space is open all day.
    open: f64,
}

impl Day {
    fn of(safe_day: &SafeDay) -> Self {
        let date = date_text(safe_day.day * DAY_S);
        let day = date.split('T').next().unwrap_or_default().to_owned();
        Self { day, open: safe_day.open }
    }
}

impl<'s> StateProbabilities<'s> {
    /// Those of a period.
    pub fn of(site: &'s Site<'_>, probabilities: &Probabilities<'_>, period: Period) -> Self {
        let Uncertainty { runs, seed, .. } = *probabilities.uncertainty();
        let elements = site.elements.iter().zip(probabilities.elements(period));
        let open = probabilities.spaces_open(period);
        let safest = probabilities.safest_days(period.from_s.div_euclid(DAY_S), N_DAYS, N_SAFEST);
        let spaces = site.spaces.iter().zip(open).zip(&safest);
        Self {
            runs,
            seed,
            elements: elements
                .map(|(element, found)| {
                    let probability = Element { stands: found.stands, there: found.there };
                    (site.text(element.global_id), probability)
                })
                .collect(),
            spaces: spaces
                .map(|((space, open), days)| {
                    let safest_days = days.iter().filter(|day| day.open > 0.0).map(Day::of).collect();
                    let space_probability = Space { open, safest_days };
                    (site.text(space.global_id), space_probability)
                })
                .collect(),
        }
    }

    /// For people: what is uncertain, then every space with its safest day.
    pub fn text(&self, site: &Site<'_>) -> String {
        let is_uncertain = |e: &Element| (0.0 < e.stands && e.stands < 1.0) || (0.0 < e.there && e.there < 1.0);
        let found = |id: messages::Text| self.elements.get(site.text(id)).copied();
        let uncertain: Vec<(&messages::ElementRecord, Element)> = site
            .elements
            .iter()
            .filter_map(|element| Some((element, found(element.global_id).filter(is_uncertain)?)))
            .collect();
        let mut out = format!(
            "probability: {} uncertain, from {} of the schedule\n",
            counted(uncertain.len(), "element"),
            counted(self.runs as usize, "run")
        );
        for (element, Element { stands, there }) in uncertain.iter().take(MAX_ELEMENTS) {
            let name = [element.ifc_type, element.name].map(|t| site.text(t)).join(" ");
            let _ = writeln!(out, "  stands {stands:.3}, there {there:.3}: {}", name.trim());
        }
        if uncertain.len() > MAX_ELEMENTS {
            let _ = writeln!(out, "  and {}: see --json", counted(uncertain.len() - MAX_ELEMENTS, "more element"));
        }
        for space in site.spaces {
            let Some(Space { open, safest_days }) = self.spaces.get(site.text(space.global_id)) else { continue };
            let name = format!("{} {}", site.text(space.name), site.text(space.long_name));
            let safest = safest_days
                .first()
                .map_or_else(|| format!("closed for {N_DAYS} days"), |d| format!("safest {} ({:.3})", d.day, d.open));
            let _ = writeln!(out, "  open {open:.3}  {:<28} {safest}", name.trim());
        }
        out
    }
}
