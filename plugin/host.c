/*
 * Finds the host's MuJoCo. The plugin is linked with none: a host has its own loaded already, under any name, and only that knows the host's plugins.
 * Beside it may be the one that libfurrow has loaded for vehicles. It is the host's only where both are the same.
 */
#define _GNU_SOURCE
#define PLUGIN_FINDS
#include <dlfcn.h>
#include <link.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "host.h"
#include "plugin.h"

struct plugin_host plugin_host;

struct finding {
	bool own, found;           /* take the one that libfurrow has loaded, too; one was taken */
	int other;                 /* version of a library that does not fit; 0: none */
	void (*warn)(const char *format, ...); /* of that library */
};

/* Returns a function that the library itself has, and none of those that it needs. */
static void *own_function(void *library, const char *file, const char *name)
{
	Dl_info info;
	void *function = dlsym(library, name);
	return function != NULL && (file[0] == '\0' || (dladdr(function, &info) != 0 && info.dli_fname != NULL && strcmp(info.dli_fname, file) == 0)) ? function : NULL;
}

static int look_at(struct dl_phdr_info *info, size_t size, void *argument)
{
	struct finding *finding = argument;
	const char *file = info->dlpi_name;
	(void)size;
	void *library = dlopen(file[0] != '\0' ? file : NULL, RTLD_LAZY | RTLD_NOLOAD);
	if (library == NULL)
		return 0;
	int (*version)(void) = NULL;
	*(void **)&version = own_function(library, file, "mj_version");
	if (version != NULL && own_function(library, file, "mjp_registerPlugin") != NULL) {
		void *const place = *(void **)&version;
		if (version() == mjVERSION_HEADER && !finding->found && (finding->own || place != furrow_mujoco_own())) {
			bool whole = true;
#define PLUGIN_FIND(name) \
	*(void **)&plugin_host.name = dlsym(library, #name); \
	whole = whole && plugin_host.name != NULL;
			PLUGIN_EACH(PLUGIN_FIND)
#undef PLUGIN_FIND
			finding->found = whole;
		} else if (version() != mjVERSION_HEADER) {
			finding->other = version();
			*(void **)&finding->warn = dlsym(library, "mju_warning");
		}
	}
	dlclose(library);
	return 0;
}

bool plugin_find_host(void)
{
	struct finding finding = {.found = false};
	dl_iterate_phdr(look_at, &finding);
	finding.own = true;
	if (!finding.found)
		dl_iterate_phdr(look_at, &finding);
	if (!finding.found && finding.warn != NULL)
		finding.warn("furrow.soil: this program has MuJoCo %d.%d.%d, and the plugin was built for %s, whose structs are other ones; give it that version, or use furrow.mujoco of Python",
			     finding.other / 1000000, finding.other / 1000 % 1000, finding.other % 1000, PLUGIN_VERSION);
	return finding.found;
}
