"""Learned offsets from arrays, and their application to predictions."""

import numpy as np
import pytest

import streakcast
from streakcast import typing as types

#: Offset of the measured magnitudes, mag.
OFFSET = 0.8
SHELLS = dict(site="Rubin Observatory", shells="oneweb", fov="60deg")
START, TARGET = "2026-08-14T23:29:05Z", (198.9, 7.7)


def test_verif_offsets_of_a_kind_move_predictions(tmp_path):
    times = [f"2026-08-{day:02d}T23:29:05Z" for day in range(1, 11)]
    predicted = np.linspace(7.0, 8.0, 10)
    file = tmp_path / "learned.json"
    learned = streakcast.learn(np.arange(1, 11), times, predicted + OFFSET, predicted, kind="oneweb", output=file)
    magnitude = learned["kinds"][0]["magnitude"]
    assert (magnitude["satellites"], magnitude["passes"]) == (10, 10)
    assert abs(magnitude["offset_mag"] - OFFSET) < 0.1
    before = streakcast.StreakModel(**SHELLS).passes(TARGET, START, 30.0)
    after = streakcast.StreakModel(**SHELLS, learned=file).passes(TARGET, START, 30.0)
    assert len(before) == len(after) > 0
    moved = np.asarray(after["magnitude"], float) - np.asarray(before["magnitude"], float)
    np.testing.assert_allclose(moved, magnitude["offset_mag"], atol=1e-6)
    assert all(str(source).endswith("(learned)") for source in after["mag_source"])


def test_incomplete_rows_are_omitted_and_sigma_is_used():
    times = ["2026-08-01T00:00:00Z", "2026-08-02T00:00:00Z", "2026-08-03T00:00:00Z"]
    learned = streakcast.learn(7, times, [7.0, np.nan, 7.2], 6.5, kind="oneweb", sigma=0.3)
    assert learned["satellites"][0]["passes"] == 2
    assert learned["kinds"][0]["magnitude"]["point_sigma_mag"] == 0.3


def test_the_result_has_the_keys_of_its_type():
    learned = streakcast.learn(7, "2026-08-01T00:00:00Z", 7.0, 6.5, kind="oneweb")
    for part, kind in (
        (learned, types.Learned), (learned["kinds"][0], types.LearnedKind),
        (learned["kinds"][0]["magnitude"], types.LearnedMagnitude), (learned["satellites"][0], types.LearnedSatellite),
    ):  # fmt: skip
        assert set(part) == kind.__required_keys__
    assert learned["kinds"][0]["lateness"] is None


@pytest.mark.parametrize(
    "change, text",
    [
        ({"kind": "twoweb"}, "twoweb"),
        ({"kind": "other"}, "no brightness model"),
        ({"norad_id": [0]}, "integers from 1"),
        ({"norad_id": [1.5]}, "integers from 1"),
        ({"observed": [1.0, 2.0, 3.0], "time": ["2026-08-01T00:00:00Z"] * 2}, "one shape"),
        ({"observed": [np.nan]}, "nothing to learn"),
        ({"observed": [1000.0]}, r"observed\[0\] is 1000.0; allowed: magnitudes from -30 to 40"),
        ({"sigma": [-1.0]}, r"sigma\[0\] is -1.0; allowed: mag from 0 to 10"),
        ({"norad_id": np.ma.MaskedArray([1], mask=[True])}, "norad_id\\[0\\] is masked"),
    ],
)
def test_invalid_arguments_are_named(change, text):
    given = dict(norad_id=[1], time=["2026-08-01T00:00:00Z"], observed=[7.0], predicted=[6.0], kind="oneweb")
    given.update(change)
    with pytest.raises(ValueError, match=text):
        streakcast.learn(**given)
