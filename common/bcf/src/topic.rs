//! A topic: what BCF files hold, whatever their version.

/// Version of the format.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum BcfVersion {
    /// 2.1, which most tools read.
    #[default]
    V2_1,
    /// 3.0.
    V3_0,
}

impl BcfVersion {
    /// As files write it.
    pub fn text(self) -> &'static str {
        match self {
            Self::V2_1 => "2.1",
            Self::V3_0 => "3.0",
        }
    }

    /// The version that a text names.
    pub fn of(text: &str) -> Option<Self> {
        [Self::V2_1, Self::V3_0].into_iter().find(|version| version.text() == text)
    }
}

/// Something to talk about.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Topic {
    /// UUID, see [`crate::uuid`].
    pub guid: String,
    /// Kind, e.g. `Issue`.
    pub kind: String,
    /// Status, e.g. `Open` or `Closed`.
    pub status: String,
    /// One line.
    pub title: String,
    /// Sentences; empty for none.
    pub description: String,
    /// Words to filter by.
    pub labels: Vec<String>,
    /// Place in the order; none if topics have no order.
    pub index: Option<u32>,
    /// When it was made, as XML writes dates with a time.
    pub created: String,
    /// By whom.
    pub author: String,
    /// When and by whom it was changed last.
    pub modified: Option<[String; 2]>,
    /// Base names of the model files.
    pub files: Vec<String>,
    /// What was said.
    pub comments: Vec<Comment>,
    /// What to look at.
    pub viewpoints: Vec<Viewpoint>,
}

/// Something that was said about a topic.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Comment {
    /// UUID.
    pub guid: String,
    /// When, as XML writes dates with a time.
    pub date: String,
    /// By whom.
    pub author: String,
    /// What.
    pub text: String,
    /// UUID of the viewpoint that it is about, if it is about one.
    pub viewpoint: Option<String>,
}

/// What to look at, from where.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Viewpoint {
    /// UUID.
    pub guid: String,
    /// From where.
    pub camera: Option<Camera>,
    /// Selected elements.
    pub components: Vec<Component>,
    /// Lines from place to place, in metres of the IFC world.
    pub lines: Vec<[[f64; 3]; 2]>,
    /// A picture of it.
    pub snapshot: Option<Snapshot>,
}

/// A picture.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Snapshot {
    /// A PNG file.
    Png(Vec<u8>),
    /// A JPEG file.
    Jpeg(Vec<u8>),
}

/// An orthogonal camera, in metres of the IFC world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Where it is.
    pub position: [f64; 3],
    /// Where it looks.
    pub direction: [f64; 3],
    /// What is up in the picture.
    pub up: [f64; 3],
    /// Metres that the picture is high.
    pub height_m: f64,
    /// Width of the picture by its height.
    pub aspect_ratio: f64,
}

/// An element as BCF names it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Component {
    /// GlobalId; not written if it is none that IFC allows.
    pub global_id: String,
    /// The name that a program gives it, for programs that do not use GlobalIds; empty for none.
    pub authoring_tool_id: String,
}
