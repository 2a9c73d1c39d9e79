//! Containers: what is written is read again, in both versions; closing a topic changes nothing else; bad input is refused.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use bcf::{BcfError, BcfVersion, Camera, Comment, Component, Container, Snapshot, Topic, Viewpoint, uuid, written};
use std::io::{Cursor, Write};
use zip::write::SimpleFileOptions;

const VERSIONS: [BcfVersion; 2] = [BcfVersion::V2_1, BcfVersion::V3_0];

fn topic(name: &str) -> Topic {
    Topic {
        guid: uuid(&["topic", name]),
        kind: "Issue".to_owned(),
        status: "Open".to_owned(),
        title: format!("{name} <is> \"wrong\" & late"),
        description: "One line.\nAnd another: \u{e4}\u{4e2d}.".to_owned(),
        labels: vec!["late".to_owned(), "maps".to_owned()],
        index: Some(3),
        created: "2024-04-15T08:30:00".to_owned(),
        author: "groundplan".to_owned(),
        modified: None,
        files: vec!["a.ifc".to_owned(), "b.ifc".to_owned()],
        comments: vec![comment("first")],
        viewpoints: vec![viewpoint(name), Viewpoint { guid: uuid(&["second", name]), ..Viewpoint::default() }],
    }
}

fn viewpoint(name: &str) -> Viewpoint {
    let camera = Camera {
        position: [1.5, -2.25, 20.0],
        direction: [0.0, 0.0, -1.0],
        up: [0.6, 0.8, 0.0],
        height_m: 6.5,
        aspect_ratio: 1.0,
    };
    Viewpoint {
        guid: uuid(&["viewpoint", name]),
        camera: Some(camera),
        components: vec![
            Component { global_id: "2nJpOmW6eM0ctxYO6wzQ8k".to_owned(), authoring_tool_id: String::new() },
            Component { global_id: String::new(), authoring_tool_id: "#17".to_owned() },
        ],
        lines: vec![[[0.0, 0.0, 1.0], [2.0, 0.5, 1.0]]],
        snapshot: Some(Snapshot::Png(vec![137, 80, 78, 71])),
    }
}

fn comment(text: &str) -> Comment {
    Comment {
        guid: uuid(&["comment", text]),
        date: "2024-05-01T10:00:00".to_owned(),
        author: "robot".to_owned(),
        text: format!("{text} & more"),
        viewpoint: None,
    }
}

#[test]
fn what_is_written_is_read_again_in_both_versions() {
    for version in VERSIONS {
        let mut topics =
            vec![topic("a"), topic("b"), Topic { comments: Vec::new(), viewpoints: Vec::new(), ..topic("c") }];
        let bytes = written(&topics, version);
        assert_eq!(bytes, written(&topics, version), "the same topics give the same bytes");
        let container = Container::read(&bytes).unwrap();
        assert_eq!(container.version(), version);
        topics.sort_by(|a, b| a.guid.cmp(&b.guid));
        assert_eq!(container.topics(), topics);
    }
}

/// The files of a container, by path.
fn files(bytes: &[u8]) -> Vec<(String, Vec<u8>)> {
    let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).unwrap();
    let mut all = Vec::new();
    for k in 0..archive.len() {
        let mut file = archive.by_index(k).unwrap();
        let mut bytes = Vec::new();
        std::io::copy(&mut file, &mut bytes).unwrap();
        all.push((file.name().unwrap().into_owned(), bytes));
    }
    all.sort();
    all
}

fn zipped(files: &[(String, Vec<u8>)]) -> Vec<u8> {
    let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for (path, bytes) in files {
        zip.start_file(path.as_str(), SimpleFileOptions::default()).unwrap();
        zip.write_all(bytes).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

#[test]
fn a_topic_is_closed_with_a_comment_and_nothing_else_changes() {
    for version in VERSIONS {
        let bare = Topic { comments: Vec::new(), viewpoints: Vec::new(), description: String::new(), ..topic("bare") };
        for own in [
            topic("a"),
            bare,
            Topic { comments: Vec::new(), ..topic("c") },
            Topic { viewpoints: Vec::new(), ..topic("d") },
        ] {
            let mut others = files(&written(&[own.clone(), topic("other")], version));
            others.push(("a note.txt".to_owned(), b"of somebody else".to_vec()));
            let mut container = Container::read(&zipped(&others)).unwrap();
            container.set_status(&own.guid, "Closed", &comment("seen in place")).unwrap();
            let again = Container::read(&container.bytes()).unwrap();
            let mut expected = Topic { status: "Closed".to_owned(), ..own.clone() };
            expected.modified = Some(["2024-05-01T10:00:00".to_owned(), "robot".to_owned()]);
            expected.comments.push(comment("seen in place"));
            let found = again.topics().iter().find(|topic| topic.guid == own.guid).unwrap();
            assert_eq!(found, &expected, "{version:?}");
            let unchanged = |all: &[(String, Vec<u8>)]| {
                let markup = format!("{}/markup.bcf", own.guid);
                all.iter().filter(|(path, _)| *path != markup).cloned().collect::<Vec<_>>()
            };
            others.sort();
            assert_eq!(unchanged(&files(&container.bytes())), unchanged(&others));
            // A second closing replaces the time of the last change, and keeps both comments.
            container.set_status(&own.guid, "Open", &comment("gone again")).unwrap();
            let found = container.topics().iter().find(|topic| topic.guid == own.guid).unwrap();
            assert_eq!((found.status.as_str(), found.comments.len()), ("Open", expected.comments.len() + 1));
        }
    }
}

#[test]
fn what_no_version_has_survives_closing() {
    let guid = uuid(&["x"]);
    let markup = format!(
        "<?xml version=\"1.0\"?><Markup><Header><File IfcProject=\"0YvctVUKr0kugbFTf53O9L\"><Filename>a.ifc</Filename></File></Header>\
         <Topic Guid=\"{guid}\" TopicType=\"Clash\" TopicStatus=\"Active\"><ReferenceLink>http://x/?a=1&amp;b=2</ReferenceLink>\
         <Title>T</Title><Priority>High</Priority><CreationDate>2020-01-01T00:00:00</CreationDate><CreationAuthor>A</CreationAuthor>\
         <DueDate>2021-01-01T00:00:00</DueDate><AssignedTo>B</AssignedTo><BimSnippet SnippetType=\"x\"><Reference>s</Reference>\
         <ReferenceSchema>r</ReferenceSchema></BimSnippet><RelatedTopic Guid=\"{guid}\"/></Topic><!-- a note --><Viewpoints \
         Guid=\"{guid}\"><Viewpoint>v.bcfv</Viewpoint></Viewpoints></Markup>"
    );
    let version = (String::from("bcf.version"), b"<Version VersionId=\"2.1\"/>".to_vec());
    let mut container =
        Container::read(&zipped(&[version, (format!("{guid}/markup.bcf"), markup.clone().into_bytes())])).unwrap();
    container.set_status(&guid, "Closed", &comment("c")).unwrap();
    let all = files(&container.bytes());
    let (_, after) = all.iter().find(|(path, _)| path.ends_with("markup.bcf")).unwrap();
    let expected = markup
        .replace("TopicStatus=\"Active\"", "TopicStatus=\"Closed\"")
        .replace(
            "<DueDate>",
            "<ModifiedDate>2024-05-01T10:00:00</ModifiedDate><ModifiedAuthor>robot</ModifiedAuthor><DueDate>",
        )
        .replace(
            "<Viewpoints ",
            &format!(
                "<Comment Guid=\"{}\"><Date>2024-05-01T10:00:00</Date><Author>robot</Author><Comment>c &amp; more</Comment></Comment><Viewpoints ",
                uuid(&["comment", "c"])
            ),
        );
    assert_eq!(String::from_utf8(after.clone()).unwrap(), expected);
}

#[test]
fn bad_containers_are_refused_with_the_file_that_is_bad() {
    let refused = |files: &[(&str, &str)]| {
        let files: Vec<_> = files.iter().map(|(path, text)| ((*path).to_owned(), text.as_bytes().to_vec())).collect();
        Container::read(&zipped(&files)).unwrap_err().to_string()
    };
    assert!(matches!(Container::read(b"PK no archive"), Err(BcfError::Archive(_))));
    assert_eq!(
        refused(&[("bcf.version", "<Version VersionId=\"9.9\"/>")]),
        "its version is \"9.9\": 2.1 and 3.0 are read"
    );
    assert_eq!(refused(&[("x.txt", "")]), "its version is \"\": 2.1 and 3.0 are read");
    let version = ("bcf.version", "<Version VersionId=\"2.1\"/>");
    let cut = refused(&[version, ("a/markup.bcf", "<Markup><Topic Guid=\"g\">")]);
    assert!(cut.starts_with("a/markup.bcf in it cannot be read: "), "{cut}");
    let empty = refused(&[version, ("a/markup.bcf", "<Markup/>")]);
    assert_eq!(empty, "a/markup.bcf in it cannot be read: it has no Topic with a Guid");
    let entity = "<!DOCTYPE m [<!ENTITY a \"b\">]><Markup><Topic Guid=\"g\"><Title>&a;</Title></Topic></Markup>";
    assert!(refused(&[version, ("a/markup.bcf", entity)]).contains("the entity &a; is not known"));
    let deep = "<a>".repeat(100);
    assert!(refused(&[version, ("a/markup.bcf", &deep)]).contains("more than 64 elements lie in each other"));
    let container = Container::read(&written(&[], BcfVersion::V2_1));
    assert!(matches!(container.unwrap().set_status("x", "Closed", &comment("c")), Err(BcfError::NoTopic(_))));
}

#[test]
fn a_file_that_unpacks_to_too_much_is_refused_before_it_fills_the_memory() {
    let zeros = vec![0_u8; (64 << 20) + 1];
    let packed = zipped(&[("bcf.version".to_owned(), zeros)]);
    assert!(packed.len() < 1 << 20);
    assert!(matches!(Container::read(&packed), Err(BcfError::TooLarge { what: "bytes in a file", .. })));
}
