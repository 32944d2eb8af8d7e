#!/usr/bin/env bash
# Runs the tests of the project, with one line of output per step: its time, and its processor time on all cores.
#
#   tests/run.sh --quick   before a commit: format, lints, unit tests, import rules
#   tests/run.sh           shows that everything works on this machine: Rust tests, Python package, one night with each
#                          scheduler, commands of the documentation, the page of `serve` in a browser
#   tests/run.sh --all     before a merge, and in CI: also what LONG lists below
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

# What only `--all` runs, with its processor time in seconds (November 2026, a loaded machine; - if not measured).
LONG="   45  samples of measured streaks
   12  samples of crossing probabilities
   45  more schedules with astroplan
   60  more nights with Rubin's scheduler
  169  lints of all targets
   59  documentation of the library without warnings
    -  library without features and without a C compiler; with fit; with fits, plot and sqlite
    -  examples
    -  gate against INDI's server
   43  outputs read by independent programs
    -  serve under load, and fuzzing of the API
    -  wheel under Python 3.10
   31  site of the documentation"
usage="usage: tests/run.sh [--quick | --all]"
mode=default
for argument in "$@"; do
    case "$argument" in
        --quick) mode=quick ;;
        --all) mode=all ;;
        -h | --help) printf '%s\n\nOnly with --all:\n%s\n' "$usage" "$LONG"; exit 0 ;;
        *) echo "$usage" >&2; exit 2 ;;
    esac
done

command -v cargo >/dev/null || { echo "tests/run.sh: cargo is not installed (see https://rustup.rs)" >&2; exit 2; }

log=$(mktemp -d)
# Process groups that run in parallel to the steps.
beside_programs="" beside_plugins=""
trap 'for group in $beside_programs $beside_plugins; do kill -- "-$group" 2>/dev/null || true; done; rm -rf "$log"' EXIT
begin=$SECONDS

# step NAME COMMAND...: runs a command and prints its times. If it fails, prints the lines with errors and then the whole
# output.
step() {
    local name=$1 start=$SECONDS code=0 user system TIMEFORMAT='%0U %0S'
    shift
    { time "$@" >"$log/step" 2>&1; } 2>"$log/time" || code=$?
    read -r user system < <(tail -n 1 "$log/time")
    local times
    times=$(printf '%4d s (processor %4d s)' $((SECONDS - start)) $((user + system)))
    if [ "$code" != 0 ]; then
        echo "FAIL  $times  $name"
        if grep -aE -A 6 'panicked at|^error|^(FAILED|ERROR) |^E  |\.\.\. FAILED|No space left' "$log/step" | sed -n 1,80p >"$log/failed"; then
            cat "$log/failed"
            echo "--- whole output of $name:"
        fi
        cat "$log/step"
        exit "$code"
    fi
    echo "ok    $times  $name"
    cat "$log/step" >>"$log/all"
}

# start_beside programs|plugins COMMAND...: starts a command in parallel to the next steps, in its own process group;
# `finish_beside` waits until it ends.
start_beside() {
    local name=$1
    shift
    set -m
    "$@" >"$log/beside-$name" 2>&1 &
    printf -v "beside_$name" %s "$!"
    set +m
}

finish_beside() {
    local code=0 group=beside_$1
    wait "${!group}" || code=$?
    printf -v "$group" %s ""
    cat "$log/beside-$1"
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

is_all() { [ "$mode" = all ]; }
with_plugins() { [ "${STREAKCAST_PLUGINS:-yes}" != no ]; }
with_serve() { [ "${STREAKCAST_SERVE:-yes}" != no ]; }

# Programs of the steps after the Rust tests. Mostly waits for the network.
install_programs() {
    if with_serve; then tests/serve.sh --install ${serve[@]+"${serve[@]}"}; fi
    if is_all; then
        tests/indi.sh --install
        if with_plugins; then
            tests/independent.sh --install
            docs/build.sh --install
        fi
    fi
}

# Installs the environments of the plugins while the program is built, and tests the plugins beside the Rust tests.
test_plugins() {
    plugins/test.sh --install ${plugins[@]+"${plugins[@]}"}
    until [ -e "$STREAKCAST_BIN" ]; do sleep 1; done
    plugins/test.sh ${plugins[@]+"${plugins[@]}"}
}

# Fails if the library with its default features needs a C compiler.
no_c_compiler() {
    cargo tree -p streakcast -e normal,build --prefix none >"$log/tree"
    ! grep -E '^(cc|cmake|autotools|pkg-config) ' "$log/tree"
}

# Arguments of the scripts without `--all`.
serve=(--browser) plugins=()
if is_all; then
    serve=() plugins=(--all)
    # Larger samples in Rust tests.
    export STREAKCAST_ALL=yes
fi
lint=(-- -D warnings)
step "cargo fmt --check" cargo fmt --all --check
# Tests read no home file of the user; those of the home file use one of their own.
export STREAKCAST_NO_HOME=1

if [ "$mode" = quick ]; then
    step "cargo clippy (library and command line)" cargo clippy --quiet --lib --bins "${lint[@]}"
    step "cargo test --lib, import rules" cargo test --lib --test imports
    counts
    echo "all passed in $((SECONDS - begin)) s"
    exit
fi

mkdir "$log/bin"
export STREAKCAST=$log/bin/streakcast STREAKCAST_BIN=$log/bin/streakcast
start_beside programs install_programs
if with_plugins; then start_beside plugins test_plugins; else skipped "plugins and what needs a package index: STREAKCAST_PLUGINS=no"; fi

# `--workspace`: the Python extension uses the same compiled dependencies.
step "build of program, tests and examples" cargo test --workspace --no-run
target=$(cd "${CARGO_TARGET_DIR:-target}" && pwd)
cp "$target/debug/streakcast" "$log/bin/new"
mv "$log/bin/new" "$STREAKCAST_BIN"
# Twice as many tests as cores at a time, because many wait for a server, a clock or another process.
export RUST_TEST_THREADS=${RUST_TEST_THREADS:-$((2 * $(getconf _NPROCESSORS_ONLN)))}
step "cargo test" cargo test --workspace
# Commands that require real data are skipped with a message if the folder STREAKCAST_DATA is missing.
step "commands of the README and the documentation" tests/docs.py
step "programs of the next steps (the rest of it)" finish_beside programs
if with_serve; then
    step "serve: page in a browser" tests/serve.sh ${serve[@]+"${serve[@]}"}
else
    skipped "serve.sh: STREAKCAST_SERVE=no"
fi
if is_all; then
    step "cargo clippy" cargo clippy --quiet --workspace --all-targets "${lint[@]}"
    step "cargo doc" env RUSTDOCFLAGS="-D warnings" cargo doc --quiet --workspace --no-deps
    step "library without features: no C compiler" no_c_compiler
    step "library without features: tests and examples" cargo check --quiet -p streakcast --all-targets
    step "library with fit" cargo check --quiet -p streakcast --features fit
    step "library with fits, plot and sqlite" cargo check --quiet -p streakcast --features fits,plot,sqlite
    for example in flag_exposures forecast_night identify_streak sky_map fit_photometry inject_streaks learn_offsets; do
        step "example $example" "$target/debug/examples/$example"
    done
    for example in plot_pass charts; do step "example $example" "$target/debug/examples/$example" "$log"; done
    step "a synthetic frame with the README's streaks" "$STREAKCAST_BIN" inject --synthetic examples/synthetic.toml \
        -o "$log/streaked.fits" --random-streaks 3 --magnitude 4,7 --exposure 30s --seeing 1.5arcsec --seed 1
    step "the gate against INDI's server and simulators" tests/indi.sh
    if with_plugins; then
        step "outputs read by independent programs" tests/independent.sh
        step "site of the documentation" docs/build.sh
    fi
fi
if with_plugins; then step "plugins/test.sh (the rest of it)" finish_beside plugins; fi
counts
echo "all passed in $((SECONDS - begin)) s"
