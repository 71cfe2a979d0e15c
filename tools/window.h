/*
 * A window on the screen: what is pressed in it, and a picture to fill it. window_sdl.c makes it of SDL2; window_none.c says
 * that this build has none. For the main thread.
 */
#ifndef FURROW_TOOLS_WINDOW_H
#define FURROW_TOOLS_WINDOW_H

#include <stdint.h>

#include "base/base.h"

struct window;

/* Keys are the characters they type without Shift, letters small; and these. */
enum {
	WINDOW_UP = 256,
	WINDOW_DOWN,
	WINDOW_LEFT,
	WINDOW_RIGHT,
	WINDOW_ESCAPE,
	WINDOW_SHIFT,
	WINDOW_PLUS, /* of either place */
	WINDOW_MINUS,
};

enum window_event_kind {
	WINDOW_KEY,    /* `key` went down; once, however long it is held */
	WINDOW_DRAG,   /* the mouse moved by dx, dy pixels (right, down) with its left button held */
	WINDOW_CLICK,  /* its right button, at x, y */
	WINDOW_PICK,   /* its left button came up at x, y where it went down */
	WINDOW_EXPOSED, /* part of it was covered and lost its picture: show the picture again */
	WINDOW_CLOSE,
};
struct window_event {
	enum window_event_kind kind;
	int key, x, y, dx, dy;
};

/* STATUS_FAILED: there is no display, or this build has no window. */
enum status window_open(const char *title, int width, int height, struct window **out) FURROW_CHECKED;
void window_close(struct window *window); /* takes NULL */
/* The next event; false: none waits. */
bool window_next(struct window *window, struct window_event *event);
bool window_held(const struct window *window, int key);
/* Where the mouse is over the window, pixels from its top left; false: it is elsewhere. */
bool window_mouse(const struct window *window, int *x, int *y);
void window_size(struct window *window, int *width, int *height);
void window_title(struct window *window, const char *title);
/* Shows a picture: RGBA, 4 x width x height bytes, row 0 the lowest, as GL reads pictures back. It is stretched if the
 * window has another size by now. */
enum status window_show(struct window *window, const uint8_t *pixels, int width, int height) FURROW_CHECKED;

#endif
