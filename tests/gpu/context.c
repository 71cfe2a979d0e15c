/* The context: what it says of itself, that its counts return to nothing, that failure stays. */
#include <stdatomic.h>

#include "base/thread.h"
#include "gpu_test.h"
#include "../support/program.h"
#include "../support/skip.h"

static void it_says_what_it_is(void **state)
{
	(void)state;
	need_gpu();
	const struct gpu_info *info = gpu_info(test_gpu);
	assert_true(strlen(info->vendor) > 0 && strlen(info->renderer) > 0);
	assert_true(strncmp(info->version, "4.", 2) == 0 && info->version[2] >= '5');
	assert_int_equal(info->software, strstr(info->renderer, "llvmpipe") != NULL);
	assert_ok(gpu_check(test_gpu, "nothing"));
	gpu_finish(test_gpu);
}

static void counts_return_to_nothing(void **state)
{
	struct gpu_stats stats;
	struct gpu_texture *plane, *layers;
	struct gpu_buffer *buffer;
	struct gpu_target *target;
	(void)state;
	need_gpu();
	assert_ok(gpu_texture_create(test_gpu, GPU_R32I, 17, 9, 0, &plane));
	assert_ok(gpu_texture_create(test_gpu, GPU_R8UI, 10, 10, 3, &layers));
	assert_ok(gpu_buffer_create(test_gpu, GPU_STORAGE, 1000, NULL, &buffer));
	assert_ok(gpu_target_create(test_gpu, &(struct gpu_attachment){layers, 2}, 1, (struct gpu_attachment){NULL, 0}, &target));
	gpu_stats(test_gpu, &stats);
	assert_int_equal(stats.textures, 2);
	assert_int_equal(stats.bytes, 17 * 9 * 4 + 300 + 1000);
	gpu_target_destroy(target);
	gpu_texture_destroy(plane);
	gpu_texture_destroy(layers);
	gpu_buffer_destroy(buffer);
	gpu_stats(test_gpu, &stats);
	assert_int_equal(stats.textures, 0);
	assert_int_equal(stats.bytes, 0);
}

static void destroying_nothing_is_allowed(void **state)
{
	(void)state;
	gpu_destroy(NULL);
	gpu_texture_destroy(NULL);
	gpu_target_destroy(NULL);
	gpu_buffer_destroy(NULL);
	gpu_slots_destroy(NULL);
}

static void a_second_context_after_the_first_works_and_draws(void **state)
{
	(void)state;
	need_gpu();
	close_gpu(NULL);
	assert_ok(gpu_create(&(struct gpu_params){.draws = true}, &test_gpu));
	assert_null(getenv("LP_NUM_THREADS"));
	close_gpu(NULL);
	assert_ok(gpu_create(&(struct gpu_params){.draws = false}, &test_gpu));
}

static void a_gl_error_is_told_and_stays(void **state)
{
	struct gpu_texture *texture;
	struct gpu_buffer *buffer;
	struct gpu_program *program;
	int32_t texel = 5;
	(void)state;
	need_gpu();
	assert_ok(gpu_texture_create(test_gpu, GPU_R32I, 1, 1, 0, &texture));
	glEnable(0xffff);
	assert_int_equal(gpu_check(test_gpu, "the test"), STATUS_FAILED);
	assert_non_null(strstr(failure_message(), "the test: GL says invalid enum"));
	(void)fail_with(STATUS_FAILED, "something else");
	assert_int_equal(gpu_check(test_gpu, "later"), STATUS_FAILED);
	assert_non_null(strstr(failure_message(), "the test: GL says invalid enum"));
	assert_int_equal(gpu_buffer_create(test_gpu, GPU_INDICES, 6, NULL, &buffer), STATUS_FAILED);
	assert_int_equal(gpu_program_get(test_gpu, &(struct gpu_program_request){.vertex = "full.vert", .fragment = "decimate.frag"}, &program),
			 STATUS_FAILED);
	gpu_texture_upload(texture, 0, rect_of(0, 0, 1, 1), &texel);
	gpu_texture_read(texture, 0, rect_of(0, 0, 1, 1), &texel);
	assert_int_equal(texel, 0);
	gpu_texture_destroy(texture);
	close_gpu(NULL);
	assert_ok(gpu_create(&(struct gpu_params){.draws = false}, &test_gpu));
}

static void more_memory_than_there_is_is_refused(void **state)
{
	struct gpu_texture *texture;
	(void)state;
	need_gpu();
	enum status status = gpu_texture_create(test_gpu, GPU_R32I, 16384, 16384, 2048, &texture);
	if (status == STATUS_OK && !gpu_info(test_gpu)->software) {
		gpu_texture_destroy(texture);
		skip_since(SKIP_ELSEWHERE "the driver takes memory when a texture is used");
	}
	assert_int_equal(status, STATUS_FAILED);
	assert_non_null(strstr(failure_message(), "texture: "));
	struct gpu_stats stats;
	gpu_stats(test_gpu, &stats);
	assert_int_equal(stats.textures, 0);
	assert_int_equal(stats.bytes, 0);
	close_gpu(NULL);
	assert_ok(gpu_create(&(struct gpu_params){.draws = false}, &test_gpu));
}

enum { TURNS = 300, USERS = 2 };

struct user {
	struct thread thread;
	struct gpu *gpu;
	struct gpu_texture *texture;
	atomic_uint *inside, *most; /* threads that use GL now; the most at one time */
	enum status status;
};

static void *use_gl(void *argument)
{
	struct user *user = argument;
	const int32_t value = 1;
	for (int i = 0; i < TURNS && user->status == STATUS_OK; i++) {
		struct gpu_kept kept;
		gpu_keep(user->gpu, &kept);
		unsigned inside = 1 + atomic_fetch_add(user->inside, 1);
		if (inside > atomic_load(user->most))
			atomic_store(user->most, inside);
		user->status = gpu_take(user->gpu);
		for (int x = 0; x < 8 && user->status == STATUS_OK; x++) {
			gpu_texture_clear(user->texture, 0, rect_of(8 * x, 0, 8, 8), x);
			gpu_texture_upload(user->texture, 0, rect_of(8 * x, 0, 1, 1), &value);
		}
		if (user->status == STATUS_OK)
			user->status = gpu_check(user->gpu, "the test");
		atomic_fetch_sub(user->inside, 1);
		gpu_give(&kept);
	}
	return NULL;
}

/* On llvmpipe two threads that use GL at once crash. Freed memory is overwritten in all tests, so that they do it soon. */
static void several_threads_take_turns_on_software_gl(void **state)
{
	atomic_uint inside = 0, most = 0;
	struct user users[USERS] = {{.status = STATUS_OK}};
	(void)state;
	need_gpu();
	bool software = gpu_info(test_gpu)->software;
	close_gpu(NULL);
	for (int i = 0; i < USERS; i++) {
		struct gpu_kept kept;
		users[i] = (struct user){.inside = &inside, .most = &most};
		gpu_keep(NULL, &kept);
		assert_ok(gpu_create(&(struct gpu_params){.draws = false}, &users[i].gpu));
		assert_ok(gpu_texture_create(users[i].gpu, GPU_R32I, 64, 64, 0, &users[i].texture));
		gpu_give(&kept);
	}
	for (int i = 0; i < USERS; i++)
		assert_ok(thread_start(&users[i].thread, use_gl, &users[i], "user"));
	for (int i = 0; i < USERS; i++)
		thread_join(&users[i].thread);
	for (int i = 0; i < USERS; i++) {
		struct gpu_kept kept;
		assert_int_equal(users[i].status, STATUS_OK);
		gpu_keep(users[i].gpu, &kept);
		assert_ok(gpu_take(users[i].gpu));
		gpu_texture_destroy(users[i].texture);
		gpu_destroy(users[i].gpu);
		gpu_give(&kept);
	}
	if (software)
		assert_int_equal(most, 1);
	assert_ok(gpu_create(&(struct gpu_params){.draws = false}, &test_gpu));
}

TEST_PROGRAM(context)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(it_says_what_it_is),
		cmocka_unit_test(counts_return_to_nothing),
		cmocka_unit_test(destroying_nothing_is_allowed),
		cmocka_unit_test(a_second_context_after_the_first_works_and_draws),
		cmocka_unit_test(a_gl_error_is_told_and_stays),
		cmocka_unit_test(more_memory_than_there_is_is_refused),
		cmocka_unit_test(several_threads_take_turns_on_software_gl),
	};
	return cmocka_run_group_tests(tests, open_gpu, close_gpu);
}
