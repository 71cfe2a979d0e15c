"""A run of a fuzz target with the same seed makes the same inputs, in any process and at any time: a finding can be found again."""
import os
import re
import subprocess
import sys
import tempfile

RUNS = "150"


def run(program, folder):
    result = subprocess.run([program, "--runs", RUNS, "--seed", "5", "--keep", folder], cwd=folder, capture_output=True, text=True, check=True,
                            env={key: value for key, value in os.environ.items() if not key.startswith("FUZZ_")})
    return re.findall(r"corpus \d+, places \d+", result.stdout), sorted(os.listdir(folder))


def main():
    for program in map(os.path.abspath, sys.argv[1:]):
        with tempfile.TemporaryDirectory() as one, tempfile.TemporaryDirectory() as two:
            first, second = run(program, one), run(program, two)
            if not first[0] or first != second:
                sys.exit(f"{program}: two runs with one seed differ: {first[0]} and {second[0]}")


if __name__ == "__main__":
    main()
