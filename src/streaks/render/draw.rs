//! A path drawn: its light in the pixels of a frame.

use std::ops::Range;

use crate::images::{Patch, PatchRows, PixelPosition};
use crate::streaks::{Lattice, ProfileTables, RadialProfile};

use super::chords::{Chord, Cutter, Stretch};
use super::ends::End;
use super::panels::PanelTree;
use super::path::StreakPath;
use super::runs::{Run, Source, around, beside, beyond};
use super::strokes::{Across, Strokes, draw as draw_strokes};

/// Curvature times the profile's radius above which light is summed; what first order leaves out is 10⁻⁵ below it.
const GREATEST_CURVATURE: f64 = 0.01;
/// The same for the variance times λ''/2λ.
const GREATEST_BEND: f64 = 0.003;
/// And for its change at a node; half of it is seen at the node itself.
const GREATEST_BEND_CHANGE: f64 = 1e-5;
/// And for that of λ'''/6λ times the radius cubed, of which a pixel sees a part.
const GREATEST_THIRD_CHANGE: f64 = 1e-4;
/// Curvature times the profile's reach above which normals come too near to one another for chords.
const GREATEST_FAN: f64 = 0.25;
/// A path that turns by more may come back to its own pixels, radians.
const GREATEST_TURNING_RAD: f64 = 1.2;

/// The light of a path in a frame of `rows` by `columns`, in the unit of the path's rates times seconds.
///
/// Each pixel has the profile's average over its square, integrated along the path. The sum over the frame is the light of that part of
/// the path whose profile lies on the frame to 10⁻⁴, a pixel's value is good to 10⁻⁴ of the peak, ends and jumps of brightness included.
/// Where the path and its brightness are smooth, a pixel's light is that at its foot times the profile's integral along a line, with first-order
/// corrections for curvature and second-order ones for brightness; elsewhere it is summed over points of the path. Both go over into one
/// another without a seam: whatever is within the profile's reach of a jump or a tight curve is summed. So are ends, but that the wings about those
/// that are straight and even come from a table of half lines.
///
/// The profile is the same along the whole path: take that of the middle of what is on the frame. Where the range changes by 1 % on the frame, the
/// ring's edges are 0.5 % of its radius off at both sides of it.
pub fn draw(path: &StreakPath, profile: &RadialProfile, rows: usize, columns: usize) -> Patch {
    on_parts(path, profile, rows, columns, |path, tables, rows, columns| {
        let cutter = Cutter::new(path, tables, rows, columns);
        match cutter.chords().and_then(|chords| prepared(&cutter, chords, tables)) {
            Some((chords, ends)) => draw_along(&cutter, &chords, &ends, tables, rows, columns),
            None => draw_summed_by(&cutter, tables, rows, columns),
        }
    })
}

/// The same by sums over points of the path throughout: slow, and what [`draw`] is held against.
pub fn draw_summed(path: &StreakPath, profile: &RadialProfile, rows: usize, columns: usize) -> Patch {
    on_parts(path, profile, rows, columns, |path, tables, rows, columns| {
        let cutter = Cutter::new(path, tables, rows, columns);
        draw_summed_by(&cutter, tables, rows, columns)
    })
}

/// Draws on the parts into which the profile cuts pixels, and sums these.
fn on_parts(
    path: &StreakPath,
    profile: &RadialProfile,
    rows: usize,
    columns: usize,
    draw: impl FnOnce(&StreakPath, &ProfileTables, usize, usize) -> Patch,
) -> Patch {
    let parts = profile.parts();
    if parts.is_whole() {
        return draw(path, profile.tables(), rows, columns);
    }
    let patch = draw(&path.in_parts(parts), profile.tables(), rows * parts.y, columns * parts.x);
    patch.summed(parts.x, parts.y)
}

/// Chords with a mark whether their pixels are summed, cut where that changes, and ends for which tables do; none where chords will not do.
type Prepared = Option<(Vec<(Chord, bool)>, Vec<End>)>;

fn prepared(cutter: &Cutter<'_>, chords: Vec<Chord>, profile: &ProfileTables) -> Prepared {
    let reach = profile.pixel_reach_pix();
    let radius = 0.5 * profile.fwhm_pix() + profile.variance_pix2().sqrt().min(profile.half_light_pix());
    let turning: f64 = chords.iter().map(Chord::turning_rad).sum();
    let is_fanned = |chord: &Chord| chord.curvature().abs() * reach > GREATEST_FAN;
    if turning > GREATEST_TURNING_RAD || chords.iter().any(is_fanned) {
        return None;
    }
    let is_hard = |chord: &Chord| {
        let bend = chord.bend().abs() * profile.variance_pix2();
        chord.is_rough || chord.curvature().abs() * radius > GREATEST_CURVATURE || bend > GREATEST_BEND
    };
    // Ways along the path near which light is summed.
    let mut hard: Vec<[f64; 2]> = chords.iter().filter(|chord| is_hard(chord)).map(|chord| chord.way_pix).collect();
    // Where splines meet, brightness may begin to bend otherwise from one pixel to the next.
    for pair in chords.windows(2) {
        let [before, after] = [&cutter.pieces[pair[0].stretch.piece], &cutter.pieces[pair[1].stretch.piece]];
        if pair[0].stretch.piece != pair[1].stretch.piece {
            let change = 0.5 * (after.bend(0.0) - before.bend(before.duration_s)).abs() * profile.variance_pix2();
            let third = (after.third(0.0) - before.third(before.duration_s)).abs() / 6.0 * radius.powi(3);
            if change > GREATEST_BEND_CHANGE || third > GREATEST_THIRD_CHANGE {
                hard.push([pair[0].way_pix[1]; 2]);
            }
        }
    }
    for chord in &chords {
        let piece = &cutter.pieces[chord.stretch.piece];
        if chord.stretch.to_s == piece.duration_s && piece.ends_in_jump {
            hard.push([chord.way_pix[1]; 2]);
        }
    }
    let ends = ends(cutter, &chords, profile, &mut hard);
    let mut open: Vec<Chord> = chords.into_iter().rev().collect();
    let mut done = Vec::with_capacity(open.len());
    while let Some(chord) = open.pop() {
        let [from, to] = chord.way_pix;
        let near = |margin: f64| hard.iter().any(|[start, end]| from < end + margin && to > start - margin);
        let is_within = || hard.iter().any(|[start, end]| from >= start - reach && to <= end + reach);
        if !near(reach) {
            done.push((chord, false));
        } else if is_within() || to - from < (0.25 * reach).max(4.0) {
            done.push((chord, true));
        } else {
            let [first, second] = cutter.halve(&chord)?;
            open.push(second);
            open.push(first);
        }
    }
    Some((done, ends))
}

/// Ends of the path near the frame for which tables do; the others join what is hard.
fn ends(cutter: &Cutter<'_>, chords: &[Chord], profile: &ProfileTables, hard: &mut Vec<[f64; 2]>) -> Vec<End> {
    let mut found = Vec::new();
    for (number, chord) in chords.iter().enumerate() {
        for is_start in [true, false] {
            if !cutter.is_end(chord, is_start) {
                continue;
            }
            match End::of(chords, number, is_start, profile).filter(|end| end.is_clear_of(hard, profile)) {
                Some(end) => found.push(end),
                None => hard.push([chord.way_pix[usize::from(!is_start)]; 2]),
            }
        }
    }
    // One that is summed may be too near to another that came before it.
    let (clear, near) = found.into_iter().partition(|end| end.is_clear_of(hard, profile));
    hard.extend(Vec::into_iter(near).map(|end: End| [end.way_pix; 2]));
    clear
}

fn draw_along(
    cutter: &Cutter<'_>,
    marked: &[(Chord, bool)],
    ends: &[End],
    profile: &ProfileTables,
    rows: usize,
    columns: usize,
) -> Patch {
    let reach = profile.pixel_reach_pix();
    let mut extents = PatchRows::new(rows, columns);
    let mut runs: Vec<Run> = Vec::with_capacity(rows);
    for (number, (chord, is_summed)) in marked.iter().enumerate() {
        let source = if *is_summed { Source::Summed(number) } else { Source::Smooth(number) };
        beside(chord, reach, source, &extents, &mut runs);
        for (is_start, border) in [(true, &chord.start), (false, &chord.end)] {
            if *is_summed && cutter.is_end(chord, is_start) {
                beyond(border, is_start, reach, source, &extents, &mut runs);
            }
        }
    }
    // After the smooth light, which they correct, and each middle after all edges.
    for (number, end) in ends.iter().enumerate() {
        around(end, number, reach, &extents, &mut runs);
    }
    runs.sort_by_key(|run| matches!(run.source, Source::Middle(_)));
    for run in &runs {
        extents.add(run.row, run.columns.clone());
    }
    let mut patch = extents.into_patch();
    let Trees { trees, of_chords, of_ends } = Trees::of(cutter, marked, ends, profile);
    let ends: Vec<(End, Range<usize>)> = ends.iter().copied().zip(of_ends).collect();
    let (tables, table_of) = tables(marked, &pixels_of(marked, &runs), profile);
    let chords: Vec<Chord> = marked.iter().map(|(chord, _)| *chord).collect();
    draw_strokes(Strokes {
        chords: &chords,
        tables: &tables,
        table_of: &table_of,
        trees: &trees,
        trees_of: &of_chords,
        ends: &ends,
        profile,
        runs: &runs,
        patch: &mut patch,
    });
    patch
}

/// Panels of all chords within reach of what is summed, and which of them each chord and each end needs.
struct Trees {
    trees: Vec<PanelTree>,
    of_chords: Vec<Range<usize>>,
    of_ends: Vec<Range<usize>>,
}

impl Trees {
    fn of(cutter: &Cutter<'_>, marked: &[(Chord, bool)], ends: &[End], profile: &ProfileTables) -> Self {
        // A path that turns by at most 1.2 rad is at most 1.07 times as long as the distance between its ends.
        let reach = 1.1 * profile.pixel_reach_pix();
        let near = |[from, to]: [f64; 2], reach: f64| {
            let start = marked.partition_point(|(chord, _)| chord.way_pix[1] < from - reach);
            start..marked.partition_point(|(chord, _)| chord.way_pix[0] <= to + reach)
        };
        let of_chord = |(chord, is_summed): &(Chord, bool)| if *is_summed { near(chord.way_pix, reach) } else { 0..0 };
        let of_end = |end: &End| near([end.way_pix; 2], reach + 1.1 * end.from_pix);
        let mut is_wanted = vec![false; marked.len()];
        for range in marked.iter().map(of_chord).chain(ends.iter().map(of_end)) {
            is_wanted[range].fill(true);
        }
        // Neighbours of one piece become one tree: the longer the panels that distant pixels use, the fewer.
        let mut trees: Vec<(Stretch, [f64; 2])> = Vec::new();
        for ((chord, _), _) in marked.iter().zip(&is_wanted).filter(|(_, is_wanted)| **is_wanted) {
            match trees.last_mut() {
                Some((last, way)) if last.piece == chord.stretch.piece && last.to_s == chord.stretch.from_s => {
                    last.to_s = chord.stretch.to_s;
                    way[1] = chord.way_pix[1];
                }
                _ => trees.push((chord.stretch, chord.way_pix)),
            }
        }
        let trees_of = |chords: Range<usize>| {
            if chords.is_empty() {
                return 0..0;
            }
            let [from, to] = [marked[chords.start].0.way_pix[0], marked[chords.end - 1].0.way_pix[1]];
            let start = trees.partition_point(|(_, way)| way[1] <= from);
            start..trees.partition_point(|(_, way)| way[0] < to)
        };
        Self {
            of_chords: marked.iter().map(of_chord).map(&trees_of).collect(),
            of_ends: ends.iter().map(of_end).map(&trees_of).collect(),
            trees: trees.iter().map(|(stretch, _)| PanelTree::of(cutter, *stretch, profile)).collect(),
        }
    }
}

/// How many pixels each chord draws where its light is smooth.
fn pixels_of(marked: &[(Chord, bool)], runs: &[Run]) -> Vec<usize> {
    let mut pixels = vec![0; marked.len()];
    for run in runs {
        if let Source::Smooth(number) = run.source {
            pixels[number] += run.columns.len();
        }
    }
    pixels
}

/// Tables across the path for all chords that need one, with so many pixels each, and which of them each uses.
fn tables(marked: &[(Chord, bool)], pixels: &[usize], profile: &ProfileTables) -> (Vec<Across>, Vec<usize>) {
    let mut tables: Vec<Across> = Vec::new();
    let mut table_of = vec![0; marked.len()];
    let step_rad = profile.line_angle_step_rad();
    let mut last: Option<f64> = None;
    let (mut number, mut known_to) = (0, 0);
    while let Some((chord, is_summed)) = marked.get(number) {
        if *is_summed {
            number += 1;
            continue;
        }
        if number >= known_to {
            let (count, lattice) = shared(&marked[number..], &pixels[number..], profile);
            known_to = number + count;
            if let Some(lattice) = lattice {
                tables.push(Across::Straight(lattice));
                table_of[number..known_to].fill(tables.len() - 1);
                last = None;
                number = known_to;
                continue;
            }
        }
        let angle = chord.angle_rad();
        let turns = chord.half_turn_rad() > step_rad;
        let is_known = last.is_some_and(|last| (angle - last).abs() <= step_rad);
        let is_turned = matches!(tables.last(), Some(Across::Curved { turned: Some(_), .. }));
        if !is_known || (turns && !is_turned) {
            let turned = turns.then(|| profile.line_turned_lanes(angle));
            tables.push(Across::Curved { line: profile.line_lanes(angle), turned });
            last = Some(angle);
        }
        table_of[number] = tables.len() - 1;
        number += 1;
    }
    (tables, table_of)
}

/// How many of the first chords may share a lattice: as far as none of their directions is farther than allowed from that half way between all. And the lattice; none
/// where it is not worth its making.
fn shared(marked: &[(Chord, bool)], pixels: &[usize], profile: &ProfileTables) -> (usize, Option<Lattice>) {
    let [mut least, mut greatest] = [f64::INFINITY, f64::NEG_INFINITY];
    let (mut count, mut angle_rad) = (0, 0.0);
    for (chord, is_summed) in marked {
        let (angle, half_turn) = (chord.angle_rad(), chord.half_turn_rad());
        (least, greatest) = (least.min(angle - half_turn), greatest.max(angle + half_turn));
        let middle = 0.5 * (least + greatest);
        if *is_summed || chord.is_bent(profile) || greatest - middle > profile.lattice_turn_rad(middle) {
            break;
        }
        (count, angle_rad) = (count + 1, middle);
    }
    (count, profile.line_lattice(angle_rad, pixels[..count].iter().sum()))
}

fn draw_summed_by(cutter: &Cutter<'_>, profile: &ProfileTables, rows: usize, columns: usize) -> Patch {
    let reach = profile.pixel_reach_pix();
    let mut extents = PatchRows::new(rows, columns);
    let stretches = cutter.stretches();
    let trees: Vec<PanelTree> = stretches.iter().map(|(stretch, _)| PanelTree::of(cutter, *stretch, profile)).collect();
    for ([x, y], radius) in trees.iter().flat_map(PanelTree::discs) {
        extents.add_disc(PixelPosition { x, y }, reach + radius);
    }
    let mut patch = extents.into_patch();
    let mut runs = Vec::new();
    patch.fill(|row, first, values| {
        runs.push(Run { row, columns: first..first + values.len(), source: Source::Summed(0) });
    });
    let all = 0..trees.len();
    draw_strokes(Strokes {
        chords: &[],
        tables: &[],
        table_of: &[],
        trees: &trees,
        trees_of: std::slice::from_ref(&all),
        ends: &[],
        profile,
        runs: &runs,
        patch: &mut patch,
    });
    patch
}
