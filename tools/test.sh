#!/bin/sh
# Packages, builds, tests:
#
#   sh tools/test.sh            what finds most for its time: at most ten minutes on two cores, the builds included. Of the slow tests a sixth,
#                               which the hash of the commit chooses
#   sh tools/test.sh quick      the tests of suite `quick`: under a minute once they are built
#   sh tools/test.sh long       every test, at full length: an hour or more
#   sh tools/test.sh ARGUMENT   what `meson test` takes: names, --suite X; in build-test alone
#
# Three builds. build-test is optimized, with asserts, and ends where UBSan finds undefined behaviour: it runs everything but faults and fuzz targets. build-asan has
# address and undefined-behaviour sanitizers: it runs fuzz targets always, faults and the tests of each folder of src whose sources changed since the
# last tag, of slow ones the same sixth, and in the long run all that is not `plain`. build-tsan has ThreadSanitizer, for the tests of threads, in the long run.
# Each builds only what its tests need.
set -eu
cd "$(dirname "$0")/.."
sh tools/packages.sh
build=${BUILD:-build-test}
asan=${BUILD:-build}-asan
tsan=${BUILD:-build}-tsan
threaded='page/pin page/write_back page/hazards page/prefetch page/faults page/newest page/random resident/ground resident/homes resident/prefetcher base/crew laws/batches laws/threads api/threads'

export LSAN_OPTIONS="suppressions=$PWD/tests/lsan.supp:print_suppressions=0"
export UBSAN_OPTIONS="halt_on_error=1:print_stacktrace=1"
# The leak checker takes thread-local blocks of loaded drivers, where they lie 16 bytes behind a page, for another allocator's
# and reads what their first words happen to be: it ends with signal 11. So it does not look there.
# Memory that was freed is kept for a while, so that its use is seen: 16 MB of it. The default, 256, takes a tenth of the time.
export ASAN_OPTIONS="detect_odr_violation=0:intercept_tls_get_addr=0:quarantine_size_mb=16${ASAN_OPTIONS:+:$ASAN_OPTIONS}"
# Chooses the cases of kills, power cuts and ranks that a run takes (tests/support/chosen.h).
FURROW_COMMIT=${FURROW_COMMIT:-$(git rev-parse HEAD 2>/dev/null | cut -c1-8)}
export FURROW_COMMIT
status=0
logs=
# Higher digits than those that choose cases within a test, so that each case meets each sixth.
turn=$((0x${FURROW_COMMIT:-0} / 144 % 6))
others=--no-suite=long
for other in 1 2 3 4 5; do
	others="$others --no-suite=turn_$(((turn + other) % 6))"
done
length="--no-suite=asan $others"
if [ "${1:-}" = long ]; then
	shift
	length=
	export FURROW_LONG=1
fi

# setup FOLDER OPTION...: a build with asserts, unless there is one. Line numbers are all that is kept for a debugger: it compiles
# in three quarters of the time. gold links in half the time of binutils' own, where it is there.
linker=$(command -v ld.gold > /dev/null && echo -fuse-ld=gold || true)
setup() {
	folder=$1
	arguments=$2
	shift 2
	[ -f "$folder/build.ninja" ] || meson setup "$folder" -Dbuildtype=debugoptimized -Dc_args="-g1 $arguments" -Dc_link_args="$linker" -Db_lundef=false -Db_ndebug=false "$@"
}

# run FOLDER ARGUMENT...: builds what these tests need, and runs them. One more at a time than processors: some wait for the disk.
run() {
	folder=$1
	shift
	meson test -C "$folder" --print-errorlogs --num-processes $(($(nproc) + 1)) "$@" || status=$?
	logs="$logs $folder/meson-logs/testlog.json"
}

# Prints `--suite NAME` for each folder of src, and for tools, whose sources changed since the last tag; where there is no tag, in the
# last five commits.
changed() {
	since=$(git describe --tags --abbrev=0 2>/dev/null || git rev-list --max-count=6 HEAD 2>/dev/null | tail -n 1)
	git diff --name-only "$since" -- src tools 2>/dev/null | sed -n 's,^src/\([a-z]*\)/.*\.[ch]$,\1,p; s,^tools/.*\.[ch]$,tools,p' | sort -u | sed 's/^/--suite /; s/tools$/tools --suite sanitized/'
}

# Whether the compiler has it, and this machine lets it run.
has_tsan() {
	probe=$(mktemp)
	echo 'int main(void) { return 0; }' | ${CC:-cc} -fsanitize=thread -x c - -o "$probe" 2>/dev/null && "$probe" 2>/dev/null
	found=$?
	rm -f "$probe"
	return $found
}

# The soil's law is compiled for the processor family's first instruction set and for the widest that this processor has, since each takes a minute or two;
# in the long run for all.
sets=$(grep -qw avx512vl /proc/cpuinfo 2>/dev/null && echo avx512 || echo avx2)
if [ -n "${FURROW_LONG:-}" ]; then
	sets=avx2,avx512
	[ ! -f "$build/build.ninja" ] || meson setup --reconfigure "$build" -Dlaw_sets="$sets"
fi
# With -fsanitize gcc takes some variables for unset that are not.
setup "$build" "-fsanitize=undefined -fsanitize-undefined-trap-on-error -Wno-maybe-uninitialized" -Dlaw_sets="$sets"
if [ "${1:-}" = quick ]; then
	shift
	run "$build" --suite quick "$@"
elif [ $# -gt 0 ]; then
	run "$build" "$@"
else
	ninja -C "$build" --quiet benches
	# shellcheck disable=SC2086
	run "$build" --no-suite packages --no-suite sanitized $length
	setup "$asan" "" -Doptimization=1 -Db_sanitize=address,undefined
	if [ -n "${FURROW_LONG:-}" ]; then
		run "$asan" --no-suite packages --no-suite plain
	else
		# shellcheck disable=SC2046
		run "$asan" --suite fuzz --suite fault $(changed) --no-suite packages --no-suite plain --no-suite later $others
	fi
	if [ -z "${FURROW_LONG:-}" ]; then
		: # ThreadSanitizer is for the long run
	elif has_tsan; then
		setup "$tsan" "" -Doptimization=1 -Db_sanitize=thread
		# The detector of deadlocks counts LLVM's locks without an end, and fails at 64.
		# shellcheck disable=SC2086
		TSAN_OPTIONS="suppressions=$PWD/tests/tsan.supp:detect_deadlocks=0" PAGE_STEPS=10000 run "$tsan" $threaded
	else
		echo "ThreadSanitizer: ${CC:-cc} or this machine has none; its tests are left out" >&2
	fi
fi

# One line a person, and a machine, can read. It fails if a test skipped that should have run.
# shellcheck disable=SC2086
python3 tests/summary.py $logs || status=1
exit $status
