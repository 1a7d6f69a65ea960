# shellcheck shell=bash
# Sourced by the workflows: where the programs are. Needs $root, the folder above pipelines/.

# find_programs: ACUS_BIN, exported and first on the PATH: as it is, or build/bin of the sources, or
# beside the share/ of an installation.
find_programs() {
  if [[ -n ${ACUS_BIN:-} ]]; then
    ACUS_BIN=$(realpath -m "$ACUS_BIN")
  elif [[ -f $root/CMakeLists.txt ]]; then
    ACUS_BIN=$root/build/bin
  else
    ACUS_BIN=$(realpath -m "$root/../../bin")
  fi
  export ACUS_BIN PATH="$ACUS_BIN:$PATH"
}

# need_programs [NAME...]: the same; programs of the sources are first brought up to date.
need_programs() {
  [[ -n ${ACUS_BIN:-} || ! -f $root/CMakeLists.txt ]] || "$root/pipelines/build" --programs "$@" >&2
  find_programs
}

# default_output NAME: a folder under build/ of the sources, or in the working folder.
default_output() {
  if [[ -f $root/CMakeLists.txt ]]; then
    echo "$root/build/$1"
  else
    echo "$PWD/acus_$1"
  fi
}
