//! The layer: for each cell the limit of speed and the cost, with the rule and the element that they come from.

use crate::door_swings::door_swings;
use crate::local_ground::LocalGround;
use crate::rule_elements::StoreyElements;
use crate::stair_cells::stair_cells;
use crate::stair_edges::stair_edges;
use grid::{CellRect, Class, GridSpec, Run, fifths_of, grow_labelled};
use messages::{
    ContentHash, Grid, Grids, SafetyKind, SafetyRuleRecord, SafetyRules, SafetySubject, ScheduleState, Site,
};
use std::collections::BTreeMap;

/// Of cells that no rule is about.
pub const NO_SOURCE: u32 = u32::MAX;

/// Cost beside an element and at the end of the distance, per cent of what is lethal.
const COSTS: [u32; 2] = [90, 10];

/// What a layer is made from.
#[derive(Clone, Copy)]
pub struct SafetyInput<'a> {
    /// Geometry and facts.
    pub site: &'a Site<'a>,
    /// States at the plan time.
    pub schedule_state: &'a ScheduleState<'a>,
    /// Index of the grids, with the rules of the robot.
    pub index: &'a Grids<'a>,
}

/// An element that a rule is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct SafetySource {
    /// Of the rules of the robot.
    pub rule: u32,
    /// Element of the site.
    pub element: u32,
}

/// The cells of a map storey near elements that rules are about; row-major from the lower left.
#[derive(Debug, Clone, PartialEq)]
pub struct SafetyLayer {
    /// Where the cells lie: as those of the grid.
    pub spec: GridSpec,
    /// The rules of the robot, and after them that of the cost of stairs on which it drives.
    pub rules: SafetyRules,
    /// Cost of cells on stairs, per cent of what is lethal; 0 where no robot drives.
    pub stair_cost: u8,
    /// What the rules are about on this storey, by rule, then by element.
    pub sources: Vec<SafetySource>,
    /// Index of the source that limits the speed in each cell, or [`NO_SOURCE`].
    pub speed_source: Vec<u32>,
    /// Cost of each cell, per cent of what is lethal; 0 for none.
    pub cost: Vec<u8>,
    /// Index of the source that each cost comes from, or [`NO_SOURCE`].
    pub cost_source: Vec<u32>,
}

/// The values of Nav2's speed mask of a map storey, in steps of [`speed_step_m_s`]; 0 in every cell for a robot without rules.
pub fn speed_mask(input: SafetyInput<'_>, grid: &Grid<'_>) -> Vec<i8> {
    SafetyLayer::of(input, grid).map_or_else(|| vec![0; grid.spec().n_cells()], |layer| layer.speed_mask())
}

impl SafetyLayer {
    /// The layer of a map storey; `None` for a robot without rules that does not drive on stairs.
    pub fn of(input: SafetyInput<'_>, grid: &Grid<'_>) -> Option<Self> {
        let robot = &input.index.head.robot;
        let rules = SafetyRules::of(input.index).with_costs_of(robot);
        if rules.is_empty() {
            return None;
        }
        let spec = grid.spec();
        let n = spec.n_cells();
        let mut layer = Self {
            spec,
            rules: rules.clone(),
            stair_cost: robot.stair_cost as u8,
            sources: Vec::new(),
            speed_source: vec![NO_SOURCE; n],
            cost: vec![0; n],
            cost_source: vec![NO_SOURCE; n],
        };
        let ground = &LocalGround::of(grid);
        let storey = StoreyElements { site: input.site, schedule_state: input.schedule_state, grid, ground };
        // A closed room is occupied everywhere; its floor is free of obstacles where it shows no class.
        let is_open =
            |cell: usize| grid.planning[cell] == 0 || (grid.floor[cell] != 0 && grid.class[cell] == Class::None.id());
        let is_edge =
            |cell: usize| ground.is_beside(cell) && grid.planning[cell] < 0 && grid.class[cell] == Class::None.id();
        let is_passed = |cell: usize| is_open(cell) || is_edge(cell);
        let mut distance = vec![u32::MAX; n];
        for (number, rule) in (0..).zip(rules.records()) {
            let seeds = match rules.subject(rule) {
                SafetySubject::StairEdge => stair_edges(storey),
                SafetySubject::DoorSwing => door_swings(storey, &is_passed),
                SafetySubject::Stair => stair_cells(storey),
                subject => storey.cells_of(subject),
            };
            layer.add((number, rule), &seeds, (&is_open, &is_passed), &mut distance);
        }
        Some(layer)
    }

    /// Adds the open cells near the elements of a rule, along cells that are passed; `distance` is that of the element that limits the
    /// speed, by cell.
    fn add(
        &mut self,
        (number, rule): (u32, &SafetyRuleRecord),
        seeds: &[(u32, Vec<Run>)],
        (is_open, is_passed): (&impl Fn(usize) -> bool, &impl Fn(usize) -> bool),
        distance: &mut [u32],
    ) {
        let reach = fifths_of(rule.distance_m / self.spec.resolution_m());
        let first = self.sources.len() as u32;
        self.sources.extend(seeds.iter().map(|(element, _)| SafetySource { rule: number, element: *element }));
        let whole = CellRect::whole(self.spec.width, self.spec.height);
        let runs = (first..).zip(seeds).map(|(source, (_, runs))| (source, runs.as_slice()));
        let nearest = grow_labelled(whole, is_passed, runs, reach);
        for (cell, nearest) in nearest.into_iter().enumerate() {
            let Some(nearest) = nearest.filter(|_| is_open(cell)) else { continue };
            if rule.speed_m_s > 0.0 {
                let before = self.speed_m_s(cell).unwrap_or(f64::INFINITY);
                let is_nearer = rule.speed_m_s <= before && nearest.fifths < distance[cell];
                if rule.speed_m_s < before || is_nearer {
                    (self.speed_source[cell], distance[cell]) = (nearest.label, nearest.fifths);
                }
            }
            let cost = match ((COSTS[0] - COSTS[1]) * nearest.fifths).checked_div(reach) {
                Some(share) => (COSTS[0] - share) as u8,
                None if rule.kind == SafetyKind::Stair => self.stair_cost,
                None => 0,
            };
            if cost > self.cost[cell] {
                (self.cost[cell], self.cost_source[cell]) = (cost, nearest.label);
            }
        }
    }

    /// The limit of speed in a cell.
    pub fn speed_m_s(&self, cell: usize) -> Option<f64> {
        let source = self.sources.get(self.speed_source[cell] as usize)?;
        Some(self.rules.records()[source.rule as usize].speed_m_s)
    }

    /// True if the robot is not to be in the cell unless no other place or way serves: a distance is kept from an element there, or it
    /// is on a stair.
    pub fn is_within_distance(&self, cell: usize) -> bool {
        self.cost[cell] != 0
    }

    /// The values of Nav2's speed mask: 0 without a limit, else 1 to 100 steps of [`speed_step_m_s`], rounded down.
    pub fn speed_mask(&self) -> Vec<i8> {
        let step_m_s = speed_step_m_s(self.rules.records());
        let value = |speed_m_s: f64| ((speed_m_s / step_m_s + 1e-9).floor()).clamp(1.0, 100.0) as i8;
        (0..self.spec.n_cells()).map(|cell| self.speed_m_s(cell).map_or(0, value)).collect()
    }

    /// True if any cell has a limit of speed.
    pub fn limits_speed(&self) -> bool {
        self.rules.records().iter().any(|rule| rule.speed_m_s > 0.0)
    }

    /// True if cells may have a cost: a distance is kept, or stairs are driven on.
    pub fn has_costs(&self) -> bool {
        self.stair_cost > 0 || self.rules.records().iter().any(|rule| rule.distance_m > 0.0)
    }

    /// The values of a mask of costs: -1 without a cost, which Nav2's filter skips, else 1 to 99.
    pub fn cost_mask(&self) -> Vec<i8> {
        self.cost.iter().map(|&cost| if cost == 0 { -1 } else { cost.cast_signed() }).collect()
    }

    /// Hash of what it says of each cell.
    pub fn content_hash(&self) -> ContentHash {
        let sources: BTreeMap<SafetySource, u32> = self.sources.iter().copied().zip(0..).collect();
        let sources = sources.into_iter().flat_map(|(source, number)| [source.rule, source.element, number]);
        let mut bytes: Vec<u8> = sources.flat_map(u32::to_le_bytes).collect();
        bytes.extend_from_slice(bytemuck::cast_slice(self.rules.records()));
        bytes.extend(self.speed_source.iter().flat_map(|source| source.to_le_bytes()));
        bytes.extend(self.cost_source.iter().flat_map(|source| source.to_le_bytes()));
        bytes.extend_from_slice(&self.cost);
        ContentHash::of(&bytes)
    }
}

/// Metres per second of one step of a speed mask: a hundredth of the highest limit of the rules, rounded up to whole metres per
/// second.
pub fn speed_step_m_s(rules: &[SafetyRuleRecord]) -> f64 {
    let highest = rules.iter().map(|rule| rule.speed_m_s).fold(1.0, f64::max);
    highest.ceil() / 100.0
}
