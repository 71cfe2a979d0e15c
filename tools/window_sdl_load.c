/* Loads SDL when a window is first opened. */
#include "window_sdl_calls.h"

#include <dlfcn.h>

#define WINDOW_SDL_LIBRARY "libSDL2-2.0.so.0" /* of every SDL 2 */

struct sdl_calls sdl;

enum status sdl_load(void)
{
	static void *library; /* never closed: it may have threads and handlers of its own */
	if (library == NULL)
		library = dlopen(WINDOW_SDL_LIBRARY, RTLD_LAZY | RTLD_LOCAL);
	bool whole = library != NULL;
	/* ISO C has no conversion from what dlsym returns to a pointer to a function; POSIX has. */
#define WINDOW_SDL_FIND(name) \
	*(void **)&sdl.name = whole ? dlsym(library, "SDL_" #name) : NULL; \
	whole = whole && sdl.name != NULL;
	WINDOW_SDL_EACH(WINDOW_SDL_FIND)
#undef WINDOW_SDL_FIND
	if (whole)
		return STATUS_OK;
	const char *why = dlerror();
	sdl = (struct sdl_calls){0};
	return fail_with(STATUS_FAILED, "window: SDL cannot be loaded%s%s; install it (Debian: libsdl2-2.0-0), or furrow drive the scene and look at "
					"its pictures", why != NULL ? ": " : "", why != NULL ? why : "");
}
