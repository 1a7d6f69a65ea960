#!/usr/bin/env bash
# Configures with packages hidden, which takes seconds, and looks which programs are left.
#   optional_packages.sh SOURCE BUILD WORK
set -euo pipefail
source=$1 build=$2 work=$3
rm -rf "$work"
mkdir -p "$work"

fail() {
  echo "$1" >&2
  exit 1
}

# configure NAME option...: into WORK/NAME; what is printed is in WORK/NAME.log.
configure() {
  local name=$1
  shift
  cmake -S "$source" -B "$work/$name" -G Ninja "$@" >"$work/$name.log" 2>&1 || {
    cat "$work/$name.log" >&2
    fail "$name: not configured"
  }
}

programs() { sed -n 's,^build bin/\(acus[a-z-]*\):.*,\1,p' "$work/$1/build.ninja" | sort | tr '\n' ' '; }
all=$(find "$source/apps" -name 'acus*.cpp' -printf '%f\n' | sed 's/\.cpp$//' | sort | tr '\n' ' ')

# All that acus-fit is not linked with; and flags of the user.
hidden=(-DACUS_OPENIGTLINK=OFF -DACUS_TET=OFF -DACUS_ZIP=OFF)
for package in embree X11 OpenGL OpenCV hwy PNG; do
  hidden+=("-DCMAKE_DISABLE_FIND_PACKAGE_$package=ON")
done
PKG_CONFIG_LIBDIR=$work configure fit -DCMAKE_CXX_FLAGS_RELEASE="-O2 -g3" "${hidden[@]}"
[[ $(programs fit) == "acus acus-fit " ]] || fail "without most libraries: $(programs fit)"
grep -qE '^ +acus-live: .*libembree-dev.*libopenigtlink-dev.*libx11-dev' "$work/fit.log" ||
  fail "acus-live is left out without a word on what it needs"
grep -q '^ *the tests: all programs' "$work/fit.log" || fail "tests are left out without a word"
grep -q -- ' -O2 -g3 ' "$work/fit/compile_commands.json" || fail "the user's flags are not used"

# One library, of one program, and the preset for a debugger.
configure debug --preset debug -DACUS_TET=OFF
[[ $(programs debug) == "${all/acus-mesh /}" ]] || fail "without TetGen: $(programs debug)"
grep -qE '^ +acus-mesh: libtet1.5-dev$' "$work/debug.log" || fail "acus-mesh is left out without a word"
! grep -qE -- ' -(O[1-3]|DNDEBUG)' "$work/debug/compile_commands.json" || fail "debug: optimised"

# The flags of this build, which asks for none, are not those that CMake would have set.
! grep -q -- ' -DNDEBUG' "$build/compile_commands.json" || fail "assertions are off"
