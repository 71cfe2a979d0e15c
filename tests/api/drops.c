/* Bodies that a host drops between two steps: they press the ground, the store keeps it, and the next picture shows it. */
#include "guest.h"
#include "render/view.h"
#include "../support/program.h"

static enum status drop_one(struct guest *guest, struct drive *drive, struct drive_control *wish)
{
	wish->go = guest->turns < 3 ? DRIVE_HOLD : DRIVE_STOP;
	return guest->turns == 2 ? drive_drop(drive, WORLD_DROP_FIRST, 150, 120, 0, &guest->pressed) : STATUS_OK;
}

/* Twice between two steps: the second upon what the first left. */
static enum status drop_twice(struct guest *guest, struct drive *drive, struct drive_control *wish)
{
	const struct resident_point point = {150, 120};
	struct resident_height height;
	wish->go = guest->turns < 3 ? DRIVE_HOLD : DRIVE_STOP;
	for (int i = 1; i <= 2 && guest->turns == 2; i++) {
		must(drive_drop(drive, WORLD_DROP_FIRST, point.x, point.y, 0, &guest->pressed));
		assert_int_equal(world_happened(drive->world)->touch_count, 0); /* the view knows: the next drop may have another shape */
		must(drive_heights(drive, &point, 1, &height));
		assert_true(fabs(height.height - (100 - 0.5 * i)) < 1e-4);
	}
	return STATUS_OK;
}

/* From straight above the place: what the colours say of it before a drop and after. */
struct colours {
	struct guest guest;
	int shown, still;
	uint8_t height[3], none[3], deep[3];
};

static enum status colours_turn(void *user, struct drive *drive, struct drive_control *wish)
{
	struct colours *colours = user;
	struct guest *guest = &colours->guest;
	uint8_t *seen[] = {colours->height, colours->none, colours->deep};
	colours->still = guest->pictures == colours->shown ? colours->still + 1 : 0;
	colours->shown = guest->pictures;
	if (colours->still >= 80 && guest->pictures > 0) {
		memcpy(seen[guest->stage++], guest->middle, 3);
		colours->still = 0;
		if (guest->stage == 2)
			must(drive_drop(drive, WORLD_DROP_FIRST, 150, 120, 0, &guest->pressed));
	}
	wish->go = guest->stage == 3 ? DRIVE_STOP : DRIVE_HOLD;
	wish->free = true;
	wish->camera = (struct render_camera){{150, 120, 120}, {150, 120.01, 100}, 0.9, {0}};
	wish->layer = guest->stage == 0 ? RENDER_HEIGHTS : RENDER_OFFSETS;
	return STATUS_OK;
}

static double linear(uint8_t coded)
{
	return coded > 10 ? pow((coded / 255.0 + 0.055) / 1.055, 2.4) : coded / 255.0 / 12.92;
}

/* A legend's colour in the light that falls on level ground, which is the same whatever the colour. */
static void is_colour(const uint8_t seen[3], enum render_layer_kind kind, double t, double *light)
{
	struct chart_colour colour = render_layer_colour(kind, t);
	const uint8_t rgb[3] = {colour.r, colour.g, colour.b};
	if (isnan(*light))
		*light = linear(seen[0]) / linear(rgb[0]);
	for (int c = 0; c < 3; c++)
		assert_true(fabs(linear(seen[c]) - *light * linear(rgb[c])) < 0.012);
}

static enum status drop_outside(struct guest *guest, struct drive *drive, struct drive_control *wish)
{
	wish->go = DRIVE_STOP;
	return drive_drop(drive, WORLD_DROP_FIRST, -20, 120, 0, &guest->pressed);
}

static double quanta_at(const char *store, int64_t x, int64_t y)
{
	double *quanta = support_quanta(store, 0, (struct post_rect){x, y, x + 1, y + 1}), one = quanta[0];
	free(quanta);
	return one;
}

static const char none_text[] =
	"scene: 1\n"
	"time_step: 0.1\n"
	"end_time: 2\n"
	"redistribute: {model: none}\n"
	"objects:\n"
	"  - {name: a, shape: {sphere: {radius: 2.5}}, sink: 0.5, path: {points: [[40, 60], [80, 90]], speed: 20}}\n"
	"view: {size: [64, 36], camera: {chase: a}}\n"
	"cache: {slots: 128}\n";

static void what_is_dropped_is_pressed_as_deep_as_it_sinks_and_kept(void **state)
{
	const char *store = support_path("drop.furrow");
	struct guest guest = {.act = drop_one};
	support_store(store, extent, flat);
	must(watch_drive(store, none_text, &guest, true));
	assert_true(guest.pressed);
	support_verify(store);
	assert_true(fabs(quanta_at(store, 150, 120) / (1 << 20) + 0.5) < 1e-4);
	/* A ball of 2.5 m, a metre aside. */
	assert_true(fabs(quanta_at(store, 151, 120) / (1 << 20) + 0.5 - (2.5 - sqrt(2.5 * 2.5 - 1))) < 1e-3);
	assert_true(quanta_at(store, 153, 120) == 0);
	/* Upon the ground as it is: as deep again. */
	guest = (struct guest){.act = drop_one};
	must(watch_drive(store, none_text, &guest, true));
	assert_true(fabs(quanta_at(store, 150, 120) / (1 << 20) + 1.0) < 1e-4);
	assert_int_equal(guest.step, 0);
	support_store(store, extent, flat);
	guest = (struct guest){.act = drop_twice};
	must(watch_drive(store, none_text, &guest, true));
	assert_true(fabs(quanta_at(store, 150, 120) / (1 << 20) + 1.0) < 1e-4);
}

static const char box_text[] = /* its print is level */
	"scene: 1\n"
	"time_step: 0.1\n"
	"end_time: 2\n"
	"redistribute: {model: none}\n"
	"objects:\n"
	"  - {name: a, shape: {box: {size: [8, 8, 2]}}, sink: 0.5, path: {points: [[40, 60], [80, 90]], speed: 20}}\n"
	"view: {size: [64, 36], camera: {chase: a}}\n"
	"cache: {slots: 128}\n";

static void layers_have_the_colours_of_their_legend(void **state)
{
	const char *store = support_path("colours.furrow");
	struct colours colours = {.guest = {.stage = 0}};
	support_store(store, extent, flat);
	must(drive_with(store, box_text, &(struct drive_host){&colours, colours_turn, on_picture}));
	double light = NAN;
	is_colour(colours.height, RENDER_HEIGHTS, 1, &light); /* 100 m, where all is as high: above its range */
	assert_true(light > 0.5 && light < 1);
	is_colour(colours.none, RENDER_OFFSETS, 0.5, &light);
	is_colour(colours.deep, RENDER_OFFSETS, 0, &light); /* half a metre deep, and that is the range */
}

static void beyond_the_ground_nothing_is_dropped(void **state)
{
	const char *store = support_path("outside.furrow");
	struct guest guest = {.act = drop_outside, .pressed = true};
	support_store(store, extent, flat);
	must(watch_drive(store, none_text, &guest, true));
	assert_false(guest.pressed);
}

/* Deeper than an object of the scene ever is: boxes hold it still. */
static enum status drop_often(struct guest *guest, struct drive *drive, struct drive_control *wish)
{
	const struct resident_point point = {150, 120};
	struct resident_height height;
	wish->go = DRIVE_STOP;
	for (int i = 0; i < 30; i++)
		must(drive_drop(drive, WORLD_DROP_FIRST, point.x, point.y, 0, &guest->pressed));
	must(drive_heights(drive, &point, 1, &height));
	assert_true(height.height < 90);
	must(render_view_update(drive->view));
	assert_true(drive->view->reach >= 100 - height.height);
	return STATUS_OK;
}

static void a_pit_of_many_drops_is_in_its_tiles_box(void **state)
{
	const char *store = support_path("pit.furrow");
	struct guest guest = {.act = drop_often};
	support_store(store, extent, flat);
	must(watch_drive(store, none_text, &guest, true));
	assert_true(guest.pressed);
}

/* Drops while a picture is shown that was asked for, when all had come. */
struct dropper {
	struct guest guest;
	int shown, still;
	bool dropped;
	uint64_t before;
};

static enum status dropper_turn(void *user, struct drive *drive, struct drive_control *wish)
{
	struct dropper *dropper = user;
	dropper->still = dropper->guest.pictures == dropper->shown ? dropper->still + 1 : 0;
	dropper->shown = dropper->guest.pictures;
	bool settled = dropper->still >= 80 && dropper->shown > 0;
	wish->again = settled && !dropper->dropped;
	wish->go = settled && dropper->dropped ? DRIVE_STOP : DRIVE_HOLD;
	wish->free = true;
	wish->camera = (struct render_camera){{150, 120, 110}, {150, 120.01, 100}, 0.9, {0}};
	return STATUS_OK;
}

static enum status dropper_picture(void *user, struct drive *drive, uint8_t *pixels, uint32_t width, uint32_t height)
{
	struct dropper *dropper = user;
	enum status status = on_picture(&dropper->guest, drive, pixels, width, height);
	if (status != STATUS_OK || dropper->dropped || dropper->still < 80)
		return status;
	dropper->dropped = true;
	dropper->before = dropper->guest.hash;
	return drive_drop(drive, WORLD_DROP_FIRST, 150, 120, 0, &dropper->guest.pressed);
}

static void what_is_dropped_while_a_picture_is_shown_is_in_the_next(void **state)
{
	const char *store = support_path("shown.furrow");
	struct dropper dropper = {.guest = {.stage = 0}};
	support_store(store, extent, flat);
	must(drive_with(store, scene_text, &(struct drive_host){&dropper, dropper_turn, dropper_picture}));
	assert_true(dropper.guest.pressed);
	assert_true(dropper.guest.hash != dropper.before);
}

static enum status drop_nowhere(struct guest *guest, struct drive *drive, struct drive_control *wish)
{
	static const double far[] = {NAN, INFINITY, -1e300, 1e18};
	wish->go = DRIVE_STOP;
	for (size_t i = 0; i < sizeof far / sizeof *far; i++) {
		guest->pressed = true;
		must(drive_drop(drive, WORLD_DROP_BALL, far[i], 120, 0, &guest->pressed));
		assert_false(guest->pressed);
	}
	return STATUS_OK;
}

static void what_is_no_place_is_no_ground(void **state)
{
	const char *store = support_path("nowhere.furrow");
	struct guest guest = {.act = drop_nowhere};
	support_store(store, extent, flat);
	must(watch_drive(store, none_text, &guest, true));
	assert_false(guest.pressed);
}

static const char scm_text[] =
	"scene: 1\n"
	"time_step: 0.1\n"
	"end_time: 2\n"
	"soil: {name: dry_sand}\n"
	"redistribute: {model: scm}\n"
	"output: {forces: 20}\n"
	"objects:\n"
	"  - {name: a, shape: {wheel: {radius: 1.5, width: 2}}, load: 20000, path: {points: [[40, 60], [80, 90]], speed: 20}}\n"
	"view: {size: [64, 36], camera: {chase: a}}\n"
	"cache: {slots: 128}\n"
	"spacing: 0.5\n";

static enum status drop_all_shapes(struct guest *guest, struct drive *drive, struct drive_control *wish)
{
	wish->pace = INFINITY;
	/* The drive may make all its steps between two turns, so it waits for both drops. */
	wish->go = guest->stage < 2 ? DRIVE_HOLD : guest->step == 20 ? DRIVE_STOP : DRIVE_ON;
	if (guest->stage >= 2)
		return STATUS_OK;
	int shape = guest->stage++;
	return drive_drop(drive, shape == 0 ? WORLD_DROP_FIRST : WORLD_DROP_BALL, 150 + 20 * shape, 120, 0.3, &guest->pressed);
}

static void under_a_load_the_soil_carries_what_is_dropped(void **state)
{
	const char *store = support_path("scm.furrow");
	struct guest guest = {.act = drop_all_shapes};
	support_store(store, extent, flat);
	must(watch_drive(store, scm_text, &guest, true));
	assert_true(guest.pressed);
	support_verify(store);
	double *wheel = support_quanta(store, -1, (struct post_rect){300, 240, 301, 241});
	double *ball = support_quanta(store, -1, (struct post_rect){340, 240, 341, 241});
	assert_true(wheel[0] < 0 && wheel[0] > -1.5 * (1 << 20));
	assert_true(ball[0] < 0 && ball[0] > -1.5 * (1 << 20));
	free(wheel);
	free(ball);
}

TEST_PROGRAM(drops)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(what_is_dropped_is_pressed_as_deep_as_it_sinks_and_kept),
		cmocka_unit_test(layers_have_the_colours_of_their_legend),
		cmocka_unit_test(beyond_the_ground_nothing_is_dropped),
		cmocka_unit_test(a_pit_of_many_drops_is_in_its_tiles_box),
		cmocka_unit_test(what_is_dropped_while_a_picture_is_shown_is_in_the_next),
		cmocka_unit_test(what_is_no_place_is_no_ground),
		cmocka_unit_test(under_a_load_the_soil_carries_what_is_dropped),
	};
	return cmocka_run_group_tests_name("drops", tests, support_enter, support_leave);
}
