//! Operator ephemerides: positions, velocities and covariances at given times, from files in Modified ITC format and
//! CCSDS orbit ephemeris messages (OEM).
//!
//! `data` defines the types, `builder` checks states and covariances for all formats, `metadata` reads the metadata of
//! an OEM, and there is one module for each format. An ephemeris with an error is rejected as a whole, because
//! interpolation uses neighbouring states.

mod builder;
mod data;
mod metadata;
mod modified_itc;
mod oem_kvn;
mod oem_xml;

pub(super) use builder::Problem;
pub use data::{CovarianceAxes, Ephemeris, EphemerisFrame, EphemerisObject, EphemerisState, PositionCovariance};
pub(super) use modified_itc::{looks_like as looks_like_modified_itc, parse as parse_modified_itc};
pub(super) use oem_kvn::{
    OPENING as OEM_KVN_OPENING, closes as closes_oem_kvn, looks_like as looks_like_oem_kvn, opens as opens_oem_kvn,
    parse as parse_oem_kvn,
};
pub(super) use oem_xml::{looks_like as looks_like_oem_xml, parse as parse_oem_xml};
