/* What furrow.h promises of checkpoints and rollbacks, of the store after a world is closed, and of copies that follow changes. */
#include "../support/near.h"
#include "rut.h"

#include "api/library.h"
#include "world/made.h"
#include "../support/program.h"

/* A whole copy of what a host can ask for. */
struct copy {
	double time;
	double *offsets, *sinkages;
	size_t posts;
	struct furrow_state state;
	struct furrow_contact contact;
};

static struct copy copy_of(struct furrow_world *world, furrow_body ball)
{
	struct furrow_info info;
	struct copy copy = {.time = furrow_time(world)};
	copy.offsets = hosted_read(world, FURROW_OFFSET, &info);
	copy.sinkages = hosted_read(world, FURROW_SINKAGE, &info);
	copy.posts = (size_t)(info.columns * info.rows);
	done(furrow_get_states(world, 1, &ball, &copy.state));
	copy.contact = contact_of(world, ball);
	return copy;
}

static void assert_same(struct copy *a, struct copy *b)
{
	assert_true(a->time == b->time);
	assert_memory_equal(a->offsets, b->offsets, a->posts * sizeof(double));
	assert_memory_equal(a->sinkages, b->sinkages, a->posts * sizeof(double));
	assert_memory_equal(&a->state, &b->state, sizeof a->state);
	for (int i = 0; i < 3; i++)
		assert_true(a->contact.force[i] == b->contact.force[i] && a->contact.moment[i] == b->contact.moment[i]);
	assert_true(a->contact.sinkage == b->contact.sinkage && a->contact.state == b->contact.state);
}

static void free_copy(struct copy *copy)
{
	free(copy->offsets);
	free(copy->sinkages);
}

/* steps: of the ways that are compared. */
static void goes_back(const char *scene, int steps)
{
	struct furrow_world *world = hosted_world_over("rollback.furrow", scene, hosted_flat);
	furrow_body ball = hosted_ball(world, 10, 16), kept = -1, later = -1;
	done(furrow_body_add(world, "{name: kept, shape: {sphere: {radius: 0.5}}}", &kept));
	make_rut(world, ball, 10, 16, 12);
	done(furrow_checkpoint(world));
	struct copy first = copy_of(world, ball), ways[2];
	for (int i = 0; i < 2; i++) {
		make_rut(world, ball, 10.6, 16, steps);
		ways[i] = copy_of(world, ball);
		done(furrow_body_remove(world, kept));
		done(furrow_body_add(world, HOSTED_BALL, &later));
		assert_true(later > kept);
		done(furrow_rollback(world));
		struct copy back = copy_of(world, ball);
		assert_same(&first, &back);
		free_copy(&back);
		furrow_body found = -1;
		done(furrow_body_find(world, "kept", &found));
		assert_int_equal(found, kept);
		misused(furrow_body_remove(world, later));
	}
	assert_same(&ways[0], &ways[1]);
	assert_memory_not_equal(first.offsets, ways[0].offsets, first.posts * sizeof(double));
	done(furrow_rollback(world)); /* again: the checkpoint is still there */
	done(furrow_world_close(world));
	free_copy(&first);
	free_copy(&ways[0]);
	free_copy(&ways[1]);
}

static void a_rollback_leaves_what_the_checkpoint_had(void **state)
{
	goes_back(HOSTED_SCENE, 20);
	/* A body that slides remembers its recent motion. After many steps no force would tell it. */
	goes_back("{time_step: 0.01, spacing: 0.125, soil: {name: dry_sand}, redistribute: {model: scm, faces: on}}", 1);
}

/* The same of a kinematic model; `compute`: what computes it. */
static struct copy ways_of(const char *model, const char *soil, const char *compute, struct copy *back)
{
	char scene[300], store[60];
	struct furrow_info info;
	snprintf(scene, sizeof scene, "{time_step: 0.01, spacing: 0.125, soil: {name: %s}, redistribute: {model: %s}, compute: %s}", soil, model, compute);
	snprintf(store, sizeof store, "%s-%s.furrow", model, compute);
	struct furrow_world *world = hosted_world_over(store, scene, hosted_flat);
	furrow_body ball = hosted_ball(world, 10, 16);
	make_rut(world, ball, 10, 16, 12);
	done(furrow_checkpoint(world));
	make_rut(world, ball, 12, 17, 9);
	done(furrow_rollback(world));
	*back = (struct copy){.offsets = hosted_read(world, FURROW_OFFSET, &info)};
	make_rut(world, ball, 10.6, 16, 20);
	struct copy way = {.offsets = hosted_read(world, FURROW_OFFSET, &info), .posts = (size_t)(info.columns * info.rows)};
	done(furrow_world_close(world));
	return way;
}

static void a_rollback_does_not_show_what_computes(void **state)
{
	static const char *const models[][2] = {{"none", "sand"}, {"box", "sand"}, {"sumner", "sand"}, {"slippage", "dry_sand"}};
	for (size_t i = 0; i < sizeof models / sizeof *models; i++) {
		struct copy back[2], gpu = ways_of(models[i][0], models[i][1], "gpu", &back[0]), cpu = ways_of(models[i][0], models[i][1], "cpu", &back[1]);
		assert_memory_equal(back[0].offsets, back[1].offsets, gpu.posts * sizeof(double));
		assert_memory_equal(gpu.offsets, cpu.offsets, gpu.posts * sizeof(double));
		assert_memory_not_equal(back[0].offsets, gpu.offsets, gpu.posts * sizeof(double));
		for (int k = 0; k < 2; k++)
			free_copy(&back[k]);
		free_copy(&gpu);
		free_copy(&cpu);
	}
}

/* Offsets + compacted = 0, and thrown = landed + lost + in flight, to the unit. */
static struct world_thrown_figures thrown_now(struct furrow_world *world)
{
	struct world_thrown_figures figures;
	assert_true(world_thrown_figures(world->world, &figures));
	assert_true(figures.thrown == figures.landed + figures.lost + figures.flying);
	return figures;
}

/* A wheel throws soil. After a rollback the same grains are in flight, and land in the same places. One whose host spins it throws, too. */
static void soil_in_flight_goes_back(void **state)
{
	static const char scene[] = "{scene: 1, time_step: 0.01, spacing: 0.0625, soil: {name: dry_sand}, redistribute: {model: scm, thrown: on}, objects: ["
				    "{name: a, shape: {wheel: {radius: 0.3, width: 0.2}}, load: 600, slip: 0.8, path: {points: [[10, 16], [20, 16]], speed: 1}}]}";
	struct furrow_world *world = hosted_world_over("thrown.furrow", scene, hosted_flat);
	struct furrow_info info = {.size = sizeof info};
	for (int i = 0; i < 60; i++)
		done(furrow_step(world, 0));
	done(furrow_checkpoint(world));
	const struct world_thrown_figures first = thrown_now(world);
	assert_true(first.grains > 100 && first.flying > 0);
	struct world_thrown_figures last[2];
	double *offsets[2];
	for (int i = 0; i < 2; i++) {
		for (int k = 0; k < 50; k++)
			done(furrow_step(world, i == 0 ? 0 : 0.01));
		last[i] = thrown_now(world);
		assert_true(last[i].landed > first.landed && last[i].thrown > first.thrown);
		offsets[i] = hosted_read(world, FURROW_OFFSET, &info);
		done(furrow_rollback(world));
		const struct world_thrown_figures back = thrown_now(world);
		assert_memory_equal(&back, &first, sizeof back);
	}
	assert_memory_equal(&last[0], &last[1], sizeof last[0]);
	assert_memory_equal(offsets[0], offsets[1], (size_t)(info.columns * info.rows) * sizeof(double));
	free(offsets[0]);
	free(offsets[1]);
	furrow_body wheel = -1;
	done(furrow_body_add(world, "{shape: {wheel: {radius: 0.3, width: 0.2}}}", &wheel));
	int64_t before = 0;
	for (int spins = 0; spins < 2; spins++) {
		before = thrown_now(world).thrown;
		done(furrow_rollback(world));
		done(furrow_body_add(world, "{shape: {wheel: {radius: 0.3, width: 0.2}}}", &wheel));
		struct furrow_state at = {.pose = {{10, 24, 100.27}, {1, 0, 0, 0}}, .linear = {0.5, 0, 0}, .angular = {0, spins ? 12 : 0.5 / 0.3, 0}};
		done(furrow_place(world, wheel, &at.pose));
		for (int k = 0; k < 40; k++) {
			at.pose.position[0] += 0.005;
			done(furrow_set_states(world, 1, &wheel, &at));
			done(furrow_step(world, 0.01));
		}
		if (spins)
			assert_true(thrown_now(world).thrown > before);
	}
	done(furrow_world_close(world));
}

/* A commit that nobody asked for, as its age makes it. */
static void force_commit(struct furrow_world *world)
{
	struct library_call call;
	must(api_library_enter(&call, world));
	done(api_library_leave(&call, page_cache_flush(world_resident(world->world)->cache, world_made_record(world->world))));
}

/* A checkpoint that fails leaves the one before. */
static void a_failed_checkpoint_changes_no_rollback(void **state)
{
	struct furrow_world *world = hosted_world("unmarked.furrow");
	furrow_body ball = hosted_ball(world, 10, 16);
	make_rut(world, ball, 10, 16, 12);
	done(furrow_checkpoint(world));
	struct copy first = copy_of(world, ball);
	make_rut(world, ball, 10.6, 16, 20);
	must(world_hosts_commit(world->world));
	force_commit(world);
	mem_fail_nth(UINT64_MAX, false);
	force_commit(world); /* of nothing: a checkpoint begins with the same, and then copies the world's state */
	const uint64_t committing = mem_fail_nth(0, false);
	for (uint64_t copied = 1; copied <= 4; copied++) {
		mem_fail_nth(committing + copied, false);
		refused(FURROW_FAILED, furrow_checkpoint(world));
		mem_fail_nth(0, false);
	}
	make_rut(world, ball, 11.6, 16, 5);
	done(furrow_rollback(world));
	struct copy back = copy_of(world, ball);
	assert_same(&first, &back);
	done(furrow_world_close(world));
	free_copy(&first);
	free_copy(&back);
}

static void a_rollback_without_a_checkpoint_goes_back_to_the_opening(void **state)
{
	struct furrow_world *world = hosted_world("opening.furrow");
	struct furrow_info info;
	furrow_body ball = hosted_ball(world, 10, 16);
	make_rut(world, ball, 10, 16, 12);
	done(furrow_rollback(world));
	assert_true(furrow_time(world) == 0);
	misused(furrow_body_remove(world, ball));
	double *offsets = hosted_read(world, FURROW_OFFSET, &info);
	for (int64_t i = 0; i < info.columns * info.rows; i++)
		assert_true(offsets[i] == 0);
	free(offsets);
	done(furrow_world_close(world));
}

static furrow_status open_again(const char *name, struct furrow_world **world)
{
	const struct furrow_open open = hosted_open(HOSTED_SCENE, support_path(name));
	return furrow_world_open(&open, world);
}

static void what_is_closed_is_in_the_store(void **state)
{
	struct furrow_world *world = hosted_world("closed.furrow");
	furrow_body ball = hosted_ball(world, 10, 16);
	make_rut(world, ball, 10, 16, 12);
	done(furrow_checkpoint(world));
	const double rut = point_at(world, 10.5, 16).offset, beyond = point_at(world, 20, 16).offset;
	assert_true(rut < -0.05 && beyond == 0);
	make_rut(world, ball, 19, 16, 1);
	make_rut(world, ball, 19.05, 16, 40);
	assert_true(point_at(world, 20, 16).offset < -0.05);
	done(furrow_rollback(world));
	done(furrow_world_close(world));
	support_verify(support_path("closed.furrow"));
	done(open_again("closed.furrow", &world));
	assert_true(point_at(world, 10.5, 16).offset == rut && point_at(world, 20, 16).offset == 0);
	done(furrow_world_close(world));
}

static void an_overlay_keeps_the_store_as_it_was(void **state)
{
	const char *store = support_path("base.furrow"), *overlay = support_path("overlay.furrow");
	struct furrow_world *world;
	support_store(store, hosted_extent, hosted_flat);
	const uint64_t hash = support_hash(store);
	struct furrow_open open = hosted_open(HOSTED_SCENE, store);
	open.overlay = overlay;
	done(furrow_world_open(&open, &world));
	make_rut(world, hosted_ball(world, 10, 16), 10, 16, 12);
	done(furrow_world_close(world));
	assert_true(support_hash(store) == hash);
	done(furrow_world_open(&open, &world));
	assert_true(point_at(world, 10.5, 16).offset < -0.05);
	done(furrow_world_close(world));
}

/* A host's texts are its own again when furrow_world_open returns: they are overwritten and freed here. */
static void what_open_was_given_may_go(void **state)
{
	const char *store = support_path("given.furrow"), *overlay = support_path("given-overlay.furrow"), *output = support_path("given");
	const char *given[] = {HOSTED_SCENE, store, overlay, output};
	char *texts[4], *json;
	struct furrow_world *world;
	support_store(store, hosted_extent, hosted_flat);
	for (int i = 0; i < 4; i++)
		texts[i] = strdup(given[i]);
	struct furrow_open open = hosted_open(texts[0], texts[1]);
	open.overlay = texts[2];
	open.output = texts[3];
	done(furrow_world_open(&open, &world));
	for (int i = 0; i < 4; i++) {
		memset(texts[i], 0x80, strlen(texts[i]));
		free(texts[i]);
	}
	furrow_body ball = hosted_ball(world, 10, 16);
	make_rut(world, ball, 10, 16, 5);
	done(furrow_checkpoint(world));
	make_rut(world, ball, 10, 16, 5);
	done(furrow_rollback(world));
	done(furrow_stats(world, &json));
	assert_non_null(strstr(json, overlay));
	assert_non_null(strstr(json, store));
	furrow_free(json);
	done(furrow_world_close(world));
}

/* An engine that keeps a copy reads only what changed. */
static void copies_that_follow_changes_end_as_the_store_does(void **state)
{
	struct furrow_world *world = hosted_world("copies.furrow");
	struct furrow_info info;
	struct furrow_rect rects[64];
	furrow_body ball = hosted_ball(world, 5, 5);
	double *copy = hosted_read(world, FURROW_SURFACE, &info);
	uint64_t since = info.revision, now = 0;
	uint64_t read = 0;
	for (int turn = 0; turn < 10; turn++) {
		if (turn == 5)
			done(furrow_checkpoint(world));
		if (turn == 8)
			done(furrow_rollback(world));
		else
			make_rut(world, ball, 5 + turn, 5 + turn, 10);
		if (turn == 8)
			done(furrow_place(world, ball, &(struct furrow_pose){{13, 13, 100.5}, {1, 0, 0, 0}}));
		else if (turn < 9)
			done(furrow_place(world, ball, &(struct furrow_pose){{6 + turn, 6 + turn, 100.5}, {1, 0, 0, 0}}));
		size_t count = 64;
		done(furrow_changes(world, since, rects, &count, &now));
		assert_true(count > 0);
		since = now;
		for (size_t i = 0; i < count; i++) {
			const struct furrow_rect *rect = &rects[i];
			assert_true(rect->column >= 0 && rect->row >= 0 && rect->columns > 0 && rect->rows > 0);
			assert_true(rect->column + rect->columns <= info.columns && rect->row + rect->rows <= info.rows);
			done(furrow_read(world, FURROW_SURFACE, info.level, rect->column, rect->row, (uint32_t)rect->columns, (uint32_t)rect->rows,
					 copy + rect->row * info.columns + rect->column, (size_t)info.columns));
			read += (uint64_t)(rect->columns * rect->rows);
		}
		double *truth = hosted_read(world, FURROW_SURFACE, &info);
		assert_memory_equal(copy, truth, (size_t)(info.columns * info.rows) * sizeof *copy);
		free(truth);
	}
	assert_true(read < 10 * (uint64_t)(info.columns * info.rows) / 2);
	size_t none = 64;
	done(furrow_changes(world, since, rects, &none, &now));
	assert_int_equal(none, 0);
	/* Too little room: the number is told. */
	size_t few = 0;
	misused(furrow_changes(world, 0, NULL, &few, &now));
	assert_true(few > 0 && now == since);
	done(furrow_world_close(world));
	free(copy);
}

/* What an earlier world left is told to those that ask for all, and to nobody else. */
static void ruts_of_earlier_worlds_are_told_once(void **state)
{
	struct furrow_world *world = hosted_world("earlier.furrow");
	struct furrow_info info = {.size = sizeof info};
	struct furrow_rect rects[64];
	uint64_t now = 0;
	make_rut(world, hosted_ball(world, 10, 16), 10, 16, 5);
	done(furrow_world_close(world));
	done(open_again("earlier.furrow", &world));
	done(furrow_info(world, &info));
	assert_true(info.revision > 0);
	const uint64_t asked[] = {0, info.revision, 0, info.revision};
	for (int i = 0; i < 4; i++) {
		size_t count = 64;
		done(furrow_changes(world, asked[i], rects, &count, &now));
		assert_true(now == info.revision && (count > 0) == (asked[i] == 0));
	}
	make_rut(world, hosted_ball(world, 20, 16), 20, 16, 0);
	size_t count = 64;
	done(furrow_changes(world, now, rects, &count, &now));
	assert_true(count > 0 && now > info.revision);
	for (size_t i = 0; i < count; i++)
		assert_true(rects[i].column > 140 && rects[i].columns < 32 && rects[i].rows < 32);
	done(furrow_world_close(world));
}

/* --- higher ground comes back --- */

#define HEAP_METRES 0.5

/* A store of flat ground with a heap of 4 by 4 m around 16, 16, as an earlier drive may leave it. */
static void store_with_heap(const char *path)
{
	enum { LEVEL = -1, CELLS = 32, SIDE = CELLS + 1 };
	const struct post_rect heap = {112, 112, 145, 145}; /* posts of 0.125 m */
	static int32_t offsets[SIDE * SIDE];
	struct store *store;
	struct store_commit_result result;
	const struct store_run run = {.scene_hash = "00", .state = "{}"};
	support_store(path, hosted_extent, hosted_flat);
	must(store_open(path, &(struct store_options){.mode = STORE_WRITE}, &store));
	must(store_set_working_level(store, LEVEL));
	for (uint32_t y = 3; y <= 4; y++)
		for (uint32_t x = 3; x <= 4; x++) {
			struct store_page page = {.tile = {LEVEL, x, y}};
			for (int64_t i = 0; i < SIDE * SIDE; i++) {
				const int64_t px = x * CELLS + i % SIDE, py = y * CELLS + i / SIDE;
				const bool in = px >= heap.x0 && px < heap.x1 && py >= heap.y0 && py < heap.y1;
				offsets[i] = in ? (int32_t)lattice_offset(HEAP_METRES) : 0;
			}
			page.planes[PLANE_OFFSET] = offsets;
			must(store_commit(store, &page, 1, &run, &result));
		}
	store_close(store);
}

/* Sets the box of 1 m height down with its bottom there, in a step. */
static void set_down(struct furrow_world *world, furrow_body box, double bottom)
{
	const struct furrow_pose pose = hosted_pose(16, 16, bottom + 0.5);
	done(furrow_place(world, box, &pose));
	done(furrow_step(world, 0));
}

static enum status here(void *user, double until, enum status status)
{
	(void)user, (void)until;
	return status;
}

static bool may_read(void *user, uint64_t key)
{
	(void)user, (void)key;
	return true;
}

static enum status no_change(void *user, uint64_t key)
{
	(void)user, (void)key;
	return fail_with(STATUS_FAILED, "change: it fails; try another");
}

/* Fails a step when the soil moves already. */
static void tear(struct furrow_world *world, furrow_body ball, double x)
{
	const struct world_ranks ranks = {.step = here, .has = may_read, .changes = no_change};
	const struct furrow_state state = hosted_state(x, 16, 100.4);
	world_made_set_ranks(world->world, &ranks);
	done(furrow_set_states(world, 1, &ball, &state));
	refused(FURROW_FAILED, furrow_step(world, 0));
	world_made_set_ranks(world->world, NULL);
	assert_true(world_is_torn(world->world));
}

/* What a commit has of it stays, and a close tells if that is not all. */
static void a_step_that_fails_half_way_is_told_if_others_go_with_it(void **state)
{
	for (int committed = 0; committed < 2; committed++) {
		const char *name = committed ? "torn-all.furrow" : "torn-some.furrow";
		struct furrow_world *world = hosted_world(name);
		furrow_body ball = hosted_ball(world, 10, 16);
		make_rut(world, ball, 10, 16, 12);
		done(furrow_checkpoint(world));
		const double rut = point_at(world, 10.5, 16).offset;
		hosted_move(world, ball, 12.6, 16, 100.4);
		if (committed)
			force_commit(world);
		tear(world, ball, 12.8);
		if (committed)
			done(furrow_world_close(world));
		else
			refused(FURROW_FAILED, furrow_world_close(world));
		support_verify(support_path(name));
		done(open_again(name, &world));
		assert_true(point_at(world, 10.5, 16).offset <= rut && rut < -0.05);
		assert_true((point_at(world, 12, 16).offset < -0.05) == committed);
		done(furrow_world_close(world));
	}
}

/* The heap is pressed flat and committed before a body is first looked at in the air. A rollback brings the heap back: now a body
 * above the base is in the heap, and must press it. */
static void ground_that_a_rollback_raises_is_pressed(void **state)
{
	static const char *const models[] = {"none", "box"};
	for (size_t m = 0; m < sizeof models / sizeof *models; m++) {
		const char *path = support_path("raised.furrow");
		char scene[160];
		struct furrow_world *world;
		furrow_body box = -1;
		store_with_heap(path);
		snprintf(scene, sizeof scene, "{\"scene\": 1, \"time_step\": 0.01, \"spacing\": 0.125, \"redistribute\": {\"model\": \"%s\"}}", models[m]);
		const struct furrow_open open = hosted_open(scene, path);
		done(furrow_world_open(&open, &world));
		assert_near(point_at(world, 16, 16).height, 100 + HEAP_METRES, 1e-6);
		done(furrow_body_add(world, "{name: press, shape: {box: {size: [6, 6, 1]}}}", &box));
		done(furrow_checkpoint(world));
		set_down(world, box, 99.9);
		force_commit(world);
		assert_true(point_at(world, 16, 16).height < 100);
		set_down(world, box, 105);
		done(furrow_rollback(world));
		assert_near(point_at(world, 16, 16).height, 100 + HEAP_METRES, 1e-6);
		set_down(world, box, 100.2);
		assert_near(point_at(world, 16, 16).height, 100.2, 1e-3);
		done(furrow_world_close(world));
	}
}

TEST_PROGRAM(rollback)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_rollback_leaves_what_the_checkpoint_had),
		cmocka_unit_test(a_rollback_does_not_show_what_computes),
		cmocka_unit_test(soil_in_flight_goes_back),
		cmocka_unit_test(a_failed_checkpoint_changes_no_rollback),
		cmocka_unit_test(a_rollback_without_a_checkpoint_goes_back_to_the_opening),
		cmocka_unit_test(ground_that_a_rollback_raises_is_pressed),
		cmocka_unit_test(what_is_closed_is_in_the_store),
		cmocka_unit_test(a_step_that_fails_half_way_is_told_if_others_go_with_it),
		cmocka_unit_test(an_overlay_keeps_the_store_as_it_was),
		cmocka_unit_test(what_open_was_given_may_go),
		cmocka_unit_test(copies_that_follow_changes_end_as_the_store_does),
		cmocka_unit_test(ruts_of_earlier_worlds_are_told_once),
	};
	return cmocka_run_group_tests(tests, support_enter, support_leave);
}
