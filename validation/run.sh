#!/bin/sh
# Compares Kinome with Mitsuba 3, and with Blender's Cycles where that shows the same: are the
# pictures the same, and which renderer reaches an error sooner? Ends with validation/report/.
#
#   sh validation/run.sh [correctness|benchmark|report] [SCENE|GROUP|all...]
#                        [--quick] [--fresh] [--output FOLDER] [--build FOLDER]
#   sh validation/run.sh benchmark [SCENE|GROUP...] --scenes-for 15m [...]
#   sh validation/run.sh maps [SCENE...] [--spp N] [...]
#   sh validation/run.sh budgets [SCENE|FILE|FOLDER...] [--minutes N] [--seeds N] [--threads N]
#                        [--size WxH] [--seconds S,...] [...]
#   sh validation/run.sh engine [PART...] [SCENE|GROUP...] [--minutes N] [--sampler NAME] [...]
#
# engine: nanoseconds a sample of ours and of Mitsuba's llvm_ad_rgb, and what else its goals name.
# Ends with validation/engine/. Begins no measurement that would end after 10 minutes; the same
# command then goes on. --build: the program of that build folder, which is not built.
#
# maps: where the error of clustered by product lies, by pixels and by classes of pixels, on six
# scenes, in 3 minutes. Ends with validation/maps/. Needs no Mitsuba.
#
# budgets: is clustered worse than path or ptracer, by samples, time and error, on these scenes, scene
# files, or all scene files of a folder? Ends with validation/budgets/. Begins no scene that would
# end after 10 minutes; the same command then goes on. Needs no Mitsuba.
#
# Groups: environment, hard, plain, bounce, area, together. Most of their scenes are taken only if
# asked for; all: these and the rest, 26.
# Without a mode, all three, in about an hour on two cores; --quick: the same in a small form, in 10
# minutes, which goes to out/report unless --output says otherwise. `benchmark all` takes somewhat
# more than an hour, and half of one for the next program, as what Mitsuba did is kept.
# --scenes-for TIME (90s, 15m, 2h) begins no scene that would end later, by what scenes have taken
# so far; first come those that this program wasn't measured on, then those whose measurement is
# the oldest.
# What was measured before is not measured again, so an interrupted run goes on where it stopped;
# --fresh measures anew what it is asked for. What can't be had is said in a line, left out, and the
# rest goes on.
#
# Exit status: 0 all well; 1 a comparison is red; 2 something was left out, or a bad argument;
# 3 another run is at work in the same build folder; 130 or 143 interrupted.
set -eu
root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd)
build=${KINOME_BUILD:-$root/build}
. "$root/scenes/setup.sh"

# environment FOLDER REQUIREMENTS WHAT: a virtual environment of these packages; does nothing where
# it is there already.
environment() {
  cmp -s "$2" "$1/requirements.txt" && return 0
  echo "validation: installing $3 into $1" >&2
  rm -rf "$1"
  if "$kinome_python" -m venv "$1" && "$1/bin/pip" install -q -r "$2" >"$1/pip.log" 2>&1; then
    cp "$2" "$1/requirements.txt"
  else
    sed -n '/^ERROR/p' "$1/pip.log" 2>/dev/null | tail -n 1 >&2 || :
    rm -rf "$1"
    echo "validation: $3 can't be installed: it is left out" >&2
  fi
}

run() {
  "$kinome_python" "$root/validation/run.py" --build "$build" --work "$build" "$@"
}

# It reads the words, before minutes go by for a wrong one.
command -v "$kinome_python" >/dev/null 2>&1 ||
  (kinome_packages=python3 && kinome_install_packages)
given=
for word in "$@"; do
  case $word in
    --build | --build=*) given=yes ;;
    -h | --help)
      run --help
      exit
      ;;
  esac
done
modes=$(run --check "$@")
if [ "$modes" != report ]; then
  # Until this shell and all it starts have ended.
  mkdir -p "$build/validation"
  exec 9>"$build/validation/lock"
  if command -v flock >/dev/null 2>&1 && ! flock -n 9; then
    echo "validation: another run is at work in $build/validation: wait until it has ended, or" \
      "set KINOME_BUILD to another folder" >&2
    exit 3
  fi
  kinome_packages="$kinome_packages $kinome_report_packages $kinome_compare_packages python3-venv"
  kinome_install_packages
  if [ -z "$given" ]; then
    kinome_configure
    ninja -C "$build" kinome_renderer
  fi
  "$kinome_python" "$root/scenes/make_assets.py"
  if [ "$modes" != maps ] && [ "$modes" != budgets ]; then
    # Mitsuba's llvm variants need it; without, they are left out.
    (kinome_packages=libllvm19 && kinome_install_packages) ||
      echo "validation: no libllvm19: Mitsuba's llvm variants are left out" >&2
    environment "$build/validation/mitsuba" "$root/validation/requirements.txt" Mitsuba
  fi
  case " $modes " in
    *" benchmark "*) environment "$build/validation/cycles" \
      "$root/validation/requirements-cycles.txt" "Cycles (bpy)" ;;
  esac
else
  kinome_packages="python3-numpy $kinome_report_packages $kinome_compare_packages"
  kinome_install_packages
fi
exec "$kinome_python" "$root/validation/run.py" --build "$build" --work "$build" "$@"
