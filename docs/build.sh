#!/usr/bin/env bash
# The documentation as a site: `docs/build.sh [FOLDER]`, in target/site without one. Needs cargo, Python 3.11 or newer and a package index.
# A link that leads nowhere, a verb without a section or a page that no list names fails.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

python=${PYTHON:-python3}
"$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "docs/build.sh: $python is older than 3.11" >&2; exit 2; }
mkdir -p "${CARGO_TARGET_DIR:-target}"
target=$(cd "${CARGO_TARGET_DIR:-target}" && pwd)
site=${1:-$target/site}

# The environment stays from run to run while the pins are the same.
venv=$target/docs-venv
if ! sha256sum --check --status "$venv/requirements.sha256" 2>/dev/null; then
    rm -rf "$venv"
    "$python" -m venv "$venv"
    "$venv/bin/pip" install --quiet --disable-pip-version-check --requirement docs/requirements.txt
    sha256sum docs/requirements.txt >"$venv/requirements.sha256"
fi

cargo build --quiet --bin streakcast
export STREAKCAST_BIN=$target/debug/streakcast
"$venv/bin/sphinx-build" --quiet --fail-on-warning --keep-going -d "$target/site-doctrees" docs "$site"
echo "$site/index.html"
