//! Planned, reported and observed dates beside each other.

#[path = "../../stages/schedule/tests/support/mod.rs"]
mod support;

use answers::tasks::progress;
use messages::Site;
use schedule::{ABSENT, parse_actuals};
use serde_json::{Value, json};
use support::ScheduledSite;

#[test]
fn dates_that_are_reported_and_observed_stand_beside_the_planned_ones() {
    let mut site = ScheduledSite::new();
    let walls = site.dated("walls", "2024-03-04T08:00:00", "2024-03-08T17:00:00");
    site.task("undated");
    for _ in 0..3 {
        let wall = site.element("IfcWall");
        site.builds(walls, wall);
    }
    let planned = site.evaluate();
    let reported = "id,start,finish\nwalls,2024-03-05T08:00:00,\nelement-0,2024-03-06,2024-03-07\ngone,2024-03-06,\n";
    let observed = format!("id,start,finish\nelement-0,,2024-03-07T11:00:00\nelement-1,{ABSENT},\n");
    let [reported, observed] = [reported, &observed].map(|table| parse_actuals(table.as_bytes()).unwrap());
    let bytes = site.builder.finish();
    let site = Site::open(bytes.bytes()).unwrap();
    let progress = serde_json::to_value(progress(&site, &planned, &reported, &observed).unwrap()).unwrap();
    let dates = |start: Value, finish: Value| json!({"start": start, "finish": finish});
    let as_planned = dates(json!("2024-03-04T08:00:00"), json!("2024-03-08T17:00:00"));
    let of_walls = json!({"planned": as_planned, "reported": dates(json!("2024-03-05T08:00:00"), Value::Null)});
    assert_eq!(progress["tasks"], json!({"walls": of_walls}));
    let both = json!({"planned": as_planned, "reported": dates(json!("2024-03-06"), json!("2024-03-07")),
        "observed": dates(Value::Null, json!("2024-03-07T11:00:00"))});
    let absent = json!({"planned": as_planned, "reported": null, "observed": dates(json!("absent"), Value::Null)});
    assert_eq!(progress["elements"], json!({"element-0": both, "element-1": absent}));
}
