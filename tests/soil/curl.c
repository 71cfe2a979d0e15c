/* A plate with soil on it pitches. Its edge that rises as it draws in pushes the soil above it inward. Its edge that sinks lets that soil fall. No unit is lost. */
#include <math.h>

#include "../support/program.h"
#include "../support.h"
#include "soil/soil.h"

static const struct soil_shape plate = {.kind = SOIL_BOX, .size = {1, 0.5, 0.02}};

/* Sums soil that falls in the half ahead (side 1) or behind (side -1) of the plate's middle. */
static int64_t falls_of(const struct soil_carried *carried, int side)
{
	int64_t sum = 0;
	for (int row = 0; row < carried->side; row++)
		for (int column = 0; column < carried->side; column++)
			if (side * (column - carried->half) > 0)
				sum += carried->falls[row * carried->side + column];
	return sum;
}

static int64_t amounts_of(const struct soil_carried *carried)
{
	int64_t sum = 0;
	for (int i = 0; i < carried->side * carried->side; i++)
		sum += carried->amounts[i];
	return sum;
}

static void the_edge_that_rises_keeps_its_soil(void **state)
{
	(void)state;
	for (int up = -1; up <= 1; up += 2) {
		struct soil_carried *carried;
		struct soil_pose pose = {.z = lattice_offset(2)};
		assert_int_equal(soil_carried_create(&plate, 0.03125, &carried), STATUS_OK);
		soil_carried_place(carried, &pose);
		for (int64_t y = -10; y <= 10; y++)
			for (int64_t x = -20; x <= 20; x++)
				(void)soil_carried_add(carried, &pose, x, y, (int32_t)lattice_offset(0.05), 0);
		const int64_t total = carried->total;
		assert_true(total > 0 && amounts_of(carried) == total);
		for (int step = 1; step <= 30; step++) {
			pose.pitch = up * step * M_PI / 180;
			soil_carried_place(carried, &pose);
		}
		print_message("pitched by %d degrees: %g %% fell ahead, %g %% behind\n", up * 30, 100 * (double)falls_of(carried, 1) / (double)total, 100 * (double)falls_of(carried, -1) / (double)total);
		assert_int_equal(falls_of(carried, up), 0);
		assert_true(falls_of(carried, -up) > total / 50);
		assert_int_equal(amounts_of(carried) + falls_of(carried, 1) + falls_of(carried, -1), total);
		soil_carried_destroy(carried);
	}
}

TEST_PROGRAM(curl)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(the_edge_that_rises_keeps_its_soil)};
	return cmocka_run_group_tests_name("a plate that pitches", tests, NULL, NULL);
}
