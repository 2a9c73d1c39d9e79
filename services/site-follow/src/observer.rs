//! Observations of elements by the robot: from the deviations on its bus, by the GlobalIds of the site that they were judged by.

use bus::{Bus, CheckedSample, Subscriber, topics};
use daemon::{ElementObservation, Failure, Observations};
use messages::{Deviations, Observation, ScheduleStateHead, Site};
use std::sync::Arc;

/// Follows the deviations of a robot.
#[derive(Default)]
pub(crate) struct Observer {
    ends: Option<Ends>,
    /// What was observed last, as it is told.
    observed: Option<Arc<[u8]>>,
}

/// Ends in a generation of the bus.
struct Ends {
    generation: u64,
    deviations: Subscriber<topics::Deviations>,
    sites: Subscriber<topics::Site>,
    site: Option<CheckedSample<topics::Site>>,
    /// Deviations whose site has not come yet.
    waiting: Option<CheckedSample<topics::Deviations>>,
}

impl Ends {
    fn of(bus: &Bus) -> Result<Self, Failure> {
        let (deviations, sites) = (bus.subscriber(topics::Deviations)?, bus.subscriber(topics::Site)?);
        Ok(Self { generation: bus.generation(), deviations, sites, site: None, waiting: None })
    }
}

impl Observer {
    /// What was observed, as it is told; `None` before anything was.
    ///
    /// # Errors
    /// The bus refuses, or has something that is none of its topics.
    pub(crate) fn look(&mut self, bus: Option<&Bus>) -> Result<Option<Arc<[u8]>>, Failure> {
        let Some(bus) = bus else { return Ok(self.observed.clone()) };
        let ends = match self.ends.take().filter(|ends| ends.generation == bus.generation()) {
            Some(ends) => self.ends.insert(ends),
            None => self.ends.insert(Ends::of(bus)?),
        };
        if let Some(site) = ends.sites.take()? {
            ends.site = Some(site.check()?);
        }
        if let Some(deviations) = ends.deviations.take()? {
            ends.waiting = Some(deviations.check()?);
        }
        let is_of = |deviations: &mut CheckedSample<topics::Deviations>, site: &CheckedSample<topics::Site>| {
            deviations.view().check_site(&site.view()).is_ok()
        };
        if let Some(site) = &ends.site
            && let Some(deviations) = ends.waiting.take_if(|deviations| is_of(deviations, site))
        {
            let observations = observations(&site.view(), &deviations.view());
            self.observed = Some(serde_json::to_vec(&observations)?.into());
        }
        Ok(self.observed.clone())
    }
}

/// What a robot saw of the elements of a storey. Of those that it did not see it tells nothing.
fn observations(site: &Site<'_>, deviations: &Deviations<'_>) -> Observations {
    let seen = deviations.elements.iter().filter(|record| record.observation != Observation::Unseen);
    let elements = seen.map(|record| {
        let id = site.text(site.elements[record.element as usize].global_id).to_owned();
        let (observation, verdict) = (record.observation.get().name(), record.verdict.get().name());
        (id, ElementObservation { observation: observation.to_owned(), verdict: verdict.to_owned() })
    });
    let plan_time_s = Some(deviations.head.plan_time_s).filter(|at_s| *at_s != ScheduleStateHead::NO_TIME);
    Observations { plan_time_s, elements: elements.collect() }
}
