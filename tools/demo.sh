#!/bin/sh
# From a clean clone to pictures: packages, a release build, a synthetic DEM, an import, a vehicle's drive across a hill.
set -eu
cd "$(dirname "$0")/.."
sh tools/packages.sh
[ -f build/build.ninja ] || meson setup build >/dev/null
ninja -C build --quiet tools/furrow
furrow=build/tools/furrow
mkdir -p demo
$furrow synth -o demo/demo.tif --posts 2049x2049 --spacing 1 --kind ridged --relief 160 --seed 7
rm -rf demo/drive demo/ruts.furrow # of an earlier demo: a terrain that has ruts over it is not replaced
$furrow import demo/demo.tif -o demo/demo.furrow --overwrite
scene=tools/scenes/vehicles/offroad.yaml
camera='{fixed: {eye: [74.5, 51.8, 118.5], target: [66.5, 57.2, 115.5]}}' # beside the way, where the vehicle is after 12 s
case $($furrow --version) in *"no MuJoCo"*)
	scene=tools/scenes/demo.yaml
	camera=
	echo "demo: this build has no MuJoCo, so its wheels follow paths; sh tools/mujoco.sh fetches it, then remove the folder build"
	;;
esac
$furrow drive $scene --store demo/demo.furrow --overlay demo/ruts.furrow -o demo/drive ${camera:+--set "view.camera=$camera"}
$furrow verify demo/ruts.furrow
$furrow export demo/ruts.furrow -o demo/ruts.png --layer offset --window 30,30,100,70
$furrow export demo/demo.furrow -o demo/hillshade.png --layer hillshade
echo
echo "pictures:  $(ls demo/drive/*.png demo/hillshade.png demo/ruts.png | tr '\n' ' ')"
echo "figures:   demo/drive/run.json; of a vehicle demo/drive/vehicles.csv, of its wheels demo/drive/objects.csv"
echo "a plot:    python3 examples/plot_drive.py demo/drive demo/drive.png (with python3-matplotlib)"
echo "terrain:   demo/demo.furrow, its ruts demo/ruts.furrow (try: $furrow info demo/ruts.furrow)"
echo "a window:  $furrow view tools/scenes/demo.yaml"
