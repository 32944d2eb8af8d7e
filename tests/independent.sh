#!/usr/bin/env bash
# Output files are read by independent programs in a virtual environment: tracking data messages by ccsds-ndm, injected
# streaks by acstools. About a minute on two cores.
# STREAKCAST_BIN is the binary (default: it is built). Missing frames are skipped with a message; the synthetic one is always used.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

python=${PYTHON:-python3}
"$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "tests/independent.sh: $python is older than 3.11" >&2; exit 2; }
target=${CARGO_TARGET_DIR:-target}
if [ -z "${STREAKCAST_BIN:-}" ]; then
    cargo build --quiet
    STREAKCAST_BIN=$target/debug/streakcast
fi
# The environment is reused while the pinned versions and Python are the same.
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
