/*
 * A ring of staging memory between the GPU and one thread that writes.
 *
 *     free -> begun (the GPU fills it) -> handed (waits for the thread, or is being written) -> free
 *
 * Places are used in turn, so three counts of pictures tell the state of each. Pictures from `written` to `handed` are the
 * thread's. Those from `handed` to `begun` are the GPU's.
 *
 * Invariants:
 *   1. written <= handed <= begun <= written + PICTURES_ROOM.
 *   2. Only the thread uses the bytes of a place from when it is handed until it is written.
 *   3. The thread takes every place that it is handed, in order, even after a failure. So every wait for it ends.
 */
#include "render/internal.h"

#include <assert.h>
#include <stdio.h>
#include <time.h>

#include "scene/scene.h"

struct pictures {
	struct gpu *gpu;
	const char *directory;
	size_t bytes; /* of a place */
	struct gpu_staging *places[PICTURES_ROOM];
	struct render_picture pictures[PICTURES_ROOM];
	struct thread thread;
	uint64_t begun;              /* only the owner uses it */
	struct mutex mutex;          /* guards what follows */
	struct render_pictures_figures figures; /* its waits are the owner's alone */
	struct condition changed;
	uint64_t handed, written, marked;
	bool stopping;
	struct failure failure;      /* the first; STATUS_OK until then */
};

static void fail_locked(struct pictures *pictures, enum status status)
{
	if (pictures->failure.status == STATUS_OK)
		failure_capture(&pictures->failure, status);
}

static enum status sticky_locked(const struct pictures *pictures)
{
	return pictures->failure.status == STATUS_OK ? STATUS_OK : failure_restore(&pictures->failure);
}

static enum status sticky(struct pictures *pictures)
{
	mutex_lock(&pictures->mutex);
	enum status status = sticky_locked(pictures);
	mutex_unlock(&pictures->mutex);
	return status;
}

/* --- the thread --- */

/* Returns what share of the pixels is black, or white; less than RENDER_BLACK_SHARE as soon as so many are not. */
static double share_of(const struct render_picture *picture, const uint8_t *pixels, bool white)
{
	const size_t count = (size_t)picture->width * picture->height, enough = (size_t)((1 - RENDER_BLACK_SHARE) * (double)count) + 1;
	size_t others = 0;
	for (const uint8_t *pixel = pixels; pixel < pixels + 4 * count && others < enough; pixel += 4)
		others += white ? pixel[0] < RENDER_WHITE || pixel[1] < RENDER_WHITE || pixel[2] < RENDER_WHITE
				: pixel[0] > RENDER_BLACK || pixel[1] > RENDER_BLACK || pixel[2] > RENDER_BLACK;
	return 1 - (double)others / (double)count;
}

static void name_file(const struct render_picture *picture, char name[160])
{
	if (picture->frame < 0)
		snprintf(name, 160, "%.100s.png", picture->name);
	else
		snprintf(name, 160, "%.100s/%s/%06lld.png", picture->name, scene_image_name(picture->image), (long long)picture->frame);
}

/* Counts the picture if it is black or white. */
static void look(struct pictures *pictures, uint64_t which)
{
	const struct render_picture *picture = &pictures->pictures[which % PICTURES_ROOM];
	const uint8_t *pixels = gpu_staging_bytes(pictures->places[which % PICTURES_ROOM]);
	struct render_pictures_figures *figures = &pictures->figures;
	if (picture->image != SCENE_IMAGE_COLOUR)
		return;
	const double dark = share_of(picture, pixels, false), bright = share_of(picture, pixels, true);
	mutex_lock(&pictures->mutex);
	if (dark >= RENDER_BLACK_SHARE && figures->black++ == 0) {
		figures->dark = dark;
		figures->groundless_black = picture->triangles == 0;
		name_file(picture, figures->first_black);
	}
	if (bright >= RENDER_BLACK_SHARE && figures->white++ == 0) {
		figures->bright = bright;
		figures->exposed_white = picture->exposure;
		figures->groundless_white = picture->triangles == 0;
		name_file(picture, figures->first_white);
	}
	mutex_unlock(&pictures->mutex);
}

static enum status write_one(struct pictures *pictures, uint64_t which)
{
	uint64_t place = which % PICTURES_ROOM;
	look(pictures, which);
	return render_picture_write(pictures->directory, &pictures->pictures[place], gpu_staging_bytes(pictures->places[place]));
}

static void *write_body(void *argument)
{
	struct pictures *pictures = argument;
	mutex_lock(&pictures->mutex);
	while (!pictures->stopping || pictures->written < pictures->handed) {
		if (pictures->written == pictures->handed) {
			condition_wait(&pictures->changed, &pictures->mutex);
			continue;
		}
		uint64_t which = pictures->written;
		mutex_unlock(&pictures->mutex);
		enum status status = write_one(pictures, which);
		mutex_lock(&pictures->mutex);
		if (status == STATUS_OK)
			pictures->figures.written++;
		else
			fail_locked(pictures, status);
		pictures->written++;
		condition_wake_all(&pictures->changed);
	}
	mutex_unlock(&pictures->mutex);
	return NULL;
}

/* --- the owner --- */

/* Hands pictures that were read back to the thread. If a read-back failed, all pictures after it are dropped. */
static void hand_over(struct pictures *pictures)
{
	while (pictures->handed < pictures->begun &&
	       gpu_staging_idle(pictures->places[pictures->handed % PICTURES_ROOM])) {
		enum status status = gpu_check(pictures->gpu, "reading a picture back");
		mutex_lock(&pictures->mutex);
		if (status == STATUS_OK) {
			pictures->handed++;
		} else {
			fail_locked(pictures, status);
			pictures->begun = pictures->handed;
		}
		condition_wake_all(&pictures->changed);
		mutex_unlock(&pictures->mutex);
	}
}

/* Waits until `handed` pictures were handed over, or until a failed read-back dropped the rest. Only the owner looks at fences. */
static void wait_for_gpu(struct pictures *pictures, uint64_t handed)
{
	const struct timespec nap = {0, 200000};
	hand_over(pictures);
	while (pictures->handed < handed && pictures->handed < pictures->begun) {
		nanosleep(&nap, NULL);
		hand_over(pictures);
	}
}

static void wait_until_written_locked(struct pictures *pictures, uint64_t written)
{
	while (pictures->written < written)
		condition_wait(&pictures->changed, &pictures->mutex);
}

/* Waits for the place of the next picture. */
static void wait_for_room(struct pictures *pictures)
{
	mutex_lock(&pictures->mutex);
	bool full = pictures->begun - pictures->written == PICTURES_ROOM;
	mutex_unlock(&pictures->mutex);
	if (!full)
		return;
	double started = clock_seconds();
	uint64_t first = pictures->begun - PICTURES_ROOM + 1;
	wait_for_gpu(pictures, first);
	mutex_lock(&pictures->mutex);
	wait_until_written_locked(pictures, first < pictures->handed ? first : pictures->handed);
	mutex_unlock(&pictures->mutex);
	pictures->figures.waits++;
	pictures->figures.wait_ms += (clock_seconds() - started) * 1e3;
}

static size_t bytes_of(uint64_t width, uint64_t height, bool measured)
{
	return width * height * gpu_format_bytes(measured ? GPU_RGBA32F : GPU_SRGB8_ALPHA8);
}

enum status render_pictures_begin(struct pictures *pictures, struct render *render, int64_t step)
{
	struct render_picture picture = {SCENE_IMAGE_COLOUR, render->screen->width, render->screen->height, .unit = 1, .frame = -1, .exposure = render_exposed(render),
					.triangles = render_triangles(render)};
	snprintf(picture.name, sizeof picture.name, "frame-%06lld", (long long)step);
	return render_pictures_add(pictures, render, &picture);
}

enum status render_pictures_add(struct pictures *pictures, struct render *render, const struct render_picture *picture)
{
	if (pictures == NULL)
		return STATUS_OK;
	assert(bytes_of(picture->width, picture->height, picture->images != 0 || picture->image == SCENE_IMAGE_LINEAR) <= pictures->bytes);
	wait_for_room(pictures);
	TRY(sticky(pictures));
	uint64_t place = pictures->begun % PICTURES_ROOM;
	pictures->pictures[place] = *picture;
	render_read_into(render, picture->image, pictures->places[place]);
	pictures->begun++;
	return render_pictures_poll(pictures);
}

enum status render_pictures_poll(struct pictures *pictures)
{
	if (pictures == NULL)
		return STATUS_OK;
	hand_over(pictures);
	return sticky(pictures);
}

void render_pictures_mark(struct pictures *pictures)
{
	if (pictures == NULL)
		return;
	hand_over(pictures);
	bool all = pictures->handed == pictures->begun;
	double started = clock_seconds();
	wait_for_gpu(pictures, pictures->begun);
	if (!all) {
		pictures->figures.waits++;
		pictures->figures.wait_ms += (clock_seconds() - started) * 1e3;
	}
	mutex_lock(&pictures->mutex);
	pictures->marked = pictures->handed;
	mutex_unlock(&pictures->mutex);
}

enum status render_pictures_await(struct pictures *pictures)
{
	if (pictures == NULL)
		return STATUS_OK;
	mutex_lock(&pictures->mutex);
	wait_until_written_locked(pictures, pictures->marked);
	enum status status = sticky_locked(pictures);
	mutex_unlock(&pictures->mutex);
	return status;
}

void render_pictures_figures(struct pictures *pictures, struct render_pictures_figures *figures)
{
	mutex_lock(&pictures->mutex);
	*figures = pictures->figures;
	mutex_unlock(&pictures->mutex);
}

/* --- life --- */

size_t render_pictures_bytes(const struct scene *scene)
{
	const struct scene_view *view = &scene->view;
	size_t most = view->images > 0 ? bytes_of((uint64_t)view->width, (uint64_t)view->height, false) : 0;
	for (size_t i = 0; i < scene->camera_count; i++) {
		const struct scene_camera *camera = &scene->cameras[i];
		const size_t bytes = bytes_of((uint64_t)camera->width, (uint64_t)camera->height, (camera->images & (SCENE_IMAGES_MEASURED | 1u << SCENE_IMAGE_LINEAR)) != 0);
		most = bytes > most ? bytes : most;
	}
	return most;
}

void render_pictures_plan(size_t bytes, enum scene_effect by, struct plan *plan)
{
	const char *effect = scene_effect_row(by)->name;
	plan_add(plan, &(struct plan_line){.kind = PLAN_THREAD, .effect = effect, .object = -1, .amount = 1}, PICTURES_THREAD);
	plan_add(plan, &(struct plan_line){.kind = PLAN_BUFFER, .effect = effect, .object = -1, .amount = PICTURES_ROOM,
					   .bytes = PICTURES_ROOM * bytes}, "pictures: colour");
}

static enum status start(struct pictures *pictures)
{
	for (int i = 0; i < PICTURES_ROOM; i++)
		TRY(gpu_staging_create(pictures->gpu, pictures->bytes, &pictures->places[i]));
	return thread_start(&pictures->thread, write_body, pictures, PICTURES_THREAD);
}

enum status render_pictures_create(struct gpu *gpu, const char *directory, size_t bytes, struct pictures **out)
{
	struct pictures *pictures = mem_calloc(1, sizeof *pictures);
	TRY_MEM(pictures, "the pictures");
	pictures->gpu = gpu;
	pictures->directory = directory;
	pictures->bytes = bytes;
	mutex_init(&pictures->mutex);
	condition_init(&pictures->changed);
	enum status status = start(pictures);
	if (status != STATUS_OK) {
		render_pictures_destroy(pictures);
		return status;
	}
	*out = pictures;
	return STATUS_OK;
}

void render_pictures_stop(struct pictures *pictures)
{
	if (pictures == NULL || !pictures->thread.started)
		return;
	wait_for_gpu(pictures, pictures->begun);
	mutex_lock(&pictures->mutex);
	pictures->stopping = true;
	condition_wake_all(&pictures->changed);
	mutex_unlock(&pictures->mutex);
	thread_join(&pictures->thread);
	assert(pictures->written == pictures->begun);
}

void render_pictures_destroy(struct pictures *pictures)
{
	if (pictures == NULL)
		return;
	render_pictures_stop(pictures);
	for (int i = 0; i < PICTURES_ROOM; i++)
		gpu_staging_destroy(pictures->places[i]);
	condition_finish(&pictures->changed);
	mutex_finish(&pictures->mutex);
	mem_free(pictures);
}
