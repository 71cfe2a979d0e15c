/* The rows of objects, their shapes and their paths. What a row says, and how a key is added: scene_row.h and scene_schema.h. */
#include "scene/scene.h"
#include "scene/scene_schema.h"

static const struct scene_row wheel_tyre_rows[] = {
	{NEEDED_NUMBER("stiffness", struct raw_tyre, stiffness), ABOVE(0, 1e12), .unit = "N/m", .since = "0.2.0",
	 .text = "radial, on rigid ground at `load`: chord and tangent"},
	{NUMBER("load", struct raw_tyre, load), ABOVE(0, 1e12), .unit = "N", .otherwise = "the object's load", .since = "0.2.0",
	 .text = "at which it is as stiff as that"},
	{NUMBER("pressure", struct raw_tyre, pressure), RANGE(0, 1e9), .unit = "Pa", .otherwise = "half of the mean on rigid ground", .since = "0.2.0",
	 .text = "up to which it keeps its shape: inflation and carcass. At most 0.9 of the mean on rigid ground"},
	{.key = NULL},
};
static const struct scene_row wheel_rows[] = {
	{NEEDED_NUMBER("radius", struct raw_wheel, radius), RANGE(0.001, 1000), .why = "is out of range, and the unit is m, not mm", .unit = "m", .since = "0.1.0",
	 .text = "without its grousers"},
	{NEEDED_NUMBER("width", struct raw_wheel, width), RANGE(0.001, 1000), .unit = "m", .since = "0.1.0",
	 .text = "along its axis"},
	{WHOLE("grousers", struct raw_wheel, grousers), RANGE(0, 128), DEFAULT(0), .since = "0.1.0",
	 .text = "grousers (bars across the rim), evenly spaced; they turn as the wheel rolls; 0: smooth"},
	{NUMBER("grouser_height", struct raw_wheel, grouser_height), ABOVE(0, 1000), .unit = "m", .otherwise = "0.05 of the radius", .since = "0.1.0",
	 .text = "beyond the radius, and no more than it; only with grousers"},
	{NUMBER("grouser_thickness", struct raw_wheel, grouser_thickness), ABOVE(0, 1000), .unit = "m", .otherwise = "0.1 of the radius", .since = "0.1.0",
	 .text = "along the rim; only with grousers"},
	{MAPPING("tyre", struct raw_wheel, tyre, struct raw_tyre, wheel_tyre_rows), .otherwise = "none: the wheel is rigid", .since = "0.2.0",
	 .text = "scm alone: [a tyre](../vehicle/VEHICLES.md#tyres), which flattens where the ground is harder than it. A host's body has a twentieth of the critical damping"},
	{.key = NULL},
};
static const struct scene_row sphere_rows[] = {
	{NEEDED_NUMBER("radius", struct raw_sphere, radius), RANGE(0.001, 1000), .unit = "m", .since = "0.1.0"},
	{.key = NULL},
};
static const struct scene_row box_rows[] = {
	{NEEDED_NUMBERS("size", struct raw_box, size, 3), RANGE(0.001, 1000), .unit = "m", .since = "0.1.0",
	 .text = "length (forward), breadth, height"},
	{SWITCH("belt", struct raw_box, belt), .otherwise = "false", .since = "0.2.0",
	 .text = "[a belt](#belts) runs over it"},
	{.key = NULL},
};
static const struct scene_row mesh_rows[] = {
	{NEEDED_TEXT("file", struct raw_mesh, file, 4096), .since = "0.1.0",
	 .text = "OBJ, STL, DAE, glTF: at most 64 MiB, 1,000,000 triangles and 20,000 groups; OBJ, STL and DAE have x forward, y left, z up"},
	{NUMBER("scale", struct raw_mesh, scale), ABOVE(0, 1000), DEFAULT(1), .since = "0.1.0",
	 .text = "metres a unit of the file; the longest side is then 1 mm to 1000 m"},
	{SWITCH("belt", struct raw_mesh, belt), .otherwise = "false", .since = "0.2.0",
	 .text = "[a belt](#belts) runs over it"},
	{.key = NULL},
};
static const struct scene_row cylinder_rows[] = {
	{NEEDED_NUMBER("radius", struct raw_rod, radius), RANGE(0.001, 1000), .unit = "m", .since = "0.2.0"},
	{NEEDED_NUMBER("length", struct raw_rod, length), RANGE(0.001, 1000), .unit = "m", .since = "0.2.0",
	 .text = "along its axis, whole"},
	{.key = NULL},
};
static const struct scene_row capsule_rows[] = {
	{NEEDED_NUMBER("radius", struct raw_rod, radius), RANGE(0.001, 1000), .unit = "m", .since = "0.2.0",
	 .text = "of the cylinder and the balls"},
	{NEEDED_NUMBER("length", struct raw_rod, length), RANGE(0, 1000), .unit = "m", .since = "0.2.0",
	 .text = "of the cylinder alone, without the balls; 0: a ball"},
	{.key = NULL},
};
static const struct scene_row ellipsoid_rows[] = {
	{NEEDED_NUMBERS("radii", struct raw_ellipsoid, radii, 3), RANGE(0.001, 1000), .unit = "m", .since = "0.2.0",
	 .text = "half axes forward, to the left, up; none more than 1000 times another"},
	{.key = NULL},
};
static const struct scene_row shape_rows[] = {
	{MAPPING("wheel", struct raw_shape, wheel, struct raw_wheel, wheel_rows), .needs = "needed, or another shape", .since = "0.1.0",
	 .text = "rolls along its path; its axis is level, but for the roll of its poses (camber)"},
	{MAPPING("sphere", struct raw_shape, sphere, struct raw_sphere, sphere_rows), .needs = "needed, or another shape", .since = "0.1.0",
	 .text = "a sphere"},
	{MAPPING("box", struct raw_shape, box, struct raw_box, box_rows), .needs = "needed, or another shape", .since = "0.1.0",
	 .text = "a box"},
	{MAPPING("mesh", struct raw_shape, mesh, struct raw_mesh, mesh_rows), .needs = "needed, or another shape", .since = "0.1.0",
	 .text = "triangles from a file"},
	{MAPPING("cylinder", struct raw_shape, cylinder, struct raw_rod, cylinder_rows), .needs = "needed, or another shape", .since = "0.2.0",
	 .text = "a cylinder about its own z: upright at attitude 0, lying at roll 90"},
	{MAPPING("capsule", struct raw_shape, capsule, struct raw_rod, capsule_rows), .needs = "needed, or another shape", .since = "0.2.0",
	 .text = "a cylinder about its own z with half a ball on each end"},
	{MAPPING("ellipsoid", struct raw_shape, ellipsoid, struct raw_ellipsoid, ellipsoid_rows), .needs = "needed, or another shape", .since = "0.2.0",
	 .text = "an ellipsoid"},
	{.key = NULL},
};
static const struct scene_row path_rows[] = {
	{PAIRS("points", struct raw_path, points, 1, ENDLESS), RANGE(-1e9, 1e9), .unit = "m", .needs = "needed, or file or relative_to", .since = "0.1.0",
	 .text = "x, y of the corners of its way; one: it stands there"},
	{NUMBER("speed", struct raw_path, speed), ABOVE(0, 10000), .unit = "m/s", .needs = "needed with points", .since = "0.1.0",
	 .text = "along the way, always the same; of a line in a file: instead of its times"},
	{SWITCH("loop", struct raw_path, loop), .otherwise = "false", .since = "0.1.0",
	 .text = "from the last point back to the first, for ever; with points or a line"},
	{TEXT("file", struct raw_path, file, 4096), .needs = "needed, or points", .since = "0.1.0",
	 .text = "[poses in time](#path-files), or a [line of GPX or GeoJSON](#lines-on-the-globe); at most 256 MiB"},
	{WHOLE("line", struct raw_path, line), RANGE(1, 1e6), .otherwise = "the only line", .since = "0.2.0",
	 .text = "which line of a GPX or GeoJSON file"},
	{SWITCH("smooth", struct raw_path, smooth), .otherwise = "false", .since = "0.2.0",
	 .text = "a [curve through the points](#curves), not straight lines"},
	{NUMBER("rotate", struct raw_path, rotate), RANGE(-36000, 36000), .unit = "degrees", DEFAULT(0), .since = "0.2.0",
	 .text = "turns the whole path, and the yaws of a file, about its first point, from east to north"},
	{NUMBERS("offset", struct raw_path, offset, 2, 2), RANGE(-1e9, 1e9), .unit = "m", .otherwise = "0, 0", .since = "0.2.0",
	 .text = "then moves it, east and north, in metres whatever `coordinates` are; with relative_to: metres ahead of the other object, and left of it"},
	{TEXT("relative_to", struct raw_path, relative_to, 64), .needs = "needed, or points or file", .since = "0.2.0",
	 .text = "the name of an object [whose path this one follows](#followers)"},
	{NUMBER("delay", struct raw_path, delay), RANGE(0, 1e9), .unit = "s", DEFAULT(0), .since = "0.2.0",
	 .text = "the whole path is so much later; until then it touches nothing"},
	{.key = NULL},
};
static const struct scene_row interface_rows[] = {
	{NUMBER("friction_angle", struct raw_interface, friction_angle), RANGE(0, 89), .unit = "degrees", .otherwise = "the soil's", .since = "0.2.0",
	 .text = "of soil that slides along the surface; counts where the surface is weaker than the soil"},
	{NUMBER("adhesion", struct raw_interface, adhesion), RANGE(0, 1e9), .unit = "Pa", .otherwise = "by the soil's cohesion", .since = "0.2.0",
	 .text = "the same: what holds soil on the surface beside friction, where it is pressed on: [how well soil sticks](../deform/SOIL.md#how-well-soil-sticks)"},
	{.key = NULL},
};
const struct scene_row scene_object_rows[] = {
	{TEXT("name", struct raw_object, name, 64), .command = true, .since = "0.1.0",
	 .text = "unique; A-Z a-z 0-9 _ -"},
	{NEEDED_MAPPING("shape", struct raw_object, shape, struct raw_shape, shape_rows), .since = "0.1.0",
	 .text = "exactly one of the seven that follow"},
	{MAPPING("path", struct raw_object, path, struct raw_path, path_rows), .command = true, .since = "0.1.0",
	 .text = "where it goes: points with a speed, a file, or the path of another object"},
	{NUMBER("sink", struct raw_object, sink), RANGE(0, 1000), .unit = "m", DEFAULT(0), .since = "0.1.0",
	 .text = "how deep its lowest point is below the undisturbed ground under its centre; a rut is pressed no deeper by driving it again"},
	{NUMBER("load", struct raw_object, load), ABOVE(0, 1e9), .unit = "N", .otherwise = "none: sink", .since = "0.1.0",
	 .text = "instead of sink: it sinks until the soil, or an elastic sheet, carries this; scm and sheet, and no z in its path"},
	{NUMBER("slip", struct raw_object, slip), RANGE(-1000, 0.99), .why = "is out of range, since slip is a share (0.2 for 20 %)", DEFAULT(0), .since = "0.1.0",
	 .text = "of a wheel, with scm or vegetation: 1 - way / (radius x angle turned); below 0 it is dragged, at -1000 as good as locked; of a belt: 1 - way / what the belt ran"},
	{SWITCH("carry", struct raw_object, carry), .otherwise = "false", .since = "0.2.0",
	 .text = "scm alone, of a box or a mesh: [soil that comes onto it stays on it](../deform/SOIL.md#soil-aboard-a-body), and weighs on it"},
	{NUMBERS("attitude", struct raw_object, attitude, 3, 3), RANGE(-360, 360), .unit = "degrees", .otherwise = "0, 0, 0", .since = "0.2.0",
	 .text = "yaw, pitch and roll [against its way](#turned-against-its-way), where its path gives none"},
	{MAPPING("interface", struct raw_object, interface, struct raw_interface, interface_rows), .otherwise = "none: the soil's own strength", .since = "0.2.0",
	 .text = "scm alone: [friction and adhesion](../deform/SOIL.md#the-objects-surface) between the object's surface and the soil"},
	{.key = NULL},
};
