#!/bin/sh
# Packages, a build with address and undefined-behaviour sanitizers, and every test; then those of the
# threads again under ThreadSanitizer. With arguments, which meson test gets, the former alone.
set -eu
cd "$(dirname "$0")/.."
sh tools/packages.sh
build=${BUILD:-build-test}
tsan=${BUILD:-build}-tsan
threaded='page/pin page/write_back page/hazards page/prefetch page/faults page/newest page/random resident/ground motion/prefetcher'

[ -f "$build/build.ninja" ] || meson setup "$build" -Dbuildtype=debugoptimized -Doptimization=1 \
	-Db_sanitize=address,undefined -Db_lundef=false -Db_ndebug=false
ninja -C "$build" --quiet
export LSAN_OPTIONS="suppressions=$PWD/tests/lsan.supp:print_suppressions=0"
export UBSAN_OPTIONS="halt_on_error=1:print_stacktrace=1"
# The leak checker takes thread-local blocks of loaded drivers, where they lie 16 bytes behind a page, for another allocator's
# and reads what their first words happen to be: it ends with signal 11. So it does not look there.
export ASAN_OPTIONS="detect_odr_violation=0:intercept_tls_get_addr=0${ASAN_OPTIONS:+:$ASAN_OPTIONS}"
status=0
meson test -C "$build" --print-errorlogs --num-processes "$(nproc)" "$@" || status=$?
logs=$build/meson-logs/testlog.json

# Whether the compiler has it, and this machine lets it run.
has_tsan() {
	probe=$(mktemp)
	echo 'int main(void) { return 0; }' | ${CC:-cc} -fsanitize=thread -x c - -o "$probe" 2>/dev/null && "$probe" 2>/dev/null
	found=$?
	rm -f "$probe"
	return $found
}

if [ $# -gt 0 ]; then
	:
elif has_tsan; then
	[ -f "$tsan/build.ninja" ] || meson setup "$tsan" -Dbuildtype=debugoptimized -Doptimization=1 \
		-Db_sanitize=thread -Db_lundef=false -Db_ndebug=false
	# shellcheck disable=SC2086
	PAGE_STEPS=10000 meson test -C "$tsan" --print-errorlogs --num-processes "$(nproc)" $threaded || status=$?
	logs="$logs $tsan/meson-logs/testlog.json"
else
	echo "ThreadSanitizer: ${CC:-cc} or this machine has none; its tests are left out" >&2
fi

# One line a person, and a machine, can read.
# shellcheck disable=SC2086
python3 - $logs <<'PYTHON'
import json, sys
results = [json.loads(line)["result"] for log in sys.argv[1:] for line in open(log)]
skipped = results.count("SKIP")
passed = results.count("OK") + results.count("EXPECTEDFAIL")
print(f"{passed} passed, {len(results) - passed - skipped} failed, {skipped} skipped")
PYTHON
exit $status
