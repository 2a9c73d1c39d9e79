//! Material names of elements.

use rustc_hash::FxHashMap;

use crate::kernel::File;
use crate::relations::Relations;

/// Deepest chain from an association to a material; the schema needs four steps.
const DEPTH_MAX: usize = 6;

/// Material names, each definition read once.
pub(crate) struct Materials<'f, 'a> {
    file: &'f File<'a>,
    known: FxHashMap<u32, Vec<String>>,
}

impl<'f, 'a> Materials<'f, 'a> {
    pub(crate) fn new(file: &'f File<'a>) -> Self {
        Self { file, known: FxHashMap::default() }
    }

    /// Names in the order of layers, profiles or constituents, without repetition; of the occurrence, else of its type.
    pub(crate) fn of(&mut self, object: u32, relations: &Relations) -> Vec<String> {
        let type_of = relations.type_of.get(&object);
        let definitions = [Some(&object), type_of].map(|o| o.and_then(|o| relations.material.get(o)));
        definitions.into_iter().flatten().map(|&d| self.names(d)).find(|names| !names.is_empty()).unwrap_or_default()
    }

    fn names(&mut self, definition: u32) -> Vec<String> {
        let file = self.file;
        let collect = || {
            let mut names = Vec::new();
            collect(file, definition, 0, &mut names);
            names
        };
        self.known.entry(definition).or_insert_with(collect).clone()
    }
}

fn collect(file: &File<'_>, id: u32, depth: usize, names: &mut Vec<String>) {
    let Some(record) = file.record(id).filter(|_| depth < DEPTH_MAX) else { return };
    let next = match record.keyword.to_ascii_uppercase().as_str() {
        "IFCMATERIAL" => {
            let name = record.text(0);
            if !name.is_empty() && !names.contains(&name) {
                names.push(name);
            }
            return;
        }
        "IFCMATERIALLIST"
        | "IFCMATERIALLAYERSET"
        | "IFCMATERIALLAYERSETUSAGE"
        | "IFCMATERIALLAYER"
        | "IFCMATERIALLAYERWITHOFFSETS"
        | "IFCMATERIALPROFILESETUSAGE"
        | "IFCMATERIALPROFILESETUSAGETAPERING" => 0,
        "IFCMATERIALCONSTITUENTSET"
        | "IFCMATERIALCONSTITUENT"
        | "IFCMATERIALPROFILESET"
        | "IFCMATERIALPROFILE"
        | "IFCMATERIALPROFILEWITHOFFSETS" => 2,
        _ => return,
    };
    for id in record.at(next).references() {
        collect(file, id, depth + 1, names);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{file, with_file};
    use diagnostics::Report;

    #[test]
    fn names_are_found_through_layers_and_through_the_type() {
        let text = file(
            "#1=IFCRELASSOCIATESMATERIAL('a',$,$,$,(#10),#2);#2=IFCMATERIALLAYERSETUSAGE(#3,.AXIS2.,.POSITIVE.,0.);
             #3=IFCMATERIALLAYERSET((#4,#5,#6),'set');#4=IFCMATERIALLAYER(#7,0.1,$);#5=IFCMATERIALLAYER(#8,0.1,$);
             #6=IFCMATERIALLAYER(#7,0.1,$);#7=IFCMATERIAL('Brick');#8=IFCMATERIAL('Wool');
             #20=IFCRELDEFINESBYTYPE('b',$,$,$,(#11),#21);#21=IFCWALLTYPE('c',$,$,$,$,$,$,$,$,.STANDARD.);
             #22=IFCRELASSOCIATESMATERIAL('d',$,$,$,(#21),#23);#23=IFCMATERIALCONSTITUENTSET($,$,(#24));
             #24=IFCMATERIALCONSTITUENT($,$,#7,$,$);",
        );
        with_file(&text, |file| {
            let relations = Relations::read(file, &mut Report::default());
            let mut materials = Materials::new(file);
            assert_eq!(materials.of(10, &relations), ["Brick", "Wool"]);
            assert_eq!(materials.of(11, &relations), ["Brick"]);
            assert!(materials.of(12, &relations).is_empty());
        });
    }
}
