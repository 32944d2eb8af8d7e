//! Flags as a table: one row an exposure.

use crate::output::{Column, Kind, Table, Value};

use super::exposure_flag::ExposureFlag;

/// One column and how its cell comes from a flag.
struct Field {
    column: Column,
    value: fn(&ExposureFlag) -> Value,
}

static FIELDS: [Field; 11] = [
    Field {
        column: Column::new("exposure_id", Kind::Text, "The schedule's name of the exposure."),
        value: |flag| flag.exposure_id.as_str().into(),
    },
    Field {
        column: Column::new("verdict", Kind::Text, "clear, streaked, avoid, or invalid where it cannot be judged."),
        value: |flag| flag.verdict.name().into(),
    },
    Field {
        column: Column::new("n_streaks", Kind::Integer, "Lit satellites whose nominal tracks cross the field."),
        value: |flag| flag.n_streaks.into(),
    },
    Field {
        column: Column::real("brightest_mag", "mag", 3, "Brightest magnitude that any of them reaches in the field."),
        value: |flag| flag.brightest_mag.into(),
    },
    Field {
        column: Column::real(
            "expected_lost_pixel_fraction",
            "",
            6,
            "Share of the field's pixels expected lost; empty without a telescope.",
        ),
        value: |flag| flag.expected_lost_pixel_fraction.into(),
    },
    Field {
        column: Column::real(
            "p_any",
            "",
            4,
            "Probability that at least one lit satellite crosses, near misses included.",
        ),
        value: |flag| flag.p_any.into(),
    },
    Field {
        column: Column::real("streak_length_deg", "deg", 4, "Length of all nominal lit streaks in the field."),
        value: |flag| flag.streak_length_deg.into(),
    },
    Field {
        column: Column::new("reasons", Kind::List { separator: "; " }, "Why the verdict is what it is."),
        value: |flag| Value::List(flag.reasons.clone()),
    },
    Field {
        column: Column {
            kind: Kind::Time { decimals: 3 },
            ..Column::time(
                "next_clear_start_utc",
                "Earliest start from the scheduled one on that is clear; empty where there is none in time.",
            )
        },
        value: |flag| flag.next_clear_start.into(),
    },
    Field {
        column: Column::real("delay_s", "s", 3, "How much later than scheduled that is."),
        value: |flag| flag.delay_s.into(),
    },
    Field {
        column: Column::new(
            "norad_ids",
            Kind::List { separator: " " },
            "Catalogue numbers of the lit crossings in order of entry.",
        ),
        value: |flag| Value::Integers(flag.norad_ids.iter().map(|id| i64::from(id.0)).collect()),
    },
];

/// The flags as a table, in their order.
pub fn flag_table(flags: &[ExposureFlag]) -> Table {
    Table {
        columns: FIELDS.iter().map(|field| field.column).collect(),
        rows: flags.iter().map(|flag| FIELDS.iter().map(|field| (field.value)(flag)).collect()).collect(),
    }
}
