#!/bin/sh
# see.sh SRC FARM NAME [BELOW...]: makes FARM/NAME, what the folder NAME may include: itself, all of
# base, and of each folder below it the outward header with the parts that it includes: that of api is furrow.h. deform and bearing may include all of soil.
# world and the folders above it see api/furrow.h, too, which includes nothing of ours: its structs are the world's own.
# It runs when meson configures: after a new part, `meson setup --reconfigure BUILD`.
set -eu
src=$1 farm=$2 name=$3
shift 3
rm -rf "$farm/$name"
mkdir -p "$farm/$name"
ln -s "$src/$name" "$farm/$name/$name"
case " $name $* " in
" api "*) ;;
*" world "*)
	mkdir "$farm/$name/api"
	ln -s "$src/api/furrow.h" "$farm/$name/api/furrow.h"
	;;
esac
for below; do
	if [ "$below" = base ] || [ "$name/$below" = deform/soil ] || [ "$name/$below" = bearing/soil ]; then
		ln -s "$src/$below" "$farm/$name/$below"
	else
		mkdir "$farm/$name/$below"
		outward=$below/$below.h
		[ "$below" != api ] || outward=api/furrow.h
		for header in $outward $(sed -n "s,^#include \"\($below/[^\"]*\)\".*,\1,p" "$src/$outward"); do
			ln -s "$src/$header" "$farm/$name/$header"
		done
	fi
done
