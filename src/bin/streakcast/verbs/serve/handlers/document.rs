//! JSON bodies of responses, their JSON Schemas, and columns that occur only in the API.

use hifitime::Epoch;
use serde_json::{Value, json};
use streakcast::output::{Column, Kind, Provenance, Table, json_members, json_rows};
use streakcast::passes::AltAz;

use super::super::state::Caveats;

/// JSON object to which members are added.
#[derive(Default)]
pub struct Document {
    text: String,
}

impl Document {
    /// Creates an object with the provenance of the response.
    pub fn with_provenance(provenance: &Provenance) -> Self {
        let mut document = Self::default();
        document.raw("provenance", &serde_json::to_string(provenance).unwrap_or_else(|_| "{}".to_owned()));
        document
    }

    fn raw(&mut self, name: &str, text: &str) {
        let comma = if self.text.is_empty() { "" } else { ",\n" };
        self.text.push_str(&format!("{comma}{}: {text}", Value::from(name)));
    }

    pub fn value(&mut self, name: &str, value: impl Into<Value>) {
        self.raw(name, &value.into().to_string());
    }

    pub fn caveats(&mut self, caveats: &Caveats) {
        self.value("warnings", caveats.warnings.as_slice());
        self.value("left_out_count", caveats.left_out_count);
    }

    /// Adds a table as an array of objects.
    pub fn table(&mut self, name: &str, table: &Table) {
        self.raw(name, &json_rows(&table.columns, &table.rows));
    }

    /// Adds the first row of a table as an object.
    pub fn record(&mut self, name: &str, table: &Table) {
        let members = table.rows.first().map(|row| json_members(&table.columns, row)).unwrap_or_default();
        self.raw(name, &format!("{{{members}}}"));
    }

    pub fn into_json(self) -> String {
        format!("{{{}}}\n", self.text)
    }
}

/// Returns the schema of a table's row.
pub fn row_schema(columns: &[Column]) -> Value {
    let names: Vec<&str> = columns.iter().map(|column| column.name).collect();
    let members: serde_json::Map<String, Value> =
        columns.iter().map(|column| (column.name.to_owned(), cell_schema(column))).collect();
    json!({"type": "object", "properties": members, "required": names, "additionalProperties": false})
}

/// Returns the schema of a table.
pub fn rows_schema(columns: &[Column]) -> Value {
    json!({"type": "array", "items": row_schema(columns)})
}

/// Returns the schema of an object with exactly these members.
pub fn object_schema(members: &[(&str, Value)]) -> Value {
    let names: Vec<&str> = members.iter().map(|(name, _)| *name).collect();
    let members: serde_json::Map<String, Value> =
        members.iter().map(|(name, schema)| ((*name).to_owned(), schema.clone())).collect();
    json!({"type": "object", "properties": members, "required": names, "additionalProperties": false})
}

/// Returns the schema of a response that begins with its provenance and caveats, and has these members.
pub fn document_schema(members: &[(&str, Value)]) -> Value {
    let provenance = json!({"type": "object", "description": "Origin of the result: version, elements with hash and epochs, models, time scale, options."});
    object_schema(&[&[("provenance", provenance)][..], &caveat_schemas(), members].concat())
}

/// Returns the schemas of the warnings and of the number of satellites whose position cannot be computed.
pub fn caveat_schemas() -> [(&'static str, Value); 2] {
    let warnings = json!({
        "type": "array",
        "items": text_schema(),
        "description": "The warnings of the command line: age of the elements, satellites left out, invalid records.",
    });
    let left_out = json!({"type": "integer", "minimum": 0, "description": "Number of satellites that are missing from the result because SGP4 cannot compute their position at that time."});
    [("warnings", warnings), ("left_out_count", left_out)]
}

/// Returns the schema of a number.
pub fn number_schema() -> Value {
    json!({"type": "number"})
}

/// Returns the schema of a number or null.
pub fn optional_number_schema() -> Value {
    json!({"type": ["number", "null"]})
}

/// Returns the schema of a text.
pub fn text_schema() -> Value {
    json!({"type": "string"})
}

/// Returns the schema of a number of things.
pub fn count_schema() -> Value {
    json!({"type": "integer", "minimum": 0})
}

fn cell_schema(column: &Column) -> Value {
    let unit = if column.unit.is_empty() { String::new() } else { format!(" [{}]", column.unit) };
    let description = format!("{}{unit}", column.description);
    let mut schema = match column.kind {
        Kind::Text => json!({"type": ["string", "null"]}),
        Kind::Integer => json!({"type": ["integer", "null"]}),
        Kind::Real { .. } | Kind::Small { .. } => json!({"type": ["number", "null"]}),
        Kind::Time { .. } => json!({"type": ["string", "null"], "format": "date-time"}),
        Kind::Boolean => json!({"type": ["boolean", "null"]}),
        Kind::List { .. } => json!({"type": "array", "items": {"type": ["string", "integer"]}}),
        Kind::Rows(columns) => json!({"type": ["array", "null"], "items": row_schema(columns)}),
    };
    schema["description"] = description.into();
    schema
}

/// Columns for altitude and azimuth of pointing and Sun.
pub const POINTING: [Column; 5] = [
    Column::time("utc", "Time of the position."),
    Column::real("altitude_deg", "deg", 4, "Altitude of the field's centre, without refraction."),
    Column::real("azimuth_deg", "deg", 4, "Azimuth of the field's centre, from north through east."),
    Column::real("sun_altitude_deg", "deg", 4, "Altitude of the Sun, without refraction."),
    Column::real("sun_azimuth_deg", "deg", 4, "Azimuth of the Sun, from north through east."),
];

/// Columns for crossings of the field before, during and after the exposure.
pub const AROUND: [Column; 8] = [
    Column::new("norad_id", Kind::Integer, "NORAD catalogue number."),
    Column::new("name", Kind::Text, "Name in the element set."),
    Column::real("enter_s", "s", 3, "Time of entry into the field after shutter opening; negative before it."),
    Column::real("exit_s", "s", 3, "Time of exit from the field after shutter opening."),
    Column::real("magnitude_peak", "mag", 3, "Brightest magnitude inside the field."),
    Column::real("probability", "", 4, "Probability that the satellite crosses the field in that interval."),
    Column::real("p_brighter", "", 4, "Probability of being brighter than the magnitude limit; empty without a limit."),
    Column::new(
        "exceeds_limit",
        Kind::Boolean,
        "True if the crossing alone is sufficient for the verdict avoid; empty without a limit.",
    ),
];

/// Columns for positions of the Sun in a night.
pub const SUN: [Column; 3] = [
    Column { kind: Kind::Time { decimals: 0 }, ..Column::time("utc", "Time of the position.") },
    Column::real("sun_altitude_deg", "deg", 3, "Altitude of the Sun, without refraction."),
    Column::real("sun_azimuth_deg", "deg", 3, "Azimuth of the Sun, from north through east."),
];

/// Columns for local time minus UTC.
pub const OFFSETS: [Column; 2] = [
    Column { kind: Kind::Time { decimals: 0 }, ..Column::time("from_utc", "Time from which the value holds.") },
    Column::real("utc_offset_h", "h", 4, "Local time minus UTC."),
];

/// Columns for exposures of the schedule. Times and pointings of invalid exposures are null.
pub const SCHEDULED: [Column; 8] = [
    Column::new("id", Kind::Text, "Identifier of the exposure in the schedule."),
    Column::new("row", Kind::Integer, "Row in the file, counted from 0."),
    Column::time("start_utc", "Shutter opening."),
    Column::real("duration_s", "s", 3, "Length of the exposure."),
    Column::real("ra_deg", "deg", 7, "Right ascension of the field's centre, ICRS."),
    Column::real("dec_deg", "deg", 7, "Declination of the field's centre."),
    Column::real("rotation_deg", "deg", 4, "Position angle of the field's y axis."),
    Column::new("band", Kind::Text, "Band as the schedule writes it."),
];

/// Columns for nights of the schedule.
pub const NIGHTS: [Column; 2] = [
    Column::new("night", Kind::Text, "Local date of the evening."),
    Column::new("exposures", Kind::Integer, "Number of exposures in the night."),
];

/// Columns for the site.
pub const SITE: [Column; 5] = [
    Column::new("name", Kind::Text, "Name of the site."),
    Column::new("mpc_code", Kind::Text, "Observatory code of the Minor Planet Center."),
    Column::real("latitude_deg", "deg", 6, "Geodetic latitude, WGS84."),
    Column::real("longitude_deg", "deg", 6, "Longitude, east positive."),
    Column::real("height_m", "m", 1, "Height above the ellipsoid."),
];

/// Returns the table of local time minus UTC, hours, by the times from which the values hold.
pub fn offset_table(offsets: Vec<(Epoch, f64)>) -> Table {
    let rows = offsets.into_iter().map(|(epoch, hours)| vec![epoch.into(), hours.into()]).collect();
    Table { columns: OFFSETS.to_vec(), rows }
}

/// Returns altitude and azimuth, degrees.
pub fn degrees(position: &AltAz) -> (f64, f64) {
    (position.altitude_rad.to_degrees(), position.azimuth_rad.to_degrees())
}

/// Rounds a number to a number of decimals.
pub fn rounded(value: f64, decimals: i32) -> f64 {
    let factor = 10_f64.powi(decimals);
    // The sum of no numbers is -0.
    (value * factor).round() / factor + 0.0
}
