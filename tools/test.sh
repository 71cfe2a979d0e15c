#!/bin/sh
# Packages, builds, tests:
#
#   sh tools/test.sh            what finds most for its time: 30 to 40 minutes on two cores
#   sh tools/test.sh quick      the tests of suite `quick` that are not of suite `plain`; two minutes or so
#   sh tools/test.sh long       every test, at full length: an hour or more
#   sh tools/test.sh ARGUMENT   what `meson test` takes: names, --suite X; in the sanitizer build alone
#
# Three builds: one with address and undefined-behaviour sanitizers; one without, optimized and with asserts, for the suite `plain`:
# laws, power cuts, the command and what is installed; in the long run one with ThreadSanitizer, for the tests of threads again. Each
# builds only what its tests need, and the second the benches too.
set -eu
cd "$(dirname "$0")/.."
sh tools/packages.sh
build=${BUILD:-build-test}
laws=${BUILD:-build}-laws
tsan=${BUILD:-build}-tsan
threaded='page/pin page/write_back page/hazards page/prefetch page/faults page/newest page/random resident/ground motion/prefetcher dem/crew api/threads'

export LSAN_OPTIONS="suppressions=$PWD/tests/lsan.supp:print_suppressions=0"
export UBSAN_OPTIONS="halt_on_error=1:print_stacktrace=1"
# The leak checker takes thread-local blocks of loaded drivers, where they lie 16 bytes behind a page, for another allocator's
# and reads what their first words happen to be: it ends with signal 11. So it does not look there.
# Memory that was freed is kept for a while, so that its use is seen: 16 MB of it. The default, 256, takes a tenth of the time.
export ASAN_OPTIONS="detect_odr_violation=0:intercept_tls_get_addr=0:quarantine_size_mb=16${ASAN_OPTIONS:+:$ASAN_OPTIONS}"
status=0
logs=
both=
without='--no-suite long'
later='--no-suite later'
if [ "${1:-}" = long ]; then
	shift
	both='--suite both'
	without=
	later=
	export FURROW_LONG=1
fi

# setup FOLDER OPTION...: a build with asserts, unless there is one. Line numbers are all that is kept for a debugger: it compiles
# in three quarters of the time. gold links in half the time of binutils' own, where it is there.
linker=$(command -v ld.gold > /dev/null && echo -fuse-ld=gold || true)
setup() {
	folder=$1
	shift
	[ -f "$folder/build.ninja" ] || meson setup "$folder" -Dbuildtype=debugoptimized -Dc_args=-g1 -Dc_link_args="$linker" -Db_lundef=false -Db_ndebug=false "$@"
}

# run FOLDER ARGUMENT...: builds what these tests need, and runs them. One more at a time than processors: some wait for the disk.
run() {
	folder=$1
	shift
	meson test -C "$folder" --print-errorlogs --num-processes $(($(nproc) + 1)) "$@" || status=$?
	logs="$logs $folder/meson-logs/testlog.json"
}

# Whether the compiler has it, and this machine lets it run.
has_tsan() {
	probe=$(mktemp)
	echo 'int main(void) { return 0; }' | ${CC:-cc} -fsanitize=thread -x c - -o "$probe" 2>/dev/null && "$probe" 2>/dev/null
	found=$?
	rm -f "$probe"
	return $found
}

setup "$build" -Doptimization=1 -Db_sanitize=address,undefined
if [ "${1:-}" = quick ]; then
	shift
	run "$build" --suite quick --no-suite plain "$@"
elif [ $# -gt 0 ]; then
	run "$build" "$@"
else
	# shellcheck disable=SC2086
	run "$build" --no-suite plain --no-suite packages $later $without
	setup "$laws"
	ninja -C "$laws" --quiet benches
	# shellcheck disable=SC2086
	run "$laws" --suite plain --suite later $both $without
	if [ -z "${FURROW_LONG:-}" ]; then
		: # ThreadSanitizer is for the long run
	elif has_tsan; then
		setup "$tsan" -Doptimization=1 -Db_sanitize=thread
		# The detector of deadlocks counts LLVM's locks without an end, and fails at 64.
		# shellcheck disable=SC2086
		TSAN_OPTIONS="suppressions=$PWD/tests/tsan.supp:detect_deadlocks=0" PAGE_STEPS=10000 run "$tsan" $threaded
	else
		echo "ThreadSanitizer: ${CC:-cc} or this machine has none; its tests are left out" >&2
	fi
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
