/* furrow lens: what a real camera would have made of pictures. python/furrow/lens.py does it. */
#include "python.h"

extern const struct command command_lens;

static const char *const models[] = {"pinhole", "brown_conrady", "fisheye", NULL};
static const struct command_option options[] = {
	{"o", "NAME", .help = "the new camera, in DIR/cameras", .needed = true},
	{"camera", "NAME", .help = "of the drive, with colours", .needed = true},
	{"model", "MODEL", .help = "of the lens", .choices = models, .preset = "pinhole"},
	{"coefficients", "K1,K2,...", .help = "brown_conrady: k1,k2,p1,p2,k3; fisheye: k1,k2,k3,k4", .preset = "all 0"},
	{"focal", "PIXELS", .help = "focal length", .unit = "pixels", .preset = "that of the camera"},
	{"noise", "SHARE", .help = "standard deviation of noise in the dark, of full scale", .preset = "0"},
	{"electrons", "N", .help = "at full scale: shot noise; 0: none", .preset = "0"},
	{"exposure", "S", .help = "frames within so long are averaged", .unit = "s", .preset = "0: one frame"},
	{"every", "N", .help = "writes each so many", .preset = "1"},
	{"seed", "N", .help = "another number, other noise", .preset = "0"},
	{.name = NULL},
};

static enum status run(const struct arguments *arguments)
{
	return python_command(&command_lens, arguments);
}

const struct command command_lens = {
	.name = "lens",
	.summary = "give pictures of a drive a lens, an exposure time and noise",
	.arguments = COMMAND_ARGUMENTS({"DIR", .help = "what furrow drive -o wrote", .files = "/", .needed = true}),
	.options = options,
	.details = "Makes another camera of one of the drive, whose pictures are those of a pinhole without noise, of one moment. furrow bag and furrow dataset have "
		   "it, too, with its model. Light is summed as light. The same seed gives the same pictures.\n\n"
		   "For motion blur give the camera in the scene a high rate, and here --exposure and --every.\n",
	.examples = "  furrow lens out --camera nav -o nav_fisheye --model fisheye --focal 180\n"
		    "  furrow lens out --camera nav -o nav_noisy --noise 0.004 --seed 3\n",
	.see = "furrow-bag(1), furrow-dataset(1)",
	.run = run,
};
