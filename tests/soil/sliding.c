/* Sliding over a window: the CPU and the GPU compute the same bits, and no soil is lost. */
#include "sliding.h"
#include "../support/program.h"
#include "soil/kinematic/shed.h"

#define WORLD 256 /* cells of the world along a side */
#define WORDS 81  /* blocks on which a window lies, at most */

static const char *const sumner_names[] = {"sand", "mud", "snow"};
static const char *const names[] = {"dry_sand", "clayey_38", "sandy_loam_15", "snow_us", "lete_sand", "lunar"};

/* What a round has: every combination comes up, and others at random. */
struct kind {
	bool deposited, sumner, classes, lines, stood, near, loaded, large, saw, lone; /* deposited: the CPU has that plane, which is the offsets */
	int iterations, soil_count;
	double spacing, holds, depth, tolerance, relief, cohesion;
	int rough; /* 2^rough units from post to post */
};

static struct kind any_kind(int round)
{
	struct kind kind = {
		.deposited = round % 2 && round % 6 != 2, .sumner = round % 6 == 2, .lines = round / 2 % 2, .stood = round / 4 % 2, .classes = round % 3 == 2, .near = round / 3 % 2,
		.loaded = any_word() % 2, .iterations = 1 + (int)(any_word() % 8), .spacing = ldexp(1, -(int)(any_word() % 7)),
		.tolerance = round % 5 == 4 ? ldexp(1 + any_word() % 1024, -(int)(10 + any_word() % 11)) : 0,
		.relief = any_word() % 2 ? 300 : 0, .rough = (int)(any_word() % 23), .cohesion = any_word() % 3 == 0 ? 1 : 0,
	};
	if (any_word() % 3 == 0)
		kind.iterations = 1;
	kind.large = round % 12 == 6; /* long lines, along which pools may join as often as they are allowed to */
	kind.classes = kind.sumner ? round % 4 == 2 : kind.classes;
	kind.soil_count = kind.sumner ? 3 : 6;
	kind.soil_count = kind.classes ? kind.soil_count : 1;
	kind.depth = kind.sumner ? 0 : kind.deposited ? any_word() % 2 ? 1e-9 : 0.1 : any_word() % 3 == 0 ? 0.3 : 0; /* 1e-9: 0, but there is a bottom */
	/* Where the relief may be large, some rounds have cliffs. */
	kind.rough += kind.relief == 0 && round % 7 == 6 ? 4 : 0;
	/* A slope with teeth: each pool takes in all posts of the pools before it, until no more may join. */
	kind.holds = kind.sumner && round % 12 == 2 ? 1.5 : 1;
	kind.lone = kind.sumner && round % 24 == 14; /* one steep post, which a body holds, comes to rest before the last iteration */
	kind.iterations = kind.lone ? 4 : kind.iterations;
	kind.saw = round % 24 == 18 && !kind.sumner;
	kind.iterations = kind.saw ? 1 : kind.iterations;
	return kind;
}

static void start(struct ground *ground, const struct kind *kind)
{
	struct soil_numbers soils[6];
	for (int i = 0; i < 6; i++) {
		assert_ok(soil_named(kind->sumner ? sumner_names[any_word() % 3] : names[any_word() % 6], &soils[i]));
		soils[i].theta_in *= kind->holds; /* a body may set soil in motion by holding it, or not */
		soils[i].cohesion *= kind->cohesion;
		soils[i].repose *= 0.5 + 0.5 * fabs(any_share());
	}
	soils[kind->soil_count - 1].friction_angle *= any_word() % 8 != 0;
	ground_init(ground, &(struct ground_params){.cells = WORLD, .tiles = 1, .spacing = kind->spacing, .model = kind->sumner ? DEFORM_SUMNER : DEFORM_SLIPPAGE,
						    .soils = soils, .soil_count = kind->soil_count, .iterations = kind->iterations,
						    .depth = kind->depth, .relief = kind->relief, .tolerance = kind->tolerance, .stands = kind->stood,
						    .lines = kind->lines, .touched = kind->stood});
}

static struct post_rect any_rect(int64_t side, int64_t most)
{
	int64_t width = 1 + any_word() % most, height = 1 + any_word() % most;
	int64_t x = any_word() % 4 == 0 ? 0 : any_word() % (side - width + 1), y = any_word() % 4 == 0 ? 0 : any_word() % (side - height + 1);
	x = any_word() % 4 == 0 ? side - width : x;
	return (struct post_rect){x, y, x + width, y + height};
}

/* Ground with hills, noise, holes, classes, held posts and laid soil. */
static void fill(struct window *window, const struct kind *kind, int64_t side)
{
	const struct post_rect all = window->planes.rect;
	const double rough = ldexp(1, kind->rough), hill = any_word() % 2 ? 8 : 0, calm = any_word() % 3 == 0 ? 0.02 : 1;
	const bool sparse = any_word() % 4 == 0, ends = kind->relief == 0 && any_word() % 8 == 0;
	const uint32_t hole = any_word() % 2 ? 16 : 400, held = any_word() % 2 ? 8 : 200;
	for (size_t i = 0; i < window->count; i++) {
		const int64_t x = all.x0 + (int64_t)(i % window->planes.width), y = all.y0 + (int64_t)(i / window->planes.width);
		const double wave = hill * rough * sin((double)x * 0.3) * cos((double)y * 0.21);
		/* Quiet posts lie as they did. In sparse ground few others lie between them. */
		bool quiet = sparse ? x * 7 % 31 > 3 || y * 5 % 29 > 4 : kind->deposited && x % 23 < 12;
		window->planes.base[i] = (40 << 18) + (sparse ? 0 : (int32_t)(wave + calm * any_share() * rough));
		window->planes.offset[i] = quiet ? 0 : (int32_t)(2 * any_share() * rough);
		window->deposits[i] = any_word() % 4 == 0 ? (int32_t)(any_word() % (uint32_t)(1 + rough)) : 0;
		window->planes.contact[i] = (uint8_t)(any_word() % held == 0 ? any_word() % 4 : any_word() % 8 == 0 ? SOIL_NEAR | SOIL_LOWERED : 0);
		if (window->planes.classes != NULL)
			window->planes.classes[i] = (uint8_t)(any_word() % (uint32_t)kind->soil_count);
		bool outside = x < 0 || y < 0 || x >= side || y >= side;
		if (outside || any_word() % hole == 0) {
			window->planes.base[i] = BASE_NODATA;
			window->planes.offset[i] = window->deposits[i] = 0;
			window->planes.contact[i] |= SOIL_NO_GROUND;
		} else if (ends) { /* one cliff from end to end of what a base may be: as differences wrap, a metre or two */
			window->planes.base[i] = x % 40 < 20 ? INT32_MAX - (int32_t)(any_word() >> 14) : INT32_MIN + 1 + (int32_t)(any_word() >> 14);
		} else if (kind->relief == 0 && kind->rough > 20 && any_word() % 16 == 0) {
			window->planes.base[i] += (int32_t)(any_word() % 3 * 900 - 900) * (1 << 18); /* cliffs of more than 1536 m too */
		} else if (kind->rough > 16 && any_word() % 64 == 0) {
			window->planes.offset[i] = (int32_t)(any_share() * (1 << 30)); /* beyond 736 m */
			window->deposits[i] = (int32_t)any_word();
		}
	}
}

/* A slope at the critical difference along x, y, or both, with teeth of 20000 units that fall by 200 more each. */
static void fill_saw(struct window *window, const struct soil_sliding *rule, int round)
{
	const int64_t width = (int64_t)window->planes.width, way = round / 24 % 4;
	const int32_t slope = rule->classes[0].critical[way > 1] + 200;
	for (int64_t i = 0; i < (int64_t)window->count; i++) {
		const int64_t at = way != 1 ? i % width : i / width;
		window->planes.base[i] = 40 << 18;
		window->planes.offset[i] = (int32_t)(-slope * at + (at % 2 ? -20000 : 20000));
		window->planes.contact[i] = 0;
		window->deposits[i] = 0;
	}
}

/* Level ground with one post that is a little too high. */
static void fill_lone(struct window *window, const struct soil_sliding *rule)
{
	const size_t middle = window->count / 2 + window->planes.width / 2;
	for (size_t i = 0; i < window->count; i++) {
		const bool here = i == middle && window->planes.base[i] != BASE_NODATA;
		const struct soil_shed_class *soil = &rule->shed->classes[window->planes.classes != NULL ? window->planes.classes[i] : 0];
		const int32_t steep = soil->stop[0] > soil->held[0] ? soil->stop[0] : soil->held[0];
		window->planes.base[i] = window->planes.base[i] != BASE_NODATA ? 40 << 18 : BASE_NODATA;
		window->planes.offset[i] = here && steep < 1 << 28 ? steep + 4 : 0;
		window->planes.contact[i] = here ? SOIL_HELD : 0;
		window->deposits[i] = 0;
	}
}

/* Slides on the GPU. Offsets and thickness come back to the window. */
static void slide_on_gpu(struct ground *ground, struct window *window, const struct kind *kind, struct post_rect reached, uint32_t words[WORDS])
{
	struct deform *deform = ground->deform;
	const struct post_rect read = window->planes.rect, write = window->slides.written;
	const struct deform_window of = {.read = read, .write = write};
	const uint32_t width = (uint32_t)window->planes.width, height = (uint32_t)(window->count / window->planes.width);
	const struct gpu_rect rect = rect_of(0, 0, width, height);
	struct gpu_texture *const *planes = deform->planes_of[1];
	gpu_texture_upload(deform->bases, 0, rect, window->planes.base);
	gpu_texture_upload(planes[PLANE_OFFSET], 0, rect, window->planes.offset);
	gpu_texture_upload(deform->contacts, 0, rect, window->planes.contact);
	gpu_texture_upload(deform->deposits, 0, rect, window->deposits);
	if (window->planes.classes != NULL)
		gpu_texture_upload(deform->classes, 0, rect, window->planes.classes);
	const uint32_t bias = 1u << 30;
	const uint32_t ends[4] = {bias + (uint32_t)(reached.x1 - 1 - read.x0), bias - (uint32_t)(reached.x0 - read.x0),
				  bias + (uint32_t)(reached.y1 - 1 - read.y0), bias - (uint32_t)(reached.y0 - read.y0)}, nowhere[4] = {0};
	gpu_buffer_write(deform->laying, 0, sizeof ends, post_rect_empty(reached) ? nowhere : ends);
	deform->scratch[0].now[PLANE_OFFSET] = 1;
	deform->scratch[0].near = kind->near;
	deform->scratch[0].alone = true;
	assert_ok(deform_slide(deform, &of, 0));
	assert_ok(gpu_check(test_gpu, "sliding"));
	gpu_texture_read(planes[PLANE_OFFSET], 0, rect, window->planes.offset);
	gpu_buffer_read(deform_active_words(deform), 0, WORDS * sizeof *words, words);
}

/* Tells what a round has, before it fails. */
static void tell(const struct kind *kind, const struct soil_sliding *rule, const struct window *window)
{
	const struct post_rect written = window->slides.written, posts = window->slides.posts;
	print_message("deposited %d, sumner %d, classes %d, directions %d, stood %d, near %d, loaded %d, iterations %d, spacing %g, depth %g, tolerance %d, relief %g, "
		      "2^%d, reach %d; written %lld,%lld .. %lld,%lld, posts %lld,%lld .. %lld,%lld\n", kind->deposited, kind->sumner, kind->classes, rule->directions,
		      rule->undisturbed_stable, kind->near, kind->loaded, rule->iterations, kind->spacing, kind->depth, rule->tolerance, kind->relief,
		      kind->rough, rule->reach, (long long)written.x0, (long long)written.y0, (long long)written.x1, (long long)written.y1,
		      (long long)posts.x0, (long long)posts.y0, (long long)posts.x1, (long long)posts.y1);
}

static bool same_planes(const struct window *a, const struct window *b)
{
	return memcmp(a->planes.offset, b->planes.offset, a->count * 4) == 0;
}

static void assert_same_planes(const struct window *cpu, const struct window *gpu, int round)
{
	for (size_t i = 0; i < cpu->count; i++) {
		const long long x = (long long)(i % cpu->planes.width), y = (long long)(i / cpu->planes.width);
		if (cpu->planes.offset[i] != gpu->planes.offset[i])
			fail_msg("round %d, post %lld, %lld: %d, the GPU's is %d", round, x, y, cpu->planes.offset[i], gpu->planes.offset[i]);
		if (cpu->planes.deposited != NULL && cpu->planes.deposited[i] != gpu->planes.offset[i])
			fail_msg("round %d, post %lld, %lld: thickness %d, the GPU's is %d", round, x, y, cpu->planes.deposited[i], gpu->planes.offset[i]);
	}
}

static struct window twin_of(const struct window *window)
{
	struct window twin = *window;
	const struct soil_planes *planes = &window->planes;
	twin.planes.base = copy_of(planes->base, window->count * 4);
	twin.planes.offset = copy_of(planes->offset, window->count * 4);
	twin.planes.deposited = planes->deposited != NULL ? copy_of(planes->deposited, window->count * 4) : NULL;
	twin.planes.classes = planes->classes != NULL ? copy_of(planes->classes, window->count) : NULL;
	twin.planes.contact = copy_of(planes->contact, window->count);
	twin.deposits = copy_of(window->deposits, window->count * 4);
	twin.slides.deposits = twin.deposits;
	return twin;
}

static int64_t sum_of(const struct window *window, const int32_t *plane)
{
	int64_t sum = 0;
	for (size_t i = 0; i < window->count; i++)
		sum += plane[i];
	return sum;
}

/* Returns the soil that is laid on the posts in which it may slide. */
static int64_t laid_on(const struct window *window)
{
	const struct post_rect all = window->planes.rect, posts = window->slides.posts;
	int64_t sum = 0;
	for (int64_t y = posts.y0; y < posts.y1; y++)
		for (int64_t x = posts.x0; x < posts.x1; x++)
			sum += (uint32_t)window->deposits[(size_t)(y - all.y0) * window->planes.width + (size_t)(x - all.x0)];
	return sum;
}

/* Below a body that rests by its load soil slides alike, and the blocks of what it holds stay active, since it may be freed. */
static void assert_held_is_flagged(const struct soil_sliding *rule, const struct window *plain, struct window *loaded, const uint32_t words[WORDS])
{
	uint32_t flags[WORDS] = {0};
	const struct post_rect all = loaded->planes.rect, posts = loaded->slides.posts, blocks = soil_slide_blocks(loaded->slides.written);
	loaded->slides.loaded = true;
	slide_on_cpu(rule, loaded, flags);
	assert_true(same_planes(plain, loaded));
	for (int i = 0; i < WORDS; i++)
		assert_true((flags[i] & words[i]) == words[i]);
	for (int64_t y = posts.y0; y < posts.y1; y++)
		for (int64_t x = posts.x0; x < posts.x1; x++)
			if (loaded->planes.contact[(size_t)(y - all.y0) * loaded->planes.width + (size_t)(x - all.x0)] & SOIL_HELD)
				assert_true(flags[(y / SOIL_BLOCK - blocks.y0) * (blocks.x1 - blocks.x0) + x / SOIL_BLOCK - blocks.x0] & 1);
}

struct counts {
	size_t moved, changed, flagged, refused, shed, told;
};

static void compare(int round, struct counts *counts)
{
	struct kind kind = any_kind(round);
	struct ground ground;
	struct window cpu;
	uint32_t words[WORDS] = {0}, gpu_words[WORDS];
	start(&ground, &kind);
	window_init(&cpu, any_rect(ground.posts, kind.large ? LARGE : MOST), kind.deposited, kind.classes);
	fill(&cpu, &kind, ground.posts);
	if (kind.saw)
		fill_saw(&cpu, &ground.deform->sliding, round);
	if (kind.lone)
		fill_lone(&cpu, &ground.deform->sliding);
	if (kind.deposited)
		memcpy(cpu.planes.deposited, cpu.planes.offset, cpu.count * 4);
	const struct post_rect written = cpu.slides.written, world = {0, 0, ground.posts, ground.posts};
	struct post_rect reached = post_rect_intersect(any_rect(ground.posts, ground.posts), written);
	cpu.slides.world = world;
	cpu.slides.posts = kind.near ? soil_slide_posts(written, reached, ground.deform->reach) : written;
	struct window gpu = twin_of(&cpu), loaded = twin_of(&cpu);
	const struct soil_sliding rule = rule_of(&ground);
	struct deform_tally tally;
	const int64_t sum = sum_of(&cpu, cpu.planes.offset), laid = laid_on(&cpu);
	int32_t *before = copy_of(cpu.planes.offset, cpu.count * 4);

	struct soil_slid slid = slide_on_cpu(&rule, &cpu, words);
	slide_on_gpu(&ground, &gpu, &kind, reached, gpu_words);
	if (!same_planes(&cpu, &gpu) || (ground.deform->contacts_flag && memcmp(words, gpu_words, sizeof words) != 0))
		tell(&kind, &rule, &cpu);
	assert_same_planes(&cpu, &gpu, round);
	for (int i = 0; i < WORDS && ground.deform->contacts_flag; i++) { /* otherwise nobody reads them */
		uint32_t mask = kind.stood ? UINT32_MAX : 0xffffu; /* the GPU tells what changed only if touched posts are asked for */
		if ((words[i] & mask) != gpu_words[i])
			fail_msg("round %d, block %d: flags %x, the GPU's are %x", round, i, words[i] & mask, gpu_words[i]);
		counts->flagged += (words[i] & 1) != 0;
	}
	assert_held_is_flagged(&rule, &cpu, &loaded, words);
	assert_ok(deform_tally(ground.deform, &tally));
	assert_int_equal(slid.compacted, tally.compacted);
	assert_int_equal(slid.refused, tally.refused);
	assert_int_equal(sum_of(&cpu, cpu.planes.offset), sum + laid - (int64_t)slid.compacted);
	for (size_t i = 0; i < cpu.count; i++)
		counts->moved += cpu.planes.offset[i] != before[i];
	for (size_t i = 0; i < cpu.count && kind.sumner; i++)
		counts->shed += cpu.planes.offset[i] != before[i];
	counts->told += kind.sumner && ground.deform->contacts_flag && (words[0] & 1) != 0;
	counts->refused += slid.refused;
	mem_free(before);
	window_finish(&cpu);
	window_finish(&gpu);
	window_finish(&loaded);
	ground_finish(&ground);
}

static void a_window_slides_as_on_the_gpu_bit_for_bit(void **state)
{
	struct counts counts = {.moved = 0};
	(void)state;
	need_gpu();
	for (int round = 0; round < 480; round++)
		compare(round, &counts);
	assert_true(counts.moved > 50000 && counts.flagged > 200 && counts.refused > 10 && counts.shed > 10000 && counts.told > 10);
}

TEST_PROGRAM(sliding)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_window_slides_as_on_the_gpu_bit_for_bit),
	};
	return cmocka_run_group_tests_name("soil/sliding", tests, open_gpu, close_gpu);
}
