/* Loads GDAL when it is first needed, and keeps its messages off stderr. */
#define DEM_GDAL_LOADS
#include "dem_gdal.h"
#include "dem_proj.h"

#include <dlfcn.h>
#include <stdatomic.h>

struct dem_gdal_calls dem_gdal_calls;
struct dem_proj_calls dem_proj_calls;

static atomic_bool loaded;       /* all of dem_gdal_calls is there */
static atomic_bool quiet;        /* dem_quiet_process was called */
static char missing[320];        /* why GDAL could not be loaded; "" if it was; constant after `once` */
static _Thread_local int begun;  /* calls of dem_quiet_begin that have not ended, in this thread */
static _Thread_local int pushed; /* of these, those that GDAL knows of */

/* The library's own libraries are searched, too. */
static void find_proj(void *library)
{
	bool whole = true;
#define DEM_PROJ_FIND(name) \
	*(void **)&dem_proj_calls.name = dlsym(library, #name); \
	whole = whole && dem_proj_calls.name != NULL;
	DEM_PROJ_EACH(DEM_PROJ_FIND)
	if (!whole)
		dem_proj_calls = (struct dem_proj_calls){0};
}

static void load_once(void)
{
	void *library = dlopen(DEM_GDAL_LIBRARY, RTLD_LAZY | RTLD_LOCAL);
	bool whole = library != NULL;
	/* ISO C has no conversion from what dlsym returns to a pointer to a function; POSIX has. */
#define DEM_GDAL_FIND(name) \
	*(void **)&dem_gdal_calls.name = whole ? dlsym(library, #name) : NULL; \
	whole = whole && dem_gdal_calls.name != NULL;
	DEM_GDAL_EACH(DEM_GDAL_FIND)
	if (!whole) {
		const char *why = dlerror();
		snprintf(missing, sizeof missing, "cannot be loaded%s%s", why != NULL ? ": " : "", why != NULL ? why : "");
		return;
	}
	if (quiet)
		dem_gdal_calls.CPLSetErrorHandler(dem_gdal_calls.CPLQuietErrorHandler);
	find_proj(library);
	dem_gdal_register();
	if (quiet)
		dem_network_close_process();
	loaded = true;
}

/* What this thread asked for before GDAL was there. */
static void push_handlers(void)
{
	for (; pushed < begun; pushed++) {
		dem_gdal_calls.CPLPushErrorHandler(dem_gdal_calls.CPLQuietErrorHandler);
		dem_network_close_thread();
	}
}

enum status dem_gdal_init(const char *what)
{
	static pthread_once_t once = PTHREAD_ONCE_INIT;
	pthread_once(&once, load_once);
	if (missing[0] != '\0')
		return fail_with(STATUS_FAILED, "%.200s: needs GDAL, which %s; install it again, or give PNG "
				 "or raw heightmaps", what, missing);
	push_handlers();
	dem_gdal_calls.CPLErrorReset();
	return STATUS_OK;
}

/* What GDAL has to say goes into our messages, never to stderr by itself. */
void dem_quiet_process(void)
{
	quiet = true;
	if (loaded) {
		dem_gdal_calls.CPLSetErrorHandler(dem_gdal_calls.CPLQuietErrorHandler);
		dem_network_close_process();
	}
}

void dem_quiet_begin(void)
{
	begun++;
	if (loaded)
		push_handlers();
}

void dem_quiet_end(void)
{
	begun--;
	for (; pushed > begun; pushed--) {
		dem_network_reopen_thread();
		dem_gdal_calls.CPLPopErrorHandler();
	}
}
