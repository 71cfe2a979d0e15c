/*
 * A contact of the models none, box, sumner and slippage on the CPU has the same bits as its passes on the GPU: offsets, contacts, soil that is
 * carried, disturbance, and what is told. On rough ground with holes and the tracks of earlier contacts, far from the origin too.
 */
#include "../long.h"
#include "../support/program.h"
#include "window.h"

/* The models' names here. BOX is the soil model, not the shape. */
static const enum deform_model models[] = {DEFORM_NONE, DEFORM_BOX_FILTER, DEFORM_SUMNER, DEFORM_SLIPPAGE};
#define MODELS ((int)(sizeof models / sizeof *models))

static int32_t rough(int64_t x, int64_t y)
{
	const uint32_t noise = (uint32_t)(x * 7919 + y * 104729) * 2654435761u;
	return (x / 3 + y / 5) % 19 == 0 ? BASE_NODATA : (int32_t)(noise >> 15) - (1 << 16) + (int32_t)(x - y) * 400;
}

/* Every third post is as low as the range of offsets allows a body to press it. */
static int32_t deep(int64_t x, int64_t y)
{
	return (x + y) % 3 == 0 ? (1024 << 18) - 40000 : 0;
}

static struct soil_kinematic kinematic_of(const struct ground *ground)
{
	const struct deform_params *params = &ground->deform->params;
	struct soil_kinematic kinematic = {.spacing = ground->deform->spacing, .reference = params->reference};
	if (params->model == DEFORM_BOX_FILTER) {
		kinematic.radius = params->box_radius;
		kinematic.repetitions = params->box_repetitions;
	} else if (params->model == DEFORM_SUMNER) {
		soil_kinematic_sumner(&kinematic, params->soils, params->soil_count);
	} else if (params->model == DEFORM_SLIPPAGE) {
		soil_kinematic_slippage(&kinematic);
	}
	return kinematic;
}

/* The GPU's contact pass of a model that conserves soil, without laying and sliding. */
static void run_contact_pass(struct ground *ground, const struct deform_contact *contact, const struct deform_window *window)
{
	const struct deform *deform = ground->deform;
	struct {
		struct contact_params contact;
		uint32_t kept[SOIL_CLASSES][4];
	} params = {.contact = deform_contact_params(deform, contact, window, 0)};
	for (int i = 0; i < deform->params.soil_count; i++)
		params.kept[i][0] = (uint32_t)floor(ldexp(1 - deform->params.soils[i].compression, 31));
	assert_ok(deform_run_contact(ground->deform, &params, deform->params.model == DEFORM_SUMNER ? sizeof params : sizeof params.contact, window, 0));
}

static void give_classes(const struct ground *ground, const struct deform_window *window)
{
	uint8_t *classes = ground_room(SIDE * SIDE, 1);
	const struct gpu_rect all = deform_window_rect(window);
	for (int i = 0; i < SIDE * SIDE; i++)
		classes[i] = (uint8_t)(any_word() % 7 == 0 ? any_word() % 256 : any_word() % 3);
	if (ground->deform->classes != NULL)
		gpu_texture_upload(ground->deform->classes, 0, all, classes);
	mem_free(classes);
}

/* Offsets of both signs, to the ends of their range, before the contact. */
static void give_offsets(const struct ground *ground, const struct deform_window *window, double most)
{
	int32_t *offsets = ground_room(SIDE * SIDE, 4), *bases = ground_room(SIDE * SIDE, 4);
	const struct gpu_rect all = deform_window_rect(window);
	gpu_texture_read(ground->deform->bases, 0, all, bases);
	for (uint32_t i = 0; i < all.width * all.height; i++)
		offsets[i] = bases[i] == BASE_NODATA ? 0 : (int32_t)(any_share() * most);
	gpu_texture_upload(ground->deform->planes_of[0][PLANE_OFFSET], 0, all, offsets);
	mem_free(offsets);
	mem_free(bases);
}

/* What the CPU's contacts of a ground have told. */
struct seen {
	struct soil_kinematic_tally tally;
	int64_t lowered, held, near, carried, smoothed;
};

static void count(const struct host_window *window, const int32_t *before, struct seen *seen)
{
	for (size_t i = 0; i < window->posts; i++) {
		seen->lowered += window->planes.contact[i] & SOIL_LOWERED;
		seen->held += (window->planes.contact[i] & SOIL_HELD) != 0;
		seen->near += (window->planes.contact[i] & SOIL_NEAR) != 0;
		seen->carried += window->carried[i] != 0;
		seen->smoothed += window->planes.offset[i] != before[i] && (window->planes.contact[i] & SOIL_LOWERED) == 0;
	}
}

/* One window on both. The results of a model that smooths mean nothing beyond the written posts, and still are the same. most: fixed-point
 * units of other offsets than the ground's; 0: the ground's. */
static void compare_with(struct ground *ground, const struct deform_contact *contact, const struct deform_window *window, double most, struct seen *seen)
{
	struct deform *deform = ground->deform;
	const struct soil_kinematic kinematic = kinematic_of(ground);
	const struct soil_kinematic_contact own = {.shape = contact->shape, .from = contact->from, .to = contact->to, .turned = contact->turned};
	const bool conserves = deform_conserves(deform->params.model);
	struct host_window host;
	deform_gather(deform, window->read, 0, 0, 0, false, deform->planes, ground->tiles, ground->tile_count);
	give_classes(ground, window);
	if (most > 0)
		give_offsets(ground, window, most);
	window_take(ground, window, &host);
	int32_t *before = ground_room((int64_t)host.posts, 4);
	memcpy(before, host.planes.offset, host.posts * 4);
	host.scratch = mem_alloc(1, soil_kinematic_room(&kinematic, &own, host.planes.width, host.posts / host.planes.width));
	assert_non_null(host.scratch);
	memset(host.planes.contact, 255, host.posts);
	soil_kinematic_run(&kinematic, &own, &host.planes, window->write, conserves ? host.carried : NULL, host.scratch, &seen->tally);
	if (conserves) {
		deform_begin_layer(deform, contact, window, 0);
		assert_ok(deform_envelope(deform, contact, window, 0));
		run_contact_pass(ground, contact, window);
		window_compare(&host, "carried", host.carried, deform->carried, 4, window->read);
	} else {
		assert_ok(deform_run_stages(deform, contact, window, 0));
	}
	const int now = deform->scratch[0].now[PLANE_OFFSET];
	window_compare(&host, "offset", host.planes.offset, deform->planes_of[now][PLANE_OFFSET], 4, window->read);
	if (deform_needs_contacts(&deform->params))
		window_compare(&host, "contact", host.planes.contact, deform->contacts, 1, window->read);
	if (deform->params.disturbance && !conserves)
		window_compare(&host, "disturbance", host.planes.disturbance, deform->planes_of[1][PLANE_DISTURBANCE], 1, window->read);
	assert_ok(deform_scatter(deform, window, 0, ground->tiles, ground->tile_count));
	count(&host, before, seen);
	mem_free(before);
	window_drop(&host);
}

static void compare(struct ground *ground, const struct deform_contact *contact, const struct deform_window *window, struct seen *seen)
{
	compare_with(ground, contact, window, 0, seen);
}

static void compare_tally(struct ground *ground, const struct seen *seen)
{
	struct deform_tally tally;
	assert_ok(deform_tally(ground->deform, &tally));
	assert_int_equal(tally.compacted, seen->tally.compacted);
	assert_int_equal(tally.refused, seen->tally.refused);
}

static struct ground_params params_of(int model, int number)
{
	static const double spacings[] = {0.125, 1, 0.0625, 0.1 / 3, 0.4};
	return (struct ground_params){
		.cells = 64, .tiles = 2, .first = number % 2 ? 3 : 2500000, .spacing = spacings[number % 5], .height = rough, .reference = number % 3 * 1024,
		.model = models[model], .radius = 1 + number % 4, .repetitions = 1 + number % 3, .dirt = number % 2 == 0 && models[model] < DEFORM_SUMNER,
	};
}

static void contacts_are_those_of_the_gpu(void **state)
{
	static struct soil_numbers soils[3];
	(void)state;
	need_gpu();
	assert_ok(soil_named("sand", &soils[0]));
	assert_ok(soil_named("snow", &soils[1]));
	assert_ok(soil_named("mud", &soils[2]));
	for (int model = 0; model < MODELS; model++) {
		struct seen all = {.lowered = 0};
		for (int number = 0; number < (long_run() ? 20 : 5); number++) {
			struct ground_params params = params_of(model, number);
			struct ground ground;
			struct seen seen = {.lowered = 0};
			if (params.model == DEFORM_SUMNER) {
				params.soils = soils;
				params.soil_count = number % 2 ? 3 : 1;
			}
			ground_init(&ground, &params);
			for (int i = 0; i < 2 * WINDOW_KINDS; i++) {
				struct window_mesh mesh;
				const int kind = i % WINDOW_KINDS;
				const struct soil_shape shape = window_any_shape(kind, params.spacing * exp2(3 + 1.5 * any_share()), &mesh);
				const double below = -(double)params.reference - 0.3 * soil_shape_reach(&shape, 0, 0) * any_share();
				struct deform_contact contact = window_any_contact(&ground, &shape, kind, i + number, below);
				assert_ok(deform_windows(ground.deform, &contact, ground.windows, &ground.window_count));
				assert_int_equal(ground.window_count, 1);
				/* Where a contact has several windows, only the written posts count. */
				struct deform_window window = ground.windows[0];
				window.write.x0 += i % 3 == 0 ? (window.write.x1 - window.write.x0) / 2 : 0;
				window.write.y1 -= i % 5 == 0 ? (window.write.y1 - window.write.y0) / 2 : 0;
				compare(&ground, &contact, &window, &seen);
			}
			compare_tally(&ground, &seen);
			ground_finish(&ground);
			all.lowered += seen.lowered;
			all.held += seen.held;
			all.near += seen.near;
			all.carried += seen.carried;
			all.smoothed += seen.smoothed;
		}
		print_message("%s: %lld lowered, %lld held, %lld near, %lld carried, %lld smoothed\n", deform_model_row(models[model])->name, (long long)all.lowered,
			      (long long)all.held, (long long)all.near, (long long)all.carried, (long long)all.smoothed);
		assert_true(all.lowered > 1000 && all.held > 1000 && all.near > 1000);
		assert_true((all.carried > 500) == deform_conserves(models[model]) && (all.smoothed > 500) == (models[model] == DEFORM_BOX_FILTER));
	}
}

/* What would leave the range of an offset is refused, and told by the window that writes the post. */
static void what_is_refused_is_told(void **state)
{
	(void)state;
	need_gpu();
	for (int model = 0; model < MODELS; model++) {
		struct ground ground;
		struct seen seen = {.lowered = 0};
		ground_init(&ground, &(struct ground_params){.cells = 64, .tiles = 2, .spacing = 0.25, .height = deep, .model = models[model]});
		const struct soil_shape ball = {.kind = SOIL_SPHERE, .radius = 2};
		for (int i = 0; i < 4; i++) {
			struct deform_contact contact = {.shape = &ball, .from = ground_pose(&ground, 60 + i, 60, 1.9 - 0.1 * i)};
			contact.to = ground_pose(&ground, 61 + i, 60.5, 1.8 - 0.1 * i);
			assert_ok(deform_windows(ground.deform, &contact, ground.windows, &ground.window_count));
			compare(&ground, &contact, &ground.windows[0], &seen);
		}
		compare_tally(&ground, &seen);
		assert_true(seen.tally.refused > 20 && seen.lowered > 20);
		ground_finish(&ground);
	}
}

/* Smoothing of any offsets, also across the world's rim. */
static void any_offsets_are_smoothed(void **state)
{
	struct seen seen = {.lowered = 0};
	(void)state;
	need_gpu();
	for (int round = 0; round < 24; round++) {
		struct ground ground;
		ground_init(&ground, &(struct ground_params){.cells = 32, .tiles = 2, .first = 1, .spacing = 0.125, .height = rough, .model = DEFORM_BOX_FILTER,
							     .radius = 1 + round % 4, .repetitions = 1 + round % 8});
		const struct soil_shape ball = {.kind = SOIL_SPHERE, .radius = 0.7}, wheel = {.kind = SOIL_WHEEL, .radius = 0.4, .width = 0.3};
		const double x = round % 5 == 4 ? 62 : 31 + 3 * any_share(), z = -0.2 + 0.1 * any_share();
		struct deform_contact contact = {.shape = round % 2 ? &ball : &wheel, .from = ground_pose(&ground, x, 30, z), .to = ground_pose(&ground, x + 1, 31, z)};
		contact.to.yaw = any_share() * 4;
		assert_ok(deform_windows(ground.deform, &contact, ground.windows, &ground.window_count));
		compare_with(&ground, &contact, &ground.windows[0], round % 3 == 0 ? 0x1p30 : 0x1p18, &seen);
		ground_finish(&ground);
	}
	assert_true(seen.smoothed > 200);
}

/* Where a body is hardly above the ground that has its shape, or below it, a fixed-point unit decides whether it rests there. */
static void what_hardly_touches(void **state)
{
	int64_t held[2] = {0, 0};
	(void)state;
	need_gpu();
	for (int model = 0; model < MODELS; model++) {
		struct ground ground;
		struct seen seen = {.lowered = 0};
		ground_init(&ground, &(struct ground_params){.cells = 64, .tiles = 2, .spacing = 0.25, .height = rough, .model = models[model], .dirt = model < 2});
		const struct soil_shape ball = {.kind = SOIL_SPHERE, .radius = 2};
		struct deform_contact contact = ground_stand(&ground, &ball, 60, 61, 1.7);
		for (int raised = 0; raised < 10; raised++) {
			const int64_t before = seen.held;
			assert_ok(deform_windows(ground.deform, &contact, ground.windows, &ground.window_count));
			compare(&ground, &contact, &ground.windows[0], &seen);
			held[raised > 5] += seen.held - before;
			contact.from.z += raised > 0;
			contact.to.z = contact.from.z;
		}
		ground_finish(&ground);
	}
	assert_true(held[0] > 200 && held[1] < held[0] / 10);
}

/* The GPU cuts a large contact into windows; the CPU computes it as one. The written posts are the same. */
static void windows_do_not_show(void **state)
{
	(void)state;
	need_gpu();
	for (int number = 0; number < 4; number++) {
		struct ground ground;
		struct soil_kinematic_tally tally = {0, 0};
		ground_init(&ground, &(struct ground_params){.cells = 256, .tiles = 2, .spacing = 0.125, .height = rough,
							     .model = number < 1 ? DEFORM_NONE : DEFORM_BOX_FILTER, .radius = number, .repetitions = 2});
		struct soil_shape shape = {.kind = number % 2 ? SOIL_BOX : SOIL_SPHERE, .radius = 17, .size = {30, 36, 2}};
		const double z = number % 2 ? 0.9 : 14;
		const struct deform_contact contact = {.shape = &shape, .from = ground_pose(&ground, 250, 255, z), .to = ground_pose(&ground, 251, 256, z)};
		const struct soil_kinematic_contact own = {.shape = &shape, .from = contact.from, .to = contact.to};
		const struct soil_kinematic kinematic = kinematic_of(&ground);
		const struct post_rect block = {ground.x0, ground.x0, ground.x0 + ground.posts, ground.x0 + ground.posts};
		struct soil_planes planes = {.rect = block, .width = (size_t)ground.posts, .base = ground.base};
		planes.offset = ground_room(ground.posts * ground.posts, 4);
		planes.contact = ground_room(ground.posts * ground.posts, 1);
		void *scratch = mem_alloc(1, soil_kinematic_room(&kinematic, &own, planes.width, planes.width));
		assert_non_null(scratch);
		soil_kinematic_run(&kinematic, &own, &planes, block, NULL, scratch, &tally);
		ground_sweep(&ground, &contact);
		assert_true(ground.window_count > 1);
		ground_read(&ground);
		int64_t changed = 0;
		for (int64_t i = 0; i < ground.posts * ground.posts; i++) {
			assert_int_equal(ground.offset[i], planes.offset[i]);
			changed += planes.offset[i] != 0;
		}
		assert_true(changed > 10000);
		mem_free(planes.offset);
		mem_free(planes.contact);
		mem_free(scratch);
		ground_finish(&ground);
	}
}

/* An interval marks the posts that a body at rest stands on. */
static void what_a_body_at_rest_holds(void **state)
{
	int64_t held = 0;
	(void)state;
	need_gpu();
	for (int number = 0; number < 2 * WINDOW_KINDS; number++) {
		const int kind = number % WINDOW_KINDS;
		struct ground ground;
		struct window_mesh mesh;
		struct deform_interval size;
		ground_init(&ground, &(struct ground_params){.cells = 64, .tiles = 2, .spacing = 0.125, .height = rough,
							     .model = DEFORM_SLIPPAGE, .iterations = 1, .relief = 100});
		const struct soil_shape shape = window_any_shape(kind, 1.5, &mesh);
		struct deform_contact contact = window_any_contact(&ground, &shape, kind, 4, 0);
		contact.to.yaw = 0.3;
		ground_sweep(&ground, &contact);
		ground_read(&ground);
		contact.to.z += number % 13 - 6; /* hardly above the ground that it pressed, or in it */
		const struct deform_rest rest = {.shape = &shape, .pose = contact.to};
		const struct post_rect block = {ground.x0, ground.x0, ground.x0 + ground.posts, ground.x0 + ground.posts};
		const struct soil_kinematic kinematic = kinematic_of(&ground);
		const struct soil_kinematic_contact own = {.shape = &shape};
		struct soil_planes planes = {.rect = block, .width = (size_t)ground.posts, .base = ground.base, .offset = ground.offset};
		planes.contact = ground_room(ground.posts * ground.posts, 1);
		void *scratch = mem_alloc(1, soil_kinematic_room(&kinematic, &own, planes.width, planes.width));
		assert_non_null(scratch);
		soil_kinematic_hold(&kinematic, &shape, &rest.pose, &planes, scratch);
		assert_ok(deform_wake(ground.deform, (struct post_rect){40, 40, 80, 80}));
		assert_ok(deform_interval_begin(ground.deform, &rest, 1, &size));
		assert_int_equal(size.regions, 1);
		assert_ok(deform_interval_gather(ground.deform, 0, ground.tiles, ground.tile_count));
		const struct post_rect read = deform_interval_reads(ground.deform, 0);
		const uint32_t at = 16 - (uint32_t)deform_slide_rim(ground.deform), width = (uint32_t)(read.x1 - read.x0), height = (uint32_t)(read.y1 - read.y0);
		uint8_t *contacts = ground_room((int64_t)width * height, 1);
		gpu_texture_read(ground.deform->contacts, ground.deform->layers, rect_of(at, at, width, height), contacts);
		for (uint32_t i = 0; i < width * height; i++) {
			const int64_t x = read.x0 + i % width - ground.x0, y = read.y0 + i / width - ground.x0;
			if (contacts[i] == 8 || x < 0 || y < 0 || x >= ground.posts || y >= ground.posts)
				continue; /* its block is not visited */
			assert_int_equal(contacts[i], planes.contact[y * ground.posts + x]);
			held += contacts[i] == SOIL_HELD;
		}
		assert_ok(deform_interval_end(ground.deform));
		mem_free(contacts);
		mem_free(planes.contact);
		mem_free(scratch);
		ground_finish(&ground);
	}
	assert_true(held > 100);
}

TEST_PROGRAM(kinematic)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(contacts_are_those_of_the_gpu),
		cmocka_unit_test(what_is_refused_is_told),
		cmocka_unit_test(any_offsets_are_smoothed),
		cmocka_unit_test(what_hardly_touches),
		cmocka_unit_test(windows_do_not_show),
		cmocka_unit_test(what_a_body_at_rest_holds),
	};
	return cmocka_run_group_tests_name("soil/kinematic", tests, open_gpu, close_gpu);
}
