/* What the tests of scm share: soils, ground, motions, and the planes that a contact leaves. */
#ifndef FURROW_TESTS_DEFORM_SCM_RIG_H
#define FURROW_TESTS_DEFORM_SCM_RIG_H

#include "ground.h"

static inline struct soil_numbers named(const char *name)
{
	struct soil_numbers soil;
	assert_ok(soil_named(name, &soil));
	return soil;
}

/* Project Chrono's soft soil. */
static inline struct soil_numbers soft(void)
{
	struct soil_numbers soil = named("dry_sand");
	soil.bekker_kc = soil.cohesion = 0;
	soil.bekker_kphi = 0.2e6;
	soil.bekker_n = 1.1;
	soil.friction_angle = 30 * M_PI / 180;
	soil.janosi_shear = 0.01;
	soil.elastic_stiffness = 4e7;
	soil.damping = 3e4;
	return soil;
}

static const struct soil_shape wheel = {.kind = SOIL_WHEEL, .radius = 0.3, .width = 0.2};

static inline void init(struct ground *ground, const struct soil_numbers *soil, double spacing, double bulldozing)
{
	ground_init(ground, &(struct ground_params){.cells = 64, .tiles = 2, .first = 2, .spacing = spacing, .model = DEFORM_SCM,
						    .soils = soil, .bulldozing = bulldozing});
}

static inline struct deform_contact move(const struct deform_contact *before, double dx, double dy, double dz)
{
	struct deform_contact sweep = *before;
	sweep.from = before->to;
	sweep.to.x += lattice_offset(dx);
	sweep.to.y += lattice_offset(dy);
	sweep.to.z += lattice_offset(dz);
	return sweep;
}

struct planes {
	int32_t *all[PLANES];
};

static const enum plane kept[] = {PLANE_OFFSET, PLANE_DEPOSITED, PLANE_PLASTIC_SINKAGE, PLANE_SHEAR};
#define KEPT (sizeof kept / sizeof *kept)

static inline struct planes planes_of(struct ground *ground)
{
	struct planes planes;
	for (size_t i = 0; i < KEPT; i++)
		planes.all[i] = ground_plane(ground, kept[i]);
	return planes;
}

static inline void assert_same_and_free(const struct ground *ground, struct planes *a, struct planes *b)
{
	for (size_t i = 0; i < KEPT; i++) {
		assert_memory_equal(a->all[i], b->all[i], (size_t)(ground->posts * ground->posts) * 4);
		mem_free(a->all[i]);
		mem_free(b->all[i]);
	}
}

#endif
