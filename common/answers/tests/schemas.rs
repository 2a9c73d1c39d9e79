//! `config/schemas` equals the schemas of the answers; UPDATE_GOLDEN=1 rewrites them.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

#[path = "../../export/tests/support/schema.rs"]
mod schema;

use schema::check;

#[test]
fn schemas_are_current() {
    check::<answers::WayAnswer>("way");
    check::<answers::RoomAnswer>("room");
    check::<answers::DoorAnswer>("door");
    check::<answers::ScansAnswer>("scans");
    check::<answers::findings::FindingsAnswer>("findings");
    check::<answers::tasks::TaskList<'_>>("tasks");
}
