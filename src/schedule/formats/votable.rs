//! VOTable: the first table of the document, with its rows in TABLEDATA. Units and time scale are read from its header.

use std::collections::HashMap;
use std::path::Path;

use hifitime::TimeScale;
use quick_xml::Reader;
use quick_xml::escape::resolve_predefined_entity;
use quick_xml::events::{BytesStart, Event};

use super::super::error;
use super::columns::{Cell, ColumnMap, ScheduleFormat, ScheduleRow};
use super::csv_text::cells;
use super::raw_table::{RawTable, Rows};
use crate::elements::excerpt;
use crate::error::Error;
use crate::input::MOST_ROWS;
use crate::message::Quoted;

/// Number of bytes at the start of the file that are searched for the root element. XML declaration, comments and
/// processing instructions may precede it.
const HEAD: usize = 4096;

/// Byte range of an element, with the white space before it.
#[derive(Copy, Clone, Debug, Default, PartialEq)]
pub(in crate::schedule) struct Span {
    /// End of the previous element: removing from here also removes the white space before the element.
    pub after: usize,
    /// Start of the element.
    pub start: usize,
    /// End of the element.
    pub end: usize,
}

/// Attributes of one `FIELD`.
#[derive(Clone, Debug, PartialEq)]
struct FieldAttributes {
    name: String,
    unit: Option<String>,
    null: Option<String>,
    /// Identifier of the time system or the coordinate system of the column.
    system: Option<String>,
    is_single_precision: bool,
}

/// Byte ranges of one row.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::schedule) struct VoRow {
    /// The `<TR>` element.
    pub span: Span,
    /// Its `<TD>` elements.
    pub cells: Vec<Span>,
    texts: Vec<String>,
}

/// Byte ranges of fields and rows of a VOTable.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::schedule) struct VoTableLayout {
    /// Column names.
    pub names: Vec<String>,
    /// `<FIELD>` elements of the first table.
    pub fields: Vec<Span>,
    /// Rows of the first table.
    pub rows: Vec<VoRow>,
    /// Element of the first table.
    pub table: Span,
    /// Names and elements of all other tables that have a name.
    pub others: Vec<(String, Span)>,
    attributes: Vec<FieldAttributes>,
    /// Field names of each other table.
    names_of_others: Vec<Vec<String>>,
    /// True if the server states that it sent only a part of the rows.
    is_part: bool,
    time_systems: HashMap<String, TimeScale>,
    /// What systems of times or coordinates are, and what is allowed, if they cannot be used.
    rejected_systems: HashMap<String, String>,
}

/// Returns true for a VOTable.
pub(super) fn is_votable(text: &str) -> bool {
    let head = text.get(..HEAD.min(text.len())).unwrap_or_else(|| text.get(..HEAD - 3).unwrap_or(text));
    text.starts_with('<') && (head.contains("<VOTABLE") || head.contains(":VOTABLE"))
}

/// Finds the fields and rows of a VOTable.
///
/// # Errors
/// The XML is invalid, there is no table, or its rows are not in TABLEDATA.
pub(in crate::schedule) fn votable_layout(path: &Path, text: &str) -> Result<VoTableLayout, Error> {
    let fail = |what: &str| error::format(path, what);
    let mut reader = Reader::from_str(text);
    let mut layout = VoTableLayout {
        names: Vec::new(),
        fields: Vec::new(),
        rows: Vec::new(),
        table: Span::default(),
        others: Vec::new(),
        attributes: Vec::new(),
        names_of_others: Vec::new(),
        is_part: false,
        time_systems: HashMap::new(),
        rejected_systems: HashMap::new(),
    };
    // Number and name of the open table, and start positions of the open elements.
    let (mut tables, mut table_name) = (0, None::<String>);
    let (mut table, mut field, mut row, mut cell) =
        (Span::default(), Span::default(), VoRow::default(), Span::default());
    let (mut in_cell, mut value) = (false, String::new());
    let (mut last_end, mut depth) = (0, 0_usize);
    let mut before = 0;
    loop {
        let event = reader.read_event().map_err(|error| {
            let line = 1 + text[..before.min(text.len())].matches('\n').count();
            Error::format(excerpt(error.to_string().as_bytes())).in_line("schedule", path, line)
        })?;
        let now = reader.buffer_position() as usize;
        match event {
            Event::Start(element) => {
                depth += 1;
                match element.local_name().as_ref() {
                    "TABLE" => {
                        tables += 1;
                        table = Span { after: last_end, start: before, end: now };
                        table_name = attribute(&element, "name");
                        if tables > 1 {
                            layout.names_of_others.push(Vec::new());
                        }
                    }
                    "FIELD" if tables == 1 => {
                        field = Span { after: last_end, start: before, end: now };
                        layout.attributes.push(field_attributes(&element));
                    }
                    "TR" if tables == 1 => {
                        row = VoRow { span: Span { after: last_end, start: before, end: now }, ..VoRow::default() };
                    }
                    "TD" if tables == 1 => {
                        cell = Span { after: last_end, start: before, end: now };
                        (in_cell, value) = (true, String::new());
                    }
                    "FIELD" => layout.names_of_others.last_mut().into_iter().for_each(|names| {
                        names.push(field_attributes(&element).name);
                    }),
                    "INFO" => layout.is_part |= states_a_part(&element),
                    "TIMESYS" => layout.note_time_system(&element),
                    "COOSYS" => layout.note_coordinate_system(&element),
                    "BINARY" | "BINARY2" | "FITS" if tables == 1 => {
                        return Err(fail("VOTable with rows in another serialization than TABLEDATA"));
                    }
                    _ => {}
                }
                last_end = now;
            }
            Event::Empty(element) => {
                let span = Span { after: last_end, start: before, end: now };
                match element.local_name().as_ref() {
                    "FIELD" if tables == 1 => {
                        layout.attributes.push(field_attributes(&element));
                        layout.fields.push(span);
                    }
                    "TD" if tables == 1 => {
                        row.cells.push(span);
                        row.texts.push(String::new());
                    }
                    "VALUES" if tables == 1 => {
                        if let (Some(fact), Some(null)) = (layout.attributes.last_mut(), attribute(&element, "null")) {
                            fact.null = Some(null);
                        }
                    }
                    "FIELD" => layout.names_of_others.last_mut().into_iter().for_each(|names| {
                        names.push(field_attributes(&element).name);
                    }),
                    "INFO" => layout.is_part |= states_a_part(&element),
                    "TIMESYS" => layout.note_time_system(&element),
                    "COOSYS" => layout.note_coordinate_system(&element),
                    _ => {}
                }
                last_end = now;
            }
            Event::Text(piece) if in_cell => value.push_str(&piece),
            Event::CData(piece) if in_cell => value.push_str(&piece),
            Event::GeneralRef(reference) if in_cell => {
                let name = reference.to_string();
                let character = reference.resolve_char_ref().ok().flatten();
                match (resolve_predefined_entity(&name), character) {
                    (Some(text), _) => value.push_str(text),
                    (None, Some(character)) => value.push(character),
                    (None, None) => {}
                }
            }
            Event::End(element) => {
                depth = depth.saturating_sub(1);
                match element.local_name().as_ref() {
                    "FIELD" if tables == 1 => layout.fields.push(Span { end: now, ..field }),
                    "TD" if tables == 1 => {
                        row.cells.push(Span { end: now, ..cell });
                        row.texts.push(std::mem::take(&mut value));
                        in_cell = false;
                    }
                    "TR" if tables == 1 => {
                        row.span.end = now;
                        layout.rows.push(std::mem::take(&mut row));
                        if layout.rows.len() > MOST_ROWS {
                            return Err(error::too_many_rows(path, MOST_ROWS));
                        }
                    }
                    "TABLE" => {
                        table.end = now;
                        match (tables, table_name.take()) {
                            (1, _) => layout.table = table,
                            (_, Some(name)) => layout.others.push((name, table)),
                            (_, None) => {}
                        }
                        // Elements after this are not part of the first table.
                        tables = tables.max(1) + usize::from(tables == 1);
                    }
                    _ => {}
                }
                last_end = now;
            }
            Event::Eof if depth > 0 => return Err(fail("truncated VOTable: the end tag is missing")),
            Event::Eof => break,
            _ => {}
        }
        before = now;
    }
    if layout.fields.is_empty() {
        return Err(fail("VOTable without a table"));
    }
    layout.names = layout.attributes.iter().map(|fact| fact.name.clone()).collect();
    let is_schedule = |names: &Vec<String>| *names == layout.names || ColumnMap::find(path, names).is_ok();
    let others = layout.names_of_others.iter().filter(|names| is_schedule(names)).count();
    if others > 0 {
        let what = format!("VOTable with {} tables of exposures", others + 1);
        return Err(error::format(path, what).allowing("one table of exposures; split the file"));
    }
    Ok(layout)
}

impl VoTableLayout {
    /// Notes a coordinate system, unless its axes are those of ICRS.
    fn note_coordinate_system(&mut self, element: &BytesStart<'_>) {
        let (id, system) = (attribute(element, "ID"), attribute(element, "system").unwrap_or_default());
        let equinox = attribute(element, "equinox").unwrap_or_default();
        let is_j2000 = equinox.trim_start_matches(['J', 'j']).parse() == Ok(2000.0);
        let is_allowed = match system.to_ascii_uppercase().as_str() {
            "" | "ICRS" | "ICRF" => true,
            // The old name in VOTable is eq_FK5.
            "FK5" | "EQ_FK5" => is_j2000 || equinox.is_empty(),
            _ => false,
        };
        if let Some(id) = id.filter(|_| !is_allowed) {
            let system = Quoted::new(format!("{system} {equinox}").trim()).to_string();
            self.rejected_systems.insert(id, format!("is in the coordinate system {system}; allowed: ICRS"));
        }
    }

    /// Notes a time system.
    fn note_time_system(&mut self, element: &BytesStart<'_>) {
        let value = |name| attribute(element, name).unwrap_or_default();
        let (place, origin) = (value("refposition"), value("timeorigin"));
        let is_elsewhere = ["BARYCENTER", "HELIOCENTER", "EMBARYCENTER"].contains(&&*place.to_ascii_uppercase());
        let is_offset = !["", "MJD-origin", "JD-origin"].contains(&&*origin)
            && origin.parse::<f64>().map_or(true, |day| ![0.0, 2_400_000.5].contains(&day));
        let problem = if is_elsewhere {
            Some(format!("has times at the {}; allowed: TOPOCENTER or GEOCENTER", Quoted::new(&place)))
        } else if is_offset {
            Some(format!("has the time origin {}; allowed: MJD-origin or JD-origin", Quoted::new(&origin)))
        } else {
            None
        };
        if let (Some(id), Some(problem)) = (attribute(element, "ID"), problem) {
            self.rejected_systems.insert(id, problem);
        }
        let scale = match attribute(element, "timescale").as_deref() {
            Some("UTC") => TimeScale::UTC,
            Some("TAI") => TimeScale::TAI,
            Some("TT") => TimeScale::TT,
            Some("TDB") => TimeScale::TDB,
            _ => return,
        };
        if let Some(id) = attribute(element, "ID") {
            self.time_systems.insert(id, scale);
        }
    }
}

/// Reads a VOTable.
///
/// # Errors
/// Same as [`votable_layout`].
pub(super) fn read(path: &Path, text: &str) -> Result<RawTable, Error> {
    let layout = votable_layout(path, text)?;
    let mut table = RawTable::new(ScheduleFormat::VoTable, layout.names);
    let width = table.names.len();
    let rows = layout.rows.iter().map(|row| cells(row.texts.iter().map(String::as_str), width));
    let mut rows: Vec<ScheduleRow> = rows.collect();
    for (index, fact) in layout.attributes.iter().enumerate() {
        if let Some(unit) = fact.unit.clone().filter(|unit| !unit.is_empty()) {
            table.units.insert(fact.name.clone(), unit);
        }
        if let Some(scale) = fact.system.as_ref().and_then(|id| layout.time_systems.get(id)) {
            table.time_scales.insert(fact.name.clone(), *scale);
        }
        if let Some(problem) = fact.system.as_ref().and_then(|id| layout.rejected_systems.get(id)) {
            table.rejected.insert(fact.name.clone(), problem.clone());
        }
        if fact.is_single_precision {
            table.single_precision.insert(fact.name.clone());
        }
        let Some(null) = &fact.null else { continue };
        for row in rows.iter_mut().flatten() {
            if row.get(index).is_some_and(|cell| matches!(cell, Cell::Text(text) if text == null)) {
                row[index] = Cell::Missing;
            }
        }
    }
    table.rows = Rows::Cells(rows);
    if layout.is_part {
        table.warnings.push(format!(
            "the server states that its answer was cut (QUERY_STATUS OVERFLOW): the other exposures after the {} of the \
             file are unknown",
            layout.rows.len()
        ));
    }
    Ok(table)
}

/// Returns true for an `INFO` with which a server of the Virtual Observatory states that it cut its answer.
fn states_a_part(info: &BytesStart<'_>) -> bool {
    let is = |name, text: &str| attribute(info, name).is_some_and(|value| value.eq_ignore_ascii_case(text));
    is("name", "QUERY_STATUS") && is("value", "OVERFLOW")
}

fn field_attributes(element: &BytesStart<'_>) -> FieldAttributes {
    let value = |name: &str| attribute(element, name);
    FieldAttributes {
        name: value("name").or_else(|| value("ID")).unwrap_or_default(),
        unit: value("unit"),
        null: None,
        system: value("ref"),
        is_single_precision: value("datatype").as_deref() == Some("float"),
    }
}

fn attribute(element: &BytesStart<'_>, name: &str) -> Option<String> {
    let found = element.attributes().with_checks(false).flatten().find(|attribute| attribute.key.as_ref() == name)?;
    let text = found.value.to_string();
    Some(quick_xml::escape::unescape(&text).map_or(text.clone(), |plain| plain.into_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "<?xml version=\"1.0\"?>\n<VOTABLE version=\"1.4\" xmlns=\"http://www.ivoa.net/xml/VOTable/v1.3\">\n <RESOURCE>\n\
        <TIMESYS ID=\"t\" timescale=\"TAI\" refposition=\"TOPOCENTER\" timeorigin=\"MJD-origin\"/>\n <TABLE>\n  <FIELD name=\"id\" datatype=\"long\">\n\
        <VALUES null=\"-9\"/></FIELD>\n  <FIELD name=\"start_mjd\" datatype=\"double\" ref=\"t\" unit=\"d\"/>\n  <DATA><TABLEDATA>\n   \
        <TR><TD>7</TD><TD> 60536.1 </TD></TR>\n   <TR><TD>-9</TD><TD/></TR>\n  </TABLEDATA></DATA>\n </TABLE>\n\
        <TABLE name=\"streaks\"><FIELD name=\"x\"/><DATA><TABLEDATA><TR><TD>a &amp; b</TD></TR></TABLEDATA></DATA></TABLE></RESOURCE></VOTABLE>\n";

    #[test]
    fn the_first_table_is_read_with_its_header_and_byte_ranges() {
        let path = Path::new("t.vot");
        let table = read(path, TEXT).unwrap();
        assert_eq!(table.names, ["id", "start_mjd"]);
        assert_eq!(table.time_scales.get("start_mjd"), Some(&TimeScale::TAI));
        let rows: Vec<ScheduleRow> = table.rows.iter().map(std::borrow::Cow::into_owned).collect();
        assert_eq!(rows.len(), 2);
        assert_eq!(rows[0].as_ref().unwrap()[1], Cell::Text("60536.1".into()));
        assert_eq!(*rows[1].as_ref().unwrap(), [Cell::Missing, Cell::Missing]);
        let layout = votable_layout(path, TEXT).unwrap();
        let shown = |span: &Span| &TEXT[span.start..span.end];
        assert_eq!(shown(&layout.fields[1]), "<FIELD name=\"start_mjd\" datatype=\"double\" ref=\"t\" unit=\"d\"/>");
        assert_eq!(shown(&layout.rows[1].span), "<TR><TD>-9</TD><TD/></TR>");
        assert_eq!(shown(&layout.rows[1].cells[1]), "<TD/>");
        assert_eq!(layout.others.len(), 1);
        assert!(shown(&layout.others[0].1).starts_with("<TABLE name=\"streaks\">"));
        assert!(shown(&layout.table).ends_with("</TABLE>") && !shown(&layout.table).contains("streaks"));
        for (system, expected) in [
            ("<COOSYS ID=\"t\" system=\"ICRS\" equinox=\"J2015.5\"/>", None),
            ("<COOSYS ID=\"t\" system=\"eq_FK5\" equinox=\"J2000\"/>", None),
            ("<COOSYS ID=\"t\" system=\"eq_FK5\" equinox=\"J1975\"/>", Some("eq_FK5 J1975; allowed: ICRS")),
            ("<COOSYS ID=\"t\" system=\"FK4\"></COOSYS>", Some("FK4; allowed: ICRS")),
            ("<COOSYS ID=\"t\" system=\"galactic\"/>", Some("galactic; allowed: ICRS")),
            ("<COOSYS ID=\"t\" system=\"GALACTIC_II\"/>", Some("GALACTIC_II; allowed: ICRS")),
            ("<COOSYS ID=\"t\" system=\"geo_app\"/>", Some("geo_app; allowed: ICRS")),
            (
                "<TIMESYS ID=\"t\" timescale=\"UTC\" refposition=\"BARYCENTER\"/>",
                Some("BARYCENTER; allowed: TOPOCENTER"),
            ),
            (
                "<TIMESYS ID=\"t\" timescale=\"UTC\" timeorigin=\"2451545\"/>",
                Some("origin 2451545; allowed: MJD-origin"),
            ),
            ("<TIMESYS ID=\"t\" timescale=\"UTC\" timeorigin=\"2400000.5\"/>", None),
        ] {
            let old = TEXT.lines().nth(3).unwrap();
            let problem = read(path, &TEXT.replace(old, system)).unwrap().rejected.remove("start_mjd");
            assert_eq!(problem.is_some(), expected.is_some(), "{system}: {problem:?}");
            assert!(problem.unwrap_or_default().contains(expected.unwrap_or_default()), "{system}");
        }
        assert!(read(path, TEXT).unwrap().warnings.is_empty());
        for info in [
            "<INFO name=\"QUERY_STATUS\" value=\"OVERFLOW\"/>",
            "<INFO name='QUERY_STATUS' value='overflow'>limit</INFO>",
        ] {
            let cut = TEXT.replace("</RESOURCE>", &format!("{info}</RESOURCE>"));
            assert!(read(path, &cut).unwrap().warnings[0].contains("after the 2 of the file are unknown"), "{info}");
        }
        // Two tables of a resource, two resources, and two documents.
        let first = &TEXT[TEXT.find("<TABLE>").unwrap()..TEXT.find("<TABLE name").unwrap()];
        let schedule = ["exposure_id", "start_utc", "exposure_s", "ra_deg", "dec_deg"];
        let schedule: String = schedule.iter().map(|name| format!("<FIELD name=\"{name}\"></FIELD>")).collect();
        for text in [
            TEXT.replace(first, &first.repeat(2)),
            TEXT.replace("</RESOURCE>", &format!("</RESOURCE><RESOURCE>{first}</RESOURCE>")),
            TEXT.repeat(2),
            TEXT.replace("</RESOURCE>", &format!("<TABLE>{schedule}</TABLE></RESOURCE>")),
        ] {
            let error = read(path, &text).unwrap_err().to_string();
            assert!(error.contains("VOTable with 2 tables of exposures; allowed: one table"), "{error}");
        }
        let binary = TEXT.replace("TABLEDATA", "BINARY2");
        assert!(read(path, &binary).unwrap_err().to_string().contains("than TABLEDATA"));
    }
}
