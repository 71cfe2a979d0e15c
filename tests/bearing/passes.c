/*
 * Passes of a wheel in one rut, with loose soil on it and soil that passes make denser: each pass sinks the wheel by less than the one before did,
 * and the wheel pulls ever more. Soil that is dense from the first bears as after many passes. No figure here is of a measured second pass: none was found that
 * tells the wheel, its load and the soil (src/deform/VALIDATION.md).
 */
#include "ground.h"
#include "../support/program.h"

#define PASSES 10
#define WAY 0.7  /* m */
#define LOAD 800.0 /* N */
#define SLIP 0.2

static const struct soil_shape wheel = {.kind = SOIL_WHEEL, .radius = 0.25, .width = 0.2};
static const double spacings[] = {0.03125, 0.02, 0.0125};

struct passed {
	double sinkage[PASSES], pull[PASSES]; /* m below the ground as it was; N: means of the second half of the way */
};

static void init(struct ground *ground, const struct soil_numbers *soil, double spacing, double loosening, double hardening)
{
	ground_init(ground, &(struct ground_params){.cells = 128, .tiles = 1, .first = 2, .spacing = spacing, .soils = soil, .bulldozing = 0.5, .slip_sinkage = 1.35, .iterations = 1,
						    .lines = true, .stands = true, .loosening = loosening, .hardening = hardening});
}

/* Each pass goes over the same way, from the same place. */
static struct passed drive(struct ground *ground, double spacing, int passes)
{
	struct passed found = {.sinkage = {0}};
	const int posts = (int)(WAY / spacing);
	for (int pass = 0; pass < passes; pass++) {
		struct deform_contact contact = ground_stand(ground, &wheel, 28.3, 64.4, 0.25);
		int count = 0;
		contact.load = LOAD;
		ground_forces(ground, &contact);
		for (int i = 0; i < posts; i++) {
			ground_go(&contact, spacing, 0, 0);
			contact.turned = spacing / (wheel.radius * (1 - SLIP));
			const struct deform_forces forces = ground_forces(ground, &contact);
			if (i < posts / 2)
				continue;
			found.sinkage[pass] += wheel.radius - lattice_offset_metres(forces.z);
			found.pull[pass] += forces.force[0];
			count++;
		}
		found.sinkage[pass] /= count;
		found.pull[pass] /= count;
	}
	ground_lost_nothing(ground);
	return found;
}

static void tell(const char *what, double spacing, const struct passed *found)
{
	print_message("%s, %g m:", what, spacing);
	for (int i = 0; i < PASSES; i++)
		print_message(" %.1f mm %.0f N", 1e3 * found->sinkage[i], found->pull[i]);
	print_message("\n");
}

static void ten_passes_sink_ever_less_and_pull_ever_more(void **state)
{
	static const char *const names[] = {"dry_sand", "sandy_loam_15"};
	(void)state;
	for (size_t s = 0; s < 2; s++)
		for (size_t p = 0; p < 3; p++) {
			const struct soil_numbers soil = bed_soil(names[s]);
			struct ground ground;
			init(&ground, &soil, spacings[p], 0.67, 1);
			const struct passed found = drive(&ground, spacings[p], PASSES);
			ground_finish(&ground);
			tell(names[s], spacings[p], &found);
			for (int i = 1; i < PASSES; i++) {
				assert_true(found.sinkage[i] > found.sinkage[i - 1] - 1e-5);
				/* The second wheel sinks into loose soil, and in sand it pulls less than the first. */
				assert_true(i == 1 || found.pull[i] > found.pull[i - 1]);
				assert_true(i == 1 || found.sinkage[i] - found.sinkage[i - 1] < found.sinkage[i - 1] - found.sinkage[i - 2] + 2e-4);
			}
			assert_true(found.pull[PASSES - 1] > 1.2 * found.pull[0]);
		}
}

/* Without hardening the same rows fail: the wheel sinks on, and its pull does not grow. */
static void without_hardening_they_sink_on(void **state)
{
	const struct soil_numbers soil = bed_soil("dry_sand");
	struct ground soft, hard;
	(void)state;
	init(&soft, &soil, 0.04, 0.67, 0);
	init(&hard, &soil, 0.04, 0.67, 1);
	const struct passed without = drive(&soft, 0.04, 4), with = drive(&hard, 0.04, 4);
	ground_finish(&soft);
	ground_finish(&hard);
	assert_true(without.sinkage[0] == with.sinkage[0] && without.pull[0] == with.pull[0]);
	assert_true(without.sinkage[3] - without.sinkage[0] > 1.3 * (with.sinkage[3] - with.sinkage[0]));
	assert_true(without.pull[3] < with.pull[3]);
}

/* A strip that is dense before any pass: less sinkage, more pull. At a compaction of 0 the same bits, at 1 what passes come near to. */
static void soil_that_is_dense_from_the_first_sinks_less(void **state)
{
	static const double compactions[] = {0, 0.25, 0.5, 1};
	struct passed found[4];
	(void)state;
	for (int i = 0; i < 4; i++) {
		struct soil_numbers soil = bed_soil("dry_sand");
		struct ground ground;
		soil.compaction = compactions[i];
		init(&ground, &soil, 0.04, 0, 1);
		found[i] = drive(&ground, 0.04, 1);
		ground_finish(&ground);
		print_message("compaction %g: %.2f mm, %.1f N\n", compactions[i], 1e3 * found[i].sinkage[0], found[i].pull[0]);
		assert_true(i == 0 || (found[i].sinkage[0] < 0.97 * found[i - 1].sinkage[0] && found[i].pull[0] > found[i - 1].pull[0]));
	}
	/* k of 2 k at 1. So does soil of those numbers, without hardening. */
	struct soil_numbers twice = bed_soil("dry_sand");
	struct ground ground;
	twice.bekker_kc *= 2;
	twice.bekker_kphi *= 2;
	twice.cohesion *= 2;
	twice.janosi_shear /= 2;
	init(&ground, &twice, 0.04, 0, 0);
	const struct passed same = drive(&ground, 0.04, 1);
	ground_finish(&ground);
	assert_near(found[3].sinkage[0], same.sinkage[0], 1e-4 * same.sinkage[0]);
	assert_near(found[3].pull[0], same.pull[0], 1e-3 * LOAD);
}

TEST_PROGRAM(passes)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(ten_passes_sink_ever_less_and_pull_ever_more),
		cmocka_unit_test(without_hardening_they_sink_on),
		cmocka_unit_test(soil_that_is_dense_from_the_first_sinks_less),
	};
	return cmocka_run_group_tests_name("bearing/passes", tests, NULL, NULL);
}
