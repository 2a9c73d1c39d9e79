//! `config/schemas` equals the schemas of the written documents; UPDATE_GOLDEN=1 rewrites them.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

#[path = "support/schema.rs"]
mod schema;

use schema::check;

#[test]
fn schemas_are_current() {
    check::<export::FlightDocument>("flight");
    check::<export::GroundDocument>("ground");
    check::<export::Manifest>("manifest");
    check::<export::DatesManifest>("dates-manifest");
    check::<export::DeviationsDocument>("deviations");
    check::<export::Report>("report");
    check::<export::SafetyDocument>("safety");
    check::<export::Semantic>("semantic");
    check::<export::SiteFrameFile>("site-frame");
    check::<export::SiteGraph>("site-graph");
    check::<export::Waypoints>("waypoints");
}
