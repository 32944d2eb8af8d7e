# Virtual environments with pinned requirements in the build folder, for the scripts that source this file. Sets
# `target`, the build folder.

mkdir -p "${CARGO_TARGET_DIR:-target}"
target=$(cd "${CARGO_TARGET_DIR:-target}" && pwd)

# environment NAME REQUIREMENTS [PYTHON]: creates the environment $target/venv-NAME, or uses it again if pins and Python
# are unchanged.
environment() {
    local venv=$target/venv-$1 requirements=$2 interpreter=${3:-${PYTHON:-python3}} made_of
    made_of=$({ "$interpreter" -VV; "$interpreter" -c 'import sys; print(sys.base_prefix)'; cat "$requirements"; } | sha256sum) || return
    if [ "$(cat "$venv/made-of" 2>/dev/null)" != "$made_of" ]; then
        rm -rf "$venv"
        "$interpreter" -m venv "$venv" || return
        # Modules are compiled when they are imported: to compile all of them takes half of the time of an installation.
        "$venv/bin/pip" install --quiet --disable-pip-version-check --no-compile --requirement "$requirements" || return
        echo "$made_of" >"$venv/made-of"
    fi
}
