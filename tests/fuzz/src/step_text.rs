//! Mutations of STEP text that keep it STEP text: arguments, references and whole records change, not single bytes.

use std::ops::Range;

/// What a number may become.
const NUMBERS: [&str; 16] = [
    "0.",
    "-0.",
    "1.",
    "-1.",
    "1.E-7",
    "1.E-20",
    "1.E7",
    "1.E9",
    "1.E19",
    "1.E38",
    "1.E300",
    "-1.E308",
    "0.5",
    "3.14159",
    "2147483648",
    "-1",
];

/// What a text, a name or any other argument may become.
const WORDS: [&str; 24] = [
    "$",
    "*",
    "''",
    "()",
    ".T.",
    ".F.",
    ".U.",
    "($)",
    "'P1D'",
    "'P99999999Y'",
    "'PT1S'",
    "'-P3D'",
    "'2024-02-29'",
    "'9999-12-31T23:59:59'",
    "'0000-01-01'",
    "'24:00:00'",
    "'00:00:00'",
    "IFCRATIOMEASURE(1.E9)",
    "IFCLABEL('x')",
    "IFCDURATION('P5D')",
    ".DIFFERENCE.",
    ".WORKTIME.",
    "((0.,0.,0.),(1.,0.,0.),(0.,1.,0.))",
    "(1,2,3)",
];

/// Records that are inserted; `@` becomes a reference to one of the file.
const RECORDS: [&str; 44] = [
    "IFCEXTRUDEDAREASOLID(@,@,@,1.)",
    "IFCREVOLVEDAREASOLID(@,@,@,1.5)",
    "IFCBOOLEANRESULT(.DIFFERENCE.,@,@)",
    "IFCBOOLEANCLIPPINGRESULT(.DIFFERENCE.,@,@)",
    "IFCHALFSPACESOLID(@,.F.)",
    "IFCPOLYGONALBOUNDEDHALFSPACE(@,.T.,@,@)",
    "IFCPLANE(@)",
    "IFCFACETEDBREP(@)",
    "IFCCLOSEDSHELL((@,@,@))",
    "IFCFACE((@))",
    "IFCFACEOUTERBOUND(@,.T.)",
    "IFCPOLYLOOP((@,@,@))",
    "IFCTRIANGULATEDFACESET(@,$,.T.,((1,2,3),(1,3,2)),$)",
    "IFCPOLYGONALFACESET(@,.T.,(@),$)",
    "IFCINDEXEDPOLYGONALFACE((1,2,3))",
    "IFCCARTESIANPOINTLIST3D(((0.,0.,0.),(1.,0.,0.),(0.,1.,0.),(0.,0.,1.)))",
    "IFCMAPPEDITEM(@,@)",
    "IFCREPRESENTATIONMAP(@,@)",
    "IFCCARTESIANTRANSFORMATIONOPERATOR3D(@,@,@,2.,@)",
    "IFCARBITRARYCLOSEDPROFILEDEF(.AREA.,$,@)",
    "IFCARBITRARYPROFILEDEFWITHVOIDS(.AREA.,$,@,(@))",
    "IFCPOLYLINE((@,@,@))",
    "IFCCIRCLEPROFILEDEF(.AREA.,$,@,0.3)",
    "IFCISHAPEPROFILEDEF(.AREA.,$,@,0.2,0.3,0.01,0.02,$)",
    "IFCRECTANGLEHOLLOWPROFILEDEF(.AREA.,$,@,1.,1.,0.1,$,$)",
    "IFCTRIMMEDCURVE(@,(IFCPARAMETERVALUE(0.)),(IFCPARAMETERVALUE(1.)),.T.,.PARAMETER.)",
    "IFCCIRCLE(@,1.)",
    "IFCCOMPOSITECURVE((@,@),.F.)",
    "IFCCOMPOSITECURVESEGMENT(.CONTINUOUS.,.T.,@)",
    "IFCSWEPTDISKSOLID(@,0.1,$,0.,1.)",
    "IFCSURFACECURVESWEPTAREASOLID(@,@,@,0.,1.,@)",
    "IFCCSGSOLID(@)",
    "IFCRIGHTCIRCULARCYLINDER(@,2.,1.)",
    "IFCLOCALPLACEMENT(@,@)",
    "IFCCARTESIANPOINT((1.,2.,3.))",
    "IFCDIRECTION((0.,1.,0.))",
    "IFCRELVOIDSELEMENT('v',$,$,$,@,@)",
    "IFCRELAGGREGATES('a',$,$,$,@,(@))",
    "IFCRELNESTS('n',$,$,$,@,(@))",
    "IFCRELSEQUENCE('s',$,$,$,@,@,@,.FINISH_FINISH.,$)",
    "IFCLAGTIME($,$,$,IFCDURATION('-P3D'),.ELAPSEDTIME.)",
    "IFCRELASSIGNSTOPRODUCT('p',$,$,$,(@),$,@)",
    "IFCRECURRENCEPATTERN(.YEARLY_BY_POSITION.,(31),(7),(2),-1,3,99,(@))",
    "IFCTASKTIME($,$,$,.WORKTIME.,'P400D','2024-03-04',$,$,$,$,$,$,$,$,$,$,'2024-03-04','2024-02-01',$,1.)",
];

/// Changes the text in the first `size` bytes of `data`; the new size, at most `max_size`. `any` changes bytes.
pub fn mutate(
    data: &mut [u8],
    size: usize,
    max_size: usize,
    seed: u32,
    any: impl FnOnce(&mut [u8], usize, usize) -> usize,
) -> usize {
    let mut random = RandomGenerator(u64::from(seed) | 1 << 32);
    let records = records(&data[..size]);
    if records.is_empty() || random.below(8) == 0 {
        return any(data, size, max_size);
    }
    let mut text = data[..size].to_vec();
    for _ in 0..=random.below(3) {
        change(&mut text, &mut random);
    }
    if text.len() > max_size {
        return any(data, size, max_size);
    }
    data[..text.len()].copy_from_slice(&text);
    text.len()
}

/// One change.
fn change(text: &mut Vec<u8>, random: &mut RandomGenerator) {
    let records = records(text);
    let Some(record) = random.of(&records).cloned() else { return };
    match random.below(16) {
        0 => drop(text.drain(record)),
        1 => {
            let copy = with_another_id(&text[record.clone()], random);
            text.splice(record.end..record.end, copy);
        }
        2..=4 => {
            let made = from_template(text, &records, random);
            // It takes the place of a record that others refer to, or joins the file.
            match (random.below(2), id_of(text, &record)) {
                (0, Some(id)) => {
                    let at = record.start + id.end..record.end;
                    text.splice(at, [b"=", made.as_slice(), b";"].concat());
                }
                _ => {
                    let line = [format!("#{}=", 1000 + random.below(64)).as_bytes(), &made, b";"].concat();
                    text.splice(record.end..record.end, line);
                }
            }
        }
        _ => {
            let tokens = tokens(&text[record.clone()]);
            let Some(token) = random.of(&tokens).cloned() else { return };
            let token = record.start + token.start..record.start + token.end;
            let new = replacement(text, &token, &records, random);
            text.splice(token, new);
        }
    }
}

/// What an argument becomes: mostly of its own kind.
fn replacement(text: &[u8], token: &Range<usize>, records: &[Range<usize>], random: &mut RandomGenerator) -> Vec<u8> {
    if random.below(6) == 0 {
        return random.of(&WORDS).map(|w| w.as_bytes().to_vec()).unwrap_or_default();
    }
    match text[token.start] {
        b'#' => reference(text, records, random),
        b'0'..=b'9' | b'-' | b'+' => match (random.below(3), std::str::from_utf8(&text[token.clone()])) {
            (0, Ok(number)) => number.parse::<f64>().map_or(Vec::new(), |x| {
                let factor = [2.0, 0.5, -1.0, 1000.0, 0.001][random.below(5)];
                format!("{:?}", x * factor).into_bytes()
            }),
            _ => random.of(&NUMBERS).map(|w| w.as_bytes().to_vec()).unwrap_or_default(),
        },
        _ => {
            // An argument of another record, so that enumerations and texts are ones that occur.
            let Some(other) = random.of(records) else { return Vec::new() };
            let tokens = tokens(&text[other.clone()]);
            random.of(&tokens).map(|t| text[other.start + t.start..other.start + t.end].to_vec()).unwrap_or_default()
        }
    }
}

fn reference(text: &[u8], records: &[Range<usize>], random: &mut RandomGenerator) -> Vec<u8> {
    let id = random.of(records).and_then(|r| Some(text[r.clone()][id_of(text, r)?].to_vec()));
    id.unwrap_or_else(|| b"$".to_vec())
}

fn from_template(text: &[u8], records: &[Range<usize>], random: &mut RandomGenerator) -> Vec<u8> {
    let template = random.of(&RECORDS).copied().unwrap_or_default();
    let mut made = Vec::new();
    for byte in template.bytes() {
        if byte == b'@' { made.extend(reference(text, records, random)) } else { made.push(byte) }
    }
    made
}

fn with_another_id(record: &[u8], random: &mut RandomGenerator) -> Vec<u8> {
    let equals = record.iter().position(|&b| b == b'=').unwrap_or(0);
    [format!("#{}", 1000 + random.below(64)).as_bytes(), &record[equals..]].concat()
}

/// `#12` in `#12=..`, within the record.
fn id_of(text: &[u8], record: &Range<usize>) -> Option<Range<usize>> {
    let record = &text[record.clone()];
    let start = record.iter().position(|&b| b == b'#')?;
    let digits = record[start + 1..].iter().take_while(|b| b.is_ascii_digit()).count();
    (digits > 0).then_some(start..start + 1 + digits)
}

/// Records `#..;` of the text.
fn records(text: &[u8]) -> Vec<Range<usize>> {
    let mut found = Vec::new();
    let (mut start, mut is_quoted) = (0, false);
    for (at, &byte) in text.iter().enumerate() {
        match byte {
            b'\'' => is_quoted = !is_quoted,
            b';' if !is_quoted => {
                let blanks = text[start..at].iter().take_while(|b| b.is_ascii_whitespace()).count();
                if text[start + blanks] == b'#' {
                    found.push(start + blanks..at + 1);
                }
                start = at + 1;
            }
            _ => {}
        }
    }
    found
}

/// Keyword and arguments of a record, those in lists one by one.
fn tokens(record: &[u8]) -> Vec<Range<usize>> {
    let begin = record.iter().position(|&b| b == b'=').map_or(record.len(), |at| at + 1);
    let mut found = Vec::new();
    let (mut start, mut is_quoted) = (begin, false);
    for (at, &byte) in record.iter().enumerate().skip(begin) {
        is_quoted ^= byte == b'\'';
        if !is_quoted && matches!(byte, b'(' | b')' | b',' | b';') {
            if start < at {
                found.push(start..at);
            }
            start = at + 1;
        }
    }
    found
}

/// Numbers from a seed (splitmix64).
struct RandomGenerator(u64);

impl RandomGenerator {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % n.max(1) as u64) as usize
    }

    fn of<'a, T>(&mut self, all: &'a [T]) -> Option<&'a T> {
        all.get(self.below(all.len()))
    }
}
