"""Methods of `StreakModel` that need no field of view: forecasts, ephemerides, overhead, identify."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from typing import Callable

import numpy as np
from numpy.typing import ArrayLike

from . import _core
from ._frames import Files, as_files
from ._results import Forecast, Identification, Overhead
from ._quantities import count, finite_scalar, number, scalar
from ._state import ModelState
from ._streak import streak_request
from ._streak_tables import streak_files
from ._tables import CANDIDATES, CANDIDATES_OF_TABLE, EPHEMERIS, FORECAST, NIGHTS, STREAK, STREAKS_OF_TABLE, table_of
from ._times import is_time, to_tai
from ._warnings import warn_of_frames
from .typing import (
    EndsLike,
    FloatArrayLike,
    FloatLike,
    FrameLike,
    HeaderLike,
    Json,
    NightLike,
    Output,
    PathLike,
    StreaksLike,
    Table,
    TargetLike,
    TextLike,
    TimeLike,
    WholeLike,
)


class SiteQueries(ModelState):
    """Methods of `StreakModel` that need no field of view."""

    def forecast(
        self,
        night: NightLike | None = None,
        *,
        start: TimeLike | None = None,
        end: TimeLike | None = None,
        max_mag: FloatLike | None = None,
        min_p_brighter: FloatLike = 0.5,
        atmosphere: bool = True,
        sort: str | None = None,
        min_altitude: FloatLike = 10.0,
        min_culmination: FloatLike = 0.0,
        max_sun_altitude: FloatLike | None = -6.0,
        generation: TextLike | None = None,
        name: TextLike | None = None,
        norad: WholeLike | None = None,
        include_dark: bool | None = None,
        samples: int | None = None,
        scale: str | None = None,
        output: Output = "auto",
    ) -> Forecast:
        """Returns the visible passes of one or several nights, as printed by ``streakcast forecast``.

        Element sets are selected, and simulated constellations are generated, for the requested time, as on the command
        line.

        Parameters
        ----------
        night : str, date, or sequence of these
            Local date of the evening at the site, for example ``"2026-08-14"``. A night lasts from local mean noon to
            the next noon. Several nights are computed one after the other.
        start, end : time
            Time range instead of a night, at most 31 days.
        max_mag : float or `~astropy.units.Quantity`, optional
            Omits passes that are probably fainter, and passes without a magnitude. It adds the column ``p_brighter``,
            the probability of being brighter at some visible point.
        min_p_brighter : float
            Smallest probability of being brighter than ``max_mag``; with 0 all passes are listed.
        atmosphere : bool
            Whether magnitudes include extinction, that of the model's configuration or else of clear air, and the limit
            is brighter in twilight.
        sort : {"time", "brightness"}, optional
            Order of the passes of a night: by time, or the most probably visible first (default with ``max_mag``).
        min_altitude : float or `~astropy.units.Quantity`
            Altitude at which a satellite rises and sets, degrees, without refraction; 0 to below 90.
        min_culmination : float or `~astropy.units.Quantity`
            Omits passes that culminate below this altitude, degrees.
        max_sun_altitude : float or `~astropy.units.Quantity`, optional
            Highest altitude of the Sun at the site, degrees; `None` for no limit.
        generation, name, norad : str, int, or sequences of these, optional
            Only satellites of these generations (``"starlink-v2mini"``), with these parts of names, or catalogue
            numbers.
        include_dark : bool, optional
            Whether to include passes in the Earth's shadow and in daylight; default: that of the
            configuration file, or else `False`.
        samples : int, optional
            Number of points along each pass from rise to set, in a column ``samples`` of dictionaries; 0 to 10,000;
            default: that of the configuration file, or else 0.
        scale : {"utc", "tai", "tt"}, optional
            Scale of bare numbers in ``start`` and ``end``.
        output : {"auto", "qtable", "dict"}
            As for `flag`.

        Returns
        -------
        Forecast

        Raises
        ------
        StreakcastError
            A date is invalid, a number is out of range, no satellite is selected, or the telescope is in orbit.
        TypeError
            A number is given as time without a scale.

        Warns
        -----
        StreakcastWarning
            Number of passes of satellites with only a default brightness model; omitted satellites; old element sets.
        """
        options: dict[str, Json] = dict(
            max_mag=None if max_mag is None else finite_scalar(max_mag, "mag", "max_mag"),
            min_p_brighter=finite_scalar(min_p_brighter, "", "min_p_brighter"),
            no_atmosphere=not atmosphere, sort=sort,
            min_altitude=finite_scalar(min_altitude, "deg", "min_altitude"),
            min_culmination=finite_scalar(min_culmination, "deg", "min_culmination"),
            sun_altitude_deg=None if max_sun_altitude is None else finite_scalar(max_sun_altitude, "deg", "max_sun_altitude"),
            generation=_texts(generation, "generation"), name=_texts(name, "name"), norad=_norad_ids(norad),
            include_dark=None if include_dark is None else bool(include_dark), samples=None if samples is None else count(samples, "samples", 0),
        )  # fmt: skip
        if (start is None) != (end is None):
            raise ValueError("start and end require each other; specify both or neither")
        if (night is None) == (start is None):
            raise ValueError("night and start are both given or both missing; specify night, or start and end")
        if night is not None:
            times = [{"night": date} for date in _dates(night)]
        else:
            given = [time for time in (start, end) if time is not None]
            times = [dict(zip(("start", "end"), (_core.utc_text(*self._moment(time, scale)) for time in given)))]
        result = _core.forecast([json.dumps({**options, **time}) for time in times], self._engine)
        self._warn_once(result["warnings"])
        return Forecast(table_of(result["passes"], output, main=FORECAST), table_of(result["nights"], output, main=NIGHTS))

    def overhead(
        self,
        start: TimeLike,
        seconds: FloatArrayLike = 0.0,
        *,
        min_altitude: FloatLike = 10.0,
        include_dark: bool | None = None,
        light: bool = True,
        possible: bool = False,
        limit_mag: FloatArrayLike = (),
        band: str | None = None,
        scale: str | None = None,
    ) -> Overhead:
        """Returns all satellites above the site at one or several times, for example for sky maps.

        Parameters
        ----------
        start : time
            Reference time.
        seconds : float, array, ``(n_moments,)``, or `~astropy.units.Quantity`
            Times in seconds after ``start``: 0 to 3600, ascending.
        min_altitude : float or `~astropy.units.Quantity`
            Smallest altitude, degrees, without refraction, 0 to 90.
        include_dark : bool, optional
            Whether satellites in the Earth's shadow are included; default: that of the
            configuration file, or else `False`.
        light : bool
            Whether magnitudes are computed; for models made of panels this takes some microseconds per satellite.
        possible : bool
            Whether a satellite whose time is uncertain by more than a second (standard deviation) is given at several
            possible positions along its track, one sigma apart, with their probabilities. They differ from time to time,
            so that sums over many times represent all delays.
        limit_mag : float, array or `~astropy.units.Quantity`, ``(n_limits,)``
            Magnitude limits for the probabilities ``p_brighter``; they require ``light``.
        band : str, optional
            Band of the exposures, which selects the ``bright_mag`` of the telescope for ``q_bright``.
        scale : {"utc", "tai", "tt"}, optional
            Scale of a bare number (MJD) in ``start``.

        Returns
        -------
        Overhead

        Raises
        ------
        StreakcastError
            Times or an altitude are out of range, or the telescope is in orbit.
        ValueError
            Magnitude limits are given with ``light=False``.
        TypeError
            A number is given as time without a scale.

        Warns
        -----
        StreakcastWarning
            Satellites were omitted because their position cannot be computed at that time, or the element sets are old.
        """
        jd1, jd2 = self._moment(start, scale)
        moments = np.atleast_1d(number(seconds, "s", "seconds"))
        lowest = scalar(min_altitude, "deg", "min_altitude")
        limits = [float(limit) for limit in np.ravel(number(limit_mag, "mag", "limit_mag"))]
        if limits and not light:
            raise ValueError("limit_mag is given with light=False; allowed: with light=True")
        is_dark = None if include_dark is None else bool(include_dark)
        result, warnings = self._engine.overhead(jd1, jd2, moments.ravel().tolist(), lowest, is_dark, bool(light), bool(possible), limits, band)
        self._warn_once(warnings)
        return Overhead(**result)

    def ephemeris(
        self,
        times: TimeLike,
        *,
        norad: WholeLike | None = None,
        name: TextLike | None = None,
        generation: TextLike | None = None,
        min_altitude: FloatLike | None = None,
        scale: str | None = None,
        output: Output = "auto",
    ) -> Table:
        """Returns the positions of satellites at given times, as printed by ``streakcast ephemeris``.

        The element set of each satellite that is closest to the middle of the times is used, as on the command line.

        Parameters
        ----------
        times : time or array of times, any shape
            Times of reception, in any order.
        norad, name, generation : int, str, or sequences of these
            Catalogue numbers, parts of names, or generations (``"starlink-v2mini"``); at least one of them is required.
        min_altitude : float or `~astropy.units.Quantity`, optional
            Omits positions below this altitude, degrees, without refraction; default: none is omitted.
        scale : {"utc", "tai", "tt"}, optional
            Scale of bare numbers in ``times``.
        output : {"auto", "qtable", "dict"}
            As for `flag`.

        Returns
        -------
        QTable or dict of arrays, ``(n_places,)`` each
            One row per satellite and time, grouped by satellite: ICRS astrometric right ascension and declination with
            rates, altitude and azimuth with rates, range and range rate, elongation, phase angle, illumination,
            magnitude with sigma and source, age of the element set, and errors along the track
            (``along_track_sigma_s``, half width that contains 68 % of the delays) and across it. ``position_source`` is
            ``element set``, or ``ephemeris`` and the file name.

        Raises
        ------
        StreakcastError
            There is no satellite with this number, name or generation, or there are more than a million positions.
        ValueError
            No satellites are selected.
        TypeError
            A number is given as time without a scale.

        Warns
        -----
        StreakcastWarning
            Catalogue numbers without an element set; omitted satellites; old element sets.
        """
        request: dict[str, Json] = dict(
            norad=_norad_ids(norad), name=_texts(name, "name"), generation=_texts(generation, "generation"),
        )  # fmt: skip
        if not any(request.values()):
            raise ValueError("norad, name and generation are missing; allowed: at least one of them")
        if min_altitude is not None:
            request["min_altitude"] = finite_scalar(min_altitude, "deg", "min_altitude")
        jd1, jd2 = to_tai(times, self._scale(scale), "times")
        if np.size(jd1) == 0:
            raise ValueError("times is empty; allowed: one time or several")
        request["times"] = [_core.utc_text(*parts) for parts in zip(np.ravel(jd1).tolist(), np.ravel(jd2).tolist())]
        table, warnings = _core.ephemeris(json.dumps(request), self._engine)
        self._warn_once(warnings)
        return table_of(table, output, main=EPHEMERIS)

    def identify(
        self,
        ends: EndsLike | None = None,
        times: TimeLike | None = None,
        *,
        place: TargetLike | None = None,
        position_angle: FloatLike | None = None,
        length: FloatLike | None = None,
        frame: FrameLike | None = None,
        header: HeaderLike | None = None,
        pixels: ArrayLike | None = None,
        origin: int = 1,
        hdu: int | None = None,
        region: PathLike | None = None,
        streaks: StreaksLike | Sequence[PathLike] | None = None,
        start: TimeLike | None = None,
        exposure: FloatLike | None = None,
        whole_streak: bool = False,
        place_sigma: FloatLike | None = None,
        time_sigma: FloatLike | None = None,
        angle_sigma: FloatLike | None = None,
        include_dark: bool | None = None,
        top: int = 10,
        scale: str | None = None,
        output: Output = "auto",
    ) -> Identification:
        """Returns the candidate satellites for a measured streak, or for those of a table, as printed by
        ``streakcast identify``.

        The streak is specified in one of five ways: ``ends`` (with ``times``, or in an exposure), ``place`` with
        ``position_angle``, ``pixels`` of a ``frame``, a ``region``, or the rows of ``streaks``. Element sets are selected
        for that time, as on the command line.

        Parameters
        ----------
        ends : `~astropy.coordinates.SkyCoord` of two, or two pairs
            Both ends: any frame, or ``((ra, dec), (ra, dec))``, ICRS, degrees or `Quantity`.
        times : two times
            Times at the first and, later, at the second end; they determine the direction of motion.
        place : `~astropy.coordinates.SkyCoord` or pair
            Midpoint of the streak.
        position_angle : float or `~astropy.units.Quantity`
            Position angle of the streak at the midpoint, in either direction, from north through east, degrees.
        length : float or `~astropy.units.Quantity`, optional
            Length of the whole streak, degrees; used with ``place``.
        frame : path, array, `~astropy.nddata.NDData`, `~astropy.io.fits.HDUList` or HDU
            FITS file or frame in memory, as for `streakcast.inject`, that contains the streak, with world coordinates
            and, if they are not given, the exposure times (also for ``region`` and ``ends``).
        header : `~astropy.io.fits.Header`, `~astropy.wcs.WCS`, dict or str, optional
            World coordinates of an array and the other keywords of its header; required for an array.
        pixels : two pairs
            Both ends in the frame, ``((x, y), (x, y))``.
        origin : {0, 1}
            Index of the first pixel in ``pixels``: 1 as in FITS and DS9, 0 as in arrays. Not used for ``streaks``, whose
            pixels are counted from 1, or from 0 in tables of ASTRiDE and findsat_mrt.
        hdu : int, optional
            HDU of the frame, or of the frames of ``streaks``, from 0; default: the only image.
        region : path
            File of DS9 regions drawn around the streak: polygons, boxes, lines or vectors in fk5 or icrs.
        streaks : path or list of paths, `~astropy.table.Table`, dict of columns, or list of dicts
            Tables of streaks of any number of frames, as for `measure`: ends in pixels or on the sky, ``streaks.txt`` of
            ASTRiDE, a catalog of ``acstools.findsat_mrt``, or regions of DS9. The frame of a row is its column ``image`` (a
            path relative to the folder of the table; for a table in memory to the current folder), or else ``frame``.
            Rows that cannot be used are left out, with a warning.
        start : time, optional
            Shutter opening.
        exposure : float or `~astropy.units.Quantity`, optional
            Length of the exposure, seconds.
        whole_streak : bool
            Whether both ends are positions of the satellite at shutter opening and closing, inside the frame.
        place_sigma : float or `~astropy.units.Quantity`, optional
            Standard deviation of the position of an end, arcsec; default 5, 3 pixels in a frame, or a quarter of the
            width of a region.
        time_sigma : float or `~astropy.units.Quantity`, optional
            Standard deviation of the clock error, seconds; default 0.5.
        angle_sigma : float or `~astropy.units.Quantity`, optional
            Standard deviation of ``position_angle``, degrees; default 1.
        include_dark : bool, optional
            Whether satellites in the Earth's shadow are included; default: that of the
            configuration file, or else `False`.
        top : int
            Largest number of listed candidates.
        scale : {"utc", "tai", "tt"}, optional
            Scale of bare numbers as times.
        output : {"auto", "qtable", "dict"}
            As for `flag`.

        Returns
        -------
        Identification

        Raises
        ------
        StreakcastError
            The streak is invalid: identical ends, pixels outside the frame, below the horizon, or an invalid file.
        ValueError
            None or more than one of the five ways is used.
        TypeError
            A number is given as time without a scale.

        Warns
        -----
        StreakcastWarning
            Rows of ``streaks`` are left out, satellites are omitted, or element sets are old.
        """
        scale = self._scale(scale)
        if frame is None and header is not None:
            raise ValueError("header is given without frame; allowed: with an array as frame")
        with streak_files(streaks) as tables, as_files([] if frame is None else [frame], header) as files:
            request = streak_request(
                ends=ends, times=times, place=place, position_angle=position_angle, length=length,
                frame=files.paths[0] if files.paths else None, pixels=pixels,
                origin=origin, hdu=hdu, region=region, streaks=streaks, start=start, exposure=exposure, whole_streak=whole_streak,
                place_sigma=place_sigma, time_sigma=time_sigma, angle_sigma=angle_sigma, scale=scale,
            )  # fmt: skip
            listed = count(top, "top", 1)
            is_dark = None if include_dark is None else bool(include_dark)
            if streaks is not None:
                if not hasattr(_core, "identify_streaks"):
                    raise NotImplementedError("streaks are not in this build: they need CFITSIO, which does not build on Windows")
                found = _core.identify_streaks(json.dumps(request), tables.paths, tables.image_folder, self._engine, is_dark, listed)
                return self._identified(found, lambda text: files.shown(tables.shown(text)), files, output)
            result = _core.identify(json.dumps(request), self._engine, is_dark, listed)
        warn_of_frames([*files.remarks, *(files.shown(remark) for remark in result["remarks"])])
        self._warn_once(result["warnings"])
        return Identification(
            table_of(result["candidates"], output, main=CANDIDATES),
            table_of(result["streak"], output, main=STREAK),
            result["n_candidates"],
            result["unknown_probability"],
        )

    def _identified(
        self, found: _core.IdentifiedStreaks, shown: Callable[[str], str], files: Files, output: Output
    ) -> Identification:
        """Returns the candidates of the streaks of tables, and issues the warnings."""
        warn_of_frames(shown(message) for message in found["row_warnings"])
        self._warn_once([shown(message) for message in found["warnings"]])
        values = {
            column["name"]: column["values"] for column in found["streak"] if column["kind"] == "integer" or column["kind"] == "real"
        }
        return Identification(
            table_of(files.named(found["candidates"]), output, main=CANDIDATES_OF_TABLE),
            table_of(files.named(found["streak"]), output, main=STREAKS_OF_TABLE),
            np.array(values["candidates"], dtype=np.int64),
            np.array(values["unknown_probability"], dtype=np.float64),
            tuple(shown(remark) for remark in found["remarks"]),
        )


def _texts(value: TextLike | None, what: str) -> list[Json]:
    """Returns one or several strings as a list; empty for `None`."""
    if value is None:
        return []
    items = [value] if isinstance(value, str) else list(np.ravel(value)) if np.ndim(value) else [value]
    if not all(isinstance(item, str) for item in items):
        raise TypeError(f"{what} is {value!r}; allowed: a string, or several")
    return [str(item) for item in items]


def _norad_ids(value: WholeLike | None) -> list[Json]:
    """Returns one or several catalogue numbers as a list; empty for `None`."""
    numbers: list[Json] = []
    for one in [] if value is None else np.ravel(value).tolist():
        number = count(one, "norad", 1)
        if number > 999_999_999:
            raise ValueError(f"norad is {number}; allowed: NORAD catalogue numbers, 1 to 999999999")
        numbers.append(number)
    return numbers


def _dates(night: NightLike) -> list[str]:
    """Returns one or several dates as strings. A `Time` is a moment, which does not state a local date."""
    if is_time(night):
        raise TypeError("night is a Time; allowed: local dates of evenings, for example '2026-08-14', or start and end")
    nights = [night] if isinstance(night, str) or not isinstance(night, Iterable) else night
    dates = [str(date) for date in nights]
    if not dates:
        raise ValueError("night is empty; allowed: one date or several")
    return dates
