/*
 * The functions of SDL that the window calls. They are found when the first window is opened. SDL needs 34 libraries for sounds and screens, and
 * loading those would make every other command start in 1.7 times the time.
 */
#ifndef FURROW_TOOLS_WINDOW_SDL_CALLS_H
#define FURROW_TOOLS_WINDOW_SDL_CALLS_H

#include <SDL.h>

#include "base/base.h"

/* SDL_UpperBlit and SDL_UpperBlitScaled are what SDL calls SDL_BlitSurface and SDL_BlitScaled for those who link it. */
#define WINDOW_SDL_EACH(CALL) \
	CALL(ClearError) CALL(CreateRGBSurfaceWithFormat) CALL(CreateWindow) CALL(DestroyWindow) CALL(FreeSurface) CALL(GetCurrentVideoDriver) \
	CALL(GetError) CALL(GetKeyboardState) CALL(GetModState) CALL(GetMouseFocus) CALL(GetMouseState) CALL(GetScancodeFromKey) CALL(GetWindowSize) \
	CALL(GetWindowSurface) CALL(InitSubSystem) CALL(PollEvent) CALL(Quit) CALL(QuitSubSystem) CALL(SetHint) CALL(SetHintWithPriority) \
	CALL(SetMainReady) CALL(SetSurfaceBlendMode) CALL(SetWindowMinimumSize) CALL(SetWindowTitle) CALL(UpdateWindowSurface) CALL(UpperBlit) \
	CALL(UpperBlitScaled)

#define WINDOW_SDL_MEMBER(name) __typeof__(&SDL_##name) name;
/* SDL_GetError is sdl.GetError. All are NULL before sdl_load, and after it has failed. */
extern struct sdl_calls {
	WINDOW_SDL_EACH(WINDOW_SDL_MEMBER)
} sdl;
#undef WINDOW_SDL_MEMBER

/* For the main thread; may be called again. STATUS_FAILED: SDL is not there, or lacks one of these functions. */
enum status sdl_load(void) FURROW_CHECKED;

#endif
