"""What a model is asked without a field: the passes of nights, and whose streak one is."""

from __future__ import annotations

import json
import operator
from collections.abc import Iterable
from typing import Any, Union

import numpy as np

from . import _core
from ._answers import Forecast, Identification, Overhead
from ._quantities import number, scalar
from ._state import ModelState
from ._streak import streak
from ._tables import TableLike, table_of
from ._times import TimeLike

#: One number, with or without its unit.
Numbers = Any


class Sights(ModelState):
    """The questions of `StreakModel` that need no field of view."""

    def forecast(
        self,
        night: Any = None,
        *,
        start: Union[TimeLike, None] = None,
        end: Union[TimeLike, None] = None,
        max_mag: Union[float, None] = None,
        min_altitude: Numbers = 10.0,
        min_culmination: Numbers = 0.0,
        max_sun_altitude: Union[Numbers, None] = -6.0,
        generation: Any = None,
        name: Any = None,
        norad: Any = None,
        include_dark: bool = False,
        samples: int = 0,
        scale: Union[str, None] = None,
        output: str = "auto",
    ) -> Forecast:
        """Every pass that can be seen in a night, with its peak magnitude: what ``streakcast forecast`` prints.

        Elements are chosen, and shells laid out, for the time asked about, as the command line does it.

        Parameters
        ----------
        night : str, date, or sequence of these
            The evening's local date at the site, as ``"2026-08-14"``: from local mean noon to noon. Several are asked one after the other.
        start, end : time
            Instead of a night: from when to when, at most 31 days.
        max_mag : float, optional
            Passes whose peak is fainter are left out, those without a magnitude too.
        min_altitude : float or `~astropy.units.Quantity`
            What rise and set are counted from, degrees, without refraction; 0 to below 90.
        min_culmination : float or `~astropy.units.Quantity`
            Passes that culminate lower are left out, degrees.
        max_sun_altitude : float or `~astropy.units.Quantity`, optional
            The Sun is lower than this at the site, degrees; `None` for day and night.
        generation, name, norad : str, int, or sequences of these, optional
            Satellites of these kinds (``"starlink-v2mini"``), with these parts of names, of these catalogue numbers alone.
        include_dark : bool
            Passes in the Earth's shadow and by daylight too.
        samples : int
            Points along each pass from rise to set, in a column ``samples`` of dictionaries; 0 to 10,000.
        scale : {"utc", "tai", "tt"}, optional
            Scale of bare numbers in ``start`` and ``end``.
        output : {"auto", "qtable", "dict"}
            As for `flags`.

        Returns
        -------
        Forecast

        Raises
        ------
        StreakcastError
            A night that is no date, a number out of range, nobody of that kind or name, a telescope in orbit.
        TypeError
            A bare number of time without a scale.

        Warns
        -----
        StreakcastWarning
            How many passes rest on a prior alone, for nothing is known of the satellite's brightness; satellites left out; old elements.
        """
        said: dict[str, Any] = dict(
            max_mag=None if max_mag is None else scalar(max_mag, "mag", "max_mag"),
            min_altitude=scalar(min_altitude, "deg", "min_altitude"),
            min_culmination=scalar(min_culmination, "deg", "min_culmination"),
            sun_altitude_deg=None if max_sun_altitude is None else scalar(max_sun_altitude, "deg", "max_sun_altitude"),
            generation=_texts(generation, "generation"), name=_texts(name, "name"), norad=_norad_ids(norad),
            include_dark=bool(include_dark), samples=_count(samples, "samples", 0),
        )  # fmt: skip
        for what, value in said.items():
            if isinstance(value, float) and not np.isfinite(value):
                raise ValueError(f"{what} is {value}; allowed: numbers")
        if (start is None) != (end is None):
            raise ValueError("start and end belong together; say both or neither")
        if (night is None) == (start is None):
            raise ValueError("say a night, or start and end")
        if start is None:
            times = [{"night": date} for date in _dates(night)]
        else:
            moments = [_core.utc_text(*self._moment(time, scale)) for time in (start, end)]
            times = [dict(zip(("start", "end"), moments))]
        skies, _ = self._open()
        setup, config = json.dumps(self._state["setup"]), self._state["config"]
        answer = _core.forecast([json.dumps({**said, **time}) for time in times], setup, config, skies)
        self._tell(skies, answer["warnings"])
        return Forecast(table_of(answer["passes"], output), table_of(answer["nights"], output))

    def visible_passes(
        self,
        start: TimeLike,
        end: TimeLike,
        *,
        min_altitude: Numbers = 10.0,
        lit_only: bool = True,
        scale: Union[str, None] = None,
        output: str = "auto",
    ) -> TableLike:
        """The passes of `forecast` between two moments, by day and by night: another name for it, kept for what was written with it.

        Parameters
        ----------
        start, end, min_altitude, scale, output
            As for `forecast`.
        lit_only : bool
            False for passes in the Earth's shadow too.

        Returns
        -------
        QTable or dict of arrays, ``(n_passes,)`` each
            ``forecast(start=start, end=end, max_sun_altitude=None, include_dark=not lit_only).passes``
        """
        answer = self.forecast(
            start=start, end=end, min_altitude=min_altitude, max_sun_altitude=None, include_dark=not lit_only, scale=scale,
            output=output,
        )  # fmt: skip
        return answer.passes

    def overhead(
        self,
        start: TimeLike,
        seconds: Numbers = 0.0,
        *,
        min_altitude: Numbers = 10.0,
        include_dark: bool = False,
        light: bool = True,
        scale: Union[str, None] = None,
    ) -> Overhead:
        """Every satellite above the site at one or several moments: what maps of the sky are made of.

        Parameters
        ----------
        start : time
            The first moment.
        seconds : float, array, ``(n_moments,)``, or `~astropy.units.Quantity`
            The moments, seconds after ``start``: 0 to 3600, in the order of time.
        min_altitude : float or `~astropy.units.Quantity`
            Degrees, without refraction, 0 to 90.
        include_dark : bool
            Satellites in the Earth's shadow too.
        light : bool
            Whether magnitudes are asked for; models of panels take some microseconds each.
        scale : {"utc", "tai", "tt"}, optional
            Scale of a bare number (MJD) in ``start``.

        Returns
        -------
        Overhead

        Raises
        ------
        StreakcastError
            Moments or an altitude out of range, a telescope in orbit.
        TypeError
            A bare number of time without a scale.

        Warns
        -----
        StreakcastWarning
            Satellites were left out because they have no position at that time, or the elements are old.
        """
        jd1, jd2 = self._moment(start, scale)
        moments = np.atleast_1d(number(seconds, "s", "seconds"))
        lowest = scalar(min_altitude, "deg", "min_altitude")
        skies, engine = self._open()
        answer, told = engine.overhead(jd1, jd2, moments.ravel().tolist(), lowest, bool(include_dark), bool(light))
        self._tell(skies, told)
        return Overhead(**answer)

    def identify(
        self,
        ends: Any = None,
        times: Any = None,
        *,
        place: Any = None,
        position_angle: Union[Numbers, None] = None,
        length: Union[Numbers, None] = None,
        frame: Any = None,
        pixels: Any = None,
        origin: int = 1,
        hdu: Union[int, None] = None,
        region: Any = None,
        start: Union[TimeLike, None] = None,
        exposure: Union[Numbers, None] = None,
        whole_streak: bool = False,
        place_sigma: Union[Numbers, None] = None,
        time_sigma: Union[Numbers, None] = None,
        angle_sigma: Union[Numbers, None] = None,
        include_dark: bool = False,
        top: int = 10,
        scale: Union[str, None] = None,
        output: str = "auto",
    ) -> Identification:
        """Which satellite a measured streak is of, ranked: what ``streakcast identify`` prints.

        The streak is said in one of four ways: ``ends`` (with ``times``, or in an exposure), ``place`` with ``position_angle``, ``pixels``
        of a ``frame``, or a ``region``. Elements are chosen for that time, as the command line does it.

        Parameters
        ----------
        ends : `~astropy.coordinates.SkyCoord` of two, or two pairs
            Both ends: any frame, or ``((ra, dec), (ra, dec))``, ICRS, degrees or `Quantity`.
        times : two times
            When the satellite was at the first end and, later, at the second: the direction of motion is known.
        place : `~astropy.coordinates.SkyCoord` or pair
            The middle of the streak.
        position_angle : float or `~astropy.units.Quantity`
            Of the line there, in either of its directions, from north through east, degrees.
        length : float or `~astropy.units.Quantity`, optional
            Of the whole streak, degrees, with ``place``.
        frame : path
            A FITS file with the streak: its coordinates, and its times where none are said (for ``region`` and ``ends`` too).
        pixels : two pairs
            Both ends in the frame, ``((x, y), (x, y))``.
        origin : {0, 1}
            What the first pixel is called in ``pixels``: 1 as FITS and DS9 count, 0 as arrays do.
        hdu : int, optional
            HDU of the frame, from 0; the only image where not said.
        region : path
            Regions of DS9 drawn around the streak: polygons, boxes, lines or vectors in fk5 or icrs.
        start : time, optional
            Shutter opening.
        exposure : float or `~astropy.units.Quantity`, optional
            Length of the exposure, seconds.
        whole_streak : bool
            Both ends are those of the streak, not of the frame: where the satellite was as the shutter opened and closed.
        place_sigma : float or `~astropy.units.Quantity`, optional
            One sigma of an end, arcsec; 5 where not said, 3 pixels in a frame, half the half width of regions.
        time_sigma : float or `~astropy.units.Quantity`, optional
            One sigma of the clock, seconds; 0.5 where not said.
        angle_sigma : float or `~astropy.units.Quantity`, optional
            One sigma of ``position_angle``, degrees; 1 where not said.
        include_dark : bool
            Satellites in the Earth's shadow too.
        top : int
            The most candidates that are listed.
        scale : {"utc", "tai", "tt"}, optional
            Scale of bare numbers of time.
        output : {"auto", "qtable", "dict"}
            As for `flags`.

        Returns
        -------
        Identification

        Raises
        ------
        StreakcastError
            What is no streak, and what is allowed: ends at one place, pixels outside of the frame, below the horizon, a broken file.
        ValueError
            Several ways at once, or none.
        TypeError
            A bare number of time without a scale.
        """
        scale = self._scale(scale)
        said = streak(
            ends=ends, times=times, place=place, position_angle=position_angle, length=length, frame=frame, pixels=pixels,
            origin=origin, hdu=hdu, region=region, start=start, exposure=exposure, whole_streak=whole_streak,
            place_sigma=place_sigma, time_sigma=time_sigma, angle_sigma=angle_sigma, scale=scale,
        )  # fmt: skip
        listed = _count(top, "top", 1)
        skies, _ = self._open()
        setup, config = json.dumps(self._state["setup"]), self._state["config"]
        answer = _core.identify(json.dumps(said), setup, config, skies, bool(include_dark), listed)
        self._tell(skies, answer["warnings"])
        return Identification(
            table_of(answer["candidates"], output),
            table_of(answer["streak"], output),
            answer["n_candidates"],
            answer["unknown_probability"],
        )


def _texts(value: Any, what: str) -> list[str]:
    """One text or several as a list; none for `None`."""
    if value is None:
        return []
    items = [value] if isinstance(value, str) else list(np.ravel(value)) if np.ndim(value) else [value]
    if not all(isinstance(item, str) for item in items):
        raise TypeError(f"{what} is {value!r}; allowed: a text, or several")
    return [str(item) for item in items]


def _norad_ids(value: Any) -> list[int]:
    """One catalogue number or several; none for `None`."""
    numbers = [] if value is None else [_count(one, "norad", 1) for one in np.ravel(value).tolist()]
    for one in numbers:
        if one > 999_999_999:
            raise ValueError(f"norad {one}; allowed: NORAD catalogue numbers, 1 to 999999999")
    return numbers


def _count(value: Any, what: str, least: int) -> int:
    try:
        number_of = operator.index(value)
    except TypeError:
        raise TypeError(f"{what} is {value!r}; allowed: whole numbers, {least} or more") from None
    if number_of < least:
        raise ValueError(f"{what} {number_of}; allowed: {least} or more")
    return number_of


def _dates(night: Any) -> list[str]:
    """Dates as texts; a text and what has a date's own words are one."""
    is_one = isinstance(night, str) or not isinstance(night, Iterable)
    dates = [str(date) for date in ([night] if is_one else night)]
    if not dates:
        raise ValueError("no night; allowed: one date or several")
    return dates
