/* Loads MuJoCo when a scene first has vehicles. */
#define VEHICLE_MUJOCO_LOADS
#include "vehicle/vehicle.h"
#include "vehicle_mujoco.h"

#include <dlfcn.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>

/* The library's own calls must stay in it, too, where the process has another MuJoCo. Sanitizers refuse to open a library so. */
#ifdef __SANITIZE_ADDRESS__
#define OWN_NAMES 0
#else
#define OWN_NAMES RTLD_DEEPBIND
#endif

struct vehicle_mujoco vehicle_mujoco;

static char refused[640]; /* why it could not be loaded; "" if it was; constant after `once` */

static void *open_library(void)
{
	const char *given = getenv("FURROW_MUJOCO");
	if (given != NULL && given[0] != '\0') /* what the user names, or nothing */
		return dlopen(given, RTLD_NOW | RTLD_LOCAL | OWN_NAMES);
	static const char *const places[] = {VEHICLE_MUJOCO_INSTALLED, VEHICLE_MUJOCO_BUILT, VEHICLE_MUJOCO_NAME};
	void *library = NULL;
	for (size_t i = 0; i < sizeof places / sizeof places[0] && library == NULL; i++)
		library = dlopen(places[i], RTLD_NOW | RTLD_LOCAL | OWN_NAMES);
	return library;
}

static void load_once(void)
{
	void *library = open_library();
	if (library == NULL) {
		const char *why = dlerror();
		snprintf(refused, sizeof refused, "MuJoCo " VEHICLE_MUJOCO_VERSION " cannot be loaded%s%.400s; install it (tools/packages.sh brings it), or name its library in FURROW_MUJOCO",
			 why != NULL ? ": " : "", why != NULL ? why : "");
		return;
	}
	const char *missing = NULL;
	/* ISO C has no conversion from what dlsym returns to a pointer to a function; POSIX has. */
#define VEHICLE_MUJOCO_FIND(name) \
	*(void **)&vehicle_mujoco.name = dlsym(library, #name); \
	missing = vehicle_mujoco.name == NULL ? #name : missing;
	VEHICLE_MUJOCO_EACH(VEHICLE_MUJOCO_FIND)
#undef VEHICLE_MUJOCO_FIND
	/* Its structs are laid out as those of the headers in the same version alone. */
	if (vehicle_mujoco.mj_version == NULL || vehicle_mujoco.mj_version() != mjVERSION_HEADER)
		snprintf(refused, sizeof refused, "the library is MuJoCo %s, and furrow was built for " VEHICLE_MUJOCO_VERSION "; give it that version",
			 vehicle_mujoco.mj_versionString != NULL ? vehicle_mujoco.mj_versionString() : "of no known version");
	else if (missing != NULL)
		snprintf(refused, sizeof refused, "MuJoCo " VEHICLE_MUJOCO_VERSION " lacks the function %s; install it again", missing);
}

const char *vehicle_engine(void)
{
	return "MuJoCo " VEHICLE_MUJOCO_VERSION;
}

int vehicle_engine_number(void)
{
	return mjVERSION_HEADER;
}

const void *vehicle_engine_place(void)
{
	return *(void *const *)&vehicle_mujoco.mj_version;
}

enum status vehicle_mujoco_load(void)
{
	static pthread_once_t once = PTHREAD_ONCE_INIT;
	pthread_once(&once, load_once);
	return refused[0] == '\0' ? STATUS_OK : fail_with(STATUS_FAILED, "vehicles: %s", refused);
}
