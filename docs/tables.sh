#!/usr/bin/env bash
# Measures tables of the documentation again.
#   docs/tables.sh                       accuracy: runs the tests that compare with authorities; needs STREAKCAST_DATA
#   docs/tables.sh measuring             runs the ignored test `fluxes_of_many` (some 2,600 streaks)
#   docs/tables.sh coverage              runs the ignored test `coverage_of_many` (6,000 streaks)
#   docs/tables.sh lu2024                runs `streakcast reproduce lu2024`; needs STREAKCAST_DATA
#   docs/tables.sh speed                 runs all benches, also with other programs; takes an hour
#   docs/tables.sh speed --only streaks  runs only the named benches and keeps the other sections
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

usage="usage: docs/tables.sh [accuracy | measuring | coverage | lu2024 | speed [--only NAME,...] [--rounds N]]"
python=${PYTHON:-python3}
mode=${1:-accuracy}
if [ "$mode" = speed ]; then shift; exec "$python" docs/speed.py "$@"; fi
if [ $# -gt 1 ]; then echo "$usage" >&2; exit 2; fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

case "$mode" in
    accuracy)
        STREAKCAST_FIGURES=$work/figures.tsv cargo test --quiet --tests valid_ >"$work/tests" 2>&1 || { cat "$work/tests"; exit 1; }
        "$python" docs/tables.py "$work/figures.tsv" >"$work/$mode.md"
        ;;
    measuring)
        cargo test --quiet --test images fluxes_of_many -- --ignored --nocapture >"$work/log"
        grep '^|' "$work/log" >"$work/$mode.md" || { echo "docs/tables.sh: fluxes_of_many prints no table" >&2; exit 1; }
        ;;
    coverage)
        cargo test --quiet --test images coverage_of_many -- --ignored --nocapture >"$work/log"
        grep '^|' "$work/log" >"$work/$mode.md" || { echo "docs/tables.sh: coverage_of_many prints no table" >&2; exit 1; }
        ;;
    lu2024)
        # Table 1 counts satellites in element sets of six years, because many have reentered. The sets have names, by
        # which debris is recognised.
        tle=${STREAKCAST_DATA:-../shared/data}/tle
        cargo run --quiet --release -- reproduce lu2024 --quiet -o "$work/lu2024" --elements "$tle"/fullcat/TLE3_2023-04-07.txt \
            "$tle"/mmt_2021/* "$tle"/pomenis_2022/* "$tle"/active/* >/dev/null
        "$python" docs/tables.py --lu2024 "$work/lu2024/table.csv" >"$work/$mode.md"
        ;;
    *) echo "$usage" >&2; exit 2 ;;
esac
mv "$work/$mode.md" docs/tables/
