#!/usr/bin/env bash
# Reads output files with independent programs in a virtual environment: tracking data messages with ccsds-ndm, injected
# streaks with acstools. Takes about a minute on two cores.
# STREAKCAST_BIN is the program (default: it is built). Real frames that are missing are skipped with a message; a
# synthetic frame is always used. `--install` only creates the environment.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

python=${PYTHON:-python3}
"$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "tests/independent.sh: $python is older than 3.11" >&2; exit 2; }
. tests/environment.sh
environment independent tests/reference/requirements.txt
if [ "${1:-}" = --install ]; then exit; fi
if [ -z "${STREAKCAST_BIN:-}" ]; then
    cargo build --quiet --workspace --bin streakcast
    STREAKCAST_BIN=$target/debug/streakcast
fi
"$target/venv-independent/bin/python" tests/reference/check_tdm.py "$STREAKCAST_BIN"
"$target/venv-independent/bin/python" tests/reference/recover_streaks.py "$STREAKCAST_BIN" "${STREAKCAST_DATA:-../shared/data}"
