//! Region files of SAOImage DS9.

/// Polygon in a region file.
pub struct Region {
    /// Coordinates of the corners.
    pub corners: Vec<[f64; 2]>,
    /// Text at the region; braces and line ends are replaced.
    pub name: String,
    /// Tag of the region.
    pub tag: String,
}

/// Returns a region file with polygons in a coordinate system of DS9: `icrs` (degrees) or `image` (pixels from 1), with
/// this number of decimals. `what` states its content.
pub fn region_text(what: &str, system: &str, decimals: usize, regions: impl IntoIterator<Item = Region>) -> String {
    let mut lines = vec![
        "# Region file format: DS9 version 4.1".to_owned(),
        format!("# streakcast {} {what}", env!("CARGO_PKG_VERSION")),
        system.to_owned(),
    ];
    // Braces would end the text of a region, and line ends the region.
    let plain = |text: &str| text.replace(|c: char| c.is_control() || "{}#;".contains(c), " ");
    lines.extend(regions.into_iter().map(|Region { corners, name, tag }| {
        let corners: Vec<String> =
            corners.iter().map(|[first, second]| format!("{first:.decimals$},{second:.decimals$}")).collect();
        format!("polygon({}) # text={{{}}} tag={{{}}}", corners.join(","), plain(&name), plain(&tag))
    }));
    lines.join("\n") + "\n"
}
