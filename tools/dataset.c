/* furrow dataset: a drive as a dataset of odometry. python/furrow/dataset.py does it. */
#include "python.h"

extern const struct command command_dataset;

static const char *const formats[] = {"euroc", "tum", NULL};

static const struct command_option options[] = {
	{"o", "FOLDER", .help = "the dataset: a folder that is not there yet", .files = "/", .needed = true},
	{"format", "FORMAT", .help = "how it is laid out", .preset = "euroc", .choices = formats},
	{"camera", "NAME", .help = "tum: its camera; euroc: the only one", .preset = "tum: the first with colour and depth; euroc: all"},
	{.name = NULL},
};

static enum status run(const struct arguments *arguments)
{
	int format;
	TRY(arguments_choice(arguments, "format", &format));
	return python_command(&command_dataset, arguments);
}

const struct command command_dataset = {
	.name = "dataset",
	.summary = "write a drive as an EuRoC or TUM dataset",
	.arguments = COMMAND_ARGUMENTS({"DIR", .help = "what furrow drive -o wrote", .files = "/", .needed = true}),
	.options = options,
	.details = "euroc: mav0 with a cam0, cam1, ... for each camera on one vehicle, and the vehicle's true poses and velocities. tum: the colours, depths (1 m is 5000) and poses of one camera. Pictures are hard links where the "
		   "file system has them, else copies.\n",
	.examples = "  furrow dataset out -o sequence\n"
		    "  furrow dataset out -o rgbd --format tum --camera nav\n",
	.see = "furrow-bag(1), furrow-drive(1)",
	.run = run,
};
