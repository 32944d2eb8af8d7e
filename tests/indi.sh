#!/usr/bin/env bash
# Tests `gate --indi` with Debian's INDI server and simulators: a mount is slewed, and the gate must read its pointing.
# Installs indi-bin with apt; if that is not possible, prints that the test is skipped. `--install` only installs it.
# STREAKCAST is the program (default: it is built).
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

skip() {
    echo "*** SKIPPED indi.sh: $1 ***"
    exit 0
}

if ! command -v indiserver >/dev/null; then
    command -v apt-get >/dev/null || skip "no indiserver, and no apt-get to install it"
    [ "$(id -u)" = 0 ] || skip "no indiserver, and no right to install it (apt-get install indi-bin)"
    apt-get install -y --no-install-recommends indi-bin >/dev/null 2>&1 || skip "apt-get cannot install indi-bin"
fi
command -v indi_simulator_telescope >/dev/null || skip "indiserver without indi_simulator_telescope"
command -v indi_setprop >/dev/null || skip "indiserver without indi_setprop"
if [ "${1:-}" = --install ]; then exit; fi

if [ -z "${STREAKCAST:-}" ]; then
    cargo build --quiet --workspace --bin streakcast
    STREAKCAST=${CARGO_TARGET_DIR:-target}/debug/streakcast
fi
work=$(mktemp -d)
port=${INDI_PORT:-17624}
HOME=$work indiserver -p "$port" indi_simulator_telescope indi_simulator_ccd >"$work/log" 2>&1 &
server=$!
trap 'kill "$server" 2>/dev/null || true; wait "$server" 2>/dev/null || true; rm -rf "$work"' EXIT

fail() {
    echo "indi.sh: $1" >&2
    cat "$work/log" >&2
    exit 1
}
set_property() { indi_setprop -p "$port" "$1" >>"$work/log" 2>&1; }
get_property() { indi_getprop -p "$port" -t 3 "$1" 2>>"$work/log"; }
# until_property PROPERTY VALUE: waits until a property has a value.
until_property() {
    for _ in $(seq 600); do
        [ "$(get_property "$1" | head -n 1 | cut -d= -f2-)" = "$2" ] && return 0
        sleep 0.5
    done
    fail "$1 never became $2"
}
mount="Telescope Simulator"
gate=("$STREAKCAST" gate --shells starlink-gen1 --fov 3deg --exposure 10s --limit-mag=-20 --indi "localhost:$port" --timeout 20s --strict)

# When the gate has received the pointing, it waits less than a second for the site. This may be too short on a loaded
# machine, so the gate is run again.
gate_passes() {
    for _ in $(seq 20); do
        if "${gate[@]}" "$@" 2>"$work/error"; then return 0; fi
    done
    fail "the gate did not find the mount: $(cat "$work/error")"
}
# gate_fails TEXT ARGUMENT...: checks that the gate fails with an error that contains a text.
gate_fails() {
    local words=$1
    shift
    for _ in $(seq 20); do
        if ! "${gate[@]}" "$@" 2>"$work/error" && grep -q "$words" "$work/error"; then return 0; fi
    done
    fail "no error with '$words': $(cat "$work/error")"
}

until_property "$mount.CONNECTION.CONNECT" Off
# A mount that is not connected has no coordinates.
gate_fails "check its connection" --mpc X05

set_property "$mount.CONNECTION.CONNECT=On"
until_property "$mount.CONNECTION.CONNECT" On
# The position 5 h, +80 deg never sets at this latitude.
set_property "$mount.GEOGRAPHIC_COORD.LAT;LONG;ELEV=50;10;300"
set_property "$mount.TELESCOPE_PARK.UNPARK=On" || true
set_property "$mount.ON_COORD_SET.TRACK=On"
set_property "$mount.EQUATORIAL_EOD_COORD.RA;DEC=5;80"
until_property "$mount.EQUATORIAL_EOD_COORD._STATE" Ok
of_date=$(get_property "$mount.EQUATORIAL_EOD_COORD.*")

gate_passes --status-file "$work/status.json"
python=$(command -v python3) || skip "no python3 to compare the numbers"
"$python" - "$work/status.json" "$of_date" <<'PYTHON' || fail "the mount points elsewhere"
import datetime, json, math, sys
status = json.load(open(sys.argv[1]))
mount = {line.split("=")[0].rsplit(".", 1)[-1]: float(line.split("=")[1]) for line in sys.argv[2].splitlines()}
ra, dec = math.radians(15 * mount["RA"]), math.radians(mount["DEC"])
# Precession only (Lieske 1977, first-order terms), from date to J2000. Nutation and aberration, 40 arcsec, are omitted.
t = (datetime.datetime.now(datetime.timezone.utc) - datetime.datetime(2000, 1, 1, 12, tzinfo=datetime.timezone.utc)).total_seconds() / (36525 * 86400)
arcsec = math.pi / 648000
zeta, z, theta = ((2306.2181 * t + 0.30188 * t * t) * arcsec, (2306.2181 * t + 1.09468 * t * t) * arcsec, (2004.3109 * t - 0.42665 * t * t) * arcsec)
a = math.cos(dec) * math.sin(ra - z)
b = math.cos(theta) * math.cos(dec) * math.cos(ra - z) + math.sin(theta) * math.sin(dec)
c = -math.sin(theta) * math.cos(dec) * math.cos(ra - z) + math.cos(theta) * math.sin(dec)
j2000 = (math.atan2(a, b) - zeta, math.asin(c))
found = (math.radians(status["ra_deg"]), math.radians(status["dec_deg"]))
apart = lambda p, q: math.degrees(math.acos(min(1, math.sin(p[1]) * math.sin(q[1]) + math.cos(p[1]) * math.cos(q[1]) * math.cos(p[0] - q[0])))) * 3600
print(f"mount of date {15 * mount['RA']:.4f} {mount['DEC']:.4f}, gate {status['ra_deg']:.4f} {status['dec_deg']:.4f}: {apart(j2000, found):.0f} arcsec from precession only, {apart((ra, dec), found):.0f} arcsec from the mount's coordinates")
assert apart(j2000, found) < 60 and apart((ra, dec), found) > 100
assert status["verdict"] == "clear" and status["mount"] == "Telescope Simulator"
PYTHON

# The given site differs from that of the mount.
gate_fails "km from" --mpc X05
# Without a server the exit code is 0; with --strict it is an error.
kill "$server"
wait "$server" 2>/dev/null || true
"${gate[@]:0:${#gate[@]}-1}" --mpc X05 2>"$work/error" || fail "no server must not stall a night"
grep -q "satellites were not checked, the exposure starts" "$work/error" || fail "$(cat "$work/error")"
if "${gate[@]}" --mpc X05 2>/dev/null; then fail "strict is strict"; fi
echo "indi.sh: all passed"
