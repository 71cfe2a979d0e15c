#!/bin/sh
# merge.sh CC... -- OBJCOPY OUTPUT ARCHIVE...: links whole archives into one object; names that are hidden become local.
set -eu
compiler=
while [ "$1" != -- ]; do
	compiler="$compiler $1"
	shift
done
objcopy=$2 output=$3
shift 3
# shellcheck disable=SC2086
$compiler -r -nostdlib -o "$output" -Wl,--whole-archive "$@" -Wl,--no-whole-archive
"$objcopy" --localize-hidden "$output"
