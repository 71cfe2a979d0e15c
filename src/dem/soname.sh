#!/bin/sh
# soname.sh COMPILER ARGUMENT...: prints the name under which the dynamic loader knows the library libgdal that these arguments link.
set -eu
made=$(mktemp)
trap 'rm -f "$made"' EXIT
"$@" -shared -x c /dev/null -o "$made" -Wl,--no-as-needed -lgdal
readelf -d "$made" | sed -n 's/.*(NEEDED).*\[\(libgdal[^]]*\)\].*/\1/p'
