//! A check as one page in HTML that needs no other file: verdict, maps with numbered marks, issues with advice.

use crate::document::{Issue, ModelCheck};
use crate::picture::{StoreyPicture, legend, storey_title};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use messages::Site;
use std::fmt::Write;

/// Elements of an issue that the page names.
const MAX_NAMED: usize = 40;
/// Marks of an issue on a map.
const MAX_MARKS: usize = 60;

const STYLE: &str = "\
:root{color-scheme:light}\
body{font:15px/1.45 system-ui,sans-serif;margin:0 auto;max-width:60rem;padding:1.2rem;color:#20242a;background:#fff}\
h1{font-size:1.5rem;margin:0 0 .3rem}h2{font-size:1.15rem;margin:1.6rem 0 .4rem}h3{font-size:1rem;margin:0}\
.verdict{padding:.7rem .9rem;border-radius:.4rem;background:#e3f4e6;border-left:.4rem solid #3c9d55}\
.verdict.no{background:#fde9e7;border-color:#d72d2d}\
.about{color:#59616b;margin:.3rem 0}.issue{border:1px solid #d6dade;border-radius:.4rem;padding:.6rem .8rem;margin:.6rem 0}\
.n{display:inline-block;min-width:1.5rem;text-align:center;border-radius:1rem;background:#e10050;color:#fff;font-weight:600;margin-right:.4rem}\
.data .n{background:#7a6a00}.building .n{background:#59616b}.code{color:#59616b;font:12px ui-monospace,monospace;float:right}\
p{margin:.35rem 0}.advice{background:#f2f5f8;padding:.3rem .5rem;border-radius:.3rem}\
table{border-collapse:collapse;width:100%;font-size:13px;margin:.3rem 0}\
td{border-top:1px solid #e4e7ea;padding:.2rem .5rem .2rem 0;vertical-align:top}\
td.id{font:12px ui-monospace,monospace;color:#59616b}\
figure{margin:.6rem 0}svg{width:100%;height:auto;border:1px solid #d6dade;image-rendering:pixelated}figcaption{font-weight:600;margin-bottom:.2rem}\
.legend span{display:inline-block;margin-right:1rem;font-size:13px}\
.legend i{display:inline-block;width:.9rem;height:.9rem;border:1px solid #aab;vertical-align:-2px;margin-right:.3rem}\
a{color:inherit}@media print{.issue,figure{break-inside:avoid}}";

/// The page.
pub fn page(check: &ModelCheck, pictures: &[StoreyPicture], site: &Site<'_>) -> String {
    let mut out = String::new();
    let models = check.circumstances.models.join(", ");
    let (class, verdict) = if check.fit { ("verdict", check.verdict()) } else { ("verdict no", check.verdict()) };
    // Writing to a string does not fail.
    let _ = write!(
        out,
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\">\
         <title>{0}: model check</title><style>{STYLE}</style></head><body>\n<h1>{0}</h1>\n<p class=\"{class}\">{1}</p>\n\
         <p class=\"about\">{2}<br>{3}</p>\n",
        escaped(&models),
        escaped(&verdict),
        escaped(&check.figures_line()),
        escaped(&check.circumstances.to_string()),
    );
    let numbered = numbered(check);
    maps(&mut out, &numbered, pictures, site);
    let headings = [
        ("maps", "Wrong on maps"),
        ("data", "Wrong or missing in the data, maps are right"),
        ("building", "No fault of the model: what this robot cannot pass"),
    ];
    for (kind, heading) in headings {
        let own: Vec<_> = numbered.iter().filter(|(_, issue)| issue.kind == kind).collect();
        if own.is_empty() {
            continue;
        }
        let _ = writeln!(out, "<h2>{heading}</h2>");
        for (number, issue) in own {
            write_issue(&mut out, *number, issue);
        }
    }
    let _ = writeln!(out, "<h2>What was checked</h2>\n<p>{}.</p>", escaped(&check.checked.join("; ")));
    for not in &check.not_checked {
        let _ = writeln!(out, "<p>Not checked: {}: {}.</p>", escaped(not.what), escaped(not.why));
    }
    out.push_str("</body></html>\n");
    out
}

/// All issues with their numbers on the page.
fn numbered(check: &ModelCheck) -> Vec<(usize, &Issue)> {
    (1..).zip(check.issues.iter().chain(&check.building)).collect()
}

fn maps(out: &mut String, issues: &[(usize, &Issue)], pictures: &[StoreyPicture], site: &Site<'_>) {
    if pictures.is_empty() {
        return;
    }
    let _ = writeln!(out, "<h2>Maps</h2>\n<p class=\"legend\">");
    for (colour, what) in legend() {
        let _ = write!(out, "<span><i style=\"background:{colour}\"></i>{what}</span>");
    }
    let _ = writeln!(out, "</p>");
    for picture in pictures {
        let [width, height] = picture.size();
        let title = escaped(&storey_title(site, picture.map_storey));
        let data = STANDARD.encode(picture.png());
        let _ = writeln!(
            out,
            "<figure><figcaption>{title}</figcaption><svg viewBox=\"0 0 {width} {height}\"><image width=\"{width}\" height=\"{height}\" \
             href=\"data:image/png;base64,{data}\"/>"
        );
        // Marks are as large on small maps as on large ones.
        let unit = f64::from(width.max(1)) / 100.0;
        for (number, issue) in issues {
            let places = issue.elements.iter().filter_map(|element| element.place.as_ref());
            let own = places.filter(|place| place.storey == Some(picture.map_storey) && is_small(issue));
            for place in own.take(MAX_MARKS) {
                let [x, y] = picture.pixel_of(place.middle_m());
                let colour = match issue.kind {
                    "maps" => "#e10050",
                    "data" => "#7a6a00",
                    _ => "#59616b",
                };
                let _ = writeln!(
                    out,
                    "<a href=\"#i{number}\"><circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{:.2}\" fill=\"{colour}\" fill-opacity=\".85\"/>\
                     <text x=\"{x:.1}\" y=\"{:.1}\" font-size=\"{:.2}\" font-family=\"sans-serif\" font-weight=\"700\" fill=\"#fff\" \
                     text-anchor=\"middle\">{number}</text></a>",
                    1.1 * unit,
                    y + 0.5 * unit,
                    1.4 * unit
                );
            }
        }
        let _ = writeln!(out, "</svg></figure>");
    }
}

/// False for issues about whole storeys, which a mark in their middle would not show.
fn is_small(issue: &Issue) -> bool {
    issue.elements.iter().all(|element| element.ifc_type != "IfcBuildingStorey") || issue.code == "floor_without_room"
}

fn write_issue(out: &mut String, number: usize, issue: &Issue) {
    let _ = writeln!(
        out,
        "<div class=\"issue {}\" id=\"i{number}\"><span class=\"code\">{}</span><h3><span class=\"n\">{number}</span>{}</h3>\n<p>{}</p>",
        issue.kind,
        issue.code,
        escaped(&issue.title),
        escaped(issue.cause)
    );
    let rooms: Vec<String> =
        issue.effect.rooms.iter().filter(|room| room.unreachable).map(|room| escaped(room.label())).collect();
    if !rooms.is_empty() {
        let _ = writeln!(out, "<p>Unreachable: {}</p>", rooms.join(", "));
    }
    let _ = writeln!(out, "<p class=\"advice\">{}</p>\n<table>", escaped(issue.advice));
    for element in issue.elements.iter().take(MAX_NAMED) {
        let _ = writeln!(
            out,
            "<tr><td>{}</td><td>{}</td><td class=\"id\">{}</td><td>{}</td><td>{}</td></tr>",
            escaped(&element.ifc_type),
            escaped(element.name.as_deref().unwrap_or_default()),
            escaped(&element.global_id),
            escaped(element.storey.as_deref().unwrap_or_default()),
            escaped(&element.text)
        );
    }
    if issue.n > MAX_NAMED {
        let _ = writeln!(out, "<tr><td colspan=\"5\">and {} more</td></tr>", issue.n - MAX_NAMED);
    }
    let _ = writeln!(out, "</table></div>");
}

/// A text as HTML writes it.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_models_are_text_and_no_markup() {
        assert_eq!(escaped("<script>\"&\"</script>"), "&lt;script&gt;&quot;&amp;&quot;&lt;/script&gt;");
    }
}
