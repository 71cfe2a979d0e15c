/* Marks that fade, as a host reads them: they fade as the world's time goes on, and a rollback leaves those of the checkpoint. */
#include "rut.h"

#include "../support/program.h"

static const enum furrow_layer layers[] = {FURROW_DISTURBANCE, FURROW_BENT, FURROW_TORN};
#define LAYERS 3

struct shares {
	double *of[LAYERS];
	size_t posts;
};

static struct shares read_shares(struct furrow_world *world)
{
	struct furrow_info info;
	struct shares shares = {.posts = 0};
	for (int i = 0; i < LAYERS; i++)
		shares.of[i] = hosted_read(world, layers[i], &info);
	shares.posts = (size_t)(info.columns * info.rows);
	return shares;
}

static void free_shares(struct shares *shares)
{
	for (int i = 0; i < LAYERS; i++)
		free(shares->of[i]);
}

static bool same(const struct shares *a, const struct shares *b)
{
	bool all = true;
	for (int i = 0; i < LAYERS; i++)
		all = all && memcmp(a->of[i], b->of[i], a->posts * sizeof(double)) == 0;
	return all;
}

/* After `seconds` each mark has lost what its rate says, to a shade. */
static void assert_faded(const struct shares *before, const struct shares *after, double seconds, const double takes[LAYERS])
{
	for (int i = 0; i < LAYERS; i++) {
		size_t marked = 0;
		for (size_t post = 0; post < before->posts; post++) {
			const double was = before->of[i][post] * 255, is = after->of[i][post] * 255, left = was - 255 * seconds / takes[i];
			marked += was > 0;
			assert_true(is >= 0 && is <= was && is > left - 1.001 && is < (left > 0 ? left : 0) + 1.001);
		}
		assert_true(marked > 20);
	}
}

static void goes_back(const char *model, const char *compute)
{
	static const double takes[LAYERS] = {400, 100, 900};
	char scene[400], store[60];
	snprintf(scene, sizeof scene, "{time_step: 0.01, spacing: 0.125, soil: {name: %s}, redistribute: {model: %s}, compute: %s, attributes: {disturbance: {heals: %g}, "
		 "vegetation: {rises: %g, grows: %g}}}", strcmp(model, "sumner") == 0 ? "sand" : "dry_sand", model, compute, takes[0], takes[1], takes[2]);
	snprintf(store, sizeof store, "marks-%s-%s.furrow", model, compute);
	struct furrow_world *world = hosted_world_over(store, scene, hosted_flat);
	furrow_body ball = hosted_ball(world, 10, 16);
	make_rut(world, ball, 10, 16, 12);
	hosted_move(world, ball, 10, 16, 105);
	struct shares fresh = read_shares(world);
	done(furrow_step(world, 20));
	done(furrow_checkpoint(world));
	struct shares first = read_shares(world), ways[2];
	assert_faded(&fresh, &first, 20, takes);
	for (int i = 0; i < 2; i++) {
		make_rut(world, ball, 10.6, 16, 9);
		done(furrow_step(world, 7));
		ways[i] = read_shares(world);
		assert_false(same(&first, &ways[i]));
		done(furrow_rollback(world));
		struct shares back = read_shares(world);
		assert_true(same(&first, &back));
		free_shares(&back);
	}
	assert_true(same(&ways[0], &ways[1]));
	done(furrow_world_close(world));
	free_shares(&fresh);
	free_shares(&first);
	free_shares(&ways[0]);
	free_shares(&ways[1]);
}

static void a_rollback_leaves_the_marks_of_the_checkpoint(void **state)
{
	static const char *const cases[][2] = {{"none", "gpu"}, {"box", "cpu"}, {"slippage", "gpu"}, {"sumner", "cpu"}, {"scm", "cpu"}};
	(void)state;
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
		goes_back(cases[i][0], cases[i][1]);
}

TEST_PROGRAM(marks)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_rollback_leaves_the_marks_of_the_checkpoint),
	};
	return cmocka_run_group_tests(tests, support_enter, support_leave);
}
