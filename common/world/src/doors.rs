//! Doors of the world: placement, joints and limits.

use crate::door_links::{Board, JointKind, Link, Opening, boards_at, links_of};
use crate::joint_limits::{NearbyObstacles, Obstacles, Prism};
use crate::options::{DoorMode, WorldOptions};
use crate::static_elements::{StaticElement, link_name, stands, storey_at, storey_of};
use export::ExportInput;
use frames::{TENTHS_PER_M, metres};
use geometry::OrientedBox;
use messages::door_operations::{DoorFrame, Leaf, LeafMotion, OperationSource, mirrored, operation_of};
use messages::{DoorRecord, NONE};
use std::f64::consts::FRAC_PI_4;

/// Insets of leaves at each side, tried in order until they do not intersect elements beside the opening.
const INSETS_M: [f64; 5] = [0.0, 0.01, 0.02, 0.03, 0.05];

/// A threshold or floor finish under a door is at most this high above the opening's lower end.
const THRESHOLD_M: f64 = 0.15;

/// Maximum height of a floor above the lower end of an opening to which a door is shortened.
const FLOOR_ABOVE_M: f64 = 0.5;

/// Steps of the collision test of motions: 2 degrees, 2 cm.
const STEP_RAD: f64 = std::f64::consts::PI / 90.0;
const STEP_M: f64 = 0.02;

/// Minimum range of a joint; with less it is fixed.
const MIN_RANGE: f64 = 0.1;

/// A door of the world.
#[derive(Debug)]
pub(crate) struct WorldDoor {
    pub(crate) door: u32,
    pub(crate) element: u32,
    /// Its name in the world.
    pub(crate) name: String,
    pub(crate) storey: u32,
    /// Its operation type; `fixed` if it does not move.
    pub(crate) operation: String,
    pub(crate) source: OperationSource,
    /// True if the model does not define left side and front.
    pub(crate) sides_assumed: bool,
    /// The door's frame in `map`: left jamb, middle of the wall, floor; yaw of its x axis.
    pub(crate) origin_m: [f64; 3],
    pub(crate) yaw_rad: f64,
    pub(crate) opening: Opening,
    /// Inset of the leaves at each side.
    pub(crate) inset_m: f64,
    /// Boards of the lining.
    pub(crate) lining: Vec<Board>,
    pub(crate) links: Vec<Link>,
    /// For each link the names of the elements that end its motion early, at the lower and upper limit.
    pub(crate) stopped_by: Vec<[Option<String>; 2]>,
}

impl WorldDoor {
    /// Values of its joints: open as far as they go, or closed.
    pub(crate) fn values(&self, mode: DoorMode) -> Vec<f64> {
        let farthest = |l: &Link| if l.limits[1] >= -l.limits[0] { l.limits[1] } else { l.limits[0] };
        // A door that turns is as open one way as the other.
        let open = |l: &Link| if l.boards.len() > 1 { FRAC_PI_4 } else { farthest(l) };
        self.links
            .iter()
            .map(|l| if mode == DoorMode::Open && l.kind != JointKind::Fixed { open(l) } else { 0.0 })
            .collect()
    }
}

/// True for an element that is a door with a passage in an opening.
pub(crate) fn is_door(input: &ExportInput<'_>, element: u32) -> bool {
    let site = input.site;
    let record = &site.elements[element as usize];
    site.doors.get(record.door as usize).is_some_and(|d| d.opens != 0 && d.passage.half[0] > 0.0)
}

/// True if door and host wall stand.
pub(crate) fn is_hung(input: &ExportInput<'_>, door: &DoorRecord) -> bool {
    let host = input.site.openings.get(door.opening as usize).map_or(NONE, |o| o.host);
    stands(input, door.element) && (host == NONE || input.schedule_state.effective(host as usize).is_obstacle())
}

/// All hung doors, in the order of the site.
pub(crate) fn doors(input: &ExportInput<'_>, options: &WorldOptions, statics: &[StaticElement]) -> Vec<WorldDoor> {
    let obstacles = Obstacles::of(statics);
    let hung = (0..).zip(input.site.doors).filter(|(_, d)| is_door(input, d.element) && is_hung(input, d));
    let passage = |door: &DoorRecord| {
        let moving = door.passage.to_box();
        input.site.moving_leaves(door).map_or(moving, |leaves| leaves.whole_of(&moving, door.hanging.along))
    };
    hung.map(|(index, door)| {
        DoorBuilder { input, options, door, passage: passage(door) }.door(index, &obstacles, statics)
    })
    .collect()
}

struct DoorBuilder<'a> {
    input: &'a ExportInput<'a>,
    options: &'a WorldOptions,
    door: &'a DoorRecord,
    /// Passage of the whole door, also where a leaf of it is fixed.
    passage: OrientedBox,
}

impl DoorBuilder<'_> {
    fn door(&self, index: u32, obstacles: &Obstacles, statics: &[StaticElement]) -> WorldDoor {
        let (input, door) = (self.input, self.door);
        let record = &input.site.elements[door.element as usize];
        let frame = DoorFrame::of(door, &self.passage);
        let (operation, mut leaves, source) = operation_of(input.site, door, &self.options.door.unknown)
            .unwrap_or_else(|| {
                let leaf = Leaf { span: [0.0, 1.0], motion: LeafMotion::Fixed };
                ("fixed".to_owned(), vec![leaf], OperationSource::Assumed)
            });
        if frame.turned {
            mirrored(&mut leaves);
        }
        let (bottom, height) = self.heights();
        let [x, y] = frame.origin.map(|c| c / f64::from(TENTHS_PER_M));
        let origin_m = [x, y, bottom];
        let reach = self.width_m() + height + 1.0;
        let near = obstacles.near([0, 1].map(|side| {
            let sign = [-1.0, 1.0][side];
            [0, 1, 2].map(|k| origin_m[k] + sign * 2.0 * reach)
        }));
        let room = DoorSurroundings { near, origin_m, along: frame.along };
        let (opening, inset_m, links) = self.fitted(&leaves, height, &room);
        let (links, stopped_by) = room.limited(links);
        let name_of = |k: usize| statics[k].link.clone();
        WorldDoor {
            door: index,
            element: door.element,
            name: link_name(input, record),
            storey: if record.storey == NONE { storey_at(input, bottom) } else { storey_of(input, record) },
            operation,
            source,
            sides_assumed: frame.assumed,
            origin_m,
            yaw_rad: libm::atan2(frame.along[1], frame.along[0]),
            lining: self.lining(&opening),
            opening,
            inset_m,
            links,
            stopped_by: stopped_by.into_iter().map(|ends| ends.map(|k| k.map(name_of))).collect(),
        }
    }

    fn width_m(&self) -> f64 {
        2.0 * self.passage.half[0] / f64::from(TENTHS_PER_M)
    }

    /// Height of the floor in `map`, and of the opening above it.
    fn heights(&self) -> (f64, f64) {
        let (site, door) = (self.input.site, self.door);
        let record = &site.elements[door.element as usize];
        let opening = site.openings.get(door.opening as usize).filter(|o| o.plan.half[0] > 0.0);
        let (low, high) =
            opening.map_or((record.min_tenths[2], record.max_tenths[2]), |o| (o.bottom_z_tenths, o.top_z_tenths));
        let (low, high) = (metres(low), metres(high));
        let floors = site.levels().map(|(_, s)| metres(s.floor_z_tenths));
        let bottom = floors.filter(|f| low < *f && *f <= (low + FLOOR_ABOVE_M).min(high)).fold(low, f64::max);
        let height = high - bottom;
        let own = door.overall_height_m;
        (bottom, if 0.5 < own && own < height { own } else { height })
    }

    fn opening(&self, height: f64, threshold: f64, inset_m: f64) -> Opening {
        let (door, door_options) = (self.door, &self.options.door);
        let leaf_m = if door.hanging.leaf_m > 0.0 { door.hanging.leaf_m } else { door_options.thickness_m };
        Opening {
            width_m: self.width_m(),
            z_m: [threshold + door_options.floor_gap_m, height - inset_m],
            depth_m: 2.0 * self.passage.half[1] / f64::from(TENTHS_PER_M),
            leaf_m: leaf_m.clamp(0.005, 0.3),
            side_m: door_options.side_gap_m + self.lining_m() + inset_m,
        }
    }

    /// Width of the lining, if it leaves room for leaves.
    fn lining_m(&self) -> f64 {
        let lining = self.door.hanging.lining_m;
        if lining < 0.2 * self.width_m() { lining } else { 0.0 }
    }

    /// Posts and head of the lining, where the model says how wide they are.
    fn lining(&self, opening: &Opening) -> Vec<Board> {
        let lining = self.lining_m();
        if lining < 0.005 || opening.depth_m < 0.005 {
            return Vec::new();
        }
        let (width, high, depth) = (opening.width_m, opening.z_m[1], opening.depth_m);
        let post = |x: f64| Board { centre_m: [x, 0.0, high / 2.0], size_m: [lining, depth, high] };
        vec![post(lining / 2.0), post(width - lining / 2.0)]
    }

    /// The links, drawn in as far as it takes to be free when closed, above what lies on the floor where they move.
    fn fitted(&self, leaves: &[Leaf], height: f64, room: &DoorSurroundings<'_>) -> (Opening, f64, Vec<Link>) {
        let links_in = |opening: &Opening| -> Vec<Link> {
            let mut links: Vec<Link> = Vec::new();
            for leaf in leaves {
                let first = links.len();
                let more = room.best_side(leaf, opening);
                links.extend(more.into_iter().map(|l| Link { parent: l.parent.map(|p| p + first), ..l }));
            }
            named(links)
        };
        let plain = self.opening(height, 0.0, 0.0);
        let threshold = room.threshold_m(&links_in(&plain)).min(height / 2.0);
        let mut fitted = None;
        for inset in INSETS_M {
            let opening = self.opening(height, threshold, inset);
            let links = links_in(&opening);
            let is_free = links.iter().all(|l| boards_at(l, 0.0).all(|b| room.meets(&b).is_none()));
            if is_free || fitted.is_none() {
                fitted = Some((opening, inset, links));
            }
            if is_free {
                break;
            }
        }
        fitted.expect("the first inset gives links")
    }
}

fn named(mut links: Vec<Link>) -> Vec<Link> {
    let n = links.len();
    for (k, link) in links.iter_mut().enumerate() {
        link.name = if n == 1 { "leaf".to_owned() } else { format!("leaf_{}", k + 1) };
    }
    links
}

/// The static elements around a door, in the frame of the door.
struct DoorSurroundings<'a> {
    near: NearbyObstacles<'a>,
    origin_m: [f64; 3],
    along: [f64; 2],
}

impl DoorSurroundings<'_> {
    fn in_map(&self, prism: &Prism) -> Prism {
        let [ax, ay] = self.along;
        let point = |p: &[f64; 2]| [self.origin_m[0] + ax * p[0] - ay * p[1], self.origin_m[1] + ay * p[0] + ax * p[1]];
        Prism { plan_m: prism.plan_m.iter().map(point).collect(), z_m: prism.z_m.map(|z| z + self.origin_m[2]) }
    }

    fn meets(&self, prism: &Prism) -> Option<usize> {
        self.near.meets(&self.in_map(prism))
    }

    /// The links of a leaf on the side of the wall with the larger range; the front if equal.
    fn best_side(&self, leaf: &Leaf, opening: &Opening) -> Vec<Link> {
        let goes_off_wall = matches!(leaf.motion, LeafMotion::Slide { .. } | LeafMotion::Rise);
        let links = |front: f64| links_of(leaf, opening, front, self.headroom_m(leaf, opening, front));
        if !goes_off_wall {
            return links(1.0);
        }
        let (front, back) = (links(1.0), links(-1.0));
        let range = |links: &[Link]| links.iter().map(|l| self.reach(l, l.limits[1]).0).fold(f64::INFINITY, f64::min);
        if range(&back) > range(&front) + STEP_M { back } else { front }
    }

    /// Free height above a leaf that rises.
    fn headroom_m(&self, leaf: &Leaf, opening: &Opening, front: f64) -> f64 {
        if leaf.motion != LeafMotion::Rise {
            return f64::INFINITY;
        }
        let whole = links_of(leaf, opening, front, f64::INFINITY);
        whole.iter().map(|l| self.reach(l, l.limits[1]).0).fold(f64::INFINITY, f64::min)
    }

    /// Top of what lies on the floor under the leaves while they move, above the door's origin.
    fn threshold_m(&self, links: &[Link]) -> f64 {
        let low = self.origin_m[2];
        let mut top = low;
        for link in links {
            let n = 12;
            for k in 0..=n {
                let q = link.limits[0] + (link.limits[1] - link.limits[0]) * f64::from(k) / f64::from(n);
                for board in boards_at(link, q) {
                    top = top.max(self.near.top_under(&self.in_map(&board).plan_m, [low, low + THRESHOLD_M]));
                }
            }
        }
        top - low
    }

    /// Range of a joint towards a value, and the obstacle that ends it.
    fn reach(&self, link: &Link, goal: f64) -> (f64, Option<usize>) {
        let step = if link.kind == JointKind::Revolute { STEP_RAD } else { STEP_M };
        // Wings that turn look the same after a quarter.
        let goal_seen = if link.boards.len() > 1 { goal.clamp(-1.6, 1.6) } else { goal };
        let reaches = link.boards.iter().enumerate().map(|(k, _)| {
            let at = |q: f64| {
                let board = boards_at(link, q).nth(k).expect("a board of the link");
                self.in_map(&board)
            };
            self.near.reach(goal_seen, step, at)
        });
        let worst = reaches.min_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
        match worst {
            Some((end, None)) if end == goal_seen => (goal, None),
            Some(found) => found,
            None => (goal, None),
        }
    }

    /// The links with their joint limits reduced to where the leaves would hit something; links with too little range are fixed.
    fn limited(&self, links: Vec<Link>) -> (Vec<Link>, Vec<[Option<usize>; 2]>) {
        let limit = |mut link: Link| {
            if link.kind == JointKind::Fixed {
                return (link, [None, None]);
            }
            let [lower, upper] =
                link.limits.map(|goal| if goal == 0.0 { (0.0, None) } else { self.reach(&link, goal) });
            link.limits = [lower.0, upper.0];
            if upper.0 - lower.0 < MIN_RANGE {
                link.kind = JointKind::Fixed;
                link.limits = [0.0; 2];
            }
            (link, [lower.1, upper.1])
        };
        links.into_iter().map(limit).unzip()
    }
}
