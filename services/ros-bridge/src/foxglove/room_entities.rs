//! Rooms as entities of a scene, which tell GlobalId, name and state where they are selected.

use super::timestamp::timestamp;
use foxglove::messages::{
    Color, KeyValuePair, LinePrimitive, Point3, Pose, Quaternion, SceneEntity, SceneEntityDeletion, SceneUpdate,
    TextPrimitive, Timestamp, Vector3, line_primitive, scene_entity_deletion,
};
use ros::markers::Room;
use ros::msg::geometry_msgs::Point;
use ros::msg::std_msgs::Header;

/// Width of outlines in metres.
const LINE_M: f64 = 0.1;
/// Height of letters in metres, and of texts above the floor.
const LETTER_M: f64 = 0.25;

/// The rooms of a storey in the place of those of before; ids are their places in the site, the same at every date.
pub(super) fn update<'a>(rooms: impl Iterator<Item = Room<'a>>, header: &Header) -> SceneUpdate {
    let timestamp = timestamp(header);
    let all = scene_entity_deletion::Type::All.into();
    SceneUpdate {
        deletions: vec![SceneEntityDeletion { timestamp, r#type: all, id: String::new() }],
        entities: rooms.map(|room| entity(&room, &header.frame_id, timestamp)).collect(),
    }
}

fn entity(room: &Room<'_>, frame_id: &str, timestamp: Option<Timestamp>) -> SceneEntity {
    let [x, y] = room.centroid_m;
    let color = room.state.color();
    let [r, g, b, a] = [color.r, color.g, color.b, color.a].map(f64::from);
    let color = Some(Color { r, g, b, a });
    let fact = |key: &str, value: &str| KeyValuePair { key: key.to_owned(), value: value.to_owned() };
    let outline = |points: &[Point]| LinePrimitive {
        r#type: line_primitive::Type::LineStrip.into(),
        pose: Some(pose(0.0, 0.0, 0.0)),
        thickness: LINE_M,
        points: points.iter().map(|&Point { x, y, z }| Point3 { x, y, z }).collect(),
        color,
        ..LinePrimitive::default()
    };
    let label = TextPrimitive {
        pose: Some(pose(x, y, LETTER_M)),
        billboard: true,
        font_size: LETTER_M,
        scale_invariant: false,
        color,
        text: room.label(),
    };
    SceneEntity {
        timestamp,
        frame_id: frame_id.to_owned(),
        id: room.index.to_string(),
        frame_locked: true,
        metadata: vec![
            fact("GlobalId", room.global_id),
            fact("name", room.name.as_deref().unwrap_or_default()),
            fact("state", room.state.name()),
        ],
        lines: room.outlines.iter().map(|(_, points)| outline(points)).collect(),
        texts: vec![label],
        ..SceneEntity::default()
    }
}

fn pose(x: f64, y: f64, z: f64) -> Pose {
    let orientation = Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 1.0 };
    Pose { position: Some(Vector3 { x, y, z }), orientation: Some(orientation) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ros::markers::RoomState;
    use ros::msg::builtin_interfaces::Time;

    #[test]
    fn a_room_tells_what_it_is() {
        let corner = |x: f64, y: f64| Point { x, y, z: 0.0 };
        let room = Room {
            index: 3,
            global_id: "2O2Fr$t4X7Zf8NOew3FLOH",
            name: Some("Küche".to_owned()),
            state: RoomState::Blocked,
            centroid_m: [1.0, 2.0],
            outlines: vec![(7, vec![corner(0.0, 0.0), corner(2.0, 0.0), corner(2.0, 4.0), corner(0.0, 0.0)])],
        };
        let header = Header { stamp: Time { sec: 5, nanosec: 6 }, frame_id: "site_map".to_owned() };
        let update = update([room].into_iter(), &header);
        assert_eq!(update.deletions[0].r#type(), scene_entity_deletion::Type::All);
        let entity = &update.entities[0];
        assert_eq!(
            (entity.id.as_str(), entity.frame_id.as_str(), entity.timestamp),
            ("3", "site_map", Some(Timestamp::new(5, 6)))
        );
        let facts: Vec<(&str, &str)> =
            entity.metadata.iter().map(|fact| (fact.key.as_str(), fact.value.as_str())).collect();
        assert_eq!(facts, [("GlobalId", "2O2Fr$t4X7Zf8NOew3FLOH"), ("name", "Küche"), ("state", "blocked")]);
        assert_eq!((entity.lines[0].points.len(), entity.texts[0].text.as_str()), (4, "Küche\nblocked"));
    }
}
