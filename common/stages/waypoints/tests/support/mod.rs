//! Buildings drawn as text, and plans for them.
//!
//! A character is a square of 0.2 m; the first line is the north. The lower left corner of a drawing is the origin of `map`.
//!
//! | character | what it is |
//! |---|---|
//! | ` ` | nothing: unknown |
//! | `.` | floor outside of all spaces |
//! | `a` .. `z` | floor of the space of that name |
//! | `A` .. `Z`, other than those below | a part of the space without floor |
//! | `~` | floor that is keep-out |
//! | `#`, `0` .. `9` | walls: the digits are elements of their own, which may be absent |
//! | `F` | furniture |
//! | `D` | a door that swings: as wide as it is drawn, 0.1 m less is clear |
//! | `X` | a revolving door |
//! | `S`, `R`, `L`, `E` | a stair, ramp, lift, escalator: one through all storeys that show it |
//!
//! Inside of a room, what is no letter belongs to the space that surrounds it.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]
#![allow(dead_code, reason = "every test file uses a part of this")]

mod archives;
pub(crate) mod brute_force;
pub(crate) mod planned;

pub(crate) use archives::Archives;
pub(crate) use planned::Planned;

use messages::{RobotProfile, SafetyRules, SpaceRecord};
use std::collections::{BTreeMap, BTreeSet};
use waypoints::MissionPlanOptions;

/// A flight of stairs and a lift lead from the ground to two rooms above that are not connected.
pub(crate) const GROUND: &str = "
#############################
#aaaaaaaaaaaaa#bbbbbbbbbbbbb#
#aaaaaaaaaaaaa#bbbbbbbbbbbbb#
#aaaaaaaaaaaaa#bbbbbbbbbbbbb#
#SSSaaaaaaaaaaDbbbbbbbbbbLLL#
#SSSaaaaaaaaaaDbbbbbbbbbbLLL#
#SSSaaaaaaaaaaDbbbbbbbbbbLLL#
#aaaaaaaaaaaaaDbbbbbbbbbbbbb#
#aaaaaaaaaaaaaDbbbbbbbbbbbbb#
#aaaaaaaaaaaaa#bbbbbbbbbbbbb#
#############################";

/// The storey above.
pub(crate) const UPPER: &str = "
#############################
#cccccccccccccc#dddddddddddd#
#cccccccccccccc#dddddddddddd#
#cccccccccccccc#dddddddddddd#
#SSSccccccccccc#dddddddddLLL#
#SSSccccccccccc#dddddddddLLL#
#SSSccccccccccc#dddddddddLLL#
#cccccccccccccc#dddddddddddd#
#cccccccccccccc#dddddddddddd#
#cccccccccccccc#dddddddddddd#
#############################";

/// Side of a character, in tenths of a millimetre.
pub(crate) const CHARACTER: i32 = 2_000;

/// From floor to floor, in tenths of a millimetre.
pub(crate) const STOREY: i32 = 30_000;

/// A building to be.
#[derive(Clone)]
pub(crate) struct House {
    pub(crate) storeys: Vec<Drawing>,
    pub(crate) robot: RobotProfile,
    /// Distances that the robot keeps.
    pub(crate) safety: SafetyRules,
    /// How high the ground is above the floor of its storey, in metres, at a place in `map`; level if there is none.
    pub(crate) relief: Option<fn([f64; 2]) -> f64>,
    /// Side of a cell in tenths of a millimetre; divides that of a character.
    pub(crate) cell_tenths: i32,
    /// Walls, by their digits, and ways up, by their letters, that are not there.
    pub(crate) absent: BTreeSet<char>,
    /// When walls, by their digits, were finished, in civil seconds.
    pub(crate) finished: BTreeMap<char, i64>,
    /// Spaces that are blocked, and why.
    pub(crate) blocked: BTreeMap<char, &'static str>,
    /// Spaces that will be blocked, and when, in civil seconds.
    pub(crate) closing: BTreeMap<char, i64>,
    /// Spaces that are nowhere drawn, and have the outline of another one.
    pub(crate) overlaid: BTreeMap<char, char>,
    /// What else is to be said of spaces.
    pub(crate) spaces: BTreeMap<char, fn(&mut SpaceRecord)>,
}

impl House {
    pub(crate) fn drawn(storeys: &[&str]) -> Self {
        Self {
            storeys: storeys.iter().map(|text| Drawing::of(text)).collect(),
            robot: RobotProfile::DEFAULT,
            safety: SafetyRules::default(),
            relief: None,
            cell_tenths: 1_000,
            absent: BTreeSet::new(),
            finished: BTreeMap::new(),
            blocked: BTreeMap::new(),
            closing: BTreeMap::new(),
            overlaid: BTreeMap::new(),
            spaces: BTreeMap::new(),
        }
    }

    pub(crate) fn planned(&self, options: &MissionPlanOptions) -> Planned {
        Planned::new(Archives::of(self), options)
    }

    /// Names of all spaces: a space's number is its place among them.
    pub(crate) fn space_names(&self) -> Vec<char> {
        let letters = self.storeys.iter().flat_map(|s| s.rows.iter().flatten().copied()).filter_map(letter_of);
        letters
            .chain(self.spaces.keys().chain(self.overlaid.keys()).copied())
            .collect::<BTreeSet<char>>()
            .into_iter()
            .collect()
    }
}

/// Options with which small buildings are planned fast, and everything in them is scanned.
pub(crate) fn quick() -> MissionPlanOptions {
    MissionPlanOptions {
        search_steps: 20,
        tour_kicks: 20,
        classes: !0,
        min_gain_m: 0.0,
        ..MissionPlanOptions::default()
    }
}

/// The space that a character names.
pub(crate) fn letter_of(character: char) -> Option<char> {
    match character {
        'D' | 'X' | 'F' | 'S' | 'R' | 'L' | 'E' => None,
        'a'..='z' | 'A'..='Z' => Some(character.to_ascii_lowercase()),
        _ => None,
    }
}

/// A storey as text, its lowest row first; a frame of nothing is around it.
#[derive(Clone)]
pub(crate) struct Drawing {
    pub(crate) rows: Vec<Vec<char>>,
    pub(crate) width: usize,
}

impl Drawing {
    pub(crate) fn of(text: &str) -> Self {
        let lines: Vec<Vec<char>> =
            text.lines().map(|l| l.trim_end().chars().collect()).filter(|l: &Vec<char>| !l.is_empty()).collect();
        let width = lines.iter().map(Vec::len).max().unwrap();
        let framed = |mut line: Vec<char>| {
            line.resize(width + 1, ' ');
            line.insert(0, ' ');
            line
        };
        let mut rows: Vec<Vec<char>> = lines.into_iter().rev().map(framed).collect();
        rows.insert(0, vec![' '; width + 2]);
        rows.push(vec![' '; width + 2]);
        Self { rows, width: width + 2 }
    }

    /// Columns and rows of all squares that show a character.
    pub(crate) fn squares(&self, wanted: impl Fn(char) -> bool) -> Vec<[usize; 2]> {
        let all = self.rows.iter().zip(0..).flat_map(|(row, y)| row.iter().zip(0..).map(move |(&c, x)| (c, [x, y])));
        all.filter(|(c, _)| wanted(*c)).map(|(_, at)| at).collect()
    }

    /// True if there is floor outside of all spaces.
    pub(crate) fn has_floor_outside(&self) -> bool {
        !self.squares(|c| c == '.').is_empty()
    }

    pub(crate) fn at(&self, [x, y]: [usize; 2]) -> char {
        self.rows[y][x]
    }

    /// The space of every square, by its letter: what is no letter inside of a room belongs to the nearest one.
    pub(crate) fn space_of_squares(&self) -> Vec<Vec<Option<char>>> {
        let mut spaces: Vec<Vec<Option<char>>> =
            self.rows.iter().map(|row| row.iter().map(|&c| letter_of(c)).collect()).collect();
        let mut waiting = self.squares(|c| letter_of(c).is_some());
        let mut next = 0;
        while next < waiting.len() {
            let [x, y] = waiting[next];
            next += 1;
            for [x1, y1] in [[x - 1, y], [x + 1, y], [x, y - 1], [x, y + 1]] {
                let is_inside = matches!(self.rows[y1][x1], 'F' | '~' | '0'..='9' | 'S' | 'R' | 'L' | 'E');
                if is_inside && spaces[y1][x1].is_none() {
                    spaces[y1][x1] = spaces[y][x];
                    waiting.push([x1, y1]);
                }
            }
        }
        spaces
    }

    /// Connected squares (along sides) of a character, group by group.
    pub(crate) fn groups(&self, wanted: char) -> Vec<Vec<[usize; 2]>> {
        let mut left: BTreeSet<[usize; 2]> = self.squares(|c| c == wanted).into_iter().collect();
        let mut groups = Vec::new();
        while let Some(first) = left.pop_first() {
            let mut group = vec![first];
            let mut next = 0;
            while next < group.len() {
                let [x, y] = group[next];
                next += 1;
                group.extend([[x - 1, y], [x + 1, y], [x, y - 1], [x, y + 1]].into_iter().filter(|s| left.remove(s)));
            }
            groups.push(group);
        }
        groups
    }
}

/// Lower left and upper right corner of squares in `map`, in tenths of a millimetre.
pub(crate) fn bounds(squares: &[[usize; 2]]) -> [[i32; 2]; 2] {
    // The frame is outside of the origin.
    let corner = |square: usize| (square as i32 - 1) * CHARACTER;
    let end = |k: usize, most: fn(usize, usize) -> usize| squares.iter().map(|s| s[k]).reduce(most).unwrap();
    [[0, 1].map(|k| corner(end(k, usize::min))), [0, 1].map(|k| corner(end(k, usize::max) + 1))]
}
