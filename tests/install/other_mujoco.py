"""A host that is linked to another MuJoCo: Furrow moves its vehicles by its own, and the host's is not touched."""
import os
import pathlib
import re
import subprocess
import unittest

import prefix

FOLDER = os.environ.get("MUJOCO")

# A MuJoCo of another version: every name that the real one has, and each function ends the process.
OTHER = """#include <stdio.h>
#include <stdlib.h>
int mj_version(void) { return 3017000; }
const char *mj_versionString(void) { return "3.17.0"; }
"""
ENDS = "void %s(void) { fputs(\"the host's %s was called\\n\", stderr); abort(); }\n"

HOST = """#include <furrow.h>
#include <stdio.h>
extern int mj_version(void);
extern void mj_step(void);
void (*volatile theirs)(void) = mj_step;
static int failed(void)
{
	fprintf(stderr, "%s\\n", furrow_last_error());
	return 1;
}
int main(int count, char **words)
{
	struct furrow_open options = {.size = sizeof options};
	struct furrow_vehicle_state at = {.size = sizeof at};
	struct furrow_world *world;
	(void)count;
	options.scene_file = words[1];
	options.store = words[2];
	options.overlay = words[3];
	if (theirs == NULL || furrow_world_open(&options, &world) != FURROW_OK)
		return failed();
	if (furrow_step(world, 0.2) != FURROW_OK || furrow_vehicle_get(world, 0, &at) != FURROW_OK)
		return failed();
	printf("%d %.17g %.17g\\n", mj_version(), at.state.pose.position[2], at.distance);
	return furrow_world_close(world) == FURROW_OK ? 0 : failed();
}
"""

SCENE = f"""scene: 1
time_step: 0.002
end_time: 1
spacing: 0.125
soil: {{name: dry_sand}}
redistribute: {{model: scm}}
vehicles:
  - name: car
    model: {prefix.ROOT}/tools/scenes/vehicles/offroad.xml
    start: {{at: [20, 20]}}
    soil: [wheel_*]
"""


@unittest.skipUnless(FOLDER, "this build has no MuJoCo")
class OtherMujocoTest(unittest.TestCase):
    def host(self, name, libraries):
        (prefix.work / f"{name}.c").write_text(HOST)
        prefix.run("cc", *prefix.compile_flags, f"{name}.c", "-o", name, "-Wl,--no-as-needed", *libraries, *prefix.package_config("--cflags", "--libs"),
                   f"-Wl,-rpath,{prefix.work}")
        scene = prefix.work / "car.yaml"
        scene.write_text(SCENE)
        result = prefix.run(prefix.work / name, scene, prefix.synthesize("plain.furrow", "plain"), f"{name}.furrow", env=prefix.environment, check=False)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        return result.stdout.split()

    @unittest.skipIf("address" in prefix.SANITIZE, "a sanitizer lets no library keep its names to itself")
    def test_a_host_with_another_version_goes_on_with_its_own(self):
        library = next(pathlib.Path(FOLDER).rglob("libmujoco.so.4.*"))
        names = re.findall(r" T (mj[a-z]*_\w+)", subprocess.run(["nm", "-D", library], capture_output=True, text=True, check=True).stdout)
        self.assertGreater(len(names), 300)
        (prefix.work / "other.c").write_text(OTHER + "".join(ENDS % (name, name) for name in names if name not in ("mj_version", "mj_versionString")))
        (prefix.work / "other.map").write_text("Base { *; };\n") # its names have the real one's version
        prefix.run("cc", "-w", "-fno-builtin", "-shared", "-fPIC", "other.c", "-o", "libmujoco.so.3.17.0", "-Wl,-soname,libmujoco.so.3.17.0", "-Wl,--version-script=other.map")
        version, height, distance = self.host("with_other", [prefix.work / "libmujoco.so.3.17.0"])
        self.assertEqual(version, "3017000")
        self.assertEqual([height, distance], self.host("with_same", [library, f"-Wl,-rpath,{library.parent}"])[1:])

    def test_a_library_of_another_version_is_refused_with_both_versions(self):
        (prefix.work / "old.c").write_text(OTHER)
        prefix.run("cc", "-w", "-shared", "-fPIC", "old.c", "-o", "libold.so")
        scene = prefix.work / "old.yaml"
        scene.write_text(SCENE)
        result = prefix.run("furrow", "explain", scene, env=dict(prefix.environment, FURROW_MUJOCO=str(prefix.work / "libold.so")), check=False)
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertRegex(result.stderr, r"is MuJoCo 3\.17\.0, and furrow was built for 4\.\d+\.\d+")
        result = prefix.run("furrow", "explain", scene, env=dict(prefix.environment, FURROW_MUJOCO="/nonexistent/libmujoco.so"), check=False)
        self.assertRegex(result.stderr, "MuJoCo 4.* cannot be loaded: /nonexistent/libmujoco.so: .*install it")

    def test_nothing_is_linked_to_mujoco(self):
        for file in (prefix.prefix / "bin" / "furrow", next(prefix.libdir.glob("libfurrow.so.0"))):
            self.assertNotIn("mujoco", subprocess.run(["ldd", file], capture_output=True, text=True, check=True).stdout)
        self.assertTrue(list((prefix.libdir / "furrow").glob("libmujoco.so.4.*")))


if __name__ == "__main__":
    unittest.main()
