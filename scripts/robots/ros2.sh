#!/usr/bin/env bash
# Installs a ROS 2 without a ROS installation into the cache: rclpy and Fast DDS from the Python package index, longstep_msgs
# built from ros/, and rosbridge-server-rs. Prints the folder, in which `python` and `bridge` start with the right
# environment. For tests and first steps; a robot has its own ROS. `--installed` only looks, and fails if it is not installed.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
requirements="$here/ros2-requirements.txt"
messages="$here/../../ros/longstep_msgs"
cache="${LONGSTEP_CACHE:-${XDG_CACHE_HOME:-$HOME/.cache}/longstep}/robots"
# Other versions, interfaces and interpreters get a folder of their own.
mark=$(cat "$0" "$requirements" "$messages"/*/*.* "$messages/CMakeLists.txt" <(python3 --version) | sha256sum | cut -c1-12)
folder="$cache/ros2-$mark"

if [ -e "$folder/complete" ]; then
    echo "$folder"
    exit
fi
if [ "${1:-}" = "--installed" ]; then
    printf 'error: ROS 2 is not installed in the cache\nhint: run scripts/robots/ros2.sh\n' >&2
    exit 1
fi
fail() {
    printf 'error: %s\nhint: %s\n' "$1" "$2" >&2
    exit 1
}
[ "$(uname -sm)" = "Linux x86_64" ] || fail "the wheels of ROS 2 are for Linux on x86_64" "use your own ROS 2: docs/guide/ros2.md"
command -v cmake >/dev/null || fail "cmake is missing" "install it, for example with: apt-get install cmake g++"
library=$(python3 -c 'import sysconfig; print(sysconfig.get_config_var("LIBDIR") + "/" + sysconfig.get_config_var("INSTSONAME"))')
[ -e "$library" ] || fail "$library is missing" "use a Python with a shared library, such as that of Debian (libpython3-dev)"

mkdir -p "$cache"
exec 9>"$cache/ros2.lock"
flock 9
if [ ! -e "$folder/complete" ]; then
    rm -rf "$folder"
    echo "installing ROS 2 into $folder" >&2
    mkdir -p "$folder"
    python3 -m venv "$folder/ros" >&2
    pip=("$folder/ros/bin/python" -m pip --quiet --disable-pip-version-check)
    "${pip[@]}" install --requirement "$requirements" >&2 || fail "pip could not install ROS 2" "check the network, then run this again"
    "${pip[@]}" download --no-deps --dest "$folder/bridge-wheel" rosbridge-server-rs==0.1.6 >&2 ||
        fail "pip could not fetch rosbridge-server-rs" "check the network, then run this again"
    "$folder/ros/bin/python" -m zipfile --extract "$folder"/bridge-wheel/*.whl "$folder/bridge-wheel"
    chmod +x "$folder"/bridge-wheel/rosbridge_server_rs/rosbridge_server_rs_jazzy

    packages=$("$folder/ros/bin/python" -c 'import sysconfig; print(sysconfig.get_path("purelib"))')
    include=$("$folder/ros/bin/python" -c 'import sysconfig; print(sysconfig.get_path("include"))')
    # The wheels name the interpreter that they were built with.
    grep -rlIZ '/opt/python/cp' "$folder/ros/share" | xargs -0 -r sed -i -E \
        -e "s#/opt/python/cp[^/]*/include/python[0-9.]*#$include#g" \
        -e "s#/opt/python/cp[^/]*/lib/python[0-9.]*/site-packages#$packages#g"
    # The bridge looks for the library of rmw_implementation, which the wheels of Fast DDS replace.
    mkdir "$folder/shim"
    ln -s "$folder/ros/lib/librmw_fastrtps_cpp.so" "$folder/shim/librmw_implementation.so"
    (
        export AMENT_PREFIX_PATH="$folder/ros" PATH="$folder/ros/bin:$PATH"
        cmake -S "$messages" -B "$folder/build" -DCMAKE_PREFIX_PATH="$folder/ros" -DBUILD_TESTING=OFF \
            -DPython3_EXECUTABLE="$folder/ros/bin/python" -DCMAKE_INSTALL_PREFIX="$folder/ros" &&
            cmake --build "$folder/build" --parallel 2 &&
            cmake --install "$folder/build"
    ) >"$folder/build.log" 2>&1 || fail "longstep_msgs could not be built" "$folder/build.log says why"

    libraries=$(printf '%s:' "$packages"/ros_*.libs)
    cat >"$folder/environment" <<END
export AMENT_PREFIX_PATH="$folder/ros" ROS_DISTRO=jazzy RMW_IMPLEMENTATION=rmw_fastrtps_cpp
# Nothing leaves this computer.
export ROS_LOCALHOST_ONLY=1 ROS_LOG_DIR="\${ROS_LOG_DIR:-$folder/log}"
END
    cat >"$folder/python" <<END
#!/bin/sh
. "$folder/environment"
export LD_LIBRARY_PATH="$folder/ros/lib\${LD_LIBRARY_PATH:+:\$LD_LIBRARY_PATH}"
exec "$folder/ros/bin/python" "\$@"
END
    cat >"$folder/bridge" <<END
#!/bin/sh
# The services of rosapi need interfaces that are not on the package index.
. "$folder/environment"
export LD_LIBRARY_PATH="$folder/shim:$folder/ros/lib:$libraries" LD_PRELOAD="$library"
exec "$folder/bridge-wheel/rosbridge_server_rs/rosbridge_server_rs_jazzy" --no-rosapi --log-ansi false \
    --log-directory "\${ROS_LOG_DIR}" "\$@"
END
    chmod +x "$folder/python" "$folder/bridge"
    "$folder/python" -c 'import rclpy, longstep_msgs.action' || fail "the installed ROS 2 does not work" "$folder/build.log"
    rm -rf "$folder/build"
    touch "$folder/complete"
fi
echo "$folder"
