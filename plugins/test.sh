#!/usr/bin/env bash
# Tests of the plugins, each in an environment of its own: builds the command line and the wheel, then runs what the plugin brings.
# `plugins/test.sh [python]`; needs cargo, Python 3.11 or newer (the wheel runs from 3.10 on; the pinned tools do not) and a package index for the pinned requirements.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

usage="usage: plugins/test.sh [python]"
case "${1:-python}" in
    python) ;;
    -h | --help) echo "$usage"; exit 0 ;;
    *) echo "$usage" >&2; exit 2 ;;
esac

command -v cargo >/dev/null || { echo "plugins/test.sh: cargo is not installed (see https://rustup.rs)" >&2; exit 2; }
python=${PYTHON:-python3}
"$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "plugins/test.sh: $python is older than 3.11" >&2; exit 2; }

target=$(cd "${CARGO_TARGET_DIR:-target}" 2>/dev/null && pwd || { mkdir -p "${CARGO_TARGET_DIR:-target}" && cd "${CARGO_TARGET_DIR:-target}" && pwd; })
export CARGO_TARGET_DIR=$target
venv=$target/plugins-venv
requirements=plugins/python/requirements.txt

# The environment stays from run to run while the pins are the same.
stamp=$venv/requirements.sha256
if ! sha256sum --check --status "$stamp" 2>/dev/null; then
    rm -rf "$venv"
    "$python" -m venv "$venv"
    "$venv/bin/pip" install --quiet --disable-pip-version-check --requirement "$requirements"
    sha256sum "$requirements" >"$stamp"
fi
export PATH=$venv/bin:$PATH

# What answers are compared with.
cargo build --quiet --bin streakcast
export STREAKCAST_BIN=$target/debug/streakcast

wheels=$(mktemp -d)
trap 'rm -rf "$wheels"' EXIT
maturin build --quiet --release --locked --manifest-path plugins/python/Cargo.toml --out "$wheels"
pip install --quiet --disable-pip-version-check --force-reinstall --no-deps "$wheels"/*.whl

(cd plugins/python && mypy --no-error-summary python/streakcast)
(cd plugins/python && python -m pytest --quiet -rs)
