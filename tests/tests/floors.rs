//! What is floor of small models, and what is said where the model has none.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

mod support;

use support::house::{House, PLAIN};
use support::{FREE, Maps, UNKNOWN, convert};

fn converted(house: &House) -> Maps {
    let home = tempfile::tempdir().unwrap();
    convert(&house.write(home.path()), &[])
}

/// The lines about an assumed floor.
fn warnings(maps: &Maps) -> Vec<&str> {
    maps.said.lines().map(str::trim).filter(|line| line.starts_with("warning: the model has")).collect()
}

#[test]
fn an_assumed_floor_is_told_once_with_from_what_and_how_much() {
    let mut house = House::new("IFC4");
    house.add_walls([0.0, 0.0, 6.0, 4.0], [0.0, 3.0]);
    house.add_room("Hall", [[0.0, 0.0, 0.0], [6.0, 4.0, 3.0]]);
    let maps = converted(&house);
    let expected = "warning: the model has too little floor (slabs, coverings, ramps), so it is assumed: \
                    \"Ground\" 24.0 m2 from its spaces";
    assert_eq!(warnings(&maps), [expected], "{}", maps.said);
    assert_eq!(maps.manifest["storeys"][0]["floor"], "assumed");
    assert_eq!(maps.storey(0).planning(3.0, 2.0), FREE);

    let mut house = House::new("IFC4");
    house.add_walls([0.0, 0.0, 6.0, 4.0], [0.0, 3.0]);
    let maps = converted(&house);
    let (what, area) = warnings(&maps)[0].rsplit_once(": ").unwrap();
    assert_eq!((warnings(&maps).len(), what), (1, expected.rsplit_once(": ").unwrap().0));
    let area_m2: f64 = area.strip_prefix("\"Ground\" ").unwrap().split_once(' ').unwrap().0.parse().unwrap();
    assert!(24.0 <= area_m2 && area_m2 <= 6.5 * 4.5, "what the walls enclose, and the walls: {area}");
    assert!(area.ends_with(" m2 from what its walls enclose"), "{area}");

    house.add("IFCSLAB", "Slab", PLAIN, [[0.0, 0.0, -0.2], [6.0, 4.0, 0.0]]);
    let maps = converted(&house);
    assert_eq!((warnings(&maps).len(), &maps.manifest["storeys"][0]["floor"]), (0, &"built".into()));
}

#[test]
fn pavements_and_courses_near_the_height_of_a_storey_are_its_floor() {
    for entity in ["IFCPAVEMENT", "IFCCOURSE"] {
        let with = |top_m: f64| {
            let mut house = House::new("IFC4X3_ADD2");
            house.add(entity, "Road", PLAIN, [[0.0, 0.0, top_m - 0.2], [6.0, 4.0, top_m]]);
            house.add("IFCSLAB", "Slab beside it", PLAIN, [[20.0, 0.0, -0.2], [22.0, 4.0, 0.0]]);
            converted(&house)
        };
        let near = with(0.1);
        let storey = &near.manifest["storeys"][0];
        assert_eq!((&storey["floor"], storey["floor_z_m"].as_f64()), (&"built".into(), Some(0.1)), "{entity}");
        assert_eq!(near.storey(0).planning(3.0, 2.0), FREE, "{entity}");
        let far = with(-2.0);
        assert_eq!(far.manifest["storeys"][0]["floor_z_m"], 0.0, "{entity}");
        assert_eq!(far.storey(0).planning(3.0, 2.0), UNKNOWN, "{entity}");
    }
}
