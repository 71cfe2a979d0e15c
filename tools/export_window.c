/* The window of an export or a map: metres from the south-west post, or coordinates of a reference system. */
#include <math.h>
#include <string.h>

#include "dem/dem.h"
#include "export.h"

#define EDGE 8 /* parts of an edge whose ends are converted: edges may become curves */

enum status export_read_window(const struct arguments *arguments, struct export_request *request)
{
	enum status status = arguments_numbers(arguments, "window", 4, request->window, &request->has_window);
	request->window_srs = arguments_text(arguments, "window-srs");
	if (status == STATUS_OK && request->window_srs != NULL && !request->has_window)
		return fail_with(STATUS_USAGE, "%s: --window-srs %.80s: there is no window; give --window, or leave it out", request->command,
				 request->window_srs);
	return status;
}

enum status export_place_window(struct export_request *request, const struct store_meta *meta)
{
	const double given[4] = {request->window[0], request->window[1], request->window[2], request->window[3]};
	double window[4] = {INFINITY, INFINITY, -INFINITY, -INFINITY};
	if (request->window_srs == NULL)
		return STATUS_OK;
	if (given[0] > given[2] || given[1] > given[3])
		return STATUS_OK; /* refused where the window is used */
	if (strcmp(request->window_srs, "store") != 0 && meta->srs[0] == '\0')
		return fail_with(STATUS_INPUT, "%s: --window-srs: the store has no reference system; leave it out and give metres from its south-west post",
				 request->command);
	for (int i = 0; i <= EDGE; i++)
		for (int k = 0; k <= EDGE; k++) {
			double x = given[0] + (given[2] - given[0]) * i / EDGE, y = given[1] + (given[3] - given[1]) * k / EDGE;
			enum status status = strcmp(request->window_srs, "store") != 0 ? dem_transform(request->window_srs, meta->srs, 1, &x, &y) : STATUS_OK;
			if (status != STATUS_OK)
				return status;
			window[0] = fmin(window[0], x - meta->origin[0]);
			window[1] = fmin(window[1], y - meta->origin[1]);
			window[2] = fmax(window[2], x - meta->origin[0]);
			window[3] = fmax(window[3], y - meta->origin[1]);
		}
	memcpy(request->window, window, sizeof window);
	return STATUS_OK;
}
