//! Unpacks plain STEP and zipped STEP (.ifczip).

use std::borrow::Cow;
use std::io::{Cursor, Read};

use crate::ReadError;

/// Decompressed bytes that are accepted.
const UNPACKED_BYTES_MAX: u64 = 2 << 30;
/// STEP text packs 5 to 20 times; a bomb packs a thousand times.
const RATIO_MAX: u64 = 200;

/// The STEP bytes of a file that is plain STEP (`.ifc`) or a zip container (`.ifczip`), detected by content.
///
/// # Errors
/// [`ReadError::Container`] if the container is damaged, holds no or several `.ifc` files, or unpacks to more than 2 GiB
/// or 200 times its size.
pub fn unpack(bytes: &[u8]) -> Result<Cow<'_, [u8]>, ReadError> {
    if !bytes.starts_with(b"PK\x03\x04") && !bytes.starts_with(b"PK\x05\x06") {
        return Ok(Cow::Borrowed(bytes));
    }
    let container = |why: String| ReadError::Container { why };
    let mut archive = zip::ZipArchive::new(Cursor::new(bytes))
        .map_err(|e| container(format!("it is damaged ({e}); copy it again")))?;
    let names: Vec<String> = archive.file_names().filter_map(Result::ok).map(Cow::into_owned).collect();
    let mut models: Vec<&String> =
        names.iter().filter(|n| n.to_ascii_lowercase().ends_with(".ifc") && !n.starts_with("__MACOSX/")).collect();
    models.sort();
    let name = match models[..] {
        [name] => name,
        [] => return Err(container("there is no .ifc file in it".to_owned())),
        _ => return Err(container(format!("there are {} .ifc files in it; unpack it and choose", models.len()))),
    };
    let file = archive.by_name(name).map_err(|e| container(format!("{name} cannot be unpacked ({e})")))?;
    let limit = UNPACKED_BYTES_MAX.min(RATIO_MAX.saturating_mul(bytes.len() as u64).max(1 << 20));
    let mut unpacked = Vec::with_capacity(file.size().min(limit) as usize);
    file.take(limit + 1)
        .read_to_end(&mut unpacked)
        .map_err(|e| container(format!("{name} is damaged ({e}); copy it again")))?;
    if unpacked.len() as u64 > limit {
        return Err(container(format!("{name} unpacks to more than {limit} bytes; unpack it by hand")));
    }
    Ok(Cow::Owned(unpacked))
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    fn zip(files: &[(&str, &[u8])]) -> Vec<u8> {
        let mut writer = zip::ZipWriter::new(Cursor::new(Vec::new()));
        for (name, bytes) in files {
            writer.start_file(*name, zip::write::SimpleFileOptions::default()).unwrap();
            writer.write_all(bytes).unwrap();
        }
        writer.finish().unwrap().into_inner()
    }

    #[test]
    fn plain_bytes_are_borrowed_and_containers_unpacked() {
        assert!(matches!(unpack(b"ISO-10303-21;").unwrap(), Cow::Borrowed(_)));
        let packed = zip(&[("readme.txt", b"x"), ("A.IFC", b"ISO-10303-21;")]);
        assert_eq!(unpack(&packed).unwrap().as_ref(), b"ISO-10303-21;");
    }

    #[test]
    fn unusable_containers_are_errors() {
        let several = zip(&[("a.ifc", b"1"), ("b.ifc", b"2")]);
        let bomb = zip(&[("a.ifc", &vec![0; 64 << 20])]);
        for (bytes, word) in
            [(zip(&[]), "no .ifc"), (several, "2 .ifc"), (bomb, "more than"), (b"PK\x03\x04zz".to_vec(), "damaged")]
        {
            let error = unpack(&bytes).unwrap_err().to_string();
            assert!(error.contains(word), "{error}");
        }
    }
}
