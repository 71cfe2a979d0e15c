#!/bin/sh
# Packages, a build with address and undefined-behaviour sanitizers, and every test.
set -eu
cd "$(dirname "$0")/.."
sh tools/packages.sh
build=${BUILD:-build-test}
[ -f "$build/build.ninja" ] || meson setup "$build" -Dbuildtype=debugoptimized -Doptimization=1 \
	-Db_sanitize=address,undefined -Db_lundef=false -Db_ndebug=false
ninja -C "$build" --quiet
export LSAN_OPTIONS="suppressions=$PWD/tests/lsan.supp:print_suppressions=0"
export UBSAN_OPTIONS="halt_on_error=1:print_stacktrace=1"
export ASAN_OPTIONS="detect_odr_violation=0${ASAN_OPTIONS:+:$ASAN_OPTIONS}"
status=0
meson test -C "$build" --print-errorlogs --num-processes "$(nproc)" "$@" || status=$?
# One line a person, and a machine, can read.
python3 - "$build/meson-logs/testlog.json" <<'PYTHON'
import json, sys
results = [json.loads(line)["result"] for line in open(sys.argv[1])]
skipped = results.count("SKIP")
passed = results.count("OK") + results.count("EXPECTEDFAIL")
print(f"{passed} passed, {len(results) - passed - skipped} failed, {skipped} skipped")
PYTHON
exit $status
