//! Reading with meshes of an earlier reading gives what reading without them gives, whatever has changed in between.

#![expect(clippy::unwrap_used, reason = "helpers of tests may")]

use ifc::{Isolation, MeshCache, MeshCacheCounts, MeshPool, ReadOptions, mesh_task, read};
use proptest::prelude::*;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

const PROGRAM: u128 = 1;
const MAX_BYTES: usize = 64 << 20;

static POOL: LazyLock<MeshPool> = LazyLock::new(|| MeshPool::new(2).unwrap());

/// How a body is given.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Body {
    Swept,
    Mapped,
    /// Less a box.
    Clipped,
    /// Faces that leave a gap, so that the kernel cuts it.
    Open,
    /// Five kilometres from the origin of its frame.
    Far,
    /// Triangles with a colour map.
    Triangles,
    /// The same item twice, or two equal ones.
    Twice,
}

const BODIES: [Body; 7] =
    [Body::Swept, Body::Mapped, Body::Clipped, Body::Open, Body::Far, Body::Triangles, Body::Twice];

#[derive(Debug, Clone)]
struct Wall {
    body: Body,
    /// Decimetres.
    at: [u8; 2],
    length: u8,
    colour: Option<u8>,
    /// Its place along the wall.
    openings: Vec<u8>,
    is_one_item: bool,
    /// The wall that it is a part of.
    whole: Option<usize>,
    has_material: bool,
    has_type: bool,
}

/// Things that can be changed.
const EDITS: u8 = 24;

/// A building of which each number can be changed.
#[derive(Debug, Clone)]
struct Plan {
    walls: Vec<Wall>,
    is_metric: bool,
    site_x: u8,
    storey_z: u8,
    map_height: u8,
    map_origin: u8,
    map_colour: u8,
    clipped: u8,
    palette: u8,
    material_colour: u8,
    type_material_colour: Option<u8>,
    first_id: usize,
    is_reversed: bool,
    name: u8,
    is_in_one_frame: bool,
    /// Walls are placed in the storey, or in the world.
    is_placed_in_site: bool,
}

impl Plan {
    fn new(n_walls: usize) -> Self {
        let wall = |k: usize| Wall {
            body: BODIES[k % BODIES.len()],
            at: [3, (20 * k) as u8],
            length: 40,
            colour: k.is_multiple_of(2).then_some(k as u8),
            openings: if k % 3 == 1 { Vec::new() } else { vec![8, 25] },
            is_one_item: false,
            whole: (k % 5 == 4).then(|| k - 1),
            has_material: k % 4 == 1,
            has_type: k % 4 == 3,
        };
        Self {
            walls: (0..n_walls).map(wall).collect(),
            is_metric: true,
            site_x: 1,
            storey_z: 1,
            map_height: 30,
            map_origin: 2,
            map_colour: 7,
            clipped: 9,
            palette: 3,
            material_colour: 50,
            type_material_colour: Some(90),
            first_id: 1,
            is_reversed: false,
            name: 0,
            is_in_one_frame: true,
            is_placed_in_site: true,
        }
    }

    /// Changes one thing.
    fn edit(&mut self, what: u8, which: usize, to: u8) {
        let n_walls = self.walls.len();
        let wall = &mut self.walls[which % n_walls];
        match what % EDITS {
            0 => wall.length = 10 + to % 60,
            1 => wall.at[usize::from(to % 2)] = to,
            2 => wall.colour = (!to.is_multiple_of(3)).then_some(to),
            3 => wall.openings = (0..to % 4).map(|k| 3 + 9 * k + to % 5).collect(),
            4 => wall.body = BODIES[usize::from(to) % BODIES.len()],
            5 => wall.is_one_item = !wall.is_one_item,
            6 => wall.whole = (!which.is_multiple_of(n_walls) && to.is_multiple_of(2)).then(|| which % n_walls - 1),
            7 => wall.has_material = !wall.has_material,
            8 => wall.has_type = !wall.has_type,
            9 => self.is_metric = !self.is_metric,
            10 => self.site_x = to,
            11 => self.storey_z = to,
            12 => self.map_height = 5 + to % 40,
            13 => self.map_origin = to,
            14 => self.map_colour = to,
            15 => self.clipped = 1 + to % 20,
            16 => self.palette = to,
            17 => self.material_colour = to,
            18 => self.type_material_colour = (!to.is_multiple_of(3)).then_some(to),
            19 => self.first_id = 1 + usize::from(to) * 1_000,
            20 => self.is_reversed = !self.is_reversed,
            21 => self.name = to,
            22 => self.is_placed_in_site = !self.is_placed_in_site,
            _ => self.is_in_one_frame = !self.is_in_one_frame,
        }
    }

    fn text(&self) -> String {
        let mut records = Records { lines: Vec::new(), first: self.first_id };
        self.write(&mut records);
        if self.is_reversed {
            records.lines.reverse();
        }
        records.file()
    }

    fn write(&self, r: &mut Records) {
        let prefix = if self.is_metric { "$" } else { ".DECI." };
        let length = r.add(format!("IFCSIUNIT(*,.LENGTHUNIT.,{prefix},.METRE.)"));
        let angle = r.add("IFCSIUNIT(*,.PLANEANGLEUNIT.,$,.RADIAN.)".into());
        let units = r.add(format!("IFCUNITASSIGNMENT(({length},{angle}))"));
        let axes = r.axes([0.0; 3]);
        let context = r.add(format!("IFCGEOMETRICREPRESENTATIONCONTEXT($,'Model',3,1.E-5,{axes},$)"));
        r.add(format!("IFCPROJECT('project',$,'P{}',$,$,$,$,({context}),{units})", self.name));
        let site_axes = r.axes([f64::from(self.site_x), 0.0, 0.0]);
        let site_place = r.add(format!("IFCLOCALPLACEMENT($,{site_axes})"));
        r.add(format!("IFCSITE('site',$,'S',$,$,{site_place},$,$,.ELEMENT.,$,$,$,$,$)"));
        let axes = r.axes([0.0, 0.0, f64::from(self.storey_z) / 10.0]);
        let place = r.add(format!("IFCLOCALPLACEMENT({site_place},{axes})"));
        let map = self.map(r, &context);
        let [material, of_type] = [Some(self.material_colour), self.type_material_colour].map(|colour| {
            let material = r.add("IFCMATERIAL('M',$,$)".into());
            if let Some(colour) = colour {
                let styled = r.styled("$", colour);
                let styled = r.add(format!("IFCSTYLEDREPRESENTATION({context},'Style','Material',({styled}))"));
                r.add(format!("IFCMATERIALDEFINITIONREPRESENTATION($,$,({styled}),{material})"));
            }
            material
        });
        let wall_type = r.add("IFCWALLTYPE('type',$,'T',$,$,$,$,$,$,.STANDARD.)".into());
        r.add(format!("IFCRELASSOCIATESMATERIAL('of-type',$,$,$,({wall_type}),{of_type})"));
        let mut walls: Vec<String> = Vec::new();
        for (k, wall) in self.walls.iter().enumerate() {
            let axes = r.axes(if self.is_in_one_frame {
                [f64::from(wall.at[0]) / 10.0, f64::from(wall.at[1]) / 5.0, 0.0]
            } else {
                [f64::from(wall.at[0]), f64::from(wall.at[1]), 1.0]
            });
            let place = if self.is_placed_in_site { &place } else { "$" };
            let its_place = r.add(format!("IFCLOCALPLACEMENT({place},{axes})"));
            let items = self.items(r, wall, &map);
            let kind = if wall.body == Body::Mapped { "MappedRepresentation" } else { "SolidModel" };
            let shape = r.shape(&context, kind, &items);
            let id = r.add(format!("IFCWALL('wall{k}',$,'W{}',$,$,{its_place},{shape},$,.STANDARD.)", self.name));
            for (n, at) in wall.openings.iter().enumerate() {
                let x = f64::from(*at) / 10.0 + if wall.body == Body::Far { 5_000.0 } else { 0.0 };
                let item = r.block([x, -0.5, 0.3], [0.5, 2.0, 1.5]);
                let shape = r.shape(&context, "SweptSolid", &[item]);
                let opening = r.add(format!("IFCOPENINGELEMENT('o{k}-{n}',$,'O',$,$,{its_place},{shape},$,.OPENING.)"));
                r.add(format!("IFCRELVOIDSELEMENT('v{k}-{n}',$,$,$,{id},{opening})"));
            }
            if let Some(whole) = wall.whole {
                r.add(format!("IFCRELAGGREGATES('a{k}',$,$,$,{},({id}))", walls[whole]));
            }
            if wall.has_material {
                r.add(format!("IFCRELASSOCIATESMATERIAL('m{k}',$,$,$,({id}),{material})"));
            }
            if wall.has_type {
                r.add(format!("IFCRELDEFINESBYTYPE('t{k}',$,$,$,({id}),{wall_type})"));
            }
            walls.push(id);
        }
    }

    fn map(&self, r: &mut Records, context: &str) -> String {
        let item = r.block([0.0, 0.0, 0.0], [2.0, 0.3, f64::from(self.map_height) / 10.0]);
        r.styled(&item, self.map_colour);
        let mapped = r.add(format!("IFCSHAPEREPRESENTATION({context},'Body','SweptSolid',({item}))"));
        let origin = r.axes([f64::from(self.map_origin) / 10.0, 0.0, 0.0]);
        r.add(format!("IFCREPRESENTATIONMAP({origin},{mapped})"))
    }

    fn items(&self, r: &mut Records, wall: &Wall, map: &str) -> Vec<String> {
        let length = f64::from(wall.length) / 10.0;
        let size = [length, 0.3, 3.0];
        let items = match wall.body {
            Body::Swept => vec![r.block([0.0; 3], size)],
            Body::Far => vec![r.block([5_000.0, 0.0, 0.0], size)],
            Body::Twice => {
                let item = r.block([0.0; 3], size);
                let other = if wall.is_one_item { item.clone() } else { r.block([0.0; 3], size) };
                vec![item, other]
            }
            Body::Clipped => {
                let (whole, less) =
                    (r.block([0.0; 3], size), r.block([0.0; 3], [f64::from(self.clipped) / 10.0, 0.3, 1.0]));
                vec![r.add(format!("IFCBOOLEANCLIPPINGRESULT(.DIFFERENCE.,{whole},{less})"))]
            }
            Body::Mapped => {
                let origin = r.point([length / 10.0, 0.0, 0.0]);
                let target = r.add(format!("IFCCARTESIANTRANSFORMATIONOPERATOR3D($,$,{origin},$,$)"));
                vec![r.add(format!("IFCMAPPEDITEM({map},{target})"))]
            }
            Body::Open | Body::Triangles => {
                let points: Vec<String> = (0..8)
                    .map(|k| {
                        format!(
                            "({:?},{:?},{:?})",
                            length * f64::from(k & 1),
                            0.3 * f64::from(k >> 1 & 1),
                            3.0 * f64::from(k >> 2)
                        )
                    })
                    .collect();
                let list = r.add(format!("IFCCARTESIANPOINTLIST3D(({}))", points.join(",")));
                let mut faces = vec![
                    "(1,3,4)", "(1,4,2)", "(5,6,8)", "(5,8,7)", "(1,2,6)", "(1,6,5)", "(3,7,8)", "(3,8,4)", "(1,5,7)",
                    "(1,7,3)", "(2,4,8)", "(2,8,6)",
                ];
                if wall.body == Body::Open {
                    faces.pop();
                }
                let item = r.add(format!("IFCTRIANGULATEDFACESET({list},$,$,({}),$)", faces.join(",")));
                if wall.body == Body::Triangles && wall.colour.is_none() {
                    let [a, b] = [self.palette, self.palette ^ 77].map(|c| f64::from(c) / 255.0);
                    let colours = r.add(format!("IFCCOLOURRGBLIST((({a:?},0.5,0.),({b:?},0.,0.5)))"));
                    r.add(format!("IFCINDEXEDCOLOURMAP({item},$,{colours},(1,1,1,1,1,1,2,2,2,2,2,2))"));
                }
                vec![item]
            }
        };
        if let Some(colour) = wall.colour {
            items.iter().for_each(|item| _ = r.styled(item, colour));
        }
        items
    }
}

/// Records of a file, by their references.
struct Records {
    lines: Vec<String>,
    first: usize,
}

impl Records {
    fn file(&self) -> String {
        format!(
            "ISO-10303-21;HEADER;FILE_DESCRIPTION((''),'2;1');FILE_NAME('','',(''),(''),'','','');\
             FILE_SCHEMA(('IFC4'));ENDSEC;DATA;\n{}\nENDSEC;END-ISO-10303-21;",
            self.lines.join("\n")
        )
    }

    fn add(&mut self, record: String) -> String {
        let id = format!("#{}", self.first + self.lines.len());
        self.lines.push(format!("{id}={record};"));
        id
    }

    fn point(&mut self, [x, y, z]: [f64; 3]) -> String {
        self.add(format!("IFCCARTESIANPOINT(({x:?},{y:?},{z:?}))"))
    }

    fn axes(&mut self, at: [f64; 3]) -> String {
        let point = self.point(at);
        self.add(format!("IFCAXIS2PLACEMENT3D({point},$,$)"))
    }

    fn block(&mut self, [x, y, z]: [f64; 3], [dx, dy, dz]: [f64; 3]) -> String {
        let centre = self.add("IFCCARTESIANPOINT((0.,0.))".into());
        let position = self.add(format!("IFCAXIS2PLACEMENT2D({centre},$)"));
        let profile = self.add(format!("IFCRECTANGLEPROFILEDEF(.AREA.,$,{position},{dx:?},{dy:?})"));
        let axes = self.axes([x + dx / 2.0, y + dy / 2.0, z]);
        let up = self.add("IFCDIRECTION((0.,0.,1.))".into());
        self.add(format!("IFCEXTRUDEDAREASOLID({profile},{axes},{up},{dz:?})"))
    }

    fn shape(&mut self, context: &str, kind: &str, items: &[String]) -> String {
        let body = self.add(format!("IFCSHAPEREPRESENTATION({context},'Body','{kind}',({}))", items.join(",")));
        self.add(format!("IFCPRODUCTDEFINITIONSHAPE($,$,({body}))"))
    }

    fn styled(&mut self, item: &str, colour: u8) -> String {
        let colour = self.add(format!("IFCCOLOURRGB($,{:?},0.25,1.)", f64::from(colour) / 255.0));
        let shading = self.add(format!("IFCSURFACESTYLESHADING({colour},0.)"));
        let style = self.add(format!("IFCSURFACESTYLE($,.BOTH.,({shading}))"));
        self.add(format!("IFCSTYLEDITEM({item},({style}),$)"))
    }
}

/// What is read, to be compared.
fn read_with(bytes: &[u8], cache: Option<&MeshCache>) -> String {
    read_isolated(bytes, None, cache)
}

fn read_isolated(bytes: &[u8], isolation: Option<&Isolation<'_>>, cache: Option<&MeshCache>) -> String {
    let options = ReadOptions { pool: Some(&POOL), isolation, cache, ..ReadOptions::default() };
    match read(bytes, &options) {
        Ok((model, diagnostics)) => format!("{model:?}{diagnostics:?}"),
        Err(why) => why.to_string(),
    }
}

/// The cache after a reading.
fn after(cache: &MeshCache) -> MeshCache {
    MeshCache::read(cache.finish(), PROGRAM, MAX_BYTES).unwrap()
}

/// Reads one file after the other; what was taken from the cache each time.
fn check<'t>(files: impl IntoIterator<Item = &'t [u8]>, place: &str) -> Vec<MeshCacheCounts> {
    let mut cache = MeshCache::new(PROGRAM, MAX_BYTES);
    let mut counts = Vec::new();
    for (k, bytes) in files.into_iter().enumerate() {
        let (with, without) = (read_with(bytes, Some(&cache)), read_with(bytes, None));
        if with != without {
            let at = std::iter::zip(with.bytes(), without.bytes()).position(|(a, b)| a != b).unwrap_or(0);
            let around = |text: &str| text.chars().skip(at.saturating_sub(200)).take(400).collect::<String>();
            panic!("{place}, file {k}: with a cache\n{}\nwithout\n{}", around(&with), around(&without));
        }
        counts.push(cache.counts());
        cache = after(&cache);
    }
    counts
}

fn made(plans: &[Plan]) -> Vec<usize> {
    let texts: Vec<String> = plans.iter().map(Plan::text).collect();
    check(texts.iter().map(String::as_bytes), "made").iter().map(|counts| counts.made).collect()
}

#[test]
fn each_number_that_changes_is_in_the_meshes() {
    // A site that is no frame of the walls, and a wall with a gap that has only the openings of what it is a part of.
    let mut other = Plan { site_x: 0, is_placed_in_site: false, ..Plan::new(11) };
    (other.walls[10].whole, other.walls[10].openings) = (Some(9), Vec::new());
    other.walls[10].at = other.walls[9].at;
    for (what, plan) in (0..EDITS).flat_map(|what| [(what, Plan::new(10)), (what, other.clone())]) {
        for (which, to) in [(0, 200), (3, 31), (4, 78), (6, 5), (8, 64), (9, 64)] {
            let mut edited = plan.clone();
            edited.edit(what, which, to);
            let texts = [&plan, &edited, &plan].map(Plan::text);
            check(texts.iter().map(String::as_bytes), &format!("edit {what} of {which} to {to}"));
        }
    }
}

#[test]
fn a_revision_of_one_wall_makes_that_wall_and_its_cut_alone() {
    let plan = Plan::new(10);
    let revised = |edit: &dyn Fn(&mut Plan)| {
        let mut revised = plan.clone();
        edit(&mut revised);
        revised
    };
    let longer = revised(&|plan| plan.walls[0].length += 1);
    let written_anew = revised(&|plan| (plan.first_id, plan.name) = (70_000, 3));
    let whiter = revised(&|plan| plan.walls[0].colour = Some(255));
    let moved = revised(&|plan| plan.storey_z += 1);
    let counts =
        made(&[plan.clone(), longer, plan.clone(), written_anew.clone(), written_anew, plan.clone(), whiter, moved]);
    // The body with a gap is cut by the kernel, which says that it had to guess: such bodies are always made.
    assert_eq!(counts[1..7], [3, 3, 1, 1, 1, 2], "{counts:?}");
    // Copies of a shape with its openings are cut once, wherever they stand.
    assert!(counts[7] > 20, "{counts:?}");
}

/// A file of pipes of other radii, of which nothing bounds what the kernel needs, and their ids.
fn pipes(n: usize) -> (String, Vec<u32>) {
    let mut r = Records { lines: Vec::new(), first: 1 };
    let plan = Plan { walls: Vec::new(), ..Plan::new(1) };
    plan.write(&mut r);
    let [low, high] = [0.0, 3.0].map(|z| r.point([0.0, 0.0, z]));
    let line = r.add(format!("IFCPOLYLINE(({low},{high}))"));
    let axes = r.axes([0.0; 3]);
    let place = r.add(format!("IFCLOCALPLACEMENT($,{axes})"));
    let mut ids = Vec::new();
    for k in 0..n {
        let disk = r.add(format!("IFCSWEPTDISKSOLID({line},{:?},$,$,$)", 0.1 + 0.01 * k as f64));
        let shape = r.shape("$", "AdvancedSweptSolid", &[disk]);
        let pipe = r.add(format!("IFCPIPESEGMENT('pipe{k}',$,'P',$,$,{place},{shape},$,$)"));
        ids.push(pipe[1..].parse().unwrap());
    }
    (r.file(), ids)
}

#[test]
fn what_another_process_gives_up_is_given_up_with_what_was_known_before() {
    let process = |slow: Vec<u32>| {
        move |task: &[&[u8]], _: Option<f64>, take: &mut dyn FnMut(&[u8])| {
            let task = task.concat();
            let words: Vec<u32> =
                task.chunks_exact(4).map(|word| u32::from_le_bytes(word.try_into().unwrap())).collect();
            if words[3..3 + words[0] as usize].iter().any(|id| slow.contains(id)) {
                return (1.0, Err("it takes too long".to_owned()));
            }
            let mut answers = Vec::new();
            let end = mesh_task(&task, &mut |bytes| answers.extend_from_slice(bytes));
            take(&answers);
            (1.0, end.map_err(|why| why.to_string()))
        }
    };
    let (few, _) = pipes(10);
    let (many, ids) = pipes(40);
    let first = MeshCache::new(PROGRAM, MAX_BYTES);
    read_isolated(few.as_bytes(), Some(&process(Vec::new())), Some(&first));
    let slow: [Vec<u32>; 2] = [Vec::new(), ids[10..].to_vec()];
    for (slow, found) in std::iter::zip(slow, [10, 10]) {
        let (second, is_slow) = (after(&first), !slow.is_empty());
        let with = read_isolated(many.as_bytes(), Some(&process(slow.clone())), Some(&second));
        let without = read_isolated(many.as_bytes(), Some(&process(slow)), None);
        assert!(with == without, "slow: {is_slow}");
        assert_eq!(with.contains("others of the file have ended the kernel's process before"), is_slow);
        assert_eq!(second.counts().found, found);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn revisions_in_any_order_are_read_as_without_a_cache(
        n_walls in 1usize..9,
        edits in proptest::collection::vec((any::<u8>(), 0usize..9, any::<u8>()), 1..8),
    ) {
        let mut plan = Plan::new(n_walls);
        let mut texts = vec![plan.text()];
        for (what, which, to) in edits {
            plan.edit(what, which, to);
            texts.push(plan.text());
        }
        check(texts.iter().map(String::as_bytes), "revisions");
    }
}

#[test]
fn buildings_are_read_the_second_time_as_the_first() {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/corpus");
    let corpus = std::env::var_os("GROUNDPLAN_CORPUS").map_or_else(beside, PathBuf::from);
    if !corpus.is_dir() {
        // Not by `eprintln`, which the test harness captures.
        let line = format!("\n** SKIPPED: no corpus at {} (set GROUNDPLAN_CORPUS)\n", corpus.display());
        std::io::stderr().write_all(line.as_bytes()).unwrap();
        return;
    }
    let mut names: Vec<PathBuf> =
        fs::read_dir(corpus.join("representations")).unwrap().map(|entry| entry.unwrap().path()).collect();
    for name in ["AC20-FZK-Haus", "demo2", "fhnw-three-storeys", "creative-freedom", "Duplex_A_20110907_georeferenced"]
    {
        names.push(corpus.join(format!("buildings/{name}.ifc")));
    }
    names.retain(|path| path.extension().is_some_and(|extension| extension == "ifc"));
    names.sort();
    let (mut found, mut made) = (0, 0);
    for path in &names {
        let bytes = fs::read(path).unwrap();
        let counts = check([&bytes[..], &bytes[..]], &path.display().to_string());
        println!("{} {:?}", path.display(), counts);
        found += counts[1].found;
        made += counts[1].made;
    }
    assert!(found > 50 * made.max(1), "{found} found, {made} made");
}
