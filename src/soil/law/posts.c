/* Gathers the posts that a body may touch: their state from the planes, and what the body covers of their cells. */
#include "soil/law/posts.h"

#include "soil/law/cover.h"
#include "soil/law/cover_fine.h"
#include "soil/shape/body.h"

enum status soil_posts_need(struct soil_posts *posts, size_t count)
{
	enum {
#define POSTS_COUNT(name) COUNT_##name,
		POSTS_WHOLES_EACH(POSTS_COUNT) POSTS_REALS_EACH(POSTS_COUNT) ARRAYS
#undef POSTS_COUNT
	};
	if (count <= posts->capacity)
		return STATUS_OK;
	const size_t capacity = (count + count / 2 + 2 * POSTS_LANES - 1) / POSTS_LANES * POSTS_LANES;
	soil_posts_finish(posts);
	char *memory = mem_alloc(ARRAYS * capacity, sizeof(float));
	if (memory == NULL)
		return fail_memory("posts under a body");
	posts->memory = memory;
#define POSTS_PLACE(name) posts->name = (void *)memory, memory += capacity * sizeof(float);
	POSTS_WHOLES_EACH(POSTS_PLACE)
	POSTS_REALS_EACH(POSTS_PLACE)
#undef POSTS_PLACE
	posts->capacity = capacity;
	return STATUS_OK;
}

void soil_posts_finish(struct soil_posts *posts)
{
	mem_free(posts->memory);
	*posts = (struct soil_posts){0};
}

struct post_rect soil_posts_below(const struct soil_law *law, const struct soil_motion *motion)
{
	const double spacing = law->spacing, x = lattice_offset_metres(motion->to.x) + motion->beyond[0], y = lattice_offset_metres(motion->to.y) + motion->beyond[1];
	const double from[2] = {motion->jumped ? x : lattice_offset_metres(motion->from.x), motion->jumped ? y : lattice_offset_metres(motion->from.y)};
	double extent[2];
	soil_body_extent(motion->shape, &motion->to, extent);
	return (struct post_rect){(int64_t)floor((fmin(x, from[0]) - extent[0]) / spacing), (int64_t)floor((fmin(y, from[1]) - extent[1]) / spacing),
				  (int64_t)ceil((fmax(x, from[0]) + extent[0]) / spacing) + 1, (int64_t)ceil((fmax(y, from[1]) + extent[1]) / spacing) + 1};
}

/* --- the planes --- */

/* A walk over the posts below a body, row by row. Places are in the body's frame. */
struct walk {
	struct post_rect below;
	double corner[2], step[2]; /* of the first post from the centre, east and north; from a post to the next one of its row */
	int64_t zero;              /* fixed-point units: the centre above the store's reference */
	double slack;              /* m: how much higher than its post the ground of a cell can be, for a slope of 1 */
	int32_t raised;
};

static struct walk walk_of(const struct soil_law *law, const struct soil_body *body, const struct soil_form *form, int32_t raised)
{
	const struct soil_motion *motion = body->motion;
	struct walk walk = {.below = soil_posts_below(law, motion), .step = {body->axis[0] * law->spacing, -body->axis[1] * law->spacing}, .raised = raised};
	walk.corner[0] = -(double)soil_body_from_post(motion->to.x, walk.below.x0, law->spacing) - motion->beyond[0];
	walk.corner[1] = -(double)soil_body_from_post(motion->to.y, walk.below.y0, law->spacing) - motion->beyond[1];
	walk.zero = motion->to.z - (int64_t)law->reference * ((int64_t)1 << OFFSET_BITS);
	walk.slack = (double)form->half_across + 0.5 * law->spacing;
	return walk;
}

/* Returns the height of the undisturbed surface above the body's centre, fixed-point units. What is too far away is clamped: it touches nothing. */
static inline int32_t ground_of(int32_t base, int32_t deposited, int64_t zero)
{
	const int64_t far = ((int64_t)1 << 30) - ((int64_t)1 << 20), height = (int64_t)base * (1 << (OFFSET_BITS - BASE_BITS)) + deposited - zero;
	return (int32_t)(height < -far ? -far : height > far ? far : height);
}

/* Leaves the columns at which first + column x step is between low and high. */
static void cut(double first, double step, double low, double high, int64_t columns[2])
{
	if (fabs(step) < 1e-9)
		return;
	const double a = (low - first) / step, b = (high - first) / step, end = (double)columns[1];
	columns[1] = (int64_t)fmin(fmax(ceil(fmax(a, b)) + 1, 0), end);
	columns[0] = (int64_t)fmin(fmax(floor(fmin(a, b)), (double)columns[0]), (double)columns[1]);
}

/* Tells whether a rim may bear on a post, or pass over it. at: its place; height: of the highest ground of its cell above the centre. */
static bool rim_is_near(const struct soil_body *body, const struct soil_form *form, const double at[2], double height, double reach)
{
	const double away = fmax(fmax(at[0], -at[0] - (double)form->run) - reach, 0), leans = fabs((double)form->lean);
	const double side = height * (double)form->level - (double)form->lean * at[1] + leans * (reach + (double)form->step_aside);
	return away <= body->outer && (side >= 0 || away * away + side * side <= body->outer * body->outer);
}

/* The same of a mesh. */
static bool raster_is_near(const struct soil_form *form, const double at[2], double height)
{
	return (double)soil_cover_fine_low(form, (float)at[0], (float)at[1]) <= height;
}

/* The base of a post as the planes have it. */
struct ground_row {
	const int32_t *base, *deposited;
	int64_t zero;
};

/* Drops posts at the ends of a row of a rim or a mesh that surely neither bear nor are passed over. */
static void trim(const struct walk *walk, const struct soil_body *body, const struct soil_form *form, const struct ground_row *row, const double first[2],
		 int64_t columns[2])
{
	const double reach = walk->slack, fell = (double)form->plunge < 0 ? 0 : (double)form->plunge;
	for (int end = 0; end < 2; end++)
		while (columns[0] < columns[1]) {
			const int64_t column = end == 0 ? columns[0] : columns[1] - 1;
			const double at[2] = {first[0] + (double)column * walk->step[0], first[1] + (double)column * walk->step[1]};
			const int32_t base = row->base[column];
			/* A slope counts as at most 2 here; where it is steeper, nothing is dropped. */
			const double rise = fmax(fabs((double)row->base[column + 1] - base), fabs((double)base - row->base[column - 1])) * lattice_base_metres(1);
			const int32_t height = ground_of(base, row->deposited != NULL ? row->deposited[column] : 0, row->zero);
			const double most_height = lattice_offset_metres((int64_t)height - walk->raised) + fell + 4 * reach;
			if (base == BASE_NODATA || (rise < 2 * (double)form->spacing && !(form->kind == FORM_RIM ? rim_is_near(body, form, at, most_height, reach) : raster_is_near(form, at, most_height))))
				columns[end] += end == 0 ? 1 : -1;
			else
				break;
		}
}

static void copy(int32_t *restrict to, const int32_t *restrict from, size_t count)
{
	if (from != NULL)
		memcpy(to, from, count * sizeof *to);
	else
		memset(to, 0, count * sizeof *to);
}

/* Copies what the planes have of a run of posts. */
static void take_run(const struct soil_planes *planes, size_t at, size_t count, const double place[2], const struct walk *walk, struct soil_posts *p)
{
	const size_t to = p->count;
	for (size_t i = 0; i < count; i++) {
		p->index[to + i] = (int32_t)(at + i);
		p->x[to + i] = (float)(place[0] + (double)i * walk->step[0]);
		p->y[to + i] = (float)(place[1] + (double)i * walk->step[1]);
	}
	copy(p->base + to, planes->base + at, count);
	copy(p->west + to, planes->base + at - 1, count);
	copy(p->east + to, planes->base + at + 1, count);
	copy(p->south + to, planes->base + at - planes->width, count);
	copy(p->north + to, planes->base + at + planes->width, count);
	copy(p->deposited + to, planes->deposited != NULL ? planes->deposited + at : NULL, count);
	copy(p->sinkage + to, planes->sinkage != NULL ? planes->sinkage + at : NULL, count);
	copy(p->shear + to, planes->shear != NULL ? planes->shear + at : NULL, count);
	copy(p->digs + to, planes->dug != NULL ? planes->dug + at : NULL, count);
	copy(p->surface + to, planes->offset != NULL ? planes->offset + at : NULL, count);
	for (size_t i = 0; i < count; i++) {
		p->ground[to + i] = ground_of(p->base[to + i], p->deposited[to + i], walk->zero);
		p->surface[to + i] = ground_of(p->base[to + i], p->surface[to + i], walk->zero);
	}
	p->count += count;
}

static void take_rows(const struct soil_planes *planes, const struct soil_body *body, const struct soil_form *form, const struct walk *walk, struct soil_posts *p)
{
	const struct post_rect *below = &walk->below;
	const double reach = walk->slack, leans = fabs((double)form->lean) * (double)form->radius;
	const double half = fmax((double)form->half[1], 0.5 * (double)form->step_aside) + leans + 0.01 * (double)form->spacing, aside = (double)form->way[1];
	p->count = 0;
	for (int64_t y = below->y0; y < below->y1; y++) {
		const double north = walk->corner[1] + (double)(y - below->y0) * (double)form->spacing;
		const double first[2] = {body->axis[0] * walk->corner[0] + body->axis[1] * north, body->axis[0] * north - body->axis[1] * walk->corner[0]};
		const size_t at = (size_t)(y - planes->rect.y0) * planes->width + (size_t)(below->x0 - planes->rect.x0);
		int64_t columns[2] = {0, below->x1 - below->x0};
		if (form->kind == FORM_RIM) {
			cut(first[1], walk->step[1], -half - fmax(aside, 0), half - fmin(aside, 0), columns);
			cut(first[0], walk->step[0], -body->outer - reach - (double)form->run, body->outer + reach, columns);
			const struct ground_row row = {planes->base + at, planes->deposited != NULL ? planes->deposited + at : NULL, walk->zero};
			trim(walk, body, form, &row, first, columns);
		} else if (form->kind == FORM_RASTER) {
			const struct ground_row row = {planes->base + at, planes->deposited != NULL ? planes->deposited + at : NULL, walk->zero};
			trim(walk, body, form, &row, first, columns);
		}
		const double place[2] = {first[0] + (double)columns[0] * walk->step[0], first[1] + (double)columns[0] * walk->step[1]};
		if (columns[1] > columns[0])
			take_run(planes, at + (size_t)columns[0], (size_t)(columns[1] - columns[0]), place, walk, p);
	}
}

/* --- numbers --- */

SOIL_INLINED float rise_between(int32_t low, int32_t at, int32_t high, float scale)
{
	const int32_t from = low == BASE_NODATA ? at : low, to = high == BASE_NODATA ? at : high;
	const float rise = (float)(int32_t)((uint32_t)to - (uint32_t)from) * scale;
	return rise * ((low == BASE_NODATA) | (high == BASE_NODATA) ? 1 : 0.5f);
}

/* Computes the numbers of a block from what the planes have. A slope counts as at most 87 degrees. */
SOIL_CLONED static void put_numbers(const float axis[restrict 2], float scale, struct soil_posts *restrict p, size_t b)
{
	const float c = axis[0], s = axis[1];
	for (int i = 0; i < POSTS_LANES; i++) {
		const float rise_x = rise_between(p->west[b + i], p->base[b + i], p->east[b + i], scale);
		const float rise_y = rise_between(p->south[b + i], p->base[b + i], p->north[b + i], scale);
		const float squares = rise_x * rise_x + rise_y * rise_y, by_up = sqrtf(1 + squares), less = FORM_STEEPEST / most(sqrtf(squares), FORM_STEEPEST);
		p->rise_x[b + i] = (c * rise_x + s * rise_y) * less;
		p->rise_y[b + i] = (c * rise_y - s * rise_x) * less;
		p->up[b + i] = most(1 / by_up, FORM_UPRIGHT);
		p->by_up[b + i] = least(by_up, 1 / FORM_UPRIGHT);
	}
	for (int i = 0; i < POSTS_LANES; i++) {
		const float east = (float)(int32_t)(((uint32_t)p->shear[b + i] & 0xffffu) ^ 0x8000u) - 32768, north = (float)(p->shear[b + i] >> 16);
		p->shear_x[b + i] = (c * east + s * north) * 0x1p-15f;
		p->shear_y[b + i] = (c * north - s * east) * 0x1p-15f;
		p->was[b + i] = (float)p->sinkage[b + i] * SOIL_UNIT;
		p->dug[b + i] = (float)p->digs[b + i] * SOIL_UNIT;
	}
}

static float bounded(double value)
{
	return (float)fmin(value, 1e30);
}

/* Puts the numbers of one soil into the posts from `first` to before `last`. */
static void put_soil(const struct soil_numbers *soil, size_t first, size_t last, struct soil_posts *p)
{
	const float tangent = (float)tan(soil->friction_angle);
	for (size_t i = first; i < last; i++) {
		p->k_c[i] = (float)soil->bekker_kc;
		p->k_phi[i] = (float)soil->bekker_kphi;
		p->n[i] = (float)soil->bekker_n;
		p->elastic[i] = bounded(soil->elastic_stiffness);
		p->by_elastic[i] = bounded(1 / soil->elastic_stiffness);
		p->cohesion[i] = (float)soil->cohesion;
		p->tan_phi[i] = tangent;
		p->modulus[i] = bounded(soil->janosi_shear);
		p->by_modulus[i] = bounded(1 / soil->janosi_shear);
		p->damping[i] = (float)soil->damping;
	}
}

/* Returns the soil of a post, with what rasters say of it. */
static struct soil_numbers soil_at(const struct soil_law *law, const struct soil_planes *planes, size_t at)
{
	const int class = planes->classes != NULL ? planes->classes[at] : 0;
	struct soil_numbers soil = law->soils[class < law->soil_count ? class : 0];
	for (int i = 0; i < law->raster_count && planes->levels != NULL; i++)
		if (planes->levels[SOIL_RASTERS * at + (size_t)i] != 0)
			*soil_number_in(&soil, law->rasters[i].number) = soil_raster_value(&law->rasters[i], planes->levels[SOIL_RASTERS * at + (size_t)i]);
	return soil;
}

static bool same_soil(const struct soil_law *law, const struct soil_planes *planes, size_t a, size_t b)
{
	return (planes->classes == NULL || planes->classes[a] == planes->classes[b]) &&
	       (planes->levels == NULL || law->raster_count == 0 || memcmp(planes->levels + SOIL_RASTERS * a, planes->levels + SOIL_RASTERS * b, SOIL_RASTERS) == 0);
}

/* Neighbours of one soil are filled together. */
static void put_soils(const struct soil_law *law, const struct soil_planes *planes, struct soil_posts *p)
{
	for (size_t first = 0, last; first < p->count; first = last) {
		const size_t at = (size_t)p->index[first];
		for (last = first + 1; last < p->count && same_soil(law, planes, at, (size_t)p->index[last]);)
			last++;
		const struct soil_numbers soil = soil_at(law, planes, at);
		put_soil(&soil, first, last, p);
	}
}

/* Copies the last post into the lanes after it. They bear nothing, since their share is 0. */
static void fill_lanes(struct soil_posts *p)
{
	const size_t last = p->count - 1, end = (p->count + POSTS_LANES - 1) / POSTS_LANES * POSTS_LANES;
	for (size_t i = p->count; i < end; i++) {
#define POSTS_FILL(name) p->name[i] = p->name[last];
		POSTS_WHOLES_EACH(POSTS_FILL)
		POSTS_REALS_EACH(POSTS_FILL)
#undef POSTS_FILL
		p->base[i] = BASE_NODATA;
	}
}

void soil_posts_gather(const struct soil_law *law, const struct soil_planes *planes, const struct soil_body *body, const struct soil_form *form,
		       int32_t raised, struct soil_posts *posts)
{
	const struct walk walk = walk_of(law, body, form, raised);
	const float axis[2] = {(float)body->axis[0], (float)body->axis[1]};
	take_rows(planes, body, form, &walk, posts);
	if (posts->count == 0)
		return;
	put_soils(law, planes, posts);
	fill_lanes(posts);
	for (size_t b = 0; b < posts->count; b += POSTS_LANES)
		put_numbers(axis, (float)(lattice_base_metres(1) / law->spacing), posts, b);
	soil_cover(body, form, posts);
}

SOIL_CLONED void soil_posts_width(float by_width, struct soil_posts *posts)
{
	float *restrict k = posts->k;
	const float *restrict k_c = posts->k_c, *restrict k_phi = posts->k_phi;
	for (size_t i = 0; i < (posts->count + POSTS_LANES - 1) / POSTS_LANES * POSTS_LANES; i++)
		k[i] = most(k_c[i] * by_width + k_phi[i], 0); /* k_c may be negative, and a patch small */
}
