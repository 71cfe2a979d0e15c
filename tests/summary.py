"""The closing line of `sh tools/test.sh`: how many programs passed and failed, and what was skipped, from the logs that meson leaves.

    python3 tests/summary.py LOG.json...

A test that skips says why: unittest prints it, skip_since() of tests/support/skip.h does, and a program that ends with 77 prints a line.
The exit status is 1 if a test skipped for want of something that tools/packages.sh installs. Two kinds of reasons may stand: those that
begin with ELSEWHERE, and LONG. FURROW_TESTS_MAY_SKIP=1 lets all stand: for a build without some part, and for other systems."""
import collections
import json
import os
import re
import sys

ELSEWHERE = "not on this machine: "
LONG = "for sh tools/test.sh long"
SKIPPED = re.compile(r"\bskipped (?:'([^'\n]*)'|\"([^\"\n]*)\")")
OF_CMOCKA = re.compile(r"^\[ +SKIPPED \] (\d+) test\(s\)", re.M)


def reasons(test):
    """Why each skipped test of a program skipped. `test`: a line of meson's log."""
    text = test.get("stdout", "") + "\n" + test.get("stderr", "")
    found = [one or other for one, other in SKIPPED.findall(text)]
    # cmocka counts those that called skip(), with or without a reason.
    found += ["it says no reason"] * max(0, sum(map(int, OF_CMOCKA.findall(text))) - len(found))
    if test["result"] == "SKIP" and not found:
        lines = text.strip().splitlines()
        found = [lines[-1] if lines else "it says no reason"]
    return found


def main(logs):
    results, skipped = collections.Counter(), []
    for log in logs:
        with open(log, encoding="utf-8") as lines:
            for test in map(json.loads, lines):
                results[test["result"]] += 1
                skipped += [(test["name"], reason) for reason in reasons(test)]
    long_ones = [row for row in skipped if row[1] == LONG]
    elsewhere = [row for row in skipped if row[1].startswith(ELSEWHERE)]
    wrong = [row for row in skipped if row not in long_ones and row not in elsewhere]
    for name, reason in sorted(set(elsewhere)):
        print(f"{name}: skipped, {reason}")
    for name, reason in sorted(set(wrong)):
        print(f"{name}: skipped, though tools/packages.sh installs what a test needs: {reason}")
    passed = results["OK"] + results["EXPECTEDFAIL"]
    failed = sum(results.values()) - passed - results["SKIP"]
    print(f"{passed} passed, {failed} failed, {results['SKIP']} skipped whole; in them {len(skipped)} tests skipped: {len(long_ones)} wait for the long run, "
          f"{len(elsewhere)} need what this machine lacks, {len(wrong)} should have run")
    return 1 if wrong and "FURROW_TESTS_MAY_SKIP" not in os.environ else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
