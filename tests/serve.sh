#!/usr/bin/env bash
# Tests `streakcast serve` in a browser, under load, and with schemathesis: `tests/serve.sh [--load SECONDS]`, or only in
# a browser: `tests/serve.sh --browser`. Installs pinned versions of chromium (apt), playwright-core and axe-core
# (npm), and schemathesis (pip); prints what is skipped if that is not possible. `--install` only installs them. STREAKCAST is the
# program (default: it is built), SERVE_PICTURES a folder for screenshots.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

usage="usage: tests/serve.sh [--install] [--browser | --load SECONDS]"
load_s=3 install=no browser=no
while [ $# -gt 0 ]; do
    case "$1" in
        --install) install=yes; shift ;;
        --browser) browser=yes; shift ;;
        --load) load_s=${2:?$usage}; shift 2 ;;
        -h | --help) echo "$usage"; exit 0 ;;
        *) echo "$usage" >&2; exit 2 ;;
    esac
done

skip() {
    echo "*** SKIPPED serve.sh: $1 ***"
    exit 0
}

command -v node >/dev/null && command -v npm >/dev/null || skip "no node or npm"
CHROMIUM=${CHROMIUM:-$(command -v chromium || true)}
if [ -z "$CHROMIUM" ]; then
    command -v apt-get >/dev/null || skip "no chromium, and no apt-get to install it"
    [ "$(id -u)" = 0 ] || skip "no chromium, and no right to install it (apt-get install chromium)"
    apt-get install -y --no-install-recommends chromium >/dev/null 2>&1 \
        || { apt-get update >/dev/null 2>&1 && apt-get install -y --no-install-recommends chromium >/dev/null 2>&1; } \
        || skip "apt-get cannot install chromium"
    CHROMIUM=$(command -v chromium)
fi
export CHROMIUM

. tests/environment.sh
# Installed in the build folder, and used again while the pinned versions are unchanged.
tools=$target/serve-tools
mkdir -p "$tools"
cp tests/serve/package.json tests/serve/package-lock.json tests/serve/*.mjs tests/serve/schemathesis.toml "$tools"
if ! sha256sum --check --status "$tools/lock.sha256" 2>/dev/null; then
    (cd "$tools" && npm ci --silent --no-audit --no-fund --ignore-scripts) || skip "npm cannot install playwright-core"
    (cd "$tools" && sha256sum "$tools/package-lock.json" >lock.sha256)
fi
if [ "$browser" = no ]; then environment serve tests/serve/requirements.txt || skip "pip cannot install schemathesis"; fi
if [ "$install" = yes ]; then exit; fi

if [ -z "${STREAKCAST:-}" ]; then
    cargo build --quiet --workspace --bin streakcast
    STREAKCAST=$target/debug/streakcast
fi
work=$(mktemp -d)
"$STREAKCAST" serve --bind 127.0.0.1:0 --rate 100000 --shells starlink-gen1 --schedule examples/night.csv --mpc X05 --fov 3.5deg \
    --limit-mag 7 --telescope rubin --quiet >"$work/address" 2>"$work/log" &
server=$!
trap 'kill "$server" 2>/dev/null || true; wait "$server" 2>/dev/null || true; rm -rf "$work"' EXIT
# Waits for at most ten minutes.
for _ in $(seq 6000); do
    [ -s "$work/address" ] && break
    kill -0 "$server" 2>/dev/null || { cat "$work/log" >&2; exit 1; }
    sleep 0.1
done
url=$(head -n 1 "$work/address")

node "$tools/browser.mjs" "$url" "$STREAKCAST" ${SERVE_PICTURES:+"$SERVE_PICTURES"}
if [ "$browser" = no ]; then
    node "$tools/load.mjs" "$url" "$server" "$load_s"
    # schemathesis sends valid and invalid values of every parameter. No response may be a server error or undocumented.
    (cd "$work" && "$target/venv-serve/bin/schemathesis" --config-file "$tools/schemathesis.toml" run "${url}openapi.json" --url "$url" --seed 1 --max-examples 60 --workers 2 --no-color \
        --checks not_a_server_error,status_code_conformance,content_type_conformance,response_schema_conformance,negative_data_rejection,unsupported_method \
        --request-timeout 300) | tail -n 60
fi

kill -TERM "$server"
wait "$server" || { echo "serve.sh: the server did not stop gracefully" >&2; exit 1; }
echo "serve.sh: all passed"
