/* Ground of one window for the tests of sliding: its posts go into the scratch, slide, and come back. */
#ifndef FURROW_TESTS_DEFORM_SLAB_H
#define FURROW_TESTS_DEFORM_SLAB_H

#include "ground.h"
#include "soil/stability.h"

#define N 40 /* posts a side of what is written */
#define RIM 2 /* posts of other ground around it */
#define HELD 2

__extension__ typedef __int128 wide;

struct slab {
	int32_t base[N * N], offset[N * N], deposit[N * N];
	uint8_t contacts[N * N], classes[N * N];
};

static struct slab slab, before;

static inline wide sum_of(const struct slab *of)
{
	wide sum = 0;
	for (int i = 0; i < N * N; i++)
		sum += (wide)of->offset[i] + (uint32_t)of->deposit[i];
	return sum;
}

/* Twice the potential energy but for a factor: the sum of squared heights, exactly, holes left out. */
static inline wide energy_of(const struct slab *of)
{
	wide sum = 0;
	for (int i = 0; i < N * N; i++) {
		int64_t height = 4 * (int64_t)of->base[i] + of->offset[i];
		if (of->base[i] != BASE_NODATA)
			sum += (wide)height * height;
	}
	return sum;
}

static double relief; /* of the world, m; 0: not known */
static double tolerance; /* m */
static bool stands;   /* undisturbed ground does */
static bool along_lines; /* soil slides along lines too */

static inline void start(struct ground *ground, enum deform_model model, double spacing, int iterations, double depth,
		  const struct soil_numbers *soils, int count)
{
	ground_init(ground, &(struct ground_params){.cells = 32, .tiles = 1, .spacing = spacing, .model = model, .soils = soils,
						    .soil_count = count, .iterations = iterations, .depth = depth, .relief = relief, .tolerance = tolerance,
						    .stands = stands, .lines = along_lines});
}

/* Uploads the slab into the scratch, with other ground around it, and lets it slide there. */
static inline void slide_in_scratch(struct ground *ground)
{
	struct deform *deform = ground->deform;
	struct gpu_rect rect = rect_of(RIM, RIM, N, N), around = rect_of(0, 0, N + 2 * RIM, N + 2 * RIM);
	struct deform_window window = {.read = {0, 0, N + 2 * RIM, N + 2 * RIM}, .write = {RIM, RIM, N + RIM, N + RIM}};
	gpu_texture_clear(deform->bases, 0, around, 40 << 18);
	gpu_texture_clear(deform->planes_of[1][PLANE_OFFSET], 0, around, 1 << 20);
	gpu_texture_clear(deform->contacts, 0, around, 0);
	gpu_texture_clear(deform->deposits, 0, around, 99);
	gpu_texture_upload(deform->bases, 0, rect, slab.base);
	gpu_texture_upload(deform->planes_of[1][PLANE_OFFSET], 0, rect, slab.offset);
	gpu_texture_upload(deform->contacts, 0, rect, slab.contacts);
	gpu_texture_upload(deform->deposits, 0, rect, slab.deposit);
	if (deform->classes != NULL)
		gpu_texture_upload(deform->classes, 0, rect, slab.classes);
	deform->scratch[0].now[PLANE_OFFSET] = 1;
	deform->scratch[0].near = false;
	assert_ok(deform_slide(deform, &window, 0));
	assert_ok(gpu_check(test_gpu, "sliding"));
}

/* The slab slides. Its deposits become part of its offsets. */
static inline void slide_on_gpu(struct ground *ground)
{
	slide_in_scratch(ground);
	gpu_texture_read(ground->deform->planes_of[1][PLANE_OFFSET], 0, rect_of(RIM, RIM, N, N), slab.offset);
	memset(slab.deposit, 0, sizeof slab.deposit);
}

static inline int64_t height_of(const struct slab *of, int i)
{
	return 4 * (int64_t)of->base[i] + of->offset[i];
}

static inline void flat_slab(void)
{
	memset(&slab, 0, sizeof slab);
	for (int i = 0; i < N * N; i++)
		slab.base[i] = 40 << 18;
}

#endif
