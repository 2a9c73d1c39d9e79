//! Progress of drawing, and whether to go on.

/// Takes what is done while maps are drawn for an answer.
pub trait DrawingProgress: Sync {
    /// A stage of unknown length.
    fn stage(&self, stage: &'static str);

    /// Steps of a stage; false to stop before the next one.
    fn step(&self, stage: &'static str, done: usize, total: usize) -> bool;
}

/// Takes nothing, and goes on.
#[derive(Debug, Clone, Copy)]
pub struct Silent;

impl DrawingProgress for Silent {
    fn stage(&self, _stage: &'static str) {}

    fn step(&self, _stage: &'static str, _done: usize, _total: usize) -> bool {
        true
    }
}
