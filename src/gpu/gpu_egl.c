/*
 * A windowless OpenGL 4.5 core context: Mesa's surfaceless platform first, then each EGL device. A
 * hardware renderer is preferred to a software one, which is kept as the last resort.
 *
 * Displays belong to the process, not to us, and stay initialised: to terminate one would end it for
 * the program we are a library in. setenv is called here, so no other thread may be reading the
 * environment meanwhile.
 */
#include <dlfcn.h>
#include <stdlib.h>
#include <string.h>

#include "gpu/internal.h"

#define DEVICES_MAX 16
#define ADVICE "install a driver with OpenGL 4.5 (Mesa's llvmpipe will do), or use a command that needs no GL"

/* Loads EGL and OpenGL before their first call. They stay loaded. Returns NULL, or why they cannot be loaded. libepoxy would end the
 * process: a library may be missing, or the limit on open files may be reached. */
static const char *load_libraries(void)
{
	if (dlopen("libEGL.so.1", RTLD_LAZY | RTLD_LOCAL) == NULL)
		return dlerror();
	if (dlopen("libOpenGL.so.0", RTLD_LAZY | RTLD_LOCAL) != NULL || dlopen("libGL.so.1", RTLD_LAZY | RTLD_LOCAL) != NULL)
		return NULL;
	return dlerror();
}

static bool has_word(const char *list, const char *word)
{
	size_t length = strlen(word);
	for (const char *at = list; at != NULL && (at = strstr(at, word)) != NULL; at += length)
		if ((at == list || at[-1] == ' ') && (at[length] == ' ' || at[length] == '\0'))
			return true;
	return false;
}

static bool renderer_is_software(void)
{
	static const char *const names[] = {"llvmpipe", "softpipe", "swrast", "SWR", "SwiftShader"};
	const char *renderer = (const char *)glGetString(GL_RENDERER);
	for (size_t i = 0; renderer != NULL && i < sizeof names / sizeof names[0]; i++)
		if (strstr(renderer, names[i]) != NULL)
			return true;
	return false;
}

void gpu_egl_close(struct gpu_egl *egl)
{
	if (egl->display == EGL_NO_DISPLAY)
		return;
	eglMakeCurrent(egl->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
	if (egl->context != EGL_NO_CONTEXT)
		eglDestroyContext(egl->display, egl->context);
	*egl = (struct gpu_egl){0};
}

/* Makes a 4.5 core context that reports a lost GPU; if that fails, a 4.5 core context without it. */
static EGLContext create_context(EGLDisplay display)
{
	EGLConfig config = EGL_NO_CONFIG_KHR;
	const char *extensions = eglQueryString(display, EGL_EXTENSIONS);
	if (!has_word(extensions, "EGL_KHR_no_config_context")) {
		EGLint count = 0;
		const EGLint wanted[] = {EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE};
		if (!eglChooseConfig(display, wanted, &config, 1, &count) || count < 1)
			return EGL_NO_CONTEXT;
	}
	const EGLint robust[] = {
		EGL_CONTEXT_MAJOR_VERSION, 4, EGL_CONTEXT_MINOR_VERSION, 5,
		EGL_CONTEXT_OPENGL_PROFILE_MASK, EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
		EGL_CONTEXT_OPENGL_RESET_NOTIFICATION_STRATEGY, EGL_LOSE_CONTEXT_ON_RESET, EGL_NONE};
	const EGLint plain[] = {
		EGL_CONTEXT_MAJOR_VERSION, 4, EGL_CONTEXT_MINOR_VERSION, 5,
		EGL_CONTEXT_OPENGL_PROFILE_MASK, EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE};
	EGLContext context = eglCreateContext(display, config, EGL_NO_CONTEXT, robust);
	return context != EGL_NO_CONTEXT ? context : eglCreateContext(display, config, EGL_NO_CONTEXT, plain);
}

/* Takes over `display` (which may be none). On failure nothing is left open and `why` says why. */
static bool try_display(EGLDisplay display, struct gpu_egl *egl, const char **why)
{
	*egl = (struct gpu_egl){0};
	if (display == EGL_NO_DISPLAY || !eglInitialize(display, NULL, NULL)) {
		*why = "no EGL display can be opened";
		return false;
	}
	egl->display = display;
	if (!eglBindAPI(EGL_OPENGL_API)) {
		*why = "EGL has no desktop OpenGL";
	} else if (!has_word(eglQueryString(display, EGL_EXTENSIONS), "EGL_KHR_surfaceless_context")) {
		*why = "EGL has no surfaceless contexts";
	} else if ((egl->context = create_context(display)) == EGL_NO_CONTEXT) {
		*why = "the driver has no OpenGL 4.5 core context";
	} else if (!eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, egl->context)) {
		*why = "the OpenGL context cannot be made current";
	} else if (epoxy_gl_version() < 45) {
		*why = "the driver gives less than OpenGL 4.5";
	} else {
		egl->software = renderer_is_software();
		return true;
	}
	gpu_egl_close(egl);
	return false;
}

static EGLDisplay platform_display(EGLenum platform, void *native)
{
	PFNEGLGETPLATFORMDISPLAYEXTPROC get =
		(PFNEGLGETPLATFORMDISPLAYEXTPROC)(void (*)(void))eglGetProcAddress("eglGetPlatformDisplayEXT");
	return get != NULL ? get(platform, native, NULL) : EGL_NO_DISPLAY;
}

/* Opens the first device that gives a context. `only_hardware`: skips software devices, since there is a software context
 * already. */
static bool try_devices(struct gpu_egl *egl, bool only_hardware, const char **why)
{
	PFNEGLQUERYDEVICESEXTPROC query =
		(PFNEGLQUERYDEVICESEXTPROC)(void (*)(void))eglGetProcAddress("eglQueryDevicesEXT");
	PFNEGLQUERYDEVICESTRINGEXTPROC query_string =
		(PFNEGLQUERYDEVICESTRINGEXTPROC)(void (*)(void))eglGetProcAddress("eglQueryDeviceStringEXT");
	EGLDeviceEXT devices[DEVICES_MAX];
	EGLint count = 0;
	if (query == NULL || query_string == NULL || !query(DEVICES_MAX, devices, &count))
		return false;
	for (EGLint i = 0; i < count; i++) {
		bool software = has_word(query_string(devices[i], EGL_EXTENSIONS), "EGL_MESA_device_software");
		if (only_hardware && software)
			continue;
		if (!try_display(platform_display(EGL_PLATFORM_DEVICE_EXT, devices[i]), egl, why))
			continue;
		if (!only_hardware || !egl->software)
			return true;
		gpu_egl_close(egl);
	}
	return false;
}

static bool software_asked_for(void)
{
	const char *value = getenv("LIBGL_ALWAYS_SOFTWARE");
	return value != NULL && (strcmp(value, "1") == 0 || strcmp(value, "true") == 0);
}

static enum status open_any(struct gpu_egl *egl)
{
	const char *why = "EGL has no windowless platform";
	const char *extensions = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
	bool platforms = has_word(extensions, "EGL_EXT_platform_base");
	bool surfaceless = platforms && has_word(extensions, "EGL_MESA_platform_surfaceless");
	bool devices = platforms && has_word(extensions, "EGL_EXT_platform_device");
	EGLDisplay display = EGL_NO_DISPLAY;

	*egl = (struct gpu_egl){0};
	if (surfaceless) {
		display = platform_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY);
		if (try_display(display, egl, &why)) {
			struct gpu_egl hardware;
			if (!egl->software || !devices || software_asked_for())
				return STATUS_OK;
			if (try_devices(&hardware, true, &why)) {
				eglDestroyContext(egl->display, egl->context);
				*egl = hardware;
				return STATUS_OK;
			}
			if (eglMakeCurrent(egl->display, EGL_NO_SURFACE, EGL_NO_SURFACE, egl->context))
				return STATUS_OK;
			why = "the OpenGL context cannot be made current";
			gpu_egl_close(egl);
		}
	}
	if (devices && try_devices(egl, false, &why))
		return STATUS_OK;
	return fail_with(STATUS_NO_GL, "GL: %s; " ADVICE, why);
}

enum status gpu_egl_open(bool draws, struct gpu_egl *egl)
{
	/* Without raster threads llvmpipe runs the small passes of a simulation 3-7 times faster. It
	 * reads this once, when the process first opens its display. */
	const char *missing = load_libraries();
	if (missing != NULL)
		return fail_with(STATUS_NO_GL, "GL: %s; " ADVICE, missing);
	bool set = !draws && getenv("LP_NUM_THREADS") == NULL && setenv("LP_NUM_THREADS", "0", 0) == 0;
	enum status status = open_any(egl);
	if (set)
		unsetenv("LP_NUM_THREADS");
	return status;
}

void gpu_keep(const struct gpu *gpu, struct gpu_kept *kept)
{
	bool turn = gpu == NULL || gpu->egl.software;
	if (turn)
		gpu_turn_begin();
	*kept = (struct gpu_kept){.turn = turn};
	if (gpu == NULL && load_libraries() != NULL) /* gpu_create() will say so */
		return;
	*kept = (struct gpu_kept){.api = eglQueryAPI(), .context = eglGetCurrentContext(), .turn = turn};
	if (kept->context == EGL_NO_CONTEXT)
		return;
	kept->display = eglGetCurrentDisplay();
	kept->draw = eglGetCurrentSurface(EGL_DRAW);
	kept->read = eglGetCurrentSurface(EGL_READ);
}

void gpu_give(const struct gpu_kept *kept)
{
	EGLDisplay ours = EGL_NO_DISPLAY;
	if (kept->api != 0 || load_libraries() == NULL)
		ours = eglGetCurrentDisplay();
	if (kept->api != 0 && kept->api != EGL_NONE)
		eglBindAPI(kept->api);
	if (kept->context != EGL_NO_CONTEXT)
		eglMakeCurrent(kept->display, kept->draw, kept->read, kept->context);
	else if (ours != EGL_NO_DISPLAY)
		eglMakeCurrent(ours, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
	if (kept->turn)
		gpu_turn_end();
}

enum status gpu_take(struct gpu *gpu)
{
	gpu->owner = pthread_self();
	if (eglBindAPI(EGL_OPENGL_API) && eglMakeCurrent(gpu->egl.display, EGL_NO_SURFACE, EGL_NO_SURFACE, gpu->egl.context))
		return STATUS_OK;
	return fail_with(STATUS_NO_GL, "GL: this world's context cannot be made current on this thread; release the thread's own GL "
				       "context first (GLX and EGL do not mix), or call from another thread");
}
