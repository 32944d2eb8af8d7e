#!/usr/bin/env bash
# Tests the plugins, each in its own virtual environment: builds the command line program and the wheel, then runs the
# tests of each plugin. `plugins/test.sh [NAME...]`; without a name all plugins. `--all` also runs tests that are marked
# `whole` (more nights of schedulers) and those under the oldest Python. `--install` only creates the environments.
# Requires cargo, Python 3.11 or newer (for the pinned tools) and a package index for the pinned
# requirements. The wheel supports Python 3.10 and newer: if there is a Python 3.10 (in the PATH or in pyenv), the tests
# that need only NumPy are also run with it. STREAKCAST_BIN is the command line program with which results are compared;
# by default it is built.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

# Every folder with pinned requirements is a plugin. The others depend on the wheel of `python`.
every=(python)
for folder in plugins/*/; do
    name=$(basename "$folder")
    if [ "$name" != python ] && [ -f "$folder/requirements.txt" ]; then every+=("$name"); fi
done
usage="usage: plugins/test.sh [--install] [--all] [$(IFS='|'; echo "${every[*]}")]..."
names=() install=no all=no
for name in "$@"; do
    case "$name" in
        -h | --help) echo "$usage"; exit 0 ;;
        --install) install=yes ;;
        --all) all=yes ;;
        *) if [[ " ${every[*]} " == *" $name "* ]]; then names+=("$name"); else echo "$usage" >&2; exit 2; fi ;;
    esac
done
if [ ${#names[@]} = 0 ]; then names=("${every[@]}"); fi

command -v cargo >/dev/null || { echo "plugins/test.sh: cargo is not installed (see https://rustup.rs)" >&2; exit 2; }
python=${PYTHON:-python3}
"$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "plugins/test.sh: $python is older than 3.11" >&2; exit 2; }

. tests/environment.sh
export CARGO_TARGET_DIR=$target PIP_DISABLE_PIP_VERSION_CHECK=1

# Finds a Python 3.10 that can create virtual environments. A pyenv shim may be in the PATH although this version is not
# installed.
python_3_10() {
    local one root=""
    if command -v pyenv >/dev/null; then root=$(pyenv root); fi
    for one in python3.10 "$root"/versions/3.10*/bin/python; do
        if "$one" -c 'import ensurepip, sys; sys.exit(sys.version_info[:2] != (3, 10))' >/dev/null 2>&1; then
            echo "$one"
            return
        fi
    done
}

for name in python "${names[@]}"; do
    environment "$name" "plugins/$name/requirements.txt"
done
oldest=""
if [[ $all = yes && " ${names[*]} " == *" python "* ]]; then
    oldest=$(python_3_10)
    if [ -n "$oldest" ]; then environment python-3.10 plugins/python/requirements-3.10.txt "$oldest"; fi
fi
if [ "$install" = yes ]; then exit; fi

# Command line program with which results are compared.
if [ -z "${STREAKCAST_BIN:-}" ]; then
    cargo build --quiet --workspace --bin streakcast
    STREAKCAST_BIN=$target/debug/streakcast
fi
export STREAKCAST_BIN

marked=(-m "not whole")
if [ "$all" = yes ]; then marked=(-m ""); fi
wheels=$(mktemp -d)
trap 'rm -rf "$wheels"' EXIT
# Built with the profile and the features of `cargo test --workspace`, to use what that has compiled: library and
# dependencies. Releases build the optimised wheel, with the features that it needs.
PATH=$target/venv-python/bin:$PATH \
    maturin build --quiet --profile dev --locked --manifest-path plugins/python/Cargo.toml --features streakcast/cli,streakcast/fit,streakcast/sqlite --out "$wheels"

for name in "${names[@]}"; do
    echo "plugins/$name"
    (
        export PATH=$target/venv-$name/bin:$PATH
        pip install --quiet --force-reinstall --no-deps "$wheels"/*.whl
        if [ "$name" != python ]; then
            # Built from a copy (no build folders in the source tree; links to the licences become files), with the
            # pinned tools of the environment.
            cp -rL "plugins/$name" "$wheels/$name"
            pip install --quiet --force-reinstall --no-deps --no-build-isolation "$wheels/$name"
        fi
        plugins/licences.py "$name"
        cd "plugins/$name"
        mypy --no-error-summary
        python -m pytest --quiet -rs "${marked[@]}"
    )
done

if [[ $all = yes && " ${names[*]} " == *" python "* ]]; then
    if [ -z "$oldest" ]; then
        echo "***** SKIPPED the wheel under Python 3.10: not found with venv in the PATH or among pyenv's versions ***"
    else
        echo "plugins/python under $("$oldest" -V)"
        (
            export PATH=$target/venv-python-3.10/bin:$PATH
            pip install --quiet --force-reinstall --no-deps "$wheels"/*.whl
            cd plugins/python
            # NumPy and the last astropy for this Python. The other tests need packages that are not available for it.
            python -m pytest --quiet -rs tests/test_{copies,threads,shapes,times,bad_input,hosts,quantities,tables,warnings}.py
        )
    fi
fi
