#!/bin/sh
# Builds and runs the tests. Ends with a line `N passed, M failed`; the exit status is 0 if M is 0.
#
#   sh tests/run.sh [--all | --long "NAME..."] [--asan | --tsan] [-R REGEX]
#                   [--only "NAME..." [--plugins "NAME..."]] [CTEST OPTION...]
#   sh tests/run.sh --stability
#   sh tests/run.sh --fuzz [SECONDS] [--only "NAME..."]
#
# --all:          also runs the long tests and the test of the tests (--asan, --tsan and --only
#                 include them)
# --long NAMES:   also runs the long tests of these areas and test programs; `defects` is the test of
#                 the tests
# --asan:         uses the address and undefined-behaviour sanitizers of clang, in the build folder of
#                 --fuzz
# --tsan:         uses the thread sanitizer, in a separate build folder
# -R REGEX:       runs only tests whose names match
# --only NAMES:   builds and runs only these areas (`core` is all of tests/core) and test programs, as
#                 tests/…/CMakeLists.txt names them (`film` has the tests of films). `apps` includes its
#                 folders, which are areas as well: blender, cli, python, viewer
# --plugins NAMES: with --only: builds only these plugins (`bsdf_diffuse`) instead of all
# --stability:    renders every hard case with every integrator and material, in some minutes, and
#                 writes tests/STABILITY.md (`--only stability` is its short form)
# --fuzz SECONDS: runs each program of tests/fuzz for this time (default: 60), or only those of
#                 --only, with clang's libFuzzer and sanitizers; see tests/fuzz/README.md
#
# KINOME_BUILD: build folder; default: build, build-tsan or build-fuzz.
set -u
root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd)
sanitizer=
only=
plugins=
left_out='-LE \.long\.'
long=
stability=
fuzz=
fuzz_seconds=60
# Removes this script's options from any position. Appends the others, which rotates the list.
arguments=$#
while [ "$arguments" -gt 0 ]; do
  case $1 in
    -h | --help)
      sed -n '2,/^$/{/^#/!q;s/^# \{0,1\}//;p;}' "$0"
      exit
      ;;
    --all) left_out= ;;
    --long)
      [ "$arguments" -ge 2 ] || { echo "tests/run.sh: --long needs names" >&2; exit 1; }
      long=$2
      left_out=yes
      shift
      arguments=$((arguments - 1))
      ;;
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

# Runs a step that must succeed before the tests. Its failure counts as one failed test.
require() {
  "$@" || {
    echo "tests/run.sh: '$*' failed"
    finish 0 1
  }
}

configure() {
  if [ "$sanitizer" = fuzz ]; then
    # Uses -O2: with -O1, clang takes four times as long to compile the meshes' files, and little less
    # for all others.
    kinome_configure -DCMAKE_C_COMPILER=clang -DCMAKE_CXX_COMPILER=clang++ \
      -DKINOME_SANITIZER=fuzz -DCMAKE_BUILD_TYPE=RelWithDebInfo \
      -DCMAKE_CXX_FLAGS_RELWITHDEBINFO=-O2
  elif [ -n "$sanitizer" ]; then
    # Keeps asserts. -O1 and few debug symbols keep the build short. The tests' own code is compiled
    # with -O0, see tests/CMakeLists.txt.
    kinome_configure -DKINOME_SANITIZER="$sanitizer" -DCMAKE_BUILD_TYPE=RelWithDebInfo \
      -DCMAKE_CXX_FLAGS_RELWITHDEBINFO=-O1
  else
    kinome_configure
  fi
}

# Prints the name and time of all findings of a target. A finding that occurs again has a new time.
# Slow units are only hints of libFuzzer, not findings.
artifacts() {
  find "$build/fuzz" -maxdepth 1 -type f -name "$1-*" ! -name "$1-slow-unit-*" -printf '%f %T@\n' |
    sort
}

# Runs one target after the other on all cores. They start from the committed corpus and the inputs
# that earlier runs have added in the build folder. A finding is stored there, too, and ends its
# target.
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
  # AddressSanitizer quarantines 8 MB of freed memory, enough for many inputs. The default of 256 MB
  # doesn't fit in the caches and takes a quarter more time.
  ASAN_OPTIONS=quarantine_size_mb=8${ASAN_OPTIONS:+:$ASAN_OPTIONS}
  export ASAN_OPTIONS
  for name in $names; do
    mkdir -p "$build/fuzz/$name"
    log=$build/fuzz/$name.log
    before=$(artifacts "$name")
    # Each input can use 10 s and 1 GB. With -fork, libFuzzer by default continues after time-outs and
    # out-of-memory errors, and can still exit with status 0.
    (cd "$build/fuzz" && "$build/bin/fuzz_$name" -fork="$(nproc)" \
      -ignore_timeouts=0 -ignore_ooms=0 -ignore_crashes=0 \
      -max_total_time="$fuzz_seconds" -timeout=10 -rss_limit_mb=1024 -malloc_limit_mb=1024 \
      -max_len=4096 -artifact_prefix="$build/fuzz/$name-" \
      "$build/fuzz/$name" "$root/tests/fuzz/corpus/$name") > "$log" 2>&1
    status=$?
    runs=$(sed -n 's/^#\([0-9]*\):* .*/\1/p' "$log" | tail -n 1)
    # A new finding counts even if the exit status is 0.
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
[ -n "$sanitizer" ] || kinome_install_readers
require configure
if [ -n "$stability" ]; then
  require ninja -C "$build" kinome_renderer kinome-stability
  exec "$build/bin/kinome-stability" --page "$root/tests/STABILITY.md"
fi
[ -z "$fuzz" ] || fuzz
targets=all
case "$left_out $long " in " "* | *" defects "*) targets="all tests_defects" ;; esac
if [ -n "$only" ]; then
  targets=kinome_renderer
  [ -z "$plugins" ] || targets=kinome
  for name in $plugins; do
    targets="$targets kinome_$name"
  done
  labels=
  case " $only " in
    *" apps "*) only="$only blender cli python viewer" ;;
  esac
  for name in $only; do
    if [ -d "$root/tests/$name" ] || [ -d "$root/tests/apps/$name" ]; then
      targets="$targets tests_$name"
      labels="$labels${labels:+|}^$name\\."
    else
      targets="$targets test_$name"
      labels="$labels${labels:+|}\\.$name\$"
    fi
  done
  set -- -L "$labels" "$@"
fi

# Continues after build errors, so that the other suites run. A failed build counts as one failure.
# ctest also counts each missing program.
broken=0
# shellcheck disable=SC2086
ninja -C "$build" -k 0 $targets || {
  broken=1
  echo "tests/run.sh: the build failed"
}

# The labels AREA.long.NAME are known once the programs are built.
if [ -n "$long" ]; then
  labels=$(ctest --test-dir "$build" --print-labels | sed -n 's/^ *\([a-z0-9_]*\.long\.[a-z0-9_]*\)$/\1/p')
  others=$labels
  for name in $long; do
    pattern="^$name\\.long\\.|\\.long\\.$name\$"
    echo "$labels" | grep -qE "$pattern" || {
      echo "tests/run.sh: no long tests of '$name'"
      [ "$broken" -eq 1 ] || finish 0 1
    }
    others=$(echo "$others" | grep -vE "$pattern")
  done
  left_out="-LE ^($(echo "$others" | tr '\n' '|' | sed 's/|$//'))\$"
fi

log=$(mktemp)
trap 'rm -f "$log"' EXIT
# intercept_tls_get_addr=0 avoids a crash of GCC's LeakSanitizer. For some addresses of a plugin's
# thread-local variables, it reads their size from unrelated memory.
export ASAN_OPTIONS="${ASAN_OPTIONS:-detect_stack_use_after_return=1:intercept_tls_get_addr=0}"
export UBSAN_OPTIONS="${UBSAN_OPTIONS:-print_stacktrace=1}"
export TSAN_OPTIONS="${TSAN_OPTIONS:-halt_on_error=1}"
# shellcheck disable=SC2086
ctest --test-dir "$build" -j "$(nproc)" --output-on-failure --no-tests=error $left_out "$@" 2>&1 |
  tee "$log"
# Parses "98% tests passed, 3 tests failed out of 150". The failed tests include crashes, time-outs
# and missing programs. Skipped tests prove nothing, so they count as failed, too.
summary=$(sed -n 's/.*% tests passed, \([0-9]*\) tests* failed out of \([0-9]*\)$/\1 \2/p' "$log")
if [ -z "$summary" ]; then
  echo "tests/run.sh: no test was run${left_out:+ (long tests need --all)}"
  finish 0 1
fi
failed=${summary% *}
total=${summary#* }
skipped=$(grep -c '^ *[0-9]*/[0-9]* Test .*\*\*\*Skipped' "$log")
[ "$skipped" -eq 0 ] || echo "$skipped skipped, which counts as failed"
finish $((total - failed - skipped)) $((failed + skipped + broken))
