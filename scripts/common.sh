# Shared by scripts/run and scripts/test: where things are, what is said, how the package is built. Sourced, not run.

set -u
ROOT=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
BUILD=$(realpath -ms "${RAVEN2_TRAINER_BUILD:-$ROOT/build}")
LOGS=$BUILD/logs

say() { printf '%s\n' "$*" >&2; }

fail() {
  say "raven2_trainer: $*"
  exit 1
}

# show_progress NAME LOG: the newest percentage or line of a log, in place on a terminal, else a line every 30 s. Ends with
# this script, whatever ends it.
show_progress() {
  local every=30 begin='' end='\n' seconds=0 clock
  [ -t 2 ] && every=1 begin='\r\033[K' end=''
  exec {clock}<> <(:)  # read -t on it waits without a sleep process that would outlive us
  while ! read -r -t 1 -u "$clock" && kill -0 $$ 2>/dev/null; do
    seconds=$((seconds + 1))
    [ $((seconds % every)) -eq 0 ] && printf "$begin%s: %s$end" "$1" "$(tail -n 1 "$2" | cut -c1-60)" >&2
  done
}

# step NAME LOG COMMAND...: runs quietly; on failure one line with the reason, and where the whole output is.
step() {
  local name=$1 log=$LOGS/$2 begin=$SECONDS
  shift 2
  mkdir -p "$LOGS"
  : >"$log" || fail "$log cannot be written: remove $BUILD, or make it yours"
  show_progress "$name" "$log" &
  local progress=$! status=0
  "$@" >"$log" 2>&1 || status=$?
  kill "$progress" 2>/dev/null
  wait "$progress" 2>/dev/null
  if [ $status -ne 0 ]; then
    [ -t 2 ] && printf '\r\033[K' >&2
    fail "$name failed: $(grep -m1 -E '(^|[ :])(fatal )?[Ee]rror[ :]|^E: |cannot' "$log" || tail -n 1 "$log") (see $log)"
  fi
  [ -t 2 ] && printf '\r\033[K' >&2
  say "$name: $((SECONDS - begin)) s"
}

configure_preset() { (cd "$ROOT" && cmake --preset "$1" -B "$2"); }  # the caller stays in its folder
# A configure that failed or was interrupted leaves its cache, but nothing to build with.
is_configured() { [ -f "$BUILD/build.ninja" ] || [ -f "$BUILD/Makefile" ]; }
configure() { is_configured || step "configure" configure.log configure_preset release "$BUILD"; }
build() { step "build" build.log cmake --build "$BUILD" -j "$(nproc)" "$@"; }
configure_and_build() { configure && build "$@"; }

# ROS environment of the devel space. Its scripts use unset variables. A ROS_HOSTNAME of the user would count more than ROS_IP.
source_ros() {
  set +u
  # shellcheck disable=SC1091
  source "$BUILD/devel/setup.bash" || fail "no ROS environment in $BUILD/devel"
  set -u
  unset ROS_HOSTNAME
  export ROS_HOME=$BUILD/ros_home ROS_LOG_DIR=$BUILD/ros_home/log ROS_IP=127.0.0.1
  mkdir -p "$ROS_LOG_DIR"
}

# free_port KIND PREFERRED [TAKEN...]: the preferred port if nobody listens on it, else one that the system chooses.
free_port() {
  /usr/bin/python3 - "$@" <<'PY'
import socket, sys
kind = socket.SOCK_DGRAM if sys.argv[1] == "udp" else socket.SOCK_STREAM
taken = {int(p) for p in sys.argv[3:]}
def usable(port):
    with socket.socket(socket.AF_INET, kind) as s:
        try:
            s.bind(("127.0.0.1", port))
        except OSError:
            return 0
        return s.getsockname()[1]
port = 0 if int(sys.argv[2]) in taken else usable(int(sys.argv[2]))
while not port or port in taken:
    port = usable(0)
print(port)
PY
}
