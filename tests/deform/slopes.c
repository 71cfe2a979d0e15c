/* High slopes of cohesive soil: they fall above Culmann's height and stand below it, however near the posts lie. */
#include <stdio.h>

#include "late.h"
#include "sliding.h"
#include "deform/soil/stability.h"

/* A straight bank, through the middle of the ground. */
static struct bank {
	double spacing, middle, height, slope, direction, shift; /* m; rad; posts across the bank */
} bank;

static double bank_at(double x, double y)
{
	double across = (x - bank.middle) * cos(bank.direction) + (y - bank.middle) * sin(bank.direction) + bank.shift * bank.spacing;
	double down = across * tan(bank.slope);
	return 10 - fmax(0, fmin(bank.height, down + bank.height / 2));
}

static int32_t bank_post(int64_t x, int64_t y)
{
	return (int32_t)lrint(ldexp(bank_at((double)x * bank.spacing, (double)y * bank.spacing), BASE_BITS));
}

static void make(struct ground *ground, const char *name, double spacing, double height, double slope, double direction, double shift)
{
	struct deform_soil soil;
	uint32_t tiles = spacing < 0.2 ? 3 : 2;
	assert_ok(deform_soil_named(name, &soil));
	bank = (struct bank){spacing, tiles * 32 * spacing, height, slope, direction, shift};
	ground_init(ground, &(struct ground_params){.cells = 64, .tiles = tiles, .spacing = spacing, .model = DEFORM_SLIPPAGE,
						    .iterations = 4, .soils = &soil, .soil_count = 1, .height = bank_post, .relief = 100});
}

static void probe(void **state)
{
	(void)state;
	need_gpu();
	const char *names[] = {"dry_sand", "clayey_38", "upland_loam_51"};
	for (int n = 0; n < 3; n++)
	for (double spacing = 1; spacing > 0.1; spacing /= 2)
	for (int over = 0; over < 2; over++)
	for (int dir = 0; dir < 3; dir++) {
		struct ground g;
		struct deform_soil soil;
		assert_ok(deform_soil_named(names[n], &soil));
		double h = reference_culmann(&soil, M_PI / 3) * (over ? 1.25 : 0.8);
		make(&g, names[n], spacing, h, M_PI / 3, dir * M_PI / 8, 0.37);
		assert_ok(deform_wake(g.deform, all_of(&g)));
		size_t b0 = 0, b = 0;
		int i = 0;
		for (; i < 400; i++) {
			b = interval(&g, NULL, 0);
			if (i == 1) b0 = b;
			if (b == 0) break;
		}
		ground_read(&g);
		double most = 0, sum = 0, least=0;
		for (int64_t k = 0; k < g.posts * g.posts; k++) { most = fmax(most, ldexp(g.offset[k], -20)); least = fmin(least, ldexp(g.offset[k], -20));sum += g.offset[k]; }
		printf("%s d %g H %.2f over %d dir %g: blocks %zu then %zu after %d, moved %.3f %.3f m sum %g; ", names[n], spacing, h, over, dir * 22.5, b0, b, i, most, least, sum);
		/* steepest slope over the middle */
		double s = 0; int64_t m = g.posts / 2;
		for (int64_t k = 1; k < g.posts; k++) { double d = ldexp(4.0 * (g.base[m * g.posts + k - 1] - g.base[m * g.posts + k]) + g.offset[m*g.posts+k-1] - g.offset[m*g.posts+k], -20); s = fmax(s, d); }
		printf("steepest %.1f deg\n", atan(s / spacing) * 180 / M_PI);
		ground_finish(&g);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(probe),
	};
	return cmocka_run_group_tests_name("deform/slopes", tests, open_gpu, close_gpu);
}
