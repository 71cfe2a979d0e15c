/* Pictures on their way to their files: whole, bounded, waited for where they must be, and every failure told. */
#define _GNU_SOURCE /* pthread_setattr_default_np */
#include <errno.h>
#include <fcntl.h>
#include <glob.h>
#include <png.h>
#include <pthread.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include "../support.h"
#include "../support/program.h"
#include "../support/skip.h"

#include "gpu/internal.h"
#include "render/internal.h"
#include "render/render.h"

enum { WIDTH = 64, HEIGHT = 48, TEXELS = WIDTH * HEIGHT };

static const struct extent extent = {65, 65, 1, 32};
static struct gpu *gpu;
static struct gpu_slots *slots;
static struct render *render;
static struct pictures *pictures;

/* No two are alike, and none can be packed much. */
static void fill(uint8_t *pixels, int64_t step)
{
	uint32_t word = (uint32_t)step * 2654435761u + 1;
	for (size_t i = 0; i < 4 * TEXELS; i++) {
		word = word * 1664525u + 1013904223u;
		pixels[i] = (uint8_t)(word >> 24);
	}
}

/* As if a frame had been drawn. */
static void draw(int64_t step)
{
	static uint8_t pixels[4 * TEXELS];
	fill(pixels, step);
	gpu_texture_upload(render->screen->colour, 0, (struct gpu_rect){0, 0, WIDTH, HEIGHT}, pixels);
}

static enum status begin(int64_t step)
{
	draw(step);
	enum status status = render_pictures_begin(pictures, render, step);
	draw(-1); /* what is drawn after it is another's */
	return status;
}

static const char *name_of(int64_t step, const char *suffix)
{
	char name[64];
	snprintf(name, sizeof name, "out/frame-%06lld.png%s", (long long)step, suffix);
	return support_path(name);
}

static bool is_there(int64_t step)
{
	return access(name_of(step, ""), F_OK) == 0;
}

static void assert_whole(int64_t step)
{
	static uint8_t pixels[4 * TEXELS], back[3 * TEXELS];
	fill(pixels, step);
	png_image image = {.version = PNG_IMAGE_VERSION};
	assert_true(png_image_begin_read_from_file(&image, name_of(step, "")));
	assert_int_equal(image.width, WIDTH);
	assert_int_equal(image.height, HEIGHT);
	image.format = PNG_FORMAT_RGB;
	assert_true(png_image_finish_read(&image, NULL, back, 0, NULL));
	for (size_t y = 0; y < HEIGHT; y++)
		for (size_t x = 0; x < WIDTH; x++)
			assert_memory_equal(back + 3 * ((HEIGHT - 1 - y) * WIDTH + x), pixels + 4 * (y * WIDTH + x), 3);
}

static void assert_no_parts(void)
{
	glob_t found;
	assert_int_equal(glob(support_path("out/*.part"), 0, NULL, &found), GLOB_NOMATCH);
	globfree(&found);
}

static void open_folder(void)
{
	char command[160];
	snprintf(command, sizeof command, "rm -rf '%s'", support_path("out"));
	assert_int_equal(system(command), 0);
	assert_int_equal(mkdir(support_path("out"), 0777), 0);
}

static enum status create(void)
{
	static char folder[128];
	snprintf(folder, sizeof folder, "%s", support_path("out"));
	pictures = NULL;
	return render_pictures_create(gpu, folder, 4 * TEXELS, &pictures);
}

static int enter(void **state)
{
	if (support_enter(state) != 0)
		return -1;
	enum status status = gpu_create(&(struct gpu_params){.draws = true}, &gpu);
	if (status == STATUS_NO_GL)
		return 0;
	struct render_params params = {.extent = &extent, .low = 0, .high = 1, .width = WIDTH, .height = HEIGHT};
	if (status == STATUS_OK)
		status = gpu_slots_create(gpu, extent.cells, 1, 0, &slots);
	params.gpu = gpu;
	params.slots = slots;
	if (status == STATUS_OK)
		status = render_create(&params, &render);
	return status == STATUS_OK ? 0 : -1;
}

static int leave(void **state)
{
	render_destroy(render);
	gpu_slots_destroy(slots);
	gpu_destroy(gpu);
	return support_leave(state);
}

static void open_up(void)
{
	if (gpu == NULL)
		skip_since("no GL");
	open_folder();
	must(create());
}

static void close_down(void)
{
	render_pictures_destroy(pictures);
	assert_int_equal(thread_running(), 0);
}

/* --- a file whose writing begins when the test says so --- */

static void block(int64_t step)
{
	assert_int_equal(mkfifo(name_of(step, ".part"), 0600), 0);
}

/* Waits until the main thread sleeps, as it does once it waits for a picture: then it sleeps each time that this looks. */
static void await_sleep(void)
{
	for (int asleep = 0; asleep < 10;) {
		char path[64], text[256] = "";
		snprintf(path, sizeof path, "/proc/self/task/%d/stat", (int)getpid());
		const int file = open(path, O_RDONLY);
		assert_true(file >= 0 && read(file, text, sizeof text - 1) > 0);
		close(file);
		const char *state = strrchr(text, ')');
		asleep = state != NULL && state[1] == ' ' && state[2] == 'S' ? asleep + 1 : 0;
		usleep(1000);
	}
}

/* The writer's open of the pipe, and its write, go on. */
static void *unblock_body(void *path)
{
	char bytes[4096];
	await_sleep();
	int file = open(path, O_RDONLY);
	while (file >= 0 && read(file, bytes, sizeof bytes) > 0)
		;
	close(file);
	return NULL;
}

static pthread_t unblock(int64_t step)
{
	static char path[128];
	pthread_t thread;
	snprintf(path, sizeof path, "%s", name_of(step, ".part"));
	assert_int_equal(pthread_create(&thread, NULL, unblock_body, path), 0);
	return thread;
}

static uint64_t written(void)
{
	struct render_pictures_figures figures;
	render_pictures_figures(pictures, &figures);
	return figures.written;
}

/* --- tests --- */

static void every_picture_is_whole_whatever_is_drawn_after(void **state)
{
	open_up();
	for (int64_t step = 0; step < 20; step++)
		must(begin(step));
	render_pictures_stop(pictures);
	assert_int_equal(written(), 20);
	for (int64_t step = 0; step < 20; step++)
		assert_whole(step);
	assert_no_parts();
	close_down();
}

/* As hardware does it: fences, and bytes that are there later. */
static void open_up_with_fences(void)
{
	if (gpu == NULL)
		skip_since("no GL");
	bool software = gpu->info.software;
	open_folder();
	gpu->info.software = false;
	enum status status = create();
	gpu->info.software = software;
	must(status);
}

static void so_it_is_with_fences(void **state)
{
	open_up_with_fences();
	for (int64_t step = 0; step < 20; step++) {
		must(begin(step));
		if (step % 7 == 6) {
			render_pictures_mark(pictures);
			must(render_pictures_await(pictures));
			assert_int_equal(written(), step + 1);
		}
		must(render_pictures_poll(pictures));
	}
	close_down();
	for (int64_t step = 0; step < 20; step++)
		assert_whole(step);
	assert_no_parts();
}

static void begun_is_ended_by_destroy_alone(void **state)
{
	open_up_with_fences();
	for (int64_t step = 0; step < PICTURES_ROOM; step++)
		must(begin(step));
	close_down();
	for (int64_t step = 0; step < PICTURES_ROOM; step++)
		assert_whole(step);
	assert_no_parts();
}

static void only_so_many_are_under_way(void **state)
{
	open_up();
	block(0);
	for (int64_t step = 0; step < PICTURES_ROOM; step++)
		must(begin(step));
	assert_int_equal(written(), 0);
	pthread_t thread = unblock(0);
	must(begin(PICTURES_ROOM));
	assert_true(written() >= 1);
	pthread_join(thread, NULL);
	render_pictures_stop(pictures);
	struct render_pictures_figures figures;
	render_pictures_figures(pictures, &figures);
	assert_int_equal(figures.waits, 1);
	assert_true(figures.wait_ms > 0);
	for (int64_t step = 1; step <= PICTURES_ROOM; step++)
		assert_whole(step);
	close_down();
}

static void what_was_marked_is_awaited_and_no_more(void **state)
{
	open_up();
	must(render_pictures_await(pictures)); /* nothing was */
	must(begin(0));
	must(begin(1));
	render_pictures_mark(pictures);
	block(2);
	must(begin(2));
	must(render_pictures_await(pictures));
	assert_whole(0);
	assert_whole(1);
	assert_int_equal(written(), 2);
	render_pictures_mark(pictures);
	pthread_t thread = unblock(2);
	must(render_pictures_await(pictures));
	assert_int_equal(written(), 3);
	pthread_join(thread, NULL);
	close_down();
	must(render_pictures_begin(NULL, render, 1));
	must(render_pictures_poll(NULL));
	must(render_pictures_await(NULL));
}

/* Three pictures of which the one of step 1 cannot be written. */
static void fails(const char *why)
{
	bool failed = false;
	for (int64_t step = 0; step < 3; step++)
		failed = begin(step) != STATUS_OK || failed;
	render_pictures_mark(pictures);
	assert_int_equal(render_pictures_await(pictures), STATUS_FAILED);
	assert_non_null(strstr(failure_message(), name_of(1, "")));
	assert_non_null(strstr(failure_message(), why));
	assert_non_null(strstr(failure_message(), "; "));
	/* For good, and of the first. */
	(void)!fail_with(STATUS_OK, "another");
	assert_int_equal(render_pictures_poll(pictures), STATUS_FAILED);
	assert_non_null(strstr(failure_message(), why));
	assert_int_equal(begin(3), STATUS_FAILED);
	close_down();
	assert_whole(0);
	assert_false(is_there(3));
	if (!failed)
		assert_whole(2);
	assert_no_parts();
}

static void a_full_disk_is_told_and_the_others_are_whole(void **state)
{
	open_up();
	if (access("/dev/full", W_OK) != 0 || symlink("/dev/full", name_of(1, ".part")) != 0) {
		close_down();
		skip_since(SKIP_ELSEWHERE "no /dev/full");
	}
	fails("No space left");
	assert_false(is_there(1));
}

static void so_is_a_place_that_is_taken(void **state)
{
	open_up();
	assert_int_equal(mkdir(name_of(1, ""), 0777), 0);
	fails("check the folder's permissions");
}

static void the_first_failure_is_told_and_the_rest_is_tried(void **state)
{
	open_up();
	block(0);
	assert_int_equal(mkdir(name_of(1, ""), 0777), 0);
	assert_int_equal(mkdir(name_of(2, ".part"), 0777), 0);
	for (int64_t step = 0; step < PICTURES_ROOM; step++)
		must(begin(step));
	render_pictures_mark(pictures);
	pthread_t thread = unblock(0);
	assert_int_equal(render_pictures_await(pictures), STATUS_FAILED);
	assert_non_null(strstr(failure_message(), "check the folder's permissions"));
	assert_int_equal(written(), 1);
	pthread_join(thread, NULL);
	close_down();
}

static void so_is_a_file_that_cannot_be_made(void **state)
{
	open_up();
	assert_int_equal(mkdir(name_of(1, ".part"), 0777), 0);
	(void)!begin(1); /* which may see it already */
	render_pictures_mark(pictures);
	assert_int_equal(render_pictures_await(pictures), STATUS_FAILED);
	assert_non_null(strstr(failure_message(), "give a file that can be written"));
	close_down();
	open_folder();
	must(create());
	assert_int_equal(rmdir(support_path("out")), 0);
	(void)!begin(1);
	render_pictures_mark(pictures);
	assert_int_equal(render_pictures_await(pictures), STATUS_FAILED);
	assert_non_null(strstr(failure_message(), "/out is not there; make it"));
	close_down();
}

static void a_disk_that_is_full_after_any_byte_is_told(void **state)
{
	struct rlimit before, limit;
	struct stat whole;
	open_up();
	must(begin(1));
	close_down();
	assert_int_equal(stat(name_of(1, ""), &whole), 0);
	assert_true(whole.st_size > 5000);
	signal(SIGXFSZ, SIG_IGN);
	assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
	for (off_t room = 0; room <= whole.st_size; room += room < whole.st_size - 700 ? 700 : whole.st_size - room > 1 ? whole.st_size - room - 1 : 1) {
		open_folder();
		must(create());
		limit = before;
		limit.rlim_cur = (rlim_t)room;
		assert_int_equal(setrlimit(RLIMIT_FSIZE, &limit), 0);
		enum status begun = begin(1);
		render_pictures_mark(pictures);
		enum status status = render_pictures_await(pictures);
		assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
		assert_int_equal(status, room < whole.st_size ? STATUS_FAILED : STATUS_OK);
		assert_true(begun == STATUS_OK || begun == status);
		close_down();
		assert_int_equal(is_there(1), room == whole.st_size);
		assert_no_parts();
	}
}

static void each_allocation_that_fails_is_told(void **state)
{
	if (gpu == NULL)
		skip_since("no GL");
	int failed = 0;
	for (uint64_t nth = 1; nth < 100; nth++) {
		open_folder();
		mem_fail_nth(nth, 0);
		enum status status = create(), begun = status, ended = status;
		if (status == STATUS_OK) {
			begun = begin(1);
			render_pictures_mark(pictures);
			ended = render_pictures_await(pictures);
			close_down();
		}
		uint64_t made = mem_fail_nth(0, 0);
		assert_int_equal(thread_running(), 0);
		assert_no_parts();
		assert_int_equal(ended, made >= nth ? STATUS_FAILED : STATUS_OK);
		assert_true(begun == STATUS_OK || begun == STATUS_FAILED);
		assert_int_equal(is_there(1), ended == STATUS_OK);
		if (ended == STATUS_OK)
			break;
		failed++;
		assert_non_null(strstr(failure_message(), "memory"));
	}
	assert_true(failed >= 1 + PICTURES_ROOM + 2);
	assert_whole(1);
}

static void a_thread_that_cannot_be_had_is_told(void **state)
{
	pthread_attr_t before, huge;
	if (gpu == NULL)
		skip_since("no GL");
	assert_int_equal(pthread_getattr_default_np(&before), 0);
	assert_int_equal(pthread_attr_init(&huge), 0);
	assert_int_equal(pthread_attr_setstacksize(&huge, (size_t)1 << 47), 0);
	assert_int_equal(pthread_setattr_default_np(&huge), 0);
	enum status status = create();
	assert_int_equal(pthread_setattr_default_np(&before), 0);
	pthread_attr_destroy(&huge);
	pthread_attr_destroy(&before);
	assert_int_equal(status, STATUS_FAILED);
	assert_non_null(strstr(failure_message(), PICTURES_THREAD));
	assert_null(pictures);
	assert_int_equal(thread_running(), 0);
}

/* The last: nothing mends the GPU. */
static void what_the_gpu_did_not_give_is_no_picture(void **state)
{
	open_up();
	must(begin(1));
	(void)gpu_fail(gpu, fail_with(STATUS_FAILED, "the GPU: is gone; run again"));
	assert_int_equal(begin(2), STATUS_FAILED);
	assert_non_null(strstr(failure_message(), "is gone"));
	close_down();
	assert_false(is_there(2));
	assert_no_parts();
}

TEST_PROGRAM(image_files)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(every_picture_is_whole_whatever_is_drawn_after),
		cmocka_unit_test(so_it_is_with_fences),
		cmocka_unit_test(begun_is_ended_by_destroy_alone),
		cmocka_unit_test(only_so_many_are_under_way),
		cmocka_unit_test(what_was_marked_is_awaited_and_no_more),
		cmocka_unit_test(a_full_disk_is_told_and_the_others_are_whole),
		cmocka_unit_test(so_is_a_place_that_is_taken),
		cmocka_unit_test(the_first_failure_is_told_and_the_rest_is_tried),
		cmocka_unit_test(so_is_a_file_that_cannot_be_made),
		cmocka_unit_test(a_disk_that_is_full_after_any_byte_is_told),
		cmocka_unit_test(each_allocation_that_fails_is_told),
		cmocka_unit_test(a_thread_that_cannot_be_had_is_told),
		cmocka_unit_test(what_the_gpu_did_not_give_is_no_picture),
	};
	return cmocka_run_group_tests_name("image_files", tests, enter, leave);
}
