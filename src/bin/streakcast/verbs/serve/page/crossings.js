// Table of crossings: the columns of SatChecker, and further ones.

import { css } from "./colours.js";
import { hover } from "./hover.js";
import { fixed, known, moment } from "./words.js";

const sigma = (pass) => (pass.magnitude_peak == null ? "–" : `${fixed(pass.magnitude_peak, 2)} ± ${fixed(pass.magnitude_peak_sigma, 2)}`);

/** Returns the time of an event, with the digits that the error of the position along the track allows. */
const at = (pass, name) => known(moment(pass[name]), pass.along_track_sigma_s, 0, 1);

/** Columns on the page: heading, function that returns the text of a cell, and meaning. */
const COLUMNS = [
  ["satellite", null, "Name in the element set; selects the track"],
  ["catalogue number", (pass) => pass.norad_id, "NORAD catalogue number"],
  ["magnitude", sigma, "Brightest magnitude inside the field, with one sigma"],
  ["magnitude from", (pass) => pass.mag_source ?? "–", "Brightness model"],
  ["enters, UTC", (pass) => at(pass, "enter_utc"), "Entry into the field"],
  ["leaves, UTC", (pass) => at(pass, "exit_utc"), "Exit from the field"],
  ["right asc., °", (pass) => fixed(pass.mid_ra_deg, 3), "Right ascension at the middle of the pass, ICRS"],
  ["declin., °", (pass) => fixed(pass.mid_dec_deg, 3), "Declination at the middle of the pass"],
  ["altitude, °", (pass) => fixed(pass.altitude_deg, 1), "Altitude, without refraction"],
  ["azimuth, °", (pass) => fixed(pass.azimuth_deg, 1), "Azimuth from north through east"],
  ["distance, km", (pass) => fixed(pass.range_km, 0), "Distance from the observer"],
  ["from centre, °", (pass) => fixed(pass.min_separation_deg, 2), "Least distance from the field's centre"],
  ["phase angle, °", (pass) => fixed(pass.phase_angle_deg, 0), "Phase angle at the satellite, between Sun and observer"],
  ["speed, °/s", (pass) => fixed(pass.angular_rate_deg_s, 2), "Angular speed"],
  ["light", (pass) => pass.illumination, "Sunlit, in the penumbra, or in the shadow, at the middle of the pass"],
  ["elements' age, days", (pass) => fixed(pass.element_age_days, 1), "Time since the epoch of the element set"],
  ["early or late, s", (pass) => fixed(pass.along_track_sigma_s, 1), "Error of the times, one sigma"],
  ["probability", (pass) => fixed(pass.probability, 2), "Probability that the satellite crosses the field"],
];

/** Columns of the CSV file: name, and function that returns the value. Positions are those of the middle of the pass. */
const FILE = [
  ["name", (pass) => pass.name],
  ["norad_id", (pass) => pass.norad_id],
  ["international_designator", (pass) => pass.international_designator],
  ["julian_date", (pass) => (moment(pass.mid_utc) / 86400e3 + 2440587.5).toFixed(8)],
  ["date_time", (pass) => pass.mid_utc],
  ["enter_utc", (pass) => pass.enter_utc],
  ["exit_utc", (pass) => pass.exit_utc],
  ["ra", (pass) => pass.mid_ra_deg],
  ["dec", (pass) => pass.mid_dec_deg],
  ["altitude_deg", (pass) => pass.altitude_deg],
  ["azimuth_deg", (pass) => pass.azimuth_deg],
  ["range_km", (pass) => pass.range_km],
  ["angle", (pass) => pass.min_separation_deg],
  ["phase_angle_deg", (pass) => pass.phase_angle_deg],
  ["illuminated", (pass) => pass.lit_fraction > 0],
  ["apparent_magnitude", (pass) => pass.magnitude],
  ["apparent_magnitude_uncert", (pass) => pass.magnitude_sigma],
  ["magnitude_peak", (pass) => pass.magnitude_peak],
  ["magnitude_peak_sigma", (pass) => pass.magnitude_peak_sigma],
  ["mag_source", (pass) => pass.mag_source],
  ["epoch_age_days", (pass) => pass.element_age_days],
  ["probability", (pass) => pass.probability],
];

export function heads(row) {
  row.replaceChildren(
    ...COLUMNS.map(([name, , meaning]) => {
      const cell = document.createElement("th");
      cell.scope = "col";
      cell.textContent = name;
      hover(cell, () => meaning);
      return cell;
    }),
  );
}

/** Fills the table, or shows the reason why it is empty; the button in each row selects its track. */
export function rows(body, passes, selected, choose) {
  if (!passes?.length) {
    const cell = document.createElement("td");
    cell.colSpan = COLUMNS.length;
    cell.textContent = passes ? "No lit satellite crosses this exposure." : "No result for this exposure.";
    const row = document.createElement("tr");
    row.append(cell);
    body.replaceChildren(row);
    return;
  }
  // The focus is kept when the rows are replaced.
  const focused = body.contains(document.activeElement) ? document.activeElement.dataset.norad : null;
  body.replaceChildren(
    ...passes.map((pass) => {
      const row = document.createElement("tr");
      row.dataset.norad = pass.norad_id;
      row.dataset.chosen = String(pass.norad_id === selected);
      for (const [name, text] of COLUMNS) {
        const cell = document.createElement("td");
        if (text) cell.textContent = text(pass);
        else {
          const button = document.createElement("button");
          button.type = "button";
          button.textContent = pass.name || String(pass.norad_id);
          button.dataset.norad = pass.norad_id;
          button.setAttribute("aria-pressed", String(pass.norad_id === selected));
          button.addEventListener("click", () => choose(pass.norad_id));
          cell.append(button);
        }
        // The colour of the track; as the colour of the text it would have too little contrast.
        if (name === "magnitude") cell.style.textDecoration = `underline 2px ${css(pass.magnitude_peak)}`;
        row.append(cell);
      }
      return row;
    }),
  );
  if (focused) body.querySelector(`button[data-norad="${CSS.escape(focused)}"]`)?.focus();
}

/** Returns the crossings as CSV. */
export function csv(passes) {
  const cell = (value) => {
    const text = value == null ? "" : String(value);
    return /[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
  };
  const lines = passes.map((pass) => FILE.map(([, value]) => cell(value(pass))).join(","));
  return [FILE.map(([name]) => name).join(","), ...lines].join("\n") + "\n";
}
