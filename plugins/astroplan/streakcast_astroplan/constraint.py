"""`SatelliteStreakConstraint`: exposures that no satellite crosses, for astroplan's schedulers and tables."""

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
from .blocks import Exposures, Rules, icrs_deg, one_of, seconds, unix_s
from .memory import ClearStarts

FloatArray = npt.NDArray[np.float64]

#: Tables ask the same thing again and again: as many answers are kept.
KEPT_ANSWERS = 8


class SatelliteStreakConstraint(Constraint):  # type: ignore[misc]
    """Only exposures that no lit satellite crosses, or the better the fewer do.

    astroplan hands over instants; each stands for an interval here, never for an instant:

    ================================================  ==============================================================
    what astroplan asks                               what one time stands for
    ================================================  ==============================================================
    two or three even times for one target            the block from the first to the last, with the exposures in it
    (``SequentialScheduler``: start, middle, end)     (all times have the same answer)
    rising times, without ``exposure`` or with        the cell up to the next time: a block is clear where all its
    ``n_exposures`` (``PriorityScheduler``)           cells are
    rising times, with ``exposure`` alone             ``[t, t + exposure]``, and the whole cell where that is longer
    one time, times that do not rise, a time for      ``[t, t + exposure]``
    each target
    ================================================  ==============================================================

    Parameters
    ----------
    model : StreakModel or Hook
        Satellites, site, field of view and limits. A `~streakcast.hosts.Hook` is shared with others: its model, its counters.
    exposure : `~astropy.units.Quantity` or float, optional
        Length of one exposure; seconds where it has no unit. Without it, cells and blocks are exposed throughout.
    readout : `~astropy.units.Quantity` or float
        From the closing of the shutter to its next opening.
    n_exposures : int, optional
        Exposures in a block; as many as fit where not said.
    boolean_constraint : bool
        True: whether all exposures are clear. False: a score, ``worst_score`` to 1.
    score : {"clear", "pixels"}, optional
        What the score measures: the share of the exposures that are clear (default), or of the pixels that are left (the model
        needs a ``telescope``). Only with ``boolean_constraint=False``.
    blocking : {"any", "avoid"}
        Every lit satellite counts, or only those that break a limit of magnitude of the model's policy (``limit_mag``). Pixels are
        lost to all.
    margin : `~astropy.units.Quantity` or float
        Kept clear before the shutter opens and after it closes: astroplan moves blocks by up to a second to close gaps.
    worst_score : float
        What a wholly spoilt exposure scores, above 0, below 1. astroplan never places a block where a score is 0.
    each : {"auto", "cell", "exposure", "block"}
        What a time stands for, where the table above guesses wrong: ``"exposure"`` for tables of single exposures on a coarse grid,
        ``"cell"`` or ``"block"`` for schedulers of one's own.

    Raises
    ------
    ValueError
        What cannot work: a length that is none, a model without a field of view, a score without its telescope.

    Notes
    -----
    Whatever fails later (elements deleted, a time that cannot be converted) is counted, logged once (``streakcast.astroplan``) and
    answered with "observable": a scheduler is never stopped. See ``constraint.hook.counts``. A target below the horizon is not
    observable.

    The score of a block is the product of its times' scores for ``SequentialScheduler``, their mean for ``PriorityScheduler``.

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
        blocking: str = "any",
        margin: Any = 1.0,
        worst_score: float = 0.01,
        each: str = "auto",
    ) -> None:
        self.hook = model if isinstance(model, Hook) else Hook(model, "astroplan")
        self.boolean_constraint = bool(boolean_constraint)
        if self.boolean_constraint and score is not None:
            raise ValueError(f"score {score!r} with boolean_constraint=True; allowed: a score with boolean_constraint=False")
        exposures = Exposures(
            None if exposure is None else seconds(exposure, "exposure"), seconds(readout, "readout"), n_exposures
        )
        self.rules = Rules(exposures, "clear" if score is None else score, blocking, seconds(margin, "margin"))
        if not 0.0 < worst_score < 1.0:
            raise ValueError(f"worst_score is {worst_score}; allowed: above 0, below 1")
        self.worst_score = float(worst_score)
        one_of("each", each, MEANINGS)
        if each == "exposure" and exposures.exposure_s is None:
            raise ValueError("each='exposure' without exposure; allowed: with the length of one exposure")
        self.each = each
        self.rules.check(self.hook.model)
        self._begin()

    def _begin(self) -> None:
        self._kept: OrderedDict[Any, Any] = OrderedDict()
        self._kept_of: Union[StreakModel, None] = None
        self._clear_starts = ClearStarts()
        self._observer: Any = None

    def __getstate__(self) -> dict[str, Any]:
        return {key: value for key, value in self.__dict__.items() if key not in ("_kept", "_kept_of", "_clear_starts", "_observer")}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._begin()

    @classmethod
    def for_block(cls, model: Union[StreakModel, Hook], block: Any, **options: Any) -> "SatelliteStreakConstraint":
        """A constraint with the exposures that one block holds, for its ``constraints``.

        Parameters
        ----------
        model : StreakModel or Hook
            As above; give all blocks one `Hook` and they count together.
        block : `~astroplan.ObservingBlock`
            One of ``ObservingBlock.from_exposures``; any other is exposed throughout.
        **options
            All other parameters of the class.

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
        """The answers for times and targets, broadcast against each other.

        Parameters
        ----------
        times : `~astropy.time.Time`
            Any shape; for the grids of ``PriorityScheduler`` ``(n_times,)``.
        observer : `~astroplan.Observer`
            Its location is held against the model's site.
        targets : `~astropy.coordinates.SkyCoord`
            Any frame and shape; for grids ``()`` or ``(n_targets, 1)``.

        Returns
        -------
        array of bool, or of float within ``worst_score`` to 1
            In the broadcast shape.
        """
        shape = np.broadcast_shapes(times.shape, () if targets is None else targets.shape)
        open_gate = np.ones(shape, dtype=bool if self.boolean_constraint else float)
        if observer is not None and observer is not self._observer:
            self._observer = observer
            self.hook.see_site(lambda: observer.location)
        if targets is None:
            self.hook.note("target", "no target was handed over; it is taken as observable")
            return open_gate
        return self.hook.ask(lambda model: self._answer(model, times, targets, open_gate), open_gate)

    def _answer(self, model: StreakModel, times: Time, targets: SkyCoord, open_gate: npt.NDArray[Any]) -> npt.NDArray[Any]:
        ra_deg, dec_deg = icrs_deg(targets)
        known = np.isfinite(ra_deg) & np.isfinite(dec_deg)
        if not known.all():
            missing = int((~known).sum())
            self.hook.note("target", f"targets without coordinates: {missing}; they are taken as observable", kind="target")
        starts_s = unix_s(times)
        meaning = meaning_of(starts_s, ra_deg.shape, self.rules.exposures, self.each)
        if meaning is Meaning.INSTANT:
            self.hook.note("instant", "a single time without an exposure is no interval; give SatelliteStreakConstraint(exposure=...)")
            return open_gate
        if meaning is Meaning.ALONE:
            return self._alone(model, ra_deg, dec_deg, starts_s, known, open_gate)
        # One row a target: (n_targets, 1) and () alike.
        rows = (np.where(known, ra_deg, 0.0).ravel(), np.where(known, dec_deg, 0.0).ravel())
        key = (rows[0].tobytes(), rows[1].tobytes(), starts_s.tobytes(), meaning)
        if self._kept_of is not model:
            self._kept, self._kept_of = OrderedDict(), model
        answer = self._kept.get(key)
        if answer is None:
            answer = self._block(model, *rows, starts_s) if meaning is Meaning.BLOCK else self._grid(model, *rows, starts_s, meaning)
            self._kept[key] = answer
            while len(self._kept) > KEPT_ANSWERS:
                self._kept.popitem(last=False)
        answer = answer.reshape(ra_deg.shape[:-1] + answer.shape[1:] if ra_deg.ndim else answer.shape[1:])
        return np.where(np.broadcast_to(known, open_gate.shape), answer, open_gate)

    def _block(self, model: StreakModel, ra_deg: FloatArray, dec_deg: FloatArray, starts_s: FloatArray) -> npt.NDArray[Any]:
        """The block's answer for each of its times: ``(n_targets, n_times)``."""
        block_s = float(starts_s[-1] - starts_s[0])
        overlong_s = self.rules.overlong_s(block_s)
        if overlong_s:
            message = f"a block of {block_s:.0f} s is asked about, its exposures last {overlong_s:.0f} s; all of them are looked at"
            self.hook.note("block", message, kind="block")
        if len(ra_deg) == 1:
            # SequentialScheduler weighs each target anew at every step of the night.
            place = (float(ra_deg[0]), float(dec_deg[0]))
            share = np.array([self._clear_starts.worth_of_block(model, self.rules, *place, float(starts_s[0]), block_s)])
        else:
            share = self.rules.worth_of_block(model, ra_deg, dec_deg, float(starts_s[0]), block_s)
        # SequentialScheduler multiplies over the times: (s^(1/n))^n = s
        whole = share == 1.0 if self.boolean_constraint else self._scored(share) ** (1.0 / len(starts_s))
        return np.repeat(whole[:, np.newaxis], len(starts_s), axis=1)

    def _grid(
        self, model: StreakModel, ra_deg: FloatArray, dec_deg: FloatArray, starts_s: FloatArray, meaning: Meaning
    ) -> npt.NDArray[Any]:
        """An answer for each time of a rising grid: ``(n_targets, n_times)``."""
        worth = np.empty((len(ra_deg), len(starts_s)))
        # To the millisecond: Julian dates make an even grid uneven by microseconds.
        lengths_s = np.round(cells_s(starts_s), 3)
        exposures, alone = self.rules.exposures, self.each == "exposure"
        for cell_s in np.unique(lengths_s):
            places = np.flatnonzero(lengths_s == cell_s)
            some = starts_s[places]
            if not self.boolean_constraint:
                # The exposures that begin within the cell, so that the mean over a block's cells is that over its exposures.
                offsets_s, length_s = exposures.begun_in(0.0 if alone else float(cell_s))
            else:
                offsets_s, length_s = np.zeros(1), float(cell_s)
                if meaning is Meaning.EXPOSURE and exposures.exposure_s is not None:
                    length_s = exposures.exposure_s if alone else max(exposures.exposure_s, length_s)
            each = [self.rules.worth(model, ra_deg, dec_deg, some + offset_s, length_s) for offset_s in offsets_s]
            worth[:, places] = np.mean(each, axis=0)
        return worth == 1.0 if self.boolean_constraint else self._scored(worth)

    def _alone(
        self, model: StreakModel, ra_deg: FloatArray, dec_deg: FloatArray, starts_s: FloatArray, known: Any, open_gate: npt.NDArray[Any]
    ) -> npt.NDArray[Any]:
        """Exposures that have nothing in common: the broadcast shape."""
        ra, dec, starts, fine = (np.broadcast_to(part, open_gate.shape).ravel() for part in (ra_deg, dec_deg, starts_s, known))
        where = np.flatnonzero(fine)
        length_s = float(self.rules.exposures.exposure_s or 0.0)
        worth = self.rules.worth_of_each(model, ra[where], dec[where], starts[where], length_s)
        answer = open_gate.ravel().copy()
        answer[where] = worth == 1.0 if self.boolean_constraint else self._scored(worth)
        return answer.reshape(open_gate.shape)

    def _scored(self, share: FloatArray) -> FloatArray:
        """A share of [0, 1] as a score of [worst, 1]."""
        return self.worst_score + (1.0 - self.worst_score) * share
