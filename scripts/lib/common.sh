# What the scripts share; sourced, not run.

set -euo pipefail

ROOT=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
VENV=$ROOT/.venv
WORKSPACE=$ROOT/ros2_ws
NAME=$(basename "$0")

say() { echo "$NAME: $*" >&2; }

fail() {
    say "$*"
    exit 2
}

# Prints the comment at the top of the running script and ends, if its arguments ask for help.
help_if_asked() {
    case ${1:-} in
        -h | --help)
            sed -n '2,/^$/s/^# \{0,1\}//p' "$0"
            exit 0
            ;;
    esac
}

# Puts the environment and the workspace that scripts/setup made on the paths of this shell.
enter_workspace() {
    if [ -n "${ROS_DISTRO:-}" ]; then # of a system-wide ROS 2, which would be mixed with this one
        unset AMENT_PREFIX_PATH CMAKE_PREFIX_PATH COLCON_PREFIX_PATH PYTHONPATH LD_LIBRARY_PATH
    fi
    unset _ROS_WHEELS_BOOTSTRAP_COMPLETE # set by the Python of any environment of ROS 2 wheels
    export AMENT_PREFIX_PATH=${AMENT_PREFIX_PATH:+$AMENT_PREFIX_PATH:}$VENV PATH=$VENV/bin:$PATH
    set +u
    # shellcheck source=/dev/null
    source "$WORKSPACE/install/setup.bash"
    set -u
    local name entries
    for name in PYTHONPATH LD_LIBRARY_PATH CMAKE_PREFIX_PATH; do
        # an empty entry, which the setup leaves at the end, would stand for the current folder
        entries=$(tr -s : <<<"${!name:-}")
        entries=${entries#:} entries=${entries%:}
        if [ -n "$entries" ]; then export "$name=$entries"; else unset "$name"; fi
    done
    if [ -z "${ROS_AUTOMATIC_DISCOVERY_RANGE:-}${ROS_STATIC_PEERS:-}${ROS_LOCALHOST_ONLY:-}" ]; then
        export ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST
    fi
}
