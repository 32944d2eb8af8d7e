#!/usr/bin/env bash
# Makes the table of docs/accuracy.md anew, from what the tests measure: `docs/tables.sh`. The whole table needs the folder of STREAKCAST_DATA.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

if [ $# != 0 ]; then
    echo "usage: docs/tables.sh" >&2
    exit 2
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

STREAKCAST_FIGURES=$work/figures.tsv cargo test --quiet --tests valid_ >"$work/tests" 2>&1 || { cat "$work/tests"; exit 1; }
"${PYTHON:-python3}" docs/tables.py "$work/figures.tsv" >"$work/accuracy.md"
mv "$work/accuracy.md" docs/tables/accuracy.md
