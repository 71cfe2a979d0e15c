/*
 * Pictures that are kept, on their way from the GPU to their files while steps go on: frame-NNNNNN.png of a folder, each
 * written aside and renamed. For the GPU's thread; one thread of its own writes.
 *
 * A failure to read back or to write is kept, with its whole message, and returned by every call from then on. What was
 * begun before is tried all the same: when it is over, each picture is whole or not there.
 */
#ifndef FURROW_RUN_PICTURES_H
#define FURROW_RUN_PICTURES_H

#include <stdint.h>

#include "base/base.h"
#include "base/plan.h"
#include "gpu/gpu.h"
#include "render/render.h"

struct pictures;

/* What is kept at once, from the picture that is read back to the one that is written. */
#define PICTURES_ROOM 3
#define PICTURES_THREAD "furrow-images"

/* The lines of pictures of so many pixels. Pure. */
void pictures_plan(uint32_t width, uint32_t height, struct plan *plan);

/* Of so many pixels. The folder's name stays the caller's and must outlive it. */
enum status pictures_create(struct gpu *gpu, const char *directory, uint32_t width, uint32_t height,
			    struct pictures **out) FURROW_CHECKED;
/* Ends what was begun and stops the thread; then only pictures_figures and pictures_destroy. */
void pictures_stop(struct pictures *pictures);
void pictures_destroy(struct pictures *pictures); /* takes NULL; stops first */

/* All of these but pictures_figures take NULL, of which nothing is asked. */
/* Begins with the last frame, the picture after so many steps. Waits if PICTURES_ROOM are under way, for the first. */
enum status pictures_begin(struct pictures *pictures, struct render *render, int64_t step) FURROW_CHECKED;
/* Hands on what the GPU is done with. Never waits; call it once a step. */
enum status pictures_poll(struct pictures *pictures) FURROW_CHECKED;
/* Marks all that were begun, when the GPU is done with them, which is waited for. */
void pictures_mark(struct pictures *pictures);
/* Any thread: waits until what was marked last is in its files. */
enum status pictures_await(struct pictures *pictures) FURROW_CHECKED;

struct pictures_figures {
	uint64_t written, waits; /* files; times that a call waited */
	double wait_ms;
};
void pictures_figures(struct pictures *pictures, struct pictures_figures *figures);

#endif
