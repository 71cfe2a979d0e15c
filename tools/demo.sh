#!/bin/sh
# From a clean clone to pictures: packages, a release build, a synthetic DEM, an import, a drive.
set -eu
cd "$(dirname "$0")/.."
sh tools/packages.sh
[ -f build/build.ninja ] || meson setup build >/dev/null
ninja -C build --quiet tools/furrow
furrow=build/tools/furrow
mkdir -p demo
$furrow synth -o demo/demo.tif --posts 2049x2049 --spacing 1 --kind ridged --relief 160 --seed 7
$furrow import demo/demo.tif -o demo/demo.furrow --overwrite
rm -rf demo/drive
$furrow drive tools/scenes/demo.yaml --store demo/demo.furrow -o demo/drive
$furrow verify demo/demo.furrow
$furrow export demo/demo.furrow -o demo/hillshade.png --layer hillshade
echo
echo "pictures:  $(ls demo/drive/*.png demo/hillshade.png | tr '\n' ' ')"
echo "figures:   demo/drive/run.json"
echo "terrain:   demo/demo.furrow (try: $furrow info demo/demo.furrow)"
