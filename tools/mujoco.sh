#!/bin/sh
# Brings MuJoCo 4.0.0, which vehicles need, into the folder mujoco-4.0.0 beside this project's README: its library and headers, out of the Python
# package `mujoco-core`, by pip. Nothing goes into any Python. Nothing is done when it is there. Exit 1: it cannot be had; everything else builds
# without it.
set -eu
cd "$(dirname "$0")/.."
version=4.0.0
folder=mujoco-$version
[ -f "$folder/include/mujoco/mujoco.h" ] && [ -f "$folder/libmujoco.so.$version" ] && exit 0
case $(uname -s)-$(uname -m) in
Linux-x86_64) hash=885bd9b9cc0a6b5ba1114923eb954027652a6a0c115fa46b3218b83bae72ac4f ;;
Linux-aarch64) hash=34de0c1674caa95abd3a0214ded4461e688150fbaa015b2db523d553b7411c3b ;;
*)
	echo "mujoco: there is no package of MuJoCo $version for $(uname -s) on $(uname -m); build it and name its folder with -Dmujoco=DIR" >&2
	exit 1
	;;
esac
pip=
for python in python3 /usr/bin/python3; do
	[ -z "$pip" ] && "$python" -m pip --version >/dev/null 2>&1 && pip="$python -m pip"
done
if [ -z "$pip" ]; then
	echo "mujoco: there is no pip (Debian: python3-pip); vehicles are left out" >&2
	exit 1
fi
work=$(mktemp -d "$folder.XXXXXX") # beside its place, so that the last step is a rename
trap 'rm -rf "$work"' EXIT INT TERM
echo "mujoco-core==$version --hash=sha256:$hash" > "$work/wanted"
# The library does not care which Python its package is for.
if ! $pip --disable-pip-version-check -q download --no-deps --only-binary=:all: --platform "manylinux_2_28_$(uname -m)" --implementation cp \
	--python-version 3.11 --abi cp311 --require-hashes -r "$work/wanted" -d "$work" > "$work/log" 2>&1; then
	tail -n 2 "$work/log" >&2
	echo "mujoco: MuJoCo $version cannot be fetched; vehicles are left out. To try again: sh tools/mujoco.sh" >&2
	exit 1
fi
mkdir "$work/whole"
(cd "$work" && python3 -m zipfile -e mujoco_core-*.whl unpacked)
mv "$work/unpacked/mujoco/include" "$work/unpacked/mujoco/libmujoco.so.$version" "$work/unpacked"/mujoco_core-*.dist-info/licenses/* "$work/whole"
rm -rf "$folder"
mv "$work/whole" "$folder"
echo "mujoco: MuJoCo $version is in $folder"
