# shellcheck shell=sh disable=SC2154
# What scenes/render.sh, tests/run.sh and the scripts of validation have in common. To be sourced,
# with `root` set to the top folder and `build` to the build folder.

kinome_packages="build-essential cmake ninja-build pkg-config \
libopenexr-dev libembree-dev libtbb-dev libtinygltf-dev nlohmann-json3-dev libglm-dev \
libpugixml-dev libcli11-dev libspdlog-dev libfmt-dev libhwy-dev libpng-dev libjpeg-dev \
libopenimageio-dev libgtest-dev libbenchmark-dev blender-data python3 python3-numpy"
# What the pages with pictures and plots need beside these (validation/thesis.sh and its test).
kinome_report_packages="python3-matplotlib python3-pil"

# The packages are of Debian's Python; another one may come before it on the PATH.
kinome_python=python3
[ ! -x /usr/bin/python3 ] || kinome_python=/usr/bin/python3

# What validation/kinome-compare and its tests need beside kinome_packages.
kinome_compare_packages="python3-openimageio python3-scipy python3-matplotlib"

# What makes videos of films, for the test of `kinome film`; without it films are PNG frames.
kinome_film_packages="ffmpeg"

# What the Python module needs beside kinome_packages; nanobind is not among Debian 12's.
kinome_module_packages="python3-dev python3-venv"
kinome_module_requirements="nanobind==3.1.0 scikit-build-core==1.1.2"

# What kinome-view needs beside kinome_packages, and its tests.
kinome_viewer_packages="libglfw3-dev libimgui-dev xvfb xauth xdotool libgl1-mesa-dri python3-pil"

# What rendering with several processes needs beside kinome_packages, and its test.
kinome_mpi_packages="libopenmpi-dev openmpi-bin"

# One question for all packages; those that are not fully installed, one a line.
kinome_missing_packages() {
  # shellcheck disable=SC2086
  set -- $kinome_packages
  installed=$(dpkg-query -W -f '${db:Status-Status} ${Package}\n' "$@" 2>/dev/null |
    sed -n 's/^installed //p')
  for package in "$@"; do
    printf '%s\n' "$installed" | grep -qxF "$package" || printf '%s\n' "$package"
  done
}

# Installs what is missing; does and says nothing where all is there.
kinome_install_packages() {
  if ! command -v dpkg-query >/dev/null 2>&1; then
    echo "Not a Debian system: what these packages hold is taken to be there: $kinome_packages" >&2
    return 0
  fi
  missing=$(kinome_missing_packages | tr '\n' ' ')
  missing=${missing% }
  [ -n "$missing" ] || return 0
  echo "apt-get install -y --no-install-recommends $missing"
  if [ "$(id -u)" -eq 0 ]; then
    as_root=
  elif command -v sudo >/dev/null 2>&1; then
    as_root=sudo
  else
    echo "These packages are missing, and installing them needs root or sudo." >&2
    return 1
  fi
  # Package lists may be old or, in a fresh container, not there at all.
  $as_root apt-get update -q || return 1
  # shellcheck disable=SC2086
  $as_root env DEBIAN_FRONTEND=noninteractive \
    apt-get install -q -y --no-install-recommends $missing
}

# A virtual environment in the build folder with what the module is built by, where
# python/CMakeLists.txt looks for it; does nothing where it is there already. Where it can't be had,
# the module isn't built.
kinome_python_environment() {
  environment=$build/python-env
  [ "$(cat "$environment/requirements.txt" 2>/dev/null)" != "$kinome_module_requirements" ] ||
    return 0
  rm -rf "$environment"
  mkdir -p "$build"
  # shellcheck disable=SC2086
  if "$kinome_python" -m venv --system-site-packages "$environment" &&
    "$environment/bin/pip" install -q --disable-pip-version-check $kinome_module_requirements; then
    echo "$kinome_module_requirements" >"$environment/requirements.txt"
    [ ! -f "$build/build.ninja" ] || cmake "$build"
  else
    rm -rf "$environment"
    echo "The Python module is left out: it needs $kinome_module_requirements" >&2
  fi
}

# kinome_configure [CMAKE ARGUMENT...]: once a build folder, and again where KINOME_WERROR is asked
# for anew; CMake keeps it up to date by itself. KINOME_ISAS: as CMake's option, see KinomePlugin.cmake.
kinome_configure() {
  if [ -f "$build/build.ninja" ] &&
    { [ -z "${KINOME_WERROR:-}" ] ||
      grep -qx "KINOME_WERROR:BOOL=$KINOME_WERROR" "$build/CMakeCache.txt"; }; then
    return 0
  fi
  if command -v ccache >/dev/null 2>&1; then
    set -- -DCMAKE_CXX_COMPILER_LAUNCHER=ccache "$@"
  fi
  cmake -S "$root" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release \
    -DKINOME_WERROR="${KINOME_WERROR:-OFF}" ${KINOME_ISAS:+"-DKINOME_ISAS=$KINOME_ISAS"} "$@"
}
