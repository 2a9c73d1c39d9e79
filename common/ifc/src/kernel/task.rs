//! Meshing in another process: the task that goes there, and the answers that come back while it works.
//!
//! A task is the number of products, of threads and of products that are meshed at a time, the ids of the products in the order
//! of their records (32 bits each, little-endian), and the bytes of the file as the kernel is to see it. An answer is its
//! length (32 bits) and, in postcard, products that are done and their meshes: what ends the process loses none of them.

use serde::{Deserialize, Serialize};

use super::MeshPool;
use super::mesh::{Meshed, mesh_in_batches};
use crate::{Isolation, ReadError};

/// Threads of the other process: each has a stack of a quarter of a gibibyte, and its memory is limited.
const THREADS: u32 = 2;

/// Products that are done, and what there is of them.
#[derive(Serialize, Deserialize)]
pub(super) struct Answer {
    pub(super) products: Vec<u32>,
    pub(super) meshed: Meshed,
}

/// Meshes products in the other process, so many at a time, in at most so much CPU time in all, and hands on its answers.
pub(super) fn mesh_there(
    bytes: &[u8],
    products: &[u32],
    batch: usize,
    max_cpu_s: Option<f64>,
    isolation: &Isolation<'_>,
    mut take: impl FnMut(Answer),
) -> (f64, Result<(), String>) {
    let head = [products.len() as u32, THREADS, batch as u32];
    let head: Vec<u8> = head.iter().chain(products).flat_map(|word| word.to_le_bytes()).collect();
    let (mut waiting, mut is_garbled) = (Vec::new(), false);
    let (cpu_s, end) = isolation(&[&head, bytes], max_cpu_s, &mut |piece| {
        waiting.extend_from_slice(piece);
        while let Some((length, _)) = waiting.split_first_chunk::<4>().filter(|_| !is_garbled) {
            let length = 4 + u32::from_le_bytes(*length) as usize;
            let Some(answer) = waiting.get(4..length) else { break };
            match postcard::from_bytes(answer) {
                Ok(answer) => take(answer),
                Err(_) => is_garbled = true,
            }
            waiting.drain(..length);
        }
    });
    if is_garbled || end.is_ok() && !waiting.is_empty() {
        return (cpu_s, Err("its process answers what is no mesh".to_owned()));
    }
    (cpu_s, end)
}

/// Meshes the products of a task, and gives each answer to `send` as soon as it is known: what the process runs that
/// [`Isolation`](crate::Isolation) starts. An answer without products says that the file is read.
///
/// # Errors
/// Bytes that are no task, no threads, meshes that cannot be written.
pub fn mesh_task(task: &[u8], send: &mut (dyn FnMut(&[u8]) + Send)) -> Result<(), ReadError> {
    let (words, _) = task.as_chunks::<4>();
    let mut words = words.iter().map(|word| u32::from_le_bytes(*word));
    let mut word = || words.next().ok_or(ReadError::NoTask);
    let (n_products, threads, batch) = (word()?, word()?, word()?);
    let bytes = task.get(12 + 4 * n_products as usize..).ok_or(ReadError::NoTask)?;
    let products: Vec<u32> = words.take(n_products as usize).collect();
    ifc_lite_core::set_report_sink(|_| {});
    let pool = MeshPool::new(threads as usize)?;
    let mut is_written = true;
    let mut take = |products: &[u32], meshed| match postcard::to_stdvec(&Answer { products: products.to_vec(), meshed })
    {
        Ok(answer) => {
            send(&(answer.len() as u32).to_le_bytes());
            send(&answer);
        }
        Err(_) => is_written = false,
    };
    pool.install(|| mesh_in_batches(bytes, &products, batch as usize, &mut take));
    if is_written { Ok(()) } else { Err(ReadError::NoTask) }
}

#[cfg(test)]
mod tests {
    use super::Answer;
    use crate::testing::{BASICS, file, volume_m3};
    use crate::{Geometry, GeometryStatus, Isolation, ReadOptions, mesh_task, read};
    use std::sync::atomic::{AtomicUsize, Ordering};

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

    /// The other process, as if it were this one.
    fn there(task: &[&[u8]], _: Option<f64>, take: &mut dyn FnMut(&[u8])) -> (f64, Result<(), String>) {
        let mut answers = Vec::new();
        let end = mesh_task(&task.concat(), &mut |bytes| answers.extend_from_slice(bytes));
        // A pipe cuts where it likes.
        answers.chunks(7).for_each(take);
        (0.0, end.map_err(|error| error.to_string()))
    }

    #[test]
    fn meshes_are_the_same_from_there_as_from_here() {
        let of = |geometries: &[Geometry]| format!("{geometries:?}");
        let (here, there) = (geometries(None), geometries(Some(&there)));
        assert_eq!(of(&here), of(&there));
        assert!(here.iter().all(|geometry| volume_m3(&geometry.parts[0]) > 0.0));
    }

    #[test]
    fn what_cannot_be_meshed_there_is_its_box_and_the_others_are_meshed_here() {
        for answer in [Err("it takes too long".to_owned()), Ok(vec![2, 0, 0, 0, 255, 255, 7])] {
            let process = |_: &[&[u8]], _: Option<f64>, take: &mut dyn FnMut(&[u8])| {
                (0.0, answer.clone().map(|bytes| take(&bytes)))
            };
            let [other, first] = &geometries(Some(&process))[..] else { panic!() };
            assert_eq!(other.status, GeometryStatus::Meshed);
            let GeometryStatus::BoundingBox { why } = &first.status else { panic!("{first:?}") };
            assert!(why.contains("it takes too long") || why.contains("answers what is no mesh"), "{why}");
        }
    }

    #[test]
    fn a_body_that_is_given_up_is_its_box_although_its_openings_would_leave_nothing_of_it() {
        let opening = "#20=IFCOPENINGELEMENT('opening',$,$,$,$,#103,#21,$,$);#21=IFCPRODUCTDEFINITIONSHAPE($,$,(#22));
            #22=IFCSHAPEREPRESENTATION(#101,'Body','SweptSolid',(#23));#23=IFCEXTRUDEDAREASOLID(#111,#24,#112,9.);
            #24=IFCAXIS2PLACEMENT3D(#25,$,$);#25=IFCCARTESIANPOINT((0.,0.,-2.));#26=IFCRELVOIDSELEMENT('r',$,$,$,#1,#20);";
        let text = walls().replace("#7=IFCWALL(", &format!("{opening}#7=IFCWALL("));
        let status_of_first = |isolation: &Isolation<'_>| {
            let options = ReadOptions { isolation: Some(isolation), ..ReadOptions::default() };
            let (model, _) = read(text.as_bytes(), &options).unwrap();
            model.elements.into_iter().find(|element| &*element.id.global_id == "wall").unwrap().geometry.status
        };
        assert_eq!(status_of_first(&there), GeometryStatus::None);
        let ended = |_: &[&[u8]], _: Option<f64>, _: &mut dyn FnMut(&[u8])| (0.0, Err("it takes too long".to_owned()));
        let GeometryStatus::BoundingBox { why } = status_of_first(&ended) else { panic!() };
        assert!(why.contains("it takes too long"), "{why}");
    }

    /// Products without bounds, and the number of processes that they took. Each that is done takes a second, and those of `slow`
    /// end the process.
    fn pipes(n: u32, slow: &[u32]) -> (Vec<Geometry>, usize) {
        let pipe = |k: u32| format!("#{}=IFCPIPESEGMENT('pipe{k:02}',$,'P',$,$,#103,#2,$,$);", 1_000 + k);
        let text = file(&format!(
            "{BASICS}{}#2=IFCPRODUCTDEFINITIONSHAPE($,$,(#3));#3=IFCSHAPEREPRESENTATION(#101,'Body','AdvancedSweptSolid',(#4));
             #4=IFCSWEPTDISKSOLID(#5,0.1,$,$,$);#5=IFCPOLYLINE((#107,#6));#6=IFCCARTESIANPOINT((0.,0.,5.));",
            // The order of the records is another than that of the GlobalIds.
            (0..n).rev().map(pipe).collect::<String>()
        ));
        let n_started = AtomicUsize::new(0);
        let process = |task: &[&[u8]], max_cpu_s: Option<f64>, take: &mut dyn FnMut(&[u8])| {
            n_started.fetch_add(1, Ordering::Relaxed);
            let mut pieces = Vec::new();
            let (mut cpu_s, mut end) = there(task, max_cpu_s, &mut |piece| pieces.extend_from_slice(piece));
            // Answers come until a slow one is among the products that are done.
            let mut rest = &pieces[..];
            while let Some((length, _)) = rest.split_first_chunk::<4>() {
                let (answer, others) = rest.split_at(4 + u32::from_le_bytes(*length) as usize);
                let found: Answer = postcard::from_bytes(&answer[4..]).unwrap();
                if found.products.iter().any(|product| slow.contains(&(product - 1_000))) {
                    end = Err("it takes too long".to_owned());
                    break;
                }
                cpu_s += found.products.len() as f64;
                take(answer);
                rest = others;
            }
            (cpu_s, end)
        };
        let options = ReadOptions { isolation: Some(&process), ..ReadOptions::default() };
        let (model, _) = read(text.as_bytes(), &options).unwrap();
        (model.elements.into_iter().map(|element| element.geometry).collect(), n_started.into_inner())
    }

    #[test]
    fn a_product_that_ends_the_process_loses_no_other() {
        let (geometries, n_started) = pipes(40, &[7, 30]);
        let lost: Vec<usize> = (0..40).filter(|k| geometries[*k].status != GeometryStatus::Meshed).collect();
        assert_eq!(lost, [7, 30]);
        // All at once, the batch one by one, and what is left of it: for each, and then the rest.
        assert!(n_started <= 8, "{n_started}");
    }

    #[test]
    fn what_is_left_after_many_that_end_the_process_is_not_tried() {
        let slow: Vec<u32> = (20..100).collect();
        let (geometries, n_started) = pipes(100, &slow);
        assert!(geometries.iter().all(|geometry| geometry.status != GeometryStatus::Meshed));
        let GeometryStatus::BoundingBox { why } = &geometries[0].status else { panic!("{:?}", geometries[0]) };
        assert!(why.contains("others of the file have ended the kernel's process before"), "{why}");
        assert!(n_started <= 8, "{n_started}");
    }

    #[test]
    fn bytes_that_are_no_task_are_an_error() {
        assert!(mesh_task(b"", &mut |_| {}).is_err() && mesh_task(&[9; 12], &mut |_| {}).is_err());
    }
}
