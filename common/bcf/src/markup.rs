//! `markup.bcf` of a topic, and the files beside the topics.

use crate::topic::{BcfVersion, Comment, Snapshot, Topic, Viewpoint};
use crate::xml::{Xml, document, text};
use std::collections::BTreeSet;
use std::io::Result;

/// `bcf.version`.
pub(crate) fn version(version: BcfVersion) -> Result<Vec<u8>> {
    let mut xml = document()?;
    let root = xml.create_element("Version").with_attribute(("VersionId", version.text()));
    match version {
        BcfVersion::V2_1 => root.write_inner_content(|xml| text(xml, "DetailedVersion", "2.1"))?,
        BcfVersion::V3_0 => root.write_empty()?,
    };
    Ok(xml.into_inner())
}

/// `extensions.xml`, which version 3.0 requires: the words that topics use.
pub(crate) fn extensions(topics: &[Topic]) -> Result<Vec<u8>> {
    let words = |of: &dyn Fn(&Topic) -> Vec<String>| topics.iter().flat_map(of).collect::<BTreeSet<String>>();
    let mut statuses = words(&|topic| vec![topic.status.clone()]);
    statuses.extend(["Open", "Closed"].map(str::to_owned));
    let lists = [
        ("TopicTypes", "TopicType", words(&|topic| vec![topic.kind.clone()])),
        ("TopicStatuses", "TopicStatus", statuses),
        ("Priorities", "Priority", BTreeSet::new()),
        ("TopicLabels", "TopicLabel", words(&|topic| topic.labels.clone())),
        ("Users", "User", words(&|topic| vec![topic.author.clone()])),
        ("SnippetTypes", "SnippetType", BTreeSet::new()),
        ("Stages", "Stage", BTreeSet::new()),
    ];
    let mut xml = document()?;
    xml.create_element("Extensions").write_inner_content(|xml| {
        for (list, item, words) in &lists {
            xml.create_element(*list)
                .write_inner_content(|xml| words.iter().try_for_each(|word| text(xml, item, word)))?;
        }
        Ok(())
    })?;
    Ok(xml.into_inner())
}

/// Names of the files of a viewpoint in the folder of its topic: of the viewpoint, and of its picture.
pub(crate) fn file_names(at: usize, viewpoint: &Viewpoint) -> (String, Option<String>) {
    let number = if at == 0 { String::new() } else { format!("-{}", at + 1) };
    let picture = viewpoint.snapshot.as_ref().map(|snapshot| match snapshot {
        Snapshot::Png(_) => format!("snapshot{number}.png"),
        Snapshot::Jpeg(_) => format!("snapshot{number}.jpg"),
    });
    (format!("viewpoint{number}.bcfv"), picture)
}

/// `markup.bcf`.
pub(crate) fn markup(topic: &Topic, version: BcfVersion) -> Result<Vec<u8>> {
    let mut xml = document()?;
    xml.create_element("Markup").write_inner_content(|xml| {
        if !topic.files.is_empty() {
            header(xml, topic, version)?;
        }
        let head = xml.create_element("Topic").with_attributes([
            ("Guid", topic.guid.as_str()),
            ("TopicType", &topic.kind),
            ("TopicStatus", &topic.status),
        ]);
        head.write_inner_content(|xml| {
            of_topic(xml, topic, version)?;
            if version == BcfVersion::V3_0 {
                if !topic.comments.is_empty() {
                    let all = xml.create_element("Comments");
                    all.write_inner_content(|xml| topic.comments.iter().try_for_each(|c| comment(xml, c)))?;
                }
                if !topic.viewpoints.is_empty() {
                    xml.create_element("Viewpoints").write_inner_content(|xml| viewpoints(xml, topic, "ViewPoint"))?;
                }
            }
            Ok(())
        })?;
        if version == BcfVersion::V2_1 {
            topic.comments.iter().try_for_each(|c| comment(xml, c))?;
            viewpoints(xml, topic, "Viewpoints")?;
        }
        Ok(())
    })?;
    Ok(xml.into_inner())
}

fn header(xml: &mut Xml, topic: &Topic, version: BcfVersion) -> Result<()> {
    let is_external = match version {
        BcfVersion::V2_1 => "isExternal",
        BcfVersion::V3_0 => "IsExternal",
    };
    let files = |xml: &mut Xml| {
        topic.files.iter().try_for_each(|name| {
            let file = xml.create_element("File").with_attribute((is_external, "true"));
            file.write_inner_content(|xml| text(xml, "Filename", name)).map(|_| ())
        })
    };
    xml.create_element("Header").write_inner_content(|xml| match version {
        BcfVersion::V2_1 => files(xml),
        BcfVersion::V3_0 => xml.create_element("Files").write_inner_content(files).map(|_| ()),
    })?;
    Ok(())
}

fn of_topic(xml: &mut Xml, topic: &Topic, version: BcfVersion) -> Result<()> {
    text(xml, "Title", &topic.title)?;
    if let Some(index) = topic.index {
        text(xml, "Index", &index.to_string())?;
    }
    match version {
        BcfVersion::V2_1 => topic.labels.iter().try_for_each(|label| text(xml, "Labels", label))?,
        BcfVersion::V3_0 if topic.labels.is_empty() => {}
        BcfVersion::V3_0 => {
            let labels = xml.create_element("Labels");
            labels.write_inner_content(|xml| topic.labels.iter().try_for_each(|label| text(xml, "Label", label)))?;
        }
    }
    text(xml, "CreationDate", &topic.created)?;
    text(xml, "CreationAuthor", &topic.author)?;
    if let Some([date, author]) = &topic.modified {
        text(xml, "ModifiedDate", date)?;
        text(xml, "ModifiedAuthor", author)?;
    }
    if !topic.description.is_empty() {
        text(xml, "Description", &topic.description)?;
    }
    Ok(())
}

/// A comment, the same in both versions.
pub(crate) fn comment(xml: &mut Xml, comment: &Comment) -> Result<()> {
    xml.create_element("Comment").with_attribute(("Guid", comment.guid.as_str())).write_inner_content(|xml| {
        text(xml, "Date", &comment.date)?;
        text(xml, "Author", &comment.author)?;
        text(xml, "Comment", &comment.text)?;
        if let Some(viewpoint) = &comment.viewpoint {
            xml.create_element("Viewpoint").with_attribute(("Guid", viewpoint.as_str())).write_empty()?;
        }
        Ok(())
    })?;
    Ok(())
}

fn viewpoints(xml: &mut Xml, topic: &Topic, element: &str) -> Result<()> {
    for (at, viewpoint) in topic.viewpoints.iter().enumerate() {
        let (file, picture) = file_names(at, viewpoint);
        xml.create_element(element).with_attribute(("Guid", viewpoint.guid.as_str())).write_inner_content(|xml| {
            text(xml, "Viewpoint", &file)?;
            picture.iter().try_for_each(|picture| text(xml, "Snapshot", picture))
        })?;
    }
    Ok(())
}
