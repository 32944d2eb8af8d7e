#!/usr/bin/env bash
# Measures the tables of docs/explanation/accuracy.md, measuring.md and speed.md again.
#   docs/tables.sh                       accuracy: runs the tests that compare with authorities, and those of measured
#                                        fluxes; needs STREAKCAST_DATA
#   docs/tables.sh speed                 speed: runs all benches, also with other programs; takes an hour
#   docs/tables.sh speed --only streaks  speed: runs only the named benches and keeps the other sections
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
cargo test --quiet --test images measure::verif_flux_is_unbiased -- --nocapture | grep '^|' >"$work/measuring.md"
mv "$work/accuracy.md" "$work/measuring.md" docs/tables/
