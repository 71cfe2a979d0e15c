"""What the tests of an installation share: Furrow installed into a folder of its own, and programs run against it."""
import atexit
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(os.environ["FURROW_BUILD"])
SANITIZE = os.environ.get("SANITIZE", "none")

_folder = pathlib.Path(tempfile.mkdtemp(prefix="furrow-install-"))
_folder.chmod(0o755)  # other users come through it
atexit.register(shutil.rmtree, _folder, ignore_errors=True)
work = _folder / "work"  # examples are built and run here
work.mkdir()


def where_it_waits(process):
    """What the threads of a process do, as gdb tells it."""
    if shutil.which("gdb") is None:
        return "install gdb to see where it waits"
    return subprocess.run(["gdb", "-p", str(process.pid), "-batch", "-ex", "thread apply all backtrace"], capture_output=True,
                          text=True, timeout=60).stdout


def run(*command, cwd=None, env=None, check=True, **more):
    command = [*map(str, command)]
    with subprocess.Popen(command, cwd=cwd or work, env=env, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **more) as process:
        try:
            out, err = process.communicate(timeout=600)
        except subprocess.TimeoutExpired:
            where = where_it_waits(process)
            process.kill()
            raise AssertionError(f"{' '.join(command)}: not done after 600 s\n{where}")
    result = subprocess.CompletedProcess(command, process.returncode, out, err)
    if check and result.returncode != 0:
        raise AssertionError(f"{' '.join(command)}: exit {result.returncode}\n{result.stdout}\n{result.stderr}")
    return result


def install():
    """Installs what is built, by somebody whose files are his own; returns (prefix, where libraries lie below it)."""
    options = json.loads(run("meson", "introspect", "--buildoptions", BUILD).stdout)
    prefix = next(option["value"] for option in options if option["name"] == "prefix")
    libdir = next(option["value"] for option in options if option["name"] == "libdir")
    run("meson", "install", "-C", BUILD, "--no-rebuild", "--quiet", "--destdir", _folder, umask=0o077)
    return _folder / prefix.lstrip("/"), libdir


prefix, _libdir = install()
libdir = prefix / _libdir
package = next(prefix.rglob("furrow/__init__.py")).parent

environment = dict(os.environ, LD_LIBRARY_PATH=str(libdir), PYTHONPATH=str(package.parent), PYTHONDONTWRITEBYTECODE="1",
                   PKG_CONFIG_PATH=str(libdir / "pkgconfig"), PATH=f"{prefix / 'bin'}:{os.environ['PATH']}", MPLBACKEND="")
for variable in ("FURROW_LIBRARY", "DISPLAY", "WAYLAND_DISPLAY", "MPLBACKEND"):
    environment.pop(variable, None)

# A library that was built with sanitizers needs a program that has them, or one that loads them first.
compile_flags = [] if SANITIZE == "none" else [f"-fsanitize={SANITIZE}"]
loaded = {}
if "address" in SANITIZE:
    loaded = {"LD_PRELOAD": subprocess.run(["cc", "-print-file-name=libasan.so"], capture_output=True, text=True,
                                           check=True).stdout.strip(), "ASAN_OPTIONS": "detect_leaks=0"}
elif "thread" in SANITIZE:
    loaded = {"LD_PRELOAD": subprocess.run(["cc", "-print-file-name=libtsan.so"], capture_output=True, text=True,
                                           check=True).stdout.strip()}


def open_to_all(path):
    """Whether every user may come to a file."""
    path = pathlib.Path(path).resolve()
    return all(each.stat().st_mode & 0o001 for each in (path, *path.parents))


class Stranger:
    """Somebody else: always with another PATH, locale, umask and home, and another user where root runs this and a user may come to what is
    needed. `home` may be absent or not writable."""

    def __init__(self, name, locale, home="/nonexistent"):
        self.folder = _folder / name
        self.folder.mkdir()
        # As docs/INSTALL.md tells for a prefix that the system does not know.
        self.environment = {"PATH": f"{prefix / 'bin'}:/usr/bin:/bin", "LD_LIBRARY_PATH": str(libdir), "PKG_CONFIG_PATH": str(libdir / "pkgconfig"),
                            "PYTHONPATH": str(package.parent), "LANG": locale, "HOME": str(home)}
        self.user = {"umask": 0o077}
        if os.getuid() == 0 and open_to_all(_folder) and open_to_all(sys.executable):
            os.chown(self.folder, 65534, 65534)
            self.user.update(user=65534, group=65534, extra_groups=[])

    def run(self, *command, check=True, **environment):
        return run(*command, cwd=self.folder, env=dict(self.environment, **environment), check=check, **self.user)


def package_config(*options):
    return run("pkg-config", f"--define-variable=prefix={prefix}", *options, "furrow", env=environment).stdout.split()


def python_with(*modules):
    """An interpreter that has these modules, or None: the one that runs this, or the system's."""
    for program in (sys.executable, "/usr/bin/python3"):
        found = subprocess.run([program, "-c", "import " + ", ".join(modules)], capture_output=True)
        if found.returncode == 0:
            return program
    return None


def run_python(*arguments, modules=("numpy",), check=True):
    program = python_with(*modules)
    if program is None:
        raise AssertionError(f"no python3 has {', '.join(modules)}; run tools/packages.sh")
    return run(program, *arguments, env=dict(environment, **loaded), check=check)


def synthesize(name, kind):
    """A terrain of 64 m; returns its path."""
    store = work / name
    if not store.exists():
        run("furrow", "synth", "-o", store, "--kind", kind, "--posts", "257x257", "--spacing", "0.25", "--relief", "2",
            env=environment)
    return store
