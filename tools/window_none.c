/* No window: this build was made without SDL2. */
#include "window.h"

enum status window_open(const char *title, int width, int height, struct window **out)
{
	return fail_with(STATUS_FAILED, "view: this build has no window; build it where SDL2 is (libsdl2-dev), or furrow drive the "
					"scene and look at its pictures");
}

void window_close(struct window *window)
{
}

bool window_next(struct window *window, struct window_event *event)
{
	return false;
}

bool window_held(const struct window *window, int key)
{
	return false;
}

bool window_mouse(const struct window *window, int *x, int *y)
{
	return false;
}

void window_size(struct window *window, int *width, int *height)
{
}

void window_title(struct window *window, const char *title)
{
}

enum status window_show(struct window *window, const uint8_t *pixels, int width, int height)
{
	return STATUS_OK;
}
