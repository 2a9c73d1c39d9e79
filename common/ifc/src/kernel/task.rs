//! Meshing in another process: the task that goes there, and the meshes that come back.
//!
//! A task is the number of products, the number of threads, the ids of the products (32 bits each, little-endian), and the
//! bytes of the file as the kernel is to see it. The result is postcard.

use super::MeshPool;
use super::mesh::{Meshed, mesh_here};
use crate::{Isolation, ReadError};

/// Threads of the other process: each has a stack of a quarter of a gibibyte, and its memory is limited.
const THREADS: u32 = 2;

/// Meshes products in the other process; what it says where it does not.
pub(super) fn mesh_there(bytes: &[u8], products: &[u32], isolation: &Isolation<'_>) -> Result<Meshed, String> {
    let head = [products.len() as u32, THREADS];
    let head: Vec<u8> = head.iter().chain(products).flat_map(|word| word.to_le_bytes()).collect();
    let result = isolation(&[&head, bytes])?;
    postcard::from_bytes(&result).map_err(|error| format!("the process answers what is no mesh: {error}"))
}

/// Meshes the products of a task: what the process runs that [`Isolation`](crate::Isolation) starts.
///
/// # Errors
/// Bytes that are no task, no threads, meshes that cannot be written.
pub fn mesh_task(task: &[u8]) -> Result<Vec<u8>, ReadError> {
    let (words, _) = task.as_chunks::<4>();
    let mut words = words.iter().map(|word| u32::from_le_bytes(*word));
    let (n_products, threads) = words.next().zip(words.next()).ok_or(ReadError::NoTask)?;
    let products: Vec<u32> = words.take(n_products as usize).collect();
    let bytes = task.get(8 + 4 * n_products as usize..).ok_or(ReadError::NoTask)?;
    ifc_lite_core::set_report_sink(|_| {});
    let meshed = mesh_here(bytes, &products, &MeshPool::new(threads as usize)?, &|_, _| {});
    postcard::to_stdvec(&meshed).map_err(|_| ReadError::NoTask)
}

#[cfg(test)]
mod tests {
    use crate::testing::{BASICS, file, volume_m3};
    use crate::{Geometry, GeometryStatus, Isolation, ReadOptions, mesh_task, read};

    /// Two walls, of which nothing bounds the first.
    fn walls() -> String {
        file(&format!(
            "{BASICS}#1=IFCWALL('wall',$,'W',$,$,#103,#2,$,$);#2=IFCPRODUCTDEFINITIONSHAPE($,$,(#3));
             #3=IFCSHAPEREPRESENTATION(#101,'Body','AdvancedSweptSolid',(#4));#4=IFCSWEPTDISKSOLID(#5,0.1,$,$,$);
             #5=IFCPOLYLINE((#107,#6));#6=IFCCARTESIANPOINT((0.,0.,5.));#7=IFCWALL('other',$,'W',$,$,#103,#121,$,$);"
        ))
    }

    fn geometries(isolation: Option<&Isolation<'_>>) -> Vec<Geometry> {
        let options = ReadOptions { isolation, ..ReadOptions::default() };
        let (model, _) = read(walls().as_bytes(), &options).unwrap();
        model.elements.into_iter().map(|element| element.geometry).collect()
    }

    #[test]
    fn meshes_are_the_same_from_there_as_from_here() {
        let there = |task: &[&[u8]]| mesh_task(&task.concat()).map_err(|error| error.to_string());
        let of = |geometries: &[Geometry]| format!("{geometries:?}");
        let (here, there) = (geometries(None), geometries(Some(&there)));
        assert_eq!(of(&here), of(&there));
        assert!(here.iter().all(|geometry| volume_m3(&geometry.parts[0]) > 0.0));
    }

    #[test]
    fn what_cannot_be_meshed_there_is_its_box_and_the_others_are_meshed_here() {
        for answer in [Err("it takes too long".to_owned()), Ok(vec![255; 7])] {
            let [other, first] = &geometries(Some(&|_: &[&[u8]]| answer.clone()))[..] else { panic!() };
            assert_eq!(other.status, GeometryStatus::Meshed);
            let GeometryStatus::BoundingBox { why } = &first.status else { panic!("{first:?}") };
            assert!(why.contains("it takes too long") || why.contains("answers what is no mesh"), "{why}");
        }
    }

    #[test]
    fn bytes_that_are_no_task_are_an_error() {
        assert!(mesh_task(b"").is_err() && mesh_task(&[9; 12]).is_err());
    }
}
