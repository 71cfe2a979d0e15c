/* A part of another grid. Used for sources without a place, whose window is in local metres. */
#include "dem_internal.h"

#include <math.h>

struct crop {
	struct dem_grid grid;
	struct dem_grid *whole;
	int64_t x0, y0; /* of the first post, in the whole */
};

static enum status crop_read(struct dem_grid *grid, struct post_rect rect, double *heights)
{
	struct crop *crop = (struct crop *)grid;
	int64_t x = crop->x0, y = crop->y0;
	return crop->whole->read(crop->whole, (struct post_rect){rect.x0 + x, rect.y0 + y, rect.x1 + x, rect.y1 + y}, heights);
}

static void crop_destroy(struct dem_grid *grid)
{
	struct crop *crop = (struct crop *)grid;
	dem_grid_destroy(crop->whole);
	mem_free(crop);
}

/* The first post at or after `low`, and the number of posts from there to `high`. Metres from the first of `count` posts. */
static int64_t posts_within(double low, double high, double spacing, int64_t count, int64_t *first)
{
	double from = fmax(0, ceil(low / spacing - 1e-6)), to = fmin((double)count - 1, floor(high / spacing + 1e-6));
	*first = to >= from ? (int64_t)from : 0;
	return to >= from ? (int64_t)(to - from) + 1 : 0;
}

enum status dem_crop_create(const struct dem_params *params, struct dem_grid *grid, struct dem_grid **out)
{
	const double *window = params->window;
	struct crop *crop = mem_calloc(1, sizeof *crop);
	if (crop == NULL) {
		dem_grid_destroy(grid);
		return fail_memory("the window");
	}
	/* The result has the whole's properties. It takes over the whole's texts and frees them. */
	crop->grid = *grid;
	crop->grid.read = crop_read;
	crop->grid.destroy = crop_destroy;
	crop->grid.misfit = NULL; /* of a source without a place posts are never resampled */
	grid->srs = grid->vertical = grid->projected = NULL;
	grid->files = (struct dem_list){0};
	crop->whole = grid;
	double s = grid->spacing;
	crop->grid.width = posts_within(window[0] - grid->origin[0], window[2] - grid->origin[0], s, grid->width, &crop->x0);
	crop->grid.height = posts_within(window[1] - grid->origin[1], window[3] - grid->origin[1], s, grid->height, &crop->y0);
	crop->grid.origin[0] += (double)crop->x0 * s;
	crop->grid.origin[1] += (double)crop->y0 * s;
	enum status status;
	if (params->window_srs != NULL)
		TRY_OR(failed, fail_with(STATUS_INPUT, "window SRS \"%.80s\": the source has no place on a planet; give the window in metres "
					 "from its south-west post", params->window_srs));
	if (crop->grid.width < 2 || crop->grid.height < 2)
		TRY_OR(failed, fail_with(STATUS_INPUT, "window %.10g,%.10g,%.10g,%.10g: holds %lld x %lld posts of the source, which go from "
					 "0,0 to %.10g,%.10g; give another window", window[0], window[1], window[2], window[3],
					 (long long)crop->grid.width, (long long)crop->grid.height, (double)(grid->width - 1) * s,
					 (double)(grid->height - 1) * s));
	*out = &crop->grid;
	return STATUS_OK;
failed:
	dem_grid_destroy(&crop->grid);
	return status;
}
