"""Operator ephemerides are read in the same way as element sets."""

import pytest
import streakcast

from conftest import ROOT

DATA = ROOT / "tests" / "data"
MEME = DATA / "ephemerides" / "MEME_90001_INVENTED-1_2270000_Operational_1407628800_UNCLASSIFIED.txt.gz"
INSIDE, OUTSIDE = "2024-08-14T00:45:00Z", "2024-08-14T06:00:00Z"


@pytest.mark.parametrize("name", [MEME.name, "invented.oem", "invented_itrf.xml"])
def test_ephemerides_are_used_where_they_cover_the_time(name):
    files = [DATA / "elements" / "sample.csv", MEME.parent / name]
    for epoch, used in [(INSIDE, "satellites_covered"), (OUTSIDE, "satellites_not_covered")]:
        model = streakcast.StreakModel(lat=0.0, lon=0.0, fov="3.5deg", elements=files, epoch=epoch)
        provenance = model.provenance(epoch)
        assert provenance["elements"][1]["records"] in (91, 46)
        assert provenance["ephemerides"][used] == 1
