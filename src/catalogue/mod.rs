//! Which satellites: element sets from every syntax in use, their history, synthetic shells, and which kind each is.

mod element_set;

pub use element_set::{ElementSet, NoradId, Origin};
