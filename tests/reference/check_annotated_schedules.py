"""Compares annotated schedules with their originals: cells, types, units, descriptions, meta and order.

    python check_annotated_schedules.py ../data/schedules FOLDER

FOLDER contains the annotated files with the same names, and their .streaks files. Run manually; requires astropy 8.
"""
import json
import sys
from pathlib import Path

import numpy as np
from astropy.io.votable import parse
from astropy.table import Table

samples, folder = Path(sys.argv[1]), Path(sys.argv[2])


def same_column(old, new, name):
    masks = [np.ma.getmaskarray(np.ma.asarray(column)) for column in (old, new)]
    assert (masks[0] == masks[1]).all(), name
    assert old.dtype == new.dtype or old.dtype.kind == new.dtype.kind == "U", (name, old.dtype, new.dtype)
    equal = (np.asarray(old) == np.asarray(new)) | masks[0]
    if old.dtype.kind == "f":
        equal |= np.isnan(np.asarray(old)) & np.isnan(np.asarray(new))
    assert equal.all(), name
    assert (old.unit, old.description) == (new.unit, new.description), name


def same_table(name, read):
    old, new = read(samples / name), read(folder / name)
    assert new.colnames[: len(old.colnames)] == old.colnames
    for column in old.colnames:
        same_column(old[column], new[column], f"{name} {column}")
    assert json.dumps(dict(old.meta), default=str) == json.dumps(dict(new.meta), default=str), name
    verdicts = list(new["verdict"])
    assert len(verdicts) == len(old) and set(verdicts) <= {"clear", "streaked", "avoid", "invalid"}
    print(f"{name}: {len(old)} rows, {len(old.colnames)} columns identical; {verdicts.count('clear')} clear")


same_table("consdb.csv", lambda path: Table.read(path, format="ascii.csv"))
same_table("consdb.ecsv", lambda path: Table.read(path, format="ascii.ecsv"))
same_table("consdb_comma.ecsv", lambda path: Table.read(path, format="ascii.ecsv"))
same_table("consdb.vot", lambda path: parse(path).get_first_table().to_table())
streaks = [len(Table.read(folder / "consdb.streaks.csv", format="ascii.csv", comment="#")), len(Table.read(folder / "consdb.streaks.ecsv", format="ascii.ecsv"))]
streaks.append(len(list(parse(folder / "consdb.vot").iter_tables())[1].to_table()))
for name, rows in (("obsplan.json", lambda document: document), ("obsplan_object.json", lambda document: document["exposures"])):
    old, new = (rows(json.loads((place / name).read_text())) for place in (samples, folder))
    assert [{key: row[key] for key in before} for before, row in zip(old, new, strict=True)] == old
    assert all(list(row)[: len(before)] == list(before) for before, row in zip(old, new))
    print(f"{name}: {len(old)} rows identical")
assert len(set(streaks)) == 1, streaks
print(f"streaks: {streaks[0]} in each")
