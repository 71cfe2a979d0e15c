/* What a mesh covers of the cells of posts: see cover_fine.h and fine.h. */
#include "soil/law/cover_fine.h"

#include "soil/law/face.h"

#define BESIDE 2e-6f /* m: a post nearer to a side lies below it */

/* Gives the place of the raster at a post, and its cell. Returns false if the post is beside the raster. */
static bool place_of(const struct soil_fine *fine, float x, float y, int32_t place[2], int32_t cell[2])
{
	const float at[2] = {(fine->axis[0] * x - fine->axis[1] * y - fine->x) * fine->by_step, (fine->axis[1] * x + fine->axis[0] * y - fine->y) * fine->by_step};
	for (int k = 0; k < 2; k++) {
		place[k] = whole_of(clamped(at[k], -1e6f, 1e6f));
		if (place[k] < 0 || place[k] >= fine->cells[k] * fine->parts)
			return false;
		cell[k] = place[k] / fine->parts;
	}
	return true;
}

/* Gives how far ahead and behind the mesh reaches, `y` to the left of its middle. Returns false if it does not reach there. */
static bool reaches(const struct soil_fine *fine, float y, float ends[2])
{
	const float at = (y - fine->aside) * fine->by_step;
	if (!(y >= fine->sides[0] - BESIDE) || !(y <= fine->sides[1] + BESIDE) || !(at >= 0) || at >= (float)(fine->strips - 1))
		return false;
	const int32_t i = (int32_t)at;
	const float p = at - (float)i;
	if (!(fine->front[i] > -0.5f * FINE_NONE))
		return false;
	const bool both = fine->front[i + 1] > -0.5f * FINE_NONE;
	ends[0] = both ? fine->front[i] + p * (fine->front[i + 1] - fine->front[i]) : fine->front[i];
	ends[1] = both ? fine->rear[i] + p * (fine->rear[i + 1] - fine->rear[i]) : fine->rear[i];
	return true;
}

/* Sets what the motion did. */
static void put_swept(const struct soil_form *f, const int32_t cell[2], bool within, struct soil_posts *p, size_t i)
{
	const struct soil_fine *fine = &f->fine;
	const float x = p->x[i], y = p->y[i], run = f->passes[0];
	float ends[2];
	const bool hole = p->base[i] == BASE_NODATA;
	p->swept[i] = p->over[i];
	p->lowered[i] = run > 0 || !(p->over[i] > 0) ? 0 : most(f->way[2], 0);
	const bool known = run > 0 && reaches(fine, y, ends);
	p->entered[i] = known ? most(ends[0] - x, 0) / run : 1e3f;
	if (!known || !within || hole || x > ends[0] + BESIDE || x < ends[1] - run - BESIDE)
		return;
	const float low = fine->passed[cell[1] * fine->cells[0] + cell[0]];
	p->swept[i] = low < 0.5f * FINE_NONE ? 1 : p->over[i];
	p->lowered[i] = low < 0.5f * FINE_NONE ? most(p->height[i] - low, 0) : 0;
}

/* Below a wall the ground is as low as the wall, but the wall bears beside the cell that has its edge. */
static void put_wall(float wall, float hole, struct soil_posts *p, size_t i)
{
	if (!(wall < 0.5f * FINE_NONE) || !(hole > 0))
		return;
	p->height[i] = wall;
	p->over[i] = 1;
	p->share[i] = 0;
}

static void cover_post(const struct soil_form *f, struct soil_posts *p, size_t i)
{
	const struct soil_fine *fine = &f->fine;
	const float x = p->x[i], y = p->y[i], hole = p->base[i] == BASE_NODATA ? 0 : 1;
	int32_t place[2], cell[2] = {0, 0};
	struct face face;
	float slope[2];
	raster_face(f, x, y, &face);
	put_raster_slope(f, x, y, 0.5f * (float)fine->parts, slope);
	p->height[i] = face.height;
	p->slope_x[i] = slope[0];
	p->slope_y[i] = slope[1];
	p->print[i] = height_at(f, FORM_RASTER, 0, x + f->way[0], y + f->way[1]);
	p->begun[i] = p->print[i] - face.height - f->way[2];
	p->halfway[i] = height_at(f, FORM_RASTER, 0, x + 0.5f * f->way[0], y + 0.5f * f->way[1]) - face.height - 0.5f * f->way[2];
	p->own[i] = p->above[i] = p->over[i] = p->share[i] = p->middle_x[i] = p->middle_y[i] = 0;
	p->side_behind[i] = p->side_ahead[i] = p->side_right[i] = p->side_left[i] = 0;
	const bool within = place_of(fine, x, y, place, cell);
	if (within) {
		const int32_t at = cell[1] * fine->cells[0] + cell[0];
		const float east = fine->middles[0][at] * f->spacing, north = fine->middles[1][at] * f->spacing;
		p->over[i] = fine->drawn[place[1] * fine->stride + place[0]] < 0.5f * FINE_NONE ? hole : 0;
		p->share[i] = fine->areas[at] * hole;
		p->middle_x[i] = fine->axis[0] * east + fine->axis[1] * north;
		p->middle_y[i] = fine->axis[0] * north - fine->axis[1] * east;
		if (fine->earlier[0] != NULL && fine->earlier[0][at] < 0.5f * FINE_NONE && fine->earlier[1][at] < 0.5f * FINE_NONE) {
			p->halfway[i] = fine->earlier[0][at] - face.height;
			p->begun[i] = fine->earlier[1][at] - face.height;
		}
	}
	if (within && fine->walls != NULL && !(p->over[i] > 0))
		put_wall(fine->walls[place[1] * fine->stride + place[0]], hole, p, i);
	put_swept(f, cell, within, p, i);
}

void soil_cover_fine(const struct soil_form *form, struct soil_posts *posts)
{
	for (size_t i = 0; i < (posts->count + POSTS_LANES - 1) / POSTS_LANES * POSTS_LANES; i++)
		cover_post(form, posts, i);
}

float soil_cover_fine_low(const struct soil_form *form, float x, float y)
{
	const struct soil_fine *fine = &form->fine;
	int32_t place[2], cell[2];
	if (!place_of(fine, x, y, place, cell))
		return FINE_NONE;
	const int32_t at = cell[1] * fine->cells[0] + cell[0];
	if (fine->brims != NULL && fine->brims[at].length > 0) /* its edge lies between places */
		return -form->reach;
	return fine->lows[at] < 0.5f * FINE_NONE || !(fine->areas[at] > 0) ? fine->lows[at] : -form->reach;
}
