//! Spaces in which nobody walks: lift shafts, risers and pits, by their names and by the lift in them; voids by their names.

use geometry::Bounds;

/// Words that name a shaft wherever they stand in a name, in small letters without accents.
const SHAFT_WORDS: [&str; 24] = [
    "shaft",
    "shafts",
    "hoistway",
    "schacht",
    "liftschacht",
    "aufzugsschacht",
    "aufzugschacht",
    "fahrstuhlschacht",
    "installationsschacht",
    "steigschacht",
    "luftungsschacht",
    "versorgungsschacht",
    "leidingschacht",
    "leidingkoker",
    "liftkoker",
    "schakt",
    "hisschakt",
    "hissschakt",
    "heissjakt",
    "sjakt",
    "skakt",
    "kuilu",
    "hissikuilu",
    "patinillo",
];

/// Phrases that do so.
const SHAFT_PHRASES: [&str; 12] = [
    "gaine technique",
    "gaine ascenseur",
    "gaine d ascenseur",
    "cage d ascenseur",
    "vano ascensore",
    "vano corsa",
    "cavedio",
    "hueco de ascensor",
    "hueco del ascensor",
    "caixa de elevador",
    "poco do elevador",
    "\u{30b7}\u{30e3}\u{30d5}\u{30c8}",
];

/// Names of a lift, a riser or a pit, if they are the whole name but for numbers, single letters and [`QUALIFIERS`].
const WHOLE_NAMES: [&str; 24] = [
    "lift",
    "elevator",
    "elev",
    "aufzug",
    "fahrstuhl",
    "personenaufzug",
    "lastenaufzug",
    "ascenseur",
    "monte charge",
    "ascensore",
    "ascensor",
    "montacargas",
    "elevador",
    "hiss",
    "heis",
    "elevatorskakt",
    "hissi",
    "riser",
    "pit",
    "unterfahrt",
    "aufzugsunterfahrt",
    "fosse",
    "foso",
    "\u{30a8}\u{30ec}\u{30d9}\u{30fc}\u{30bf}\u{30fc}",
];

/// Words that do not make another room of a [`WHOLE_NAMES`].
const QUALIFIERS: [&str; 22] = [
    "lift",
    "elevator",
    "goods",
    "freight",
    "passenger",
    "service",
    "fire",
    "duct",
    "pipe",
    "mechanical",
    "electrical",
    "mep",
    "aufzug",
    "ascenseur",
    "ascensore",
    "ascensor",
    "no",
    "nr",
    "room",
    "car",
    "pit",
    "riser",
];

/// Words that make a room beside a shaft of its name: somebody stands there.
const ROOMS_BESIDE: [&str; 20] = [
    "lobby",
    "hall",
    "foyer",
    "corridor",
    "access",
    "vorraum",
    "vorplatz",
    "zugang",
    "flur",
    "halle",
    "palier",
    "hal",
    "atrio",
    "vestibulo",
    "vestibule",
    "machine",
    "machinery",
    "maschinenraum",
    "control",
    "office",
];

/// Words that name a void wherever they stand in a name.
const VOID_WORDS: [&str; 8] = ["void", "luftraum", "vide", "vuoto", "vacio", "vazio", "hulrom", "\u{5439}\u{629c}"];

/// A lift fills at least this share of the plan of its shaft.
const MIN_LIFT_SHARE: f64 = 0.25;

/// No lift is larger; cranes are.
const MAX_LIFT_M2: f64 = 25.0;

/// True if a name, long name or type of a space says that it is a lift shaft, a riser or a pit.
pub(crate) fn names_shaft(name: &str) -> bool {
    let plain = plain(name);
    let words: Vec<&str> = plain.split_whitespace().collect();
    if words.iter().any(|word| ROOMS_BESIDE.contains(word)) {
        return false;
    }
    let has_phrase = SHAFT_PHRASES.iter().any(|phrase| plain.contains(phrase));
    let is_shaft = |word: &&str| SHAFT_WORDS.contains(word) || word.ends_with("schacht");
    if has_phrase || words.iter().any(is_shaft) {
        return true;
    }
    let is_mark = |word: &&&str| word.chars().count() == 1 || word.chars().any(|c| c.is_ascii_digit());
    let named: Vec<&str> = words.iter().filter(|word| !is_mark(word)).copied().collect();
    let is_whole = WHOLE_NAMES.contains(&named.join(" ").as_str());
    let heads = named.last().is_some_and(|last| WHOLE_NAMES.contains(last));
    is_whole || heads && named[..named.len() - 1].iter().all(|word| QUALIFIERS.contains(word))
}

/// True if a name says that a space is open to what lies below it.
pub(crate) fn names_void(name: &str) -> bool {
    let plain = plain(name);
    plain.split_whitespace().any(|word| VOID_WORDS.contains(&word))
}

/// True if a lift of these bounds is in a space that is hardly larger: the space is its shaft.
pub(crate) fn holds_lift(space: (Bounds, f64, [i32; 2]), lift: ([i32; 3], [i32; 3])) -> bool {
    let (plan, area_m2, [bottom, top]) = space;
    let (min, max) = lift;
    let middle = |k: usize| min[k] / 2 + max[k] / 2;
    let is_inside = (0..2).all(|k| plan.min[k] <= middle(k) && middle(k) <= plan.max[k]);
    let side_m = |k: usize| frames::metres(max[k] - min[k]);
    let lift_m2 = side_m(0) * side_m(1);
    is_inside && lift_m2 <= MAX_LIFT_M2 && min[2] < top && bottom < max[2] && lift_m2 >= MIN_LIFT_SHARE * area_m2
}

/// Small letters without accents; everything but letters and digits is a space.
fn plain(name: &str) -> String {
    let letter = |c: char| match c {
        'ä' | 'à' | 'á' | 'â' | 'ã' | 'å' => 'a',
        'ö' | 'ò' | 'ó' | 'ô' | 'õ' | 'ø' => 'o',
        'ü' | 'ù' | 'ú' | 'û' => 'u',
        'é' | 'è' | 'ê' | 'ë' => 'e',
        'í' | 'ì' | 'î' | 'ï' => 'i',
        'ç' => 'c',
        'ñ' => 'n',
        c if c.is_alphanumeric() || c == '\u{30fc}' => c,
        _ => ' ',
    };
    // Accents may be letters of their own behind the one that they belong to.
    let is_mark = |c: &char| ('\u{300}'..='\u{36f}').contains(c);
    name.to_lowercase().chars().filter(|c| !is_mark(c)).map(letter).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shafts_are_told_by_their_names_and_rooms_beside_them_are_none() {
        for shaft in [
            "Lift shaft",
            "ELEVATOR SHAFT 2",
            "Aufzugsschacht",
            "Installationsschacht 03",
            "Schacht",
            "Lift",
            "Elevator A",
            "Aufzug 1",
            "Ascenseur",
            "Gaine d'ascenseur",
            "Goods lift",
            "Lift pit",
            "Riser",
            "Kabelschacht",
            "Technikschacht 2",
            "Shafts",
            "Lu\u{308}ftungsschacht",
            "Pipe riser 4",
            "Leidingschacht",
            "EL-Schakt",
            "エレベーターシャフト",
            "MEP Shaft",
            "Aufzugsunterfahrt",
            "Lift 01 (pit)",
        ] {
            assert!(names_shaft(shaft), "{shaft}");
        }
        for room in [
            "Lift lobby",
            "Elevator hall",
            "Aufzugsvorraum",
            "Vorraum Aufzug",
            "Machine room lift",
            "Office",
            "Pitch",
            "Shafting",
            "",
            "12",
            "Reading pit corner",
            "Uplift studio",
            "Hissenraum",
            "Storage",
            "Lift access corridor",
            "Skiliftraum",
        ] {
            assert!(!names_shaft(room), "{room}");
        }
    }

    #[test]
    fn voids_are_told_by_their_names() {
        assert!(["Atrium void", "Luftraum EG", "VOID", "Vide sur séjour"].into_iter().all(names_void));
        assert!(!["Avoidance", "Hall", ""].into_iter().any(names_void));
    }

    #[test]
    fn a_lift_makes_a_shaft_of_a_space_of_its_size_only() {
        let lift = ([10_000, 10_000, 0], [26_000, 26_000, 22_000]);
        let space = |side: i32| {
            let side_m = frames::metres(side);
            (Bounds { min: [0, 0], max: [side, side] }, side_m * side_m, [-12_000, 30_000])
        };
        assert!(holds_lift(space(30_000), lift));
        assert!(!holds_lift(space(80_000), lift));
        assert!(!holds_lift((space(30_000).0, 9.0, [30_000, 60_000]), lift));
    }
}
