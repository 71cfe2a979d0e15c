#!/bin/sh
# Makes the Debian packages of the last commit:
#
#   sh tools/debian.sh OUT [BUILD]     into the folder OUT, by the tarball that `meson dist` makes of the build folder BUILD (build)
#
# DEB_BUILD_OPTIONS="nocheck noopt" is quicker. What is missing to build them, dpkg-buildpackage names.
set -eu
mkdir -p "$1"
out=$(cd "$1" && pwd)
cd "$(dirname "$0")/.."
build=${2:-build}
# Debian has no MuJoCo 4: what tools/packages.sh brought goes into the packages, or what MUJOCO names. MUJOCO= leaves vehicles out.
[ -n "${MUJOCO+given}" ] || [ ! -d mujoco-4.0.0 ] || MUJOCO=$PWD/mujoco-4.0.0
export MUJOCO="${MUJOCO-}"
[ -f "$build/build.ninja" ] || meson setup "$build"
ninja -C "$build" build.ninja >/dev/null # as meson.build says now
meson dist -C "$build" --no-tests --allow-dirty --formats gztar >/dev/null
tarball=$(ls -t "$build"/meson-dist/*.tar.gz | head -1)
tar -xzf "$tarball" -C "$out"
cd "$out/$(basename "$tarball" .tar.gz)"
dpkg-buildpackage -us -uc -b
