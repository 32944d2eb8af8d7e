//! Physical pixels of IRAF and SAOImage DS9: those of the frame from which a frame was cut or binned.

use super::header::Header;
use super::pixels::PixelPosition;

impl PixelPosition {
    /// Converts a position in physical pixels to one in the frame with this header: x = LTM p + LTV (IRAF), or without
    /// these keywords x = CRPIX + (p - CRVAL) / CDELT of the world coordinates P (WCSNAMEP is PHYSICAL). Without either,
    /// physical pixels are those of the frame.
    pub(crate) fn of_physical(self, header: &Header) -> Self {
        let number = |keyword: String, missing: f64| header.number(&keyword).unwrap_or(missing);
        let physical = self.fits();
        let is_iraf = ["LTV1", "LTV2", "LTM1_1", "LTM2_2"].iter().any(|keyword| header.number(keyword).is_some());
        let is_named = header.text("WCSNAMEP").is_some_and(|name| name.eq_ignore_ascii_case("PHYSICAL"));
        let of_axis = |axis: usize| {
            let own = physical[axis - 1];
            if !is_iraf && is_named {
                let from_reference = own - number(format!("CRVAL{axis}P"), 0.0);
                return number(format!("CRPIX{axis}P"), 0.0) + from_reference / number(format!("CDELT{axis}P"), 1.0);
            }
            let other = 3 - axis;
            number(format!("LTM{axis}_{axis}"), 1.0) * own
                + number(format!("LTM{axis}_{other}"), 0.0) * physical[other - 1]
                + number(format!("LTV{axis}"), 0.0)
        };
        Self::from_fits(of_axis(1), of_axis(2))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn physical_pixels_are_those_before_cutting_and_binning() {
        for (header, expected) in [
            ("", [100.0, 50.0]),
            // A cutout that begins at (41, 11), and the same with axis 1 in bins of two.
            ("LTV1    = -40.0\nLTV2    = -10.0\n", [60.0, 40.0]),
            ("LTV1    = -19.75\nLTM1_1  = 0.5\nLTV2    = -10\nLTM2_2  = 1.0\n", [30.25, 40.0]),
            // Flipped, and with exchanged axes.
            ("LTV1    = 201.0\nLTM1_1  = -1.0\n", [101.0, 50.0]),
            ("LTM1_1  = 0.0\nLTM1_2  = 1.0\nLTM2_1  = 1.0\nLTM2_2  = 0.0\n", [50.0, 100.0]),
            ("WCSNAMEP= 'PHYSICAL'\nCRPIX1P = 0.5\nCRVAL1P = 40.0\nCDELT1P = 2.0\n", [30.5, 50.0]),
            ("WCSNAMEP= 'OTHER'\nCRPIX1P = 0.5\nCRVAL1P = 40.0\nCDELT1P = 2.0\n", [100.0, 50.0]),
        ] {
            let found = PixelPosition::from_fits(100.0, 50.0).of_physical(&Header::from_text(header)).fits();
            assert_eq!(found, expected, "{header}");
        }
    }
}
