//! Inputs of a service: newest samples of its topics, each validated once.

use crate::failure::Failure;
use bus::{RawSample, TopicName};

/// The topics that a service follows, one variant for each; [`crate::inputs`] declares them.
pub trait Input: Sized + Send + 'static {
    /// The topics; an earlier one is given to the service first.
    const TOPICS: &'static [TopicName];

    /// Validates a sample of one of the topics.
    ///
    /// # Errors
    /// Bytes that are no whole archive of its topic.
    fn check(sample: RawSample) -> Result<Self, Failure>;
}

/// The inputs of a service that follows no topic.
#[derive(Debug)]
pub enum NoInput {}

impl Input for NoInput {
    const TOPICS: &'static [TopicName] = &[];

    fn check(sample: RawSample) -> Result<Self, Failure> {
        Err(not_an_input(&sample))
    }
}

/// The refusal of a sample of another topic.
#[doc(hidden)]
pub fn not_an_input(sample: &RawSample) -> Failure {
    format!("`{}` is no input of this service", sample.topic()).into()
}

/// Declares the inputs of a service: an enumeration with a checked sample of a topic in each variant.
///
/// ```
/// daemon::inputs! {
///     /// What grids are made from.
///     pub enum RasterizeInput { Site, ScheduleState }
/// }
/// ```
#[macro_export]
macro_rules! inputs {
    ($(#[$doc:meta])* $visible:vis enum $name:ident { $($topic:ident),+ $(,)? }) => {
        $(#[$doc])*
        #[derive(Debug)]
        $visible enum $name {
            $(
                #[doc = concat!("A sample of [`bus::topics::", stringify!($topic), "`].")]
                $topic(bus::CheckedSample<bus::topics::$topic>),
            )+
        }

        impl $crate::Input for $name {
            const TOPICS: &'static [bus::TopicName] = &[$(bus::TopicName::$topic),+];

            fn check(sample: bus::RawSample) -> Result<Self, $crate::Failure> {
                match sample.topic() {
                    $(bus::TopicName::$topic => match sample.of(bus::topics::$topic) {
                        Some(sample) => Ok(Self::$topic(sample.check()?)),
                        None => unreachable!("the name is that of the topic"),
                    },)+
                    _ => Err($crate::not_an_input(&sample)),
                }
            }
        }
    };
}
