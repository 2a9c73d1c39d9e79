//! The questions about rooms, doors, ways, scans and findings.

use crate::question::{Answer, Question};
use answers::findings::{FindingsAnswer, findings};
use answers::{
    Circumstances, DoorAnswer, FindError, FoundPlace, Later, OpeningAnswer, RoomAnswer, RoomsAnswer, ScansAnswer,
    Situation, WayAnswer, find_door, find_place, find_room, find_storey,
};
use messages::Site;
use std::collections::BTreeSet;
use waypoints::MissionPlanOptions;

/// Where a room is, whether the robot may enter it, what is in it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RoomQuestion {
    /// Number, name, long name or GlobalId.
    pub room: String,
}

impl Question for RoomQuestion {
    type Found = usize;
    type Answer = RoomAnswer;

    fn find(&self, site: &Site<'_>) -> Result<usize, FindError> {
        find_room(site, &self.room)
    }

    fn options(&self, site: &Site<'_>, space: &usize, options: MissionPlanOptions) -> MissionPlanOptions {
        // Scans are planned in this room alone.
        let spaces = vec![site.text(site.spaces[*space].global_id).to_owned()];
        MissionPlanOptions { spaces, ..options }
    }

    fn depends_on_start(&self) -> bool {
        true
    }

    fn answer(&self, situation: &Situation<'_>, space: &usize) -> RoomAnswer {
        answers::room(situation, *space)
    }

    fn verdict(&self, situation: &Situation<'_>, space: &usize) -> Option<bool> {
        answers::may_enter(situation.mission_plan, *space)
    }
}

impl Answer for RoomAnswer {
    fn verdict(&self) -> Option<bool> {
        self.may_enter
    }

    fn wants_later(&self) -> bool {
        self.may_enter.is_some()
    }

    fn set_changes(&mut self, changes: Later) {
        self.changes = Some(changes);
    }

    fn circumstances(&self) -> &Circumstances {
        &self.circumstances
    }
}

/// When a room opens, by the schedule and for the robot.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OpeningQuestion {
    /// Number, name, long name or GlobalId.
    pub room: String,
}

impl Question for OpeningQuestion {
    type Found = usize;
    type Answer = OpeningAnswer;

    fn find(&self, site: &Site<'_>) -> Result<usize, FindError> {
        find_room(site, &self.room)
    }

    fn options(&self, _: &Site<'_>, _: &Self::Found, options: MissionPlanOptions) -> MissionPlanOptions {
        MissionPlanOptions { kinds: BTreeSet::new(), ..options }
    }

    fn depends_on_start(&self) -> bool {
        true
    }

    fn answer(&self, situation: &Situation<'_>, space: &usize) -> OpeningAnswer {
        answers::opening(situation, *space)
    }

    fn verdict(&self, situation: &Situation<'_>, space: &usize) -> Option<bool> {
        answers::may_enter(situation.mission_plan, *space)
    }
}

impl Answer for OpeningAnswer {
    fn verdict(&self) -> Option<bool> {
        self.may_enter
    }

    fn wants_later(&self) -> bool {
        self.may_enter != Some(true)
    }

    fn set_changes(&mut self, changes: Later) {
        self.robot_may_enter = Some(changes);
    }

    fn circumstances(&self) -> &Circumstances {
        &self.circumstances
    }
}

/// Which rooms the robot may enter, and why not the others.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RoomsQuestion {
    /// Index or name of a map storey; all rooms of the site if left out.
    pub storey: Option<String>,
}

impl Question for RoomsQuestion {
    type Found = Option<u32>;
    type Answer = RoomsAnswer;

    fn find(&self, site: &Site<'_>) -> Result<Option<u32>, FindError> {
        self.storey.as_deref().map(|storey| find_storey(site, storey)).transpose()
    }

    fn options(&self, _: &Site<'_>, _: &Self::Found, options: MissionPlanOptions) -> MissionPlanOptions {
        MissionPlanOptions { kinds: BTreeSet::new(), ..options }
    }

    fn depends_on_start(&self) -> bool {
        true
    }

    fn answer(&self, situation: &Situation<'_>, storey: &Option<u32>) -> RoomsAnswer {
        answers::rooms(situation, *storey)
    }

    fn verdict(&self, situation: &Situation<'_>, storey: &Option<u32>) -> Option<bool> {
        Answer::verdict(&self.answer(situation, storey))
    }
}

impl Answer for RoomsAnswer {
    fn verdict(&self) -> Option<bool> {
        Some(self.n_may_enter == self.n_rooms)
    }

    fn circumstances(&self) -> &Circumstances {
        &self.circumstances
    }
}

/// Where a door is, and whether the robot can pass it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DoorQuestion {
    /// Name or GlobalId.
    pub door: String,
}

impl Question for DoorQuestion {
    type Found = usize;
    type Answer = DoorAnswer;

    fn find(&self, site: &Site<'_>) -> Result<usize, FindError> {
        find_door(site, &self.door)
    }

    fn options(&self, _: &Site<'_>, _: &Self::Found, options: MissionPlanOptions) -> MissionPlanOptions {
        MissionPlanOptions { kinds: BTreeSet::new(), ..options }
    }

    fn depends_on_start(&self) -> bool {
        false
    }

    fn answer(&self, situation: &Situation<'_>, door: &usize) -> DoorAnswer {
        answers::door(situation, *door)
    }

    fn verdict(&self, situation: &Situation<'_>, door: &usize) -> Option<bool> {
        answers::can_pass(situation, *door)
    }
}

impl Answer for DoorAnswer {
    fn verdict(&self) -> Option<bool> {
        self.can_pass
    }

    fn wants_later(&self) -> bool {
        true
    }

    fn set_changes(&mut self, changes: Later) {
        self.changes = Some(changes);
    }

    fn circumstances(&self) -> &Circumstances {
        &self.circumstances
    }
}

/// The way from a place to another, or what is missing.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WayQuestion {
    /// Where it begins: a room, or a point `X,Y` or `X,Y,STOREY` of the frame `map`.
    pub from: String,
    /// Where it ends.
    pub to: String,
}

impl Question for WayQuestion {
    type Found = [FoundPlace; 2];
    type Answer = WayAnswer;

    fn find(&self, site: &Site<'_>) -> Result<Self::Found, FindError> {
        Ok([find_place(site, &self.from)?, find_place(site, &self.to)?])
    }

    fn options(&self, _: &Site<'_>, _: &Self::Found, options: MissionPlanOptions) -> MissionPlanOptions {
        MissionPlanOptions { kinds: BTreeSet::new(), ..options }
    }

    fn depends_on_start(&self) -> bool {
        false
    }

    fn answer(&self, situation: &Situation<'_>, [from, to]: &Self::Found) -> WayAnswer {
        answers::way(situation, from, to)
    }

    fn verdict(&self, situation: &Situation<'_>, [from, to]: &Self::Found) -> Option<bool> {
        Some(answers::way_exists(situation, from.end, to.end))
    }
}

impl Answer for WayAnswer {
    fn verdict(&self) -> Option<bool> {
        Some(self.exists)
    }

    fn wants_later(&self) -> bool {
        !self.exists
    }

    fn set_changes(&mut self, changes: Later) {
        self.changes = Some(changes);
    }

    fn circumstances(&self) -> &Circumstances {
        &self.circumstances
    }
}

/// Which scans a room has, and what each sees.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ScansQuestion {
    /// Number, name, long name or GlobalId.
    pub room: String,
}

impl Question for ScansQuestion {
    type Found = usize;
    type Answer = ScansAnswer;

    fn find(&self, site: &Site<'_>) -> Result<usize, FindError> {
        find_room(site, &self.room)
    }

    fn options(&self, _: &Site<'_>, _: &Self::Found, options: MissionPlanOptions) -> MissionPlanOptions {
        options
    }

    fn depends_on_start(&self) -> bool {
        true
    }

    fn answer(&self, situation: &Situation<'_>, space: &usize) -> ScansAnswer {
        answers::scans(situation, *space)
    }

    fn verdict(&self, situation: &Situation<'_>, space: &usize) -> Option<bool> {
        Answer::verdict(&self.answer(situation, space))
    }
}

impl Answer for ScansAnswer {
    fn verdict(&self) -> Option<bool> {
        Some(!self.scans.is_empty())
    }

    fn circumstances(&self) -> &Circumstances {
        &self.circumstances
    }
}

/// What model, schedule and mission plan lack.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FindingsQuestion;

impl Question for FindingsQuestion {
    type Found = ();
    type Answer = FindingsAnswer;

    fn find(&self, _: &Site<'_>) -> Result<(), FindError> {
        Ok(())
    }

    fn options(&self, _: &Site<'_>, _: &Self::Found, options: MissionPlanOptions) -> MissionPlanOptions {
        options
    }

    fn depends_on_start(&self) -> bool {
        true
    }

    fn answer(&self, situation: &Situation<'_>, (): &()) -> FindingsAnswer {
        findings(situation)
    }

    fn verdict(&self, situation: &Situation<'_>, (): &()) -> Option<bool> {
        Answer::verdict(&self.answer(situation, &()))
    }
}

impl Answer for FindingsAnswer {
    fn verdict(&self) -> Option<bool> {
        Some(self.is_well())
    }

    fn circumstances(&self) -> &Circumstances {
        &self.circumstances
    }
}
