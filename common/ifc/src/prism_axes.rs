//! Axes of prisms: the direction along which all items of a body are extruded.

use crate::bounding_boxes::{mapped_items, mapping};
use crate::kernel::File;
use crate::placement::{axis2_placement, direction};
use nalgebra::{Affine3, Vector3};

/// Deepest nesting of mapped items.
const DEPTH_MAX: usize = 8;

/// Least sine of an angle between directions that differ.
const SINE_MIN: f64 = 1e-6;

/// The direction in the coordinates of the product, of unit length; `None` if an item is no prism, or another one's differs.
pub(crate) fn axis_of(file: &File<'_>, items: &[u32]) -> Option<Vector3<f64>> {
    axis_of_items(file, items, 0)
}

fn axis_of_items(file: &File<'_>, items: &[u32], depth: usize) -> Option<Vector3<f64>> {
    let mut axes = items.iter().map(|item| axis_of_item(file, *item, depth));
    let first = axes.next()??;
    axes.all(|axis| axis.is_some_and(|axis| axis.cross(&first).norm() < SINE_MIN)).then_some(first)
}

fn axis_of_item(file: &File<'_>, item: u32, depth: usize) -> Option<Vector3<f64>> {
    let record = file.record(item).filter(|_| depth < DEPTH_MAX)?;
    let axis = if record.is("IFCEXTRUDEDAREASOLID") {
        let frame = match record.at(1).reference() {
            Some(position) => axis2_placement(file, &file.record(position)?, 1.0)?,
            None => Affine3::identity(),
        };
        frame * direction(file, record.at(2).reference()?)?
    } else if record.is("IFCMAPPEDITEM") {
        let inner: Vec<u32> = mapped_items(file, item).collect();
        mapping(file, &record, 1.0)? * axis_of_items(file, &inner, depth + 1)?
    } else {
        return None;
    };
    crate::affine::normalised(axis)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{BASICS, file, with_file};

    #[test]
    fn the_axis_of_prisms_is_found_through_maps_and_turned_positions() {
        let text = file(&format!(
            "{BASICS}#1=IFCEXTRUDEDAREASOLID(#111,#2,#112,1.);#2=IFCAXIS2PLACEMENT3D(#107,#3,$);#3=IFCDIRECTION((0.,2.,0.));
             #4=IFCMAPPEDITEM(#5,#6);#5=IFCREPRESENTATIONMAP(#102,#120);#6=IFCCARTESIANTRANSFORMATIONOPERATOR3D($,$,#107,1.,#3);
             #7=IFCSPHERE(#102,1.);"
        ));
        with_file(&text, |file| {
            assert_eq!(axis_of(file, &[110]), Some(Vector3::z()));
            assert_eq!(axis_of(file, &[1, 4]), Some(Vector3::y()));
            assert_eq!([axis_of(file, &[1, 110]), axis_of(file, &[110, 7]), axis_of(file, &[])], [None; 3]);
        });
    }
}
