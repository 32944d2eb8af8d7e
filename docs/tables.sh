#!/usr/bin/env bash
# Makes the tables of docs/accuracy.md and docs/speed.md anew, from what the tests and benches measure on this machine:
# `docs/tables.sh [accuracy|speed]`, both without a word. Accuracy needs the folder of STREAKCAST_DATA for its whole table, speed an idle
# machine, a package index, and some twenty minutes.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

what=${1:-all}
case "$what" in
    accuracy | speed | all) ;;
    *) echo "usage: docs/tables.sh [accuracy|speed]" >&2; exit 2 ;;
esac
python=${PYTHON:-python3}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

if [ "$what" != speed ]; then
    STREAKCAST_FIGURES=$work/figures.tsv cargo test --quiet --tests valid_ >"$work/tests" 2>&1 || { cat "$work/tests"; exit 1; }
    "$python" docs/tables.py accuracy "$work/figures.tsv" >"$work/accuracy.md"
    mv "$work/accuracy.md" docs/tables/accuracy.md
fi

if [ "$what" != accuracy ]; then
    mkdir -p "${CARGO_TARGET_DIR:-target}"
    venv=$(cd "${CARGO_TARGET_DIR:-target}" && pwd)/peers-venv
    requirements=tests/benches/peers/requirements-models.txt
    if ! sha256sum --check --status "$venv/requirements.sha256" 2>/dev/null; then
        rm -rf "$venv"
        "$python" -m venv "$venv"
        "$venv/bin/pip" install --quiet --disable-pip-version-check --requirement "$requirements"
        # Its own pins are of 2022 and do not install any more; it runs with today's.
        "$venv/bin/pip" install --quiet --disable-pip-version-check --no-deps lumos-sat==1.0.9
        sha256sum "$requirements" >"$venv/requirements.sha256"
    fi
    cargo bench --no-run --quiet
    cargo bench --quiet --bench catalogue --bench night --bench maps --bench reduce --bench frame_files >"$work/benches"
    for peer in photometry fit streaks; do
        "$venv/bin/python" "tests/benches/peers/$peer.py" --rounds 3 >"$work/$peer"
    done
    "$python" docs/tables.py speed "$work" >"$work/speed.md"
    mv "$work/speed.md" docs/tables/speed.md
fi
