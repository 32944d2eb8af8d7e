"""`StreakModel`: satellites over a site, for use in schedulers and notebooks."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal

from ._results import Assessment, ClearWindows, CostParameters, Site
from ._injection import Injected, inject
from ._deprecated import DeprecatedQueries
from ._setup import absolute, document
from ._state import State
from ._times import to_tai
from .typing import (
    FloatLike,
    FrameLike,
    HeaderLike,
    InjectionOptions,
    Json,
    LimitLike,
    ModelLike,
    ModelOptions,
    Options,
    PathLike,
    SiteLike,
    TimeLike,
)

if TYPE_CHECKING:
    from astropy.coordinates import EarthLocation
    from astropy.units import Quantity
    from typing_extensions import Unpack

__all__ = ["Assessment", "ClearWindows", "Site", "StreakModel"]


class StreakModel(DeprecatedQueries):
    """Satellites over a site, with a field of view, brightness models and a policy.

    Arguments have the names of the command line flags and of the keys in configuration files. A
    `~astropy.units.Quantity` is accepted for every number with a unit, also in dictionaries.

    Parameters
    ----------
    site : str, `~astropy.coordinates.EarthLocation` or dict, optional
        Name in the bundled table, a location, or ``{"latitude_deg": ..., "longitude_deg": ..., "height_m": ...}``. The
        site can also be given by ``mpc="X05"`` or ``lat=, lon=, height=`` (degrees, degrees east, metres).
    elements : path or list of paths, optional
        Element sets (TLE, 3LE, or OMM in CSV, JSON, XML or KVN), and operator ephemerides (OEM, Modified ITC) of the
        same satellites, plain or gzipped; or folders of such files. Element sets of about 3, 7 and 14 days before
        improve the positions of Starlinks.
    shells : str or list of str, optional
        Simulated constellations by name (``"starlink-gen1"``), or paths of TOML files. Constellations that grow (tables
        ``[[period]]``) are as deployed in each night.
    telescope : str, path or dict, optional
        Preset name (``"rubin"``) or TOML file: field of view, and parameters of the pixels lost to a streak.
    fov : str or `~astropy.units.Quantity`, optional
        Diameter of a circular field, with its unit: ``"3.5deg"``; or width and height of a rectangle, ``"1.5x1.0deg"``.
        Overrides the field of the telescope.
    field : path or dict, optional
        Field of any shape, instead of ``fov``.
    model : str, path or dict, optional
        Brightness model for all satellites, by name or as a JSON file; or models by generation, ``{"oneweb":
        "oneweb-panels"}``. Overrides ``models``.
    models : dict, optional
        ``{"files": [...], "generations": {"oneweb": "my-model"}, "qs_mag": path}``.
    limit_mag : float, `~astropy.units.Quantity` or dict, optional
        Magnitude limit. If a brighter satellite probably crosses an exposure, its verdict is ``avoid``. By band:
        ``{"g": 7, "default": 6}``.
    blocking : {"avoid", "any"}, optional
        Satellites that block a start: ``avoid`` (default), those that exceed a magnitude limit (all lit satellites if no
        limit applies); ``any``, all lit satellites.
    policy : path or dict, optional
        All limits: ``limit_mag, limit_surface_brightness, max_cost_s, min_probability, blocking, margin_s, max_delay_s``.
    mjd_scale : {"utc", "tai", "tt"}, optional
        Time scale of numbers given as times. Without it they raise `TypeError`.
    epoch : time, optional
        Time for which element sets are selected and simulated constellations are generated, for all calls. Without it
        this is done for each night (from noon to noon in mean solar time of the site): the element set of each object
        nearest to midnight, and constellations for 0h UTC of the date of the evening.
    config : path, optional
        Configuration file (TOML). Arguments override its keys, and the keys that answer the same question: a telescope
        replaces ``fov`` of the file, and a policy all limits. Tables of verbs, as ``[forecast]``, have no effect.
    on_changed_file : {"error", "warn"}
        Behaviour of an unpickled model if one of its files has changed: raises `ChangedFileError`, or warns and uses
        the new file.
    **more
        Other arguments; all are optional.

        - ``mpc``: observatory code, ``"X05"``; or ``lat``, ``lon`` (degrees, east positive) and ``height`` (metres
          above the ellipsoid, default 0), instead of ``site``.
        - ``band``: band of the magnitudes, one of ``B V R I u g r i z y G J H K W1 W2`` (default ``"V"``), or the
          path of a response curve (CSV or ECSV with ``wavelength_um`` and ``response``; AB magnitudes).
          In K, W1 and W2 magnitudes include thermal emission; in W1 and W2 satellites in shadow count.
        - ``bright_share``: share of an exposure that is lost to a bright streak across the whole field, 0 to 100 (default:
          that of the telescope, 0.08 if its file has none), for ``streak_cost_s``.
        - ``limit_surface_brightness``: limit of the surface brightness of streaks averaged over the exposure,
          mag/arcsec2, or by band as ``limit_mag``; requires ``telescope``.
        - ``mag_system``: ``"Vega"`` or ``"AB"`` (default: the usual one of the band).
        - ``earthshine``: whether models made of panels include earthshine (default `True`).
        - ``extinction``: magnitudes per airmass, 0 to 5 (default: magnitudes outside the atmosphere).
        - ``sun_distance``: whether magnitudes are for the Sun's distance of the day instead of 1 au (default `False`).
        - ``min_probability``: least probability, above 0, at most 1: of a crossing brighter than a limit, for the
          verdict ``avoid`` (default 0.5), and of near misses, which count only if it is given.
        - ``max_delay``: longest delay in the search for the next start, with its unit, ``"10min"`` (the default) or a
          `~astropy.units.Quantity`; at most one day.
        - ``learned``: path of a file that `streakcast.learn` or ``streakcast learn`` wrote: corrections of magnitudes
          and delays.
        - ``measured``: path or list of paths of tables that ``streakcast measure`` wrote, or with the columns
          ``norad_id``, ``mid_utc``, ``magnitude`` and ``magnitude_sigma``: magnitudes in the same pass are corrected.
        - ``qs_mag``: path of a table of standard magnitudes in the format of McCants' ``qs.mag``.
        - ``drag``: drag of satellites that hold their orbits by thrust: ``"station-keeping"`` (none; default) or
          ``"published"`` (as in the element set).
        - ``shadow``: model of the Earth's shadow: ``"atmosphere"`` (default) or ``"geometric"`` (solid Earth).
        - ``eop``: path of an IERS ``finals2000A`` file (default: UT1 table of the package).
        - ``accept_bad_checksums``: whether element sets with a wrong checksum are accepted (default `False`).
        - ``observer_elements``: path of the element set or of the ephemerides (OEM, Modified ITC) of a telescope in
          orbit, instead of a site.
        - ``observer_norad``: catalogue number of the telescope in orbit, in that file or else in ``elements``.
        - ``limb_height_km``: for a telescope in orbit, height of the Earth's limb, 0 to 1000 km (default 0): lower
          lines of sight are rejected.
        - ``max_zenith_angle``, ``min_sun_angle``, ``min_limb_angle``: for a telescope in orbit, the largest angle of a
          pointing from its zenith (away from the Earth's centre), and the smallest ones from the Sun and from the
          Earth's limb, degrees. Verdicts on other exposures are ``invalid``, and windows do not include them.

    Raises
    ------
    SetupError
        Arguments are invalid: a file is missing or invalid, a name is unknown, a number is out of range, or a required
        argument is missing.
    TypeError
        An argument does not exist.

    Notes
    -----
    A model can be used by several threads, and long computations release the interpreter lock. Copies use the same
    satellites. A pickle contains arguments, paths and hashes of files (below 10 kB), and no satellites, which are read
    again on first use.
    """

    def __init__(
        self,
        site: SiteLike | None = None,
        *,
        elements: PathLike | Sequence[PathLike] | None = None,
        shells: PathLike | Sequence[PathLike] | None = None,
        telescope: PathLike | Options | None = None,
        fov: str | Quantity | None = None,
        field: PathLike | Options | None = None,
        model: ModelLike | None = None,
        models: Options | None = None,
        limit_mag: LimitLike | None = None,
        policy: PathLike | Options | None = None,
        mjd_scale: str | None = None,
        epoch: TimeLike | None = None,
        config: PathLike | None = None,
        on_changed_file: Literal["error", "warn"] = "error",
        **more: Unpack[ModelOptions],
    ) -> None:
        if on_changed_file not in ("error", "warn"):
            raise ValueError(f"on_changed_file is '{on_changed_file}'; allowed: error, warn")
        given: dict[str, object] = dict(
            site=site, elements=elements, shells=shells, telescope=telescope, fov=fov, field=field, model=model,
            models=models, limit_mag=limit_mag, policy=policy, mjd_scale=mjd_scale, **more,
        )  # fmt: skip
        epoch_tai = None
        if epoch is not None:
            jd1, jd2 = to_tai(epoch, mjd_scale, "epoch")
            if jd1.shape != ():
                raise ValueError(f"epoch has the shape {jd1.shape}; allowed: one time")
            epoch_tai = (float(jd1), float(jd2))
        state: State = {
            "setup": document(given),
            "config": None if config is None else absolute(config),
            "epoch": epoch_tai,
            "on_changed_file": on_changed_file,
            "files": None,
        }
        self._begin(state)
        self._open()

    # Properties ------------------------------------------------------------------------------------------------------

    @property
    def site(self) -> Site | None:
        """Site; `None` for a telescope in orbit."""
        site = self._open()[0].site
        return None if site is None else Site(*site)

    @property
    def location(self) -> EarthLocation | None:
        """Site as an `astropy.coordinates.EarthLocation`; `None` for a telescope in orbit."""
        from astropy.coordinates import EarthLocation

        site = self.site
        if site is None:
            return None
        return EarthLocation.from_geodetic(lon=site.longitude_deg, lat=site.latitude_deg, height=site.height_m)

    @property
    def field_radius_deg(self) -> float | None:
        """Radius of a circle that contains the field of view, degrees; `None` without a field."""
        return self._engine.field_radius_deg

    @property
    def field_area_deg2(self) -> float | None:
        """Area of the field of view, square degrees; `None` without a field."""
        return self._engine.field_area_deg2

    def cost_parameters(self, band: str | None = None) -> CostParameters | None:
        """Returns the values that determine ``streak_cost_s`` of exposures in a band; `None` without a telescope.

        Parameters
        ----------
        band : str, optional
            Band of the exposures; default: that of exposures without a band.

        Returns
        -------
        CostParameters or None
        """
        parameters = self._engine.cost_parameters(band)
        return None if parameters is None else CostParameters(*parameters)

    def satellites(self, time: TimeLike, *, scale: str | None = None) -> int:
        """Returns the number of satellites loaded for a night.

        Parameters
        ----------
        time : time
            A time within the night.
        scale : {"utc", "tai", "tt"}, optional
            Scale of a bare number.

        Returns
        -------
        int
        """
        return self._open()[0].satellites(*self._moment(time, scale))

    def night(self, time: TimeLike, *, scale: str | None = None) -> int:
        """Returns the number of the night that contains a time. It increases by one at each mean noon of the site.

        Parameters
        ----------
        time : time
            The time.
        scale : {"utc", "tai", "tt"}, optional
            Scale of a bare number.

        Returns
        -------
        int
            Integer part of the MJD at the preceding noon of the site; 0 for all times if the model has an ``epoch``.
        """
        return self._open()[0].night(*self._moment(time, scale))

    def provenance(self, time: TimeLike, *, scale: str | None = None) -> dict[str, Json]:
        """Returns the provenance of a night: files with hashes and epochs, site, models, Earth orientation.

        Parameters
        ----------
        time : time
            A time within the night.
        scale : {"utc", "tai", "tt"}, optional
            Scale of a bare number.

        Returns
        -------
        dict
        """
        record = json.loads(self._open()[0].provenance(*self._moment(time, scale)))
        provenance: dict[str, Json] = record.pop("provenance")
        return {**provenance, **record}

    def inject(
        self,
        frame: FrameLike,
        output: PathLike | None = None,
        *,
        header: HeaderLike | None = None,
        start: TimeLike | None = None,
        exposure: FloatLike | None = None,
        **options: Unpack[InjectionOptions],
    ) -> Injected:
        """Adds the streaks of the satellites to a frame.

        Parameters
        ----------
        frame, output, header, start, exposure
            As for `streakcast.inject`.
        **options
            Other arguments of `streakcast.inject`; telescope and band default to those of the model.

        Returns
        -------
        Injected
        """
        return inject(frame, output, model=self, header=header, start=start, exposure=exposure, **options)
