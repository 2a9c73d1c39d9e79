//! Site, phase and grids in, waypoints out: the centre of every space that a robot may enter.

mod centre;
mod reach;

use centre::{Centre, Clearance, centre_of};
use frames::metres;
use messages::{
    ArchiveBuffer, Grid, NONE, Phase, PlanBuilder, PlanHead, RobotProfile, Site, SpacePlanRecord, TextPool,
    WaypointKind, WaypointRecord, space_flags,
};
use reach::Reach;

/// Plans the centres of all spaces, storey by storey, in file order.
///
/// A centre is the area centroid of the space's floor, moved to the nearest place that is inside the space and clear by
/// the robot's radius and can be reached, where it is not. A space without one has a reason.
pub fn plan(site: &Site<'_>, phase: &Phase<'_>, grids: &[Grid<'_>], robot: &RobotProfile) -> ArchiveBuffer {
    let mut builder = PlanBuilder {
        texts: TextPool::default(),
        head: PlanHead {
            site_hash: site.content_hash(),
            phase_hash: phase.content_hash(),
            plan_time_s: phase.head.plan_time_s,
        },
        waypoints: Vec::new(),
        spaces: vec![
            SpacePlanRecord { coverage: 0.0, reason: messages::Text::default(), centre: NONE, reserved: 0 };
            site.spaces.len()
        ],
    };
    for index in 0..site.spaces.len() {
        if let Err(reason) = may_be_entered(site, phase, index) {
            builder.spaces[index].reason = builder.texts.add(&reason);
        }
    }
    for grid in grids {
        let clearance = Clearance::of(grid);
        let reach = Reach::of(grid, &clearance, robot.radius_m);
        for (index, space) in site.spaces.iter().enumerate() {
            if space.map_storey != grid.head.map_storey || may_be_entered(site, phase, index).is_err() {
                continue;
            }
            match centre_of(site, grid, &clearance, &reach, index, robot.radius_m) {
                Ok(centre) => add_centre(&mut builder, grid, robot, index, space.centroid_m, &centre),
                Err(reason) => builder.spaces[index].reason = builder.texts.add(&reason),
            }
        }
    }
    builder.finish()
}

/// Why a robot has no business in a space, whatever the map looks like.
fn may_be_entered(site: &Site<'_>, phase: &Phase<'_>, index: usize) -> Result<(), String> {
    let space = &site.spaces[index];
    if space.has(space_flags::METADATA_ONLY) {
        Err("it is a gross area, or made of other spaces".to_owned())
    } else if space.has(space_flags::EXTERNAL) {
        Err("it is outdoors".to_owned())
    } else if space.n_rings == 0 {
        Err("it has no body".to_owned())
    } else if space.map_storey == NONE {
        Err("its floor is on no map storey".to_owned())
    } else if phase.is_blocked(index) {
        Err(format!("it is blocked: {}", phase.why(index).collect::<Vec<_>>().join(", ")))
    } else {
        Ok(())
    }
}

fn add_centre(
    builder: &mut PlanBuilder,
    grid: &Grid<'_>,
    robot: &RobotProfile,
    space: usize,
    centroid_m: [f64; 2],
    centre: &Centre,
) {
    let floor_m = metres(grid.head.floor_z_tenths);
    let id = builder.waypoints.len() as u32;
    builder.spaces[space].centre = id;
    builder.waypoints.push(WaypointRecord {
        position_in_map_m: [centre.x_m, centre.y_m, floor_m],
        sensor_z_m: floor_m + robot.sensor_height_m,
        yaw_rad: 0.0,
        centroid_in_map_m: [centroid_m[0], centroid_m[1], floor_m],
        clearance_m: centre.clearance_m,
        covers_m2: 0.0,
        id,
        order: id,
        kind: WaypointKind::Centre as u32,
        map_storey: grid.head.map_storey,
        space: space as u32,
        reserved: 0,
    });
}
