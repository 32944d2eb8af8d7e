//! Light on a part of a frame, stored only for the pixels on which it falls.

use std::ops::Range;

use super::light_area::LightArea;
use super::pixels::PixelPosition;
use super::pixels::Plane;

/// Adjacent pixels in one row of a patch.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct PatchSpan<'a> {
    /// Row of the frame, counted from 0.
    pub row: usize,
    /// Column of the first pixel, counted from 0.
    pub first_column: usize,
    /// Values of the first pixel and of those to its right.
    pub values: &'a [f32],
}

/// Light on a part of a frame of `rows` by `columns` pixels: one range of columns in each row, all within the frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Patch {
    rows: usize,
    columns: usize,
    first_row: usize,
    /// Columns of each row, beginning with `first_row`, and the index of the row's first value.
    spans: Vec<(Range<usize>, usize)>,
    values: Vec<f32>,
}

impl Patch {
    /// Returns the number of rows of the frame.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Returns the number of columns of the frame.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Returns true if the patch has no pixels.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// Returns the number of pixels.
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// Returns the sum of all light in the patch.
    pub fn sum(&self) -> f64 {
        // Eight independent sums are faster, because each addition to a single sum would have to wait for the previous
        // one.
        let (blocks, rest) = self.values.as_chunks::<8>();
        let mut sums = [0.0; 8];
        for block in blocks {
            for (sum, value) in sums.iter_mut().zip(block) {
                *sum += f64::from(*value);
            }
        }
        sums.iter().sum::<f64>() + rest.iter().map(|value| f64::from(*value)).sum::<f64>()
    }

    /// Returns the mean position weighted by the light, pixels; `None` if the light is 0.
    pub fn centroid(&self) -> Option<PixelPosition> {
        let mut sums = [0.0; 3];
        for span in self.iter() {
            for (column, value) in (span.first_column..).zip(span.values) {
                let light = f64::from(*value);
                sums = [sums[0] + light, sums[1] + light * column as f64, sums[2] + light * span.row as f64];
            }
        }
        (sums[0] != 0.0).then(|| PixelPosition { x: sums[1] / sums[0], y: sums[2] / sums[0] })
    }

    /// Returns the rows that have pixels, in order.
    #[doc(hidden)]
    pub fn iter(&self) -> impl Iterator<Item = PatchSpan<'_>> {
        self.spans.iter().enumerate().filter(|(_, (columns, _))| !columns.is_empty()).map(|(number, (columns, at))| {
            PatchSpan {
                row: self.first_row + number,
                first_column: columns.start,
                values: &self.values[*at..*at + columns.len()],
            }
        })
    }

    /// Returns the pixels of one row; empty if the patch has none in this row.
    #[doc(hidden)]
    pub fn row(&self, row: usize) -> PatchSpan<'_> {
        let span = row.checked_sub(self.first_row).and_then(|number| self.spans.get(number));
        match span {
            Some((columns, at)) => {
                PatchSpan { row, first_column: columns.start, values: &self.values[*at..*at + columns.len()] }
            }
            None => PatchSpan { row, first_column: 0, values: &[] },
        }
    }

    /// Returns the value of one pixel; 0 outside the patch.
    pub fn at(&self, row: usize, column: usize) -> f32 {
        let span = self.row(row);
        column.checked_sub(span.first_column).and_then(|index| span.values.get(index)).copied().unwrap_or(0.0)
    }

    /// Sets the values row by row by a function of `(row, first_column, values)`.
    pub fn fill(&mut self, mut set: impl FnMut(usize, usize, &mut [f32])) {
        for (number, (columns, at)) in self.spans.iter().enumerate() {
            set(self.first_row + number, columns.start, &mut self.values[*at..*at + columns.len()]);
        }
    }

    /// Returns the pixels of one row in the range `columns`; empty if not all of them are in the patch.
    pub fn span_mut(&mut self, row: usize, columns: Range<usize>) -> &mut [f32] {
        let span = row.checked_sub(self.first_row).and_then(|number| self.spans.get(number));
        let range = span.and_then(|(own, at)| {
            let is_inside = own.start <= columns.start && columns.start <= columns.end && columns.end <= own.end;
            is_inside.then(|| at + columns.start - own.start..at + columns.end - own.start)
        });
        range.and_then(|range| self.values.get_mut(range)).unwrap_or(&mut [])
    }

    /// Multiplies all values by a factor.
    pub fn scale(&mut self, factor: f32) {
        self.values.iter_mut().for_each(|value| *value *= factor);
    }

    /// Adds the light to a plane; pixels outside the plane are omitted.
    pub fn add_to(&self, plane: &mut Plane) {
        for (row, (columns, at)) in (self.first_row..).zip(&self.spans) {
            // The compiler can vectorise loops over slices.
            let values = &self.values[*at..*at + columns.len()];
            let Some(pixels) = plane.row_mut(row).get_mut(columns.start..) else { continue };
            for (pixel, value) in pixels.iter_mut().zip(values) {
                *pixel += value;
            }
        }
    }

    /// Returns a patch in which blocks of `x` columns by `y` rows are summed. The size of the frame must be a multiple
    /// of both.
    pub fn summed(&self, x: usize, y: usize) -> Self {
        let mut extents = PatchRows::new(self.rows / y, self.columns / x);
        for span in self.iter() {
            let end = span.first_column + span.values.len();
            extents.add(span.row / y, span.first_column / x..end.div_ceil(x));
        }
        let mut summed = extents.into_patch();
        for span in self.iter() {
            let first = span.first_column / x;
            let end = (span.first_column + span.values.len()).div_ceil(x);
            let out = summed.span_mut(span.row / y, first..end);
            for (offset, value) in (span.first_column - first * x..).zip(span.values) {
                out[offset / x] += value;
            }
        }
        summed
    }

    /// Returns the part of the patch that lies in an area of the frame.
    pub fn within(self, area: &LightArea) -> Self {
        if *area == LightArea::whole(self.rows, self.columns) {
            return self;
        }
        let mut extents = PatchRows::new(self.rows, self.columns);
        let cut = |span: &PatchSpan<'_>| {
            let end = span.first_column + span.values.len();
            span.first_column.max(area.columns.start)..end.min(area.columns.end)
        };
        let rows = || self.iter().filter(|span| area.rows.contains(&span.row));
        rows().for_each(|span| extents.add(span.row, cut(&span)));
        let mut patch = extents.into_patch();
        patch.fill(|row, first, values| {
            if values.is_empty() {
                return;
            }
            let span = self.row(row);
            values.copy_from_slice(&span.values[first - span.first_column..][..values.len()]);
        });
        patch
    }

    /// Returns the pixels with values of at least `threshold`, as `(row, columns)`, for masks.
    pub fn footprint(&self, threshold: f32) -> Vec<(usize, Range<usize>)> {
        let mut found = Vec::new();
        for span in self.iter() {
            let mut start = None;
            for (offset, value) in span.values.iter().chain([&f32::NEG_INFINITY]).enumerate() {
                let column = span.first_column + offset;
                match (start, *value >= threshold) {
                    (None, true) => start = Some(column),
                    (Some(first), false) => {
                        found.push((span.row, first..column));
                        start = None;
                    }
                    _ => {}
                }
            }
        }
        found
    }
}

/// Builder of a patch, which collects a range of columns for each row.
#[derive(Clone, Debug)]
pub struct PatchRows {
    rows: usize,
    columns: usize,
    first_row: usize,
    extents: Vec<Range<usize>>,
}

impl PatchRows {
    /// Creates an empty builder for a frame of `rows` by `columns` pixels.
    pub fn new(rows: usize, columns: usize) -> Self {
        Self { rows, columns, first_row: 0, extents: Vec::new() }
    }

    /// Returns the number of rows of the frame.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Returns the number of columns of the frame.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Adds columns of one row, and all columns between them and those added before.
    pub fn add(&mut self, row: usize, columns: Range<usize>) {
        if columns.is_empty() || row >= self.rows || columns.end > self.columns {
            return;
        }
        if self.extents.is_empty() {
            self.first_row = row;
        }
        if row < self.first_row {
            let missing = self.first_row - row;
            self.extents.splice(0..0, std::iter::repeat_n(0..0, missing));
            self.first_row = row;
        }
        let number = row - self.first_row;
        if number >= self.extents.len() {
            self.extents.resize(number + 1, 0..0);
        }
        let own = &mut self.extents[number];
        *own = if own.start >= own.end { columns } else { own.start.min(columns.start)..own.end.max(columns.end) };
    }

    /// Returns a patch of these columns, filled with zeros.
    pub fn into_patch(self) -> Patch {
        let mut total = 0;
        let spans = self.extents.into_iter().map(|columns| {
            let at = total;
            total += columns.len();
            (columns, at)
        });
        let spans: Vec<_> = spans.collect();
        // Writing zeros is faster than allocating zeroed memory, whose pages cause one page fault at the first read and
        // another at the first write.
        let mut values = Vec::with_capacity(total);
        values.resize(total, 0.0);
        Patch { rows: self.rows, columns: self.columns, first_row: self.first_row, spans, values }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_light_within_an_area_is_kept_and_removed_elsewhere() {
        // A path that leaves the area and returns.
        let mut extents = PatchRows::new(8, 20);
        [(2, 6..9), (3, 2..4), (4, 3..9), (6, 0..20)].into_iter().for_each(|(row, columns)| extents.add(row, columns));
        let mut patch = extents.into_patch();
        patch.fill(|row, first, values| {
            (first..).zip(values).for_each(|(column, value)| *value = (100 * row + column) as f32);
        });
        let cut = patch.clone().within(&LightArea { rows: 2..6, columns: 5..20 });
        for row in 0..8 {
            for column in 0..20 {
                let is_inside = (2..6).contains(&row) && column >= 5;
                assert_eq!(cut.at(row, column), if is_inside { patch.at(row, column) } else { 0.0 }, "{row} {column}");
            }
        }
        assert_eq!(cut.len(), 3 + 4);
        assert_eq!(patch.clone().within(&LightArea::whole(8, 20)), patch);
        assert!(patch.within(&LightArea { rows: 0..2, columns: 0..20 }).is_empty());
    }
}
