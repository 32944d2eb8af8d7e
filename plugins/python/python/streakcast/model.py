"""`StreakModel`: satellites over a site, asked by schedulers and notebooks."""

from __future__ import annotations

import json
import os
from typing import Any, Union

from ._answers import Assessment, ClearWindows, Site
from ._injection import Injected, inject
from ._questions import Questions
from ._setup import absolute, document
from ._times import TimeLike, to_tai

__all__ = ["Assessment", "ClearWindows", "Site", "StreakModel"]


class StreakModel(Questions):
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

    def inject(
        self,
        frame: Any,
        output: Union[str, "os.PathLike[str]", None] = None,
        *,
        header: Any = None,
        start: Union[TimeLike, None] = None,
        exposure: Any = None,
        **options: Any,
    ) -> Injected:
        """Puts the streaks of the model's satellites into a frame.

        Parameters
        ----------
        frame, output, header, start, exposure
            As for `streakcast.inject`.
        **options
            The others of `streakcast.inject`; telescope and band are the model's where they are not said.

        Returns
        -------
        Injected
        """
        return inject(frame, output, model=self, header=header, start=start, exposure=exposure, **options)
