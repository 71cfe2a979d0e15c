/*
 * A window of SDL2. The CPU fills it: SDL makes no renderer and no GL context. The one GL context is the drive's, on the
 * same thread, and SDL must not make another one current.
 */
#include <stdlib.h>
#include <string.h>

#include "window.h"
#include "window_sdl_calls.h"

#define LEAST_WIDTH 64
#define LEAST_HEIGHT 36
#define STILL 3 /* pixels: a hand that moves the mouse so little does not drag */

struct window {
	SDL_Window *sdl;
	int down[2];          /* where the left button went down; below 0: it has moved since */
	SDL_Surface *upright; /* the picture with its highest row first, as SDL shows it; NULL before the first picture */
};

static enum status sdl_failed(const char *what)
{
	return fail_with(STATUS_FAILED, "window: %s: %s; give a display (DISPLAY or WAYLAND_DISPLAY), or furrow drive the scene and look "
					"at its pictures", what, sdl.GetError());
}

/* Drivers that SDL takes where there is no display: nobody would see the window. One that was asked for by name is right. */
static bool is_unseen(const char *driver)
{
	return driver != NULL && getenv("SDL_VIDEODRIVER") == NULL &&
	       (strcmp(driver, "offscreen") == 0 || strcmp(driver, "dummy") == 0);
}

static enum status open_sdl(const char *title, int width, int height, struct window *window)
{
	if (sdl.InitSubSystem(SDL_INIT_VIDEO) != 0)
		return sdl_failed("no display");
	if (is_unseen(sdl.GetCurrentVideoDriver()))
		return fail_with(STATUS_FAILED, "window: no display: none is named or there; give a display (DISPLAY or WAYLAND_DISPLAY), or "
						"furrow drive the scene and look at its pictures");
	window->sdl = sdl.CreateWindow(title, SDL_WINDOWPOS_UNDEFINED, SDL_WINDOWPOS_UNDEFINED, width, height, SDL_WINDOW_RESIZABLE);
	if (window->sdl == NULL)
		return sdl_failed("cannot be opened");
	if (sdl.GetWindowSurface(window->sdl) == NULL)
		return fail_with(STATUS_FAILED, "window: SDL's video driver %s cannot show what the CPU draws: %s; try SDL_VIDEODRIVER=x11",
				 sdl.GetCurrentVideoDriver(), sdl.GetError());
	sdl.SetWindowMinimumSize(window->sdl, LEAST_WIDTH, LEAST_HEIGHT);
	return STATUS_OK;
}

enum status window_open(const char *title, int width, int height, struct window **out)
{
	TRY(sdl_load());
	struct window *window = mem_calloc(1, sizeof *window);
	TRY_MEM(window, "a window");
	sdl.SetMainReady();
	sdl.SetHint(SDL_HINT_NO_SIGNAL_HANDLERS, "1"); /* Ctrl-C is the command's own */
	/* The environment may ask for a renderer, even one that does not exist. The window needs none. */
	sdl.SetHintWithPriority(SDL_HINT_FRAMEBUFFER_ACCELERATION, "0", SDL_HINT_OVERRIDE);
	sdl.SetHint(SDL_HINT_VIDEO_ALLOW_SCREENSAVER, "1");
	enum status status;
	TRY_OR(failed, open_sdl(title, width, height, window));
	*out = window;
	return STATUS_OK;
failed:
	window_close(window);
	return status;
}

void window_close(struct window *window)
{
	if (window == NULL)
		return;
	sdl.FreeSurface(window->upright);
	if (window->sdl != NULL)
		sdl.DestroyWindow(window->sdl);
	sdl.QuitSubSystem(SDL_INIT_VIDEO);
	sdl.Quit();
	mem_free(window);
}

static int key_of(SDL_Keycode code)
{
	switch (code) {
	case SDLK_UP:
		return WINDOW_UP;
	case SDLK_DOWN:
		return WINDOW_DOWN;
	case SDLK_LEFT:
		return WINDOW_LEFT;
	case SDLK_RIGHT:
		return WINDOW_RIGHT;
	case SDLK_ESCAPE:
		return WINDOW_ESCAPE;
	case SDLK_PLUS:
	case SDLK_EQUALS: /* the same key without Shift */
	case SDLK_KP_PLUS:
		return WINDOW_PLUS;
	case SDLK_MINUS:
	case SDLK_KP_MINUS:
		return WINDOW_MINUS;
	default:
		return code > 0 && code < 128 ? (int)code : 0;
	}
}

static SDL_Keycode code_of(int key)
{
	switch (key) {
	case WINDOW_UP:
		return SDLK_UP;
	case WINDOW_DOWN:
		return SDLK_DOWN;
	case WINDOW_LEFT:
		return SDLK_LEFT;
	case WINDOW_RIGHT:
		return SDLK_RIGHT;
	default:
		return (SDL_Keycode)key;
	}
}

bool window_next(struct window *window, struct window_event *event)
{
	SDL_Event from;
	while (sdl.PollEvent(&from)) {
		*event = (struct window_event){.key = 0};
		if (from.type == SDL_QUIT) {
			event->kind = WINDOW_CLOSE;
			return true;
		}
		if (from.type == SDL_KEYDOWN && from.key.repeat == 0 && (event->key = key_of(from.key.keysym.sym)) != 0) {
			event->kind = WINDOW_KEY;
			return true;
		}
		if (from.type == SDL_MOUSEBUTTONDOWN && from.button.button == SDL_BUTTON_LEFT) {
			window->down[0] = from.button.x;
			window->down[1] = from.button.y;
		}
		if (from.type == SDL_MOUSEBUTTONUP && from.button.button == SDL_BUTTON_LEFT && window->down[0] >= 0) {
			event->kind = WINDOW_PICK;
			event->x = from.button.x;
			event->y = from.button.y;
			window->down[0] = -1;
			return true;
		}
		if (from.type == SDL_MOUSEMOTION && (from.motion.state & SDL_BUTTON_LMASK) != 0) {
			if (abs(from.motion.x - window->down[0]) > STILL || abs(from.motion.y - window->down[1]) > STILL)
				window->down[0] = -1;
			event->kind = WINDOW_DRAG;
			event->dx = from.motion.xrel;
			event->dy = from.motion.yrel;
			return true;
		}
		if (from.type == SDL_MOUSEBUTTONDOWN && from.button.button == SDL_BUTTON_RIGHT) {
			event->kind = WINDOW_CLICK;
			event->x = from.button.x;
			event->y = from.button.y;
			return true;
		}
		if (from.type == SDL_WINDOWEVENT && from.window.event == SDL_WINDOWEVENT_EXPOSED) {
			event->kind = WINDOW_EXPOSED;
			return true;
		}
	}
	return false;
}

bool window_held(const struct window *window, int key)
{
	int count;
	const Uint8 *down = sdl.GetKeyboardState(&count);
	if (key == WINDOW_SHIFT)
		return (sdl.GetModState() & KMOD_SHIFT) != 0;
	SDL_Scancode code = sdl.GetScancodeFromKey(code_of(key));
	return (int)code < count && down[code] != 0;
}

bool window_mouse(const struct window *window, int *x, int *y)
{
	sdl.GetMouseState(x, y);
	return sdl.GetMouseFocus() == window->sdl;
}

void window_size(struct window *window, int *width, int *height)
{
	sdl.GetWindowSize(window->sdl, width, height);
}

void window_title(struct window *window, const char *title)
{
	sdl.SetWindowTitle(window->sdl, title);
}

/* Copies the picture into window->upright, highest row first. */
static bool turn_upright(struct window *window, const uint8_t *pixels, int width, int height)
{
	SDL_Surface *to = window->upright;
	if (to == NULL || to->w != width || to->h != height) {
		sdl.FreeSurface(to);
		window->upright = to = sdl.CreateRGBSurfaceWithFormat(0, width, height, 32, SDL_PIXELFORMAT_RGBA32);
		if (to == NULL)
			return false;
		sdl.SetSurfaceBlendMode(to, SDL_BLENDMODE_NONE);
	}
	size_t row = (size_t)4 * (size_t)width;
	for (int y = 0; y < height; y++)
		memcpy((uint8_t *)to->pixels + (size_t)y * (size_t)to->pitch, pixels + (size_t)(height - 1 - y) * row, row);
	return true;
}

enum status window_show(struct window *window, const uint8_t *pixels, int width, int height)
{
	SDL_Surface *to = sdl.GetWindowSurface(window->sdl);
	if (to == NULL) {
		sdl.ClearError();
		return STATUS_OK; /* between two sizes, or minimised: the next picture may be seen */
	}
	if (!turn_upright(window, pixels, width, height))
		return sdl_failed("a picture cannot be shown");
	bool same = to->w == width && to->h == height;
	int failed = same ? sdl.UpperBlit(window->upright, NULL, to, NULL) : sdl.UpperBlitScaled(window->upright, NULL, to, NULL);
	if (failed != 0 || sdl.UpdateWindowSurface(window->sdl) != 0)
		return sdl_failed("a picture cannot be shown");
	return STATUS_OK;
}
