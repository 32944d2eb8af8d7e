//! Parts of the solar array that the chassis shades and hides: figure 1 of Lu (2024).

use nalgebra::Vector3;
use plotters::prelude::RGBColor;
use plotters::style::Color;
use plotters::style::text_anchor::HPos;

use super::axes::{Axis, Frame};
use super::numbers::fixed;
use super::picture::{INK, Picture};
use crate::error::Error;
use crate::photometry::{ChassisAndSail, SatelliteShape};

const SAIL: RGBColor = RGBColor(222, 235, 247);
const SHADED: RGBColor = RGBColor(230, 159, 0);
const HIDDEN: RGBColor = RGBColor(0, 114, 178);
/// Scale, pixels per metre.
const PER_M: f64 = 62.0;

/// Draws the front of the solar array with the part that the chassis shades, the part that it hides from the observer,
/// and the corner (x_p, y_p) of eqs. 16 and 17 of the paper. The angles, in radians, are the latitude of the Sun, and
/// the longitude and latitude of the observer, which must be below the chassis and in front of the array.
///
/// # Errors
/// The sizes are invalid.
pub fn blocking_picture(
    shape: &SatelliteShape,
    sun_latitude_rad: f64,
    [observer_longitude_rad, observer_latitude_rad]: [f64; 2],
) -> Result<Picture, Error> {
    let out =
        || Error::invalid("sizes of the panels", format!("{shape:?}"), "positive lengths and an offset within 90 deg");
    let panels = ChassisAndSail::new(shape).ok_or_else(out)?;
    let direction = |longitude: f64, latitude: f64| {
        let (sin, cos) = latitude.sin_cos();
        Vector3::new(cos * longitude.cos(), cos * longitude.sin(), sin)
    };
    let sun = direction(0.0, sun_latitude_rad);
    let observer = direction(observer_longitude_rad, observer_latitude_rad);
    let blocked = panels.blocked(&sun, &observer);
    let (sin_offset, cos_offset) = shape.panel_offset_deg.to_radians().sin_cos();
    // h = l_base (-w_z) / (n · w) for a direction w below the chassis and in front of the array
    let height_m = |x: f64, z: f64| {
        let facing = cos_offset * x + sin_offset * z;
        if z < 0.0 && facing > 0.0 { shape.base_length_m * -z / facing } else { 0.0 }
    };
    let (shade_m, y_p) = (height_m(sun.x, sun.z), height_m(observer.x, observer.z));
    // The ray from (u, v) meets the plane of the chassis at y = u + v cos POA w_y / (-w_z), with the panel offset angle
    // POA.
    let x_p = -y_p * cos_offset * observer.y / -observer.z;
    let (sail_m, half_m) = (shape.sail_length_m, 0.5 * shape.sail_width_m);
    let half_base_m = 0.5 * shape.base_width_m;
    let frame = Frame {
        sides: [90.0, 60.0, 90.0 + 5.0 * PER_M, 60.0 + (sail_m + 0.6) * PER_M],
        x: Axis::linear(-2.5, 2.5),
        y: Axis::linear(-0.3, sail_m + 0.3),
    };
    let height = frame.sides[3] as usize + 190;
    let mut picture = Picture::new(860, height);
    picture.text("Front of the solar array, blocked by the chassis", (430.0, 28.0), 22.0, HPos::Center);
    let on = |points: &[(f64, f64)]| points.iter().map(|&(u, v)| frame.at(u, v)).collect::<Vec<_>>();
    let upright = |half_m: f64, top_m: f64| [(-half_m, 0.0), (half_m, 0.0), (half_m, top_m), (-half_m, top_m)];
    picture.patch(on(&upright(half_m, sail_m)), SAIL.to_rgba());
    picture.patch(on(&upright(half_m.min(half_base_m), shade_m.min(sail_m))), SHADED.mix(0.55));
    // The hidden part is cut to the array: at each height it is an interval of the width of the chassis.
    let top_m = y_p.min(sail_m);
    let steps = 200;
    let edge = |side: f64| {
        move |step: i32| {
            let v = top_m * f64::from(step) / f64::from(steps);
            let shift = if y_p > 0.0 { x_p * v / y_p } else { 0.0 };
            ((side * half_base_m + shift).clamp(-half_m, half_m), v)
        }
    };
    let outline: Vec<_> = (0..=steps).map(edge(-1.0)).chain((0..=steps).rev().map(edge(1.0))).collect();
    picture.patch(on(&outline), HIDDEN.mix(0.45));
    let border = upright(half_m, sail_m);
    picture.line(&on(&[border[0], border[1], border[2], border[3], border[0]]), INK.to_rgba(), 1.6);
    picture.line(&on(&[(-half_base_m, 0.0), (half_base_m, 0.0)]), INK.to_rgba(), 5.0);
    picture.dashed(&on(&[(0.0, 0.0), (x_p, y_p)]), [6.0, 4.0], INK.to_rgba(), 1.4);
    picture.circle(frame.at(x_p, y_p), 4.0, INK.to_rgba(), 2.0);
    let (x, y) = frame.at(x_p, y_p);
    picture.text("(x_p, y_p)", (x + 10.0, y - 12.0), 17.0, HPos::Left);
    frame.draw(&mut picture, [true, true]);
    frame.name_x(&mut picture, "along the hinge, m");
    frame.name_y(&mut picture, "from the hinge, m", 52.0);
    let deg = |angle: f64| fixed(angle.to_degrees(), 0);
    let text = [
        (Some(SHADED.mix(0.55)), format!("shaded: h = {} m, BF' = {}", fixed(shade_m, 2), fixed(blocked.shadow, 3))),
        (
            Some(HIDDEN.mix(0.45)),
            format!("hidden from the observer: x_p = {} m, y_p = {} m", fixed(x_p, 2), fixed(y_p, 2)),
        ),
        (None, format!("shaded or hidden: BF = {}", fixed(blocked.shadow_or_hidden, 3))),
        (None, format!("Sun at latitude {}°", deg(sun_latitude_rad))),
        (None, format!("observer at latitude {}°,", deg(observer_latitude_rad))),
        (None, format!("  {}° from the Sun", deg(observer_longitude_rad))),
        (None, format!("panel offset {}°", fixed(shape.panel_offset_deg, 1))),
    ];
    for (line, (colour, text)) in text.iter().enumerate() {
        let y = 90.0 + 30.0 * line as f64;
        if let Some(colour) = colour {
            picture.rectangle([430.0, y - 9.0, 448.0, y + 9.0], *colour);
        }
        picture.text(text, (458.0, y), 16.0, HPos::Left);
    }
    // y_p = l_base √((1 - l cos δ cos α)² + l² sin² δ); the paper prints δ_sun in the last term.
    let (sin_obs, flat) = (-observer.z, observer.x);
    let l = cos_offset / (flat * cos_offset - sin_obs * sin_offset);
    let printed_m = shape.base_length_m * (1.0 - l * flat).hypot(l * sun_latitude_rad.sin());
    let caption = format!(
        "After figure 1 of Lu (2024). Eq. 17 of the paper prints the Sun's latitude instead of the \
         observer's; with it y_p would be {} m.",
        fixed(printed_m, 2)
    );
    picture.paragraph(&caption, [30.0, 830.0], frame.sides[3] + 76.0, 17.0);
    Ok(picture)
}
