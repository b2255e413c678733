# Shared by compare/run, tests/run, tests/sanitized and .ci/run: what must be there before anything runs. Sourced by bash.
# Everything that is not the program's own output goes to stderr. What cannot be prepared ends with 3: no verdict.

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
build=${CONCORD_BUILD:-$root/build}  # a folder of its own for each set of options

# Debian 12 packages, the tools first; and what the tests need beside them.
packages=(
  cmake ninja-build g++ ccache
  libeigen3-dev libsundials-dev libsuitesparse-dev libspectra-dev
  libtomlplusplus-dev libmuparser-dev libnetcdf-dev nlohmann-json3-dev libcli11-dev libfmt-dev libsqlite3-dev
  gnuplot-nox
)
packages_of_tests=(libgtest-dev libgmock-dev librapidcheck-dev catch2 valgrind)
packages_of_python=(pybind11-dev python3-dev python3-numpy)
packages_of_oracle=(libsimbody-dev)

# Prints the packages that are not installed; none on a machine without dpkg, where CMake speaks for itself.
missing_packages() {
  command -v dpkg-query >/dev/null || return 0
  local installed package
  installed=$(dpkg-query -W -f='${Package} ${db:Status-Status}\n' "${packages[@]}" 2>/dev/null || true)
  for package in "${packages[@]}"; do
    grep -qx "$package installed" <<<"$installed" || echo "$package"
  done
}

# Installs what is missing; without root names it and the command, and ends with 2.
install_packages() {
  local missing
  mapfile -t missing < <(missing_packages)
  [ "${#missing[@]}" -eq 0 ] && return
  if [ "$(id -u)" -ne 0 ]; then
    {
      echo "missing Debian packages: ${missing[*]}"
      echo "install them as root, then start again:"
      echo "  apt-get update && apt-get install --yes --no-install-recommends ${missing[*]}"
    } >&2
    exit 2
  fi
  echo "installing Debian packages: ${missing[*]}" >&2
  if ! { apt-get update && DEBIAN_FRONTEND=noninteractive apt-get install --yes --no-install-recommends "${missing[@]}"; } >&2; then
    echo "apt-get could not install them: see above" >&2
    exit 3
  fi
}

# configure FOLDER [CMAKE OPTION...]: once; again only if the folder belongs to another place. What CONCORD_CMAKE_OPTIONS
# says goes before.
configure() {
  local folder=$1 home=
  shift
  if [ -f "$folder/CMakeCache.txt" ]; then
    home=$(sed -n 's/^CMAKE_HOME_DIRECTORY:INTERNAL=//p' "$folder/CMakeCache.txt")
  fi
  [ "$home" = "$root" ] && [ -f "$folder/build.ninja" ] && return
  # shellcheck disable=SC2086  # several words
  if ! cmake --fresh -G Ninja -S "$root" -B "$folder" "$@" ${CONCORD_CMAKE_OPTIONS:-} >&2; then
    echo "CMake could not configure $folder: see above" >&2
    exit 3
  fi
}

# turn_on FOLDER OPTION: the folder builds what OPTION names too, from now on.
turn_on() {
  grep -qx "$2:BOOL=ON" "$1/CMakeCache.txt" && return
  if ! cmake "-D$2=ON" "$1" >&2; then
    echo "CMake could not turn on $2 in $1: see above" >&2
    exit 3
  fi
}

# build FOLDER TARGET...: silent if there is nothing to do.
build() {
  local folder=$1
  shift
  set -o pipefail
  if ! ninja -C "$folder" "$@" | { grep --line-buffered -v -e '^ninja: Entering' -e '^ninja: no work to do' -e 'Re-checking globbed' -e 'Finding the commit' || true; } >&2; then
    echo "the build of $* failed: see above" >&2
    exit 3
  fi
}
