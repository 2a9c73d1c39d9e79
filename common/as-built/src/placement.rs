//! Placements: where a chain of IfcLocalPlacement lies, and how an element is moved with all that belongs to it.

use crate::editor::Editor;
use crate::owner_history::OwnerHistory;
use crate::step_file::{Instance, StepFile, members, number};
use crate::step_text::{real, reference};
use nalgebra::{Matrix3, Vector3};
use std::collections::{BTreeMap, BTreeSet};

/// Placements in a chain; real files stay below ten.
const DEPTH_MAX: usize = 100;
/// Place of ObjectPlacement in IfcProduct.
pub(crate) const OBJECT_PLACEMENT: usize = 5;

/// A rotation and a translation in units of the file.
pub(crate) struct Motion {
    pub(crate) rotation: Matrix3<f64>,
    pub(crate) translation: Vector3<f64>,
}

/// Where a placement lies in the world; the world itself for none.
///
/// # Errors
/// Why that cannot be told.
pub(crate) fn world_from(file: &StepFile<'_>, placement: Option<u64>) -> Result<Motion, String> {
    let mut motion = Motion { rotation: Matrix3::identity(), translation: Vector3::zeros() };
    let mut next = placement;
    for _ in 0..DEPTH_MAX {
        let Some(id) = next else { return Ok(motion) };
        let local = local_placement(file, id)?;
        let axes = file.referred(&local, 1).ok_or_else(|| format!("#{id} has no relative placement"))?;
        let own = axis_placement(file, &axes)?;
        motion = Motion {
            rotation: own.rotation * motion.rotation,
            translation: own.rotation * motion.translation + own.translation,
        };
        next = file.reference(&local, 0);
    }
    Err("its placements refer to each other in a circle".to_owned())
}

fn local_placement<'a>(file: &StepFile<'a>, id: u64) -> Result<Instance<'a>, String> {
    let found = file.instance(id).ok_or_else(|| format!("its placement #{id} does not exist"))?;
    match found.is("IFCLOCALPLACEMENT") && found.arguments.len() == 2 {
        true => Ok(found),
        false => Err(format!("its placement #{id} is {}, not IfcLocalPlacement", found.entity)),
    }
}

fn axis_placement(file: &StepFile<'_>, axes: &Instance<'_>) -> Result<Motion, String> {
    let is_plane = axes.is("IFCAXIS2PLACEMENT2D");
    if !is_plane && !axes.is("IFCAXIS2PLACEMENT3D") {
        return Err(format!("#{} is {}, which is not understood here", axes.id, axes.entity));
    }
    let translation = file.referred(axes, 0).map(|point| vector(file, &point));
    let translation = translation.ok_or_else(|| format!("#{} has no location", axes.id))?;
    let direction = |k: usize| file.referred(axes, k).map(|direction| vector(file, &direction));
    let z = if is_plane { None } else { direction(1) }.unwrap_or_else(Vector3::z);
    let x = direction(if is_plane { 1 } else { 2 }).unwrap_or_else(Vector3::x);
    let z = z.try_normalize(1e-12).ok_or_else(|| format!("the axis of #{} has no length", axes.id))?;
    let x = (x - z * x.dot(&z)).try_normalize(1e-12);
    let x = x.ok_or_else(|| format!("the axes of #{} are parallel", axes.id))?;
    Ok(Motion { rotation: Matrix3::from_columns(&[x, z.cross(&x), z]), translation })
}

/// Coordinates of a point, or ratios of a direction.
fn vector(file: &StepFile<'_>, instance: &Instance<'_>) -> Vector3<f64> {
    let text = file.argument(instance, 0);
    let places = members(text, 0).unwrap_or_default();
    let mut values = places.into_iter().map(|place| number(&text[place]).unwrap_or(0.0));
    let mut next = || values.next().unwrap_or(0.0);
    Vector3::new(next(), next(), next())
}

/// A number without dust behind a millionth of the unit.
pub(crate) fn rounded(value: f64) -> String {
    real((value * 1e6).round() / 1e6)
}

/// What moves with elements: openings, what fills them, parts; and which products share a placement. Made once for a file.
pub(crate) struct Dependents {
    of: BTreeMap<u64, Vec<u64>>,
    by_placement: BTreeMap<u64, Vec<u64>>,
    moved: BTreeSet<u64>,
    /// Placements that were changed.
    placements: BTreeSet<u64>,
}

impl Dependents {
    pub(crate) fn of(file: &StepFile<'_>) -> Self {
        let mut of: BTreeMap<u64, Vec<u64>> = BTreeMap::new();
        let kinds =
            ["IFCRELVOIDSELEMENT", "IFCRELFILLSELEMENT", "IFCRELAGGREGATES", "IFCRELPROJECTSELEMENT", "IFCRELNESTS"];
        for relation in kinds.iter().flat_map(|kind| file.all(kind)) {
            if let Some(whole) = file.reference(&relation, 4) {
                of.entry(whole).or_default().extend(file.references(&relation, 5));
            }
        }
        let mut by_placement: BTreeMap<u64, Vec<u64>> = BTreeMap::new();
        for product in file.roots().filter_map(|id| file.instance(id)) {
            if !product.entity.to_ascii_uppercase().starts_with("IFCREL")
                && let Some(placement) = file.reference(&product, OBJECT_PLACEMENT)
            {
                by_placement.entry(placement).or_default().push(product.id);
            }
        }
        Self { of, by_placement, moved: BTreeSet::new(), placements: BTreeSet::new() }
    }

    /// An element and what depends on it, wholes before parts.
    fn with_all(&self, element: u64) -> Vec<u64> {
        let (mut all, mut seen) = (vec![element], BTreeSet::from([element]));
        let mut k = 0;
        while let Some(id) = all.get(k) {
            let next: Vec<u64> = self.of.get(id).into_iter().flatten().copied().filter(|id| seen.insert(*id)).collect();
            all.extend(next);
            k += 1;
        }
        all
    }
}

/// Moves an element, and what depends on it: openings, what fills them, parts. What else is placed relative to it moves too, since
/// it is placed so. The answer names what moved along.
///
/// # Errors
/// Why it cannot be moved; then nothing is.
pub(crate) fn move_element(
    editor: &mut Editor<'_, '_>,
    owner: &mut OwnerHistory,
    dependents: &mut Dependents,
    element: &Instance<'_>,
    by: Vector3<f64>,
) -> Result<Vec<String>, String> {
    let file = editor.file;
    let all = dependents.with_all(element.id);
    if all.iter().any(|id| dependents.moved.contains(id)) {
        return Err("it moves along with another element, or another one with it".to_owned());
    }
    // Everything is looked at before anything is written.
    let is_twice = "it is placed relative to another element that is moved, or another one relative to it";
    let mut moved: BTreeSet<u64> = BTreeSet::new();
    let mut plans = Vec::new();
    for object in all.iter().filter_map(|id| file.instance(*id)) {
        let Some(placement) = file.reference(&object, OBJECT_PLACEMENT) else {
            if object.id == element.id {
                return Err("it has no placement".to_owned());
            }
            continue;
        };
        if follows(file, placement, &moved)? {
            continue;
        }
        if follows(file, placement, &dependents.placements)? {
            return Err(is_twice.to_owned());
        }
        let local = local_placement(file, placement)?;
        let axes = file.referred(&local, 1).ok_or_else(|| format!("#{placement} has no relative placement"))?;
        let parent = world_from(file, file.reference(&local, 0))?;
        let by_local = parent.rotation.transpose() * by;
        let is_shared = dependents.by_placement.get(&placement).into_iter().flatten().any(|id| !all.contains(id));
        let location = axis_placement(file, &axes)?.translation + by_local;
        if axes.is("IFCAXIS2PLACEMENT2D") && by_local.z.abs() > 1e-9 {
            return Err(format!("its placement #{placement} lies in a plane that it would leave"));
        }
        // What is placed relative to one that others share gets a placement of its own, as this does.
        if !is_shared {
            moved.insert(placement);
        }
        plans.push((object, local, axes, location, is_shared));
    }
    for earlier in &dependents.placements {
        if follows(file, *earlier, &moved)? {
            return Err(is_twice.to_owned());
        }
    }
    dependents.moved.extend(&all);
    dependents.placements.extend(&moved);
    let mut names = Vec::new();
    for id in all.iter().skip(1) {
        names.extend(file.instance(*id).and_then(|object| file.global_id(&object).map(str::to_owned)));
    }
    for (object, local, axes, location, is_shared) in plans {
        let n = if axes.is("IFCAXIS2PLACEMENT2D") { 2 } else { 3 };
        let coordinates: Vec<String> = location.iter().take(n).map(|value| rounded(*value)).collect();
        let point = editor.add("IFCCARTESIANPOINT", &[format!("({})", coordinates.join(","))]);
        let kept = (1..axes.arguments.len()).map(|k| editor.argument(&axes, k));
        let arguments: Vec<String> = std::iter::once(reference(point)).chain(kept).collect();
        let axes = editor.add(&axes.entity.to_ascii_uppercase(), &arguments);
        if is_shared {
            let parent = editor.argument(&local, 0);
            let new = editor.add("IFCLOCALPLACEMENT", &[parent, reference(axes)]);
            editor.set(&object, OBJECT_PLACEMENT, reference(new));
            owner.mark_changed(editor, &object);
        } else {
            editor.set(&local, 1, reference(axes));
        }
    }
    owner.mark_changed(editor, element);
    Ok(names)
}

/// True if a placement is one of these, or lies relative to one.
fn follows(file: &StepFile<'_>, placement: u64, moved: &BTreeSet<u64>) -> Result<bool, String> {
    let mut next = Some(placement);
    for _ in 0..DEPTH_MAX {
        match next {
            Some(id) if moved.contains(&id) => return Ok(true),
            Some(id) => next = file.instance(id).and_then(|local| file.reference(&local, 0)),
            None => return Ok(false),
        }
    }
    Err("its placements refer to each other in a circle".to_owned())
}
