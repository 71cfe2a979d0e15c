"""The tarball of `meson dist` builds and passes a quick test; as Debian packages where this machine has their tools. These have no error for lintian,
and are installed into a clean Debian, where the command, its manual pages and the Python package work."""
import json
import os
import pathlib
import shutil
import subprocess
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(os.environ["FURROW_BUILD"])
# Always the same folder, so that a compiler's cache knows its files.
FOLDER = BUILD / "package"
PACKAGES = ["furrow", "libfurrow-dev", "libfurrow0", "python3-furrow"]

# What is done in the clean Debian.
CHECKS = """set -eu
apt-get install -y -qq --no-install-recommends /packages/*.deb man-db bash-completion >/dev/null 2>&1
mkdir -p /work && cd /work
furrow --version
furrow synth -o plain.furrow --kind plain --posts 65x65 --spacing 1 >/dev/null
furrow verify plain.furrow
python3 -c 'import furrow; print("python", furrow.version())'
man furrow drive | col -bx | grep -c -e --keep-history
man 5 scene | col -bx | grep -c soil.cohesion
man 3 furrow | col -bx | grep -c furrow_world_open
bash -c '. /usr/share/bash-completion/bash_completion; _completion_loader furrow; complete -p furrow'
apt-get purge -y -qq furrow python3-furrow libfurrow0 libfurrow-dev >/dev/null 2>&1
find / -xdev -name '*furrow*' -not -path '/packages/*' -not -path '/work/*' -not -path '/var/cache/man/*' -not -path '/proc/*'
echo done
"""


def run(*command, env=None, cwd=None, timeout=2000):
    return subprocess.run([*map(str, command)], capture_output=True, text=True, env=env, cwd=cwd, timeout=timeout)


def missing():
    """Why no Debian packages can be built here, or ""."""
    for tool in ("dpkg-buildpackage", "dpkg-checkbuilddeps", "dh", "dh_python3"):
        if shutil.which(tool) is None:
            return f"there is no {tool}"
    met = run("dpkg-checkbuilddeps", ROOT / "debian" / "control", cwd=ROOT)
    return met.stderr.strip() if met.returncode != 0 else ""


class PackageTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        if not (ROOT / ".git").exists():
            raise unittest.SkipTest("not on this machine: meson dist packs commits, and this is no git repository")
        shutil.rmtree(FOLDER, ignore_errors=True)
        FOLDER.mkdir()
        cls.missing = missing()
        cls.version = next(iter(json.loads(run("meson", "introspect", "--projectinfo", BUILD).stdout)[key] for key in ["version"]))
        if not cls.missing:
            cls.built = run("sh", ROOT / "tools" / "debian.sh", FOLDER, BUILD,
                            env=dict(os.environ, DEB_BUILD_OPTIONS=f"noopt noddebs parallel={os.cpu_count()}", LC_ALL="C.UTF-8"))

    def plain(self):
        """Without Debian's tools: the tarball by itself."""
        self.assertEqual(run("meson", "dist", "-C", BUILD, "--no-tests", "--allow-dirty", "--formats", "gztar").returncode, 0)
        run("tar", "-xzf", BUILD / "meson-dist" / f"furrow-{self.version}.tar.gz", "-C", FOLDER)
        source = FOLDER / f"furrow-{self.version}"
        for command in (["meson", "setup", "build", "-Dtests=false", "-Doptimization=0"], ["meson", "compile", "-C", "build"],
                        ["env", f"FURROW={source}/build/tools/furrow", sys.executable, "tests/cli/help.py"]):
            result = run(*command, cwd=source)
            self.assertEqual(result.returncode, 0, result.stdout[-3000:] + result.stderr[-3000:])

    def test_the_tarball_builds_and_passes_a_quick_test(self):
        if self.missing:
            self.plain()
            return
        self.assertEqual(self.built.returncode, 0, self.built.stdout[-3000:] + self.built.stderr[-3000:])
        self.assertEqual(sorted(path.name for path in FOLDER.glob("*.deb")),
                         [f"{name}_{self.version}_{run('dpkg', '--print-architecture').stdout.strip()}.deb" for name in PACKAGES])

    def test_lintian_finds_no_error(self):
        if self.missing or shutil.which("lintian") is None:
            self.skipTest(self.missing or "there is no lintian")
        result = run("lintian", "--allow-root", "--fail-on", "error,warning", *FOLDER.glob("*.changes"))
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)

    def test_a_clean_debian_takes_them(self):
        if self.missing or shutil.which("mmdebstrap") is None:
            self.skipTest(self.missing or "there is no mmdebstrap")
        (FOLDER / "checks.sh").write_text(CHECKS)
        begun = FOLDER / "begun"
        release = dict(line.split("=", 1) for line in pathlib.Path("/etc/os-release").read_text().splitlines() if "=" in line)
        result = run("mmdebstrap", "--variant=apt", "--format=null", f"--customize-hook=touch {begun}",
                     "--customize-hook=mkdir $1/packages", "--customize-hook=copy-in " + " ".join(map(str, FOLDER.glob("*.deb"))) + " /packages",
                     f"--customize-hook=copy-in {FOLDER}/checks.sh /", '--customize-hook=chroot "$1" sh /checks.sh > ' + f"{FOLDER}/told",
                     release["VERSION_CODENAME"].strip('"'), "/dev/null")
        if not begun.exists():
            self.skipTest("not on this machine: no clean Debian can be made here: " + (result.stderr.strip().splitlines() or ["mmdebstrap says nothing"])[-1])
        told = (FOLDER / "told").read_text().splitlines()
        self.assertEqual(result.returncode, 0, "\n".join(told) + result.stderr[-3000:])
        self.assertEqual(told[0], f"furrow {self.version}")
        self.assertIn(f"python {self.version}", told)
        self.assertIn("complete -F _furrow furrow", told)
        counts = [int(line) for line in told if line.isdigit()]
        self.assertEqual(len(counts), 3)
        self.assertTrue(all(count > 0 for count in counts))
        # Nothing stays behind.
        self.assertEqual(told[told.index("complete -F _furrow furrow") + 1:], ["done"])


if __name__ == "__main__":
    unittest.main()
