//! Waypoints in WGS 84, where the site's projected CRS can be computed without grid-shift files.

use crate::input::ExportInput;
use crate::text::rounded;
use crate::waypoints::{space_id, space_name};
use frames::{Earth, EarthFromWorld, Map, Point3};
use messages::{Site, WaypointRecord};
use proj4rs::Proj;
use proj4rs::transform::transform;
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Value, json};

/// Name of the file.
pub(crate) const FILE: &str = "waypoints.wgs84.geojson";

/// Latitude and longitude, as OGC:CRS84 and RFC 7946 mean them.
const WGS84: &str = "+proj=longlat +datum=WGS84 +no_defs";

/// Degrees are rounded to a tenth of a millimetre: trigonometry of another machine's library may differ far below that.
const PER_DEGREE: f64 = 1e9;

/// How far a point may be from where its latitude and longitude lead back to, in units of the projected system.
const SAME_UNITS: f64 = 0.1;

/// Whether latitudes and longitudes are written.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct GeographicReport {
    /// The file with latitudes and longitudes of the waypoints; null if there is none.
    file: Option<&'static str>,
    /// Why there is none.
    reason: Option<String>,
}

impl GeographicReport {
    pub(crate) fn of(site: &Site<'_>) -> Self {
        match Geographic::of(site) {
            Ok(_) => Self { file: Some(FILE), reason: None },
            Err(reason) => Self { file: None, reason: Some(reason) },
        }
    }
}

/// From the map to longitude and latitude.
pub(crate) struct Geographic<'a> {
    site: &'a Site<'a>,
    earth_from_world: EarthFromWorld,
    projection: Projection,
}

impl<'a> Geographic<'a> {
    /// Finds the site's projected system, and tests it at the origin of the map.
    ///
    /// The error is a sentence for people: why there are no latitudes and longitudes.
    pub(crate) fn of(site: &'a Site<'a>) -> Result<Self, String> {
        let Some(earth_from_world) = site.earth_from_world() else {
            return Err("no file has a map conversion (IfcMapConversion)".to_owned());
        };
        let crs = site.text(site.head.earth_crs);
        let geographic = Self { site, earth_from_world, projection: Projection::of(crs)? };
        let origin = geographic.longitude_latitude_deg([0.0; 3]);
        origin.map(|_| geographic).ok_or_else(|| format!("the model lies outside of {crs:?}"))
    }

    fn longitude_latitude_deg(&self, p_in_map_m: [f64; 3]) -> Option<[f64; 2]> {
        let [east_m, north_m, _] = self.on_earth_m(p_in_map_m);
        self.projection.longitude_latitude_deg([east_m, north_m])
    }

    /// Eastings, northings and height in metres of a point of the map.
    fn on_earth_m(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let world_from_map = self.site.map_from_world().inverse();
        let on_earth: Point3<Earth> = &self.earth_from_world * (&world_from_map * Point3::<Map>::new(x, y, z));
        on_earth.coordinates_m()
    }

    /// A FeatureCollection as RFC 7946 has it: longitude and latitude in degrees, of WGS 84.
    pub(crate) fn geojson(&self, input: &ExportInput<'_>) -> Value {
        let feature = |w: &WaypointRecord| {
            let [x_m, y_m, z_m] = w.position_in_map_m.map(rounded);
            let properties = json!({
                "id": w.id, "order": w.order, "kind": w.purpose().kind().name(), "storey": w.map_storey, "space": space_id(input, w.space),
                "name": space_name(input.site, w.space), "x_m": x_m, "y_m": y_m, "z_m": z_m,
                "orthogonal_height_m": rounded(self.on_earth_m(w.position_in_map_m)[2]),
            });
            let place = self.longitude_latitude_deg(w.position_in_map_m);
            let geometry = place.map(|coordinates| json!({"type": "Point", "coordinates": coordinates}));
            json!({"type": "Feature", "geometry": geometry, "properties": properties})
        };
        let features: Vec<Value> = input.mission_plan.waypoints.iter().map(feature).collect();
        json!({"type": "FeatureCollection", "features": features})
    }
}

/// A projected system and the geographic one.
struct Projection {
    projected: Proj,
    wgs84: Proj,
}

impl Projection {
    /// The projected system of a name such as `EPSG:25832`.
    fn of(name: &str) -> Result<Self, String> {
        let code =
            epsg_code(name).ok_or_else(|| format!("{name:?} names no system by its EPSG code, such as EPSG:25832"))?;
        let definition = crs_definitions::from_code(code).ok_or_else(|| format!("EPSG:{code} is not in the table"))?;
        if !has_known_datum(definition.proj4) {
            return Err(format!("the datum transformation of EPSG:{code} to WGS 84 is not in the table"));
        }
        if UNCERTAIN.binary_search(&code).is_ok() {
            return Err(format!(
                "the datum transformation of EPSG:{code} to WGS 84 is not certain: the table and the register of EPSG differ by more than 20 m"
            ));
        }
        let projected = Proj::from_proj_string(definition.proj4)
            .map_err(|error| format!("EPSG:{code} cannot be computed without further tables ({error})"))?;
        if projected.is_latlong() || projected.is_geocent() {
            return Err(format!("EPSG:{code} is no projected system"));
        }
        let wgs84 = Proj::from_proj_string(WGS84).map_err(|error| error.to_string())?;
        Ok(Self { projected, wgs84 })
    }

    /// Longitude and latitude in degrees; `None` outside of the projected system.
    fn longitude_latitude_deg(&self, east_north_m: [f64; 2]) -> Option<[f64; 2]> {
        let [east, north] = east_north_m.map(|x| x / self.projected.to_meter());
        // Heights of the projected system are above its own zero, not above the ellipsoid, and stay out of this.
        let mut point = (east, north, 0.0);
        transform(&self.projected, &self.wgs84, &mut point).ok()?;
        let degrees = [point.0.to_degrees(), point.1.to_degrees()];
        // Outside of its domain the inverse of a projection answers with some point, which does not lead back.
        let mut back = (point.0, point.1, 0.0);
        transform(&self.wgs84, &self.projected, &mut back).ok()?;
        let leads_back = (back.0 - east).abs() <= SAME_UNITS && (back.1 - north).abs() <= SAME_UNITS;
        leads_back.then(|| degrees.map(|d| libm::round(d * PER_DEGREE) / PER_DEGREE + 0.0))
    }
}

/// The number behind `EPSG` and a colon, a blank or both, as in `urn:ogc:def:crs:EPSG::25832`.
fn epsg_code(name: &str) -> Option<u16> {
    let name = name.trim().to_ascii_uppercase();
    let at = name.find("EPSG")?;
    let number = name[at + 4..].rsplit(|c: char| !c.is_ascii_digit()).find(|digits| !digits.is_empty())?;
    number.parse().ok()
}

/// Words of definitions whose datum is known. Ellipsoids of today's satellite datums are WGS 84's within a metre, and `@null` says
/// that there is no shift; any other datum needs one, which some definitions lack.
const KNOWN_DATUMS: [&str; 6] =
    ["+datum=WGS84", "+datum=NAD83", "+ellps=GRS80", "+ellps=WGS84", "+towgs84=", "+nadgrids=@null"];

/// Codes whose place in the table and in the register of EPSG differ by more than 20 m: of some the register knows no shift of the
/// datum, of others the table has an old one, or a meridian that is not the register's. Sorted.
///
/// # Source
/// PROJ 9.5 (pyproj 3.7.2) at the middle of the area of use of every projected code of the table.
const UNCERTAIN: [u16; 97] = [
    2042, 2045, 2082, 2401, 2406, 2407, 2408, 2410, 2411, 2418, 2419, 2420, 2421, 2422, 2427, 2428, 2429, 2431, 2432,
    2439, 2440, 2441, 2442, 2492, 2493, 2550, 2979, 2983, 2984, 3146, 3147, 3833, 3837, 3838, 3844, 3986, 3989, 5631,
    5670, 5671, 6200, 6991, 6996, 6997, 20248, 20348, 20357, 20358, 21416, 21422, 21423, 21456, 21462, 21463, 21476,
    21482, 21483, 23946, 24047, 24048, 24305, 24306, 24375, 24880, 24881, 24882, 25395, 26195, 26432, 26591, 26592,
    27037, 27038, 28402, 28403, 28462, 28463, 29100, 29122, 29168, 29170, 29181, 29182, 29183, 29184, 29185, 29220,
    31281, 31282, 31283, 31288, 31289, 31290, 31291, 31292, 31293, 31700,
];

fn has_known_datum(proj4: &str) -> bool {
    KNOWN_DATUMS.iter().any(|word| proj4.contains(word))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_systems_give_their_code() {
        for (name, code) in [
            ("EPSG:25832", Some(25832)),
            ("epsg: 2056", Some(2056)),
            ("urn:ogc:def:crs:EPSG::32760", Some(32760)),
            ("EPSG:9.8.6:5514", Some(5514)),
            ("ETRS89 / UTM 32N (EPSG:25832)", Some(25832)),
            ("EPSG:99999999", None),
            ("WKT", None),
            ("", None),
        ] {
            assert_eq!(epsg_code(name), code, "{name}");
        }
    }

    /// Eastings and northings in metres, longitude and latitude in degrees as PROJ 9.5 has them (pyproj 3.7.2), and by how many
    /// metres the two may differ: the parameters of national datums are known to a few decimals.
    const KNOWN: [(u16, [f64; 2], [f64; 2], f64); 10] = [
        (32632, [458_870.0, 5_438_232.0], [8.436_593_280, 49.095_563_028], 0.001),
        (25833, [389_000.0, 5_819_000.0], [13.364_413_980, 52.509_806_057], 0.001),
        (32760, [729_013.348_8, 9_063_992.684_7], [179.080_146_717, -8.462_199_942], 0.001),
        (2154, [652_000.0, 6_862_000.0], [2.345_811_959, 48.856_248_141], 0.001),
        (2263, [300_000.0, 60_000.0], [-74.0, 40.706_984_497], 0.001),
        (3857, [1_113_194.9, 6_800_125.45], [9.999_999_929, 51.999_999_976], 0.001),
        (4647, [32_458_870.0, 5_438_232.0], [8.436_593_280, 49.095_563_029], 0.001),
        (2056, [2_600_000.0, 1_200_000.0], [7.438_632_421, 46.951_082_772], 0.01),
        (28992, [155_000.0, 463_000.0], [5.387_203_508, 52.155_172_301], 0.05),
        (31370, [150_000.0, 170_000.0], [4.368_752_141, 50.840_411_283], 0.05),
    ];

    #[test]
    fn longitudes_and_latitudes_are_those_of_proj() {
        const METRES_PER_DEGREE: f64 = 111_320.0;
        for (code, east_north_m, expected, within_m) in KNOWN {
            let projection = Projection::of(&format!("EPSG:{code}")).unwrap();
            let found = projection.longitude_latitude_deg(east_north_m).unwrap();
            let off_m = [0, 1].map(|k| (found[k] - expected[k]).abs() * METRES_PER_DEGREE);
            assert!(off_m.iter().all(|off| *off <= within_m), "EPSG:{code}: {found:?}, off by {off_m:?} m");
        }
    }

    #[test]
    fn a_system_that_cannot_be_computed_says_why() {
        let why = |name: &str| Projection::of(name).err().unwrap();
        assert!(why("EPSG:4326").contains("no projected system"));
        assert!(why("EPSG:65000").contains("not in the table"));
        assert!(why("Gauss-Krueger").contains("names no system"));
        // The old datum of the United States is known by grids alone, which are files of PROJ.
        assert!(why("EPSG:26715").contains("datum"), "{}", why("EPSG:26715"));
    }

    #[test]
    fn a_system_whose_shift_is_uncertain_says_so_and_is_not_used() {
        assert!(UNCERTAIN.is_sorted());
        // Withdrawn, another meridian, an old shift of its datum, and none where there is one.
        for code in [31_700, 31_283, 24_047, 6_991] {
            let why = Projection::of(&format!("EPSG:{code}")).err().unwrap();
            assert!(why.contains(&format!("EPSG:{code}")) && why.contains("not certain"), "{why}");
        }
    }

    #[test]
    fn no_definition_without_a_shift_of_its_datum_is_used() {
        let definition = |code: u16| crs_definitions::from_code(code).map(|d| d.proj4).unwrap_or_default();
        let used: Vec<u16> = (1..u16::MAX).filter(|code| Projection::of(&format!("EPSG:{code}")).is_ok()).collect();
        assert!(used.len() > 3_000, "{}", used.len());
        for code in used {
            let text = definition(code);
            let is_satellite = ["WGS84", "NAD83", "GRS80"].iter().any(|datum| text.contains(datum));
            assert!(
                is_satellite || text.contains("+towgs84=") || text.contains("+nadgrids=@null"),
                "EPSG:{code}: {text}"
            );
        }
    }

    #[test]
    fn a_definition_without_a_shift_of_its_datum_is_not_used() {
        assert!(has_known_datum("+proj=utm +zone=32 +ellps=GRS80 +units=m"));
        assert!(has_known_datum("+proj=utm +zone=32 +ellps=intl +towgs84=-87,-98,-121"));
        assert!(!has_known_datum("+proj=utm +zone=32 +ellps=intl +units=m"));
        assert!(!has_known_datum("+proj=tmerc +ellps=bessel +nadgrids=BETA2007.gsb"));
    }

    #[test]
    fn a_point_outside_of_the_projected_system_has_no_latitude() {
        // Millimetres that were taken for metres.
        let point = [149_626_315.910, 413_717_684.216];
        for name in ["EPSG:28992", "EPSG:25832", "EPSG:2154", "EPSG:2056", "EPSG:3857"] {
            assert_eq!(Projection::of(name).unwrap().longitude_latitude_deg(point), None, "{name}");
        }
    }
}
