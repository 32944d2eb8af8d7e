//! A path drawn: `path` (where a light is and how bright) on `spline`s; `chords` (stretches that are parabolas), `runs` (which pixel belongs to which),
//! `strokes` (the vector loops) over `blocks` of pixels, `straight` (that for straight chords), `ends` (by tables of half lines; far from them by the cubics of `wings`), `panels` (jumps, tight curves and the middle of ends, summed over points); `draw` (all together).

mod blocks;
mod chords;
mod draw;
mod ends;
mod panels;
mod path;
mod runs;
mod spline;
mod straight;
mod strokes;
mod wings;

pub use draw::{draw, draw_summed};
pub use path::{PathError, PathNode, StreakPath};
