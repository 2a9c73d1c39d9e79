//! Robots and the server of their site, besides the store.
