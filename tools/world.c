/* furrow world: a drive for MuJoCo or Gazebo. python/furrow/world.py does it. */
#include "python.h"

extern const struct command command_world;

static const char *const formats[] = {"mjcf", "sdf", NULL};
static const struct command_option options[] = {
	{"o", "FOLDER", .help = "a folder that is not there yet", .files = "/", .needed = true},
	{"format", "FORMAT", .help = "of MuJoCo, or of Gazebo", .choices = formats, .preset = "mjcf"},
	{"window", "X0,Y0,X1,Y1", .help = "of the ground: west, south, east, north", .unit = "m", .preset = "what moved, and 10 m around"},
	{"no-vehicles", .help = "the ground alone"},
	{.name = NULL},
};

static enum status run(const struct arguments *arguments)
{
	return python_command(&command_world, arguments);
}

const struct command command_world = {
	.name = "world",
	.summary = "write a drive as a world for MuJoCo or Gazebo",
	.arguments = COMMAND_ARGUMENTS({"DIR", .help = "what furrow drive -o wrote", .files = "/", .needed = true}),
	.options = options,
	.details = "The world has the ground at the end of the drive, with its ruts, and the vehicles where they were then. mjcf: world.xml with a height field. "
		   "sdf: world.sdf with a heightmap of 2^n + 1 posts.\n\n"
		   "Vehicles need the Python package mujoco.\n",
	.examples = "  furrow drive scene.yaml -o out\n"
		    "  furrow world out -o site\n"
		    "  furrow world out -o gazebo --format sdf\n",
	.see = "furrow-export(1), furrow-usd(1)",
	.run = run,
};
