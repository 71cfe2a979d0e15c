#!/bin/sh
# see.sh SRC FARM NAME [BELOW...]: makes FARM/NAME, what the folder NAME may include: itself, all of
# base, and the outward header of each folder below it.
set -eu
src=$1 farm=$2 name=$3
shift 3
rm -rf "$farm/$name"
mkdir -p "$farm/$name"
ln -s "$src/$name" "$farm/$name/$name"
for below; do
	if [ "$below" = base ]; then
		ln -s "$src/base" "$farm/$name/base"
	else
		mkdir "$farm/$name/$below"
		ln -s "$src/$below/$below.h" "$farm/$name/$below/$below.h"
	fi
done
