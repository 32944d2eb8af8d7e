#!/usr/bin/env bash
# Runs all checks of the project, with one line of output per step. `tests/run.sh --quick` before a commit;
# `tests/run.sh` before a merge.
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
beside=""
trap 'if [ -n "$beside" ]; then kill -- "-$beside" 2>/dev/null || true; fi; rm -rf "$log"' EXIT
begin=$SECONDS

# step NAME COMMAND...: runs a command and prints its time. If it fails, prints the lines with errors and then the whole
# output.
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
            echo "--- whole output of $name:"
        fi
        cat "$log/step"
        exit "$code"
    fi
    cat "$log/step" >>"$log/all"
}

# start_beside COMMAND...: starts a command in parallel to the next steps, in its own process group; `finish_beside`
# waits until it ends.
start_beside() {
    set -m
    "$@" >"$log/beside" 2>&1 &
    beside=$!
    set +m
}

finish_beside() {
    local code=0
    wait "$beside" || code=$?
    beside=""
    cat "$log/beside"
    return "$code"
}

# skipped TEXT: prints what is skipped, now and in the summary.
skipped() {
    echo "*** SKIPPED $*" | tee -a "$log/all"
}

# Prints what was skipped, and the sums of the "test result" lines of Rust and of the last lines of pytest.
counts() {
    grep -ahoE '\*\*\* SKIPPED [^ ]+: no real data' "$log/all" | sed 's/\*\*\* SKIPPED /skipped (no data folder): /; s/: no real data$//' | sort -u || true
    grep -ahoE '\*\*\* SKIPPED .*' "$log/all" | grep -vE ': no real data' | sed 's/\*\*\* SKIPPED /skipped: /; s/ \*\*\*$//; s/"*, stacklevel.*//' | sort -u || true
    # Measured values that tests print without checking them.
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

# Installs the programs of later steps, which mostly waits for the network.
install_programs() {
    if [ "${STREAKCAST_PLUGINS:-yes}" != no ]; then
        plugins/test.sh --install
        tests/independent.sh --install
        docs/build.sh --install
    fi
    if [ "${STREAKCAST_SERVE:-yes}" != no ]; then tests/serve.sh --install; fi
}

lint=(-- -D warnings)
step "cargo fmt --check" cargo fmt --check
step "cargo fmt --check (plugins/python)" cargo fmt --check --manifest-path plugins/python/Cargo.toml
if [ "$mode" = quick ]; then
    step "cargo clippy (library and command line)" cargo clippy --quiet --lib --bins "${lint[@]}"
    step "cargo test --lib, import rules" cargo test --lib --test imports
else
    start_beside install_programs
    # Tests are built with all features only. Other sets of features are only checked, further below.
    step "cargo clippy --all-targets" cargo clippy --quiet --all-targets --all-features "${lint[@]}"
    # Twice as many tests as cores at a time, because many wait for a server, a clock or another process.
    export RUST_TEST_THREADS=${RUST_TEST_THREADS:-$((2 * $(getconf _NPROCESSORS_ONLN)))}
    step "cargo test" cargo test --all-features
    step "programs of the next steps (the rest of it)" finish_beside
    # Uses the binary built by the tests. `cargo build` would build it again, without features that development
    # dependencies enable.
    target=$(cd "${CARGO_TARGET_DIR:-target}" && pwd)
    mkdir "$log/bin"
    cp "$target/debug/streakcast" "$log/bin/streakcast"
    export STREAKCAST=$log/bin/streakcast STREAKCAST_BIN=$log/bin/streakcast
    # The plugins are tested in their own environments, with packages from the index; STREAKCAST_PLUGINS=no skips them.
    # They take as long as all other steps after `cargo test` and mostly use one core, so they run in parallel.
    if [ "${STREAKCAST_PLUGINS:-yes}" = no ]; then
        skipped "plugins and the site of the documentation: STREAKCAST_PLUGINS=no"
    else
        start_beside plugins/test.sh
    fi
    step "cargo doc" env RUSTDOCFLAGS="-D warnings" cargo doc --quiet --no-deps
    step "default features" cargo check --quiet
    step "without features" cargo check --quiet --no-default-features
    step "cli alone" cargo check --quiet --no-default-features --features cli
    step "serve and fit" cargo check --quiet --no-default-features --features serve,fit
    step "fits, plot and sqlite" cargo check --quiet --no-default-features --features fits,plot,sqlite
    step "example flag_exposures" cargo run --quiet --all-features --example flag_exposures
    step "example forecast_night" cargo run --quiet --all-features --example forecast_night
    step "example identify_streak" cargo run --quiet --all-features --example identify_streak
    step "example plot_pass" cargo run --quiet --all-features --example plot_pass -- "$log"
    step "example sky_map" cargo run --quiet --all-features --example sky_map
    step "example fit_photometry" cargo run --quiet --all-features --example fit_photometry
    step "example inject_streaks" cargo run --quiet --all-features --example inject_streaks
    step "a synthetic frame with the README's streaks" "$STREAKCAST_BIN" inject --synthetic examples/synthetic.toml \
        -o "$log/streaked.fits" --random-streaks 3 --magnitude 4,7 --exposure 30s --seeing 1.5arcsec --seed 1
    step "example learn_offsets" cargo run --quiet --all-features --example learn_offsets
    step "example charts" cargo run --quiet --all-features --example charts -- "$log"
    step "the gate against INDI's server and simulators" tests/indi.sh
    # Requires programs from the package index; STREAKCAST_PLUGINS=no skips this step and the plugins.
    if [ "${STREAKCAST_PLUGINS:-yes}" = no ]; then
        skipped "independent.sh: STREAKCAST_PLUGINS=no"
    else
        step "outputs read by independent programs" tests/independent.sh
    fi
    # Installs its requirements with apt, npm and pip; STREAKCAST_SERVE=no skips this step.
    if [ "${STREAKCAST_SERVE:-yes}" = no ]; then
        skipped "serve.sh: STREAKCAST_SERVE=no"
    else
        step "serve: page in a browser, load, and fuzzing of the API" tests/serve.sh
    fi
    # Commands that require real data are skipped with a message if the folder STREAKCAST_DATA is missing.
    step "commands of the README and the documentation" tests/docs.py
    if [ "${STREAKCAST_PLUGINS:-yes}" != no ]; then
        step "docs/build.sh" docs/build.sh
        step "plugins/test.sh (the rest of it)" finish_beside
    fi
fi
counts
echo "all passed in $((SECONDS - begin)) s"
