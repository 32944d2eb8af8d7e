#!/usr/bin/env bash
# All checks of the project, one line a step. `tests/run.sh --quick` is for before a commit, `tests/run.sh` for before a merge.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

usage="usage: tests/run.sh [--quick]"
mode=full
for argument in "$@"; do
    case "$argument" in
        --quick) mode=quick ;;
        -h | --help) echo "$usage"; exit 0 ;;
        *) echo "$usage" >&2; exit 2 ;;
    esac
done

command -v cargo >/dev/null || { echo "tests/run.sh: cargo is not installed (see https://rustup.rs)" >&2; exit 2; }

log=$(mktemp -d)
trap 'rm -rf "$log"' EXIT
begin=$SECONDS

# step NAME COMMAND...: runs it, says how long it took, and shows what it wrote only where it failed: what failed first, then all of it.
step() {
    local name=$1 start=$SECONDS
    shift
    if "$@" >"$log/step" 2>&1; then
        printf 'ok    %4d s  %s\n' $((SECONDS - start)) "$name"
    else
        local code=$?
        printf 'FAIL  %4d s  %s\n' $((SECONDS - start)) "$name"
        if grep -aE -A 6 'panicked at|^error|^(FAILED|ERROR) |^E  |\.\.\. FAILED|No space left' "$log/step" | sed -n 1,80p >"$log/failed"; then
            cat "$log/failed"
            echo "--- all that $name wrote:"
        fi
        cat "$log/step"
        exit "$code"
    fi
    cat "$log/step" >>"$log/all"
}

# skipped WHAT: says loudly what is left out, here and in the sum.
skipped() {
    echo "*** SKIPPED $*" | tee -a "$log/all"
}

# What was left out, and the sums of Rust's "test result" lines and of pytest's last lines.
counts() {
    grep -ahoE '\*\*\* SKIPPED [^ ]+: no real data' "$log/all" | sed 's/\*\*\* SKIPPED /left out (no data folder): /; s/: no real data$//' | sort -u || true
    grep -ahoE '\*\*\* SKIPPED .*' "$log/all" | grep -vE ': no real data' | sed 's/\*\*\* SKIPPED /left out: /; s/ \*\*\*$//; s/"*, stacklevel.*//' | sort -u || true
    # What was measured by the way, which is no test.
    grep -ahoE '[0-9]+ moves: median.*|[0-9]+ passes, .* read by ccsds-ndm.*' "$log/all" || true
    awk '/^test result:/ { passed += $4; failed += $6; ignored += $8; suites += 1 }
         / in [0-9.]+s/ && !/^test result:/ && /[0-9]+ (passed|failed|skipped|error)/ {
             python += 1
             for (i = 2; i <= NF; i++) { if ($i ~ /^passed/) pytest += $(i - 1); if ($i ~ /^skipped/) left += $(i - 1) }
         }
         END {
             printf "%d suites: %d of Rust with %d tests, %d of Python with %d\n", suites + python, suites, passed, python, pytest
             printf "%d passed, %d failed, %d skipped\n", passed + pytest, failed, ignored + left
         }' "$log/all"
}

lint=(-- -D warnings)
step "cargo fmt --check" cargo fmt --check
if [ "$mode" = quick ]; then
    step "cargo clippy (library and command line)" cargo clippy --quiet --lib --bins "${lint[@]}"
    step "cargo test --lib, import rules" cargo test --lib --test imports
else
    # With every feature, in one build.
    step "cargo clippy --all-targets" cargo clippy --quiet --all-targets --all-features "${lint[@]}"
    step "cargo test" cargo test --all-features
    # The command line as the tests built it. `cargo build` would leave out the features that development dependencies add and build it again.
    target=$(cd "${CARGO_TARGET_DIR:-target}" && pwd)
    mkdir "$log/bin"
    cp "$target/debug/streakcast" "$log/bin/streakcast"
    export STREAKCAST=$log/bin/streakcast STREAKCAST_BIN=$log/bin/streakcast
    step "cargo doc" env RUSTDOCFLAGS="-D warnings" cargo doc --quiet --no-deps
    step "default features" cargo check --quiet
    step "without features" cargo check --quiet --no-default-features
    step "cli alone" cargo check --quiet --no-default-features --features cli
    step "sqlite alone" cargo check --quiet --no-default-features --features sqlite
    step "cli and fit" cargo check --quiet --no-default-features --features cli,fit
    step "serve alone" cargo check --quiet --no-default-features --features serve
    step "fits and plot alone" cargo check --quiet --no-default-features --features fits,plot
    step "example flag_exposures" cargo run --quiet --all-features --example flag_exposures
    step "example forecast_night" cargo run --quiet --all-features --example forecast_night
    step "example identify_streak" cargo run --quiet --all-features --example identify_streak
    step "example plot_pass" cargo run --quiet --all-features --example plot_pass -- "$log"
    step "example sky_map" cargo run --quiet --all-features --example sky_map
    step "example fit_photometry" cargo run --quiet --all-features --example fit_photometry
    step "example inject_streaks" cargo run --quiet --all-features --example inject_streaks
    step "a synthetic frame with the README's streaks" "$STREAKCAST_BIN" inject --synthetic examples/synthetic.toml \
        -o "$log/streaked.fits" --random-streaks 3 --magnitude 4,7 --exposure 30s --seeing 1.5arcsec --seed 1
    step "example charts" cargo run --quiet --all-features --example charts -- "$log"
    step "the gate against INDI's server and simulators" tests/indi.sh
    # With programs from the package index; STREAKCAST_PLUGINS=no leaves them out with the plugins.
    if [ "${STREAKCAST_PLUGINS:-yes}" = no ]; then
        skipped "independent.sh: STREAKCAST_PLUGINS=no"
    else
        step "what comes out, read by others" tests/independent.sh
    fi
    # In a browser, under load and a fuzz; chromium, npm and pip are asked for what is needed. STREAKCAST_SERVE=no leaves it out.
    if [ "${STREAKCAST_SERVE:-yes}" = no ]; then
        skipped "serve.sh: STREAKCAST_SERVE=no"
    else
        step "the page in a browser, under load, and a fuzz of its API" tests/serve.sh
    fi
    # What the pages show is what comes out: every line of the answer stands in them. `transcript [--exits CODE] PAGE ARGUMENT...`, where
    # the command is expected to end with another code than 0.
    transcript() {
        local expected=0 code=0
        if [ "$1" = --exits ]; then expected=$2; shift 2; fi
        local page=$1
        shift
        NO_COLOR=1 "$STREAKCAST_BIN" "$@" --format table >"$log/answer.raw" 2>&1 || code=$?
        if [ "$code" != "$expected" ]; then
            cat "$log/answer.raw"
            echo "streakcast $* ended with $code, not $expected ($page)"
            return 1
        fi
        sed 's/[ ]*$//' "$log/answer.raw" >"$log/answer"
        if ! [ -s "$log/answer" ] || grep -vxFf "$page" "$log/answer"; then
            echo "$page does not show these lines of: streakcast $*"
            return 1
        fi
    }
    first=(--shells starlink-gen1 --mpc X05 --telescope rubin --fov 3.5deg)
    step "the README's main job" transcript README.md flag "${first[@]}" --schedule examples/night.csv --limit-mag 7
    step "the README's passes" transcript README.md passes "${first[@]}" --start 2026-08-14T23:29:05Z \
        --exposure 30s --ra 198.9 --dec 7.7
    step "docs/forecast.md" transcript docs/forecast.md forecast --shells starlink-gen1 --mpc X05 --night 2026-08-14 --max-mag 5 --min-culmination 86
    step "docs/forecast.md, a bright night" transcript docs/forecast.md forecast --shells starlink-gen1 --lat 60.17 --lon 24.94 --night 2026-06-21 \
        --sun-altitude-deg -12
    step "docs/policy.md" transcript docs/policy.md flag --config examples/streakcast.toml --schedule examples/night.csv
    data=${STREAKCAST_DATA:-../shared/data}
    if [ -f "$data/INDEX.md" ]; then
        step "docs/models.md" transcript docs/models.md model check --data "$data"
        step "docs/statistics.md" transcript docs/statistics.md reproduce hu2022 --schedule "$data/schedules/baseline_10klines_2.0.db" \
            --time-scale utc -q
        step "docs/space.md" transcript docs/space.md passes --elements "$data/tle/active/active_2026-04-25.txt" \
            --observer-norad 20580 --fov 3.4arcmin -q --start 2026-04-26T15:12:00Z --exposure 11min --ra 257.09 --dec=57.37
        boley=$data/photometry/boley2021_plaskett
        step "docs/identify.md" transcript docs/identify.md identify --region "$boley/regFiles/box-000013.reg" -q --top 3 \
            --start 2021-07-16T08:41:49.5Z --exposure 30s --elements "$boley/starlink.15JUL2021" --mpc 658
        step "docs/fetch.md" transcript docs/fetch.md doctor --elements "$data/tle/daily/starlink_2026-08-21.tle" --mpc X05 \
            --telescope rubin --now 2026-08-23T00:00:00Z --cache cache
    else
        for page in models statistics space identify fetch; do
            skipped "the transcripts of docs/$page.md: no data folder $data (STREAKCAST_DATA)"
        done
    fi
    step "examples/field.json" "$STREAKCAST_BIN" flag "${first[@]:0:4}" --field examples/field.json \
        --schedule examples/night.csv
    # In an environment of their own, from the package index; where there is none, STREAKCAST_PLUGINS=no leaves them out.
    if [ "${STREAKCAST_PLUGINS:-yes}" = no ]; then
        skipped "plugins and the site of the documentation: STREAKCAST_PLUGINS=no"
    else
        step "plugins/test.sh" plugins/test.sh
        step "docs/build.sh" docs/build.sh
    fi
fi
counts
echo "all passed in $((SECONDS - begin)) s"
