# Sourced by ./quickstart and ./check: what building llama.cpp needs from the system.
# shellcheck shell=bash

fail() {
    printf 'error: %s\nhint: %s\n' "$1" "$2" >&2
    exit 1
}

have_libclang() {
    ldconfig -p 2>/dev/null | grep -q 'libclang[-.]' || compgen -G '/usr/lib/llvm-*/lib/libclang*.so*' >/dev/null \
        || [ -n "${LIBCLANG_PATH:-}" ]
}

# Installs what is missing, with apt where there is apt; says what is missing where there is none.
install_system_packages() {
    command -v cargo >/dev/null || fail "cargo is not installed" "install Rust first, with rustup"
    command -v python3 >/dev/null || fail "python3 is not installed" "install Python 3 with pip"
    python3 -m pip --version >/dev/null 2>&1 || fail "python3 has no pip" "install pip (Debian: apt-get install python3-pip)"
    local missing=()
    command -v cmake >/dev/null || missing+=(cmake)
    command -v c++ >/dev/null || missing+=(build-essential)
    command -v clang >/dev/null || missing+=(clang)
    have_libclang || missing+=(libclang-dev)
    [ ${#missing[@]} -eq 0 ] && return
    command -v apt-get >/dev/null || fail "missing: ${missing[*]}" "install them with your system's package manager"
    [ "$(id -u)" -eq 0 ] || fail "missing: ${missing[*]}" "run: sudo apt-get install ${missing[*]}"
    echo "installing ${missing[*]}" >&2
    { apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}"; } \
        >&2 || fail "apt-get could not install ${missing[*]}" "check the network, then run this again"
}
