//! Asks schedule-eval, which alone has the rules, schedule files and progress in force, for its verdict on a candidate.

use bus::Bus;
use daemon::{Answer, Client, OpenRequest, ScheduleRequest, ScheduleVerdict};
use messages::ContentHash;

/// Who judges candidates.
pub trait Judge: Send {
    /// Joins a generation of the bus.
    fn attach(&mut self, bus: &Bus);

    /// What was found of the candidate with this content hash; `None` as long as nothing is known, or nobody is there to ask.
    fn verdict(&mut self, site_hash: ContentHash) -> Option<ScheduleVerdict>;

    /// No candidate is there: lets go of what is needed to ask.
    fn rest(&mut self);
}

/// schedule-eval, by requests. It may die, or be busy: it is asked until it has answered.
#[derive(Default)]
pub(crate) struct ScheduleEval {
    bus: Option<Bus>,
    client: Option<Client<ScheduleRequest>>,
    asked: Option<OpenRequest<ScheduleRequest>>,
}

impl Judge for ScheduleEval {
    fn attach(&mut self, bus: &Bus) {
        *self = Self { bus: Some(bus.clone()), client: None, asked: None };
    }

    fn verdict(&mut self, site_hash: ContentHash) -> Option<ScheduleVerdict> {
        if self.client.is_none() {
            self.client = Client::of(self.bus.as_ref()?).ok();
        }
        let Some(asked) = &self.asked else {
            self.asked = self.client.as_ref()?.send(&ScheduleRequest::GetVerdict).ok();
            return None;
        };
        let answer = match asked.take() {
            Ok(Some(Answer::Done(answer))) => Some(answer),
            Ok(_) => return None,
            Err(_) => None,
        };
        self.asked = None;
        answer?.verdict.filter(|verdict| verdict.site_hash == site_hash)
    }

    fn rest(&mut self) {
        (self.client, self.asked) = (None, None);
    }
}
