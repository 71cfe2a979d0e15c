/* A blade that is dragged through level ground removes as much as it raises. What is missing is what it compresses where it stands. */
#include <math.h>

#include "hard.h"
#include "../support/program.h"

#define LONG 0.3 /* m: the blade along its way, and across it */
#define WIDE 1.2
#define DEEP 0.05

static double flat(int64_t x, int64_t y)
{
	(void)x, (void)y;
	return 20;
}

/* SI */
static const struct soil_of {
	const char *name;
	double k_c, k_phi, n, elastic;
} soils[] = {{"dry_sand", 0.99e3, 1528.43e3, 1.1, 4e7}, {"lean_clay_22", 16.43e3, 1724.69e3, 0.2, 4e7}};

/* Returns how much soil below the blade springs back when it is taken away, m3. */
static double elastic_of(const struct soil_of *soil)
{
	return (soil->k_c / LONG + soil->k_phi) * pow(DEEP, soil->n) / soil->elastic * LONG * WIDE;
}

static void a_blade_raises_what_it_removes(void **state)
{
	static const double spacings[] = {0.125, 0.0625, 0.03125};
	(void)state;
	for (int i = 0; i < 12; i++) {
		const struct soil_of *soil = &soils[i % 2];
		const double spacing = spacings[i / 2 % 3], heading = i < 6 ? 0 : 0.4, litres = 1e3 * ldexp(spacing * spacing, -OFFSET_BITS);
		char model[200], text[400];
		const char *store = support_path("blade.furrow");
		snprintf(model, sizeof model, "redistribute: {model: scm, bulldozing: 1, slip_sinkage: 1.35}\nsoil: {name: %s}\noutput: {forces: 5}\n", soil->name);
		snprintf(text, sizeof text,
			 "spacing: %g\ntime_step: 0.05\nend_time: 3.5\nobjects:\n"
			 "  - {name: blade, shape: {box: {size: [%g, %g, 0.5]}}, sink: %g, path: {points: [[10.03, 12.02], [%.9g, %.9g]], speed: 1}}\n",
			 spacing, LONG, WIDE, DEEP, 10.03 + 3 * cos(heading), 12.02 + 3 * sin(heading));
		support_store(store, (struct extent){65, 65, 0.5, 32}, flat);
		const struct hard_model scm = {"scm", model, true};
		char *json = hard_drive(&scm, text, store, NULL);
		const long long removed = support_figure(json, "\"quanta\"", "removed"), raised = support_figure(json, "\"quanta\"", "raised");
		const long long net = support_figure(json, "\"quanta\"", "net"), compacted = support_figure(json, "\"quanta\"", "compacted");
		mem_free(json);
		print_message("%s, %g m, heading %g: removes %.2f l, raises %.2f l; it compresses %.2f l below it\n", soil->name, spacing, heading, (double)removed * litres,
			      (double)raised * litres, 1e3 * elastic_of(soil));
		assert_true(net == raised - removed && compacted == -net);
		assert_true(raised <= removed && (double)removed * litres > 50);
		assert_true((double)(removed - raised) * litres < 0.02 * (double)removed * litres + 1.15e3 * elastic_of(soil));
	}
}

TEST_PROGRAM(volume)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_blade_raises_what_it_removes),
	};
	return cmocka_run_group_tests_name("volume", tests, support_enter, support_leave);
}
