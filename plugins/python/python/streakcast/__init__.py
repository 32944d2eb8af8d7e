"""Satellites crossing astronomers' exposures: which, when, where and how bright.

>>> import streakcast
>>> model = streakcast.StreakModel(site="Rubin Observatory", shells="starlink-gen1", telescope="rubin", limit_mag=7)
>>> result = model.assess((198.9, 7.7), "2026-08-14T23:29:05Z", 30.0)
>>> result.crosses
True

`StreakModel` contains satellites, site, field of view, brightness models and policy, and computes crossings for arrays
of exposures. `StreakModel.forecast` returns the visible passes of nights, `StreakModel.overhead` the positions of all
satellites above the site, `StreakModel.ephemeris` those of given satellites at any times, and `StreakModel.identify`
the satellites that may have caused a streak. `StreakModel.measure` and `measure_streaks` measure the streaks in frames, `StreakModel.mask` masks them, and `learn` computes
offsets of satellites from their magnitudes. `inject` adds streaks to frames and arrays. `body_map`, `sky_map`,
`standard_magnitudes` and `sky_magnitudes` use only brightness models, without satellites.

Times need a time scale: an `astropy.time.Time`, a string that ends in ``Z``, or numbers with ``scale="utc"`` (or
``"tai"``, ``"tt"``). A number without a scale raises `TypeError`: TAI that is read as UTC is wrong by 37 s, and
satellites cross a field within seconds.

A `Quantity` of astropy is accepted for every number with a unit. `streakcast.typing` names the types of arguments and
results.
"""

from ._results import Assessment, ClearWindows, CostParameters, Forecast, Identification, Overhead, Site
from ._core import SetupError, StreakcastError, UnknownPositionsError, __version__
from ._injection import Injected, inject
from ._learn import learn
from ._mask import StreakMask
from ._measure import Measurements, measure_streaks
from .errors import ChangedFileError, StreakcastWarning
from .light import body_map, model_names, sky_magnitudes, sky_map, standard_magnitudes
from .model import StreakModel

__all__ = [
    "Assessment",
    "ChangedFileError",
    "ClearWindows",
    "CostParameters",
    "Forecast",
    "Identification",
    "Injected",
    "Measurements",
    "Overhead",
    "SetupError",
    "Site",
    "StreakMask",
    "StreakModel",
    "StreakcastError",
    "UnknownPositionsError",
    "StreakcastWarning",
    "__version__",
    "body_map",
    "inject",
    "learn",
    "measure_streaks",
    "model_names",
    "sky_magnitudes",
    "sky_map",
    "standard_magnitudes",
]
