//! Maps of cells in several panels.

use streakcast::math::healpix::{cell_count, ring_centre_rad};
use streakcast::plot::{ColourScale, LayerPanel, Layers, Quantity, layers};

use super::{COLOUR_STEPS, has, pixels, words};

fn southern_cells(nside: u32, value: impl Fn(f64, f64) -> f64) -> Vec<(u64, f64)> {
    let cells = (0..cell_count(nside)).map(|cell| (cell, ring_centre_rad(nside, cell).unwrap()));
    cells.filter(|(_, (_, latitude))| *latitude < 0.0).map(|(cell, (x, y))| (cell, value(x, y))).collect()
}

#[test]
fn verif_cells_have_their_colours_at_their_positions() {
    let residuals = southern_cells(8, |longitude, latitude| 0.5 * longitude.cos() * latitude.cos());
    let missing = residuals[40].0;
    let shown: Vec<_> = residuals.iter().copied().filter(|(cell, _)| *cell != missing).collect();
    for is_folded in [true, false] {
        let panel = LayerPanel { title: "(a) Sun at latitude −8°", quantity: Quantity::Residual, cells: &shown };
        let picture =
            layers(&Layers { title: "O−C", caption: "Test.", nside: 8, is_folded, panels: vec![panel] }).unwrap();
        let image = pixels(&picture);
        let scale = picture.scales()[0];
        assert!((scale.least + scale.greatest).abs() < 1e-12);
        // Layout: a left margin of 66 and a radius of 270; from the top 46 + 32 + 66 + 270.
        let mut compared = 0;
        for (cell, value) in &residuals {
            let (longitude, latitude) = ring_centre_rad(8, *cell).unwrap();
            let distance = 270.0 * (latitude + std::f64::consts::FRAC_PI_2) / std::f64::consts::FRAC_PI_2;
            // Pixels that are not near the edge of the hemisphere, lines or texts.
            let degrees = longitude.to_degrees();
            let is_clear = [90.0, 180.0, 270.0].iter().all(|circle| (distance - circle).abs() > 6.0);
            if !is_clear || (100.0..130.0).contains(&degrees) || (is_folded && !(8.0..172.0).contains(&degrees)) {
                continue;
            }
            let (x, y) = (336.0 - distance * longitude.sin(), 414.0 - distance * longitude.cos());
            let found = image.get_pixel(x as u32, y as u32).0;
            let expected = if *cell == missing { [205; 3] } else { scale.colour(*value) };
            let apart = found.iter().zip(expected).map(|(a, b)| a.abs_diff(b)).max().unwrap();
            assert!(apart <= COLOUR_STEPS, "cell {cell} at {x} {y}: {found:?} for {expected:?}");
            compared += 1;
        }
        assert!(compared > if is_folded { 100 } else { 200 }, "{compared}");
        has(&picture, &["O−C", "(a) Sun at latitude −8°", "O−C, mag", "0°", "90°", "180°", "−60°", "Sun", "no cell"]);
        assert_eq!(words(&picture).contains(&"270°".to_owned()), !is_folded);
    }
}

#[test]
fn verif_panels_of_several_quantities_have_a_bar_each() {
    let magnitudes = southern_cells(4, |longitude, _| 6.0 + longitude.cos());
    let counts = southern_cells(4, |longitude, _| (1.0 + 100.0 * longitude).floor());
    let spreads = southern_cells(4, |_, latitude| 0.3 - 0.2 * latitude);
    let panel = |title, quantity, cells| LayerPanel { title, quantity, cells };
    let panels = vec![
        panel("(a)", Quantity::Magnitude, &magnitudes[..]),
        panel("(b)", Quantity::Count, &counts),
        panel("(c)", Quantity::Spread, &spreads),
    ];
    for is_folded in [true, false] {
        let input = Layers { title: "", caption: "", nside: 4, is_folded, panels: panels.clone() };
        let picture = layers(&input).unwrap();
        pixels(&picture);
        has(&picture, &["(a)", "(b)", "(c)", "mag", "samples", "IQR, mag", "100"]);
        let quantities: Vec<Quantity> = picture.scales().iter().map(|scale: &ColourScale| scale.quantity).collect();
        assert_eq!(quantities, [Quantity::Magnitude, Quantity::Count, Quantity::Spread]);
        // Twelve layers can be drawn.
        let twelve = vec![panels[0].clone(); 12];
        pixels(&layers(&Layers { panels: twelve, ..input }).unwrap());
    }
}

#[test]
fn verif_layers_reject_invalid_input() {
    let refused = |nside: u32, quantity: Quantity, cells: &[(u64, f64)]| {
        let panels = vec![LayerPanel { title: "p", quantity, cells }];
        layers(&Layers { title: "", caption: "", nside, is_folded: true, panels }).map(|_| ()).unwrap_err().to_string()
    };
    assert!(refused(0, Quantity::Magnitude, &[(1, 1.0)]).contains("nside is 0; allowed: 1 to 1024"));
    assert!(refused(4, Quantity::Magnitude, &[(192, 1.0)]).contains("is 192; allowed: below 12 nside²"));
    assert!(refused(4, Quantity::Magnitude, &[(191, f64::NAN)]).contains("value 0 (counted from 0) is NaN"));
    assert!(refused(4, Quantity::Count, &[(191, 0.0)]).contains("1 sample or more"));
    assert!(refused(4, Quantity::Spread, &[(191, 0.1), (191, 0.2)]).contains("is given twice; allowed: once"));
    assert!(refused(4, Quantity::Spread, &[]).contains("nothing to draw: no cells"));
    let none = layers(&Layers { title: "", caption: "", nside: 4, is_folded: true, panels: Vec::new() });
    assert!(none.is_err_and(|error| error.to_string().contains("; allowed: ")));
}
