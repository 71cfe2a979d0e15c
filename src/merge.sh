#!/bin/sh
# merge.sh CC... -- OBJCOPY OUTPUT ARCHIVE...: links whole archives into one object. Names that are hidden become local, and those that do not
# begin with furrow_: the compiler does not hide functions that it compiles for several processors.
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
"$objcopy" --localize-hidden --wildcard --keep-global-symbol="furrow_*" "$output"
