//! Rooms that are on no map, as JSON and as lines of the summary.

use diagnostics::counted;
use export::{NotMapped, RoomNotMapped, space_name};
use messages::Site;
use serde::Serialize;

/// A room that is on no map.
#[derive(Debug, Serialize)]
pub(super) struct RoomLine {
    global_id: String,
    name: Option<String>,
    area_m2: f64,
    #[serde(serialize_with = "reason_text")]
    reason: NotMapped,
}

fn reason_text<S: serde::Serializer>(reason: &NotMapped, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(reason.text())
}

impl RoomLine {
    pub(super) fn of(site: &Site<'_>, room: RoomNotMapped) -> Self {
        let record = &site.spaces[room.space as usize];
        Self {
            global_id: site.text(record.global_id).to_owned(),
            name: space_name(site, room.space),
            area_m2: export::rounded(record.area_m2),
            reason: room.reason,
        }
    }
}

/// How many rooms without a map are named for each reason.
const MAX_ROOMS: usize = 8;

/// `on no map: 3 rooms, 41.5 m2: Cellar 20.0 m2, ..` for each reason that there is.
pub(super) fn rooms_lines(rooms: &[RoomLine]) -> Vec<String> {
    let reasons = [
        (NotMapped::NoLevel, "on no map"),
        (NotMapped::NoFloor, "on no map, without floor under them"),
        (NotMapped::Shaft, "on no map, shafts"),
    ];
    let line = |(reason, what): (NotMapped, &str)| {
        let of_reason: Vec<&RoomLine> = rooms.iter().filter(|room| room.reason == reason).collect();
        let all_m2: f64 = of_reason.iter().map(|r| r.area_m2).sum();
        let named = of_reason.iter().take(MAX_ROOMS).map(|r| {
            let name = r.name.as_deref().unwrap_or(&r.global_id);
            format!("{name} {:.1} m2", r.area_m2)
        });
        let mut named: Vec<String> = named.collect();
        if of_reason.len() > MAX_ROOMS {
            named.push(format!("and {} more", of_reason.len() - MAX_ROOMS));
        }
        let n = counted(of_reason.len(), "room");
        (!of_reason.is_empty()).then(|| format!("{what}: {n}, {all_m2:.1} m2: {}", named.join(", ")))
    };
    reasons.into_iter().filter_map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rooms_on_no_map_are_listed_with_their_area() {
        let room = |k: usize, reason| RoomLine {
            global_id: format!("room-{k}"),
            name: (k > 0).then(|| format!("Room {k}")),
            area_m2: 10.0 - k as f64,
            reason,
        };
        let (level, floor) = (NotMapped::NoLevel, NotMapped::NoFloor);
        assert_eq!(rooms_lines(&[]), Vec::<String>::new());
        assert_eq!(rooms_lines(&[room(0, level)]), ["on no map: 1 room, 10.0 m2: room-0 10.0 m2"]);
        let lines = rooms_lines(&[room(0, floor), room(1, level), room(2, floor)]);
        let expected = "on no map, without floor under them: 2 rooms, 18.0 m2: room-0 10.0 m2, Room 2 8.0 m2";
        assert_eq!(lines, ["on no map: 1 room, 9.0 m2: Room 1 9.0 m2", expected]);
        let many: Vec<RoomLine> = (0..10).map(|k| room(k, level)).collect();
        let line = &rooms_lines(&many)[0];
        assert!(line.starts_with("on no map: 10 rooms, 55.0 m2: room-0 10.0 m2, Room 1 9.0 m2, "), "{line}");
        assert!(line.ends_with("Room 7 3.0 m2, and 2 more"), "{line}");
    }
}
