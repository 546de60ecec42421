#!/bin/sh
# Builds and runs the tests; ends with one line `N passed, M failed` and that exit status.
#
#   sh tests/run.sh [--all] [--asan | --tsan] [-R REGEX] [--only "NAME..." [--plugins "NAME..."]]
#                   [CTEST OPTION...]
#   sh tests/run.sh --stability
#   sh tests/run.sh --fuzz [SECONDS] [--only "NAME..."]
#
# --all:          also what takes long, and the test of the tests (as do --asan, --tsan and --only)
# --asan:         with the address and undefined-behaviour sanitizers, by clang, in the build folder
#                 of --fuzz
# --tsan:         with the thread sanitizer, in a build folder of its own
# -R REGEX:       the tests whose names match
# --only NAMES:   build and run just these areas (`unit` is all of tests/unit) and test programs
#                 (`film` is tests/…/film_test.cpp)
# --plugins NAMES: and of the plugins just these (`bsdf_diffuse`), in place of all
# --stability:    renders every hard case by every integrator with every material, for some minutes,
#                 and writes tests/STABILITY.md (`--only stability` is its short form)
# --fuzz SECONDS: so long for each program of tests/fuzz (60), or for those that are named, with
#                 clang's libFuzzer and sanitizers; see tests/fuzz/README.md
#
# KINOME_BUILD: build folder; default: build, build-tsan or build-fuzz.
set -u
root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd)
sanitizer=
only=
plugins=
left_out='-LE \.long\.'
stability=
fuzz=
fuzz_seconds=60
# Ours are taken out, wherever they stand; the others go round to the end.
arguments=$#
while [ "$arguments" -gt 0 ]; do
  case $1 in
    -h | --help)
      sed -n '2,/^$/{/^#/!q;s/^# \{0,1\}//;p;}' "$0"
      exit
      ;;
    --all) left_out= ;;
    --asan)
      sanitizer=fuzz
      left_out=
      ;;
    --tsan)
      sanitizer=tsan
      left_out=
      ;;
    --stability) stability=yes ;;
    --fuzz)
      sanitizer=fuzz
      fuzz=yes
      case ${2:-} in
        '' | *[!0-9]*) ;;
        *)
          fuzz_seconds=$2
          shift
          arguments=$((arguments - 1))
          ;;
      esac
      ;;
    --only)
      [ "$arguments" -ge 2 ] || { echo "tests/run.sh: --only needs names" >&2; exit 1; }
      only=$2
      left_out=
      shift
      arguments=$((arguments - 1))
      ;;
    --plugins)
      [ "$arguments" -ge 2 ] || { echo "tests/run.sh: --plugins needs names" >&2; exit 1; }
      plugins=$2
      shift
      arguments=$((arguments - 1))
      ;;
    *) set -- "$@" "$1" ;;
  esac
  shift
  arguments=$((arguments - 1))
done
build=${KINOME_BUILD:-$root/build${sanitizer:+-$sanitizer}}
. "$root/scenes/setup.sh"
kinome_packages="$kinome_packages $kinome_report_packages $kinome_compare_packages"
kinome_packages="$kinome_packages $kinome_film_packages"
[ -n "$sanitizer" ] || kinome_packages="$kinome_packages $kinome_module_packages $kinome_viewer_packages \
  $kinome_mpi_packages"

finish() {
  echo "$1 passed, $2 failed"
  [ "$2" -eq 0 ]
  exit
}

# A step that must work before there is any test counts as one that failed.
require() {
  "$@" || {
    echo "tests/run.sh: '$*' failed"
    finish 0 1
  }
}

configure() {
  if [ "$sanitizer" = fuzz ]; then
    # clang takes four times as long for meshes' files by -O1, and little longer for all others by -O2.
    kinome_configure -DCMAKE_C_COMPILER=clang -DCMAKE_CXX_COMPILER=clang++ \
      -DKINOME_SANITIZER=fuzz -DCMAKE_BUILD_TYPE=RelWithDebInfo \
      -DCMAKE_CXX_FLAGS_RELWITHDEBINFO=-O2
  elif [ -n "$sanitizer" ]; then
    # Asserts stay in; -O1 and few debug symbols keep the build short (the tests' own code is
    # compiled by -O0, see tests/CMakeLists.txt).
    kinome_configure -DKINOME_SANITIZER="$sanitizer" -DCMAKE_BUILD_TYPE=RelWithDebInfo \
      -DCMAKE_CXX_FLAGS_RELWITHDEBINFO=-O1
  else
    kinome_configure
  fi
}

# The findings of a target, old ones too: name and time, so that one that is found again is new. A
# slow unit is none, but a hint of libFuzzer's.
artifacts() {
  find "$build/fuzz" -maxdepth 1 -type f -name "$1-*" ! -name "$1-slow-unit-*" -printf '%f %T@\n' |
    sort
}

# One target after the other, on all cores, from the committed corpus and what earlier runs added to
# it in the build folder. A finding stays there, too, and ends its target.
fuzz() {
  names=${only:-$(cd "$root/tests/fuzz/corpus" && ls)}
  for name in $names; do
    require ninja -C "$build" "fuzz_$name"
  done
  passed=0
  failed=0
  TMPDIR=$(mktemp -d -p /dev/shm 2>/dev/null || mktemp -d)
  export TMPDIR
  trap 'rm -rf "$TMPDIR"' EXIT
  # What was freed is kept apart for 8 MB, many inputs long; 256 of them would not fit the caches,
  # which takes a quarter more time.
  ASAN_OPTIONS=quarantine_size_mb=8${ASAN_OPTIONS:+:$ASAN_OPTIONS}
  export ASAN_OPTIONS
  for name in $names; do
    mkdir -p "$build/fuzz/$name"
    log=$build/fuzz/$name.log
    before=$(artifacts "$name")
    # Of one input: 10 s and 1 GB. With -fork, libFuzzer goes on after time-outs and lack of memory
    # unless it is told not to, and may end well after them.
    (cd "$build/fuzz" && "$build/bin/fuzz_$name" -fork="$(nproc)" \
      -ignore_timeouts=0 -ignore_ooms=0 -ignore_crashes=0 \
      -max_total_time="$fuzz_seconds" -timeout=10 -rss_limit_mb=1024 -malloc_limit_mb=1024 \
      -max_len=4096 -artifact_prefix="$build/fuzz/$name-" \
      "$build/fuzz/$name" "$root/tests/fuzz/corpus/$name") > "$log" 2>&1
    status=$?
    runs=$(sed -n 's/^#\([0-9]*\):* .*/\1/p' "$log" | tail -n 1)
    # Whatever the status says: what was kept was found.
    if [ "$status" -eq 0 ] && [ "$(artifacts "$name")" = "$before" ]; then
      passed=$((passed + 1))
      echo "fuzz $name: ${runs:-0} executions, nothing found"
    else
      failed=$((failed + 1))
      tail -n 60 "$log"
      echo "fuzz $name: found something after ${runs:-0} executions: $build/fuzz/$name-*"
    fi
  done
  finish "$passed" "$failed"
}

[ "$sanitizer" != fuzz ] || kinome_packages="$kinome_packages clang libclang-rt-14-dev"
require kinome_install_packages
[ -n "$sanitizer" ] || kinome_python_environment
require configure
if [ -n "$stability" ]; then
  require ninja -C "$build" kinome_renderer kinome-stability
  exec "$build/bin/kinome-stability" --page "$root/tests/STABILITY.md"
fi
[ -z "$fuzz" ] || fuzz
targets=all
[ -n "$left_out" ] || targets="all tests_defects"
if [ -n "$only" ]; then
  targets=kinome_renderer
  [ -z "$plugins" ] || targets=kinome
  for name in $plugins; do
    targets="$targets kinome_$name"
  done
  labels=
  for name in $only; do
    if [ -d "$root/tests/$name" ]; then
      targets="$targets tests_$name"
      labels="$labels${labels:+|}^$name\\."
    else
      targets="$targets test_$name"
      labels="$labels${labels:+|}\\.$name\$"
    fi
  done
  set -- -L "$labels" "$@"
fi

# The first suite to be broken must not hide what the others say. Whatever could not be built counts
# as one failure, and again wherever ctest misses a program.
broken=0
# shellcheck disable=SC2086
ninja -C "$build" -k 0 $targets || {
  broken=1
  echo "tests/run.sh: the build failed"
}

log=$(mktemp)
trap 'rm -f "$log"' EXIT
# intercept_tls_get_addr=0: by the address that a plugin's thread-local variables happen to have, GCC's
# LeakSanitizer may take what lies before them for their size, and crashes.
export ASAN_OPTIONS="${ASAN_OPTIONS:-detect_stack_use_after_return=1:intercept_tls_get_addr=0}"
export UBSAN_OPTIONS="${UBSAN_OPTIONS:-print_stacktrace=1}"
export TSAN_OPTIONS="${TSAN_OPTIONS:-halt_on_error=1}"
# shellcheck disable=SC2086
ctest --test-dir "$build" -j "$(nproc)" --output-on-failure --no-tests=error $left_out "$@" 2>&1 |
  tee "$log"
# "98% tests passed, 3 tests failed out of 150"; a crash, a time-out and a program that isn't there
# are among the failed. A skipped test is not among them, yet proves nothing: it counts as failed.
summary=$(sed -n 's/.*% tests passed, \([0-9]*\) tests* failed out of \([0-9]*\)$/\1 \2/p' "$log")
if [ -z "$summary" ]; then
  echo "tests/run.sh: no test was run${left_out:+ (what takes long needs --all)}"
  finish 0 1
fi
failed=${summary% *}
total=${summary#* }
skipped=$(grep -c '^ *[0-9]*/[0-9]* Test .*\*\*\*Skipped' "$log")
[ "$skipped" -eq 0 ] || echo "$skipped skipped, which counts as failed"
finish $((total - failed - skipped)) $((failed + skipped + broken))
