/* The window of an export or a map: metres from the south-west post, or coordinates of a reference system. */
#include <math.h>
#include <string.h>

#include "export.h"
#include "place.h"
#include "ruts.h"

#define LARGE_GIGABYTES 0.5 /* of a raster; of a larger one only what changed is written, unless a window is given */
#define EDGE 8 /* parts of an edge whose ends are converted: edges may become curves; 9 x 9 points are PLACE_POINTS */

enum status export_read_window(const struct arguments *arguments, struct export_request *request)
{
	TRY(arguments_numbers(arguments, "window", 4, request->window, &request->has_window));
	request->window_srs = arguments_text(arguments, "window-srs");
	if (request->window_srs != NULL && !request->has_window)
		return fail_with(STATUS_USAGE, "%s: --window-srs %.80s: there is no window; give --window, or leave it out", request->command,
				 request->window_srs);
	return STATUS_OK;
}

enum status export_place_window(struct export_request *request, const struct store_meta *meta)
{
	const double given[4] = {request->window[0], request->window[1], request->window[2], request->window[3]};
	double window[4] = {INFINITY, INFINITY, -INFINITY, -INFINITY};
	double given_x[PLACE_POINTS], given_y[PLACE_POINTS];
	char hint[240];
	size_t points = 0;
	if (!request->has_window || given[0] > given[2] || given[1] > given[3])
		return STATUS_OK; /* swapped corners are refused where the window is used */
	for (int i = 0; i <= EDGE; i++)
		for (int k = 0; k <= EDGE; k++) {
			double x = given[0] + (given[2] - given[0]) * i / EDGE, y = given[1] + (given[3] - given[1]) * k / EDGE;
			given_x[points] = x;
			given_y[points++] = y;
			TRY(place_local(meta, request->window_srs, request->command, "--window-srs", &x, &y));
			window[0] = fmin(window[0], x);
			window[1] = fmin(window[1], y);
			window[2] = fmax(window[2], x);
			window[3] = fmax(window[3], y);
		}
	if (request->window_srs != NULL)
		memcpy(request->window, window, sizeof window);
	const struct extent *extent = &meta->extent;
	const bool meets = window[0] <= (double)(extent->width - 1) * extent->spacing && window[1] <= (double)(extent->height - 1) * extent->spacing &&
			   window[2] >= 0 && window[3] >= 0;
	if (!meets && place_guess(meta, request->window_srs, "--window-srs", points, given_x, given_y, hint, sizeof hint))
		return fail_with(STATUS_INPUT, "%s: --window %.10g,%.10g,%.10g,%.10g: is outside the terrain, but %s", request->command, given[0], given[1],
				 given[2], given[3], hint);
	return STATUS_OK;
}

bool export_is_ruts(const struct export_request *request)
{
	return request->layer >= LAYER_OFFSET && request->layer != LAYER_HILLSHADE && request->layer != LAYER_IMAGERY;
}

/* Most of a whole terrain is 0, ruts are specks on its map, and at their spacing its raster may have gigabytes. */
enum status export_take_changed(struct export_request *request, struct store *store)
{
	const struct extent *extent = &store_meta(store)->extent;
	const int level = (int)request->level;
	const double gigabytes = 4e-9 * (double)extent_posts(extent->width, level) * (double)extent_posts(extent->height, level);
	const double ends[2] = {extent_side(extent, 0), extent_side(extent, 1)};
	double *window = request->window;
	char size[64] = "";
	bool any;
	if (!export_is_ruts(request) || request->has_window || (!request->map && gigabytes < LARGE_GIGABYTES))
		return STATUS_OK;
	TRY(ruts_window(store, window, &any));
	if (!any || (window[0] <= 0 && window[1] <= 0 && window[2] >= ends[0] && window[3] >= ends[1]))
		return STATUS_OK;
	request->has_window = true;
	if (!request->map)
		snprintf(size, sizeof size, " has %.1f GB at this spacing", gigabytes);
	note("%s: only what changed is %s, --window %s; the whole terrain%s: give --window %s for it", request->path,
	     request->map ? "drawn" : "written", number_window(window[0], window[1], window[2], window[3]).text, size,
	     number_window(0, 0, ends[0], ends[1]).text);
	return STATUS_OK;
}
