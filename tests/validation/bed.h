/*
 * A bed of soil, and who computes it: every number is asked of a kind of bed, so that another that presses,
 * slides and weighs can be held to the same. One test is run once with each kind.
 */
#ifndef FURROW_TESTS_VALIDATION_BED_H
#define FURROW_TESTS_VALIDATION_BED_H

#include "../deform/ground.h"

#define RADIANS (M_PI / 180)

struct bed_params {
	int width, height; /* posts */
	double spacing;
	double (*ground)(int x, int y); /* NULL: flat at 0. Metres */
	struct deform_params deform;    /* the model's part of it */
};

struct bed_kind {
	/* What it is kept in: heights and sinkages in m, mobilised shear as a share; 0: nothing is rounded. A share by which
	 * stresses are. */
	double quantum, shear_quantum, stress;
	void *(*make)(const struct bed_params *params);
	void (*destroy)(void *bed);
	/* `lower`: how far the soil let the load sink below the sweep's height. */
	void (*sweep)(void *bed, const struct deform_contact *sweep, struct reference_forces *forces, double *lower);
	/* Slides until nothing moves more than `tolerance`. */
	void (*settle)(void *bed, double tolerance);
	double (*surface)(void *bed, int x, int y);
	double (*volume)(void *bed); /* m3, of the offsets and of what was compacted */
};

struct bed_reference {
	struct reference_ground ground;
	struct deform_params params;
};

static void *bed_reference_make(const struct bed_params *params)
{
	struct bed_reference *bed = mem_calloc(1, sizeof *bed);
	assert_non_null(bed);
	bed->params = params->deform;
	assert_int_equal(reference_ground_init(&bed->ground, params->width, params->height, params->spacing), STATUS_OK);
	for (int i = 0; i < params->width * params->height && params->ground != NULL; i++)
		bed->ground.base[i] = params->ground(i % params->width, i / params->width);
	return bed;
}

static void bed_reference_destroy(void *user)
{
	struct bed_reference *bed = user;
	reference_ground_finish(&bed->ground);
	mem_free(bed);
}

static void bed_reference_sweep(void *user, const struct deform_contact *sweep, struct reference_forces *forces, double *lower)
{
	struct bed_reference *bed = user;
	if (reference_sweep(&bed->ground, &bed->params, sweep, forces, lower) != STATUS_OK)
		fail_msg("%s", failure_message());
}

static void bed_reference_settle(void *user, double tolerance)
{
	struct bed_reference *bed = user;
	double moved;
	assert_int_equal(reference_slide(&bed->ground, &bed->params, 1000000, tolerance, &moved), STATUS_OK);
	assert_true(moved <= tolerance);
}

static double bed_reference_surface(void *user, int x, int y)
{
	struct bed_reference *bed = user;
	int at = y * bed->ground.width + x;
	return bed->ground.base[at] + bed->ground.offset[at];
}

static double bed_reference_volume(void *user)
{
	struct bed_reference *bed = user;
	return reference_volume(&bed->ground);
}

static const struct bed_kind bed_reference = {
	0, 0, 0, bed_reference_make, bed_reference_destroy, bed_reference_sweep,
	bed_reference_settle, bed_reference_surface, bed_reference_volume,
};

static inline struct soil_numbers bed_soil(const char *name)
{
	struct soil_numbers soil;
	assert_int_equal(soil_named(name, &soil), STATUS_OK);
	return soil;
}

static inline struct bed_params bed_scm(int width, int height, double spacing, struct soil_numbers soil)
{
	return (struct bed_params){
		.width = width, .height = height, .spacing = spacing,
		.deform = {.model = DEFORM_SCM, .soils = {soil}, .soil_count = 1, .iterations = 4},
	};
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
