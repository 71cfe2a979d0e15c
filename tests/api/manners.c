/* What a host has and the library leaves alone: its output, locale, environment, signals, and EGL context. */
#include "hosted.h"
#include "../support/program.h"
#include "../support/skip.h"

#include <fcntl.h>
#include <locale.h>
#include <signal.h>

#include <epoxy/egl.h>
#include <epoxy/gl.h>

extern char **environ;

/* --- a host's context --- */

struct screen {
	EGLDisplay display;
	EGLContext context;
};

static bool open_screen(struct screen *screen)
{
	screen->display = eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, NULL);
	if (screen->display == EGL_NO_DISPLAY || !eglInitialize(screen->display, NULL, NULL) || !eglBindAPI(EGL_OPENGL_ES_API))
		return false;
	const EGLint version[] = {EGL_CONTEXT_MAJOR_VERSION, 3, EGL_NONE};
	screen->context = eglCreateContext(screen->display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, version);
	return screen->context != EGL_NO_CONTEXT && eglMakeCurrent(screen->display, EGL_NO_SURFACE, EGL_NO_SURFACE, screen->context);
}

static void assert_current(const struct screen *screen, const char *after)
{
	if (eglGetCurrentContext() != screen->context)
		print_error("after %s the host's context is not current\n", after);
	assert_ptr_equal(eglGetCurrentContext(), screen->context);
	assert_ptr_equal(eglGetCurrentDisplay(), screen->display);
	assert_ptr_equal(eglGetCurrentSurface(EGL_DRAW), EGL_NO_SURFACE);
	assert_int_equal(eglQueryAPI(), EGL_OPENGL_ES_API);
	assert_int_equal(glGetError(), GL_NO_ERROR);
	GLint value = 0;
	glGetIntegerv(GL_UNPACK_ALIGNMENT, &value);
	assert_int_equal(value, 2);
}

#define drawn(call)                            \
	do {                                   \
		done(call);                    \
		assert_current(&screen, #call); \
	} while (0)

static void the_context_of_the_host_is_current_after_every_call(void **state)
{
	struct screen screen;
	if (!open_screen(&screen))
		skip_since("no GL on a device");
	glPixelStorei(GL_UNPACK_ALIGNMENT, 2);
	const char *store = support_path("context.furrow");
	support_store(store, hosted_extent, hosted_flat);
	const struct furrow_open open = hosted_open(HOSTED_SCENE, store);
	struct furrow_world *world;
	struct furrow_info info = {.size = sizeof info};
	struct furrow_contact contact;
	struct furrow_state body_state = hosted_state(16, 16, 100.4);
	const struct furrow_pose pose = hosted_pose(16, 16, 100.5);
	const struct furrow_camera camera = {sizeof camera, hosted_pose(16, 16, 103), 1, 32, 32};
	const double xy[2] = {16, 16}, at[3] = {16, 16, 103}, down[3] = {0, 0, -1};
	struct furrow_point point;
	struct furrow_hit hit;
	struct furrow_rect rects[64];
	size_t count = 64;
	uint8_t rgb[3 * 32 * 32];
	double post;
	char *json;
	furrow_body ball;
	drawn(furrow_world_open(&open, &world));
	drawn(furrow_body_add(world, HOSTED_BALL, &ball));
	drawn(furrow_place(world, ball, &pose));
	drawn(furrow_set_states(world, 1, &ball, &body_state));
	drawn(furrow_step(world, 0));
	drawn(furrow_get_contacts(world, 1, &ball, &contact, sizeof contact));
	drawn(furrow_points(world, 1, xy, &point));
	drawn(furrow_rays(world, 1, at, down, &hit));
	drawn(furrow_info(world, &info));
	drawn(furrow_read(world, FURROW_OFFSET, info.level, 128, 128, 1, 1, &post, 1));
	drawn(furrow_changes(world, 0, rects, &count, NULL));
	drawn(furrow_render(world, &camera, rgb, NULL));
	drawn(furrow_checkpoint(world));
	drawn(furrow_step(world, 0));
	drawn(furrow_rollback(world));
	drawn(furrow_stats(world, &json));
	furrow_free(json);
	drawn(furrow_body_remove(world, ball));
	/* Calls that fail, too. */
	const struct furrow_open wrong = hosted_open("{", store);
	struct furrow_world *none;
	refused(FURROW_INPUT, furrow_world_open(&wrong, &none));
	assert_current(&screen, "a failed opening");
	misused(furrow_step(world, -1));
	assert_current(&screen, "a failed step");
	drawn(furrow_world_close(world));
	/* Without a context there is none afterwards. */
	eglMakeCurrent(screen.display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
	done(furrow_world_open(&open, &world));
	assert_ptr_equal(eglGetCurrentContext(), EGL_NO_CONTEXT);
	done(furrow_step(world, 0));
	assert_ptr_equal(eglGetCurrentContext(), EGL_NO_CONTEXT);
	done(furrow_world_close(world));
	eglDestroyContext(screen.display, screen.context);
}

/* --- the process --- */

/* A life of a world, its failures included. No check in it, since the output goes elsewhere meanwhile. */
static furrow_status live(const char *store, const char *output, bool resume)
{
	struct furrow_open open = hosted_open(HOSTED_SCENE, store);
	struct furrow_world *world;
	const char *missing[] = {"/nonexistent/dem.tif"};
	open.resume = resume;
	open.output = output;
	furrow_status status = furrow_world_open(&open, &world);
	if (status != FURROW_OK)
		return status;
	furrow_body ball;
	const struct furrow_pose pose = hosted_pose(16, 16, 100.5);
	const struct furrow_camera camera = {sizeof camera, hosted_pose(16, 16, 103), 1, 32, 32};
	static uint8_t rgb[3 * 32 * 32];
	status = furrow_body_add(world, HOSTED_BALL, &ball);
	if (status == FURROW_OK)
		status = furrow_place(world, ball, &pose);
	for (int i = 0; i < 20 && status == FURROW_OK; i++) {
		const struct furrow_state body_state = hosted_state(16 + 0.1 * i, 16, 100.4);
		status = furrow_set_states(world, 1, &ball, &body_state);
		if (status == FURROW_OK)
			status = furrow_step(world, 0);
		if (status == FURROW_OK && i == 10)
			status = furrow_checkpoint(world);
	}
	if (status == FURROW_OK)
		status = furrow_render(world, &camera, rgb, NULL);
	if (status == FURROW_OK)
		status = furrow_rollback(world);
	if (furrow_step(world, NAN) != FURROW_USAGE || furrow_body_add(world, "{", &ball) != FURROW_INPUT)
		status = FURROW_FAILED;
	if (furrow_import(missing, 1, "/nonexistent/out.furrow", NULL, NULL, NULL) == FURROW_OK)
		status = FURROW_FAILED;
	const furrow_status closed = furrow_world_close(world);
	return status != FURROW_OK ? status : closed;
}

/* Both outputs go to a file; returns the bytes that came. */
static off_t captured(const char *store, const char *output, furrow_status *status)
{
	fflush(stdout);
	fflush(stderr);
	const int file = open(support_path("printed"), O_RDWR | O_CREAT | O_TRUNC, 0600);
	const int kept[2] = {dup(1), dup(2)};
	dup2(file, 1);
	dup2(file, 2);
	*status = live(store, output, true);
	fflush(stdout);
	fflush(stderr);
	dup2(kept[0], 1);
	dup2(kept[1], 2);
	close(kept[0]);
	close(kept[1]);
	const off_t bytes = lseek(file, 0, SEEK_END);
	if (bytes > 0) {
		char text[512] = "";
		const ssize_t length = pread(file, text, sizeof text - 1, 0);
		print_error("printed (%zd bytes): %s\n", length, text);
	}
	close(file);
	return bytes;
}

static void nothing_is_printed(void **state)
{
	furrow_status status;
	const char *store = support_path("quiet.furrow");
	support_store(store, hosted_extent, hosted_flat);
	const off_t bytes = captured(store, support_path("quiet"), &status);
	done(status);
	assert_int_equal(bytes, 0);
	assert_int_equal(access(support_path("quiet/run.json"), F_OK), 0);
}

struct notes {
	int count, level;
	char last[256];
};

static void take_note(int level, const char *message, void *user)
{
	struct notes *notes = user;
	notes->count++;
	notes->level = level;
	snprintf(notes->last, sizeof notes->last, "%s", message);
}

static void notes_go_to_the_log(void **state)
{
	struct notes notes = {.count = 0, .level = -1};
	const char *store = support_path("noted.furrow");
	support_store(store, hosted_extent, hosted_flat);
	furrow_set_log(take_note, &notes);
	const furrow_status status = live(store, NULL, true); /* nothing to resume: worth a note */
	furrow_set_log(NULL, NULL);
	done(status);
	assert_true(notes.count > 0);
	assert_int_equal(notes.level, 0);
	assert_true(strlen(notes.last) > 0 && strchr(notes.last, '\n') == NULL);
	const int told = notes.count;
	support_store(store, hosted_extent, hosted_flat);
	done(live(store, NULL, true));
	assert_int_equal(notes.count, told);
}

/* A word that changes when a variable does. */
static uint64_t environment(void)
{
	uint64_t hash = 14695981039346656037u;
	for (char **at = environ; *at != NULL; at++)
		for (const char *c = *at; *c != '\0'; c++)
			hash = (hash ^ (uint8_t)*c) * 1099511628211u;
	return hash;
}

static void the_process_is_left_as_it_was(void **state)
{
	struct sigaction handlers[32], after;
	char locale[256];
	const char *store = support_path("process.furrow");
	support_store(store, hosted_extent, hosted_flat);
	unsetenv("LP_NUM_THREADS");
	setlocale(LC_ALL, "");
	snprintf(locale, sizeof locale, "%s", setlocale(LC_ALL, NULL));
	const locale_t used = uselocale((locale_t)0);
	const uint64_t variables = environment();
	memset(handlers, 0, sizeof handlers);
	for (int i = 1; i < 32; i++)
		sigaction(i, NULL, &handlers[i]);
	char folder[256], folder_after[256];
	assert_non_null(getcwd(folder, sizeof folder));

	done(live(store, NULL, false));

	assert_string_equal(setlocale(LC_ALL, NULL), locale);
	assert_ptr_equal(uselocale((locale_t)0), used);
	assert_true(environment() == variables);
	assert_null(getenv("LP_NUM_THREADS"));
	for (int i = 1; i < 32; i++) {
		sigaction(i, NULL, &after);
		assert_ptr_equal(after.sa_handler, handlers[i].sa_handler);
		assert_int_equal(after.sa_flags, handlers[i].sa_flags);
	}
	assert_non_null(getcwd(folder_after, sizeof folder_after));
	assert_string_equal(folder_after, folder);
}

TEST_PROGRAM(manners)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(the_context_of_the_host_is_current_after_every_call),
		cmocka_unit_test(nothing_is_printed),
		cmocka_unit_test(notes_go_to_the_log),
		cmocka_unit_test(the_process_is_left_as_it_was),
	};
	return cmocka_run_group_tests(tests, support_enter, support_leave);
}
