/* What sweeps leave awake: what becomes of the ground is what becomes of it when all of it is worked on. */
#include "late.h"
#include "sliding.h"
#include "../support/program.h"

/* What a sweep leaves awake, by its own flags or all of it: the drive's rules. */
static void sweep_and_wake(struct ground *ground, const struct deform_contact *sweep, const struct soil_pose *left, bool all)
{
	struct deform_contact rest = {.shape = sweep->shape, .from = left != NULL ? *left : sweep->to};
	rest.to = rest.from;
	struct deform_window windows[DEFORM_WINDOWS_MAX];
	size_t count;
	if (left != NULL && (all || !deform_covers(ground->deform, sweep, left))) {
		assert_ok(deform_windows(ground->deform, &rest, windows, &count));
		for (size_t i = 0; i < count; i++)
			assert_ok(deform_wake(ground->deform, windows[i].write));
	}
	ground_sweep(ground, sweep);
	for (size_t i = 0; i < ground->window_count; i++)
		assert_ok(all ? deform_wake(ground->deform, all_of(ground))
			      : deform_wake_swept(ground->deform, &ground->windows[i], (uint32_t)i));
}

struct walker {
	struct soil_shape shape;
	bool stands;
	struct soil_pose last;
};

static struct walker any_walker(const struct ground *ground, int kind)
{
	double d = ground->params.spacing;
	bool large = kind == 3;
	struct walker walker = {.shape.kind = kind % 2 == 0 ? SOIL_WHEEL : kind == 1 ? SOIL_BOX : SOIL_SPHERE};
	walker.shape.radius = large ? 120 * d : (6 + 4 * fabs(any_share())) * d;
	walker.shape.width = 7 * d;
	for (int i = 0; i < 3; i++)
		walker.shape.size[i] = (6 + 8 * fabs(any_share())) * d;
	return walker;
}

/* A post on, mostly; now and then it turns, jumps, or has left the ground. */
static bool any_way(const struct ground *ground, const struct walker *walker, int kind, struct deform_contact *sweep)
{
	double middle = (double)ground->posts / 2, d = ground->params.spacing, x = middle * (1 + any_share());
	double y = middle * (1 + any_share()), z = soil_shape_reach(&walker->shape, 0, 0) - 1.5 * d * any_share() * any_share();
	bool jumps = !walker->stands || any_word() % 16 == 0;
	if (kind == 3)
		z = walker->shape.radius - d * fabs(any_share());
	*sweep = (struct deform_contact){.shape = &walker->shape, .from = walker->last, .to = walker->last, .seconds = 0.01};
	if (jumps) {
		sweep->to = ground_pose(ground, x, y, z);
		sweep->from = sweep->to;
	} else {
		sweep->to.x += lattice_offset(d * any_share());
		sweep->to.y += lattice_offset(d * any_share());
		sweep->to.z += lattice_offset(0.2 * d * any_share());
		if (any_word() % 4 == 0)
			sweep->to.yaw += 0.4 * any_share();
	}
	return any_word() % 10 != 0;
}

static int32_t holed_hills(int64_t x, int64_t y)
{
	return (x * 5 + y * 3) % 31 == 0 || (x / 9 + y / 7) % 17 == 3 ? BASE_NODATA : hills(x, y);
}

static const struct setup walked[] = {
	{DEFORM_SLIPPAGE, 64, 3, 0.0625, 0, 4, hills},       {DEFORM_SUMNER, 64, 3, 0.0625, 0, 4, hills},
	{DEFORM_SLIPPAGE, 32, 9, 0.125, 0.02, 1, holed_hills}, {DEFORM_SUMNER, 32, 9, 0.125, 0, 1, holed_hills},
	{DEFORM_SLIPPAGE, 128, 2, 0.0625, 0.1, 2, hills},    {DEFORM_SUMNER, 16, 8, 0.0625, 0, 2, holed_hills},
};

static void what_a_sweep_lets_sleep_would_not_move(void **state)
{
	(void)state;
	need_gpu();
	for (size_t s = 0; s < sizeof walked / sizeof *walked; s++) {
		struct ground few, all;
		start(&few, &walked[s]);
		start(&all, &walked[s]);
		bool wide = walked[s].cells * walked[s].tiles > 250;
		struct walker walkers[4];
		size_t visited = 0, possible = 0, woken = 0;
		for (int k = 0; k < 4; k++)
			walkers[k] = any_walker(&few, k);
		for (int n = 0; n < 36; n++) {
			struct deform_rest rests[4];
			size_t count = 0;
			for (int i = 0; i < 3 && n < 30; i++) {
				int k = any_word() % 32 == 0 && wide ? 3 : (int)(any_word() % 3);
				struct walker *walker = &walkers[k];
				struct deform_contact sweep;
				bool stays = any_way(&few, walker, k, &sweep);
				sweep_and_wake(&few, &sweep, walker->stands ? &walker->last : NULL, false);
				sweep_and_wake(&all, &sweep, walker->stands ? &walker->last : NULL, true);
				walker->last = sweep.to;
				walker->stands = stays;
				if (stays)
					continue;
				const struct deform_contact rest = {.shape = &walker->shape, .from = sweep.to, .to = sweep.to};
				assert_ok(deform_windows(few.deform, &rest, few.windows, &few.window_count));
				for (size_t w = 0; w < few.window_count; w++)
					assert_ok(deform_wake(few.deform, few.windows[w].write));
			}
			for (int k = 0; k < 4; k++)
				if (walkers[k].stands)
					rests[count++] = (struct deform_rest){.shape = &walkers[k].shape, .pose = walkers[k].last};
			const struct soil_block *blocks;
			size_t awake;
			assert_ok(deform_active_blocks(few.deform, &blocks, &awake));
			woken += awake;
			/* Of odd ones flags come late. */
			late_by = s % 2;
			visited += interval(&few, rests, count);
			late_by = 0;
			late_pass();
			assert_ok(deform_wake(all.deform, all_of(&all)));
			possible += interval(&all, rests, count);
			assert_same(&few, &all, n);
		}
		/* Before their flags come all that sweeps wrote is awake. */
		assert_true((s % 2 == 1 ? visited <= woken : visited < woken) && visited < possible / 2);
		ground_finish(&few);
		ground_finish(&all);
	}
}

static void a_settled_rut_wakes_nothing(void **state)
{
	static const enum deform_model models[] = {DEFORM_SLIPPAGE, DEFORM_SUMNER};
	(void)state;
	need_gpu();
	for (int m = 0; m < 2; m++) {
		struct ground ground;
		start(&ground, &(struct setup){models[m], 64, 3, 0.0625, 0, 4, NULL});
		/* Shallower than what stands, beside the corner of four tiles; then on, four posts. */
		struct soil_shape plate = {.kind = SOIL_BOX, .size = {1.6, 1.2, 0.5}};
		struct deform_contact sweep = {.shape = &plate, .from = ground_pose(&ground, 70, 60, 0.249)};
		sweep.to = sweep.from;
		for (int n = 0; n < 4; n++) {
			const struct soil_pose left = sweep.to;
			sweep_and_wake(&ground, &sweep, n > 0 ? &left : NULL, false);
			sweep.from = sweep.to;
			sweep.to.x += lattice_offset(0.0625);
		}
		const struct soil_block *blocks;
		size_t awake;
		assert_ok(deform_active_blocks(ground.deform, &blocks, &awake));
		assert_true(awake >= 4);
		ground_read(&ground);
		size_t pressed = 0;
		for (int64_t i = 0; i < ground.posts * ground.posts; i++)
			pressed += ground.offset[i] < 0;
		assert_true(pressed > 400);
		struct gpu_stats before, after;
		gpu_stats(test_gpu, &before);
		const struct deform_rest rest = {.shape = &plate, .pose = sweep.from};
		assert_int_equal(interval(&ground, &rest, 1), 0);
		assert_int_equal(interval(&ground, NULL, 0), 0);
		gpu_stats(test_gpu, &after);
		assert_memory_equal(before.passes, after.passes, sizeof before.passes);
		/* One that does not stand. */
		sweep.to.z = sweep.from.z -= lattice_offset(0.2);
		sweep_and_wake(&ground, &sweep, NULL, false);
		assert_true(interval(&ground, NULL, 0) > 0);
		ground_finish(&ground);
	}
}

/* A plate that stood in a pit is lifted. It touches nothing then, but the walls no longer stand. */
static void soil_slides_to_where_an_object_was(void **state)
{
	static const enum deform_model models[] = {DEFORM_SLIPPAGE, DEFORM_SUMNER};
	(void)state;
	need_gpu();
	for (int m = 0; m < 2; m++) {
		struct ground few, all;
		const struct setup setup = {models[m], 64, 3, 0.0625, 1, 1, NULL};
		start(&few, &setup);
		start(&all, &setup);
		struct soil_shape plate = {.kind = SOIL_BOX, .size = {0.8, 0.6, 0.5}};
		struct deform_contact sweep = {.shape = &plate, .from = ground_pose(&few, 70, 60, -0.05)};
		sweep.to = sweep.from;
		const struct deform_rest rest = {.shape = &plate, .pose = sweep.to};
		sweep_and_wake(&few, &sweep, NULL, false);
		sweep_and_wake(&all, &sweep, NULL, true);
		int n = 0;
		while (interval(&few, &rest, 1) > 0 && n++ < 2000)
			interval(&all, &rest, 1);
		assert_true(n < 2000);
		sweep.to.z += lattice_offset(0.4);
		sweep_and_wake(&few, &sweep, &rest.pose, false);
		sweep_and_wake(&all, &sweep, &rest.pose, true);
		assert_true(interval(&few, NULL, 0) > 0);
		interval(&all, NULL, 0);
		assert_same(&few, &all, n);
		int32_t before = few.offset[60 * few.posts + 70 + 6];
		for (int k = 0; k < 60; k++) {
			interval(&few, NULL, 0);
			interval(&all, NULL, 0);
		}
		assert_same(&few, &all, n);
		assert_true(few.offset[60 * few.posts + 70 + 6] > before + 1000);
		ground_finish(&few);
		ground_finish(&all);
	}
}

/* Holes, but for what is under a plate, and a lane of two posts that ends at the rim of those in which soil can slide. The plate just
 * touches, so nothing is laid. So only what was there before comes to the rim: a wall on the lane's first post, which an earlier drive left
 * asleep. Beyond the rim the ground lies `beyond` lower. Base lattice. */
static struct {
	struct post_rect write;
	int64_t lane;
	int32_t beyond;
} rim;

static int32_t to_the_rim(int64_t x, int64_t y)
{
	bool inside = x >= rim.write.x0 && x < rim.write.x1 && y >= rim.write.y0 && y < rim.write.y1;
	if (x >= rim.write.x1)
		return -rim.beyond;
	if (!inside || (y == rim.lane && x >= rim.write.x1 - 2))
		return 0;
	return llabs(x - 60) < 6 && llabs(y - 60) < 4 ? 0 : BASE_NODATA;
}

/* What slid from the lane's first post, `wall` high, in a sweep; and whether an interval knows of what the sweep could not look at. */
static int32_t slid_after(enum deform_model model, int32_t wall, int32_t beyond, bool *goes_on)
{
	struct ground ground;
	struct setup setup = {model, 64, 2, 0.0625, 0, 8, to_the_rim};
	struct soil_shape plate = {.kind = SOIL_BOX, .size = {0.8, 0.5, 0.5}};
	rim.beyond = beyond;
	start(&ground, &setup);
	int32_t *before = ground_room(65 * 65, sizeof *before);
	for (uint32_t k = 0; k < ground.tile_count; k++) {
		int64_t x = rim.write.x1 - 2 - k % 2 * 64, y = rim.lane - k / 2 * 64;
		bool here = x >= 0 && y >= 0 && x <= 64 && y <= 64;
		if (here)
			before[y * 65 + x] = wall;
		assert_ok(gpu_slots_deform(ground.slots, k));
		const void *planes[PLANES] = {[PLANE_OFFSET] = before};
		assert_ok(staged_upload_planes(test_gpu, ground.slots, 64, k, planes));
		if (here)
			before[y * 65 + x] = 0;
	}
	mem_free(before);
	struct deform_contact sweep = {.shape = &plate, .from = ground_pose(&ground, 60, 60, 0.25)};
	sweep.to = sweep.from;
	assert_ok(deform_windows(ground.deform, &sweep, ground.windows, &ground.window_count));
	sweep_and_wake(&ground, &sweep, NULL, false);
	ground_read(&ground);
	struct post_rect slides = ground_slides(&ground);
	/* At first no rim is known. */
	int64_t next = post_rect_empty(rim.write) ? 2 : rim.lane * ground.posts + rim.write.x1;
	int32_t left = ground.offset[next - 2];
	interval(&ground, NULL, 0);
	ground_read(&ground);
	*goes_on = ground.offset[next] != 0;
	ground_finish(&ground);
	rim.write = slides;
	rim.lane = (slides.y0 + slides.y1) / 2;
	return wall - left;
}

static void what_comes_to_the_rim_goes_on(void **state)
{
	bool goes_on;
	(void)state;
	need_gpu();
	memset(&rim, 0, sizeof rim);
	for (int m = 0; m < 2; m++) {
		const enum deform_model model = m == 0 ? DEFORM_SLIPPAGE : DEFORM_SUMNER;
		const int32_t stands = (int32_t)ldexp(tan(M_PI / 180 * 28) * 0.0625, OFFSET_BITS);
		for (int twice = 0; twice < 2; twice++)
			slid_after(model, 0, 0, &goes_on); /* finds the posts that can slide; then they are some of those with ground */
		assert_true(slid_after(model, 4 * stands, 0, &goes_on) > stands / 2 && goes_on);
	}
	/* It slid there by a few quanta, stopped, and was the last straw. */
	int32_t stands = 0;
	for (int32_t step = 1 << 16; step > 0; step /= 2)
		while (slid_after(DEFORM_SLIPPAGE, stands + step, 0, &goes_on) == 0)
			stands += step;
	assert_true(slid_after(DEFORM_SLIPPAGE, stands, 0, &goes_on) == 0 && !goes_on);
	int32_t slid = slid_after(DEFORM_SLIPPAGE, stands + 8, stands / 4, &goes_on);
	assert_true(slid > 0 && slid < 12 && goes_on);
}

static bool is_awake(struct ground *ground, int64_t x, int64_t y)
{
	const struct soil_block *blocks;
	size_t count;
	bool found = false;
	assert_ok(deform_active_blocks(ground->deform, &blocks, &count));
	for (size_t i = 0; i < count; i++)
		found = found || (blocks[i].x == x / SOIL_BLOCK && blocks[i].y == y / SOIL_BLOCK);
	return found;
}

/* Between two intervals nobody asks for a sweep's flags: until then, and in a commit, all that it wrote is awake. */
static void what_is_not_known_to_sleep_is_awake(void **state)
{
	struct ground ground;
	(void)state;
	need_gpu();
	start(&ground, &(struct setup){DEFORM_SLIPPAGE, 64, 4, 0.0625, 0, 4, NULL});
	disturb(&ground, 50, 50, 0.9);
	late_by = LATE_UNTIL_WAITED;
	assert_true(interval(&ground, NULL, 0) > 0);
	late_by = 0;
	struct soil_shape plate = {.kind = SOIL_BOX, .size = {1.2, 0.8, 0.5}};
	struct deform_contact sweep = {.shape = &plate, .from = ground_pose(&ground, 200, 200, 0.249)};
	sweep.to = sweep.from;
	sweep_and_wake(&ground, &sweep, NULL, false);
	assert_true(is_awake(&ground, 200, 200));
	gpu_finish(test_gpu); /* the interval's flags are here */
	assert_true(is_awake(&ground, 200, 200) && is_awake(&ground, 50, 50));
	assert_true(interval(&ground, NULL, 0) > 0);
	assert_true(!is_awake(&ground, 200, 200));
	ground_finish(&ground);
}

/* More sweeps between two intervals than there is room for their flags. */
static void many_sweeps_are_as_right(void **state)
{
	struct ground few, all;
	struct setup setup = {DEFORM_SLIPPAGE, 64, 3, 0.0625, 0, 1, hills};
	(void)state;
	need_gpu();
	start(&few, &setup);
	start(&all, &setup);
	struct soil_shape ball = {.kind = SOIL_SPHERE, .radius = 5.5};
	for (int n = 0; n < 500; n++) {
		struct deform_contact sweep = {.shape = &ball, .from = ground_pose(&few, 96 + n % 7, 96 - n % 5, 5.1 - n % 3 * 0.02)};
		sweep.to = sweep.from;
		sweep_and_wake(&few, &sweep, NULL, false);
		sweep_and_wake(&all, &sweep, NULL, true);
	}
	for (int n = 0; n < 3; n++) {
		interval(&few, NULL, 0);
		assert_ok(deform_wake(all.deform, all_of(&all)));
		interval(&all, NULL, 0);
		assert_same(&few, &all, n);
	}
	ground_finish(&few);
	ground_finish(&all);
}

TEST_PROGRAM(swept)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(what_a_sweep_lets_sleep_would_not_move),
		cmocka_unit_test(a_settled_rut_wakes_nothing),
		cmocka_unit_test(soil_slides_to_where_an_object_was),
		cmocka_unit_test(what_comes_to_the_rim_goes_on),
		cmocka_unit_test(what_is_not_known_to_sleep_is_awake),
		cmocka_unit_test(many_sweeps_are_as_right),
	};
	return cmocka_run_group_tests_name("deform/swept", tests, open_gpu, close_gpu);
}
