//! The frames that positions and directions are given in; empty types, only their names matter.

use std::fmt::Debug;

/// A set of axes. Implemented by the empty types of this file and by nothing else.
pub trait Frame: Copy + Clone + Debug + PartialEq + Send + Sync + 'static {
    /// The frame's name as it is printed.
    const NAME: &'static str;
}

macro_rules! frame {
    ($(#[$doc:meta])* $name:ident, $text:literal) => {
        $(#[$doc])*
        #[derive(Copy, Clone, Debug, PartialEq, Eq)]
        pub struct $name;
        impl Frame for $name {
            const NAME: &'static str = $text;
        }
    };
}

frame!(
    /// True equator, mean equinox of date: what SGP4 answers in. Never leaves `orbit`.
    Teme, "TEME"
);
frame!(
    /// Geocentric celestial reference system; its axes are those of ICRS.
    Gcrs, "GCRS"
);
frame!(
    /// True equator and equinox of date: x to the equinox, z to the celestial intermediate pole.
    OfDate, "true equator and equinox of date"
);
frame!(
    /// Earth-fixed: x to longitude 0 on the equator, z to the pole.
    Itrs, "ITRS"
);
frame!(
    /// A site's horizon: x to the north, y to the east, z to the zenith (left-handed, so that longitude is azimuth).
    Horizontal, "horizontal"
);
frame!(
    /// A satellite's body: z to its zenith, x in the half plane of the Sun, y completes it (Lu 2024, section 2.2).
    Body, "body"
);
