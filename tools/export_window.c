/* The window of an export or a map: metres from the south-west post, or coordinates of a reference system. */
#include <math.h>
#include <string.h>

#include "export.h"
#include "place.h"

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
	for (int i = 0; i <= EDGE; i++)
		for (int k = 0; k <= EDGE; k++) {
			double x = given[0] + (given[2] - given[0]) * i / EDGE, y = given[1] + (given[3] - given[1]) * k / EDGE;
			enum status status = place_local(meta, request->window_srs, request->command, "--window-srs", &x, &y);
			if (status != STATUS_OK)
				return status;
			window[0] = fmin(window[0], x);
			window[1] = fmin(window[1], y);
			window[2] = fmax(window[2], x);
			window[3] = fmax(window[3], y);
		}
	memcpy(request->window, window, sizeof window);
	return STATUS_OK;
}
