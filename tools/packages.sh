#!/bin/sh
# Installs what Furrow builds with on Debian 12 (and its relatives), and brings MuJoCo beside the project (mujoco.sh). Nothing is done when all is there.
set -eu
packages="build-essential clang meson ninja-build pkg-config python3 python3-pip libegl-dev libegl1 libgl1-mesa-dri
libepoxy-dev liblz4-dev libzstd-dev liblzma-dev libsqlite3-dev libpng-dev libwebp-dev zlib1g-dev libcmocka-dev libgdal-dev libproj-dev gdal-bin libcyaml-dev libyaml-dev
libcglm-dev libxxhash-dev libcjson-dev libassimp-dev liblmdb-dev libopenmpi-dev openmpi-bin gnuplot-nox
libsdl2-dev libpango1.0-dev libcairo2-dev libfontconfig-dev fonts-dejavu-core poppler-utils xvfb xdotool x11-apps groff locales
python3-numpy python3-matplotlib libjs-leaflet debhelper dh-python lintian mmdebstrap mandoc zsh fish"
missing=
for package in $packages; do
	dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null | grep -qx installed || missing="$missing $package"
done
if [ -n "$missing" ]; then
	if ! command -v apt-get >/dev/null; then
		echo "packages: this is not Debian; install the equivalents of:$missing" >&2
		exit 1
	fi
	sudo=
	[ "$(id -u)" = 0 ] || sudo=sudo
	export DEBIAN_FRONTEND=noninteractive
	$sudo apt-get update -qq
	# shellcheck disable=SC2086
	$sudo apt-get install -y -qq --no-install-recommends $missing >/dev/null
fi
sh "$(dirname "$0")/mujoco.sh" || true # it says what is left out
