//! People who walk while the robot drives, seen as legs.

use crate::plane::{Vector, direction_of, left_of, moved, scaled};
use crate::random_generator::RandomGenerator;
use crate::world::{Material, World};

/// Steps during which a person is in sight.
const STEPS: [usize; 2] = [3, 25];

/// The cross-section of a leg or a body.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Disc {
    pub(crate) centre: Vector,
    pub(crate) radius_m: f64,
}

struct Person {
    at: Vector,
    /// Unit vector.
    heading: Vector,
    metres_per_step: f64,
    /// Half the distance between the legs; 0 for a body at the height of the lidar.
    stride_m: f64,
    steps_left: f64,
}

/// All people in sight of the robot.
pub(crate) struct People {
    per_scan: f64,
    steps: f64,
    people: Vec<Person>,
}

impl People {
    /// So many in sight of a scan, who walk so many steps between two scans.
    pub(crate) fn new(per_scan: f64, steps: f64) -> Self {
        Self { per_scan, steps, people: Vec::new() }
    }

    /// What a robot at a place sees of them; then they go on.
    pub(crate) fn step(&mut self, world: &World, robot: Vector, random: &mut RandomGenerator) -> Vec<Disc> {
        let mean_steps = (STEPS[0] + STEPS[1]) as f64 / 2.0;
        for _ in 0..random.poisson(self.per_scan / mean_steps * self.steps) {
            let towards = direction_of(random.between(0.0, std::f64::consts::TAU));
            let person = Person {
                at: moved(robot, towards, random.between(1.0, 5.0)),
                heading: direction_of(random.between(0.0, std::f64::consts::TAU)),
                metres_per_step: if random.happens(0.4) { random.between(0.0, 0.1) } else { random.between(0.3, 1.3) },
                stride_m: if random.happens(0.7) { random.between(0.08, 0.2) } else { 0.0 },
                steps_left: random.count(STEPS[0], STEPS[1]) as f64,
            };
            if is_floor(world, person.at) {
                self.people.push(person);
            }
        }
        let discs = self.people.iter().flat_map(Person::discs).collect();
        for person in &mut self.people {
            person.steps_left -= self.steps;
            let next = moved(person.at, person.heading, person.metres_per_step * self.steps);
            if is_floor(world, next) {
                person.at = next;
            } else {
                person.heading = direction_of(random.between(0.0, std::f64::consts::TAU));
            }
            let sway = direction_of(0.2 * self.steps.sqrt() * random.normal());
            person.heading = crate::plane::turned(person.heading, sway);
        }
        self.people.retain(|person| person.steps_left > 0.0);
        discs
    }
}

impl Person {
    fn discs(&self) -> Vec<Disc> {
        if self.stride_m == 0.0 {
            return vec![Disc { centre: self.at, radius_m: 0.2 }];
        }
        let across = scaled(left_of(self.heading), 0.1);
        let leg = |side: f64| {
            let beside = moved(self.at, across, side);
            Disc { centre: moved(beside, self.heading, side * self.stride_m), radius_m: 0.07 }
        };
        vec![leg(-1.0), leg(1.0)]
    }
}

fn is_floor(world: &World, p: Vector) -> bool {
    world.index_at(p).is_some_and(|k| world.floor[k] && world.cells[k] == Material::Empty)
}
