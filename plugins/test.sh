#!/usr/bin/env bash
# Tests of the plugins, each in an environment of its own: builds the command line and the wheel, then runs what each plugin brings.
# `plugins/test.sh [NAME...]`, all without a name; needs cargo, Python 3.11 or newer (the wheel runs from 3.10 on; the pinned tools do not)
# and a package index for the pinned requirements.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

# Every folder with pinned requirements is a plugin; `python` is the wheel that the others stand on.
all=(python)
for folder in plugins/*/; do
    name=$(basename "$folder")
    if [ "$name" != python ] && [ -f "$folder/requirements.txt" ]; then all+=("$name"); fi
done
usage="usage: plugins/test.sh [$(IFS='|'; echo "${all[*]}")]..."
names=()
for name in "$@"; do
    case "$name" in
        -h | --help) echo "$usage"; exit 0 ;;
        *) if [[ " ${all[*]} " == *" $name "* ]]; then names+=("$name"); else echo "$usage" >&2; exit 2; fi ;;
    esac
done
if [ ${#names[@]} = 0 ]; then names=("${all[@]}"); fi

command -v cargo >/dev/null || { echo "plugins/test.sh: cargo is not installed (see https://rustup.rs)" >&2; exit 2; }
python=${PYTHON:-python3}
"$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "plugins/test.sh: $python is older than 3.11" >&2; exit 2; }

target=$(cd "${CARGO_TARGET_DIR:-target}" 2>/dev/null && pwd || { mkdir -p "${CARGO_TARGET_DIR:-target}" && cd "${CARGO_TARGET_DIR:-target}" && pwd; })
export CARGO_TARGET_DIR=$target PIP_DISABLE_PIP_VERSION_CHECK=1

# The environment of a plugin; it stays from run to run while the pins are the same.
environment() {
    local venv=$target/plugins-venv-$1 requirements=plugins/$1/requirements.txt
    if ! sha256sum --check --status "$venv/requirements.sha256" 2>/dev/null; then
        rm -rf "$venv"
        "$python" -m venv "$venv"
        "$venv/bin/pip" install --quiet --requirement "$requirements"
        sha256sum "$requirements" >"$venv/requirements.sha256"
    fi
}

# What answers are compared with.
cargo build --quiet --bin streakcast
export STREAKCAST_BIN=$target/debug/streakcast

environment python
wheels=$(mktemp -d)
trap 'rm -rf "$wheels"' EXIT
PATH=$target/plugins-venv-python/bin:$PATH \
    maturin build --quiet --release --locked --manifest-path plugins/python/Cargo.toml --out "$wheels"

for name in "${names[@]}"; do
    echo "plugins/$name"
    environment "$name"
    (
        export PATH=$target/plugins-venv-$name/bin:$PATH
        pip install --quiet --force-reinstall --no-deps "$wheels"/*.whl
        if [ "$name" != python ]; then
            # Built from a copy: no build folders in the tree.
            cp -r "plugins/$name" "$wheels/$name"
            pip install --quiet --force-reinstall --no-deps "$wheels/$name"
        fi
        cd "plugins/$name"
        mypy --no-error-summary
        python -m pytest --quiet -rs
    )
done
