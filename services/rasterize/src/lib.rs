//! Rasterisation as a process: what is drawn is in `drawing`, when and for whom is here.

pub mod service;
