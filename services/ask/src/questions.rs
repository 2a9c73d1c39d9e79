//! The questions: one declaration of each, for HTTP and MCP alike.
//!
//! A question is a type of parameters: its fields with their sentences are the parameters of the path and of the tool, and its
//! answer is a type of `answers`. Adding a question is adding a type and its line in [`QUESTIONS`].

use crate::document::Document;
use crate::problem::{Problem, ProblemKind};
use crate::site::{Lane, Moment};
use answers::changes::Difference;
use answers::deviations::DeviationsAnswer;
use answers::findings::FindingsAnswer;
use answers::processes::{ProcessAnswer, ProcessesAnswer};
use answers::states::{StatesAnswer, WantedElements, state_list};
use answers::tasks::{TaskList, list};
use answers::{
    Circumstances, DoorAnswer, MapUse, OpeningAnswer, RoomAnswer, RoomsAnswer, ScansAnswer, WayAnswer, find_element,
};
use daemon::{FleetElement, StatusBoard, chain};
use messages::ScheduleState;
use schedule::{EvaluateError, Period, find_task};
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use site_answers::{
    DoorQuestion, FindingsQuestion, OpeningQuestion, RoomQuestion, RoomsQuestion, ScansQuestion, WayQuestion,
    difference_between, fleet_document,
};
use std::collections::BTreeMap;

/// A question as HTTP and MCP see it.
pub(crate) struct Declared {
    /// Its name: of the tool, and at the end of the path.
    pub(crate) name: &'static str,
    /// A few words for people.
    pub(crate) title: &'static str,
    /// What it answers.
    pub(crate) about: &'static str,
    /// Lists of its answer of which a page is shown, as JSON Pointers.
    pub(crate) paged: &'static [&'static str],
    /// The schema of its parameters.
    pub(crate) parameters: fn(&mut SchemaGenerator) -> Schema,
    /// The schema of the document with its answer.
    pub(crate) document: fn(&mut SchemaGenerator) -> Schema,
    /// Reads the parameters and answers; the parameters first, so that wrong ones are told of a site without maps, too.
    pub(crate) ask: fn(Map<String, Value>) -> Result<Asked, Problem>,
}

/// A question whose parameters were read: how it is answered, and what answers it.
pub(crate) type Asked = (Lane, Box<Work>);

/// What answers a question at a moment of a site.
pub(crate) type Work = dyn FnOnce(&Moment<'_>) -> Result<Value, Problem> + Send;

/// A question.
trait Parameters: DeserializeOwned + JsonSchema + Send + 'static {
    const NAME: &str;
    const TITLE: &str;
    const ABOUT: &str;
    const PAGED: &[&str] = &[];
    /// Its answer, for the schema.
    type Answer: JsonSchema;

    /// Refuses parameters that cannot be used although their schema allows them.
    fn check(&self) -> Result<(), Problem> {
        Ok(())
    }

    /// True if maps are drawn for the answer.
    fn draws(&self) -> bool {
        false
    }

    /// The answer, a document of `Answer`.
    fn answer(&self, moment: &Moment<'_>) -> Result<Value, Problem>;
}

const fn declared<Q: Parameters>() -> Declared {
    Declared {
        name: Q::NAME,
        title: Q::TITLE,
        about: Q::ABOUT,
        paged: Q::PAGED,
        parameters: |generator| Q::json_schema(generator),
        document: |generator| Document::<Q::Answer>::json_schema(generator),
        ask: |parameters| {
            let question: Q = serde_json::from_value(Value::Object(parameters))
                .map_err(|why| Problem::of(ProblemKind::BadParameter, why.to_string()))?;
            question.check()?;
            let lane = if question.draws() { Lane::Drawing } else { Lane::AtOnce };
            Ok((lane, Box::new(move |moment| question.answer(moment))))
        },
    }
}

/// All questions.
pub(crate) static QUESTIONS: [Declared; 12] = [
    declared::<Rooms>(),
    declared::<Room>(),
    declared::<Opening>(),
    declared::<Way>(),
    declared::<Door>(),
    declared::<Changes>(),
    declared::<States>(),
    declared::<Tasks>(),
    declared::<Scans>(),
    declared::<Findings>(),
    declared::<SeenByRobots>(),
    declared::<Processes>(),
];

/// The question with a name.
///
/// # Errors
/// There is none, with all names.
pub(crate) fn question(name: &str) -> Result<&'static Declared, Problem> {
    QUESTIONS.iter().find(|question| question.name == name).ok_or_else(|| {
        let names: Vec<&str> = QUESTIONS.iter().map(|question| question.name).collect();
        let short: String = name.chars().take(MAX_NAME).collect();
        Problem::of(ProblemKind::NoSuchQuestion, format!("there is no question {short:?}: ask {}", names.join(", ")))
    })
}

/// Longest name in a question, in characters.
const MAX_NAME: usize = 400;
/// Longest date, in characters.
const MAX_DATE: usize = 40;

/// Days and instants, with or without an offset: what is no date of the calendar is refused by the answer.
const DATE: &str = r"^[0-9]{4}-[0-9]{2}-[0-9]{2}(T[0-9]{2}:[0-9]{2}(:[0-9]{2})?(Z|[+-][0-9]{2}:[0-9]{2})?)?$";

/// Refuses names that are empty or longer than any may be.
fn check_names<'a>(names: impl IntoIterator<Item = &'a str>) -> Result<(), Problem> {
    for name in names {
        if name.trim().is_empty() || name.chars().count() > MAX_NAME {
            let why = format!("a name has 1 to {MAX_NAME} characters");
            return Err(Problem::of(ProblemKind::BadParameter, why));
        }
    }
    Ok(())
}

fn check_dates<'a>(dates: impl IntoIterator<Item = &'a String>) -> Result<(), Problem> {
    for date in dates {
        if date.len() > MAX_DATE || frames::PlanTime::parse(date, Some(&jiff::tz::TimeZone::UTC)).is_err() {
            let short: String = date.chars().take(MAX_DATE).collect();
            let why = format!("{short:?} is no date: write 2024-04-15 or 2024-04-15T08:30:00");
            return Err(Problem::of(ProblemKind::BadParameter, why));
        }
    }
    Ok(())
}

fn told(answer: &impl Serialize) -> Result<Value, Problem> {
    serde_json::to_value(answer).map_err(|why| Problem::of(ProblemKind::Failed, why.to_string()))
}

/// An answer with what it was made of.
#[derive(Debug, Serialize, JsonSchema)]
struct Of<A> {
    /// What the answer is made of.
    circumstances: Circumstances,
    /// The answer.
    #[serde(flatten)]
    answer: A,
}

/// Which rooms the robot may enter.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Rooms {
    /// Index or name of a map storey; all rooms of the site if left out.
    #[serde(default)]
    #[schemars(length(min = 1, max = MAX_NAME))]
    storey: Option<String>,
    /// Date of the answer: a day (2024-04-15, throughout it) or an instant (2024-04-15T08:30:00) at the site; the maps that are
    /// shown now if left out.
    #[serde(default)]
    #[schemars(regex(pattern = DATE))]
    date: Option<String>,
}

impl Parameters for Rooms {
    const NAME: &str = "rooms";
    const TITLE: &str = "Which rooms may the robot enter";
    const ABOUT: &str = "All rooms of the site, or of a storey: whether the schedule has each open, whether this robot gets \
        there, and every reason why not.";
    const PAGED: &[&str] = &["/rooms"];
    type Answer = RoomsAnswer;

    fn check(&self) -> Result<(), Problem> {
        check_names(self.storey.as_deref())?;
        check_dates(&self.date)
    }

    fn draws(&self) -> bool {
        self.date.is_some()
    }

    fn answer(&self, moment: &Moment<'_>) -> Result<Value, Problem> {
        told(&moment.answer(&RoomsQuestion { storey: self.storey.clone() }, self.date.as_deref(), false)?)
    }
}

/// One room.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Room {
    /// Number, name, long name or GlobalId of the room.
    #[schemars(length(min = 1, max = MAX_NAME))]
    room: String,
    /// Date of the answer: a day (2024-04-15, throughout it) or an instant (2024-04-15T08:30:00) at the site; the maps that are
    /// shown now if left out.
    #[serde(default)]
    #[schemars(regex(pattern = DATE))]
    date: Option<String>,
    /// True to search when `may_enter` changes, by drawing maps of later changes of the schedule in turn; it takes a while.
    #[serde(default)]
    later: bool,
}

impl Parameters for Room {
    const NAME: &str = "room";
    const TITLE: &str = "A room";
    const ABOUT: &str = "Where a room is, whether this robot may enter it and why not, its states by the schedule, its doors, \
        scans, tasks and findings.";
    type Answer = RoomAnswer;

    fn check(&self) -> Result<(), Problem> {
        check_names([self.room.as_str()])?;
        check_dates(&self.date)
    }

    fn draws(&self) -> bool {
        self.date.is_some() || self.later
    }

    fn answer(&self, moment: &Moment<'_>) -> Result<Value, Problem> {
        told(&moment.answer(&RoomQuestion { room: self.room.clone() }, self.date.as_deref(), self.later)?)
    }
}

/// When a room opens.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Opening {
    /// Number, name, long name or GlobalId of the room.
    #[schemars(length(min = 1, max = MAX_NAME))]
    room: String,
    /// Date after which it is looked for: a day or an instant at the site; the plan time that is shown now if left out.
    #[serde(default)]
    #[schemars(regex(pattern = DATE))]
    date: Option<String>,
}

impl Parameters for Opening {
    const NAME: &str = "room_opening";
    const TITLE: &str = "When a room opens";
    const ABOUT: &str = "When the schedule opens or closes a room next, and when this robot may enter it: for that, maps of later \
        changes of the schedule are drawn in turn.";
    type Answer = OpeningAnswer;

    fn check(&self) -> Result<(), Problem> {
        check_names([self.room.as_str()])?;
        check_dates(&self.date)
    }

    fn draws(&self) -> bool {
        true
    }

    fn answer(&self, moment: &Moment<'_>) -> Result<Value, Problem> {
        told(&moment.answer(&OpeningQuestion { room: self.room.clone() }, self.date.as_deref(), true)?)
    }
}

/// A way.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Way {
    /// Where it begins: a room by number, name, long name or GlobalId, or a point X,Y,STOREY in metres of the frame map, with the
    /// index or name of a storey.
    #[schemars(length(min = 1, max = MAX_NAME))]
    from: String,
    /// Where it ends, in the same words.
    #[schemars(length(min = 1, max = MAX_NAME))]
    to: String,
    /// Date of the answer: a day (2024-04-15, throughout it) or an instant (2024-04-15T08:30:00) at the site; the maps that are
    /// shown now if left out.
    #[serde(default)]
    #[schemars(regex(pattern = DATE))]
    date: Option<String>,
    /// True to search when there is a way, if there is none, by drawing maps of later changes of the schedule in turn; it takes a
    /// while.
    #[serde(default)]
    later: bool,
}

impl Parameters for Way {
    const NAME: &str = "way";
    const TITLE: &str = "The way from a place to another";
    const ABOUT: &str = "The way of this robot from a room or point to another, over storeys, with its legs, doors and rooms; \
        or what is missing on it. Nothing is moved by asking.";
    type Answer = WayAnswer;

    fn check(&self) -> Result<(), Problem> {
        check_names([self.from.as_str(), self.to.as_str()])?;
        check_dates(&self.date)
    }

    fn draws(&self) -> bool {
        self.date.is_some() || self.later
    }

    fn answer(&self, moment: &Moment<'_>) -> Result<Value, Problem> {
        let question = WayQuestion { from: self.from.clone(), to: self.to.clone() };
        told(&moment.answer(&question, self.date.as_deref(), self.later)?)
    }
}

/// A door.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Door {
    /// Name or GlobalId of the door.
    #[schemars(length(min = 1, max = MAX_NAME))]
    door: String,
    /// Date of the answer: a day (2024-04-15, throughout it) or an instant (2024-04-15T08:30:00) at the site; the maps that are
    /// shown now if left out.
    #[serde(default)]
    #[schemars(regex(pattern = DATE))]
    date: Option<String>,
    /// True to search when `can_pass` changes, by drawing maps of later changes of the schedule in turn; it takes a while.
    #[serde(default)]
    later: bool,
}

impl Parameters for Door {
    const NAME: &str = "door";
    const TITLE: &str = "A door";
    const ABOUT: &str = "Where a door is, whether this robot can pass it, and every reason why not. Whether a way leads to it \
        is the question `way`.";
    type Answer = DoorAnswer;

    fn check(&self) -> Result<(), Problem> {
        check_names([self.door.as_str()])?;
        check_dates(&self.date)
    }

    fn draws(&self) -> bool {
        self.date.is_some() || self.later
    }

    fn answer(&self, moment: &Moment<'_>) -> Result<Value, Problem> {
        told(&moment.answer(&DoorQuestion { door: self.door.clone() }, self.date.as_deref(), self.later)?)
    }
}

/// What changes between two dates.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Changes {
    /// The first date, an instant: 2024-04-15 is its midnight.
    #[schemars(regex(pattern = DATE))]
    from: String,
    /// The second date, an instant.
    #[schemars(regex(pattern = DATE))]
    to: String,
}

impl Parameters for Changes {
    const NAME: &str = "changes";
    const TITLE: &str = "What changes between two dates";
    const ABOUT: &str = "Elements that come and go between two dates, doors that this robot can pass at one of them alone, \
        rooms that it reaches at one of them alone, and the tasks that cause it. The maps of both dates are drawn.";
    const PAGED: &[&str] = &["/elements_added", "/elements_removed", "/causes"];
    type Answer = Of<Difference<'static>>;

    fn check(&self) -> Result<(), Problem> {
        check_dates([&self.from, &self.to])
    }

    fn draws(&self) -> bool {
        true
    }

    fn answer(&self, moment: &Moment<'_>) -> Result<Value, Problem> {
        let [from_s, to_s] = [moment.instant_s(&self.from)?, moment.instant_s(&self.to)?];
        let timeline = &moment.schedule()?.timeline;
        moment.with_rasterizer(|drawing, kept| {
            let site = &moment.views.site;
            let answer = difference_between(drawing, site, timeline, [from_s, to_s], kept)?;
            let circumstances = moment.circumstances_at(Period::instant(to_s));
            told(&Of { circumstances, answer })
        })
    }
}

/// What stands at a date.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct States {
    /// Date of the answer: a day (2024-04-15, throughout it) or an instant (2024-04-15T08:30:00) at the site; the plan time that
    /// is shown now if left out.
    #[serde(default)]
    #[schemars(regex(pattern = DATE))]
    date: Option<String>,
    /// Only this element, by GlobalId or name.
    #[serde(default)]
    #[schemars(length(min = 1, max = MAX_NAME))]
    element: Option<String>,
    /// Only elements in this state.
    #[serde(default)]
    state: Option<StateName>,
}

/// The state of an element.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum StateName {
    NotStarted,
    InProgress,
    Built,
    BeingRemoved,
    Removed,
}

impl StateName {
    fn name(self) -> &'static str {
        use messages::ElementState::*;
        match self {
            Self::NotStarted => NotStarted,
            Self::InProgress => InProgress,
            Self::Built => Built,
            Self::BeingRemoved => BeingRemoved,
            Self::Removed => Removed,
        }
        .name()
    }
}

impl Parameters for States {
    const NAME: &str = "states";
    const TITLE: &str = "What stands at a date";
    const ABOUT: &str = "The state of elements and rooms by the schedule and by what was observed, with the dates on which each \
        element is built and removed.";
    const PAGED: &[&str] = &["/elements", "/rooms"];
    type Answer = StatesAnswer;

    fn check(&self) -> Result<(), Problem> {
        check_names(self.element.as_deref())?;
        check_dates(&self.date)
    }

    fn answer(&self, moment: &Moment<'_>) -> Result<Value, Problem> {
        let site = &moment.views.site;
        let wanted = match (&self.element, self.state) {
            (Some(element), _) => WantedElements::One(find_element(site, element)?),
            (None, Some(state)) => WantedElements::InState(state.name()),
            (None, None) => WantedElements::All,
        };
        let Some(date) = &self.date else {
            let state = &moment.views.state;
            return told(&state_list(site, state, moment.timeline(), wanted, &moment.circumstances));
        };
        let period = moment.period(date)?;
        let timeline = &moment.schedule()?.timeline;
        let state = timeline.schedule_state(period).finish();
        let state = ScheduleState::open(state.bytes()).map_err(|why| Problem::of(ProblemKind::Failed, chain(&why)))?;
        told(&state_list(site, &state, Some(timeline), wanted, &moment.circumstances_at(period)))
    }
}

/// The tasks of the schedule.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Tasks {
    /// Only this task, by GlobalId, identification or name.
    #[serde(default)]
    #[schemars(length(min = 1, max = MAX_NAME))]
    task: Option<String>,
    /// Date of the status of the tasks: 2024-04-15 (its midnight) or 2024-04-15T08:30:00; the plan time that is shown now if left
    /// out.
    #[serde(default)]
    #[schemars(regex(pattern = DATE))]
    date: Option<String>,
}

impl Parameters for Tasks {
    const NAME: &str = "tasks";
    const TITLE: &str = "The tasks of the schedule";
    const ABOUT: &str = "The tasks with their dates and their status at a date, the elements and rooms that each acts on, and \
        what is wrong with them.";
    const PAGED: &[&str] = &["/tasks"];
    type Answer = Of<TaskList<'static>>;

    fn check(&self) -> Result<(), Problem> {
        check_names(self.task.as_deref())?;
        check_dates(&self.date)
    }

    fn answer(&self, moment: &Moment<'_>) -> Result<Value, Problem> {
        let site = &moment.views.site;
        let timeline = &moment.schedule()?.timeline;
        let wanted = self.task.as_deref().map(|task| find_task(site, task)).transpose();
        let wanted = wanted.map_err(|why| {
            let is_one_of_several = matches!(why, EvaluateError::SeveralTasks { .. });
            let kind = if is_one_of_several { ProblemKind::SeveralNames } else { ProblemKind::UnknownName };
            Problem::of(kind, chain(&why))
        })?;
        let asked_s = self.date.as_deref().map(|date| moment.instant_s(date)).transpose()?;
        let shown_s = moment.views.state.head.plan_time().map(|at| at.civil_seconds());
        let circumstances = match asked_s {
            Some(at_s) => moment.circumstances_at(Period::instant(at_s)),
            None => moment.circumstances.clone(),
        };
        let answer = list(site, timeline, asked_s.or(shown_s), wanted.as_ref().map(std::slice::from_ref));
        told(&Of { circumstances, answer })
    }
}

/// The scans of a room.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Scans {
    /// Number, name, long name or GlobalId of the room.
    #[schemars(length(min = 1, max = MAX_NAME))]
    room: String,
    /// Date of the answer: a day (2024-04-15, throughout it) or an instant (2024-04-15T08:30:00) at the site; the maps that are
    /// shown now if left out.
    #[serde(default)]
    #[schemars(regex(pattern = DATE))]
    date: Option<String>,
}

impl Parameters for Scans {
    const NAME: &str = "scans";
    const TITLE: &str = "The scans of a room";
    const ABOUT: &str = "Where the robot scans in a room and what each scan sees, or why there is none.";
    type Answer = ScansAnswer;

    fn check(&self) -> Result<(), Problem> {
        check_names([self.room.as_str()])?;
        check_dates(&self.date)
    }

    fn draws(&self) -> bool {
        self.date.is_some()
    }

    fn answer(&self, moment: &Moment<'_>) -> Result<Value, Problem> {
        told(&moment.answer(&ScansQuestion { room: self.room.clone() }, self.date.as_deref(), false)?)
    }
}

/// What was assumed.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Findings {
    /// Date of the answer: a day (2024-04-15, throughout it) or an instant (2024-04-15T08:30:00) at the site; the maps that are
    /// shown now if left out.
    #[serde(default)]
    #[schemars(regex(pattern = DATE))]
    date: Option<String>,
}

impl Parameters for Findings {
    const NAME: &str = "findings";
    const TITLE: &str = "What the converter found and assumed";
    const ABOUT: &str = "Errors and warnings about model, schedule and waypoints, floors and widths that are assumed, boxes in \
        place of bodies that could not be made, rooms and storeys on no map.";
    const PAGED: &[&str] =
        &["/errors/list", "/warnings/list", "/assumptions/list", "/substitutions/list", "/left_out/list"];
    type Answer = FindingsAnswer;

    fn check(&self) -> Result<(), Problem> {
        check_dates(&self.date)
    }

    fn draws(&self) -> bool {
        self.date.is_some()
    }

    fn answer(&self, moment: &Moment<'_>) -> Result<Value, Problem> {
        told(&moment.answer(&FindingsQuestion, self.date.as_deref(), false)?)
    }
}

/// What robots saw that differs.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct SeenByRobots {}

/// What robots saw that differs: the one of these maps, and all that tell the server of the site.
#[derive(Debug, Serialize, JsonSchema)]
struct SeenAnswer {
    /// By the robot of these maps.
    #[serde(flatten)]
    own: DeviationsAnswer,
    /// By robots that tell the server of this site: conflicts first. Null for a site without a link with robots.
    robots: Option<Vec<FleetElement>>,
    /// Why nothing is known of robots that tell the server; null if it is, or there is no link.
    why_no_robots: Option<String>,
}

impl Parameters for SeenByRobots {
    const NAME: &str = "deviations";
    const TITLE: &str = "What robots saw that differs from the plan";
    const ABOUT: &str = "Elements that the robot saw late, early or displaced, what stands beside them and is no element of the \
        model, and what other robots of the site tell.";
    const PAGED: &[&str] = &["/seen/elements", "/seen/obstacles", "/robots"];
    type Answer = SeenAnswer;

    fn answer(&self, moment: &Moment<'_>) -> Result<Value, Problem> {
        let seen = moment.seen_deviations();
        let why_none = "no map of the robot with a pose in effect was compared with this site";
        let (robots, why_no_robots) = match fleet_document(moment.config) {
            Ok(document) => (document.map(|document| document.elements), None),
            Err(why) => (None, Some(chain(&why))),
        };
        let why_none = seen.is_none().then(|| why_none.to_owned());
        let own = DeviationsAnswer { circumstances: moment.circumstances.clone(), seen, why_none };
        told(&SeenAnswer { own, robots, why_no_robots })
    }
}

/// Which processes run.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Processes {}

/// The processes of a site, and whether its maps may be used.
#[derive(Debug, Serialize, JsonSchema)]
struct SiteProcesses {
    /// What the answer is made of.
    circumstances: Circumstances,
    /// Whether its maps may be used.
    maps: MapUse,
    /// The processes by name.
    processes: BTreeMap<String, ProcessAnswer>,
}

impl Parameters for Processes {
    const NAME: &str = "processes";
    const TITLE: &str = "Which processes run, and whether the maps may be used";
    const ABOUT: &str = "The processes of the site, what each does and says, and whether its maps may be used now.";
    type Answer = SiteProcesses;

    fn answer(&self, moment: &Moment<'_>) -> Result<Value, Problem> {
        let board = StatusBoard::of_site(moment.config);
        let board = board.map_err(|why| Problem::of(ProblemKind::NotKnown, chain(&why)))?;
        let seen = board.processes(moment.config).map(|process| board.seen(process));
        let maps = moment.circumstances.maps.clone().unwrap_or_else(|| MapUse::of(None));
        let ProcessesAnswer { processes, maps } = ProcessesAnswer::of(seen, maps);
        let processes = processes.into_iter().map(|process| (process.name.clone(), process)).collect();
        told(&SiteProcesses { circumstances: moment.circumstances.clone(), maps, processes })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    /// The detail of the problem with parameters of a question; none if they can be used.
    fn refused(name: &str, parameters: Value) -> Option<String> {
        let Value::Object(parameters) = parameters else { panic!("{parameters}") };
        let problem = (question(name).unwrap().ask)(parameters).err()?;
        assert_eq!(problem.status(), 400);
        Some(serde_json::to_value(&problem).unwrap()["detail"].as_str().unwrap().to_owned())
    }

    #[test]
    fn parameters_that_cannot_be_used_are_refused_before_anything_is_done() {
        assert_eq!(refused("room", json!({"room": "G.02", "date": "2024-04-15T08:30:00", "later": true})), None);
        assert_eq!(refused("rooms", json!({})), None);
        for (name, parameters, word) in [
            ("room", json!({}), "room"),
            ("room", json!({"room": ""}), "1 to 400"),
            ("room", json!({"room": "x".repeat(401)}), "1 to 400"),
            ("room", json!({"room": 7}), "string"),
            ("room", json!({"room": "a", "date": "15/04/2024"}), "is no date"),
            ("room", json!({"room": "a", "date": "2024-02-30"}), "is no date"),
            ("room", json!({"room": "a", "date": "9".repeat(5_000)}), "is no date"),
            ("room", json!({"room": "a", "path": "/etc/passwd"}), "unknown field"),
            ("way", json!({"from": "a"}), "to"),
            ("states", json!({"state": "gone"}), "unknown variant"),
            ("processes", json!({"confirm": true}), "unknown field"),
        ] {
            let why = refused(name, parameters.clone()).unwrap_or_else(|| panic!("{name} {parameters}"));
            assert!(why.contains(word) && why.len() < 300, "{name}: {why}");
        }
        assert_eq!(question("../../etc/passwd").err().unwrap().status(), 404);
    }
}
