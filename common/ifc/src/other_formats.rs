//! Formats of files that are given in place of IFC, by their first bytes.

/// How much of a file is looked at.
const HEAD_BYTES: usize = 4096;

const FORMATS: [(&[u8], &str); 9] = [
    (
        b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1",
        "a compound file, as those of Revit (.rvt, .rfa) are; open it in Revit and export it with File > Export > IFC",
    ),
    (b"AC10", "a drawing of AutoCAD (.dwg); export IFC from the program that has the building model"),
    (b"AutoCAD Binary DXF", "a drawing (.dxf); export IFC from the program that has the building model"),
    (b"\xff\xfeS\0k\0e\0t\0c\0h\0U\0p\0", "a model of SketchUp (.skp); export it there as IFC"),
    (b"SketchUp", "a model of SketchUp (.skp); export it there as IFC"),
    (
        b"glTF",
        "a mesh (.glb), which has no rooms, doors and walls; export IFC from the program that has the building model",
    ),
    (b"\x89PNG", "a picture (PNG); give a .ifc or .ifczip file"),
    (b"\xff\xd8\xff", "a picture (JPEG); give a .ifc or .ifczip file"),
    (b"%PDF", "a PDF; export IFC from the program that has the building model"),
];

/// What a file is that does not begin as STEP does, with what to do instead; `None` if that is not known.
pub(crate) fn known(bytes: &[u8]) -> Option<&'static str> {
    let head = &bytes[..bytes.len().min(HEAD_BYTES)];
    let has = |word: &[u8]| head.windows(word.len()).any(|window| window.eq_ignore_ascii_case(word));
    let is_text = |start: &[u8], word: &[u8]| head.starts_with(start) && has(word);
    if is_text(b"<", b"ifcXML") || is_text(b"<", b"iso_10303_28") {
        return Some("ifcXML, which is not read; export the model as IFC in STEP (.ifc) or in a zip archive (.ifczip)");
    }
    if is_text(b"{", b"ifc") || is_text(b"[", b"ifc") {
        return Some("IFC in JSON, which is not read; export the model as IFC in STEP (.ifc)");
    }
    FORMATS.iter().find(|(start, _)| head.starts_with(start)).map(|(_, what)| *what)
}

#[cfg(test)]
mod tests {
    use crate::{ReadError, ReadOptions, read};

    #[test]
    fn files_of_other_formats_are_refused_with_what_to_do_instead() {
        let check = |bytes: &[u8], expected: &str| match read(bytes, &ReadOptions::default()) {
            Err(error @ ReadError::OtherFormat { .. }) => assert!(error.to_string().contains(expected), "{error}"),
            Err(other) => panic!("{expected}: {other}"),
            Ok(_) => panic!("{expected} is read"),
        };
        check(b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1rest", "File > Export > IFC");
        check(b"AC1032\0\0", ".dwg");
        check(b"\xef\xbb\xbf<?xml version=\"1.0\"?><ifc:ifcXML/>", "ifcXML, which is not read");
        check(b"<?xml version=\"1.0\"?><iso_10303_28 xmlns=\"x\"/>", "ifcXML, which is not read");
        check(b"{\"type\": \"ifcJSON\"}", "IFC in JSON");
        check(b"\x89PNG\r\n", "a picture (PNG)");
        assert!(matches!(read(b"<html/>", &ReadOptions::default()), Err(ReadError::NotStep { .. })));
    }
}
