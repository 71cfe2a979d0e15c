/* A tile that the GPU divides with relief is what base makes of it, bit for bit. */
#include "slots.h"
#include "../support/program.h"

/* Tiles near the origin and far from it, to the north and to the east. */
static struct tile any_tile(int level, int i)
{
	const uint32_t far = i % 3 == 0 ? 0 : i % 3 == 1 ? 1u << 20 : (1u << 28) - 5000;
	return (struct tile){level, far + any_word() % 4096, (i % 2 == 0 ? far : 0) + any_word() % 4096};
}

static void relief_in_glsl_is_relief_in_c(void **state)
{
	static const double waves[][3] = {{1, 2, 0.02}, {30, 2, 0.02}, {4, 1000, 10}, {0.5, 0.07, 0.001}}; /* spacing, wavelength, roughness */
	size_t raised = 0, holes = 0;
	(void)state;
	need_gpu();
	for (uint32_t n = 8; n <= 64; n *= 2) {
		size_t posts = (size_t)(n + 1) * (n + 1);
		int32_t *expected = mem_alloc(posts, sizeof *expected), *read = mem_alloc(posts, sizeof *read), *heights = mem_alloc(posts, sizeof *heights);
		struct gpu_slots *slots;
		assert_true(expected != NULL && read != NULL && heights != NULL);
		assert_ok(gpu_slots_create(test_gpu, n, 1, 0, &slots));
		for (int shift = 1; shift <= 14; shift++)
			for (int i = 0; i < 8; i++) {
				const struct relief_spec spec = {.seed = any_word(), .classes = 1, .waves = {{waves[i % 4][2], waves[i % 4][1]}}};
				const struct tile tile = any_tile(-shift, i);
				const uint32_t stride = lattice_patch_posts(n, shift), part = (1u << shift) - 1, x = tile.x * n & part, y = tile.y * n & part;
				struct relief relief;
				struct gpu_staging *staging;
				relief_make(&spec, waves[i % 4][0], -14, &relief);
				int32_t *patch = random_ints((size_t)stride * stride);
				for (size_t k = 0; k < (size_t)stride * stride; k++)
					patch[k] = any_word() % 16 == 0 ? BASE_NODATA : patch[k] >> 2;
				lattice_subdivide(patch, n, shift, x, y, expected);
				const int64_t x0 = (int64_t)tile.x * n, y0 = (int64_t)tile.y * n;
				assert_ok(relief_heights(&relief, -shift, 0, (struct post_rect){x0, y0, x0 + n + 1, y0 + n + 1}, heights));
				for (size_t k = 0; k < posts; k++) {
					raised += heights[k] != 0;
					holes += expected[k] == BASE_NODATA;
					expected[k] += expected[k] != BASE_NODATA ? heights[k] : 0;
				}
				assert_ok(staged_from(test_gpu, patch, (size_t)stride * stride * sizeof *patch, &staging));
				assert_ok(gpu_slots_subdivide_relief(slots, 0, staging, STAGED_AT, x, y, tile, &relief));
				gpu_texture_read(gpu_slots_get(slots, 0)->base, 0, rect_of(0, 0, n + 1, n + 1), read);
				assert_memory_equal(read, expected, posts * sizeof *read);
				gpu_staging_destroy(staging);
				mem_free(patch);
			}
		assert_ok(gpu_check(test_gpu, "relief"));
		gpu_slots_destroy(slots);
		mem_free(expected);
		mem_free(read);
		mem_free(heights);
	}
	assert_true(raised > 200000 && holes > 1000);
}

TEST_PROGRAM(relief)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(relief_in_glsl_is_relief_in_c),
	};
	return cmocka_run_group_tests(tests, open_gpu, close_gpu);
}
