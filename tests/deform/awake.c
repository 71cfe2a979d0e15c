/* Awake blocks: what becomes of the ground is what becomes of it when all of it is worked on. */
#include "conserve.h"

struct setup {
	enum deform_model model;
	uint32_t cells, tiles;
	double spacing, depth;
	int iterations;
	ground_height height;
};

static int32_t hills(int64_t x, int64_t y)
{
	return (int32_t)(lrint(30000 * sin((double)x * 0.21) * cos((double)y * 0.17))) + conserve_rough(x, y) / 64; /* it stands */
}

static void start(struct ground *ground, const struct setup *setup)
{
	struct deform_soil soil;
	assert_ok(deform_soil_named("sand", &soil));
	soil.cohesion = 0;
	soil.theta_stop = soil.theta_out + 0.1;
	ground_init(ground, &(struct ground_params){.cells = setup->cells, .tiles = setup->tiles, .spacing = setup->spacing,
						    .model = setup->model, .iterations = setup->iterations, .soils = &soil,
						    .soil_count = 1, .depth = setup->depth, .height = setup->height,
						    /* A world known to be low has the narrower rim. */
						    .relief = setup->iterations == 1 || setup->cells == 64 ? 100 : 0,
						    .bulldozing = 0.5});
}

/* A mound and a pit across the corners of tiles and blocks, and the ground awake there. */
static struct post_rect disturb(struct ground *ground, int64_t x, int64_t y, double height)
{
	struct deform_shape ball = {.kind = DEFORM_SPHERE, .radius = 6 * ground->params.spacing};
	double z = ldexp(ground->base[y * ground->posts + x], -BASE_BITS) + ball.radius - height;
	struct deform_sweep sweep = {.shape = &ball, .from = ground_pose(ground, (double)x, (double)y, z)};
	sweep.to = sweep.from;
	ground_sweep(ground, &sweep);
	for (size_t i = 0; i < ground->window_count; i++)
		assert_ok(deform_wake_swept(ground->deform, &ground->windows[i], (uint32_t)i));
	return ground->windows[0].write;
}

static size_t interval(struct ground *ground, const struct deform_rest *objects, size_t count)
{
	size_t blocks;
	assert_ok(deform_interval_begin(ground->deform, objects, count, &blocks));
	for (size_t i = 0; i < blocks; i++)
		assert_ok(deform_interval_gather(ground->deform, i, ground->tiles, ground->tile_count));
	for (size_t i = 0; i < blocks; i++)
		assert_ok(deform_interval_scatter(ground->deform, i, ground->tiles, ground->tile_count));
	if (blocks > 0)
		assert_ok(deform_interval_end(ground->deform));
	return blocks;
}

static struct post_rect all_of(const struct ground *ground)
{
	return (struct post_rect){0, 0, ground->posts, ground->posts};
}

/* The whole block of ground as one window. */
static void whole(struct ground *ground)
{
	struct deform *deform = ground->deform;
	struct post_rect all = all_of(ground);
	struct deform_window window = {{-1, -1, all.x1 + 1, all.y1 + 1}, all};
	struct gpu_rect rect = rect_of(0, 0, (uint32_t)all.x1 + 2, (uint32_t)all.y1 + 2);
	deform_gather(deform, window.read, 0, 0, 0, true, PLANE_BIT(PLANE_OFFSET), ground->tiles, ground->tile_count);
	gpu_texture_clear(deform->contacts, 0, rect, 0);
	gpu_texture_clear(deform->deposits, 0, rect, 0);
	deform->scratch[0].now[PLANE_OFFSET] = 1;
	assert_ok(deform_slide(deform, &window, 0));
	assert_ok(deform_scatter(deform, &window, 0, ground->tiles, ground->tile_count));
}

static void assert_same(struct ground *a, struct ground *b, int n)
{
	ground_read(a);
	ground_read(b);
	for (int64_t i = 0; i < a->posts * a->posts; i++)
		if (a->offset[i] != b->offset[i])
			fail_msg("interval %d, post %lld, %lld: %d, not %d", n, (long long)(i % a->posts), (long long)(i / a->posts),
				 a->offset[i], b->offset[i]);
}

static const struct setup setups[] = {
	{DEFORM_SLIPPAGE, 64, 3, 0.0625, 0, 4, hills}, {DEFORM_SUMNER, 64, 3, 0.0625, 0, 4, hills},
	{DEFORM_SLIPPAGE, 32, 4, 0.125, 0.02, 8, hills}, {DEFORM_SUMNER, 16, 7, 0.125, 0, 8, hills},
	{DEFORM_SLIPPAGE, 8, 14, 0.25, 0, 1, conserve_holed}, {DEFORM_SUMNER, 128, 1, 0.25, 0, 1, conserve_holed},
};

static void few_blocks_do_what_all_would(void **state)
{
	(void)state;
	need_gpu();
	for (size_t s = 0; s < sizeof setups / sizeof *setups; s++) {
		struct ground few, all, one;
		start(&few, &setups[s]);
		start(&all, &setups[s]);
		start(&one, &setups[s]);
		struct ground *grounds[] = {&few, &all, &one};
		size_t visited = 0, possible = 0;
		int64_t side = few.posts, n = 0, still = 0;
		for (; n < 900 && still < 2; n++) {
			/* Now and then something happens, near corners of blocks and at the edge of the world. */
			if (n % 40 == 0 && n < 120)
				for (int k = 0; k < 3; k++)
					disturb(grounds[k], n == 0 ? 64 : n == 40 ? 3 : side / 2, n == 80 ? side - 4 : 60, n == 80 ? 0.4 : 0.9);
			size_t blocks = interval(&few, NULL, 0);
			visited += blocks;
			still += blocks == 0 && n > 120;
			assert_ok(deform_wake(all.deform, all_of(&all)));
			possible += interval(&all, NULL, 0);
			whole(&one);
			if (n % 32 == 0 || still > 0) {
				assert_same(&few, &one, (int)n);
				assert_same(&all, &one, (int)n);
			}
		}
		/* It came to rest, and cost less on the way. */
		assert_true(still == 2 && visited > 0 && visited < possible / 2);
		struct deform_tally tally;
		assert_ok(deform_tally(few.deform, &tally));
		assert_true(conserve_sum(&few) == -tally.compacted);
		for (int k = 0; k < 3; k++)
			ground_finish(grounds[k]);
	}
}

static void more_blocks_than_a_layer_holds_are_as_right(void **state)
{
	struct ground few, all;
	struct setup setup = {DEFORM_SLIPPAGE, 64, 5, 0.0625, 0, 4, hills};
	(void)state;
	need_gpu();
	start(&few, &setup);
	start(&all, &setup);
	for (int k = 0; k < 4; k++) {
		disturb(&few, k % 2 * 250 + 40, k / 2 * 250 + 40, 0.9);
		disturb(&all, k % 2 * 250 + 40, k / 2 * 250 + 40, 0.9);
	}
	for (int n = 0; n < 6; n++) {
		size_t blocks = interval(&few, NULL, 0);
		assert_true(blocks > 0 && blocks < 64);
		assert_ok(deform_wake(all.deform, all_of(&all)));
		assert_int_equal(interval(&all, NULL, 0), 121);
	}
	assert_same(&few, &all, 6);
	ground_finish(&few);
	ground_finish(&all);
}

/* Flags that come late keep more awake, and change nothing. */
static void flags_that_come_late_change_nothing(void **state)
{
	(void)state;
	need_gpu();
	for (int s = 0; s < 2; s++) {
		struct ground prompt, late;
		start(&prompt, &setups[s]);
		start(&late, &setups[s]);
		disturb(&prompt, 96, 96, 0.9);
		disturb(&late, 96, 96, 0.9);
		bool software = test_gpu->info.software;
		size_t most = 0;
		for (int n = 0; n < 60; n++) {
			if (n == 7) {
				disturb(&prompt, 100, 40, 0.5);
				disturb(&late, 100, 40, 0.5);
			}
			interval(&prompt, NULL, 0);
			/* A fence for each: as on hardware. */
			test_gpu->info.software = false;
			size_t blocks = interval(&late, NULL, 0);
			most = blocks > most ? blocks : most;
			test_gpu->info.software = software;
		}
		assert_same(&prompt, &late, 60);
		assert_true(most > 4);
		ground_finish(&prompt);
		ground_finish(&late);
	}
}

static void what_an_object_rests_on_is_held(void **state)
{
	static const enum deform_model models[] = {DEFORM_SLIPPAGE, DEFORM_SUMNER};
	(void)state;
	need_gpu();
	for (int m = 0; m < 2; m++) {
		struct ground few, all;
		struct setup setup = {models[m], 64, 3, 0.0625, 0, 4, hills};
		start(&few, &setup);
		start(&all, &setup);
		struct ground *grounds[] = {&few, &all};
		struct deform_shape box = {.kind = DEFORM_BOX, .size = {1.4, 0.9, 4}}, ball = {.kind = DEFORM_SPHERE, .radius = 0.5};
		struct deform_sweep sweep = {.shape = &box, .from = ground_pose(&few, 64.3, 63.8, 1.4)};
		sweep.from.yaw = 0.5;
		sweep.to = sweep.from;
		struct deform_rest rests[] = {{.shape = &ball, .pose = ground_pose(&few, 150, 20, 0.4)}, {.shape = &box, .pose = sweep.to}};
		for (int k = 0; k < 2; k++) {
			ground_sweep(grounds[k], &sweep);
			assert_ok(deform_wake(grounds[k]->deform, grounds[k]->windows[0].write));
		}
		uint8_t *contacts = ground_contacts(&few);
		ground_read(&few);
		int32_t *before = ground_room(few.posts * few.posts, sizeof *before);
		memcpy(before, few.offset, (size_t)(few.posts * few.posts) * sizeof *before);
		size_t passes = 0, awake = 0;
		for (int n = 0; n < 500 && (n < 10 || awake); n++) {
			awake = interval(&few, rests, 2);
			passes += awake;
			assert_ok(deform_wake(all.deform, all_of(&all)));
			interval(&all, rests, 2);
		}
		assert_same(&few, &all, 500);
		size_t held = 0, moved = 0, in_the_hole = 0;
		for (int64_t i = 0; i < few.posts * few.posts; i++) {
			bool rests_here = (contacts[i] & REFERENCE_HELD) != 0;
			held += rests_here;
			moved += few.offset[i] != before[i];
			in_the_hole += rests_here && few.offset[i] != before[i];
		}
		assert_true(held > 150 && moved > 100 && passes > 8);
		if (models[m] == DEFORM_SLIPPAGE)
			assert_int_equal(in_the_hole, 0);
		/* It rests; the ground too, until what held it is gone. */
		assert_int_equal(interval(&few, rests, 2), 0);
		assert_ok(deform_wake(few.deform, few.windows[0].write));
		assert_true(interval(&few, rests, 1) > 0);
		ground_read(&few);
		in_the_hole = 0;
		for (int64_t i = 0; i < few.posts * few.posts; i++)
			in_the_hole += (contacts[i] & REFERENCE_HELD) != 0 && few.offset[i] != before[i];
		assert_true(in_the_hole > 0);
		mem_free(before);
		mem_free(contacts);
		ground_finish(&few);
		ground_finish(&all);
	}
}

/* What a sweep leaves awake, by its own flags or all of it: the drive's rules. */
static void sweep_and_wake(struct ground *ground, const struct deform_sweep *sweep, const struct deform_pose *left, bool all)
{
	struct deform_sweep rest = {.shape = sweep->shape, .from = left != NULL ? *left : sweep->to};
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
	struct deform_shape shape;
	double load;
	bool stands;
	struct deform_pose last;
};

static struct walker any_walker(const struct ground *ground, int kind)
{
	double d = ground->params.spacing;
	bool large = kind == 3;
	struct walker walker = {.shape.kind = kind % 2 == 0 ? DEFORM_WHEEL : kind == 1 ? DEFORM_BOX : DEFORM_SPHERE};
	walker.shape.radius = large ? 120 * d : (6 + 4 * fabs(any_share())) * d;
	walker.shape.width = 7 * d;
	for (int i = 0; i < 3; i++)
		walker.shape.size[i] = (6 + 8 * fabs(any_share())) * d;
	walker.load = ground->params.model == DEFORM_SCM && kind == 2 ? 4e5 * d * d : 0;
	return walker;
}

/* A post on, mostly; now and then it turns, jumps, or has left the ground. */
static bool any_way(const struct ground *ground, const struct walker *walker, int kind, struct deform_sweep *sweep)
{
	double middle = (double)ground->posts / 2, d = ground->params.spacing, x = middle * (1 + any_share());
	double y = middle * (1 + any_share()), z = deform_shape_reach(&walker->shape, 0, 0) - 1.5 * d * any_share() * any_share();
	bool jumps = !walker->stands || any_word() % 16 == 0;
	if (kind == 3)
		z = walker->shape.radius - d * fabs(any_share());
	*sweep = (struct deform_sweep){.shape = &walker->shape, .from = walker->last, .to = walker->last, .seconds = 0.01,
				       .load = walker->load};
	if (jumps) {
		sweep->to = ground_pose(ground, x, y, z);
		sweep->from = sweep->to;
	} else {
		sweep->to.x += lattice_offset(d * any_share());
		sweep->to.y += lattice_offset(d * any_share());
		sweep->to.z += walker->load > 0 ? 0 : lattice_offset(0.2 * d * any_share());
		if (any_word() % 4 == 0)
			sweep->to.yaw += 0.4 * any_share();
		if (walker->load > 0)
			sweep->from.z = sweep->to.z;
	}
	return any_word() % 10 != 0;
}

static int32_t holed_hills(int64_t x, int64_t y)
{
	return (x * 5 + y * 3) % 31 == 0 || (x / 9 + y / 7) % 17 == 3 ? BASE_NODATA : hills(x, y);
}

static const struct setup walked[] = {
	{DEFORM_SLIPPAGE, 64, 3, 0.0625, 0, 4, hills},       {DEFORM_SUMNER, 64, 3, 0.0625, 0, 4, hills},
	{DEFORM_SCM, 64, 3, 0.0625, 0, 4, hills},            {DEFORM_SLIPPAGE, 32, 9, 0.125, 0.02, 1, holed_hills},
	{DEFORM_SUMNER, 32, 9, 0.125, 0, 1, holed_hills},    {DEFORM_SCM, 32, 9, 0.125, 0.1, 2, hills},
	{DEFORM_SUMNER, 16, 8, 0.0625, 0, 2, holed_hills},   {DEFORM_SCM, 128, 1, 0.0625, 0, 1, holed_hills},
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
				struct deform_sweep sweep;
				bool stays = any_way(&few, walker, k, &sweep);
				sweep_and_wake(&few, &sweep, walker->stands ? &walker->last : NULL, false);
				sweep_and_wake(&all, &sweep, walker->stands ? &walker->last : NULL, true);
				walker->last = sweep.to;
				walker->stands = stays;
				if (stays)
					continue;
				const struct deform_sweep rest = {.shape = &walker->shape, .from = sweep.to, .to = sweep.to};
				assert_ok(deform_windows(few.deform, &rest, few.windows, &few.window_count));
				for (size_t w = 0; w < few.window_count; w++)
					assert_ok(deform_wake(few.deform, few.windows[w].write));
			}
			for (int k = 0; k < 4; k++)
				if (walkers[k].stands)
					rests[count++] = (struct deform_rest){.shape = &walkers[k].shape, .pose = walkers[k].last};
			const struct deform_block *blocks;
			size_t awake;
			assert_ok(deform_awake(few.deform, &blocks, &awake));
			woken += awake;
			/* Odd ones: a fence for each, as on hardware. */
			bool software = test_gpu->info.software;
			test_gpu->info.software = software && s % 2 == 0;
			visited += interval(&few, rests, count);
			test_gpu->info.software = software;
			assert_ok(deform_wake(all.deform, all_of(&all)));
			possible += interval(&all, rests, count);
			assert_same(&few, &all, n);
		}
		if (few.params.model == DEFORM_SCM) {
			int32_t *a = ground_plane(&few, PLANE_HEAPED), *b = ground_plane(&all, PLANE_HEAPED);
			assert_memory_equal(a, b, (size_t)(few.posts * few.posts) * sizeof *a);
			mem_free(a);
			mem_free(b);
		}
		assert_true(visited < woken && visited < possible / 2);
		ground_finish(&few);
		ground_finish(&all);
	}
}

static void a_settled_rut_wakes_nothing(void **state)
{
	static const enum deform_model models[] = {DEFORM_SLIPPAGE, DEFORM_SUMNER, DEFORM_SCM};
	(void)state;
	need_gpu();
	for (int m = 0; m < 3; m++) {
		struct ground ground;
		start(&ground, &(struct setup){models[m], 64, 3, 0.0625, 0, 4, NULL});
		/* Shallower than what stands, beside the corner of four tiles; then on, four posts. */
		struct deform_shape plate = {.kind = DEFORM_BOX, .size = {1.6, 1.2, 0.5}};
		struct deform_sweep sweep = {.shape = &plate, .from = ground_pose(&ground, 70, 60, 0.249)};
		sweep.to = sweep.from;
		for (int n = 0; n < 4; n++) {
			const struct deform_pose left = sweep.to;
			sweep_and_wake(&ground, &sweep, n > 0 ? &left : NULL, false);
			sweep.from = sweep.to;
			sweep.to.x += lattice_offset(0.0625);
		}
		const struct deform_block *blocks;
		size_t awake;
		assert_ok(deform_awake(ground.deform, &blocks, &awake));
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
		if (models[m] != DEFORM_SCM)
			assert_true(interval(&ground, NULL, 0) > 0);
		ground_finish(&ground);
	}
}

/* A plate amid holes, but for a lane of one or two posts that ends at the rim of its window; beyond that the ground lies
 * `beyond` lower, and the lane's first post `lifted` higher. Base lattice. */
static struct {
	struct post_rect write;
	int64_t lane, length;
	int32_t lifted, beyond;
} rim;

static int32_t to_the_rim(int64_t x, int64_t y)
{
	bool inside = x >= rim.write.x0 && x < rim.write.x1 && y >= rim.write.y0 && y < rim.write.y1;
	if (x >= rim.write.x1)
		return -rim.beyond;
	if (!inside)
		return 0;
	if (y == rim.lane && x >= rim.write.x1 - rim.length)
		return x == rim.write.x1 - rim.length ? rim.lifted : 0;
	int64_t edge = 11; /* all that is left is under the plate */
	return x >= rim.write.x0 + edge && x < rim.write.x1 - edge && y >= rim.write.y0 + edge && y < rim.write.y1 - edge
		       ? 0 : BASE_NODATA;
}

/* What is left at the lane's first post by a sweep; and whether an interval knows of what the sweep could not look at. */
static int32_t lane_after(enum deform_model model, double depth, int32_t *stands, bool *goes_on)
{
	struct ground ground;
	struct setup setup = {model, 64, 2, 0.0625, 0, 8, to_the_rim};
	struct deform_shape plate = {.kind = DEFORM_BOX, .size = {0.8, 0.5, 0.5}};
	start(&ground, &setup);
	struct deform_sweep sweep = {.shape = &plate, .from = ground_pose(&ground, 60, 60, 0.25 - depth)};
	sweep.to = sweep.from;
	assert_ok(deform_windows(ground.deform, &sweep, ground.windows, &ground.window_count));
	bool placed = memcmp(&rim.write, &ground.windows[0].write, sizeof rim.write) == 0;
	rim.write = ground.windows[0].write;
	rim.lane = (rim.write.y0 + rim.write.y1) / 2;
	*stands = ground.deform->soils[0].stands[0];
	sweep_and_wake(&ground, &sweep, NULL, false);
	ground_read(&ground);
	int32_t left = ground.offset[rim.lane * ground.posts + rim.write.x1 - rim.length];
	interval(&ground, NULL, 0);
	ground_read(&ground);
	*goes_on = ground.offset[rim.lane * ground.posts + rim.write.x1] != 0;
	ground_finish(&ground);
	return placed ? left : lane_after(model, depth, stands, goes_on);
}

static void what_comes_to_the_rim_goes_on(void **state)
{
	int32_t stands;
	bool goes_on;
	(void)state;
	need_gpu();
	memset(&rim, 0, sizeof rim);
	/* Laid down on the rim itself, where it has no neighbour that the sweep could look at. */
	rim.length = 1;
	for (int m = 0; m < 2; m++) {
		int32_t laid = lane_after(m == 0 ? DEFORM_SLIPPAGE : DEFORM_SUMNER, 0.02, &stands, &goes_on);
		assert_true(laid > 2 * stands && goes_on);
	}
	/* It slid there by a few quanta, stopped, and was the last straw. */
	rim.length = 2;
	rim.beyond = 0;
	int32_t laid = lane_after(DEFORM_SLIPPAGE, 0.002, &stands, &goes_on);
	assert_true(laid > 0 && laid < stands && !goes_on);
	rim.lifted = (stands + 8 - laid + 3) / 4;
	rim.beyond = stands / 4;
	int32_t slid = laid - lane_after(DEFORM_SLIPPAGE, 0.002, &stands, &goes_on);
	assert_true(slid > 0 && slid < 12 && goes_on);
}

static bool is_awake(struct ground *ground, int64_t x, int64_t y)
{
	const struct deform_block *blocks;
	size_t count;
	bool found = false;
	assert_ok(deform_awake(ground->deform, &blocks, &count));
	for (size_t i = 0; i < count; i++)
		found = found || (blocks[i].x == x / DEFORM_BLOCK && blocks[i].y == y / DEFORM_BLOCK);
	return found;
}

/* Between two intervals nobody asks for a sweep's flags: until then, and in a commit, all that it wrote is awake. */
static void what_is_not_known_to_sleep_is_awake(void **state)
{
	struct ground ground;
	(void)state;
	need_gpu();
	bool software = test_gpu->info.software;
	start(&ground, &(struct setup){DEFORM_SLIPPAGE, 64, 4, 0.0625, 0, 4, NULL});
	disturb(&ground, 50, 50, 0.9);
	test_gpu->info.software = false;
	assert_true(interval(&ground, NULL, 0) > 0);
	test_gpu->info.software = software;
	struct deform_shape plate = {.kind = DEFORM_BOX, .size = {1.2, 0.8, 0.5}};
	struct deform_sweep sweep = {.shape = &plate, .from = ground_pose(&ground, 200, 200, 0.249)};
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
	struct deform_shape ball = {.kind = DEFORM_SPHERE, .radius = 5.5};
	for (int n = 0; n < 500; n++) {
		struct deform_sweep sweep = {.shape = &ball, .from = ground_pose(&few, 96 + n % 7, 96 - n % 5, 5.1 - n % 3 * 0.02)};
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

/* A spike on the plain, steeper than what is held stands at, less than that diagonally. */
static int32_t spike(int64_t x, int64_t y)
{
	return x == 48 && y == 48 ? (int32_t)lrint(ldexp(1.1 * 0.0625, BASE_BITS)) : 0;
}

/* What slides from under an object, and stood beside it, stands no longer where nothing is held. */
static void what_slid_out_of_an_object_slides_on(void **state)
{
	struct ground few, all;
	const struct setup setup = {DEFORM_SUMNER, 32, 3, 0.0625, 0, 4, spike};
	const struct deform_shape ball = {.kind = DEFORM_SPHERE, .radius = 0.5};
	(void)state;
	need_gpu();
	start(&few, &setup);
	start(&all, &setup);
	struct deform_rest rest = {.shape = &ball, .pose = ground_pose(&few, 48, 48, 0.5 + ldexp(spike(48, 48), -BASE_BITS))};
	assert_ok(deform_wake(few.deform, all_of(&few)));
	for (int n = 0; n < 60; n++) {
		interval(&few, &rest, 1);
		assert_ok(deform_wake(all.deform, all_of(&all)));
		interval(&all, &rest, 1);
	}
	assert_same(&few, &all, 60);
	assert_true(few.offset[48 * few.posts + 48] < 0);
	ground_finish(&few);
	ground_finish(&all);
}

/* 20 m from one block to the next. */
static int32_t ledge_between_blocks(int64_t x, int64_t y)
{
	(void)y;
	return x >= 32 ? -20 * (1 << BASE_BITS) : 0;
}

/* As another model may have left it: one block awake, the steep one beside it asleep. */
static void beside_a_block_that_sleeps_no_soil_is_lost(void **state)
{
	static const enum deform_model models[] = {DEFORM_SLIPPAGE, DEFORM_SUMNER};
	(void)state;
	need_gpu();
	for (int m = 0; m < 2; m++) {
		struct ground ground;
		int64_t sum = 0;
		start(&ground, &(struct setup){models[m], 64, 2, 0.25, 0, 4, ledge_between_blocks});
		for (int n = 0; n < 3; n++) {
			assert_ok(deform_wake_block(ground.deform, (struct deform_block){0, 0}));
			assert_ok(deform_wake_block(ground.deform, (struct deform_block){2, 1}));
			assert_int_equal(interval(&ground, NULL, 0), 2);
		}
		ground_read(&ground);
		for (int64_t i = 0; i < ground.posts * ground.posts; i++)
			sum += ground.offset[i];
		assert_int_equal(sum, 0);
		ground_finish(&ground);
	}
}

static void a_world_at_rest_makes_no_pass(void **state)
{
	struct ground ground;
	struct gpu_stats before, after;
	(void)state;
	need_gpu();
	start(&ground, &setups[0]);
	gpu_stats(test_gpu, &before);
	for (int n = 0; n < 10; n++)
		assert_int_equal(interval(&ground, NULL, 0), 0);
	gpu_stats(test_gpu, &after);
	assert_memory_equal(&before, &after, sizeof before);
	ground_finish(&ground);
}

static void more_blocks_than_there_may_be_are_refused(void **state)
{
	struct ground ground;
	const struct deform_block *blocks;
	size_t count;
	(void)state;
	need_gpu();
	start(&ground, &(struct setup){DEFORM_SLIPPAGE, 8, 1, 0.125, 0, 1, NULL});
	ground.world.width = ground.world.height = 129 * 32;
	for (int64_t y = 0; y < 128; y++)
		for (int64_t x = 0; x < 128; x++)
			assert_ok(deform_wake_block(ground.deform, (struct deform_block){x, y}));
	assert_ok(deform_awake(ground.deform, &blocks, &count));
	assert_int_equal(count, DEFORM_BLOCKS_MAX);
	for (size_t i = 1; i < count; i++)
		assert_true(blocks[i].x != blocks[i - 1].x || blocks[i].y != blocks[i - 1].y);
	assert_ok(deform_wake_block(ground.deform, (struct deform_block){500, 3})); /* beyond the world */
	assert_ok(deform_awake(ground.deform, &blocks, &count));
	assert_ok(deform_wake_block(ground.deform, (struct deform_block){128, 3}));
	assert_int_equal(deform_awake(ground.deform, &blocks, &count), STATUS_FAILED);
	assert_non_null(strstr(failure_message(), "16384"));
	ground_finish(&ground);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(few_blocks_do_what_all_would),
		cmocka_unit_test(more_blocks_than_a_layer_holds_are_as_right),
		cmocka_unit_test(flags_that_come_late_change_nothing),
		cmocka_unit_test(what_an_object_rests_on_is_held),
		cmocka_unit_test(what_a_sweep_lets_sleep_would_not_move),
		cmocka_unit_test(a_settled_rut_wakes_nothing),
		cmocka_unit_test(what_comes_to_the_rim_goes_on),
		cmocka_unit_test(what_is_not_known_to_sleep_is_awake),
		cmocka_unit_test(many_sweeps_are_as_right),
		cmocka_unit_test(what_slid_out_of_an_object_slides_on),
		cmocka_unit_test(beside_a_block_that_sleeps_no_soil_is_lost),
		cmocka_unit_test(a_world_at_rest_makes_no_pass),
		cmocka_unit_test(more_blocks_than_there_may_be_are_refused),
	};
	return cmocka_run_group_tests_name("deform/awake", tests, open_gpu, close_gpu);
}
