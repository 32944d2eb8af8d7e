#!/usr/bin/env bash
# Reads output files with independent programs in a virtual environment: tracking data messages with ccsds-ndm, injected
# streaks with acstools. Takes about a minute on two cores.
# STREAKCAST_BIN is the program (default: it is built). Real frames that are missing are skipped with a message; a
# synthetic frame is always used.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

python=${PYTHON:-python3}
"$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "tests/independent.sh: $python is older than 3.11" >&2; exit 2; }
target=${CARGO_TARGET_DIR:-target}
if [ -z "${STREAKCAST_BIN:-}" ]; then
    cargo build --quiet
    STREAKCAST_BIN=$target/debug/streakcast
fi
# The environment is used again while the pinned versions and Python are unchanged.
venv=$target/independent-venv requirements=tests/reference/requirements.txt
made_of=$({ "$python" -VV; "$python" -c 'import sys; print(sys.base_prefix)'; cat "$requirements"; } | sha256sum)
if [ "$(cat "$venv/made-of" 2>/dev/null)" != "$made_of" ]; then
    rm -rf "$venv"
    "$python" -m venv "$venv"
    "$venv/bin/pip" install --quiet --disable-pip-version-check --requirement "$requirements"
    echo "$made_of" >"$venv/made-of"
fi
"$venv/bin/python" tests/reference/check_tdm.py "$STREAKCAST_BIN"
"$venv/bin/python" tests/reference/recover_streaks.py "$STREAKCAST_BIN" "${STREAKCAST_DATA:-../shared/data}"
