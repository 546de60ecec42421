# shellcheck shell=sh disable=SC2154
# Packages and functions that scenes/render.sh, tests/run.sh and the scripts of validation share. They
# source this file with `root` set to the top folder and `build` to the build folder.

kinome_packages="build-essential cmake ninja-build pkg-config \
libopenexr-dev libembree-dev libtbb-dev libtinygltf-dev nlohmann-json3-dev libglm-dev \
libpugixml-dev libcli11-dev libspdlog-dev libfmt-dev libhwy-dev libpng-dev libjpeg-dev libstb-dev \
libopenimageio-dev libgtest-dev libbenchmark-dev blender-data python3 python3-numpy"
# Additional packages for pages with images and plots (validation/thesis.sh and its test).
kinome_report_packages="python3-matplotlib python3-pil"

# The packages belong to Debian's Python. Another Python may precede it in the PATH.
kinome_python=python3
[ ! -x /usr/bin/python3 ] || kinome_python=/usr/bin/python3

# Additional packages for validation/kinome-compare and its tests.
kinome_compare_packages="python3-openimageio python3-scipy python3-matplotlib"

# Encodes videos, for the test of `kinome film`. Without it, animations remain PNG frames.
kinome_film_packages="ffmpeg"

# Additional packages for the Python module. Debian 12 has no package of nanobind.
kinome_module_packages="python3-dev python3-venv"
kinome_module_requirements="nanobind==3.1.0 scikit-build-core==1.1.2"

# Reader of Cryptomatte files, for a test. Debian has the packages that it depends on, except mmh3.
kinome_reader_requirements="decryptomatte==1.0.1 mmh3==5.3.1"

# Additional packages for kinome-view and its tests.
kinome_viewer_packages="libglfw3-dev libimgui-dev xvfb xauth xdotool libgl1-mesa-dri fonts-dejavu-core \
python3-pil"

# Additional packages for rendering with several processes, and for its test.
kinome_mpi_packages="libopenmpi-dev openmpi-bin"

# Prints the packages that aren't fully installed, one per line, with a single query.
kinome_missing_packages() {
  # shellcheck disable=SC2086
  set -- $kinome_packages
  installed=$(dpkg-query -W -f '${db:Status-Status} ${Package}\n' "$@" 2>/dev/null |
    sed -n 's/^installed //p')
  for package in "$@"; do
    printf '%s\n' "$installed" | grep -qxF "$package" || printf '%s\n' "$package"
  done
}

# Installs missing packages. Prints nothing if all are installed.
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
  # Package lists may be old. In a fresh container, they are missing.
  $as_root apt-get update -q || return 1
  # shellcheck disable=SC2086
  $as_root env DEBIAN_FRONTEND=noninteractive \
    apt-get install -q -y --no-install-recommends $missing
}

# Creates a virtual environment in the build folder with the build requirements of the Python module,
# at the path at which apps/python/CMakeLists.txt searches for it. Does nothing if it exists. If it
# can't be created, the module isn't built.
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

# Adds readers of other projects to this environment, for tests. Without them, these tests are skipped.
kinome_install_readers() {
  environment=$build/python-env
  [ -x "$environment/bin/pip" ] || return 0
  [ "$(cat "$environment/readers.txt" 2>/dev/null)" != "$kinome_reader_requirements" ] || return 0
  # shellcheck disable=SC2086
  if "$environment/bin/pip" install -q --disable-pip-version-check --no-deps \
    $kinome_reader_requirements; then
    echo "$kinome_reader_requirements" >"$environment/readers.txt"
  else
    echo "Tests by other readers are left out: they need $kinome_reader_requirements" >&2
  fi
}

# kinome_configure [CMAKE ARGUMENT...]: configures the build folder once, and again if KINOME_WERROR
# changes. CMake itself keeps the configuration up to date. The environment variable KINOME_ISAS is
# passed to CMake; see KinomePlugin.cmake.
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
