/* furrow bench: times on a store of the user's own. python/furrow/bench.py does it. */
#include "python.h"

extern const struct command command_bench;

static const struct command_option options[] = {
	{"o", "DIR", .help = "a folder for bench.json and bench.svg", .files = "/"},
	{"quick", .help = "one run of each, within a minute"},
	{"json", .help = "one JSON object: steps, frames, cache and tiles, a list of rows each"},
	{.name = NULL},
};

static enum status run(const struct arguments *arguments)
{
	return python_command(&command_bench, arguments);
}

const struct command command_bench = {
	.name = "bench",
	.summary = "time steps, pictures, the page cache and tiles on a store",
	.arguments = COMMAND_ARGUMENTS({"STORE", .help = "a terrain store, or an overlay; it is not changed", .files = "furrow", .needed = true}),
	.options = options,
	.details = "A wheel drives in the middle of the store, into a temporary overlay: by each model, with posts of 12.5 to 3.1 cm. Then with pictures of four sizes, and to and fro over many tiles. "
		   "Told are the median of three runs and their range. `cache` has what each policy would miss (as furrow cache-sim), and what this "
		   "one missed. It takes five minutes at most; what does not fit is left out and named. Give it a quiet machine.\n\n"
		   "-o needs the Python package matplotlib.\n",
	.examples = "  furrow bench site.furrow --quick\n"
		    "  furrow bench site.furrow -o bench\n",
	.see = "furrow-cache-sim(1), furrow-drive(1), furrow-explain(1)",
	.run = run,
};
