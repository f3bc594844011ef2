# What the scripts share: where things are, how they speak, and a build with one line of progress. Sourced, not run.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"
program=${0#"$root"/}

say() { printf '%s\n' "$*"; }
fail() {
  printf '%s: %s\n' "$program" "$*" >&2
  exit 1
}

# A line that the next one replaces on a terminal; elsewhere, lines only where something new is said.
progress() {
  if [ -t 1 ]; then printf '\r\033[K%s' "$*"; else say "$*"; fi
}
progress_done() { if [ -t 1 ]; then printf '\r\033[K'; fi; }

# The value of an option that needs one: value_of --seconds "$@" with the option at $2.
value_of() {
  [ $# -ge 3 ] || fail "$1 needs a value; see $program --help"
  printf '%s' "$3"
}

# Runs a command with its output in a log; on failure shows the end of the log.
logged() {
  local log=$1
  shift
  mkdir -p "$(dirname "$log")"
  if ! "$@" >"$log" 2>&1; then
    tail -n 30 "$log" >&2
    fail "'$*' failed; the whole log is $log"
  fi
}

has_gpu() { nvidia-smi -L >/dev/null 2>&1; }

# configure PRESET [cmake options]
configure() {
  local preset=$1
  shift
  mkdir -p "build/$preset"
  # a first build is compiled together; a tree that somebody has configured for work on it stays as it is
  if [ ! -f "build/$preset/CMakeCache.txt" ]; then set -- -DPALP_TOGETHER=ON "$@"; fi
  if [ -n "${PALP_WERROR:-}" ]; then set -- -DPALP_WERROR="$PALP_WERROR" "$@"; fi
  logged "build/$preset/configure.log" cmake --preset "$preset" "$@"
  sed -n 's/^-- \(CUDA back end: .*\)/\1/p' "build/$preset/configure.log"
}

# build PRESET [targets]: one line of progress, the compiler's words only when it fails
build() {
  local preset=$1 log="build/$1/build.log" status=0
  shift
  [ "$(ninja -C "build/$preset" -n "$@" | tail -n 1)" = "ninja: no work to do." ] && return 0
  NINJA_STATUS='[%f/%t] ' ninja -C "build/$preset" "$@" 2>&1 | tee "$log" | build_progress "$preset" || status=$?
  progress_done
  if [ "$status" -ne 0 ]; then
    grep -A 25 '^FAILED:' "$log" | head -n 80 >&2 || tail -n 30 "$log" >&2
    fail "the build failed; the whole log is $log"
  fi
  say "built $preset"
}

build_progress() {
  local line last=-1 percent
  while IFS= read -r line; do
    [[ $line =~ ^\[([0-9]+)/([0-9]+)\] ]] || continue
    percent=$((BASH_REMATCH[1] * 100 / BASH_REMATCH[2]))
    if [ -t 1 ] || [ $((percent / 10)) -gt $((last / 10)) ] || [ "$last" -lt 0 ]; then
      [ "$percent" -ne "$last" ] && progress "building $1: $percent % (${BASH_REMATCH[1]} of ${BASH_REMATCH[2]})"
    fi
    last=$percent
  done
}
