/* Where pressed soil goes: the nearest free posts of its row and column, every quantum of it. */
#include "ground.h"

#define N 24 /* posts a side of what is written */

struct field {
	int32_t carried[N * N], deposits[N * N];
	uint8_t contacts[N * N];
	int64_t compacted, confined;
};

static bool is_free(const struct field *field, int x, int y)
{
	return field->contacts[y * N + x] == 0;
}

/* As SOIL.md says it, one post at a time. */
static void spread(struct field *field)
{
	static const int ways[4][2] = {{0, -1}, {-1, 0}, {1, 0}, {0, 1}};
	memset(field->deposits, 0, sizeof field->deposits);
	field->compacted = field->confined = 0;
	for (int y = 0; y < N; y++)
		for (int x = 0; x < N; x++) {
			int32_t amount = field->carried[y * N + x];
			int to[4], count = 0;
			for (int far = 1; far < N && count == 0 && amount > 0; far++)
				for (int way = 0; way < 4; way++) {
					int px = x + far * ways[way][0], py = y + far * ways[way][1];
					if (px >= 0 && py >= 0 && px < N && py < N && is_free(field, px, py))
						to[count++] = py * N + px;
				}
			for (int i = 0; i < count; i++)
				field->deposits[to[i]] = (int32_t)((uint32_t)field->deposits[to[i]] + (uint32_t)(amount / count) +
								   (i == 0 ? (uint32_t)(amount % count) : 0));
			if (count == 0 && amount > 0) {
				field->compacted += amount;
				field->confined++;
			}
		}
}

/* Of the window at `at` in the scratch. */
static void spread_on_gpu(struct ground *ground, struct field *field, uint32_t at)
{
	struct deform *deform = ground->deform;
	struct deform_tally before, after;
	struct gpu_rect rect = rect_of(at, at, N, N), around = rect_of(0, 0, N + 2 * at, N + 2 * at);
	struct deform_window window = {{0, 0, N + 2 * at, N + 2 * at}, {at, at, at + N, at + N}};
	/* Around it all is free, and carries: another window's. */
	gpu_texture_clear(deform->contacts, 0, around, 0);
	gpu_texture_clear(deform->carried, 0, around, 1000);
	gpu_texture_clear(deform->deposits, 0, around, -7);
	gpu_texture_upload(deform->contacts, 0, rect, field->contacts);
	gpu_texture_upload(deform->carried, 0, rect, field->carried);
	assert_ok(deform_tally(deform, &before));
	assert_ok(deform_spread(deform, &window, 0));
	gpu_texture_read(deform->deposits, 0, rect, field->deposits);
	assert_ok(deform_tally(deform, &after));
	field->compacted = after.compacted - before.compacted;
	field->confined = (int64_t)(after.confined - before.confined);
	assert_int_equal(after.refused, before.refused);
}

static void every_quantum_goes_where_it_must(void **state)
{
	static struct field field, expected;
	struct ground ground;
	int64_t confined = 0;
	(void)state;
	need_gpu();
	ground_init(&ground, &(struct ground_params){.cells = 32, .tiles = 1, .spacing = 0.125, .model = DEFORM_SLIPPAGE});
	for (int round = 0; round < 60; round++) {
		/* From few free posts to many; holes; up to what a press may carry. */
		uint32_t blocked = (uint32_t)round * 4294967295u / 60;
		for (int i = 0; i < N * N; i++) {
			bool hole = any_word() % 16 == 0;
			field.contacts[i] = hole ? 4 : any_word() >= blocked ? 1 + any_word() % 3 : 0;
			if (round == 7)
				field.contacts[i] = i % N != 0; /* all towards one side */
			field.carried[i] = field.contacts[i] % 4 == 0 ? 0
					   : round % 3 == 0 ? 1 << 23 : (int32_t)(any_word() % (1u << (round % 24)));
			if (i % 2)
				field.carried[i] -= field.carried[i] % 3; /* three have the same then, and nothing is left */
		}
		expected = field;
		spread(&expected);
		spread_on_gpu(&ground, &field, round % 2 ? 3 : 0);
		confined += expected.confined;
		assert_memory_equal(field.deposits, expected.deposits, sizeof field.deposits);
		assert_int_equal(field.compacted, expected.compacted);
		assert_int_equal(field.confined, expected.confined);
	}
	assert_true(confined > 100);
	ground_finish(&ground);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(every_quantum_goes_where_it_must),
	};
	return cmocka_run_group_tests_name("deform/spread", tests, open_gpu, close_gpu);
}
