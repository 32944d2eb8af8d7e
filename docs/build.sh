#!/usr/bin/env bash
# The documentation as a site: `docs/build.sh [FOLDER]`, in target/site without one. Needs cargo (or STREAKCAST_BIN), Python 3.11 or newer and a package index.
# A link that leads nowhere, a verb, or one below it, without a section or a page that no list names fails.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

python=${PYTHON:-python3}
"$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "docs/build.sh: $python is older than 3.11" >&2; exit 2; }
mkdir -p "${CARGO_TARGET_DIR:-target}"
target=$(cd "${CARGO_TARGET_DIR:-target}" && pwd)
site=${1:-$target/site}

# The environment stays from run to run while the pins and Python are the same.
venv=$target/docs-venv
made_of=$({ "$python" -VV; "$python" -c 'import sys; print(sys.base_prefix)'; cat docs/requirements.txt; } | sha256sum)
if [ "$(cat "$venv/made-of" 2>/dev/null)" != "$made_of" ]; then
    rm -rf "$venv"
    "$python" -m venv "$venv"
    "$venv/bin/pip" install --quiet --disable-pip-version-check --requirement docs/requirements.txt
    echo "$made_of" >"$venv/made-of"
fi

# What the pages show is asked of a command line: the one that STREAKCAST_BIN names, else one is built.
if [ -z "${STREAKCAST_BIN:-}" ]; then
    cargo build --quiet --bin streakcast
    STREAKCAST_BIN=$target/debug/streakcast
fi
export STREAKCAST_BIN
"$venv/bin/sphinx-build" --quiet --fail-on-warning --keep-going -d "$target/site-doctrees" docs "$site"
echo "$site/index.html"
