#!/usr/bin/env bash
# Starts a PostgreSQL server of its own for tests, and prints its address:
#
#   export "$(scripts/postgres.sh --parent $$)"        sets LONGSTEP_POSTGRES
#
# Installs Debian's server if there is none. The server listens on a free port of this machine, has its data in a temporary
# folder and a random password, and never runs as root. It stops, and its folder goes, when the process PID ends or after
# `--seconds N` (3600).
set -euo pipefail
. "$(dirname "$0")/system-packages.sh"

parent=""
seconds=3600
while [ $# -gt 0 ]; do
    case "$1" in
    --parent) parent=${2:?} && shift 2 ;;
    --seconds) seconds=${2:?} && shift 2 ;;
    *) fail "unknown argument: $1" "usage: scripts/postgres.sh [--parent PID] [--seconds N]" ;;
    esac
done

# The newest server of Debian, which is not on the path; or one that is.
find_programs() {
    local found
    found=$(compgen -G '/usr/lib/postgresql/*/bin/initdb' | sort -V | tail -1 || true)
    [ -n "$found" ] || found=$(command -v initdb || true)
    [ -z "$found" ] || dirname "$found"
}

programs=$(find_programs)
if [ -z "$programs" ]; then
    command -v apt-get >/dev/null || fail "PostgreSQL is not installed" "install its server with your system's package manager"
    [ "$(id -u)" -eq 0 ] || fail "PostgreSQL is not installed" "run: sudo apt-get install postgresql"
    echo "installing postgresql" >&2
    { apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends postgresql; } \
        >&2 || fail "apt-get could not install postgresql" "check the network, then run this again"
    programs=$(find_programs)
fi
[ -n "$programs" ] || fail "PostgreSQL has no initdb" "install the server, not only the client"

# The server refuses to run as root.
as_user=()
if [ "$(id -u)" -eq 0 ]; then
    getent passwd postgres >/dev/null || fail "there is no user postgres" "run this as another user than root"
    as_user=(runuser -u postgres --)
fi

folder=$(mktemp -d /tmp/longstep-postgres.XXXXXX)
trap 'rm -rf "$folder"' EXIT
password=$(python3 -c 'import secrets; print(secrets.token_hex(16))')
port=$(python3 -c 'import socket; s = socket.socket(); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])')
printf '%s' "$password" >"$folder/password"
[ ${#as_user[@]} -eq 0 ] || chown -R postgres "$folder"
chmod 700 "$folder"
cd /
"${as_user[@]}" "$programs/initdb" --pgdata "$folder/data" --username postgres --pwfile "$folder/password" \
    --auth scram-sha-256 --encoding UTF8 --locale C.UTF-8 >"$folder/log" 2>&1 || {
    cat "$folder/log" >&2
    fail "initdb failed" "its messages are above"
}
chmod 666 "$folder/log"
options="-c listen_addresses=127.0.0.1 -c port=$port -c unix_socket_directories=$folder -c max_connections=200"
"${as_user[@]}" "$programs/pg_ctl" --pgdata "$folder/data" --log "$folder/log" --options "$options" --wait --silent start >&2 || {
    cat "$folder/log" >&2
    fail "the server did not start" "its messages are above"
}
trap - EXIT

# Stops the server: detached, so that whoever reads the address does not wait for it.
watch() {
    local end=$((SECONDS + seconds))
    while [ $SECONDS -lt $end ] && { [ -z "$parent" ] || kill -0 "$parent" 2>/dev/null; }; do sleep 1; done
    "${as_user[@]}" "$programs/pg_ctl" --pgdata "$folder/data" --mode immediate --silent stop
    rm -rf "$folder"
}
( trap '' HUP INT; watch ) </dev/null >/dev/null 2>&1 &

echo "LONGSTEP_POSTGRES=postgres://postgres:$password@127.0.0.1:$port/postgres"
