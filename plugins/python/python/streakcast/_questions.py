"""What a model is asked: exposures and targets to verdicts, passes and windows."""

from __future__ import annotations

from typing import Any, Union

import numpy as np
import numpy.typing as npt

from ._answers import VERDICTS, Assessment, ClearWindows
from ._quantities import FloatArray, directions, number, scalar
from ._sights import Sights
from ._tables import TableLike, table_of, time_of, wants_qtable
from ._times import TimeLike, to_tai

#: Which satellites may keep an exposure from being clear.
BLOCKING = ("any", "avoid", "limits")
#: One number, or an array in the shape of the question.
Numbers = Any


class Questions(Sights):
    """The questions of `StreakModel`."""

    def assess(
        self,
        target: Any,
        start: TimeLike,
        exposure: Numbers,
        *,
        rotation: Numbers = 0.0,
        band: Any = None,
        scale: Union[str, None] = None,
    ) -> Assessment:
        """Verdicts as plain numbers: the fast question, once a visit or for a million exposures.

        Parameters
        ----------
        target : `~astropy.coordinates.SkyCoord` or pair
            Centre of the field: any frame, or ``(ra, dec)``, ICRS, degrees or `Quantity`.
        start : time
            Shutter opening.
        exposure : float, array or `~astropy.units.Quantity`
            Length, seconds.
        rotation : float, array or `~astropy.units.Quantity`
            Position angle of the field's y axis, from north through east, degrees.
        band : str or sequence of str, optional
            Band of the exposure, for limits by band: one for all, or one for each.
        scale : {"utc", "tai", "tt"}, optional
            Scale of bare numbers (MJD) in ``start``; the model's ``mjd_scale`` where not said.

        Returns
        -------
        Assessment
            Numbers for one exposure, arrays in the broadcast shape of target, start, exposure and rotation for many.

        Raises
        ------
        TypeError
            A bare number of time without a scale.
        ValueError
            A number that is not finite or out of range, by name and index; shapes that do not fit.
        """
        asked, bands, shape = self._question(target, start, exposure, rotation, band, scale)
        skies, engine = self._open()
        answer, told = engine.judge(asked, bands)
        self._tell(skies, told)
        verdict, streaks = VERDICTS[answer["verdict"]], answer["n_streaks"]
        numbers = (answer["brightest_mag"], answer["lost_fraction"], answer["p_any"], answer["streak_length_deg"])
        is_lower_limit = answer["p_any_is_lower_limit"]
        if shape == ():
            count = int(streaks[0])
            brightest_mag, lost_fraction, p_any, length_deg = (float(one[0]) for one in numbers)
            return Assessment(
                str(verdict[0]), count > 0, count, brightest_mag, lost_fraction, p_any, length_deg, bool(is_lower_limit[0])
            )
        arrays = (verdict, streaks > 0, streaks, *numbers, is_lower_limit)
        return Assessment(*(one.reshape(shape) for one in arrays))

    def flags(
        self,
        target: Any,
        start: TimeLike,
        exposure: Numbers,
        *,
        rotation: Numbers = 0.0,
        band: Any = None,
        scale: Union[str, None] = None,
        output: str = "auto",
    ) -> TableLike:
        """Verdicts with their reasons and the next clear start: what ``streakcast flag`` prints.

        Parameters
        ----------
        target, start, exposure, rotation, band, scale
            As for `assess`.
        output : {"auto", "qtable", "dict"}
            A `~astropy.table.QTable`, or a dictionary of arrays (times as ``datetime64[ns]``, UTC); by itself the first where
            astropy is there.

        Returns
        -------
        QTable or dict of arrays, ``(n_exposures,)`` each
            ``exposure_id`` (place in the question), ``verdict``, ``n_streaks``, ``brightest_mag``, ``expected_lost_pixel_fraction``,
            ``p_any``, ``streak_length_deg``, ``reasons``, ``next_clear_start_utc``, ``delay_s``, ``norad_ids``.
        """
        asked, bands, _ = self._question(target, start, exposure, rotation, band, scale)
        skies, engine = self._open()
        columns, told = engine.flags(asked, bands)
        self._tell(skies, told)
        return table_of(_by_place(columns), output)

    def next_clear_start(
        self,
        target: Any,
        start: TimeLike,
        exposure: Numbers,
        *,
        rotation: Numbers = 0.0,
        scale: Union[str, None] = None,
    ) -> Numbers:
        """How long each exposure has to wait for a clear field.

        Parameters
        ----------
        target, start, exposure, rotation, scale
            As for `assess`. The longest wait is the policy's ``max_delay_s`` (600 s unless it says otherwise), its ``margin_s`` is kept.

        Returns
        -------
        float or array
            Delay, seconds, to the millisecond; 0 where the field is clear at once, NaN where no start in time is clear.
        """
        asked, bands, shape = self._question(target, start, exposure, rotation, None, scale)
        skies, engine = self._open()
        columns, told = engine.flags(asked, bands)
        self._tell(skies, told)
        (delay,) = (column["values"] for column in columns if column["name"] == "delay_s")
        return float(delay[0]) if shape == () else delay.reshape(shape)

    def passes(
        self,
        target: Any,
        start: TimeLike,
        exposure: Numbers,
        *,
        rotation: Numbers = 0.0,
        include_dark: bool = False,
        samples: int = 0,
        scale: Union[str, None] = None,
        output: str = "auto",
    ) -> TableLike:
        """Every satellite that crosses the field in each exposure: what ``streakcast passes`` prints.

        Parameters
        ----------
        target, start, exposure, rotation, scale
            As for `assess`.
        include_dark : bool
            Crossings that are in the Earth's shadow all along too.
        samples : int
            Points along each track, in a column ``samples`` of dictionaries.
        output : {"auto", "qtable", "dict"}
            As for `flags`.

        Returns
        -------
        QTable or dict of arrays, ``(n_passes,)`` each
            ``exposure_id`` is the place in the question; magnitudes with sigma and source, entry and exit, length, width, surface
            brightness, probability, age of the elements, chords.
        """
        asked, _, _ = self._question(target, start, exposure, rotation, None, scale)
        skies, engine = self._open()
        columns, told = engine.passes(asked, include_dark, samples)
        self._tell(skies, told)
        return table_of(_by_place(columns), output)

    def clear_windows(
        self,
        target: Any,
        start: TimeLike,
        end: TimeLike,
        exposure: Numbers,
        *,
        min_altitude: Numbers = 0.0,
        rotation: Numbers = 0.0,
        band: Any = None,
        blocking: str = "any",
        max_sun_altitude: Union[Numbers, None] = None,
        scale: Union[str, None] = None,
        output: str = "auto",
    ) -> ClearWindows:
        """From when to when exposures of a target may start so that they are clear throughout.

        Parameters
        ----------
        target : `~astropy.coordinates.SkyCoord` or pair
            One or many, as for `assess`.
        start, end : time
            No shutter opens before the one or closes after the other, at most a day later.
        exposure : float or `~astropy.units.Quantity`
            Length of the exposure, seconds.
        min_altitude : float or `~astropy.units.Quantity`
            The pointing stands as high while the shutter is open, degrees, without refraction.
        rotation, band, scale
            As for `assess`.
        blocking : {"any", "avoid", "limits"}
            Every lit satellite blocks; or only those that break a limit of magnitude of the policy; or those brighter than a limit, however
            improbable unless the policy says, and every lit one where no limit applies to the band.
        max_sun_altitude : float or `~astropy.units.Quantity`, optional
            The Sun stands no higher while the shutter is open, degrees; day and night where not said.
        output : {"auto", "qtable", "dict"}
            As for `flags`: starts as an astropy `Time`, or as ``datetime64[ns]``, UTC, which is several times faster.

        Returns
        -------
        ClearWindows

        Warns
        -----
        StreakcastWarning
            Satellites were left out because they have no position at that time, or the elements are old.
        """
        if blocking not in BLOCKING:
            raise ValueError(f"blocking '{blocking}'; allowed: {', '.join(BLOCKING)}")
        sun = None if max_sun_altitude is None else scalar(max_sun_altitude, "deg", "max_sun_altitude")
        jd1, jd2 = to_tai(end, self._scale(scale), "end")
        begin1, begin2 = to_tai(start, self._scale(scale), "start")
        span_s = ((jd1 - begin1) + (jd2 - begin2)) * 86_400.0
        if np.any(span_s < 0.0):
            raise ValueError(f"end[{int(np.flatnonzero(np.ravel(span_s) < 0.0)[0])}] is before the start")
        length_s = scalar(exposure, "s", "exposure")
        asked, bands, _ = self._question(target, start, span_s, rotation, band, scale)
        skies, engine = self._open()
        lowest = scalar(min_altitude, "deg", "min_altitude")
        answer, told = engine.clear_windows(asked, bands, length_s, lowest, blocking, sun)
        self._tell(skies, told)
        first, last = answer["first_start"], answer["last_start"]
        length = (last[0] - first[0] + (last[1] - first[1])) * 86_400.0
        if wants_qtable(output):
            return ClearWindows(answer["target"], time_of(*first[:2]), time_of(*last[:2]), length)
        moments = [one[2].view("datetime64[ns]") for one in (first, last)]
        return ClearWindows(answer["target"], moments[0], moments[1], length)

    def check_pointings(
        self,
        pointing_ras: Numbers,
        pointing_decs: Numbers,
        mjds: TimeLike,
        visit_time: Numbers,
        *,
        scale: Union[str, None] = None,
    ) -> tuple[FloatArray, npt.NDArray[np.int64]]:
        """How much streak each pointing has, in the way that users of rubin_sim's satellite constellations know.

        Parameters
        ----------
        pointing_ras, pointing_decs : array, ``(n,)``
            Right ascension and declination of the pointings, ICRS, degrees.
        mjds : array, ``(n,)``
            Start of each visit, MJD. The scale must be said, here or by the model's ``mjd_scale``; times of any other kind as well.
        visit_time : float or array
            Length of a visit, seconds.
        scale : {"utc", "tai", "tt"}, optional
            Scale of ``mjds``.

        Returns
        -------
        lengths_deg : array, ``(n,)``
            Length of all lit streaks in the field of each visit, degrees; 0 for pointings below the horizon, as there (`assess` says NaN).
        n_streaks : array, ``(n,)``
            How many there are.
        """
        answer = self.assess((pointing_ras, pointing_decs), mjds, visit_time, scale=scale)
        return np.nan_to_num(np.atleast_1d(answer.streak_length_deg)), np.atleast_1d(answer.n_streaks)

    def _question(
        self, target: Any, start: TimeLike, exposure: Numbers, rotation: Numbers, band: Any, scale: Union[str, None]
    ) -> tuple[dict[str, FloatArray], list[str], tuple[int, ...]]:
        ra, dec = directions(target)
        jd1, jd2 = to_tai(start, self._scale(scale), "start")
        length, angle = number(exposure, "s", "exposure"), number(rotation, "deg", "rotation")
        names = ("ra_deg", "dec_deg", "jd1", "jd2", "exposure_s", "rotation_deg")
        parts = (ra, dec, jd1, jd2, length, angle)
        try:
            shape = np.broadcast_shapes(*(part.shape for part in parts))
        except ValueError:
            shapes = f"ra {ra.shape}, dec {dec.shape}, start {jd1.shape}, exposure {length.shape}, rotation {angle.shape}"
            raise ValueError(f"shapes that do not fit together: {shapes}") from None
        asked = {
            name: np.ascontiguousarray(np.broadcast_to(part, shape).reshape(-1)) for name, part in zip(names, parts)
        }
        bands = [] if band is None else [band] if isinstance(band, str) else [str(one) for one in np.ravel(band)]
        return asked, bands, shape


def _by_place(columns: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Exposures are called by their places in the question: numbers, not texts."""
    first = columns[0]
    places = np.array([int(text) for text in first["values"]], dtype=np.int64)
    description = "Place of the exposure in the question (flat, from 0)."
    missing = np.zeros(len(places), dtype=bool)
    return [{**first, "kind": "integer", "values": places, "missing": missing, "description": description}, *columns[1:]]
