/* furrow bag: a drive for ROS 2's tools. python/furrow/bag.py does it. */
#include "python.h"

extern const struct command command_bag;

static const struct command_option options[] = {
	{"o", "FILE.mcap", .help = "the bag", .files = "mcap", .needed = true},
	{"points", .help = "of cameras with depth also clouds of points"},
	{.name = NULL},
};

static enum status run(const struct arguments *arguments)
{
	return python_command(&command_bag, arguments);
}

const struct command command_bag = {
	.name = "bag",
	.summary = "write a drive as a bag for ROS 2",
	.arguments = COMMAND_ARGUMENTS({"DIR", .help = "what furrow drive -o wrote", .files = "/", .needed = true}),
	.options = options,
	.details = "The bag (mcap) has the clock, tf, odometry, joint states, IMUs and ranges of each vehicle, the soil's force on each body of objects.csv, points of lidars, and of each camera "
		   "its pictures as they are and its camera info. Times are simulated, from 0. The frame `map` is the store's: x east, y north, z up, in "
		   "metres from its south-west post.\n\n"
		   "It needs the Python packages mcap and mcap-ros2-support (pip install 'furrow[ros]', or both by name).\n",
	.examples = "  furrow drive scene.yaml -o out\n"
		    "  furrow bag out -o run.mcap\n",
	.see = "furrow-dataset(1), furrow-drive(1)",
	.run = run,
};
