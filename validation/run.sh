#!/bin/sh
# Compares Kinome with Mitsuba 3, and with Blender's Cycles where it supports the scene: are the
# images the same, and which renderer reaches an error sooner? Writes validation/report/.
#
#   sh validation/run.sh [correctness|benchmark|report] [SCENE|GROUP|all...]
#                        [--quick] [--fresh] [--output FOLDER] [--build FOLDER]
#   sh validation/run.sh benchmark [SCENE|GROUP...] --scenes-for 15m [...]
#   sh validation/run.sh maps [SCENE...] [--spp N] [...]
#   sh validation/run.sh budgets [SCENE|FILE|FOLDER...] [--minutes N] [--seeds N] [--threads N]
#                        [--size WxH] [--seconds S,...] [...]
#   sh validation/run.sh threads [SCENE...] [...]
#   sh validation/run.sh large [SCENE...] [...]
#   sh validation/run.sh slope [SCENE...] [...]
#   sh validation/run.sh media [SCENE...] [--seeds N] [...]
#   sh validation/run.sh engine [PART...] [SCENE|GROUP...] [--minutes N] [--sampler NAME] [...]
#
# engine: time per sample of Kinome and of Mitsuba's llvm_ad_rgb, and the engine's other goals.
# Writes validation/engine/. Begins no measurement that would end after 10 minutes; run the same
# command again to continue.
#
# maps: the error of clustered with product in each pixel and in classes of pixels, on six scenes, in
# 3 minutes. Writes validation/maps/. Doesn't need Mitsuba.
#
# budgets: is clustered worse than path or ptracer, by samples, time and error, on these scenes, scene
# files, or all scene files of a folder? Writes validation/budgets/. Begins no scene that would end
# after 10 minutes; run the same command again to continue. Doesn't need Mitsuba.
#
# threads: the time of renders with 1 to 16 threads, measured or simulated, in 7 minutes. Writes
# validation/threads/. Doesn't need Mitsuba.
#
# large: memory and rays per second of images of up to 3840x2160 pixels, in 8 minutes. Writes
# validation/large/. Doesn't need Mitsuba.
#
# slope: the error of clustered by processor time, from one sample per pixel on, on six scenes, in
# 5 minutes. Writes validation/slope/. Doesn't need Mitsuba.
#
# media: error by time of volpath, of clustered and of Mitsuba's fastest configuration in scenes with
# media, in 20 minutes. Writes validation/media/. Run the same command again to continue.
#
# Groups: environment, hard, plain, bounce, area, together. Most of their scenes are used only if they
# or their group are given; `all` selects every scene.
# Without a mode, the command runs all three, in about an hour on two cores. --quick does the same in a
# small form, in 10 minutes, and writes out/report unless --output is given. `benchmark all` takes a
# little more than an hour. For the next program it takes half an hour, because Mitsuba's measurements
# are kept.
# --scenes-for TIME (90s, 15m, 2h) begins no scene that would end later, estimated from earlier times.
# Scenes that this program has not measured come first, then those with the oldest measurements.
# --build FOLDER measures the program of that build folder without building it.
# Finished measurements are kept, so an interrupted run continues where it stopped. --fresh repeats the
# requested measurements. If something is missing, the command prints a line and continues without it.
#
# Exit status: 0 success; 1 a comparison failed; 2 something was left out, or a bad argument;
# 3 another run uses the same build folder; 130 or 143 interrupted.
set -eu
root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd)
build=${KINOME_BUILD:-$root/build}
. "$root/scenes/setup.sh"

# environment FOLDER REQUIREMENTS NAME: makes a virtual environment with these packages, unless it is
# up to date. NAME is for messages.
environment() {
  cmp -s "$2" "$1/requirements.txt" && return 0
  echo "validation: installing $3 into $1" >&2
  rm -rf "$1"
  if "$kinome_python" -m venv "$1" && "$1/bin/pip" install -q -r "$2" >"$1/pip.log" 2>&1; then
    cp "$2" "$1/requirements.txt"
  else
    sed -n '/^ERROR/p' "$1/pip.log" 2>/dev/null | tail -n 1 >&2 || :
    rm -rf "$1"
    echo "validation: $3 can't be installed and is left out" >&2
  fi
}

run() {
  "$kinome_python" "$root/validation/run.py" --build "$build" --work "$build" "$@"
}

# Checks the arguments first, before the minutes that installing and building take.
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
  # The lock is held until this shell and all its child processes have ended.
  mkdir -p "$build/validation"
  exec 9>"$build/validation/lock"
  if command -v flock >/dev/null 2>&1 && ! flock -n 9; then
    echo "validation: another run uses $build/validation: wait until it has ended, or" \
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
  case $modes in
  maps | budgets | threads | large | slope) ;;
  *)
    # Mitsuba's llvm variants need libllvm19.
    (kinome_packages=libllvm19 && kinome_install_packages) ||
      echo "validation: libllvm19 not found: Mitsuba's llvm variants are left out" >&2
    environment "$build/validation/mitsuba" "$root/validation/requirements.txt" Mitsuba
    ;;
  esac
  case " $modes " in
    *" benchmark "*) environment "$build/validation/cycles" \
      "$root/validation/requirements-cycles.txt" "Cycles (bpy)" ;;
  esac
else
  kinome_packages="python3-numpy $kinome_report_packages $kinome_compare_packages"
  kinome_install_packages
fi
exec "$kinome_python" "$root/validation/run.py" --build "$build" --work "$build" "$@"
