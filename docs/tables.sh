#!/usr/bin/env bash
# Makes the tables of docs/explanation/accuracy.md and docs/explanation/speed.md anew.
#   docs/tables.sh                       accuracy, from what the tests measure; the whole table needs the folder of STREAKCAST_DATA
#   docs/tables.sh speed                 speed, from what the benches and the tools beside them print: an hour on a quiet machine
#   docs/tables.sh speed --only streaks  of these the runs named alone, the rest as it was
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

case "${1:-accuracy}" in
    accuracy) [ $# -le 1 ] || { echo "usage: docs/tables.sh accuracy" >&2; exit 2; } ;;
    speed) shift; exec "${PYTHON:-python3}" docs/speed.py "$@" ;;
    *) echo "usage: docs/tables.sh [accuracy | speed [--only NAME,...] [--rounds N]]" >&2; exit 2 ;;
esac
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

STREAKCAST_FIGURES=$work/figures.tsv cargo test --quiet --tests valid_ >"$work/tests" 2>&1 || { cat "$work/tests"; exit 1; }
"${PYTHON:-python3}" docs/tables.py "$work/figures.tsv" >"$work/accuracy.md"
mv "$work/accuracy.md" docs/tables/accuracy.md
