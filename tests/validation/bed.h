/*
 * A bed of soil for comparisons with closed forms: whole tiles from the world's south-western corner on, whose posts beyond the bed have no data. Its sums
 * are exact: that nothing is lost is checked after whatever happens to it.
 */
#ifndef FURROW_TESTS_VALIDATION_BED_H
#define FURROW_TESTS_VALIDATION_BED_H

#include "../bearing/ground.h"

#define RADIANS (M_PI / 180)
#define BED_CELLS 64
/* What it is kept in: heights and sinkages in m, mobilised shear as a share. A share by which stresses are rounded: exp2 and log2 in single precision. */
#define BED_QUANTUM 0x1p-20
#define BED_SHEAR 0x1p-15
#define BED_STRESS 1e-5

struct bed_params {
	int width, height; /* posts */
	double spacing;
	double (*ground)(int x, int y); /* NULL: flat at 0. Metres */
	struct soil_numbers soil;
	enum deform_model model; /* 0: scm */
};

struct bed {
	struct ground ground;
	struct bed_params params;
	int32_t *pressed; /* largest sinkages when work was last asked */
};

/* On the bed, about the body's centre; and the bed's. */
struct bed_forces {
	double force[3], moment[3]; /* N, N m: east, north, up */
	double normal;  /* N: on level ground shear is level, so it is the vertical force */
	double area;    /* m2 of the ground that bears it */
	double sinkage; /* m, the deepest of those */
	double work;    /* J that the soil's yielding took over the contact */
};

static const struct bed_params *bed_made; /* while it is made */

static inline int32_t bed_height(int64_t x, int64_t y)
{
	if (x >= bed_made->width || y >= bed_made->height)
		return BASE_NODATA;
	return bed_made->ground == NULL ? 0 : (int32_t)lattice_base(bed_made->ground((int)x, (int)y));
}

static inline void bed_init(struct bed *bed, const struct bed_params *params)
{
	const int most = params->width > params->height ? params->width : params->height;
	bed->params = *params;
	bed_made = params;
	ground_init(&bed->ground, &(struct ground_params){
		.cells = BED_CELLS, .tiles = (uint32_t)((most + BED_CELLS - 2) / BED_CELLS), .spacing = params->spacing, .height = bed_height, .model = params->model,
		.soils = &params->soil,
	});
	bed->pressed = ground_room(bed->ground.posts * bed->ground.posts, sizeof *bed->pressed);
}

static inline void bed_finish(struct bed *bed)
{
	ground_finish(&bed->ground);
	mem_free(bed->pressed);
}

/* Of what was pressed since it was last asked, J: the soil yielded along Bekker's curve. */
static inline double bed_work(struct bed *bed, const struct soil_shape *shape)
{
	const struct soil_numbers *soil = &bed->params.soil;
	const double width = shape->kind == SOIL_WHEEL ? shape->width : fmin(shape->size[0], shape->size[1]), power = soil->bekker_n + 1;
	int32_t *now = ground_plane(&bed->ground, PLANE_PLASTIC_SINKAGE);
	double sum = 0;
	for (int64_t i = 0; i < bed->ground.posts * bed->ground.posts; i++)
		sum += pow(lattice_offset_metres(now[i]), power) - pow(lattice_offset_metres(bed->pressed[i]), power);
	mem_free(bed->pressed);
	bed->pressed = now;
	return reference_stiffness(soil, width) * sum / power * bed->params.spacing * bed->params.spacing;
}

/* `lower`: how far the soil let the load sink below the contact's height. */
static inline void bed_press(struct bed *bed, const struct deform_contact *contact, struct bed_forces *forces, double *lower)
{
	const struct deform_forces got = ground_forces(&bed->ground, contact);
	assert_true(got.state != DEFORM_SUNK && got.saturated == 0);
	*forces = (struct bed_forces){.normal = got.force[2], .area = got.area, .sinkage = got.sinkage, .work = bed_work(bed, contact->shape)};
	memcpy(forces->force, got.force, sizeof got.force);
	memcpy(forces->moment, got.moment, sizeof got.moment);
	*lower = lattice_offset_metres(contact->to.z - got.z);
	ground_lost_nothing(&bed->ground);
}

/* Slides until nothing moves. */
static inline void bed_settle(struct bed *bed)
{
	size_t blocks = 1;
	assert_ok(bearing_wake(bed->ground.bearing, (struct post_rect){0, 0, bed->ground.posts, bed->ground.posts}));
	for (int n = 0; n < 100000 && blocks > 0; n++)
		blocks = ground_interval(&bed->ground, NULL, 0);
	assert_int_equal(blocks, 0);
	ground_lost_nothing(&bed->ground);
}

/* Returns the heights of all posts of the ground, m; ground.posts in a row. Freed by the caller. */
static inline double *bed_surface(struct bed *bed)
{
	int32_t *offset = ground_plane(&bed->ground, PLANE_OFFSET);
	double *surface = ground_room(bed->ground.posts * bed->ground.posts, sizeof *surface);
	bed_made = &bed->params;
	for (int64_t i = 0; i < bed->ground.posts * bed->ground.posts; i++)
		surface[i] = lattice_base_metres(bed_height(i % bed->ground.posts, i / bed->ground.posts)) + lattice_offset_metres(offset[i]);
	mem_free(offset);
	return surface;
}

static inline double bed_surface_at(struct bed *bed, int x, int y)
{
	double *surface = bed_surface(bed), at = surface[y * bed->ground.posts + x];
	mem_free(surface);
	return at;
}

/* Centre at a place in posts and a height in metres. */
static inline struct soil_pose bed_pose(double x, double y, double z, double spacing)
{
	return (struct soil_pose){lattice_offset(x * spacing), lattice_offset(y * spacing), lattice_offset(z), 0, 0, 0, 0};
}

/* Within `share` of what is wanted. Says both. */
static inline void bed_near(const char *what, double got, double wanted, double share)
{
	print_message("%-56s %12.6g, wanted %12.6g: %+.4f %%, allowed %.4f %%\n", what, got, wanted,
		      (got / wanted - 1) * 100, share * 100);
	if (!(fabs(got / wanted - 1) <= share))
		fail_msg("%s: %.9g, wanted %.9g", what, got, wanted);
}

#endif
