//! The table that holds the tiles of a compressed image: rows of descriptors and, behind them, a heap of bytes.

use super::super::super::header::Header;

/// A table of variable-length columns.
#[derive(Debug)]
pub(super) struct TileTable {
    bytes: Vec<u8>,
    row_length: usize,
    rows: usize,
    heap: usize,
    columns: Vec<Column>,
}

/// A column: where it is in a row and what it holds.
#[derive(Clone, Debug, PartialEq)]
struct Column {
    number: usize,
    name: String,
    at: usize,
    /// For a variable-length one: bytes of half a descriptor, and of one element.
    variable: Option<(usize, usize)>,
    letter: char,
}

/// A table written anew: its bytes, and what its header must say.
#[derive(Debug, PartialEq)]
pub(in super::super) struct Rebuilt {
    pub bytes: Vec<u8>,
    /// Bytes of the heap (PCOUNT).
    pub heap_length: usize,
    /// Keywords TFORMn whose greatest length grew, with their text.
    pub forms: Vec<(String, String)>,
}

impl TileTable {
    /// From the bytes of an HDU; `None` where its columns cannot be made out.
    pub fn new(header: &Header, bytes: Vec<u8>) -> Option<Self> {
        let count = |keyword: &str| usize::try_from(header.integer(keyword)?).ok();
        let (row_length, rows) = (count("NAXIS1")?, count("NAXIS2")?);
        let heap = count("THEAP").unwrap_or(row_length * rows);
        let mut columns = Vec::new();
        let mut at = 0;
        for number in 1..=count("TFIELDS")? {
            let form = header.text(&format!("TFORM{number}"))?;
            let (length, letter, variable) = parse_form(&form)?;
            let name = header.text(&format!("TTYPE{number}")).unwrap_or_default().to_ascii_uppercase();
            columns.push(Column { number, name, at, variable, letter });
            at += length;
        }
        (at <= row_length && heap >= row_length * rows && heap <= bytes.len()).then_some(Self {
            bytes,
            row_length,
            rows,
            heap,
            columns,
        })
    }

    /// Number of rows, one a tile.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Whether there is a column of this name.
    pub fn has(&self, name: &str) -> bool {
        self.column(name).is_some()
    }

    fn column(&self, name: &str) -> Option<&Column> {
        self.columns.iter().find(|column| column.name == name)
    }

    /// The bytes that a variable-length column points to in a row; `None` where there is no such column or it points out of the heap.
    pub fn variable(&self, name: &str, row: usize) -> Option<&[u8]> {
        let column = self.column(name)?;
        let (count, offset) = self.descriptor(column, row)?;
        let (_, size) = column.variable?;
        let start = self.heap.checked_add(offset)?;
        self.bytes.get(start..start.checked_add(count.checked_mul(size)?)?)
    }

    /// A number of a column of fixed length.
    pub fn number(&self, name: &str, row: usize) -> Option<f64> {
        let column = self.column(name)?;
        let at = row * self.row_length + column.at;
        let bytes = |length: usize| self.bytes.get(at..at + length);
        Some(match column.letter {
            'D' => f64::from_be_bytes(bytes(8)?.try_into().ok()?),
            'E' => f64::from(f32::from_be_bytes(bytes(4)?.try_into().ok()?)),
            'J' => f64::from(i32::from_be_bytes(bytes(4)?.try_into().ok()?)),
            'I' => f64::from(i16::from_be_bytes(bytes(2)?.try_into().ok()?)),
            _ => return None,
        })
    }

    /// How many elements, and where in the heap.
    fn descriptor(&self, column: &Column, row: usize) -> Option<(usize, usize)> {
        let (half, _) = column.variable?;
        let at = row * self.row_length + column.at;
        let number = |at: usize| {
            let bytes = self.bytes.get(at..at + half)?;
            usize::try_from(bytes.iter().fold(0u64, |number, byte| number << 8 | u64::from(*byte))).ok()
        };
        Some((number(at)?, number(at + half)?))
    }

    /// The table with other bytes in some places: `changed` gives those of a column and row, `None` for the old ones. The heap is written without gaps.
    pub fn rebuilt(&self, header: &Header, changed: impl Fn(&str, usize) -> Option<Vec<u8>>) -> Option<Rebuilt> {
        let mut rows = self.bytes[..self.row_length * self.rows].to_vec();
        let mut heap: Vec<u8> = Vec::new();
        let mut longest = vec![0; self.columns.len()];
        for row in 0..self.rows {
            for (column, longest) in self.columns.iter().zip(&mut longest) {
                let Some((half, size)) = column.variable else { continue };
                let new = changed(&column.name, row);
                let old = self.variable(&column.name, row);
                let bytes = new.as_deref().or(old)?;
                let count = bytes.len() / size;
                *longest = count.max(*longest);
                let at = row * self.row_length + column.at;
                let place = if count == 0 { 0 } else { heap.len() };
                for (number, at) in [(count, at), (place, at + half)] {
                    rows[at..at + half].copy_from_slice(&(number as u64).to_be_bytes()[8 - half..]);
                }
                heap.extend_from_slice(bytes);
            }
        }
        if self.columns.iter().any(|column| matches!(column.variable, Some((4, _))))
            && i32::try_from(heap.len()).is_err()
        {
            return None;
        }
        let forms = self.columns.iter().zip(longest).filter_map(|(column, longest)| {
            let keyword = format!("TFORM{}", column.number);
            let form = header.text(&keyword)?;
            let (head, most) = form.trim_end_matches(')').split_once('(')?;
            (column.variable.is_some() && most.parse::<usize>().ok()? < longest)
                .then(|| (keyword, format!("{head}({longest})")))
        });
        let forms = forms.collect();
        let heap_length = heap.len();
        rows.extend(heap);
        Some(Rebuilt { bytes: rows, heap_length, forms })
    }
}

/// What a TFORMn says: bytes in a row, the letter, and for a variable-length column the bytes of half a descriptor and of an element.
type Form = (usize, char, Option<(usize, usize)>);

/// Reads a TFORMn.
fn parse_form(form: &str) -> Option<Form> {
    let digits = form.len() - form.trim_start_matches(|c: char| c.is_ascii_digit()).len();
    let count: usize = if digits == 0 { 1 } else { form[..digits].parse().ok()? };
    let mut letters = form[digits..].chars();
    let letter = letters.next()?;
    let size = |letter: char| {
        Some(match letter {
            'L' | 'B' | 'A' => 1,
            'I' => 2,
            'J' | 'E' => 4,
            'K' | 'D' | 'C' => 8,
            'M' => 16,
            _ => return None,
        })
    };
    Some(match letter {
        'X' => (count.div_ceil(8), letter, None),
        'P' | 'Q' => {
            let half = if letter == 'P' { 4 } else { 8 };
            (count * 2 * half, letter, (count == 1).then_some((half, size(letters.next()?)?)))
        }
        _ => (count * size(letter)?, letter, None),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_forms() {
        assert_eq!(parse_form("1PB(260)"), Some((8, 'P', Some((4, 1)))));
        assert_eq!(parse_form("QI"), Some((16, 'Q', Some((8, 2)))));
        assert_eq!(parse_form("1D"), Some((8, 'D', None)));
        assert_eq!(parse_form("12A"), Some((12, 'A', None)));
        assert_eq!(parse_form("11X"), Some((2, 'X', None)));
        assert_eq!(parse_form("5"), None);
    }
}
