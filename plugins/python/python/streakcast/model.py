"""`StreakModel`: satellites over a site, asked by schedulers and notebooks."""

from __future__ import annotations

import hashlib
import json
import os
import threading
import warnings
import weakref
from typing import Any, NamedTuple, Union

import numpy as np
import numpy.typing as npt

from . import _core
from ._quantities import directions, is_of, number, scalar
from ._setup import ENGINE_KEYS, SKY_KEYS, absolute, document
from ._tables import TableLike, table_of, time_of, wants_qtable
from ._times import TimeLike, to_tai
from .errors import ChangedFileError, StreakcastWarning

FloatArray = npt.NDArray[np.float64]
#: One number, or an array in the shape of the question.
Numbers = Any

#: The verdicts in the order of their codes.
VERDICTS = np.array(["clear", "streaked", "avoid", "invalid"])

# Skies of this process, shared by models made of the same files: copies and unpickled models cost nothing.
_skies: "weakref.WeakValueDictionary[tuple[Any, ...], _core.Skies]" = weakref.WeakValueDictionary()
_skies_lock = threading.Lock()


class Site(NamedTuple):
    """A place on the Earth."""

    #: Name.
    name: str
    #: Geodetic latitude (WGS84), degrees, north positive.
    latitude_deg: float
    #: Longitude, degrees, east positive.
    longitude_deg: float
    #: Height above the ellipsoid, metres.
    height_m: float


class Assessment(NamedTuple):
    """What satellites do to exposures: numbers for one exposure, arrays in the shape of the question for many."""

    #: ``clear``, ``streaked``, ``avoid`` (a limit of the policy is broken) or ``invalid`` (the pointing is below the horizon).
    verdict: Any
    #: Whether a lit satellite crosses the field.
    crosses: Any
    #: How many lit satellites do.
    n_streaks: Any
    #: The brightest magnitude that any of them reaches in the field; NaN without any.
    brightest_mag: Any
    #: Share of the field's pixels expected lost, [0, 1], near misses weighed with their probability; NaN without a telescope.
    lost_fraction: Any
    #: Probability that at least one lit satellite crosses, given the errors of the elements; NaN where invalid.
    p_any: Any
    #: Length of all lit streaks in the field, degrees; NaN where invalid.
    streak_length_deg: Any

    @property
    def avoid(self) -> Any:
        """Whether a limit of the policy is broken."""
        return self.verdict == "avoid"

    @property
    def clear(self) -> Any:
        """Whether nothing lit crosses."""
        return self.verdict == "clear"


class ClearWindows(NamedTuple):
    """Stretches of clear starts, in order of target and time; each field has the shape ``(n_windows,)``."""

    #: The target's place in the question (flat).
    target: npt.NDArray[np.int64]
    #: First clear start: `astropy.time.Time` where astropy is there, else ``datetime64[ns]``, UTC.
    first_start: Any
    #: Last clear start.
    last_start: Any
    #: Length from the first to the last start, seconds.
    length_s: FloatArray


class StreakModel:
    """Satellites over a site, with a field of view, brightness models and a policy.

    Arguments are those of the command line's flags and of its configuration file, by the same names.

    Parameters
    ----------
    site : str, `~astropy.coordinates.EarthLocation` or dict, optional
        Name of the bundled table, a place, or ``{"latitude_deg": ..., "longitude_deg": ..., "height_m": ...}``. Also
        ``mpc="X05"`` or ``lat=, lon=, height=`` (degrees, degrees east, metres).
    elements : path or list of paths, optional
        Element sets: TLE, 3LE, or OMM in CSV, JSON, XML or KVN, plain or gzipped.
    shells : str or list of str, optional
        Synthetic constellations by name (``"starlink-gen1"``), or TOML files of one's own.
    telescope : str, path or dict, optional
        A preset (``"rubin"``) or a TOML file: field of view, and what a streak costs in pixels.
    fov : str or `~astropy.units.Quantity`, optional
        Full diameter of a circular field, with its unit: ``"3.5deg"``. Goes before the telescope's own field.
    field : path or dict, optional
        A field of any shape, instead of ``fov``.
    models : dict, optional
        ``{"files": [...], "generations": {"oneweb": "my-model"}, "qs_mag": path}``.
    limit_mag : float or dict, optional
        Crossings brighter than this make an exposure one to avoid; by band as ``{"g": 7, "default": 6}``.
    policy : path or dict, optional
        All limits: ``limit_mag, max_lost_fraction, saturation_mag, crosstalk_mag, min_probability, margin_s, max_delay_s``.
    mjd_scale : {"utc", "tai", "tt"}, optional
        The scale of bare numbers of time. Without it they raise `TypeError`.
    epoch : time, optional
        The one moment for which elements are chosen and shells are laid out, for all questions. Without it that is done for each
        night (noon to noon by the site's mean Sun): of several sets of one object the nearest to midnight, shells for
        0h UTC of the evening's date.
    config : path, optional
        A configuration file (TOML); arguments go before what it says.
    on_changed_file : {"error", "warn"}
        What an unpickled model does when a file it was made of has changed: raise `ChangedFileError`, or warn and use the new one.
    **more
        ``band, mag_system, earthshine, extinction, sun_distance, min_probability, max_delay, shadow, eop, qs_mag,
        accept_bad_checksums, observer_elements, observer_norad, limb_height_km``, as on the command line.

    Raises
    ------
    SetupError
        What cannot be made of the arguments: a missing or broken file, an unknown name, a number out of range, something unsaid.
    TypeError
        An argument that does not exist.

    Notes
    -----
    A model is safe to use from several threads; what takes long runs without the interpreter's lock. Copies share its satellites.
    Its pickle holds arguments, paths and hashes of files (below 10 kB), never the satellites: they are read again on first use.
    """

    def __init__(
        self,
        site: Any = None,
        *,
        elements: Any = None,
        shells: Any = None,
        telescope: Any = None,
        fov: Any = None,
        field: Any = None,
        models: Any = None,
        limit_mag: Any = None,
        policy: Any = None,
        mjd_scale: Union[str, None] = None,
        epoch: Union[TimeLike, None] = None,
        config: Union[str, "os.PathLike[str]", None] = None,
        on_changed_file: str = "error",
        **more: Any,
    ) -> None:
        if on_changed_file not in ("error", "warn"):
            raise ValueError(f"on_changed_file '{on_changed_file}'; allowed: error, warn")
        said = dict(
            site=site, elements=elements, shells=shells, telescope=telescope, fov=fov, field=field, models=models,
            limit_mag=limit_mag, policy=policy, mjd_scale=mjd_scale, **more,
        )  # fmt: skip
        moment = None
        if epoch is not None:
            jd1, jd2 = to_tai(epoch, mjd_scale, "epoch")
            if jd1.shape != ():
                raise ValueError(f"epoch has the shape {jd1.shape}; allowed: one moment")
            moment = (float(jd1), float(jd2))
        state = {
            "setup": document(said),
            "config": None if config is None else absolute(config),
            "epoch": moment,
            "on_changed_file": on_changed_file,
            "files": None,
        }
        self._begin(state)
        self._open()

    # What a model is made of, and how it comes back ------------------------------------------------------------------

    def _begin(self, state: dict[str, Any]) -> None:
        self._state = state
        self._lock = threading.Lock()
        self._opened: Union[tuple[_core.Skies, _core.Engine], None] = None
        self._told: set[str] = set()

    def _open(self) -> tuple[_core.Skies, _core.Engine]:
        """Satellites and engine; read on first use after unpickling."""
        opened = self._opened
        if opened is None:
            with self._lock:
                if self._opened is None:
                    self._opened = self._made()
                opened = self._opened
        return opened

    def _made(self) -> tuple[_core.Skies, _core.Engine]:
        state = self._state
        text, config = json.dumps(state["setup"]), state["config"]
        hashes = {path: _sha256(path) for path in _files(text, config)}
        known = state["files"]
        if known is not None and known != hashes:
            changed = ", ".join(path for path, digest in hashes.items() if known.get(path) != digest)
            message = f"changed since this model was pickled: {changed}; make the model anew, or call reloaded()"
            if state["on_changed_file"] == "error":
                raise ChangedFileError(message)
            warnings.warn(message, StreakcastWarning, stacklevel=4)
        sky_text = json.dumps({key: value for key, value in state["setup"].items() if key in SKY_KEYS}, sort_keys=True)
        key = (sky_text, config, state["epoch"], tuple(hashes.items()))
        with _skies_lock:
            skies = _skies.get(key)
            if skies is None:
                skies = _core.Skies(text, config, state["epoch"])
                for name, digest in skies.element_files():
                    if hashes.get(name, digest) != digest:
                        raise ChangedFileError(f"{name} changed while it was read; try again when it is whole")
                _skies[key] = skies
        engine = _core.Engine(skies, text, config)
        self._state = {**state, "files": hashes}
        return skies, engine

    @classmethod
    def _of_state(cls, state: dict[str, Any]) -> "StreakModel":
        model = cls.__new__(cls)
        model._begin(state)
        return model

    def __reduce__(self) -> tuple[Any, ...]:
        return (type(self)._of_state, (self._state,))

    def __copy__(self) -> "StreakModel":
        copy = self._of_state(self._state)
        copy._opened = self._opened
        return copy

    def __deepcopy__(self, memo: dict[int, Any]) -> "StreakModel":
        return self.__copy__()

    def __repr__(self) -> str:
        said = ", ".join(f"{key}={value!r}" for key, value in self._state["setup"].items())
        return f"StreakModel({said})"

    def with_options(self, **changes: Any) -> "StreakModel":
        """The same satellites with another field, telescope, policy or band; they are shared, not read again.

        Parameters
        ----------
        **changes
            ``fov, field, telescope, limit_mag, policy, band, mag_system, extinction, min_probability, max_delay, mjd_scale``, ...;
            ``None`` takes one away.

        Returns
        -------
        StreakModel
        """
        skies, _ = self._open()
        for key in changes:
            if key != "mjd_scale" and key not in ENGINE_KEYS:
                raise TypeError(f"with_options has no argument '{key}'; make a new StreakModel for other satellites or sites")
        setup = {**self._state["setup"], **document(changes)}
        for key, value in changes.items():
            if value is None:
                setup.pop("time_scale" if key == "mjd_scale" else key, None)
        model = self._of_state({**self._state, "setup": setup, "files": None})
        config = self._state["config"]
        model._opened = (skies, _core.Engine(skies, json.dumps(setup), config))
        known = self._state["files"]
        files = _files(json.dumps(setup), config)
        model._state["files"] = {path: known.get(path) or _sha256(path) for path in files}
        return model

    @property
    def files(self) -> dict[str, Union[str, None]]:
        """Paths of all files that this model was made of, with the SHA-256 of each."""
        self._open()
        return dict(self._state["files"])

    def changed_files(self) -> list[str]:
        """Files whose content is not what this model was made of: missing, half written, or new.

        Returns
        -------
        list of str
        """
        self._open()
        return [path for path, digest in self._state["files"].items() if _sha256(path) != digest]

    def reloaded(self) -> "StreakModel":
        """A model of the same arguments from the files as they are now. This one stays as it is, and good.

        Returns
        -------
        StreakModel

        Raises
        ------
        SetupError
            Where a file is missing or broken: who asks goes on with the old model.
        """
        model = self._of_state({**self._state, "files": None})
        model._open()
        return model

    # What it knows ---------------------------------------------------------------------------------------------------

    @property
    def site(self) -> Union[Site, None]:
        """Where the telescope is; `None` for one in orbit."""
        site = self._open()[0].site
        return None if site is None else Site(*site)

    @property
    def location(self) -> Any:
        """The site as an `astropy.coordinates.EarthLocation`; `None` for a telescope in orbit."""
        from astropy.coordinates import EarthLocation

        site = self.site
        if site is None:
            return None
        return EarthLocation.from_geodetic(lon=site.longitude_deg, lat=site.latitude_deg, height=site.height_m)

    @property
    def mjd_scale(self) -> Union[str, None]:
        """The scale of bare numbers of time."""
        return self._open()[1].time_scale

    @property
    def field_radius_deg(self) -> Union[float, None]:
        """Radius of the circle that holds the field of view, degrees; `None` without a field."""
        return self._open()[1].field_radius_deg

    @property
    def field_area_deg2(self) -> Union[float, None]:
        """Area of the field of view, square degrees; `None` without a field."""
        return self._open()[1].field_area_deg2

    def satellites(self, time: TimeLike, *, scale: Union[str, None] = None) -> int:
        """How many satellites the sky of a night has.

        Parameters
        ----------
        time : time
            A moment of the night.
        scale : {"utc", "tai", "tt"}, optional
            Scale of a bare number.

        Returns
        -------
        int
        """
        return self._open()[0].satellites(*self._moment(time, scale))

    def night(self, time: TimeLike, *, scale: Union[str, None] = None) -> int:
        """Which night a moment belongs to: a number that grows by one from noon to noon (the site's mean Sun).

        Parameters
        ----------
        time : time
            The moment.
        scale : {"utc", "tai", "tt"}, optional
            Scale of a bare number.

        Returns
        -------
        int
            The whole part of MJD at the site's noon before; 0 for all moments where the model has an ``epoch``.
        """
        return self._open()[0].night(*self._moment(time, scale))

    def key(self) -> str:
        """What an answer depends on besides the question, in one text: arguments and hashes of all files.

        Returns
        -------
        str
        """
        self._open()
        return json.dumps([self._state[part] for part in ("setup", "config", "epoch", "files")], sort_keys=True)

    def provenance(self, time: TimeLike, *, scale: Union[str, None] = None) -> dict[str, Any]:
        """What the answers of a night rest on: files with hashes and epochs, site, models, the Earth's orientation.

        Parameters
        ----------
        time : time
            A moment of the night.
        scale : {"utc", "tai", "tt"}, optional
            Scale of a bare number.

        Returns
        -------
        dict
        """
        answer = json.loads(self._open()[0].provenance(*self._moment(time, scale)))
        provenance: dict[str, Any] = answer.pop("provenance")
        return {**provenance, **answer}

    # What it is asked ------------------------------------------------------------------------------------------------

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
        if shape == ():
            count = int(streaks[0])
            return Assessment(str(verdict[0]), count > 0, count, *(float(one[0]) for one in numbers))
        arrays = (verdict, streaks > 0, streaks, *numbers)
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
        blocking : {"any", "avoid"}
            Every lit satellite blocks, or only those that break a limit of magnitude of the policy.
        output : {"auto", "qtable", "dict"}
            As for `flags`: starts as an astropy `Time`, or as ``datetime64[ns]``, UTC, which is several times faster.

        Returns
        -------
        ClearWindows
        """
        if blocking not in ("any", "avoid"):
            raise ValueError(f"blocking '{blocking}'; allowed: any, avoid")
        jd1, jd2 = to_tai(end, self._scale(scale), "end")
        begin1, begin2 = to_tai(start, self._scale(scale), "start")
        span_s = ((jd1 - begin1) + (jd2 - begin2)) * 86_400.0
        if np.any(span_s < 0.0):
            raise ValueError(f"end[{int(np.flatnonzero(np.ravel(span_s) < 0.0)[0])}] is before the start")
        length_s = scalar(exposure, "s", "exposure")
        asked, bands, _ = self._question(target, start, span_s, rotation, band, scale)
        skies, engine = self._open()
        answer = engine.clear_windows(
            asked, bands, length_s, scalar(min_altitude, "deg", "min_altitude"), blocking == "avoid"
        )
        self._tell(skies, [])
        first, last = answer["first_start"], answer["last_start"]
        length = (last[0] - first[0] + (last[1] - first[1])) * 86_400.0
        if wants_qtable(output):
            return ClearWindows(answer["target"], time_of(*first[:2]), time_of(*last[:2]), length)
        moments = [one[2].view("datetime64[ns]") for one in (first, last)]
        return ClearWindows(answer["target"], moments[0], moments[1], length)

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
        """Rise, culmination and set of every satellite in a night, with magnitudes.

        Parameters
        ----------
        start, end : time
            From when to when.
        min_altitude : float or `~astropy.units.Quantity`
            What rise and set are counted from, degrees, without refraction.
        lit_only : bool
            Only passes with a magnitude at rise, culmination or set.
        scale : {"utc", "tai", "tt"}, optional
            Scale of bare numbers.
        output : {"auto", "qtable", "dict"}
            As for `flags`.

        Returns
        -------
        QTable or dict of arrays, ``(n_passes,)`` each, by time of culmination
        """
        moments = [self._moment(time, scale) for time in (start, end)]
        skies, engine = self._open()
        altitude = scalar(min_altitude, "deg", "min_altitude")
        columns, told = engine.visible_passes(moments[0], moments[1], altitude, lit_only)
        self._tell(skies, told)
        return table_of(columns, output)

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
            Length of all lit streaks in the field of each visit, degrees; NaN for pointings below the horizon.
        n_streaks : array, ``(n,)``
            How many there are.
        """
        answer = self.assess((pointing_ras, pointing_decs), mjds, visit_time, scale=scale)
        return np.atleast_1d(answer.streak_length_deg), np.atleast_1d(answer.n_streaks)

    # How questions are put -------------------------------------------------------------------------------------------

    def _scale(self, scale: Union[str, None]) -> Union[str, None]:
        return self.mjd_scale if scale is None else scale

    def _moment(self, time: TimeLike, scale: Union[str, None]) -> tuple[float, float]:
        jd1, jd2 = to_tai(time, self._scale(scale))
        if np.shape(jd1) != ():
            raise ValueError(f"time has the shape {np.shape(jd1)}; allowed: one moment")
        return float(jd1), float(jd2)

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

    def _tell(self, skies: _core.Skies, told: list[str]) -> None:
        """Each warning once a model."""
        for message in [*skies.news(), *told]:
            if message not in self._told:
                self._told.add(message)
                warnings.warn(message, StreakcastWarning, stacklevel=3)


def _by_place(columns: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Exposures are called by their places in the question: numbers, not texts."""
    first = columns[0]
    places = np.array([int(text) for text in first["values"]], dtype=np.int64)
    description = "Place of the exposure in the question (flat, from 0)."
    missing = np.zeros(len(places), dtype=bool)
    return [{**first, "kind": "integer", "values": places, "missing": missing, "description": description}, *columns[1:]]


def _files(setup: str, config: Union[str, None]) -> list[str]:
    """All files that a setup names."""
    return sorted(os.fspath(path) for path in _core.setup_files(setup, config))


def _sha256(path: str) -> Union[str, None]:
    """Hash of a file's content; `None` where it cannot be read (whoever needs it says why)."""
    digest = hashlib.sha256()
    try:
        with open(path, "rb") as file:
            while chunk := file.read(1 << 20):
                digest.update(chunk)
    except OSError:
        return None
    return digest.hexdigest()
