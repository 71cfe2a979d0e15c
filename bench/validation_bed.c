/* Beds are whole tiles in host memory, all resident, of a world as large. */
#include "validation_bed.h"

#include <math.h>
#include <string.h>

#include "bearing/bearing.h"
#include "bench.h"
#include "resident/host_slots.h"

#define CELLS 64

struct bed {
	struct soil_numbers soil;
	struct extent extent;
	struct host_slots *slots;
	struct bearing *bearing;
	struct tile_slot *tiles;
	size_t tile_count;
	double spent; /* J: work of all contacts so far */
};

struct bed *bed_create(int width, int height, double spacing, const struct soil_numbers *soil)
{
	struct bed *bed = mem_calloc(1, sizeof *bed);
	const int most = width > height ? width : height;
	const uint32_t side = (uint32_t)(most + CELLS - 2) / CELLS;
	if (bed == NULL)
		bench_must(fail_memory("bench"));
	bed->soil = *soil;
	bed->extent = (struct extent){side * CELLS + 1, side * CELLS + 1, spacing, CELLS};
	bed->tile_count = (size_t)side * side;
	bed->tiles = mem_calloc(bed->tile_count, sizeof *bed->tiles);
	if (bed->tiles == NULL)
		bench_must(fail_memory("bench"));
	bench_must(resident_host_create(CELLS, side * side, deform_planes(DEFORM_SCM, false, false), &bed->slots));
	for (uint32_t k = 0; k < side * side; k++) {
		int32_t *base;
		bed->tiles[k] = (struct tile_slot){{0, k % side, k / side}, k};
		bench_must(resident_host_tile_base(bed->slots, &host_entry(bed->slots, k)->tile, &base));
		memset(base, 0, (CELLS + 1) * (CELLS + 1) * sizeof *base);
	}
	bench_must(bearing_create(&(struct deform_params){.extent = &bed->extent, .model = DEFORM_SCM, .soils = {*soil}, .soil_count = 1, .iterations = 1}, bed->slots,
				  &bed->bearing));
	return bed;
}

void bed_destroy(struct bed *bed)
{
	bearing_destroy(bed->bearing);
	resident_host_destroy(bed->slots);
	mem_free(bed->tiles);
	mem_free(bed);
}

/* Sums z^(n + 1) over all posts, m^(n + 1). Edges of tiles count once. */
static double sum_of(const struct bed *bed)
{
	double sum = 0;
	for (size_t k = 0; k < bed->tile_count; k++) {
		const int32_t *sinkage = host_tile_plane(bed->slots, &host_entry(bed->slots, (uint32_t)k)->tile, PLANE_PLASTIC_SINKAGE);
		for (size_t y = 0; y < CELLS && sinkage != NULL; y++)
			for (size_t x = 0; x < CELLS; x++)
				sum += pow(lattice_offset_metres(sinkage[y * (CELLS + 1) + x]), bed->soil.bekker_n + 1);
	}
	return sum;
}

void bed_press(struct bed *bed, const struct deform_contact *contact, struct deform_forces *forces, double *lower, double *work)
{
	const struct soil_shape *shape = contact->shape;
	const double width = shape->kind == SOIL_WHEEL ? shape->width : fmin(shape->size[0], shape->size[1]);
	struct bearing_contact done = {.contact = contact};
	bench_must(bearing_area(bed->bearing, contact, &done.area));
	bench_must(bearing_contact_alone(bed->bearing, &done, bed->tiles, bed->tile_count));
	const double spent = (bed->soil.bekker_kc / width + bed->soil.bekker_kphi) * sum_of(bed) / (bed->soil.bekker_n + 1) * bed->extent.spacing * bed->extent.spacing;
	*forces = done.forces;
	if (lower != NULL)
		*lower = lattice_offset_metres(contact->to.z - done.forces.z);
	if (work != NULL)
		*work = spent - bed->spent;
	bed->spent = spent;
}
