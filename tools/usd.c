/* furrow usd: a drive for viewers of USD. python/furrow/usd.py does it. */
#include "python.h"

extern const struct command command_usd;

static const struct command_option options[] = {
	{"o", "FILE", .help = "the stage", .files = "usdc usda usd", .needed = true},
	{"window", "X0,Y0,X1,Y1", .help = "of the ground: west, south, east, north", .unit = "m", .preset = "what moved, and 10 m around"},
	{"no-vehicles", .help = "the ground and objects alone"},
	{.name = NULL},
};

static enum status run(const struct arguments *arguments)
{
	return python_command(&command_usd, arguments);
}

const struct command command_usd = {
	.name = "usd",
	.summary = "write a drive as a USD stage",
	.arguments = COMMAND_ARGUMENTS({"DIR", .help = "what furrow drive -o wrote", .files = "/", .needed = true}),
	.options = options,
	.details = "The stage has the ground at the end of the drive as a mesh with texture coordinates, colours and a texture (NAME_ground.png beside it). Vehicles and "
		   "objects have their poses in time, from vehicles.csv and objects.csv. It is in metres, z up.\n\n"
		   "It needs the Python package usd-core; shapes of vehicles need mujoco (pip install 'furrow[usd]', or both by name).\n",
	.examples = "  furrow drive scene.yaml -o out\n"
		    "  furrow usd out -o world.usdc\n",
	.see = "furrow-export(1), furrow-world(1)",
	.run = run,
};
