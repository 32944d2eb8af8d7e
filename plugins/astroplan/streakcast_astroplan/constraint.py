"""`SatelliteStreakConstraint`: satellite-free exposures for the schedulers and tables of astroplan."""

from __future__ import annotations

from collections import OrderedDict
from typing import Any, Union

import numpy as np
import numpy.typing as npt
from astroplan import Constraint, Observer
from astropy.coordinates import SkyCoord
from astropy.time import Time
from streakcast import StreakModel
from streakcast.hosts import Hook

from ._samples import MEANINGS, Meaning, cells_s, meaning_of
from .blocks import Exposures, Rules, default_score, icrs_deg, one_of, seconds, unix_s
from .memory import ClearStarts

FloatArray = npt.NDArray[np.float64]

#: Number of cached results. Tables evaluate the same times repeatedly.
CACHED_RESULTS = 8


class SatelliteStreakConstraint(Constraint):  # type: ignore[misc]
    """Constraint for exposures that no lit satellite crosses, or a score that decreases with crossed exposures.

    astroplan passes single times; each represents an interval:

    ================================================  ==============================================================
    times passed by astroplan                         interval represented by one time
    ================================================  ==============================================================
    two or three even times for one target            the block from the first to the last, with the exposures in it
    (``SequentialScheduler``: start, middle, end)     (all times have the same result)
    ascending times, without ``exposure`` or with     the cell up to the next time: a block is clear if all its
    ``n_exposures`` (``PriorityScheduler``)           cells are
    ascending times, with ``exposure`` only           ``[t, t + exposure]``, or the whole cell if that is longer
    one time, unordered times, one time for each      ``[t, t + exposure]``
    target
    ================================================  ==============================================================

    Parameters
    ----------
    model : StreakModel or Hook
        Satellites, site, field of view and limits. A `~streakcast.hosts.Hook` may be used by several constraints.
    exposure : `~astropy.units.Quantity` or float, optional
        Duration of one exposure; seconds if it has no unit. Without it, cells and blocks are continuous exposures.
    readout : `~astropy.units.Quantity` or float
        Time from the closing of the shutter to its next opening.
    n_exposures : int, optional
        Number of exposures in a block; default: as many as fit.
    boolean_constraint : bool
        True: the result is whether all exposures are clear. False: the result is a score from ``worst_score`` to 1.
    score : {"clear", "cost"}, optional
        Meaning of the score: fraction of clear exposures, or 1 less the cost of streaks (``streak_cost_s``) as a fraction
        of the exposures. Default: ``cost`` if the model has a ``telescope``. Only with ``boolean_constraint=False``.
    blocking : {"any", "avoid"}, optional
        Satellites that block an exposure: all lit ones, or those that exceed a magnitude limit of the model's policy
        (``limit_mag``). Default: that of the policy. The score ``cost`` includes all lit satellites.
    margin : `~astropy.units.Quantity` or float
        Time that must be clear before the shutter opens and after it closes, and whose streaks the cost includes.
        astroplan moves blocks by up to a second to close gaps.
    worst_score : float
        Score of an exposure with rating 0; above 0 and below 1. astroplan never schedules a block with a score of 0.
    each : {"auto", "cell", "exposure", "block"}
        Meaning of a time, instead of that in the table above: ``"exposure"`` for tables of single exposures on a coarse
        grid, ``"cell"`` or ``"block"`` for custom schedulers.

    Raises
    ------
    ValueError
        A length is invalid, the model has no field of view, or the score is ``cost`` and the model has no telescope.

    Notes
    -----
    Errors that occur later (deleted element files, a time that cannot be converted) are counted in
    ``constraint.hook.counts`` and logged once (``streakcast.astroplan``). The target is then observable, so that the
    scheduler continues. A target below the horizon is not observable.

    The score of a block is the product of the scores of its times in ``SequentialScheduler``, and their mean in
    ``PriorityScheduler``.

    Examples
    --------
    >>> model = StreakModel(site="Rubin Observatory", elements="gp.csv", fov="1deg")  # doctest: +SKIP
    >>> constraints = [AirmassConstraint(2), SatelliteStreakConstraint(model, exposure=30 * u.s)]  # doctest: +SKIP
    """

    def __init__(
        self,
        model: Union[StreakModel, Hook],
        exposure: Any = None,
        *,
        readout: Any = 0.0,
        n_exposures: Union[int, None] = None,
        boolean_constraint: bool = True,
        score: Union[str, None] = None,
        blocking: Union[str, None] = None,
        margin: Any = 1.0,
        worst_score: float = 0.01,
        each: str = "auto",
    ) -> None:
        self.hook = model if isinstance(model, Hook) else Hook(model, "astroplan")
        self.boolean_constraint = bool(boolean_constraint)
        if self.boolean_constraint and score is not None:
            raise ValueError(f"score {score!r} with boolean_constraint=True; allowed: score with boolean_constraint=False only")
        exposures = Exposures(
            None if exposure is None else seconds(exposure, "exposure"), seconds(readout, "readout"), n_exposures
        )
        if score is None:
            score = "clear" if self.boolean_constraint or blocking is not None else default_score(self.hook.model)
        self.rules = Rules(exposures, score, blocking, seconds(margin, "margin"))
        if not 0.0 < worst_score < 1.0:
            raise ValueError(f"worst_score is {worst_score}; allowed: above 0, below 1")
        self.worst_score = float(worst_score)
        one_of("each", each, MEANINGS)
        if each == "exposure" and exposures.exposure_s is None:
            raise ValueError("each='exposure' without exposure; specify exposure, the length of one exposure")
        self.each = each
        self.rules.check(self.hook.model)
        self._reset()

    def _reset(self) -> None:
        self._cache: OrderedDict[Any, Any] = OrderedDict()
        self._cached_model: Union[StreakModel, None] = None
        self._clear_starts = ClearStarts()
        self._observer: Any = None

    def __getstate__(self) -> dict[str, Any]:
        return {key: value for key, value in self.__dict__.items() if key not in ("_cache", "_cached_model", "_clear_starts", "_observer")}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._reset()

    @classmethod
    def for_block(cls, model: Union[StreakModel, Hook], block: Any, **options: Any) -> "SatelliteStreakConstraint":
        """Returns a constraint with the exposures of one block, to be used in ``constraints`` of this block.

        Parameters
        ----------
        model : StreakModel or Hook
            As above. Blocks with the same `Hook` have common counters.
        block : `~astroplan.ObservingBlock`
            Block made by ``ObservingBlock.from_exposures``. Any other block is one continuous exposure.
        **options
            Other parameters of the class.

        Returns
        -------
        SatelliteStreakConstraint
        """
        if getattr(block, "time_per_exposure", None) is None:
            return cls(model, **options)
        return cls(
            model, block.time_per_exposure, readout=block.readout_time, n_exposures=int(block.number_exposures), **options
        )

    def compute_constraint(self, times: Time, observer: Observer, targets: Union[SkyCoord, None]) -> npt.NDArray[Any]:
        """Evaluates the constraint for times and targets, broadcast against each other.

        Parameters
        ----------
        times : `~astropy.time.Time`
            Times in any shape; ``(n_times,)`` for the grids of ``PriorityScheduler``.
        observer : `~astroplan.Observer`
            Its location is compared with the model's site.
        targets : `~astropy.coordinates.SkyCoord`
            Positions in any frame and shape; ``()`` or ``(n_targets, 1)`` for grids.

        Returns
        -------
        array of bool, or of float within ``worst_score`` to 1
            In the broadcast shape.
        """
        shape = np.broadcast_shapes(times.shape, () if targets is None else targets.shape)
        fallback = np.ones(shape, dtype=bool if self.boolean_constraint else float)
        if observer is not None and observer is not self._observer:
            self._observer = observer
            self.hook.check_site(lambda: observer.location)
        if targets is None:
            self.hook.note("target", "no target was passed; it is taken as observable")
            return fallback
        return self.hook.evaluate(lambda model: self._evaluate(model, times, targets, fallback), fallback)

    def _evaluate(self, model: StreakModel, times: Time, targets: SkyCoord, fallback: npt.NDArray[Any]) -> npt.NDArray[Any]:
        ra_deg, dec_deg = icrs_deg(targets)
        valid = np.isfinite(ra_deg) & np.isfinite(dec_deg)
        if not valid.all():
            missing = int((~valid).sum())
            self.hook.note("target", f"targets without coordinates: {missing}; they are taken as observable", kind="target")
        starts_s = unix_s(times)
        meaning = meaning_of(starts_s, ra_deg.shape, self.rules.exposures, self.each)
        if meaning is Meaning.INSTANT:
            self.hook.note("instant", "a single time without exposure defines no interval; specify SatelliteStreakConstraint(exposure=...)")
            return fallback
        if meaning is Meaning.ALONE:
            return self._alone(model, ra_deg, dec_deg, starts_s, valid, fallback)
        # One row per target, for the shapes (n_targets, 1) and ().
        rows = (np.where(valid, ra_deg, 0.0).ravel(), np.where(valid, dec_deg, 0.0).ravel())
        key = (rows[0].tobytes(), rows[1].tobytes(), starts_s.tobytes(), meaning)
        if self._cached_model is not model:
            self._cache, self._cached_model = OrderedDict(), model
        result = self._cache.get(key)
        if result is None:
            result = self._block(model, *rows, starts_s) if meaning is Meaning.BLOCK else self._grid(model, *rows, starts_s, meaning)
            self._cache[key] = result
            while len(self._cache) > CACHED_RESULTS:
                self._cache.popitem(last=False)
        result = result.reshape(ra_deg.shape[:-1] + result.shape[1:] if ra_deg.ndim else result.shape[1:])
        return np.where(np.broadcast_to(valid, fallback.shape), result, fallback)

    def _block(self, model: StreakModel, ra_deg: FloatArray, dec_deg: FloatArray, starts_s: FloatArray) -> npt.NDArray[Any]:
        """Returns the result of the block for each of its times: ``(n_targets, n_times)``."""
        block_s = float(starts_s[-1] - starts_s[0])
        overlong_s = self.rules.overlong_s(block_s)
        if overlong_s:
            message = f"the block has {block_s:.0f} s, its exposures last {overlong_s:.0f} s; all of them are evaluated"
            self.hook.note("block", message, kind="block")
        if len(ra_deg) == 1:
            # SequentialScheduler evaluates every target at each step of the night.
            position = (float(ra_deg[0]), float(dec_deg[0]))
            share = np.array([self._clear_starts.worth_of_block(model, self.rules, *position, float(starts_s[0]), block_s)])
        else:
            share = self.rules.worth_of_block(model, ra_deg, dec_deg, float(starts_s[0]), block_s)
        # SequentialScheduler multiplies the results of all times: (s^(1/n))^n = s
        per_time = share == 1.0 if self.boolean_constraint else self._scored(share) ** (1.0 / len(starts_s))
        return np.repeat(per_time[:, np.newaxis], len(starts_s), axis=1)

    def _grid(
        self, model: StreakModel, ra_deg: FloatArray, dec_deg: FloatArray, starts_s: FloatArray, meaning: Meaning
    ) -> npt.NDArray[Any]:
        """Returns a result for each time of an ascending grid: ``(n_targets, n_times)``."""
        worth = np.empty((len(ra_deg), len(starts_s)))
        # Rounded to milliseconds, because Julian dates change the steps of a regular grid by microseconds.
        lengths_s = np.round(cells_s(starts_s), 3)
        exposures, alone = self.rules.exposures, self.each == "exposure"
        for cell_s in np.unique(lengths_s):
            indices = np.flatnonzero(lengths_s == cell_s)
            cell_starts_s = starts_s[indices]
            if not self.boolean_constraint:
                # Exposures that start within the cell: the mean over the cells of a block is the mean over its
                # exposures.
                offsets_s, length_s = exposures.starts_in_cell(0.0 if alone else float(cell_s))
            else:
                offsets_s, length_s = np.zeros(1), float(cell_s)
                if meaning is Meaning.EXPOSURE and exposures.exposure_s is not None:
                    length_s = exposures.exposure_s if alone else max(exposures.exposure_s, length_s)
            each = [self.rules.worth(model, ra_deg, dec_deg, cell_starts_s + offset_s, length_s) for offset_s in offsets_s]
            worth[:, indices] = np.mean(each, axis=0)
        return worth == 1.0 if self.boolean_constraint else self._scored(worth)

    def _alone(
        self, model: StreakModel, ra_deg: FloatArray, dec_deg: FloatArray, starts_s: FloatArray, valid: Any, fallback: npt.NDArray[Any]
    ) -> npt.NDArray[Any]:
        """Returns results of independent exposures in the broadcast shape."""
        ra, dec, starts, is_valid = (np.broadcast_to(part, fallback.shape).ravel() for part in (ra_deg, dec_deg, starts_s, valid))
        where = np.flatnonzero(is_valid)
        length_s = float(self.rules.exposures.exposure_s or 0.0)
        worth = self.rules.worth_of_each(model, ra[where], dec[where], starts[where], length_s)
        result = fallback.ravel().copy()
        result[where] = worth == 1.0 if self.boolean_constraint else self._scored(worth)
        return result.reshape(fallback.shape)

    def _scored(self, share: FloatArray) -> FloatArray:
        """Converts a fraction in [0, 1] to a score in [worst, 1]."""
        return self.worst_score + (1.0 - self.worst_score) * share
