/* A host over whole drives: a held drive makes no step, pictures follow the camera of the host, and a host that only watches
 * changes nothing. */
#include "guest.h"
#include "../support/program.h"

static enum status only_watch(struct guest *guest, struct drive *drive, struct drive_control *wish)
{
	struct drive_figures figures;
	drive_figures(drive, &figures);
	wish->pace = INFINITY;
	wish->go = figures.over ? DRIVE_STOP : DRIVE_ON;
	/* From elsewhere, and in all colours. */
	wish->free = guest->turns % 2 == 0;
	wish->camera = (struct render_camera){{20, 20, 130 + guest->turns % 7}, {60, 70, 100}, 0.9, {0}};
	wish->layer = (enum render_layer_kind)(guest->turns % RENDER_LAYERS);
	/* And asks where the object has been, and will be. */
	const struct resident_point points[] = {{45, 63.75}, {60, 75}, {79, 89}};
	const struct resident_ray down = {{60, 75, 200}, {0, 0, -1}, 200};
	struct resident_height heights[3];
	struct resident_hit hit;
	enum status status = drive_heights(drive, points, 3, heights);
	if (status == STATUS_OK)
		status = drive_rays(drive, &down, 1, &hit);
	assert_true(status != STATUS_OK || (hit.hit && fabs(hit.point[2] - heights[1].height) < 1e-6));
	return status;
}

static void who_only_watches_changes_nothing(void **state)
{
	const char *alone = support_path("alone.furrow"), *watched = support_path("watched.furrow");
	struct guest guest = {.act = only_watch};
	support_store(alone, extent, support_hills);
	support_store(watched, extent, support_hills);
	must(watch_drive(alone, scene_text, &guest, false));
	assert_int_equal(guest.turns, 0);
	must(watch_drive(watched, scene_text, &guest, true));
	assert_int_equal(guest.step, 20);
	assert_true(guest.pictures > 0 && guest.changed);
	support_verify(watched);
	assert_true(support_hash(watched) == support_hash(alone));
	support_store(alone, extent, support_hills);
	assert_true(support_hash(watched) != support_hash(alone));
}

static enum status count_threads(struct guest *guest, struct drive *drive, struct drive_control *wish)
{
	guest->stage = (int)thread_running();
	wish->go = DRIVE_STOP;
	return STATUS_OK;
}

static void who_watches_keeps_no_pictures(void **state)
{
	const char *store = support_path("kept.furrow");
	struct guest without = {.act = count_threads}, with = {.act = count_threads};
	char text[sizeof scene_text + 16];
	snprintf(text, sizeof text, "%s", scene_text);
	char *cache = strstr(text, "cache:");
	snprintf(cache, sizeof text - (size_t)(cache - text), "  images: 1\n%s", strstr(scene_text, "cache:"));
	support_store(store, extent, flat);
	must(watch_drive(store, scene_text, &without, true));
	must(watch_drive(store, text, &with, true));
	assert_true(without.stage > 0);
	assert_int_equal(with.stage, without.stage);
}

static enum status hold_then_one(struct guest *guest, struct drive *drive, struct drive_control *wish)
{
	wish->pace = INFINITY;
	wish->go = DRIVE_HOLD;
	if (guest->turns <= 20)
		assert_int_equal(guest->step, 0);
	else if (guest->turns == 21)
		wish->go = DRIVE_ONE;
	else
		assert_int_equal(guest->step, 1);
	if (guest->turns == 40)
		wish->go = DRIVE_STOP;
	return STATUS_OK;
}

static void what_is_held_does_not_step_and_one_is_one(void **state)
{
	const char *store = support_path("held.furrow");
	struct guest guest = {.act = hold_then_one};
	support_store(store, extent, flat);
	must(watch_drive(store, scene_text, &guest, true));
	assert_int_equal(guest.step, 1);
	assert_int_equal(guest.turns, 40);
}

static enum status at_real_time(struct guest *guest, struct drive *drive, struct drive_control *wish)
{
	static double began;
	if (guest->turns == 1)
		began = clock_seconds();
	/* Never ahead of the clock; how far behind is the machine's. */
	assert_true((double)guest->step * 0.1 <= 4 * (clock_seconds() - began) + 0.2);
	wish->pace = 4;
	wish->go = guest->step == 20 ? DRIVE_STOP : DRIVE_ON;
	return STATUS_OK;
}

static void steps_are_not_ahead_of_their_pace(void **state)
{
	const char *store = support_path("pace.furrow");
	struct guest guest = {.act = at_real_time};
	support_store(store, extent, flat);
	must(watch_drive(store, scene_text, &guest, true));
	assert_int_equal(guest.step, 20);
}

static enum status beyond_the_end(struct guest *guest, struct drive *drive, struct drive_control *wish)
{
	wish->pace = INFINITY;
	wish->go = guest->step == 20 && guest->stage++ == 10 ? DRIVE_STOP : DRIVE_ON;
	return STATUS_OK;
}

static void the_end_of_the_scene_holds(void **state)
{
	const char *store = support_path("end.furrow");
	struct guest guest = {.act = beyond_the_end};
	support_store(store, extent, flat);
	must(watch_drive(store, scene_text, &guest, true));
	assert_int_equal(guest.step, 20);
	assert_int_equal(guest.stage, 11);
}

/* What it looks at next: the scene's camera; another; the first again; a layer; another size. */
struct looks {
	struct guest guest;
	int shown, still; /* pictures; turns since the last of them */
	uint64_t seen[5];
	uint32_t wide[5];
};

static enum status look_turn(void *user, struct drive *drive, struct drive_control *wish)
{
	struct looks *looks = user;
	struct guest *guest = &looks->guest;
	looks->still = guest->pictures == looks->shown ? looks->still + 1 : 0;
	looks->shown = guest->pictures;
	/* Longer than the shortest time between two pictures, and than a load: there is nothing new to draw. */
	if (looks->still >= 80 && guest->pictures > 0) {
		looks->seen[guest->stage] = guest->hash;
		looks->wide[guest->stage++] = guest->width;
		looks->still = 0;
	}
	wish->go = guest->stage == 5 ? DRIVE_STOP : DRIVE_HOLD;
	wish->free = guest->stage == 1;
	wish->camera = (struct render_camera){{20, 20, 130}, {60, 70, 100}, 0.9, {0}};
	wish->layer = guest->stage == 3 ? RENDER_SLOPES : RENDER_NATURAL;
	wish->width = guest->stage == 4 ? 200 : 160;
	wish->height = guest->stage == 4 ? 100 : 90;
	return STATUS_OK;
}

static void the_camera_the_layer_and_the_size_are_the_hosts(void **state)
{
	const char *store = support_path("looks.furrow");
	struct looks looks = {.guest = {.stage = 0}};
	support_store(store, extent, support_hills);
	must(drive_with(store, scene_text, &(struct drive_host){&looks, look_turn, on_picture}));
	assert_true(looks.seen[0] != looks.seen[1]);
	assert_true(looks.seen[2] == looks.seen[0]);
	assert_true(looks.seen[3] != looks.seen[0]);
	assert_int_equal(looks.wide[0], 160);
	assert_int_equal(looks.wide[4], 200);
	assert_int_equal(looks.guest.height, 100);
}

static enum status fail_soon(struct guest *guest, struct drive *drive, struct drive_control *wish)
{
	return guest->turns == 3 ? fail_with(STATUS_FAILED, "host: has enough; let it be") : STATUS_OK;
}

static void a_host_that_fails_ends_the_drive(void **state)
{
	const char *store = support_path("fails.furrow");
	struct guest guest = {.act = fail_soon};
	support_store(store, extent, flat);
	assert_int_equal(watch_drive(store, scene_text, &guest, true), STATUS_FAILED);
	assert_string_equal(failure_message(), "host: has enough; let it be");
	support_verify(store);
}

TEST_PROGRAM(host)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(who_only_watches_changes_nothing),
		cmocka_unit_test(who_watches_keeps_no_pictures),
		cmocka_unit_test(what_is_held_does_not_step_and_one_is_one),
		cmocka_unit_test(steps_are_not_ahead_of_their_pace),
		cmocka_unit_test(the_end_of_the_scene_holds),
		cmocka_unit_test(the_camera_the_layer_and_the_size_are_the_hosts),
		cmocka_unit_test(a_host_that_fails_ends_the_drive),
	};
	return cmocka_run_group_tests_name("host", tests, support_enter, support_leave);
}
