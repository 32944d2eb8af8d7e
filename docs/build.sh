#!/usr/bin/env bash
# Builds the documentation site: `docs/build.sh [FOLDER]`, in target/site by default. Needs cargo (or STREAKCAST_BIN),
# Python 3.11 or newer and a package index. Pages of verbs, columns and the HTTP API, and all pictures, are made by the
# command line itself.
#   docs/build.sh --images    makes docs/images/ anew, which README.md and pages show; needs chromium and
#                             the folder of real data (STREAKCAST_DATA)
#   docs/build.sh --install   only creates the Python environment
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

python=${PYTHON:-python3}
"$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "docs/build.sh: $python is older than 3.11" >&2; exit 2; }
. tests/environment.sh
environment docs docs/requirements.txt
if [ "${1:-}" = --install ]; then exit; fi
if [ -z "${STREAKCAST_BIN:-}" ]; then
    cargo build --quiet --workspace --bin streakcast
    STREAKCAST_BIN=$target/debug/streakcast
fi
export STREAKCAST_BIN STREAKCAST_ROOT=$PWD

site=${1:-$target/site}

# The pictures of README.md: one exposure of examples/night.csv as `plot field` and as the page of `serve`.
if [ "${1:-}" = --images ]; then
    work=$(mktemp -d)
    exposure=(--shells starlink-gen1 --mpc X05 --telescope rubin --fov 3.5deg --quiet)
    "$STREAKCAST_BIN" plot field "${exposure[@]}" --start 2026-08-14T23:29:05Z --exposure 30s --ra 198.9 --dec 7.7 --no-data -o "$work/field.png"
    "$STREAKCAST_BIN" serve "${exposure[@]}" --schedule examples/night.csv --limit-mag 7 --bind 127.0.0.1:0 >"$work/address" &
    trap 'kill "$!" 2>/dev/null || true; rm -rf "$work"' EXIT
    until [ -s "$work/address" ]; do sleep 0.1; done
    "${CHROMIUM:-chromium}" --headless --no-sandbox --hide-scrollbars --window-size=1240,1460 --force-device-scale-factor=0.75 \
        --virtual-time-budget=10000 --screenshot="$work/serve.png" "$(cat "$work/address")" 2>/dev/null
    "$python" docs/lateness.py docs/tables/lateness.md docs/images/lateness.svg
    "$python" docs/brightness.py docs/tables/brightness.md docs/images/brightness.svg
    "$python" docs/magnitudes.py docs/tables/before-after.md docs/tables/before-after-phase.md docs/images/magnitudes.svg
    "$python" docs/completeness.py docs/tables/completeness.md docs/images/completeness.svg
    "$target/venv-docs/bin/python" docs/mask.py docs/images/mask.png
    "$python" docs/position_angles.py docs/tables/position-angles.md docs/images/position-angles.svg
    # 256 colours keep the files small.
    "$target/venv-docs/bin/python" -c 'import sys; from PIL import Image
for name in ("field", "serve"):
    Image.open(f"{sys.argv[1]}/{name}.png").convert("RGB").quantize(256, dither=0).save(f"docs/images/{name}.png", optimize=True)' "$work"
    ls -l docs/images
    exit
fi

source=$target/docs-source
rm -rf "$source"
cp -a docs "$source"
"$python" docs/generate.py "$STREAKCAST_BIN" "$source"
"$python" tests/docs.py --pictures "$source/pictures" docs/index.md docs/*/*.md
"$target/venv-docs/bin/sphinx-build" --quiet --fail-on-warning --keep-going -d "$target/site-doctrees" "$source" "$site"
echo "$site/index.html"
